"""One structure of a single mesh and of linked pieces through all solvers: the links change no digit that counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tautflex as tf
from tautflex import RigidLink, Support, Tie
from tautflex.mechanics.loads.pressure import nodal_load
from tautflex.solvers.modal.refinement import mesh_errors
from verification.test_links import FILM, sheet

MAST = tf.BeamSection(tf.Material(7e9, 1600.0, 0.33), 5e-5, 4e-10, 4e-10, 6e-10)
STRAIN = ("u", "v", "w", "kinetic_energy", "strain_energy")


def boomed_film(apart: bool) -> tf.Model:
    """Film of two pieces with a boom along its lower edge: nodes shared, or tied and rigidly linked."""
    one, other = sheet((3, 2), 0.0, 1.0), sheet((2, 2), 1.0, 0.7)
    count = len(one[0])
    if apart:
        boom = np.concatenate([one[0][::3], other[0][3::3]])
        nodes = np.concatenate([one[0], other[0], boom])
        triangles = np.concatenate([one[1], other[1] + count])
        film = [*range(0, count, 3), *range(count + 3, count + 9, 3)]
        own = count + 9 + np.arange(6)
        # The seam's lower node follows a node of the film that follows the boom.
        links: list[Any] = [RigidLink(int(a), [b]) for a, b in zip(own, film, strict=True)]
        links += [Tie(count - 3 + k, [count + k]) for k in range(3)]
    else:
        nodes = np.concatenate([one[0], other[0][3:]])
        triangles = np.concatenate([one[1], other[1] + count - 3])
        own, links = np.arange(0, len(nodes), 3), []
    upper = np.flatnonzero(nodes[:, 1] > 0.999)
    return tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=FILM,
        membrane_stress=(4e4, 3e4, 5e3),
        beams=np.column_stack([own[:-1], own[1:]]),
        beam=MAST,
        supports=[Support.clamped([own[0]]), Support.pinned(upper)],
        masses=[tf.PointMass(int(own[-1]), 0.02, 1e-5, (0.0, 0.0, 0.05))],
        links=links,
    )


@pytest.fixture(scope="module")
def states() -> tuple[tf.PrestressedState, ...]:
    return tuple(tf.solve_prestress(boomed_film(apart)) for apart in (False, True))


def test_mesh_errors_along_a_boom(states: Any) -> None:
    """Sides on the boom stay straight between its nodes."""
    whole, parts = (mesh_errors(tf.solve_modes(state, n=4), [0, 1]) for state in states)
    assert parts == pytest.approx(whole, rel=0.4)
    assert np.all((parts > 0.02) & (parts < whole))


def simulated(state: Any, maneuver: Any, method: Any = None, **given: Any) -> Any:
    given = {"time_step": 2e-3, "end_time": 0.1, "probes": {"A": (0.8, 0.4), "B": (1.3, 0.1)}, **given}
    return tf.simulate(state, maneuver, method=method, damping=tf.Rayleigh(0.1, 1e-4), **given)


def node_at(state: Any, place: Any) -> int:
    return int(np.argmin(np.linalg.norm(state.model.nodes - place, axis=1)))


def same(found: Any, expected: Any, tolerance: float = 1e-7) -> None:
    for name in STRAIN:
        one, other = found[name].values, expected[name].values
        assert np.abs(other).max() > 0.0
        assert np.abs(one - other).max() <= tolerance * np.abs(other).max(), name


def test_unknowns_are_those_of_the_single_mesh(states: Any) -> None:
    whole, parts = states
    assert parts.system.size == whole.system.size
    assert parts.model.mass == pytest.approx(whole.model.mass)
    assert not any("not joined" in text for text in parts.warnings)


@pytest.mark.parametrize(
    "method",
    [tf.WilsonTheta(), tf.GeneralizedAlpha(), tf.EnergyConserving(), tf.Bathe(), tf.CentralDifference()],
    ids=lambda method: type(method).__name__,
)
def test_runs(states: Any, method: Any) -> None:
    given = {"time_step": 2e-5, "end_time": 2e-3} if isinstance(method, tf.CentralDifference) else {}
    whole, parts = (simulated(state, tf.Stop(2.0, 0.04), method, **given) for state in states)
    same(parts.data, whole.data)


def test_runs_on_a_free_hub(states: Any) -> None:
    found = []
    for state in states:
        ends = [node_at(state, place) for place in ([1.35, 0.5, 0.0], [1.7, 0.5, 0.0])]
        pull = tf.NodalForce([int(state.model.beams[3, 0])], (0.1, 0.0, 0.1))
        push = [tf.EdgeForce(ends, force=(0.0, 0.0, 0.2)), pull]
        hub = tf.FreeHub(2.0, (0.4, 0.5, 0.6), angular_velocity=(0.3, 0.2, 0.0))
        found.append(simulated(state, hub, inputs=push).data)
    same(found[1], found[0])
    assert found[1]["angular_velocity"].values == pytest.approx(found[0]["angular_velocity"].values, rel=1e-8)


def test_reduced_runs(states: Any) -> None:
    found = []
    for state in states:
        rom = tf.reduce(state, tf.ModalBasis(directions=("rx",), count=4))
        hub = tf.FreeHub(2.0, (0.4, 0.5, 0.6), angular_velocity=(0.3, 0.2, 0.0))
        found.append((simulated(rom, tf.Stop(2.0, 0.04)).data, simulated(rom, hub).data))
    for one, other in zip(*found, strict=True):
        same(one, other, 1e-5)


@pytest.mark.jax
def test_batches(states: Any) -> None:
    options = {"time_step": 2e-3, "end_time": 0.04, "probes": {"A": (0.8, 0.4)}, "method": tf.Newmark()}
    table = {"damping.alpha": np.array([0.1]), "damping.beta": np.array([1e-4])}
    for state in states[1], tf.reduce(states[1], tf.ModalBasis(directions=("rx",), count=4)):
        many = tf.Batch(state).simulate(table, tf.Stop(2.0, 0.04), **options)
        one = tf.simulate(state, tf.Stop(2.0, 0.04), damping=tf.Rayleigh(0.1, 1e-4), **options).data
        assert np.abs(many.w[0].values - one.w.values).max() < 1e-7 * np.abs(one.w.values).max()


def test_modes_spinning_modes_and_linear_views(states: Any) -> None:
    whole, parts = (tf.solve_modes(state, n=6).frequencies for state in states)
    assert parts == pytest.approx(whole, rel=1e-9)
    whole, parts = (tf.solve_spinning_modes(state, (1.0, 0.5, 0.0), n=4).frequencies for state in states)
    assert parts == pytest.approx(whole, rel=1e-8)
    sensors = {"A": tf.Displacement([(0.8, 0.4)]), "tip": tf.Displacement([(1.7, 0.0)])}
    views = []
    for state in states:
        force = tf.NodalForce([int(state.model.beams[3, 0])], direction=(0.0, 0.3, 1.0))
        push = {"push": force.prepare(state.system)}
        plant = tf.linearize(state, push, sensors, modes=6)
        views.append(plant.D - plant.C @ np.linalg.solve(plant.A, plant.B))
        data = tf.authority(state, push, limits={"push": 0.1}, modes=4)
        views.append(np.abs(data.force.values))
    assert views[2] == pytest.approx(views[0], rel=1e-6, abs=1e-12)
    assert views[3] == pytest.approx(views[1], rel=1e-6, abs=1e-9)


def test_statics_under_pressure_and_dead_forces(states: Any) -> None:
    found = []
    for state in states:
        forces = np.zeros((len(state.model.nodes), 3))
        forces[node_at(state, [1.0, 0.5, 0.0])] = (0.1, 0.0, 0.3)
        load = tf.PressureLoad(state.system, 0.5)
        q = tf.solve_static(state, -nodal_load(state.system, forces), pressure=load)
        # Derivative of the pressure's force against differences.
        step = 1e-6 * np.sin(np.arange(state.system.size))
        change = (load.force(q + step) - load.force(q - step)) / 2.0
        assert change == pytest.approx(state.system.matrix(load.tangent(q)) @ step, abs=1e-6 * np.abs(change).max())
        moved = state.system.translations(q)
        found.append([moved[node_at(state, place)] for place in states[0].model.nodes])
    assert np.array(found[1]) == pytest.approx(np.array(found[0]), rel=1e-6, abs=1e-10)


def test_stored_fields_have_the_linked_nodes(states: Any, tmp_path: Any) -> None:
    data = simulated(states[1], tf.Stop(2.0, 0.04), fields="all", every=10).data
    fields = data["displacement"].values
    assert np.abs(fields).max() > 1e-6
    assert fields[:, 12:15] == pytest.approx(fields[:, 9:12], abs=1e-15)
    assert tf.write_vtu(data, tmp_path)


def cut_boom(arm: float | None) -> tf.Model:
    """Corotational cantilever of 1 m in ten beams: whole (None), or cut in the middle over a rigid arm of a length."""
    whole = np.arange(11)
    ends = [0.1 * k + (arm or 0.0) * (k > 5) for k in whole]
    nodes = np.column_stack([[*ends, ends[5] + (arm or 0.0)], np.zeros((12, 2))])
    lines = np.column_stack([whole[:-1], whole[1:]])
    if arm is None:
        nodes = nodes[:11]
    else:
        lines[5, 0] = 11
    links = [] if arm is None else [RigidLink(5, [11])]
    tube = tf.BeamSection(tf.Material(7e10, 2700.0, 0.33), 1e-4, 8e-10, 8e-10, 1.4e-9, strain="corotational")
    return tf.Model.from_mesh(
        nodes, beams=lines, beam=tube, supports=[Support.clamped([0])], links=links, prestress_mode="uniform"
    )


def test_corotational_beams_turn_with_links_without_length_and_warn_of_others() -> None:
    found, said = [], []
    for arm in (None, 0.0, 0.1):
        state = tf.solve_prestress(cut_boom(arm))
        forces = np.zeros((len(state.model.nodes), 3))
        forces[10, 2] = 300.0
        found.append(state.system.translations(tf.solve_static(state, forces=forces))[10])
        push = tf.NodalForce([10], tf.TimeTable([0.0, 1.0], [0.0, 300.0]), direction=(0.0, 0.0, 1.0))
        run = tf.simulate(state, inputs=[push], time_step=0.02, end_time=1.0, damping=tf.Rayleigh(20.0, 0.0))
        said.append(any("turn of a link reached" in text for text in run.warnings))
    # P L^2 / EI = 5.36: a deflection beyond 0.7 of the length.
    assert found[0][2] > 0.7
    assert found[1] == pytest.approx(found[0], abs=1e-9)
    assert said == [False, False, True]
