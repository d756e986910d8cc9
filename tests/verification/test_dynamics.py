"""Energy, damping and the rotating-frame terms against closed forms and conservation laws."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.linalg import eigvals

from tautflex import (
    BeamSection,
    CableSection,
    Coupling,
    GeneralizedAlpha,
    Material,
    Model,
    Newmark,
    Rayleigh,
    RigidMotion,
    Stop,
    WilsonTheta,
    simulate,
    solve_modes,
    solve_prestress,
)
from tautflex.motion.kinematics import fixed_axis_motion
from tautflex.numeric import cross_matrix
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.structure.model import Support
from verification.builders import observed_order, rotation
from verification.dynamic_cases import (
    TINY_VELOCITY,
    SuddenSpin,
    moved,
    small_antenna,
    soft_film,
    string,
    two_term_root,
)

NO_MOTION = RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))
Z_AXIS = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("strain", ["von-karman", "green-lagrange"])
def test_energy_error_of_the_trapezoidal_rule_falls_with_the_square_of_the_step(strain, verification_row):
    """Undamped film at large amplitude: strain + kinetic energy stays but for O(dt^2)."""
    state = soft_film(strain=strain)
    errors = []
    for step in (0.004, 0.002, 0.001):
        run = simulate(
            state,
            method=Newmark(),
            time_step=step,
            end_time=0.4,
            initial_velocity=lambda x, y: 4.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8),
            tolerance=1e-9,
        )
        total = (run.data.kinetic_energy + run.data.strain_energy).values
        # All energy is kinetic at first, and most of it turns into strain energy in between.
        assert run.data.strain_energy.values[0] == 0.0
        assert run.data.strain_energy.max() > 0.8 * total[0]
        errors.append(np.abs(total / total[0] - 1.0).max())
    orders = observed_order(errors)
    assert orders[-1] == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 1e-3
    verification_row(f"undamped {strain} film, order of the energy error", 2.0, float(orders[-1]), "trapezoidal rule")


@pytest.mark.parametrize(("alpha", "beta"), [(0.3, 0.0), (0.0, 2e-3), (0.2, 1e-3)])
def test_rayleigh_damping_of_a_mode(alpha, beta, verification_row):
    """zeta = alpha/(2 w) + beta w/2; the trapezoidal root (1 + h s/2)/(1 - h s/2) gives back s exactly."""
    state = string(10, tension=4.0, modulus=1.0, free_directions="z")
    modes = solve_modes(state, n=3)
    shape, natural = modes.shapes[2], 2.0 * np.pi * modes.frequencies[2]
    step = 0.05 / modes.frequencies[2]
    run = simulate(
        state,
        method=Newmark(),
        time_step=step,
        end_time=100 * step,
        damping=Rayleigh(alpha, beta),
        initial_velocity=TINY_VELOCITY * shape,
        probes={"B": (0.5, 0.0, 0.0)},
        tolerance=1e-11,
    )
    root = two_term_root(run.data.w.values[:, 0])
    pole = 2.0 / step * (root - 1.0) / (root + 1.0)
    ratio = -pole.real / abs(pole)
    expected = 0.5 * alpha / natural + 0.5 * beta * natural
    assert ratio == pytest.approx(expected, rel=1e-7)
    assert abs(pole) == pytest.approx(natural, rel=1e-9)
    verification_row(f"damping ratio, alpha = {alpha:g}, beta = {beta:g}", expected, ratio, "alpha/(2w) + beta w/2")


def beam_bar(elements: int, length: float) -> PrestressedState:
    """Kane's beam [Simo & Vu-Quoc 1988] as a clamped bar of beam elements along x."""
    nodes = np.zeros((elements + 1, 3))
    nodes[:, 0] = np.linspace(0.0, length, elements + 1)
    model = Model.from_mesh(
        nodes,
        beams=np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        beam=BeamSection(Material(2.8e7, 1.2, 0.3), 1.0, 5e-4, 5e-4, 1e-3),
        beam_axial_force=1e-9,
        supports=(Support.clamped(0),),
    )
    return solve_prestress(model)


def cable_bar(elements: int, length: float) -> PrestressedState:
    return string(
        elements,
        length=length,
        tension=1e-9,
        modulus=2.8e7,
        area=1.0,
        density=1.2,
        free_directions="x",
        free_end=True,
    )


@pytest.mark.parametrize("bar", [beam_bar, cable_bar])
def test_bar_rotating_about_its_end_stretches_by_the_closed_form(bar, verification_row):
    """L = 10 m, EA = 2.8e7 N, rho A = 1.2 kg/m, 6 rad/s: w^2 rho A L^3 / (3 EA) = 5.143e-4 m."""
    length, rate = 10.0, 6.0
    motion = fixed_axis_motion(rate, 0.0, Z_AXIS, np.zeros(3))
    tips = []
    for elements in (2, 4, 8, 16):
        state = bar(elements, length)
        tips.append(state.system.translations(spinning_equilibrium(state, motion, Coupling()))[-1, 0])
    # The load follows the stretched position: EA u'' + rho A w^2 (x + u) = 0.
    wave = np.sqrt(1.2 * rate**2 / 2.8e7)
    exact = np.tan(wave * length) / wave - length
    assert exact == pytest.approx(5.143e-4, rel=1e-4)
    assert tips[-1] == pytest.approx(exact, rel=1e-6)
    assert tips[-1] == pytest.approx(rate**2 * 1.2 * length**3 / (3.0 * 2.8e7), rel=1e-4)
    name = "beam" if bar is beam_bar else "cable"
    verification_row(f"rotating bar of {name} elements, tip extension [m]", exact, tips[-1], "tan(kL)/k - L")
    if bar is cable_bar:
        # Without K_T the load stays at the reference position: w^2 rho A L^3/(3 EA), exact at the nodes.
        plain = spinning_equilibrium(state, motion, Coupling(centrifugal=False))
        assert state.system.translations(plain)[-1, 0] == pytest.approx(
            rate**2 * 1.2 * length**3 / (3.0 * 2.8e7), rel=1e-9
        )


def rotating_string_roots(elements: int) -> tuple[np.ndarray, np.ndarray]:
    """(w/W)^2 of a string spinning about z, held at the axis: out of plane, in plane."""
    rate = 2.0
    state = string(elements, tension=1e-7, modulus=1e8, free_end=True)
    system = state.system
    motion, coupling = fixed_axis_motion(rate, 0.0, Z_AXIS, np.zeros(3)), Coupling()
    q = spinning_equilibrium(state, motion, coupling)
    stiffness = system.tangent(q) + system.inertia.entries(coupling.displacement_weight(motion))
    stiffness = system.matrix(stiffness).toarray()
    mass = system.inertia.mass_matrix.toarray()
    gyroscopic = system.inertia.matrix(coupling.velocity_weight(motion)).toarray()
    size = system.size
    companion = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -gyroscopic]])
    weight = np.block([[np.eye(size), np.zeros((size, size))], [np.zeros((size, size)), mass]])
    roots = {}
    for name, axes in (("out", [2]), ("in", [0, 1])):
        kept = np.flatnonzero(np.isin(np.arange(size) % 3, axes))
        both = np.concatenate([kept, kept + size])
        # Nothing couples the two families: the rest of the rows is zero.
        others = np.setdiff1d(np.arange(2 * size), both)
        assert not np.any(companion[np.ix_(both, others)])
        values = eigvals(companion[np.ix_(both, both)], weight[np.ix_(both, both)])
        squares = np.sort((-(values**2)).real[values.imag >= 0.0])
        roots[name] = squares / rate**2
    return roots["out"], roots["in"]


def test_rotating_string_has_the_heliogyro_frequencies(verification_row):
    """(w/W)^2 = n(2n-1) out of plane, one less in plane: odd Legendre polynomials, tension W^2 (L^2 - x^2)/2."""
    number = np.arange(1, 4)
    exact = number * (2 * number - 1)
    found = {elements: rotating_string_roots(elements) for elements in (20, 40)}
    errors_out = np.array([found[elements][0][:3] - exact for elements in (20, 40)])
    # The first mode is a rigid tilt of the spin plane: exact on any mesh but for the stretch of 1e-6.
    assert np.abs(errors_out[:, 0]).max() < 3e-6
    np.testing.assert_allclose(np.log2(errors_out[0, 1:] / errors_out[1, 1:]), 2.0, atol=0.1)
    extrapolated = [
        found[40][0][:3] + (found[40][0][:3] - found[20][0][:3]) / 3.0,
        np.sort(found[40][1])[:3] + (np.sort(found[40][1])[:3] - np.sort(found[20][1])[:3]) / 3.0,
    ]
    np.testing.assert_allclose(extrapolated[0], exact, rtol=2e-4)
    np.testing.assert_allclose(extrapolated[1], exact - 1, rtol=2e-4, atol=1e-4)
    for n in (2, 3):
        out, within = np.sqrt(exact[n - 1]), np.sqrt(exact[n - 1] - 1)
        verification_row(
            f"rotating string, out of plane, n = {n}: w/W", out, np.sqrt(found[40][0][n - 1]), "sqrt(n(2n-1))"
        )
        got = np.sqrt(np.sort(found[40][1])[n - 1])
        verification_row(f"rotating string, in plane, n = {n}: w/W", within, got, "sqrt(n(2n-1)-1)")


def loose_particle() -> PrestressedState:
    """One free node on three cables without noticeable stiffness."""
    nodes = np.array([[0.3, 0.2, 0.1], [1.0, 0.0, 0.0], [-0.5, 0.8, 0.0], [0.0, -0.6, 0.9]])
    model = Model.from_mesh(
        nodes,
        cables=np.array([[0, 1], [0, 2], [0, 3]]),
        cable=CableSection(Material(1e-11, 1.0), 1.0),
        cable_tension=1e-11,
        supports=(Support.pinned([1, 2, 3]),),
    )
    return solve_prestress(model)


def test_all_frame_terms_together_are_inertial_motion(verification_row):
    """A force-free node, seen from a braking frame with a tilted, shifted axis, moves straight in space."""
    state = loose_particle()
    inertia = state.system.inertia
    mass = float(inertia.mass_matrix[0, 0])
    # The interpolation N of the node turns int rho N x into the position of its particle.
    position = np.array([inertia.first_moment[0, b, 0] for b in range(3)]) / mass
    axis, origin = np.array([2.0, -1.0, 2.0]) / 3.0, np.array([0.1, -0.4, 0.3])
    # ... and the shift of the axis by the ratio of int rho N to int rho N^2.
    offset = origin * float(inertia.zeroth_moment[0, 0]) / mass
    velocity = np.array([0.4, -0.3, 0.2])
    rate, duration, end = 1.5, 2.0, 1.0
    stop = Stop(rate, duration, axis=tuple(axis), origin=tuple(origin))
    errors = []
    for step in (0.02, 0.01, 0.005):
        run = simulate(
            state,
            SuddenSpin(stop),
            method=Newmark(),
            time_step=step,
            end_time=end,
            initial_velocity=np.vstack([velocity, np.zeros((3, 3))]),
            fields=[end],
            tolerance=1e-11,
        )
        angle = rate * end - 0.5 * rate / duration * end**2
        back = turn(axis, -angle)
        start = position - offset
        expected = back @ (start + (velocity + rate * np.cross(axis, start)) * end) - start
        errors.append(np.linalg.norm(run.data.displacement.values[0, 0] - expected) / np.linalg.norm(expected))
    assert observed_order(errors)[-1] == pytest.approx(2.0, abs=0.05)
    assert errors[-1] < 2e-5
    verification_row(
        "free particle in a braking frame, error of the position after 1 s (dt = 5 ms)",
        0.0,
        errors[-1],
        "straight line",
    )


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation matrix [Rodrigues]."""
    cross = cross_matrix(axis)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def antenna_motion(model: Model, stop: Stop, **options) -> np.ndarray:
    run = simulate(
        solve_prestress(model),
        stop,
        method=GeneralizedAlpha(rho_inf=0.8),
        time_step=5e-3,
        end_time=0.2,
        damping=Rayleigh(0.01, 1e-3),
        fields="all",
        tolerance=1e-10,
        **options,
    )
    return run.data.displacement.values


@pytest.mark.parametrize("strain", ["von-karman", "green-lagrange"])
def test_a_turned_and_shifted_antenna_moves_alike(strain, verification_row):
    model, axis, origin = small_antenna(strain=strain), np.array([1.0, 0.2, -0.1]), np.array([0.05, 0.1, 0.0])
    turned, shift = rotation(5), np.array([0.7, -1.3, 0.4])
    here = antenna_motion(model, Stop(0.6, 0.1, tuple(axis), tuple(origin)))
    there = antenna_motion(
        moved(model, turned, shift), Stop(0.6, 0.1, tuple(turned @ axis), tuple(turned @ origin + shift))
    )
    error = np.abs(there - here @ turned.T).max() / np.abs(here).max()
    assert error < 1e-9
    verification_row(f"antenna ({strain}) turned and shifted in space: change of its motion", 0.0, error, "objectivity")


def test_shifting_the_axis_equals_shifting_the_antenna():
    model, shift = small_antenna(), np.array([0.0, 0.3, 0.2])
    here = antenna_motion(model, Stop(0.6, 0.1, origin=tuple(-shift)))
    there = antenna_motion(moved(model, np.eye(3), shift), Stop(0.6, 0.1))
    np.testing.assert_allclose(there, here, atol=1e-9 * np.abs(here).max())
    centred = antenna_motion(model, Stop(0.6, 0.1))
    assert np.abs(centred - here).max() > 0.1 * np.abs(here).max()


def frame_forces(state: PrestressedState, coupling: Coupling, motion: RigidMotion, q, v) -> np.ndarray:
    """Inertia force that balances all others: -M a of the state."""
    equation = EquationOfMotion(state, Rayleigh(), coupling)
    return -(state.system.inertia.mass_matrix @ equation.start(0.0, q, v, motion).a)


@pytest.mark.parametrize("term", ["gyroscopic", "euler", "centrifugal", "inertial_load"])
def test_each_switch_removes_exactly_its_term(term):
    state = solve_prestress(small_antenna())
    system, random = state.system, np.random.default_rng(7)
    q, v = 1e-4 * random.standard_normal(system.size), random.standard_normal(system.size)
    spin, change, lift = np.array([0.7, -0.4, 0.5]), np.array([-0.2, 0.6, 0.9]), np.array([0.3, 0.1, -0.2])
    motion = RigidMotion(spin, change, lift)
    one, two = cross_matrix(change), cross_matrix(spin) @ cross_matrix(spin)
    inertia = system.inertia
    expected = {
        "gyroscopic": inertia.matrix(2.0 * cross_matrix(spin)) @ v,
        "euler": inertia.matrix(one) @ q,
        "centrifugal": inertia.matrix(two) @ q,
        "inertial_load": inertia.load(one + two, lift),
    }
    on = frame_forces(state, Coupling(), motion, q, v)
    off = frame_forces(state, Coupling(**{term: False}), motion, q, v)
    # Internal forces of these q are millions of newtons; the other terms must cancel to round-off of those.
    np.testing.assert_allclose(on - off, expected[term], atol=1e-12 * np.abs(on).max())
    assert np.abs(expected[term]).max() > 1e-9 * np.abs(on).max()
    none = frame_forces(state, Coupling(False, False, False, False), motion, q, v)
    np.testing.assert_allclose(none, frame_forces(state, Coupling(), NO_MOTION, q, v), rtol=1e-12)
    np.testing.assert_allclose(on - none, sum(expected.values()), atol=1e-12 * np.abs(on).max())


def test_gyroscopic_forces_do_no_work():
    """v'Gv = 0 for any velocity, and the spin-stiffness of the Euler term is skew too."""
    inertia = solve_prestress(small_antenna()).system.inertia
    random = np.random.default_rng(3)
    for weight in (2.0 * cross_matrix([0.7, -0.4, 0.5]), cross_matrix([-0.2, 0.6, 0.9])):
        v = random.standard_normal(inertia.pattern.size)
        force = inertia.matrix(weight) @ v
        assert abs(v @ force) < 1e-13 * np.linalg.norm(v) * np.linalg.norm(force)


@pytest.mark.parametrize("method", [WilsonTheta(), GeneralizedAlpha(rho_inf=1.0), GeneralizedAlpha(rho_inf=0.6)])
def test_a_stop_between_two_grid_steps_keeps_second_order(method, verification_row):
    """The deceleration ends inside a step; the run steps onto its end instead of smearing it."""
    state, stop = soft_film(), Stop(3.0, 0.0737, origin=(0.0, 0.5, 0.0))
    records = []
    for level in range(4):
        step = 0.004 / 2**level
        run = simulate(
            state,
            stop,
            method=method,
            time_step=step,
            end_time=0.2,
            probes={"A": (0.12, 0.1)},
            every=2**level,
            tolerance=1e-9,
        )
        assert run.stats.steps == round(0.2 / step) + 1
        np.testing.assert_allclose(run.data.time.values, 0.004 * np.arange(51), atol=1e-14)
        records.append(run.data.w.values[:, 0])
    differences = [np.sqrt(np.mean((a - b) ** 2)) for a, b in itertools.pairwise(records)]
    order = np.log2(differences[-2] / differences[-1])
    assert order == pytest.approx(2.0, abs=0.1)
    verification_row(f"{method.name}, stop inside a step: observed order", 2.0, float(order), "second order")
