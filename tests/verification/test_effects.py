"""What one unit of every effect does: closed forms, other ways to the same, no push on a free spacecraft."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import splu

import tautflex as tf
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from verification.builders import antenna, beam_line, unstressed

CABLE = tf.CableSection(tf.Material(1e9, 1000.0), 1e-5)
TENSION, AXIAL = 10.0, 1e9 * 1e-5 / 0.5


def film(stress: float = 4e3):
    section = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4)
    return tf.solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (6, 4)), section, (stress, stress, 0.0)))


@pytest.fixture(scope="module")
def held_film():
    return film()


@pytest.fixture(scope="module")
def taut():
    """Antenna in equilibrium."""
    return tf.solve_prestress(antenna((0.6, 1.1), (6, 4)))


def pair():
    """Two cables in a row, 0.5 m and 0.25 m long, between held ends."""
    nodes = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.75, 0.0, 0.0]]
    model = tf.Model.from_mesh(
        nodes,
        cables=[[0, 1], [1, 2]],
        cable=CABLE,
        cable_tension=TENSION,
        supports=(tf.Support.pinned([0, 2]),),
    )
    return tf.solve_prestress(model)


def response(state, effect, unit: float = 1.0):
    """Linear response of a state to a number of a stress, shape (size,), and the workspace that has the stress."""
    columns = InputSet(state.system, [effect]).columns
    workspace = state.system.workspace()
    workspace.change_initial_stress({index: unit * column[:, :, 0] for index, column in columns.items()})
    force = workspace.force(np.zeros(state.system.size))[0] - state.reference_force
    stiffness = state.system.matrix(state.tangent_entries).tocsc()
    return -splu(stiffness).solve(force), workspace


def authority(state, effect, change: float, mode) -> float:
    """Change of a mode's stiffness, relative, when film, cables and frame answer at once."""
    tangents = []
    for number in (change, -change):
        follow, workspace = response(state, effect, number)
        tangents.append(state.system.matrix(workspace.tangent(follow)) @ mode)
    stiffness = state.system.matrix(state.tangent_entries) @ mode
    return float(mode @ (tangents[0] - tangents[1]) / (2.0 * mode @ stiffness))


def test_one_number_along_a_direction_is_three_numbers(taut):
    direction, force = np.array([1.0, -2.0, 2.0]), 0.3
    edge = [int(node) for node in np.flatnonzero(np.abs(taut.model.nodes[:, 1] + 0.5) < 1e-9)]
    for kind, nodes in ((tf.NodalForce, [3, taut.model.supports[0].nodes[0]]), (tf.EdgeForce, edge)):
        one = InputSet(taut.system, [kind(nodes, force, direction=direction)])
        three = InputSet(taut.system, [kind(nodes, force * direction / 3.0)])
        np.testing.assert_allclose(one.load(0.0), three.load(0.0), atol=1e-15)
        np.testing.assert_allclose(one.held_wrench(0.0), three.held_wrench(0.0), atol=1e-15)
        unit = "N" if kind is tf.NodalForce else "N/m"
        assert one.labels == (f"force [{unit}]",)
        assert three.labels == tuple(f"force_{axis} [{unit}]" for axis in "xyz")


def test_sets_say_what_their_numbers_do(taut):
    """Pattern and columns times the numbers are loads and stresses."""
    inputs = InputSet(
        taut.system,
        [
            tf.NodalForce([5], lambda time: (0.0, time, 1.0)),
            tf.MembraneTemperature(2.0, 1e-6),
            tf.CableTension([0.1, 0.2], cables=[1, 4]),
            tf.Pressure(1.0),
            tf.StayCable((0.1, 0.1), (0.0, 0.0, 1.0), tf.Held(0.5)),
        ],
    )
    numbers = inputs.values(3.0)
    np.testing.assert_allclose(numbers, [0.0, 3.0, 1.0, 2.0, 0.1, 0.2, 1.0, 0.5])
    assert inputs.labels[3:] == ("change [K]", "change_1 [N]", "change_4 [N]", "pressure [Pa]", "tension [N]")
    np.testing.assert_allclose(inputs.pattern @ numbers, inputs.load(3.0), atol=1e-15)
    (follower,) = inputs.followers(3.0)
    push = inputs.load(3.0) + follower.force(np.zeros(taut.system.size))
    np.testing.assert_allclose(inputs.force_at_rest @ numbers, push, atol=1e-15)
    stress = inputs.stress(3.0)
    assert set(stress) == set(inputs.columns)
    for index, column in inputs.columns.items():
        np.testing.assert_allclose(column @ numbers, stress[index], rtol=1e-14, atol=1e-12)
    assert len(inputs.linear) == 5


def test_held_numbers_jump_where_they_are_set(held_film):
    """A run meets the jump at the instant of the change, as a function of time with a break has it."""
    held = tf.Held([0.0, 0.0, 1e-3])
    held.hold([0.0, 0.0, 5e-3], time=0.02)
    assert (held(np.nextafter(0.02, 0.0))[2], held(0.02)[2], held(9.0)[2]) == (1e-3, 5e-3, 5e-3)
    told = tf.NodalForce([17], lambda time: (0.0, 0.0, 5e-3 if time >= 0.02 else 1e-3), breaks=(0.02,))
    given = {"time_step": 5e-3, "end_time": 0.04, "method": tf.GeneralizedAlpha(), "fields": "all"}
    wanted, found = (
        tf.simulate(held_film, inputs=[push], **given)
        for push in (told, tf.NodalForce([17], breaks=(0.02,)).driven(held))
    )
    np.testing.assert_array_equal(found.data.displacement.values, wanted.data.displacement.values)
    with pytest.raises(tf.InputError, match="values: expected shape"):
        held.hold([1.0], time=0.03)


def test_stay_cable_pulls_as_a_force_at_its_point(held_film):
    """At a node, and inside an element, whose nodes share the pull with the moment that it has."""
    model = held_film.model
    node = int(np.argmin(np.linalg.norm(model.nodes - (1.0 / 3.0, 0.0, 0.0), axis=1)))
    above = model.nodes[node] + (0.3, 0.0, 0.4)
    stay = InputSet(held_film.system, [tf.StayCable(model.nodes[node], above, 2.0)])
    force = InputSet(held_film.system, [tf.NodalForce([node], (1.2, 0.0, 1.6))])
    np.testing.assert_allclose(stay.load(0.0), force.load(0.0), atol=1e-14)
    point = np.array([0.21, 0.07])
    load = InputSet(held_film.system, [tf.StayCable(point, (*point, -1.0), 2.0)]).load(0.0)
    forces = np.zeros(model.dof_count)
    forces[model.free_dofs] = load
    forces = forces[model.translation_dofs]
    np.testing.assert_allclose(forces.sum(axis=0), [0.0, 0.0, -2.0], atol=1e-14)
    np.testing.assert_allclose(forces[:, 2] @ model.nodes[:, :2], -2.0 * point, atol=1e-14)


def test_a_stay_that_motion_turns_is_told(held_film):
    """The angle to the true direction is atan of displacement across over length."""
    stay = tf.StayCable((1.0 / 3.0, 0.0), (1.0 / 3.0 + 0.2, 0.0, 0.0), 1e-3)
    node = int(np.argmin(np.linalg.norm(held_film.model.nodes - (1.0 / 3.0, 0.0, 0.0), axis=1)))
    q = np.zeros(held_film.system.size)
    q[held_film.system.place[held_film.model.translation_dofs[node]]] = 0.05, 0.0, 0.15
    assert stay.prepare(held_film.system).turned(q) == pytest.approx(np.arctan2(0.15, 0.15))
    given = {"time_step": 5e-3, "end_time": 0.1, "initial_velocity": lambda x, y: 0.7 * np.cos(np.pi * x / 2)}
    anchors = (0.2, 5.0)
    told = []
    for reach in anchors:
        stay = tf.StayCable((1.0 / 3.0, 0.0), (1.0 / 3.0 + reach, 0.0, 0.0), 1e-3)
        found = tf.simulate(held_film, inputs=[stay], **given).data.attrs["warnings"]
        told.append([text for text in found if "StayCable number 1 keeps its direction" in text])
    assert [len(texts) for texts in told] == [1, 0]


def test_tendon_in_series_with_a_cable(verification_row):
    """Static answer of two springs: k' = k_t k / (k_t + k) on one side, k_b on the other."""
    tendon, other, length = 500.0, 2.0 * AXIAL, 1e-3
    series = tendon * AXIAL / (tendon + AXIAL)
    reel = tf.TensionGroup([0], command="length", stiffness=tendon, change=length)
    state = tf.equip(pair(), [reel])
    place = state.system.place[state.model.translation_dofs[1, 0]]
    moved, workspace = response(state, reel, length)
    exact = -series * length / (series + other)
    assert moved[place] == pytest.approx(exact, rel=1e-10)
    workspace.force(moved)
    tensions = workspace.stress[0][:, 0] * CABLE.area
    np.testing.assert_allclose(tensions, TENSION + series * other / (series + other) * length, rtol=1e-10)
    assert state.cable_tension == pytest.approx([TENSION, TENSION])
    assert tf.equip(state, [reel]) is state
    verification_row("reel with a tendon, series springs: displacement [m]", exact, moved[place], "springs in series")


def test_commanded_tension_is_there_whatever_the_structure_does(verification_row):
    """The other cable gives way by u/k_b; the drive reels that, and what its own cable and tendon stretch."""
    tendon, other, more = 500.0, 2.0 * AXIAL, 0.7
    series = tendon * AXIAL / (tendon + AXIAL)
    pull = tf.TensionGroup([0], more, stiffness=tendon)
    state = tf.equip(pair(), [pull])
    place = state.system.place[state.model.translation_dofs[1, 0]]
    moved, workspace = response(state, pull, more)
    assert moved[place] == pytest.approx(-more / other, rel=1e-10)
    workspace.force(moved)
    np.testing.assert_allclose(workspace.stress[0][:, 0] * CABLE.area, TENSION + more, rtol=1e-10)
    workspace.force(5.0 * moved)
    assert workspace.stress[0][0, 0] * CABLE.area == pytest.approx(TENSION + more, rel=1e-14)
    stroke = float(pull.prepare(state.system).stroke(moved, more)[0])
    exact = more / series + more / other
    assert stroke == pytest.approx(exact, rel=1e-9)
    verification_row("drive at a commanded tension: stroke [m]", exact, stroke, "u / k' + u / k_b")


def test_commanded_tension_is_a_state_built_with_it(taut, verification_row):
    """Film and frame answer as `solve_prestress` says of the model with that tension: same frequencies."""
    scale, wanted = 1.02, []
    mode = tf.solve_modes(taut, n=1).vectors[0]
    pull = tf.TensionGroup("y", command="tension", share="pretension")
    state = tf.equip(taut, [pull, tf.TensionGroup("x")])
    change = (scale - 1.0) * taut.cable_tension[pull.prepare(state.system).cables].max()
    follow, workspace = response(state, pull, change)
    found = float(mode @ (state.system.matrix(workspace.tangent(follow)) @ mode))
    built = tf.solve_prestress(taut.model.with_pretension_scaled(1.0, scale))
    for one in (taut, built):
        wanted.append(float(mode @ (one.system.matrix(one.tangent_entries) @ mode)))
    gap = abs((found - wanted[0]) / (wanted[1] - wanted[0]) - 1.0)
    assert gap < 1e-3
    verification_row("commanded tension against a state built with it: change of stiffness", 0, gap, "same state")


def test_authority_depends_on_the_tendon(taut, verification_row):
    """All stiffness of the first mode is tension: commanded tensions have it all, stiff cables almost nothing."""
    mode, tendon = tf.solve_modes(taut, n=1).vectors[0], 133e9 * 3.14e-6 / 0.25 / 999.0
    shares = {}
    for command, stiffness in (("tension", None), ("length", tendon), ("length", None)):
        for axis in "xy":
            group = tf.TensionGroup(axis, command=command, stiffness=stiffness, share="pretension")
            other = tf.TensionGroup("yx"["xy".index(axis)], command=command, stiffness=stiffness)
            state = tf.equip(taut, [group, other])
            bound = group.prepare(state.system)
            whole = taut.cable_tension[bound.cables].max()
            if command == "length":
                whole /= bound.stiffness[0]
            shares[command, stiffness, axis] = authority(state, group, whole, mode)
    whole = shares["tension", None, "x"] + shares["tension", None, "y"]
    assert whole == pytest.approx(1.0, abs=2e-3)
    for axis in "xy":
        assert 0.0 < shares["length", None, axis] < 5e-3
        assert 0.1 < shares["length", tendon, axis] / shares["tension", None, axis] < 1.0
    verification_row("stiffness of mode 1 that commanded tensions of x and y cables have", 1, whole, "all is tension")


def test_piezoelectric_film_is_a_film_that_warms(held_film):
    """Bit-equal columns for equal free strains; a patch leaves the rest alone."""
    warm = InputSet(held_film.system, [tf.MembraneTemperature(1.0, 3e-6)]).columns
    electric = InputSet(held_film.system, [tf.PiezoFilm(3e-6, 1.0)]).columns
    np.testing.assert_array_equal(warm[0], electric[0])
    region = (0.0, 1.0, -0.5, 0.0)
    patch = InputSet(held_film.system, [tf.PiezoFilm(3e-6, 1.0, region=region)]).columns[0]
    middle = held_film.model.nodes[held_film.model.triangles].mean(axis=1)
    inside = (middle[:, 0] >= 0.0) & (middle[:, 1] <= 0.0)
    assert inside.sum() == 12
    np.testing.assert_array_equal(patch, warm[0] * inside[:, None, None])


@pytest.mark.parametrize(("axis", "component", "sign"), [("y", 2, -1.0), ("z", 1, 1.0)])
def test_patches_bend_a_cantilever(axis, component, sign, verification_row):
    """Constant moment along all elements: tip deflection M L^2 / (2 EI)."""
    section = tf.BeamSection(tf.Material(70e9, 2700.0, 0.3), 1e-4, 2e-10, 5e-10, 6e-10)
    length, elements, moment = 0.8, 4, 0.05
    state = unstressed(beam_line(section, length, elements, (tf.Support.clamped([0]),)))
    load = InputSet(state.system, [tf.PiezoPair(range(elements), moment, axis)]).load(0.0)
    q = splu(state.system.matrix(state.tangent_entries).tocsc()).solve(load)
    found = float(state.system.translations(q)[-1, component])
    inertia = section.inertia_y if axis == "y" else section.inertia_z
    exact = sign * moment * length**2 / (2.0 * 70e9 * inertia)
    assert found == pytest.approx(exact, rel=1e-9)
    verification_row(f"cantilever with patches about {axis}: tip [m]", exact, found, "M L^2 / (2 EI)")


INTERNAL = {
    "stay cable": lambda signal: tf.StayCable((0.3, 0.1), (0.2, 0.1, 0.3), lambda time: 0.05 + 0.04 * signal(time)),
    "commanded tension": lambda signal: tf.TensionGroup("y", lambda time: 0.05 * signal(time)),
    "length": lambda signal: tf.TensionGroup("x", lambda time: 1e-4 * signal(time), "length", 2e3),
    "piezoelectric film": lambda signal: tf.PiezoFilm(2e-11, lambda time: 1e5 * signal(time), (0.0, 1.0, -0.5, 0.5)),
    "patches": lambda signal: tf.PiezoPair([0, 1, 5], lambda time: 0.2 * signal(time)),
}


@pytest.mark.parametrize("name", INTERNAL)
def test_internal_effects_push_nothing_and_their_work_is_counted(taut, name, verification_row):
    """On a free hub the momenta stay, also where film and hub move; the energy balance closes with their work."""
    effect = INTERNAL[name](lambda time: float(np.sin(60.0 * time)))
    state = tf.equip(taut, [effect])
    bound = effect.prepare(state.system)
    if isinstance(bound, tf.PatternLoad):
        places = state.model.rigid_motions[state.model.free_dofs]
        wrench = places.T @ bound.pattern[:, 0] + bound.held[:, 0]
        assert np.abs(wrench).max() <= 1e-12 * np.abs(bound.pattern).sum()
    hub = tf.FreeHub(20.0, (4.0, 5.0, 6.0), (0.1, -0.05, 0.2), angular_velocity=(0.0, 0.0, 0.1))
    given = {"method": tf.GeneralizedAlpha(0.8), "time_step": 2e-3, "end_time": 0.06, "tolerance": 1e-11}
    given |= {"probes": {"A": (0.3, 0.2)}}
    given["initial_velocity"] = lambda x, y: 2e-3 * np.cos(np.pi * x / 2) * np.cos(np.pi * y)
    run, still = (tf.simulate(state, hub, inputs=inputs, **given) for inputs in ([effect], []))
    data, terms = run.data, run.energy_balance
    worst = 0.0
    for kind in ("linear_momentum", "angular_momentum"):
        values = data[kind].values
        worst = max(worst, float(np.abs(values - values[0]).max() / np.abs(values).max()))
    assert worst <= 1e-12
    assert abs(terms["residual"]) <= 1e-6 * abs(terms["loads"])
    assert np.abs(data.w.values - still.data.w.values).max() > 1e-3 * np.abs(still.data.w.values).max()
    verification_row(f"{name} on a free hub: change of momenta, relative", 0, worst, "internal forces")


def test_a_tendon_that_is_not_there_is_refused(taut):
    """No plant takes an effect whose structure it has not; two effects cannot want one cable different."""
    group = tf.TensionGroup("x", 0.1)
    with pytest.raises(tf.InputError, match=r"equip\(state, inputs\)"):
        tf.simulate(taut, inputs=[group], time_step=1e-3, end_time=2e-3)
    with pytest.raises(tf.InputError, match="one structure for all of them"):
        tf.equip(taut, [group, tf.TensionGroup("x", 1e-4, "length", 100.0)])
    assert tf.equip(taut, [tf.TensionGroup("x", 1e-4, "length")]) is taut


BAD = {
    "node": (lambda: tf.NodalForce([999], 1.0, direction=(0, 0, 1)), "nodes: expected"),
    "direction": (lambda: tf.NodalForce([3], 1.0, direction=(0, 0, 0)), "direction: expected a vector with a length"),
    "two numbers": (lambda: tf.NodalForce([3], (1.0, 2.0), direction=(0, 0, 1)), "force: expected one finite number"),
    "no signal": (lambda: tf.NodalForce([3], direction=(0, 0, 1)), "force: missing"),
    "cable": (lambda: tf.TensionGroup([99], 1.0, "length"), "cables: .*99"),
    "cables along z": (lambda: tf.TensionGroup("z", 1.0, "length"), "cables: expected the axis of some, .*got 'z'"),
    "cables along nothing": (
        lambda: tf.TensionGroup("up", 1.0, "length"),
        "cables: expected the axis of some, 'x' .*, or their numbers, got 'up'; leave it out for all",
    ),
    "share": (lambda: tf.TensionGroup([1, 2], 1.0, "length", share=[-1.0, 1.0]), "share: expected numbers >= 0"),
    "push": (lambda: tf.StayCable((0.1, 0.1), (0, 0, 1), -1.0), "tension: expected numbers >= 0 at t = 0 s, got -1"),
    "beside the film": (lambda: tf.StayCable((1.1, 0.1), (0, 0, 1), 1.0), "point: expected a point of the film"),
    "no length": (lambda: tf.StayCable((0.1, 0.1), (0.1, 0.1, 0.0), 1.0), "anchor: expected a place away"),
    "no film there": (lambda: tf.PiezoFilm(1e-11, 1.0, (5.0, 6.0, 5.0, 6.0)), "region: expected film elements"),
    "beam": (lambda: tf.PiezoPair([77], 1.0), "beams: .*77"),
    "beam twice": (lambda: tf.PiezoPair([1, 1], 1.0), "beams: expected at least one beam, every one once"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_not_there_is_named(name, taut):
    make, words = BAD[name]
    with pytest.raises(tf.InputError, match=words):
        tf.simulate(taut, inputs=[make()], time_step=1e-3, end_time=2e-3)


def test_cables_that_cannot_be_driven_are_named():
    state = pair()
    with pytest.raises(tf.InputError, match="two that alone meet at node 1"):
        tf.equip(state, [tf.TensionGroup(None, 1.0)])
    push = tf.TensionGroup([0], -11.0)
    state = tf.equip(state, [push])
    with pytest.raises(tf.InputError, match="expected numbers >= -10 at t = 0 s"):
        tf.simulate(state, inputs=[push], time_step=1e-3, end_time=2e-3)
    assert tf.TensionGroup([0], -10.0).prepare(state.system).values(0.0) == [-10.0]
    slack = tf.CableSection(tf.Material(1e9, 1000.0), 1e-5, law="slack")
    model = tf.Model.from_mesh(
        state.model.nodes, cables=state.model.cables, cable=slack, cable_tension=1.0, supports=state.model.supports
    )
    with pytest.raises(tf.InputError, match="expected elastic cables under TensionGroup"):
        tf.equip(tf.solve_prestress(model), [tf.TensionGroup([0])])
    for command, given in (("pull", {}), ("length", {"stiffness": -1.0}), ("length", {"share": "half"})):
        with pytest.raises(tf.InputError, match=r"command|stiffness|share"):
            tf.TensionGroup([0], 1.0, command, **given)
    with pytest.raises(tf.InputError, match="axis: expected one of 'y', 'z'"):
        tf.PiezoPair([0], 1.0, "x")
