"""Pressure that a plant commands: work, wrench, linear column, reduced, compiled and batched models, a case file."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import tautflex as tf
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.solvers.transient.problem import TransientProblem
from verification.dynamic_cases import moved, small_antenna, soft_film

# Beside the hub, so that pressure turns it.
BODY = {"mass": 20.0, "inertia": (4.0, 5.0, 6.0), "center": (0.1, -0.05, 0.2)}
SENSORS = {"attitude": tf.Attitude(), "w": tf.Displacement([(0.7, 0.6), (0.4, 0.5)])}
POINTS = {"w": tf.Displacement([(0.7, 0.6), (0.4, 0.5)])}


@cache
def film():
    return tf.solve_prestress(moved(soft_film().model, np.eye(3), np.array([0.5, 0.4, 0.0])))


@cache
def rom():
    return tf.reduce(film(), tf.ModalBasis(count=6, candidates=30))


@cache
def antenna():
    """Whose film has free edges, so that its turning changes the push."""
    return tf.solve_prestress(moved(small_antenna(), np.eye(3), np.array([0.5, 0.4, 0.0])))


def breathe(plant, size: float, intervals: int = 20):
    """Measurements under a pressure that swells and changes its sign, shape (interval + 1, outputs)."""
    seen = [plant.reset(seed=0)]
    seen += [np.array(plant.step([size * np.sin(0.4 * k)])) for k in range(intervals)]
    return np.array(seen)


def test_slopes_of_the_wrench_are_those_of_differences():
    load, vectors = PressureLoad(antenna(), 2.0), np.random.default_rng(3).normal(size=(2, antenna().system.size))
    slopes, step = load.wrench_slopes(vectors), 1e-6
    for column, vector in zip(slopes.T, vectors, strict=True):
        differences = (load.wrench(step * vector) - load.wrench(-step * vector)) / (2.0 * step)
        np.testing.assert_allclose(column, differences, rtol=1e-7, atol=1e-7 * np.abs(slopes).max())


@pytest.mark.slow
def test_work_of_a_commanded_pressure_is_the_energy_gained(verification_row):
    plant = tf.Plant(film(), None, {"press": tf.Pressure()}, POINTS, method=tf.EnergyConserving(), time_step=2.5e-3)
    breathe(plant, 3.0)
    data = plant.run.data
    gained = float(data.kinetic_energy[-1] + data.strain_energy[-1])
    off = abs(plant.energy_by_source["press"] / gained - 1.0)
    verification_row("pressure as an actuator: its work / energy gained - 1", 0, off, "conservation")
    assert off < 1e-8
    assert abs(plant.run.energy_balance["residual"]) < 1e-8 * gained


@pytest.mark.slow
def test_work_of_a_commanded_pressure_on_a_free_hub_converges():
    off = []
    for step in (5e-3, 2.5e-3):
        plant = tf.Plant(film(), tf.FreeHub(**BODY), {"press": tf.Pressure()}, SENSORS, time_step=step)
        breathe(plant, 3.0)
        work = plant.energy_by_source["press"]
        off.append(abs(plant.run.energy_balance["loads"] / work - 1.0))
    assert off[1] < 1e-3
    assert np.log2(off[0] / off[1]) > 1.7


@pytest.mark.slow
def test_the_linear_column_is_the_static_answer():
    """And what a held pressure does to the stiffness is what frequencies tell."""
    plant = tf.Plant(film(), None, {"press": tf.Pressure()}, POINTS)
    view, push = plant.linearize(12), 1e-4
    gain = view.D - view.C @ np.linalg.solve(view.A, view.B)
    q = tf.solve_static(film(), pressure=PressureLoad(film(), push))
    seen = plant._prepared["w"].rows.displacement @ q / push
    np.testing.assert_allclose(gain[:, 0], seen, rtol=1e-6)
    table = plant.authority(modes=3)
    assert abs(table.force.values[0, 0]) > 0.1
    assert not table.attrs["remarks"]
    bound, held, step = {"press": tf.Pressure().prepare(film().system)}, 20.0, 0.05
    squares = [
        (2.0 * np.pi * tf.authority(film(), bound, values={"press": held + way}, modes=3).frequency.values) ** 2
        for way in (step, -step)
    ]
    about = tf.linearize(film(), bound, {}, values={"press": held}, modes=3)
    np.testing.assert_allclose(np.diag(about.bilinear[0]), (squares[0] - squares[1]) / (2.0 * step), rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["x", "free"])
def test_reduced_and_compiled_plants_are_the_full_one(axes, verification_row):
    hub, given = tf.FreeHub(**BODY, axes=axes), {"time_step": 2.5e-3}
    plants = [tf.Plant(model, hub, {"press": tf.Pressure()}, SENSORS, **given) for model in (film(), rom())]
    plants.append(tf.CompiledPlant(rom(), hub, {"press": tf.Pressure()}, SENSORS, **given))
    full, reduced, compiled = (breathe(plant, 0.3) for plant in plants)
    off = np.abs(reduced - full).max(axis=0)[[0, -1]] / np.abs(full).max(axis=0)[[0, -1]]
    verification_row(f"commanded pressure, hub {axes}: reduced against full", 0, float(off.max()), "full model")
    assert off.max() < 1e-2
    np.testing.assert_allclose(compiled, reduced, rtol=1e-9, atol=1e-9 * np.abs(reduced).max())
    work = plants[1].energy_by_source["press"]
    np.testing.assert_allclose(plants[2].work[0, 0], work, rtol=1e-9)
    np.testing.assert_allclose(plants[0].energy_by_source["press"], work, rtol=2e-2)


@cache
def antenna_rom():
    return tf.reduce(antenna(), tf.ModalBasis(count=8, candidates=40))


def test_film_with_free_edges_turns_the_push_of_a_reduced_model():
    """Its wrench is that of the full one to the first degree."""
    push, still = tf.Pressure(2.0), np.zeros(antenna().system.size)
    question = {"inputs": [push], "time_step": 1e-3, "end_time": 1e-2, "method": tf.CentralDifference()}
    run = HubRun(antenna_rom(), TransientProblem.asked(antenna_rom(), tf.FreeHub(**BODY), question))
    kept, film = antenna_rom().basis.kept, push.prepare(antenna().system).follower(0.0)
    eta = np.random.default_rng(1).normal(size=len(kept))
    eta *= 1e-3 / np.abs(eta @ kept).max()
    wrench, slopes = run.pushed_by(film)
    np.testing.assert_allclose(wrench, film.wrench(still), rtol=1e-12, atol=1e-14)
    wanted = 0.5 * (film.wrench(eta @ kept) - film.wrench(-eta @ kept))
    assert np.abs(wanted).max() > 1e-6
    np.testing.assert_allclose(slopes @ eta, wanted, rtol=0.0, atol=1e-3 * np.abs(wanted).max())
    given = run.inputs_at(np.zeros(1), np.inf)
    np.testing.assert_allclose(given.wrench[0], wrench, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(given.arms[0], slopes, rtol=1e-12, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("axes", ["x", "free"])
def test_work_on_a_reduced_antenna_is_what_it_gains(axes):
    hub, given = tf.FreeHub(**BODY, axes=axes), {"time_step": 1e-3}
    plant = tf.Plant(antenna_rom(), hub, {"press": tf.Pressure()}, SENSORS, **given)
    seen = breathe(plant, 0.05)
    assert abs(plant.energy_by_source["press"] / plant.run.energy_balance["loads"] - 1.0) < 1e-6
    compiled = tf.CompiledPlant(antenna_rom(), hub, {"press": tf.Pressure()}, SENSORS, **given)
    np.testing.assert_allclose(breathe(compiled, 0.05), seen, rtol=1e-8, atol=1e-9 * np.abs(seen).max())


@pytest.mark.slow
def test_uneven_pressure_pushes_a_reduced_model_on_a_hub():
    count = film().model.membrane_count
    given = {"time_step": 2.5e-3, "end_time": 0.1, "probes": {"mid": (0.5, 0.4)}}
    one, each = (
        tf.simulate(rom(), tf.FreeHub(**BODY), inputs=[tf.Pressure(values)], **given).data
        for values in (0.2, np.full(count, 0.2))
    )
    np.testing.assert_allclose(one.hub_position.values, each.hub_position.values, rtol=1e-12, atol=1e-18)
    full = tf.simulate(film(), tf.FreeHub(**BODY), inputs=[tf.Pressure(0.2)], **given).data
    np.testing.assert_allclose(one.hub_position.values[-1], full.hub_position.values[-1], rtol=1e-2)


@pytest.mark.jax
@pytest.mark.slow
@pytest.mark.parametrize("hub", [None, tf.FreeHub(**BODY, axes="x")], ids=["held", "free"])
def test_batches_have_pressure(hub):
    given = {"time_step": 2.5e-3, "end_time": 0.05, "method": tf.CentralDifference(), "probes": {"mid": (0.5, 0.4)}}
    batch = tf.Batch(rom()).simulate({"inputs.1": [1.0, 2.0]}, hub, inputs=[tf.Pressure(0.1)], **given)
    for row, factor in enumerate((1.0, 2.0)):
        wanted = tf.simulate(rom(), hub, inputs=[tf.Pressure(0.1 * factor)], **given).data
        found = batch.w.values[row]
        np.testing.assert_allclose(found, wanted.w.values, rtol=1e-9, atol=1e-9 * np.abs(found).max())
    with pytest.raises(tf.UnsupportedError, match=r"inputs: .*got Pressure; reduce\(state\) first"):
        tf.Batch(film()).simulate({}, inputs=[tf.Pressure(0.1)], **{**given, "method": tf.Newmark()})


@pytest.mark.slow
def test_pressure_against_the_flow_through_the_film_takes_energy_out(verification_row):
    """p = -g dV/dt has the power -g (dV/dt)^2: what it takes is what a film that was blown at loses."""
    state = soft_film((6, 6))
    inner = [(x, y) for x in np.linspace(-1.0, 1.0, 7)[1:-1] / 2.0 for y in np.linspace(-0.4, 0.4, 7)[1:-1]]
    struck = tf.Pressure(tf.TimeTable([0.0, 0.02, 0.02, 1.0], [0.1, 0.1, 0.0, 0.0]))
    given = {"interval": 2e-3, "time_step": 1e-3, "method": tf.EnergyConserving(), "inputs": [struck]}
    plant = tf.Plant(state, None, {"press": tf.Pressure()}, {"rate": tf.Velocity(inner)}, **given)
    seen, area = plant.reset(seed=0), 0.8 / 36.0
    for _ in range(300):
        seen = plant.step([-8.0 * area * seen.sum()])
    data, taken = plant.run.data, plant.energy_by_source["press"]
    left = float(data.kinetic_energy[-1] + data.strain_energy[-1])
    blown = plant.run.energy_balance["loads"] - taken
    off = abs((left - taken) / blown - 1.0)
    verification_row("pressure against the flow: energy left and taken / energy of a blow - 1", 0, off, "conservation")
    assert off < 1e-7
    # The same loop of the linear view; 12 modes would keep 0.18 of it.
    view = plant.linearize(40)
    held, now, work = view.discretize(2e-3), np.zeros(80), 0.0
    swept = view.B[40:, 0] @ np.eye(40, 80)  # volume per coordinate
    for number in range(300):
        blow, before = 0.1 * (number < 10), swept @ now
        now = held.A @ now + held.B[:, 0] * (blow - 8.0 * area * (view.C @ now).sum())
        work += blow * (swept @ now - before)
    stiff = np.append(-np.diag(view.A[40:, :40]), np.ones(40))
    expected = float(0.5 * stiff @ now**2 / work)
    verification_row(
        "pressure against the flow: part of the energy that is left", expected, left / blown, "linear loop"
    )
    assert left / blown == pytest.approx(expected, rel=0.01)
