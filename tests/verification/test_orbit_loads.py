"""Warm cables and booms, sunlight and gravity on a spacecraft, and modes of loaded structures and on free hubs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.structure.mesh import rectangle_mesh
from verification.builders import FILM_CASE
from verification.dynamic_cases import small_antenna

STEEL = tf.Material(70e9, 2700.0, 0.3)
TUBE = tf.BeamSection(STEEL, 1e-4, 4e-8, 9e-8, 1e-7)
LENGTH, EXPANSION = 2.0, 2.3e-5


def boom(count=8, strain="von-karman"):
    """Cantilever along x, its local z along z."""
    nodes = np.column_stack([np.linspace(0.0, LENGTH, count + 1), *np.zeros((2, count + 1))])
    lines = np.column_stack([np.arange(count), np.arange(1, count + 1)])
    supports = (tf.Support.clamped([0]),)
    return tf.solve_prestress(
        tf.Model.from_mesh(
            nodes, beams=lines, beam=replace(TUBE, strain=strain), supports=supports, prestress_mode="uniform"
        )
    )


def settled(state, effect):
    """Unknowns where the structure rests under a change of its stresses."""
    system, change = state.system, effect.prepare(state.system).stress(0.0)
    stress = [own + change.get(index, 0.0) for index, own in enumerate(system.initial_stress)]
    return tf.solve_static(replace(state, system=system.with_initial_stress(stress)))


@pytest.mark.parametrize("strain", ["von-karman", "corotational"])
def test_a_warm_boom_grows_and_bends_away_from_its_warm_side(strain, verification_row):
    """Boley & Weiner: expansion T L along, -expansion G L^2 / 2 across."""
    state = boom(strain=strain)
    warm = tf.FrameTemperature((0.03, 0.04, -0.055), EXPANSION)
    tip = state.system.translations(settled(state, warm))[-1]
    wanted = EXPANSION * np.array([0.03 * LENGTH, -0.5 * 0.04 * LENGTH**2, 0.5 * 0.055 * LENGTH**2])
    assert tip == pytest.approx(wanted, rel=1e-5)
    verification_row("boom under 0.055 K/m across: tip [m]", f"{wanted[2]:.6e}", f"{tip[2]:.6e}", "Boley & Weiner 10.2")
    even = state.system.translations(settled(state, tf.FrameTemperature(30.0, EXPANSION)))[-1]
    assert even == pytest.approx([EXPANSION * 30.0 * LENGTH, 0.0, 0.0], abs=1e-12)
    half = state.system.translations(settled(state, tf.FrameTemperature(30.0, EXPANSION, range(4))))[-1]
    assert half[0] == pytest.approx(0.5 * EXPANSION * 30.0 * LENGTH)


def test_a_corotational_boom_warm_on_one_side_is_an_arc(verification_row):
    """Curvature expansion * G everywhere, nothing strained: here half a circle of the grown length."""
    state = boom(24, "corotational")
    curvature = np.pi / LENGTH
    tip = state.system.translations(
        settled(state, tf.FrameTemperature((50.0, 0.0, -curvature / EXPANSION), EXPANSION))
    )[-1]
    grown = 1.0 + EXPANSION * 50.0
    wanted = np.array([-LENGTH, 0.0, 2.0 * grown / curvature])
    # The mean stretch of a bent beam is that of its arc, so that the arc itself comes out.
    assert tip == pytest.approx(wanted, rel=1e-6, abs=1e-6)
    verification_row("boom, heat bends it to half a circle: tip [m]", f"{wanted[2]:.5f}", f"{tip[2]:.5f}", "arc")


def test_a_warm_cable_between_walls_loses_tension(verification_row):
    """-E A expansion T; its own frequency falls by the root of the tension."""
    nodes = np.column_stack([np.linspace(0.0, 1.0, 41), *np.zeros((2, 41))])
    lines = np.column_stack([np.arange(40), np.arange(1, 41)])
    cable = tf.CableSection(tf.Material(70e9, 1500.0), 1e-6)
    model = tf.Model.from_mesh(
        nodes, cables=lines, cable=cable, cable_tension=10.0, supports=(tf.Support.pinned([0, 40]),),
        prestress_mode="uniform",
    )  # fmt: skip
    state = tf.solve_prestress(model)
    change = tf.CableTemperature(tf.TimeTable([0.0, 1.0], [0.0, 2.0]), EXPANSION, "x").prepare(state.system)
    lost = change.stress(0.5)[0][:, 0] * 1e-6
    assert lost == pytest.approx(np.full(40, -70e9 * 1e-6 * EXPANSION))
    warm = tf.solve_prestress(
        replace(model, groups=(replace(model.groups[0], initial=model.groups[0].initial + lost[:, None]),))
    )
    found = tf.solve_modes(warm, 1).frequencies[0]
    wanted = 0.5 * np.sqrt((10.0 - 1.61) / 1.5e-3)
    assert found == pytest.approx(wanted, rel=3e-4)
    verification_row("cable 1 K warmer: lowest frequency [Hz]", f"{wanted:.5f}", f"{found:.5f}", "sqrt(T/mu)/2L")


@pytest.mark.parametrize("element", ["triangle3", "triangle6", "quad4"])
def test_sunlight_pushes_flat_film_by_the_closed_form(element, verification_row):
    """McInnes (2.47): along the light what is absorbed, along the normal what is reflected; held nodes too."""
    from tautflex.structure.shapes import SHAPES

    nodes, cells = rectangle_mesh(np.linspace(0.0, 2.0, 5), np.linspace(0.0, 1.0, 4), shape=SHAPES[element])
    edge = np.flatnonzero((nodes[:, 0] < 1e-9) | (nodes[:, 0] > 2.0 - 1e-9))
    model = tf.Model.from_mesh(
        nodes,
        surfaces={element: cells},
        membrane=tf.MembraneSection(STEEL, 1e-5),
        membrane_stress=(1e6, 1e6, 0.0),
        supports=(tf.Support.pinned(edge),),
        prestress_mode="uniform",
    )
    state = tf.solve_prestress(model)
    angle, specular, diffuse = 0.6, 0.7, 0.1
    light = np.array([np.sin(angle), 0.0, -np.cos(angle)])
    sun = tf.SolarPressure(3.0 * light, specular=specular, diffuse=diffuse).prepare(state.system)
    shared = tf.SolarPressure(light, tf.TimeTable([0.0, 10.0], [0.0, 1.0]), specular=specular, diffuse=diffuse)
    normal = np.array([0.0, 0.0, 1.0])  # against the light
    c = np.cos(angle)
    wanted = 4.56e-6 * 2.0 * c * ((1 - specular) * light - 2 * (specular * c + diffuse / 3) * normal)
    free = np.zeros(3)
    places = state.system.place[model.translation_dofs]
    for k in range(3):
        own = places[:, k][places[:, k] < state.system.size]
        free[k] = sun.load(0.0)[own].sum()
    held = sun.held_wrench(0.0)
    assert free + held[:3] == pytest.approx(wanted, rel=1e-12)
    # About the origin it acts in the middle.
    moment = held[3:].copy()
    for node in range(len(nodes)):
        force = np.array([0.0 if p == state.system.size else sun.load(0.0)[p] for p in places[node]])
        moment += np.cross(nodes[node], force)
    assert moment == pytest.approx(np.cross([1.0, 0.5, 0.0], wanted), rel=1e-12, abs=1e-20)
    assert shared.prepare(state.system).load(5.0) == pytest.approx(0.5 * sun.load(0.0))
    verification_row(
        f"sunlight on 2 m2, {element} [N]", f"{wanted[2]:.6e}", f"{(free + held[:3])[2]:.6e}", "McInnes (2.47)"
    )


@pytest.mark.slow
def test_gravity_turns_a_long_spacecraft_towards_the_earth(verification_row):
    """Libration in pitch: n sqrt(3 (J_x - J_z) / J_y) [Hughes 1986, 8.3], here of a stiff structure on its hub."""
    state, rate = tf.solve_prestress(small_antenna()), 0.5
    hub = tf.FreeHub(
        50.0, (60.0, 62.0, 15.0), angular_velocity=(0.0, rate, 0.0), attitude=(np.cos(0.005), 0.0, np.sin(0.005), 0.0)
    )
    torque = tf.gravity_gradient(state, hub, rate)
    run = tf.simulate(state, replace(hub, torque=torque), time_step=0.02, end_time=20.0)
    inertia = np.asarray(torque.inertia)
    pitch = (
        2.0 * np.arctan2(run.data.attitude.values[:, 2], run.data.attitude.values[:, 0]) - rate * run.data.time.values
    )
    pitch = np.angle(np.exp(1j * pitch))
    frequency = rate * np.sqrt(3.0 * (inertia[0, 0] - inertia[2, 2]) / inertia[1, 1])
    wanted = 0.01 * np.cos(frequency * run.data.time.values)
    assert np.abs(pitch - wanted).max() < 0.02 * 0.01
    verification_row(
        "gravity gradient: libration in pitch [rad/s]", f"{frequency:.4f}", "record within 2 %", "Hughes 8.3"
    )


def frame_with(support, masses=()):
    """Frame of beams with a film in it, whose turns as a whole strain nothing."""
    model = small_antenna()
    groups = tuple(replace(group, section=replace(group.section, strain="green-lagrange")) for group in model.groups)
    return replace(model, supports=support, masses=masses, groups=groups, prestress_mode="equilibrium")


def test_modes_on_a_free_hub_are_those_of_the_whole_spacecraft(verification_row):
    """A hub that holds one node is a body at that node of the free structure."""
    beams = np.unique(small_antenna().beams)
    node = int(beams[0])
    place = small_antenna().nodes[node]
    inertia = ((0.5, 0.02, 0.0), (0.02, 0.4, 0.01), (0.0, 0.01, 0.7))
    held = tf.solve_prestress(frame_with((tf.Support.clamped([node]),)))
    on_hub = tf.solve_modes(held, 8, hub=tf.FreeHub(3.0, inertia, center=tuple(place))).frequencies
    free = tf.solve_prestress(frame_with((), (tf.PointMass(node, 3.0, inertia),)))
    wanted = tf.solve_modes(free, 14).frequencies[6:]
    # The hub turns beams with their sections, whose turning in bending linear beams leave out: 4e-4 of a frequency.
    assert on_hub == pytest.approx(wanted, rel=6e-4)
    assert on_hub[0] > 1.001 * tf.solve_modes(held, 8).frequencies[0]
    heavy = tf.solve_modes(held, 8, hub=tf.FreeHub(1e9, (1e9, 1e9, 1e9))).frequencies
    assert heavy == pytest.approx(tf.solve_modes(held, 8).frequencies, rel=1e-6)
    verification_row(
        "modes on a free hub against the free structure", "same", f"{np.abs(on_hub / wanted - 1).max():.1e}", "8 modes"
    )


def test_modes_about_a_loaded_state_feel_its_tension(verification_row):
    """A cable pulled from 10 to 15 N: sqrt(T / mu) / (2 L)."""
    nodes = np.column_stack([np.linspace(0.0, 1.0, 41), *np.zeros((2, 41))])
    lines = np.column_stack([np.arange(40), np.arange(1, 41)])
    cable = tf.CableSection(tf.Material(70e9, 1500.0), 1e-6)
    ends = tf.Support.pinned([0]), tf.Support((40,), ("y", "z"))
    model = tf.Model.from_mesh(
        nodes, cables=lines, cable=cable, cable_tension=10.0, supports=ends, prestress_mode="uniform"
    )
    state = tf.solve_prestress(model)
    forces = np.zeros((41, 3))
    forces[-1, 0] = 5.0
    loaded = tf.solve_static(state, forces=forces)
    found = tf.solve_modes(state, 2, about=loaded).frequencies
    wanted = 0.5 * np.sqrt(15.0 / 1.5e-3)
    assert found == pytest.approx([wanted, wanted], rel=3e-4)
    verification_row(
        "cable pulled to 15 N: lowest frequency about it [Hz]", f"{wanted:.4f}", f"{found[0]:.4f}", "sqrt(T/mu)/2L"
    )


def test_an_eclipse_from_a_case_file():
    """Sun, then shadow: film, cables and frame cool by tables, light goes out."""
    times = "{ times = [0.0, 0.1, 0.2], values = [0.0, -0.02, -0.02] }"
    text = (
        template("m2-nearest-node")
        + f"""
[inputs.film]
kind = "membrane-temperature"
change = {times}
expansion = 2e-5
[inputs.straps]
kind = "cable-temperature"
change = {times}
expansion = -2e-6
cables = "y"
[inputs.frame]
kind = "frame-temperature"
change = {{ times = [0.0, 0.2], values = [[0.0, 0.0, 0.0], [-0.1, 0.0, 1.0]] }}
expansion = 1e-6
[inputs.sun]
kind = "solar-pressure"
direction = [0.0, 0.3, -1.0]
share = {{ times = [0.0, 0.1], values = [1.0, 0.0] }}
specular = 0.8
"""
    )
    case = parse_case(text, ["solver.end_time=0.3", "solver.time_step=5e-3", "output.fields='none'"])
    run = tf.run_case(case)
    assert run.data.time.values[-1] == pytest.approx(0.3)
    assert np.abs(run.data.w.values).max() > 0.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda s: tf.FrameTemperature((1.0, 2.0), 1e-6).prepare(s), "one number"),
        (lambda s: tf.FrameTemperature(1.0, 1e-6, [999]).prepare(s), "beams"),
        (lambda s: tf.CableTemperature(1.0, float("nan")).prepare(s), "expansion"),
        (lambda s: tf.SolarPressure((0.0, 0.0, 0.0)).prepare(s), "direction"),
        (lambda s: tf.SolarPressure((0.0, 0.0, 1.0), specular=0.8, diffuse=0.3).prepare(s), "absorbed"),
        (lambda _: tf.GravityGradient(np.eye(3), 1e-3, orbit_normal=(0.0, 0.0, 1.0)), "orbit_normal"),
        (lambda _: tf.GravityGradient(np.eye(3), 0.0), "orbital_rate"),
    ],
)  # fmt: skip
def test_wrong_loads_are_refused(make, words):
    system = tf.solve_prestress(small_antenna()).system
    with pytest.raises(tf.InputError, match=words):
        make(system)


def test_a_flat_film_that_only_cools_has_nothing_to_be_warned_of() -> None:
    """Held edges and one temperature: the tension follows ``E h a dT/(1 - nu)``, and nothing moves but round-off."""
    case = parse_case(FILM_CASE)
    state = tf.solve_prestress(tf.build_model(case))
    shade = tf.MembraneTemperature(change=tf.TimeTable([0.05, 0.2], [0.0, -20.0]), expansion=20e-6)
    run = tf.simulate(state, inputs=[shade], time_step=5e-3, end_time=0.3, damping=tf.Rayleigh(1.0))
    wanted = 0.3 + 3.5e9 * 1e-4 * 20e-6 * 20.0 / (1.0 - 0.34)
    assert float(run.data.min_principal_resultant[-1]) == pytest.approx(wanted, rel=1e-9)
    assert run.data.attrs["warnings"] == []
    assert run.error == 0.0
