"""Corotational beams: published large deflections, buckling, spin and conservation [theory.md 15]."""

from __future__ import annotations

import tomllib
import warnings
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import tautflex as tf
from tautflex.case import template
from tautflex.motion.kinematics import RigidMotion
from tautflex.reduction.polynomial.strains import stress_loads
from tautflex.solvers.plausibility import MotionWatch
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.stability import find_instability
from tautflex.structure.model import Support
from verification.builders import beam_line, line_elements, observed_order, unstressed

STEEL = tf.Material(2.0e11, 7800.0, 0.3)
LENGTH = 10.0
IN_PLANE = ("y", "rx", "rz")


def section(area=1e-2, inertia_y=1e-6, inertia_z=1e-6, torsion=2e-6, material=STEEL) -> tf.BeamSection:
    return tf.BeamSection(material, area, inertia_y, inertia_z, torsion, "corotational")


def cantilever(elements: int, own: tf.BeamSection, *supports: Support, axial_force: float = 0.0):
    held = (Support.clamped([0]), *supports)
    return tf.solve_prestress(beam_line(own, LENGTH, elements, held, axial_force=axial_force))


def plane(elements: int) -> Support:
    return Support(tuple(range(1, elements + 1)), IN_PLANE)


def loaded(state, *force: float) -> NDArray[np.float64]:
    """Unknowns of a cantilever under a force on its tip."""
    forces = np.zeros((len(state.model.nodes), 3))
    forces[-1] = force
    return tf.solve_static(state, forces=forces)


def softest(state, q) -> float:
    """Lowest eigenvalue of the tangent, unknowns scaled by its diagonal at rest."""
    system = state.system
    tangent, rest = (system.matrix(system.tangent(at)).toarray() for at in (q, np.zeros_like(q)))
    scale = 1.0 / np.sqrt(np.diag(rest))
    return float(np.linalg.eigvalsh(scale[:, None] * tangent * scale)[0])


def elastica(load: float) -> float:
    """Deflection over length of an inextensible cantilever, load PL²/EI, by elliptic integrals."""
    root = np.sqrt(load)

    def left(m):
        return ellipk(m) - ellipkinc(np.arcsin(1.0 / np.sqrt(2.0 * m)), m) - root

    m = brentq(left, 0.5 + 1e-12, 1.0 - 1e-12, xtol=1e-15)
    return float(1.0 - 2.0 / root * (ellipe(m) - ellipeinc(np.arcsin(1.0 / np.sqrt(2.0 * m)), m)))


@pytest.mark.parametrize(("load", "published"), [(1.0, 0.30172), (5.0, 0.71379), (10.0, 0.81061)])
def test_elastica(load, published, verification_row):
    assert elastica(load) == pytest.approx(published, abs=5e-6)
    own, found = section(area=1.0), []
    for elements in (5, 10, 20):
        state = cantilever(elements, own, plane(elements))
        force = load * STEEL.youngs_modulus * own.inertia_y / LENGTH**2
        found.append(state.system.translations(loaded(state, 0.0, 0.0, force))[-1, 2] / LENGTH)
    assert found[-1] == pytest.approx(elastica(load), rel=1e-6)
    order = observed_order(np.array(found) - elastica(load))
    assert np.all((order > 3.7) & (order < 4.3)), order
    verification_row(f"elastica, PL²/EI = {load:g}, 20 elements: w/L", published, found[-1], "theory.md 15")
    verification_row(f"elastica, PL²/EI = {load:g}: observed order", 4.0, order[-1], "elliptic integrals")


@pytest.mark.parametrize("turns", [0.5, 1.0])
def test_roll_up(turns, verification_row):
    """A moment bends a straight beam into a part of a circle; total rotations reach 2 pi."""
    elements, own = 20, section(area=0.1)
    state = cantilever(elements, own, plane(elements))
    load = np.zeros(state.system.size)
    load[-1] = 2.0 * np.pi * turns * STEEL.youngs_modulus * own.inertia_y / LENGTH
    q = state.system.full(tf.solve_static(state, load, steps=8))
    angle, radius = 2.0 * np.pi * turns, LENGTH / (2.0 * np.pi * turns)
    tip = [radius * np.sin(angle) - LENGTH, 0.0, radius * (1.0 - np.cos(angle)), 0.0, -angle, 0.0]
    error = float(np.abs(q[-6:] - tip).max())
    # The chord of an element's arc is taken to fourth order.
    assert error < LENGTH * (angle / elements) ** 4 / 1920.0
    verification_row(f"roll-up by {turns:g} of a circle, 20 elements: error of the tip [m, rad]", 0, error, "M = EI/R")


def test_bend_of_45_degrees(verification_row):
    """Bathe & Bolourchi 1979: circle of 100 m, unit square, E = 1e7, 600 across its plane, eight straight elements."""
    angle = np.linspace(0.0, np.pi / 4.0, 9)
    nodes = 100.0 * np.column_stack([np.sin(angle), 1.0 - np.cos(angle), np.zeros(9)])
    own = section(1.0, 1.0 / 12.0, 1.0 / 12.0, 1.0 / 6.0, tf.Material(1e7, 1.0))
    model = tf.Model.from_mesh(nodes, beams=line_elements(8), beam=own, supports=[Support.clamped([0])])
    state = tf.solve_prestress(model)
    found = state.system.translations(loaded(state, 0.0, 0.0, 600.0))[-1][[1, 0, 2]]
    published = np.array([-13.4, -23.5, 53.4])
    assert np.linalg.norm(found - published) < 5e-3 * np.linalg.norm(published)
    for name, expected, got in zip(("inwards", "back", "across"), published, found, strict=True):
        verification_row(f"45° bend, tip {name}, 8 elements", expected, got, "Bathe & Bolourchi 1979")


def critical(elements: int, own: tf.BeamSection, force, guess: float) -> float:
    """Load at which the lowest eigenvalue of the tangent vanishes, over ``guess``."""
    state = cantilever(elements, own)

    def lowest(share: float) -> float:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", tf.UnstableWarning)
            return softest(state, loaded(state, *(share * guess * np.asarray(force))))

    shares = 0.99, 1.01
    first, last = (lowest(share) for share in shares)
    # A straight line through two points on either side: the eigenvalue crosses zero with a slope.
    return float(shares[0] + (shares[1] - shares[0]) * first / (first - last))


def test_lateral_buckling(verification_row):
    """A deep strip under a force on its tip gives way sideways at 4.0126 sqrt(EI GJ)/L²."""
    own = section(1e-2, 1e-3, 1e-8, 4e-8)
    bending, torsion = STEEL.youngs_modulus * own.inertia_z, STEEL.shear_modulus * own.torsion_constant
    found = np.array([critical(n, own, (0.0, 0.0, 1.0), 4.0126 * np.sqrt(bending * torsion) / 100.0) for n in (8, 16)])
    assert found[-1] == pytest.approx(1.0, abs=4e-3)
    order = observed_order(found - 1.0)[-1]
    assert 1.9 < order < 2.1
    verification_row("lateral buckling, P L²/sqrt(EI GJ), 16 elements", 4.0126, 4.0126 * found[-1], "Timoshenko")
    verification_row("lateral buckling, observed order", 2.0, order, "Timoshenko")


def test_buckling_sideways(verification_row):
    """Euler's load about the softer axis, whichever way that bends."""
    for own, name in ((section(inertia_y=5e-7), "z"), (section(inertia_z=5e-7), "y")):
        euler = np.pi**2 * STEEL.youngs_modulus * 5e-7 / (4.0 * LENGTH**2)
        found = critical(8, own, (-1.0, 0.0, 0.0), euler)
        assert found == pytest.approx(1.0, abs=1e-4)
        verification_row(
            f"Euler's load of a cantilever that gives way along {name}, 8 elements", 1.0, found, "π²EI/4L²"
        )


def test_wagner(verification_row):
    """A push of GJ A/(2 I_p) takes half of the torsional stiffness."""
    own, elements = section(1e-2, 1e-5, 1e-5, 2e-8), 8
    push = -STEEL.shear_modulus * own.torsion_constant * own.area / (2.0 * (own.inertia_y + own.inertia_z))
    straight = Support(tuple(range(1, elements + 1)), ("x", "y", "z", "ry", "rz"))
    rest, pushed = (
        tf.solve_modes(cantilever(elements, own, straight, axial_force=force), 1).frequencies[0]
        for force in (0.0, push)
    )
    assert pushed / rest == pytest.approx(np.sqrt(0.5), rel=1e-9)
    name = "Wagner's term: torsion frequency under N = -GJ A/(2 I_p) over that at rest"
    verification_row(name, 0.7071, pushed / rest, "sqrt(1 + N I_p/(GJ A))")


def test_spin_up(verification_row):
    """Kane, Ryan & Banerjee 1987: 10 m, EA = 2.8e7 N, EI = 1.4e4 N m², 1.2 kg/m, to 6 rad/s in 15 s."""
    elements = 24
    own = section(1.0, 5e-4, 5e-4, 1e-3, tf.Material(2.8e7, 1.2, 0.3))
    flat = Support(tuple(range(elements + 1)), ("z", "rx", "ry"))
    state = cantilever(elements, own, flat)
    given = {"method": tf.GeneralizedAlpha(0.8), "time_step": 5e-3, "end_time": 7.0, "probes": {"tip": (LENGTH, 0, 0)}}
    run = tf.simulate(state, tf.SpinUp(6.0, 15.0, axis=(0.0, 0.0, 1.0)), **given)
    tip = run.data.sel(probe="tip")
    at = int(np.argmin(tip.v.values))
    assert tip.v.values[at] == pytest.approx(-0.57384, rel=1e-3)
    assert tip.u.values[at] == pytest.approx(-0.01882, rel=1e-3)
    assert tip.time.values[at] == pytest.approx(6.76, abs=0.006)
    assert abs(run.energy_balance["residual"]) < 1e-6 * run.energy_balance["maneuver"]
    verification_row(
        "spin-up of a cantilever, 24 elements: largest lag [m]", -0.57384, tip.v.values[at], "theory.md 15"
    )
    verification_row("spin-up of a cantilever, 24 elements: u1 there [m]", -0.01882, tip.u.values[at], "theory.md 15")


def spinning_frame(elements: int, masses=()):
    """Free rectangular frame, `elements` on each side."""
    corners = np.array([[-1.25, -0.75, 0.0], [1.25, -0.75, 0.0], [1.25, 0.75, 0.0], [-1.25, 0.75, 0.0]])
    nodes = np.vstack([np.linspace(corners[k], corners[k - 3], elements, endpoint=False) for k in range(4)])
    ring = np.arange(len(nodes))
    own = section(5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7, tf.Material(3e9, 1380.0, 0.38))
    model = tf.Model.from_mesh(nodes, beams=np.column_stack([ring, np.roll(ring, -1)]), beam=own, masses=masses)
    return unstressed(model)


def outriggers():
    """Bodies beyond the middles of the short sides of four elements."""
    tensor = np.diag([0.02, 0.05, 0.04])
    return [tf.PointMass(node, 0.5, tensor, (side * 0.2, 0.0, 0.0)) for node, side in ((6, 1.0), (14, -1.0))]


@pytest.mark.parametrize("bodies", [False, True], ids=["alone", "with bodies"])
def test_free_frame_about_its_axes(bodies, verification_row):
    """About the axes of smallest and largest inertia nothing grows, about the middle one Euler's rate."""
    state, spin = spinning_frame(4, outriggers() if bodies else ()), 0.2
    second = state.system.inertia.second_moment
    smallest, middle, largest = np.trace(second) - np.diag(second)
    assert smallest < middle < largest
    for axis in range(3):
        motion = RigidMotion(spin * np.eye(3)[axis], np.zeros(3), np.zeros(3))
        q = spinning_equilibrium(state, motion, tf.Coupling())
        found = find_instability(state, q, motion, tf.Coupling(), tf.Rayleigh())
        if axis == 1:
            rate = spin * np.sqrt((largest - middle) * (middle - smallest) / (smallest * largest))
            assert found is not None
            assert found.rate == pytest.approx(rate, rel=1e-4)  # what flexibility leaves is 4e-5
            verification_row(
                f"free frame{' with bodies' * bodies} spun about its middle axis: growth rate [1/s]",
                rate,
                found.rate,
                "Euler",
            )
        else:
            assert found is None
            name = "minor" if axis == 0 else "major"
            verification_row(
                f"free frame{' with bodies' * bodies} spun about its {name} axis: growth rate [1/s]", 0, 0.0, "Euler"
            )


def test_whole_turns_strain_nothing(verification_row):
    """Rotation by any vector below a revolution, also in the tangent: six motions without stiffness."""
    state = spinning_frame(3)
    system, model = state.system, state.model
    worst = 0.0
    for vector in ([0.3, -0.2, 0.5], [2.0, 1.0, -1.5], [0.0, 5.0, 0.0]):
        q = np.zeros(model.dof_count)
        q[model.translation_dofs] = Rotation.from_rotvec(vector).apply(model.nodes) - model.nodes
        q[model.translation_dofs + 3] = vector
        force, energy = system.force(q[model.free_dofs])
        worst = max(worst, abs(energy), float(np.abs(force).max() / system.tangent(0.0 * q).max()))
        values = np.linalg.eigvalsh(system.matrix(system.tangent(q)).toarray())
        assert np.sum(np.abs(values) < 1e-9 * values[-1]) == 6
    assert worst < 1e-12
    verification_row("frame turned by up to 5 rad: energy and force", 0, worst, "invariance")


def test_force_is_the_slope_of_the_energy_and_the_tangent_that_of_the_force():
    rng = np.random.default_rng(3)
    system = cantilever(6, section()).system
    workspace, h = system.workspace(), 1e-6
    for size in (0.02, 0.4):
        q, way = size * rng.normal(size=system.size), rng.normal(size=system.size)
        force, _ = workspace.force(q)
        (plus, high), (minus, low) = (workspace.force(q + s * h * way) for s in (1.0, -1.0))
        assert (high - low) / (2.0 * h) == pytest.approx(force @ way, rel=1e-8)
        push = system.matrix(system.tangent(q)) @ way
        assert np.abs((plus - minus) / (2.0 * h) - push).max() < 1e-8 * np.abs(push).max()
    block = system.blocks[0]
    places = np.append(q, 0.0)[system.row_places[0]]
    stress = np.einsum("nst,nt->ns", block.elasticity, block.strain(places))
    np.testing.assert_allclose(stress, system.stress(q)[0], rtol=1e-10, atol=1e-6)
    step = 1e-6 * rng.normal(size=places.shape)
    change = (block.strain(places + step) - block.strain(places - step)) / 2.0
    foretold = np.einsum("nsd,nd->ns", block.strain_slope(places), step)
    np.testing.assert_allclose(change, foretold, atol=1e-8 * np.abs(foretold).max())


@pytest.mark.parametrize("method", [tf.EnergyConserving(), tf.GeneralizedAlpha(0.8), tf.Bathe()], ids=lambda m: m.name)
def test_energy_of_a_beam_that_is_pulled_round(method, verification_row):
    """Deflections of half the length in both planes: books that close, and steps that lose nothing."""
    state = cantilever(8, section(inertia_z=2e-6))
    pull = tf.NodalForce(nodes=[8], force=(0.0, 600.0, 2000.0))
    given = {"time_step": 0.01, "end_time": 3.0, "probes": {"tip": (LENGTH, 0.0, 0.0)}, "tolerance": 1e-10}
    run = tf.simulate(state, method=method, inputs=[pull], **given)
    assert run.warnings == []
    assert float(np.abs(run.data.w).max()) > 0.5 * LENGTH
    balance = run.energy_balance
    largest = float(np.abs(run.data.strain_energy + run.data.kinetic_energy).max())
    assert abs(balance["residual"]) < 1e-8 * largest
    verification_row(
        f"beam pulled round, {method.name}: energy balance", 0, abs(balance["residual"]) / largest, "energy"
    )
    if method.name == "energy-conserving":
        assert abs(balance["method"]) < 1e-9 * largest


@pytest.mark.parametrize("axis", ["y", "z"])
def test_moments_of_patches_turn_with_the_beam(axis):
    """At rest they are those on linear beams; bent and turned by radians they do the work of the bending alone."""
    pair = tf.PiezoPair([1, 2], 30.0, axis=axis)
    rest = {}
    for strain in ("von-karman", "corotational"):
        state = tf.solve_prestress(beam_line(replace(section(), strain=strain), LENGTH, 4, (Support.clamped([0]),)))
        bound = pair.prepare(state.system)
        if strain == "von-karman":
            rest[strain] = bound.load(0.0)
        else:
            rest[strain] = -stress_loads(state.system, bound.columns)[0] * 30.0
    assert rest["corotational"] == pytest.approx(rest["von-karman"], abs=1e-9)
    free = unstressed(beam_line(section(), LENGTH, 4, ()))
    system, model = free.system, free.model
    plain, bent = system.workspace(), system.workspace()
    bent.change_initial_stress(pair.prepare(system).stress(0.0))
    angles = np.array([0.0, 0.1, 0.3, 0.35, 0.4])[:, None] * (np.eye(3)[1] + 0.5 * np.eye(3)[2])
    works = []
    for turn in ([0.0, 0.0, 0.0], [1.2, -0.7, 0.9]):
        whole = Rotation.from_rotvec(turn)
        q = np.zeros(model.dof_count)
        q[model.translation_dofs] = whole.apply(model.nodes) - model.nodes
        q[model.translation_dofs + 3] = (whole * Rotation.from_rotvec(angles)).as_rotvec()
        works.append(bent.strain_energy(q[model.free_dofs]) - plain.strain_energy(q[model.free_dofs]))
    share = angles[3, "xyz".index(axis)] - angles[1, "xyz".index(axis)]
    assert works[0] == pytest.approx(-30.0 * share, rel=1e-2)
    assert works[1] == pytest.approx(works[0], rel=1e-9)


def test_rotary_inertia_lowers_frequencies(verification_row):
    """Rayleigh's beam between pins: w² = EI b⁴/(rho A (1 + r² b²))."""
    own, elements = section(1e-2, 1e-4, 1e-4, 2e-4), 32
    ends = (Support.pinned([0, elements]), Support((0,), ("rx",)), plane(elements - 1))
    for strain in ("von-karman", "corotational"):
        chosen = tf.BeamSection(STEEL, 1e-2, 1e-4, 1e-4, 2e-4, strain, rotary_inertia=True)
        found = tf.solve_modes(unstressed(beam_line(chosen, LENGTH, elements, ends)), 3).frequencies
        wave = np.arange(1, 4) * np.pi / LENGTH
        radius = own.inertia_y / own.area
        stiffness = STEEL.youngs_modulus * radius / STEEL.density
        exact = wave**2 * np.sqrt(stiffness / (1.0 + radius * wave**2)) / (2.0 * np.pi)
        np.testing.assert_allclose(found, exact, rtol=1e-4)
        verification_row(f"Rayleigh's beam, {strain}: third frequency [Hz]", exact[2], found[2], "rotary inertia")


def test_small_motion_is_that_of_linear_beams():
    """Frequencies differ in fourth order of the elements' length, and by rotary inertia."""
    differences = []
    for elements in (5, 10, 20):
        pair = []
        for strain in ("von-karman", "corotational"):
            own = tf.BeamSection(STEEL, 1e-2, 1e-8, 3e-8, 2e-8, strain, rotary_inertia=True)
            pair.append(tf.solve_modes(unstressed(beam_line(own, LENGTH, elements, (Support.clamped([0]),))), 6))
        differences.append(pair[1].frequencies[[2, 4]] / pair[0].frequencies[[2, 4]] - 1.0)
    order = observed_order(np.array(differences))
    assert np.all((order > 3.7) & (order < 4.6)), (order, differences)
    assert np.abs(differences[-1]).max() < 1e-4


def test_what_does_not_take_them_says_so():
    state = cantilever(4, section())
    with pytest.raises(tf.UnsupportedError, match="strain: expected beams whose forces are polynomials"):
        tf.reduce(state)


@pytest.mark.parametrize(
    ("angle", "masses", "told"),
    [
        (5.9, (), None),
        (6.1, (), "the turn reached 6.10 at t = 1 s in beam 9"),
        (0.19, (tf.PointMass(10, 1.0, 0.1),), None),
        (0.21, (tf.PointMass(10, 1.0, 0.1),), "the turn of a point mass reached 0.21 at t = 1 s in beam 9"),
        (0.21, (tf.PointMass(10, 1.0),), None),
    ],
)
def test_turns_beyond_the_theory_are_told(angle, masses, told):
    state = tf.solve_prestress(
        replace(beam_line(section(), LENGTH, 10, (Support.clamped([0]),)), masses=masses),
    )
    watch = MotionWatch(state.system)
    q = np.zeros(state.model.dof_count)
    q[state.model.translation_dofs[-1, 0] + 4] = angle
    watch.largest[0], watch.places[0] = (1.0, 1.0), q[state.model.free_dofs]
    found = [text for text in watch.warnings() if text.startswith("the turn")]
    assert len(found) == (told is not None)
    assert all(str(told) in text for text in found)


def test_boom_on_a_free_hub(verification_row):
    """A boom thrown round on a spinning hub: its energy stays, while the hub's rate changes by a fifth."""
    state = cantilever(8, section(inertia_z=2e-6))
    hub = tf.FreeHub(2000.0, (5000.0, 6000.0, 8000.0), angular_velocity=(0.3, 0.8, -0.4))
    place = state.model.nodes[:, 0] / LENGTH
    thrown = np.column_stack([0.0 * place, 3.0 * place**2, 5.0 * place**2])
    given = {"time_step": 5e-3, "end_time": 1.0, "initial_velocity": thrown, "tolerance": 1e-10}
    run = tf.simulate(state, hub, method=tf.EnergyConserving(), **given)
    balance, rates = run.energy_balance, run.data.angular_velocity.values
    assert np.abs(rates - rates[0]).max() > 0.2 * np.abs(rates[0]).max()
    assert abs(balance["residual"]) < 1e-10 * balance["initial"]
    verification_row("boom on a free hub: energy balance", 0, abs(balance["residual"]) / balance["initial"], "energy")


def test_frame_of_a_case_has_a_strain_measure_of_its_own(verification_row):
    """A free antenna, its film and cables pulling on corotational beams, has six motions without stiffness."""
    table = tomllib.loads(template("m2"))
    table["membrane"]["strain"] = "green-lagrange"
    table["frame"] |= {"strain": "corotational", "support": "free"}
    table["mesh"] = {"divisions": [8, 4]}
    table["cables"] |= {"per_long_edge": 9, "per_short_edge": 5}
    model = tf.build_model(tf.Case(**table))
    strains = {group.section.kind: group.section.strain for group in model.groups}
    assert strains == {"membrane": "green-lagrange", "cable": "green-lagrange", "beam": "corotational"}
    found = np.abs(tf.solve_modes(tf.solve_prestress(model), 7).frequencies)
    assert found[5] < 1e-3 < 0.1 < found[6]
    verification_row("free antenna on corotational beams: sixth frequency [Hz]", 0, found[5], "theory.md 5")


def test_modes_about_a_turned_state(verification_row):
    """A frame turned by one radian rings as at rest, but for the second order of the elements' length."""
    found = []
    for elements in (6, 12):
        state, vector = spinning_frame(elements), np.array([0.6, -0.5, 0.6])
        model = state.model
        q = np.zeros(model.dof_count)
        q[model.translation_dofs] = Rotation.from_rotvec(vector).apply(model.nodes) - model.nodes
        q[model.translation_dofs + 3] = vector
        rest, turned = (tf.solve_modes(state, 10, about=at).frequencies for at in (None, q[model.free_dofs]))
        assert np.abs(turned[:6]).max() < 1e-3
        found.append(turned[6:] / rest[6:] - 1.0)
    order = observed_order(np.array(found))[-1]
    assert np.all((order > 1.8) & (order < 2.4)), order
    assert np.abs(found[-1]).max() < 2e-3
    name = "frame turned by 1 rad, 12 elements a side: change of four frequencies"
    verification_row(name, 0, float(np.abs(found[-1]).max()), "invariance, order 2")
