"""Inputs in time: forces, cable tension, temperature."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.structure.antenna import AntennaLayout, build_fixed_film

LENGTH, TENSION, ELEMENTS = 2.0, 10.0, 16
CABLE = tf.CableSection(tf.Material(1e9, 1000.0), 1e-5)


def string(tension: float = TENSION):
    nodes = np.column_stack([np.linspace(0.0, LENGTH, ELEMENTS + 1), np.zeros((ELEMENTS + 1, 2))])
    model = tf.Model.from_mesh(
        nodes,
        cables=np.column_stack([np.arange(ELEMENTS), np.arange(1, ELEMENTS + 1)]),
        cable=CABLE,
        cable_tension=tension,
        supports=(tf.Support.pinned([0, ELEMENTS]),),
    )
    return tf.solve_prestress(model)


def film(stress: float = 4e3):
    section = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4)
    return tf.solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (6, 4)), section, (stress, stress, 0.0)))


def pluck(x, y):
    return 0.01 * np.sin(np.pi * x / LENGTH)


def settle(state, inputs, **options):
    """Run with so much damping that only the static answer is left."""
    run = tf.simulate(
        state,
        method=tf.GeneralizedAlpha(0.0),
        time_step=0.05,
        end_time=20.0,
        damping=tf.Rayleigh(20.0, 0.0),
        inputs=inputs,
        **options,
    )
    return run.data


def test_point_force_on_a_string(verification_row):
    """Static deflection F L / (4 T) under a small force in the middle."""
    force = 1e-4
    data = settle(string(), [tf.NodalForce([ELEMENTS // 2], (0.0, 0.0, force))], probes={"M": (1.0, 0.0, 0.0)})
    found, exact = float(data.w[-1, 0]), force * LENGTH / (4 * TENSION)
    assert found == pytest.approx(exact, rel=1e-6)
    verification_row("string under a point force [m]", exact, found, "F L / (4 T)")


def test_line_force_on_a_string(verification_row):
    """Static deflection p L^2 / (8 T) in the middle of a parabola, exact at the nodes."""
    pressure = 1e-4
    inputs = [tf.EdgeForce(range(ELEMENTS + 1), lambda time: (0.0, 0.0, pressure))]
    data = settle(string(), inputs, probes={"M": (1.0, 0.0, 0.0)})
    found, exact = float(data.w[-1, 0]), pressure * LENGTH**2 / (8 * TENSION)
    assert found == pytest.approx(exact, rel=1e-6)
    verification_row("string under a line force [m]", exact, found, "p L^2 / (8 T)")


def test_added_tension_is_tension(verification_row):
    """A string with T0 plus an input of dT moves as one built with T0 + dT."""
    given = {"method": tf.Newmark(), "time_step": 1e-3, "end_time": 0.2, "initial_velocity": pluck, "fields": "all"}
    wanted = tf.simulate(string(1.4 * TENSION), **given).data.displacement.values
    found = tf.simulate(string(), inputs=[tf.CableTension(0.4 * TENSION)], **given).data.displacement.values
    gap = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    assert gap < 1e-9
    verification_row("string, tension as input against built in, relative", 0, gap, "same equations")


def test_temperature_relaxes_the_film(verification_row):
    """Held film: stress change -E alpha dT / (1 - nu)."""
    change, expansion = 0.3, 2e-6
    drop = 3.5e9 * expansion * change / (1.0 - 0.34)
    given = {"method": tf.Newmark(), "time_step": 2e-3, "end_time": 0.2, "fields": "all"}
    velocity = {"initial_velocity": lambda x, y: 0.02 * np.cos(np.pi * x / 2) * np.cos(np.pi * y)}
    wanted = tf.simulate(film(4e3 - drop), **given, **velocity).data.displacement.values
    inputs = [tf.MembraneTemperature(change, expansion)]
    found = tf.simulate(film(), inputs=inputs, **given, **velocity).data.displacement.values
    gap = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    assert gap < 1e-9
    assert drop > 1e3
    verification_row("film, temperature against stress -E a dT/(1-nu), relative", 0, gap, "thermoelasticity")


@pytest.mark.parametrize("method", [tf.WilsonTheta(), tf.GeneralizedAlpha(0.8), tf.Newmark()], ids=lambda m: m.name)
def test_a_jump_is_stepped_onto(method, verification_row):
    """Tension that jumps inside a step: second order as if the grid knew."""
    jump = 0.0331
    inputs = [tf.CableTension(lambda time: 0.5 * TENSION if time >= jump else 0.0, breaks=(jump,))]
    ends = []
    for step in (2e-3, 1e-3, 5e-4, 1.25e-4):
        options = {"time_step": step, "end_time": 0.1, "initial_velocity": pluck, "probes": {"M": (1.0, 0.0, 0.0)}}
        ends.append(float(tf.simulate(string(), method=method, inputs=inputs, tolerance=1e-9, **options).data.w[-1, 0]))
    errors = np.abs(np.array(ends[:3]) - ends[3])
    order = float(np.log2(errors[0] / errors[1]))
    assert order == pytest.approx(2.0, abs=0.25)
    verification_row(f"{method.name}, jump of tension inside a step: order", 2, order, "second order")


def test_inputs_add_up_and_are_taken_back():
    state = film()
    system, zero = state.system, np.zeros(state.system.size)
    before = system.force(zero)[0]
    pulls = [tf.NodalForce([8], (0.0, 0.0, 2.0)), tf.NodalForce([8], lambda time: (0.0, 0.0, time))]
    inputs = InputSet(
        system, [*pulls, tf.MembraneTemperature(lambda time: time, 2e-6), tf.MembraneTemperature(1.0, 1e-6)]
    )
    load, workspace = inputs.load(3.0), system.workspace()
    workspace.change_initial_stress(inputs.stress(3.0))
    assert load.sum() == pytest.approx(5.0)
    stress = -3.5e9 * (3.0 * 2e-6 + 1e-6) / (1.0 - 0.34)
    workspace.force(zero)
    np.testing.assert_allclose(workspace.stress[0][:, 0], 4e3 + stress, rtol=1e-12)
    workspace.change_initial_stress({})
    np.testing.assert_array_equal(workspace.force(zero)[0], before)
    np.testing.assert_allclose(workspace.stress[0][:, 0], 4e3, rtol=1e-12)
    np.testing.assert_array_equal(system.force(zero)[0], before)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: tf.NodalForce([999], (0.0, 0.0, 1.0)), "nodes"),
        (lambda: tf.NodalForce([8], (0.0, 1.0)), "force"),
        (lambda: tf.EdgeForce([1], (0.0, 0.0, 1.0)), "two nodes"),
        (lambda: tf.CableTension(1.0), "cables"),
        (lambda: tf.MembraneTemperature(np.nan, 1e-6), "finite"),
        (lambda: "pull", "inputs"),
    ],
)
def test_bad_inputs_are_named(make, words):
    with pytest.raises(InputError, match=words):
        tf.simulate(film(), time_step=1e-3, end_time=2e-3, inputs=[make()])


def test_cables_can_be_chosen():
    state = string()
    inputs = InputSet(state.system, [tf.CableTension([1.0, 2.0], cables=[3, 5])])
    workspace = state.system.workspace()
    workspace.change_initial_stress(inputs.stress(0.0))
    workspace.force(np.zeros(state.system.size))
    change = (workspace.stress[0][:, 0] * CABLE.area) - TENSION
    np.testing.assert_allclose(change[[3, 5]], [1.0, 2.0], rtol=1e-9)
    assert np.abs(np.delete(change, [3, 5])).max() < 1e-12
    with pytest.raises(InputError, match="numbers in"):
        InputSet(state.system, [tf.CableTension(1.0, cables=[99])])


def test_a_function_that_fails_on_the_way_leaves_what_was_computed():
    state, none = string(), float("nan")

    def push(failing):
        return [tf.NodalForce([8], failing, direction=(0.0, 0.0, 1.0))]

    with pytest.raises(InputError, match=r"force: expected numbers at t = 0\.05\d* s, the function failed \(ZeroDiv"):
        tf.simulate(state, inputs=push(lambda t: 1e-3 / (t < 0.05)), time_step=1e-3, end_time=0.1)
    with pytest.raises(tf.NotConvergedError, match=r"one finite number at t = 0\.05\d* s, got nan") as told:
        tf.simulate(state, inputs=push(lambda t: 1e-3 if t < 0.05 else none), time_step=1e-3, end_time=0.1)
    left = told.value.result
    whole = tf.simulate(state, inputs=push(1e-3), time_step=1e-3, end_time=left.reached)
    assert left.reached > 0.03
    np.testing.assert_array_equal(left.data.w, whole.data.w)
