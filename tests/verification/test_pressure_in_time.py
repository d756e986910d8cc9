"""Pressure as an input in time: against statics, conservation of energy and momentum, a case file."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case
from tautflex.mechanics.system import StructuralSystem
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from verification.builders import FILM, FILM_CASE, THICKNESS, unstressed
from verification.test_pressure import long_strip

HUB = {"mass": 3.0, "inertia": (4.0, 5.0, 6.0)}


def film(strain: str = "green-lagrange", law: str = "elastic", shape: str = "triangle3"):
    section = tf.MembraneSection(FILM, THICKNESS, strain, law)
    layout = AntennaLayout(2.0, 1.0, (6, 4), "alternating", element=shape)
    return tf.solve_prestress(build_fixed_film(layout, section, (4e3, 3e3, 0.0)))


def test_a_damped_run_ends_in_the_static_shape(verification_row):
    """Strip with two free edges, pressure that rises to its value: all that is left is statics."""
    state = tf.solve_prestress(long_strip()[0])
    static = state.system.translations(tf.solve_static(state, pressure=tf.PressureLoad(state.system, 500.0)))
    rising = tf.Pressure(tf.TimeTable([0.0, 1.0], [0.0, 500.0]))
    run = tf.simulate(
        state,
        method=tf.GeneralizedAlpha(0.0),
        time_step=0.1,
        end_time=30.0,
        damping=tf.Rayleigh(20.0, 0.0),
        inputs=[rising],
        fields=[30.0],
    )
    found = run.data.displacement.values[-1]
    error = float(np.abs(found - static).max() / np.abs(static).max())
    assert error < 1e-6
    verification_row("strip under pressure, free edges: settled run against statics", 0, error, "same equations")


@pytest.mark.parametrize("shape", ["triangle3", "triangle6", "quad4"])
def test_work_of_a_constant_pressure_is_the_energy_gained(shape, verification_row):
    """Held edge: the work is pressure times the volume that the film sweeps, and this method gives nothing away."""
    state, pressure = film(shape=shape), 0.5
    run = tf.simulate(
        state,
        method=tf.EnergyConserving(),
        time_step=5e-3,
        end_time=0.5,
        inputs=[tf.Pressure(pressure)],
        fields="all",
    )
    data, load = run.data, tf.PressureLoad(state.system, pressure)
    place = state.system.model.translation_dofs.ravel()
    moved = np.zeros((data.sizes["time"], state.model.dof_count))
    moved[:, place] = data.displacement.values.reshape(len(moved), -1)
    work = np.array([load.work(q) for q in moved[:, state.model.free_dofs]])
    error = float(np.abs(data.kinetic_energy + data.strain_energy - work).max() / np.abs(work).max())
    assert error < 1e-9
    verification_row(f"{shape} film struck by constant pressure: energy less work", 0, error, "conservation")


@pytest.mark.slow
def test_pressure_pushes_a_free_spacecraft(verification_row):
    """The film's edge is held by the hub, so its area along z stays: momentum is p A t, and work is energy gained."""
    state, pressure, errors = film(), 0.5, []
    for step in (2e-3, 1e-3):
        data = tf.simulate(
            state,
            tf.FreeHub(**HUB),
            method=tf.Newmark(),
            time_step=step,
            end_time=0.2,
            inputs=[tf.Pressure(lambda time: pressure * np.sin(20.0 * time))],
        ).data
        impulse = pressure * 2.0 * (1.0 - np.cos(20.0 * data.time.values)) / 20.0
        momentum = data.linear_momentum.values
        gained = data.kinetic_energy.values + data.strain_energy.values
        scale = np.abs(gained).max()
        errors.append(
            [np.abs(momentum[:, 2] - impulse).max() / impulse.max(), np.abs(gained - data.work.values).max() / scale]
        )
        assert np.abs(momentum[:, :2]).max() < 1e-12 * impulse.max()
        assert np.abs(data.angular_momentum.values).max() < 1e-10 * impulse.max()
    orders = np.log2(np.array(errors[0]) / errors[1])
    assert max(errors[1]) < 1e-3
    np.testing.assert_allclose(orders, 2.0, atol=0.3)
    verification_row("pressure on a free spacecraft, momentum against p A t: order", 2, float(orders[0]), "impulse")
    verification_row("pressure on a free spacecraft, energy gained against work: order", 2, float(orders[1]), "work")


def bag() -> tf.Model:
    """Pillow of two sheets around a point that the hub holds."""
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.3], [0.5, 0.5, -0.3]], dtype=float)
    triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]]
    section = tf.MembraneSection(FILM, THICKNESS, "green-lagrange")
    return tf.Model.from_mesh(nodes, triangles=triangles, membrane=section, supports=(tf.Support.pinned([0, 1, 3]),))


def test_pressure_inside_a_closed_film_moves_nobody(verification_row):
    """Forces on held nodes count as well: hub and bag keep their momenta."""
    state = unstressed(bag())
    data = tf.simulate(
        state,
        tf.FreeHub(**HUB, angular_velocity=(0.1, -0.2, 0.3)),
        method=tf.Newmark(),
        time_step=1e-4,
        end_time=0.02,
        inputs=[tf.Pressure(50.0)],
        probes={"A": (0.5, 0.5, 0.3)},
    ).data
    assert float(np.abs(data.w).max()) > 1e-5
    turn = data.angular_momentum.values
    push = 50.0 * 0.02  # impulse on one sheet
    error = float(
        max(np.abs(data.linear_momentum - data.linear_momentum[0]).max(), np.abs(turn - turn[0]).max()) / push
    )
    assert error < 1e-12
    verification_row("pressure in a bag on a free hub: change of its momenta / impulse", 0, error, "Gauss's theorem")


SHAKEN = {"end_time": 0.1, "inputs": [tf.Pressure(lambda t: 0.5 * np.cos(30.0 * t))], "probes": {"A": (0.2, 0.1)}}


@pytest.fixture(scope="module")
def shaken():
    state = film("von-karman")
    return state, tf.simulate(state, method=tf.Newmark(), time_step=5e-5, every=20, **SHAKEN).data.w.values


@pytest.mark.slow
@pytest.mark.parametrize(
    "method",
    [tf.WilsonTheta(), tf.GeneralizedAlpha(0.8), tf.Bathe(), tf.CentralDifference()],
    ids=lambda method: method.name,
)
def test_methods_agree_under_pressure(shaken, method, verification_row):
    step = 2e-5 if isinstance(method, tf.CentralDifference) else 2e-4
    found = tf.simulate(shaken[0], method=method, time_step=step, every=round(1e-3 / step), **SHAKEN).data.w.values
    error = float(np.abs(found - shaken[1]).max() / np.abs(shaken[1]).max())
    assert error < 5e-3
    verification_row(
        f"film under pressure in time, {method.name}: w against fine steps", "< 5e-3", error, "Newmark", ""
    )


def test_a_jump_of_pressure_is_stepped_onto(verification_row):
    state, jump, ends = film("von-karman"), 0.0331, []
    push = tf.Pressure(lambda time: 0.5 if time >= jump else 0.0, breaks=(jump,))
    for step in (2e-3, 1e-3, 5e-4, 1.25e-4):
        given = {"time_step": step, "end_time": 0.08, "inputs": [push], "probes": {"A": (0.2, 0.1)}, "tolerance": 1e-9}
        ends.append(float(tf.simulate(state, method=tf.Newmark(), **given).data.w[-1, 0]))
    errors = np.abs(np.array(ends[:3]) - ends[3])
    order = float(np.log2(errors[1] / errors[2]))
    assert order == pytest.approx(2.0, abs=0.3)
    verification_row("jump of pressure inside a step: order", 2, order, "second order")


def test_pressure_in_a_case_file():
    """The built-in mesh faces +z; a table, and a key that is wrong."""
    section = '[inputs.sun]\nkind = "pressure"\npressure = '
    run = tf.run_case(parse_case(FILM_CASE + section + "9e-6\n"))
    assert float(run.data.w[-1, 0]) > 0.0
    table = tf.run_case(parse_case(FILM_CASE + section + "{ times = [0.0, 0.1], values = [0.0, 9e-6] }\n"))
    assert 0.0 < float(table.data.w[3, 0]) < float(run.data.w[3, 0])
    with pytest.raises(tf.CaseError, match=r"inputs\.sun\.pressure: expected shape \(32\), got \(2,\)"):
        tf.run_case(parse_case(FILM_CASE + section + "[1.0, 2.0]\n"))
    reduced = tf.run_case(parse_case(FILM_CASE + section + "9e-6\n[reduction]\ncount = 4\n"))
    assert float(reduced.data.w[-1, 0]) == pytest.approx(float(run.data.w[-1, 0]), rel=0.1)


def test_what_cannot_follow_the_film_says_so():
    state = film("von-karman")
    with pytest.raises(tf.InputError, match="pressure: expected one finite number at t = 0 s, got nan"):
        tf.simulate(state, time_step=1e-3, end_time=2e-3, inputs=[tf.Pressure(np.nan)])
    with pytest.raises(tf.InputError, match=r"pressure: expected numbers at t = 0 s, got 'high'"):
        tf.simulate(state, time_step=1e-3, end_time=2e-3, inputs=[tf.Pressure(lambda time: "high")])
    for maneuver in (None, tf.FreeHub(**HUB)):
        with pytest.raises(tf.NotConvergedError, match="step failed"):  # and no warning of numpy's
            tf.simulate(state, maneuver, time_step=1e-3, end_time=2e-3, inputs=[tf.Pressure(1e200)])
    cable = tf.Model.from_mesh(np.eye(3)[:2], cables=[[0, 1]], cable=tf.CableSection(tf.Material(1.0, 1.0), 1.0))
    with pytest.raises(tf.InputError, match="pressure: expected a model with a film"):
        tf.Pressure(1.0).prepare(StructuralSystem.from_model(cable))
