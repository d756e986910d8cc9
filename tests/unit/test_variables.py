"""Every variable of every Dataset has its dimensions, units and words from the one table."""

from __future__ import annotations

import pytest

import tautflex as tf
from tautflex.solvers import variables
from tautflex.solvers.variables import about, mesh_variables
from verification.dynamic_cases import small_antenna

STEPS = {"time_step": 2e-3, "end_time": 0.04, "probes": {"A": (0.6, 0.3)}}
# Labels of rows and columns, which are no quantities.
LABELS = {
    "probe", "component", "mode", "direction", "other_direction", "branch", "run", "quaternion",
}  # fmt: skip


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def modes(state):
    return tf.solve_modes(state, n=4)


@pytest.fixture(scope="module")
def run(state):
    return tf.simulate(state, tf.Stop(0.3, 0.02), fields="all", **STEPS)


def test_runs_hub_runs_and_reduced_runs(state, run):
    check(run.data, variables.RUN, mesh_variables(state.model))
    hub = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), angular_velocity=(0.1, 0.0, 0.0))
    check(tf.simulate(state, hub, **STEPS).data, variables.HUB, mesh_variables(state.model))
    rom = tf.reduce(state, tf.ModalBasis(directions=("rx",), count=3))
    check(tf.simulate(rom, tf.Stop(0.3, 0.02), **STEPS).data, variables.REDUCED_RUN, mesh_variables(state.model))


@pytest.mark.jax
def test_batches(state):
    rom = tf.reduce(state, tf.ModalBasis(directions=("rx",), count=1))
    data = tf.Batch(rom).simulate(
        {"maneuver.rate": [0.3, 0.2]}, tf.Stop(0.3, 0.02), method=tf.CentralDifference(), **STEPS
    )
    check(data, variables.BATCH, also={"maneuver.rate"})


def test_modes_spinning_modes_and_appendages(state, modes):
    check(modes.data, variables.MODES, mesh_variables(state.model))
    spin = (0.1, 0.0, 0.0)
    check(tf.solve_spinning_modes(state, spin, n=3).data, variables.SPINNING_MODES, mesh_variables(state.model))
    check(tf.campbell(state, [0.0, 0.1], n=3), variables.CAMPBELL)
    check(tf.appendage_data(modes), variables.APPENDAGE)


def test_analyses_of_a_record(modes, run):
    record = run.data.w.sel(probe="A")
    check(tf.spectrum(record), variables.SPECTRUM, units="m", name="w")
    check(tf.scalogram(record), variables.SCALOGRAM, units="m", name="w")
    ours = tf.pod(run.data, modes=2)
    assert ours["shape"].dims == ("mode", "node", "component")
    assert ours["coefficient"].dims == ("field_time", "mode")
    for name in ("shape", "value", "participation", "cumulative", "coefficient", "mode"):
        assert ours[name].attrs == about(variables.POD[name], units="m")
    check(tf.mac_table(tf.dominant_shape(ours, energy=0.5), modes.to_dataset()), variables.MAC)


def check(data, table, mesh=None, also=(), **record):
    known = {**{name: (v.dims, about(v, **record)) for name, v in table.items()}}
    known |= {name: (dims, attrs) for name, (dims, _, attrs) in (mesh or {}).items()}
    assert set(data.variables) - set(known) - LABELS - set(also) == set()
    for name, variable in data.variables.items():
        if name not in known:
            assert not variable.attrs
            continue
        dims, attrs = known[name]
        assert variable.dims == dims
        assert {key: variable.attrs.get(key) for key in attrs} == attrs
        assert set(variable.attrs) - set(attrs) <= {"flag_values", "flag_meanings", "comment"}
