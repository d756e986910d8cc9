"""Batches against single runs, and their derivatives against finite differences of single runs."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tautflex as tf
from tautflex import NotConvergedError
from tautflex.batch import Response, final_energy, history, peak, residual_energy, residual_rms
from verification.batch_cases import changed_rom, changed_state, damping_of, stop_of
from verification.dynamic_cases import small_antenna

pytestmark = pytest.mark.jax
PROBES = {"A": (0.6, 0.3), "B": (-0.2, 0.1)}
VARIABLES = ("u", "v", "w", "u_velocity", "w_velocity", "kinetic_energy", "strain_energy")
# The stops end between two instants of the grid.
NUMBERS = {
    "tension_x": 1.1,
    "tension_y": 0.9,
    "youngs_modulus.membrane": 1.2,
    "youngs_modulus.cable": 0.8,
    "youngs_modulus.beam": 1.05,
    "density.membrane": 0.95,
    "density.beam": 1.1,
    "damping.alpha": 0.3,
    "damping.beta": 2e-3,
    "maneuver.rate": 0.5,
    "maneuver.duration": 0.0312,
}
# Compiling takes longer than these runs: hardly optimised code is good enough.
QUICKLY = {"xla_backend_optimization_level": 0}


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def rom(state):
    # Fields that are fixed before parameters change leave nothing out when they are all there.
    return tf.reduce(state, tf.ModalBasis(directions=("rx",), count=3), weak_field=0.0)


def _options(**more):
    return {"time_step": 2e-3, "end_time": 0.08, "probes": PROBES, "tolerance": 1e-11, **more}


def _single(plant, numbers, options):
    changed = changed_rom if hasattr(plant, "projection") else changed_state
    return tf.simulate(changed(plant, numbers), stop_of(numbers), damping=damping_of(numbers), **options).data


def _difference(one, other) -> float:
    return max(float(np.abs(one[name] - other[name]).max() / np.abs(other[name]).max()) for name in VARIABLES)


def _worst_run(data, plant, table, options):
    """Largest difference of the runs of a batch to single runs with their numbers."""
    runs = range(data.sizes["run"])
    rows = [{name: float(values[run]) for name, values in table.items()} for run in runs]
    return max(_difference(data.isel(run=run), _single(plant, rows[run], options)) for run in runs)


def _table(count):
    """Runs between the nominal numbers and those above."""
    nominal = {**dict.fromkeys(NUMBERS, 1.0), "damping.alpha": 0.1, "damping.beta": 1e-3}
    nominal |= {"maneuver.rate": 0.6, "maneuver.duration": 0.04}
    share = np.linspace(0.0, 1.0, count)
    return {name: nominal[name] + share * (NUMBERS[name] - nominal[name]) for name in NUMBERS}


def test_batch_of_reduced_model_is_the_single_runs(rom, verification_row):
    options, table = _options(method=tf.Newmark()), _table(3)
    batch = tf.Batch(rom)
    data = batch.simulate(table, tf.Stop(0.6, 0.04), chunk=2, **options)
    assert data.sizes["run"] == 3
    worst = _worst_run(data, rom, table, options)
    assert worst < 1e-9
    verification_row("batch of a reduced model, 3 runs with 11 parameters, Newmark", 0, worst, "single runs")
    assert set(data.status.values) == {"completed"}
    assert data.maneuver_end.values == pytest.approx(table["maneuver.duration"])

    # A run that cannot converge is labelled, and the others do not notice.
    hopeless = {name: values.copy() for name, values in table.items()}
    hopeless["maneuver.rate"][2] = 1e9
    with pytest.raises(NotConvergedError, match="1 of 3 runs") as raised:
        batch.simulate(hopeless, tf.Stop(0.6, 0.04), chunk=2, **options)
    kept = raised.value.result
    assert kept.status.values.tolist() == ["completed", "completed", "not-converged"]
    assert np.array_equal(kept.w[:2], data.w[:2])
    assert np.isnan(kept.w[2]).any()

    # Nor does it matter how many run side by side.
    together = batch.simulate(table, tf.Stop(0.6, 0.04), chunk=3, **options)
    sizes = _difference(together, data)
    assert sizes < 1e-10
    verification_row("batch sizes 2 and 3 of a reduced model", 0, sizes, "each other")


def test_central_differences_of_reduced_model_are_the_single_runs(rom, verification_row):
    options, table = _options(method=tf.CentralDifference(), tolerance=None), _table(3)
    batch = tf.Batch(rom)
    data = batch.simulate(table, tf.Stop(0.6, 0.04), chunk=2, **options)
    assert data.sizes["run"] == 3
    worst = _worst_run(data, rom, table, options)
    assert worst < 1e-9
    verification_row("batch of a reduced model, 3 runs, 11 parameters, central differences", 0, worst, "single runs")

    # A stiffer run is not stable; the others do not notice.
    stiff = {name: values.copy() for name, values in table.items()}
    stiff["tension_x"][2] = stiff["tension_y"][2] = 1e3
    with pytest.raises(NotConvergedError, match="1 of 3 runs") as raised:
        batch.simulate(stiff, tf.Stop(0.6, 0.04), chunk=2, **options)
    kept = raised.value.result
    assert kept.status.values.tolist() == ["completed", "completed", "not-converged"]
    assert np.array_equal(kept.w[:2], data.w[:2])
    assert np.isnan(kept.w[2]).all()

    # One that starts stable and becomes too stiff, where the single run halves its steps, ends on its way.
    hard = {"maneuver.rate": [0.6, 2.0], "damping.beta": 2e-3}
    ended = batch.simulate(hard, tf.Stop(0.6, 0.04), throw=False, **options)
    assert ended.status.values.tolist() == ["completed", "not-converged"]
    assert 0 < np.isfinite(ended.w[1, :, 0]).sum() < ended.time.size
    assert tf.simulate(rom, tf.Stop(2.0, 0.04), damping=tf.Rayleigh(0.0, 2e-3), **options).stats.halvings > 0


@pytest.mark.parametrize(("method", "limit"), [(tf.CentralDifference(), 1e-5), (tf.Newmark(), 1e-3)])
def test_single_precision_tells_its_error(rom, method, limit, verification_row):
    """The error that a result tells is that of its runs to a batch in double precision."""
    options, table = {**_options(method=method), "tolerance": None}, _table(4)
    double = tf.Batch(rom).simulate(table, tf.Stop(0.6, 0.04), **options)
    single = tf.Batch(rom, precision="single").simulate(table, tf.Stop(0.6, 0.04), **options)
    assert single.w.dtype == np.float32
    assert not any("single precision" in words for words in single.attrs["warnings"])
    runs = single.attrs["runs_in_double_precision"]
    assert runs == [0, 2, 3]
    groups = {"displacement": ["u", "v", "w"], "energy": ["kinetic_energy", "strain_energy"]}
    for group, names in groups.items():
        apart, largest = (
            np.abs(data.isel(run=runs).to_array().transpose("run", ...).values).reshape(3, -1).max(axis=1)
            for data in (single[names] - double[names], double[names])
        )
        told = single.attrs[f"single_precision_error_{group}"]
        assert told == pytest.approx(float((apart / largest).max()), rel=0.05, abs=1e-7)
        assert 0.0 < told < limit
        verification_row(f"batch in single precision, {method.name}: {group}", 0, told, "double precision")


def test_fixed_stress_fields_cost_less_than_the_truncation_of_the_single_run(state, verification_row):
    options = _options(method=tf.Newmark())
    every, few = (tf.reduce(state, tf.ModalBasis(directions=("rx",), count=6), weak_field=w) for w in (0.0, 1e-4))
    assert len(few.fields[0]) < len(every.fields[0])
    numbers = {name: values[1:] for name, values in _table(2).items()}
    one = {name: float(values[0]) for name, values in numbers.items()}
    data = tf.Batch(few).simulate(numbers, tf.Stop(0.6, 0.04), **options).isel(run=0)
    exact, own = _single(every, one, options), _single(few, one, options)
    truncation, fixed = _difference(own, exact), _difference(data, exact)
    verification_row("stress fields of unchanged parameters over those of the run's own", 0, fixed, "all fields")
    assert fixed < 3.0 * truncation


def test_batch_of_full_model_is_the_single_runs(state, verification_row):
    options, table = _options(method=tf.GeneralizedAlpha(0.8)), _table(2)
    data = tf.Batch(state).simulate(table, tf.Stop(0.6, 0.04), **options)
    assert data.sizes["run"] == 2
    worst = _worst_run(data, state, table, options)
    assert worst < 1e-8
    verification_row("batch of the full model, 2 runs with 11 parameters, generalized-alpha", 0, worst, "single runs")


def _measures_of(data, numbers, start):
    """Measures of a single run, written down again."""
    time, w = data.time.values, data.w.sel(probe="A").values
    energy = (data.kinetic_energy + data.strain_energy).values
    share = np.clip((time - start) / (time[1] - time[0]) + 0.5, 0.0, 1.0)
    return np.array(
        [
            np.abs(w).max() * np.mean((np.abs(w) / np.abs(w).max()) ** 12.0) ** (1.0 / 12.0),
            np.sqrt(np.sum(share * w**2) / share.sum()),
            np.sum(share * energy) / share.sum(),
            energy[-1],
        ]
    )


def _measures(response):
    return jnp.stack(
        [
            peak(response, sharpness=12.0),
            residual_rms(response),
            residual_energy(response),
            final_energy(response),
        ]
    )


# Relative: differences of fourth order then leave less than 1e-6 even where derivatives of two kinds almost cancel.
_STEP = 1e-3


def _finite_differences(plant, options, name):
    def at(steps):
        numbers = {**NUMBERS, name: NUMBERS[name] * (1.0 + steps * _STEP)}
        return _measures_of(_single(plant, numbers, options), numbers, numbers["maneuver.duration"])

    slope = (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * _STEP)
    return slope / NUMBERS[name]


def _check_gradients(plant, jacobian, options, names):
    worst = 0.0
    for name in names:
        expected, got = _finite_differences(plant, options, name), np.asarray(jacobian[name])
        worst = max(worst, float(np.abs(got / expected - 1.0).max()))
    return worst


def test_reverse_gradients_of_reduced_model(rom, verification_row):
    options = _options(method=tf.WilsonTheta(), tolerance=1e-12)
    respond = tf.Batch(rom).response(tf.Stop(0.6, 0.04), **options)
    value = _measures(jax.jit(respond, compiler_options=QUICKLY)(NUMBERS))
    single = _measures_of(_single(rom, NUMBERS, options), NUMBERS, NUMBERS["maneuver.duration"])
    assert np.asarray(value) == pytest.approx(single, rel=1e-9)
    jacobian = jax.jit(jax.jacrev(lambda numbers: _measures(respond(numbers))), compiler_options=QUICKLY)(NUMBERS)
    worst = _check_gradients(rom, jacobian, options, NUMBERS)
    assert worst < 1e-6
    verification_row("reverse gradients of 4 measures, reduced model, 11 parameters", 0, worst, "finite differences")


def test_gradients_of_central_differences(rom, verification_row):
    options = _options(method=tf.CentralDifference(), tolerance=None)
    respond = tf.Batch(rom).response(tf.Stop(0.6, 0.04), **options)
    worst = 0.0
    for kind in (jax.jacrev, jax.jacfwd):
        jacobian = jax.jit(kind(lambda numbers: _measures(respond(numbers))), compiler_options=QUICKLY)(NUMBERS)
        worst = max(worst, _check_gradients(rom, jacobian, options, NUMBERS))
    assert worst < 1e-6
    verification_row("gradients of 4 measures both ways, central differences, 11 parameters", 0, worst, "differences")


def test_forward_gradients_of_full_model(state, verification_row):
    options = _options(method=tf.Newmark(), end_time=0.05, tolerance=1e-12)
    respond = tf.Batch(state).response(tf.Stop(0.6, 0.04), **options)
    jacobian = jax.jit(jax.jacfwd(lambda numbers: _measures(respond(numbers))), compiler_options=QUICKLY)(NUMBERS)
    worst = _check_gradients(state, jacobian, options, NUMBERS)
    assert worst < 1e-6
    verification_row("forward gradients of 4 measures, full model, 11 parameters", 0, worst, "finite differences")


def test_history_of_a_response_is_its_displacement():
    response = Response(jnp.arange(3.0), jnp.arange(18.0).reshape(3, 2, 3), None, None, True, 0.0, 0.0)
    assert np.asarray(history(response, 1, "v")).tolist() == [4.0, 10.0, 16.0]
    assert float(peak(response, 1, "v")) == 16.0
    with pytest.raises(tf.InputError, match="component"):
        history(response, 0, "x")
    with pytest.raises(tf.InputError, match="energy"):
        final_energy(response)
