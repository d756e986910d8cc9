"""A run that was cut and goes on is the whole one, to the last bit: methods, plants, places of the cut, files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError
from tautflex.solvers.transient.status import Status
from verification.dynamic_cases import small_antenna, soft_film, string

pytestmark = pytest.mark.slow

STOP = tf.Stop(rate=0.628, duration=0.0203)  # ends between two instants of the grid
HUB = tf.FreeHub(
    mass=20.0,
    inertia=(3.0, 4.0, 5.0),
    angular_velocity=(0.1, 0.02, 0.0),
    torque=lambda time, hub: (-2.0 * hub.angular_velocity[0], 0.0, 0.0),
)
METHODS = [tf.WilsonTheta(), tf.Newmark(), tf.GeneralizedAlpha(0.8), tf.Bathe(), tf.EnergyConserving()]
ASKED = {"damping": tf.Rayleigh(0.01, 1e-4), "probes": {"A": (0.3, 0.1)}, "time_step": 1e-3}
# What a reduced run looks at but at a few instants of its own record, and from many steps at once.
CHECKED = {"min_principal_resultant", "max_principal_resultant", "wrinkled_fraction", "slack_fraction", "slack_cables"}


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def reduced(antenna):
    return tf.reduce(antenna, tf.ModalBasis(count=6))


@pytest.fixture(scope="module")
def film():
    return soft_film()


def cut_and_whole(plant, maneuver, cut, end, path=None, **asked):
    """The two parts of a run that was cut, perhaps through a file, and the whole one."""
    asked = ASKED | asked
    first = tf.simulate(plant, maneuver, end_time=cut, **asked)
    if path is not None:
        tf.save(first, path)
        first = tf.load_run(path)
    second = tf.simulate(plant, maneuver, end_time=end, initial=first.final, **asked)
    return first, second, tf.simulate(plant, maneuver, end_time=end, **asked)


def differing(first, second, whole) -> list[str]:
    """Names of the histories that are not those of the whole run, bit by bit."""
    found = []
    for name, variable in whole.data.variables.items():
        for time in ("time", "field_time"):
            if time in variable.dims:
                parts = np.concatenate([first.data[name].values, second.data[name].values])
                if not np.array_equal(parts, variable.values, equal_nan=parts.dtype.kind == "f"):
                    found.append(name)
    return found


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("maneuver", [STOP, HUB], ids=["prescribed", "hub"])
def test_cut_runs_are_the_whole_one(antenna, maneuver, method, verification_row):
    """In the maneuver, and at its end, where the tangent has aged and the pairs are half full."""
    for cut in (0.007, 0.021):
        parts = cut_and_whole(antenna, maneuver, cut, 0.04, method=method, fields="all")
        assert differing(*parts) == []
        first, second, whole = parts
        assert second.energy_balance == whole.energy_balance
        assert second.error == whole.error
        assert first.stats.iterations + second.stats.iterations == whole.stats.iterations
    if maneuver is STOP:
        off = float(np.abs(second.data.w.values[-1] - whole.data.w.values[-1]).max())
        verification_row(f"{method.name}: cut run against the whole one [m]", 0.0, off, "to the bit")


@pytest.mark.parametrize("maneuver", [STOP, HUB], ids=["prescribed", "hub"])
@pytest.mark.parametrize("method", [tf.Newmark(), tf.Bathe()], ids=lambda method: method.name)
def test_adaptive_steps_go_on_through_a_file(antenna, maneuver, method, tmp_path):
    """The last steps lie beyond the cut, which no step lands on."""
    asked = {"method": method, "adaptive": tf.Adaptive(1e-3)}
    parts = cut_and_whole(antenna, maneuver, 0.012, 0.03, tmp_path / "run.nc", **asked)
    assert differing(*parts) == []
    assert parts[1].energy_balance == parts[2].energy_balance
    assert parts[1].error == parts[2].error


def test_explicit_steps_go_on(film):
    parts = cut_and_whole(film, STOP, 0.013, 0.04, method=tf.CentralDifference(), time_step=2e-4, every=5)
    assert differing(*parts) == []
    assert parts[1].error == parts[2].error


def test_halved_steps_go_on(tmp_path):
    """A string thrown in steps of a hundred of its periods halves every one of them."""
    state = string(8, tension=1e-3, modulus=1e6)
    asked = {"method": tf.Newmark(), "time_step": 0.1, "probes": None}
    thrown = asked | {"initial_velocity": lambda x, y: 100.0 * np.cos(1.5 * x)}
    whole, first = (tf.simulate(state, end_time=end, **thrown) for end in (0.4, 0.2))
    second = tf.simulate(state, end_time=0.4, initial=first.final, **asked)
    assert 0 < first.stats.halvings < whole.stats.halvings
    assert differing(first, second, whole) == []


@pytest.mark.parametrize("maneuver", [STOP, HUB], ids=["prescribed", "hub"])
def test_inputs_go_on(antenna, maneuver):
    """Tension that jumps at a cut and between two, and a part of the samples."""
    table = tf.TimeTable([0.0, 0.01, 0.01, 0.03], [1.0, 1.0, 1.2, 0.8])
    for cut, every in ((0.01, 1), (0.013, 3)):
        asked = {"method": tf.GeneralizedAlpha(0.8), "inputs": [tf.CableTension(table)], "every": every}
        parts = cut_and_whole(antenna, maneuver, cut, 0.03, **asked)
        assert differing(*parts) == []
        assert parts[1].energy_balance == parts[2].energy_balance


@pytest.mark.parametrize("method", [*METHODS, tf.CentralDifference()], ids=lambda method: method.name)
def test_reduced_runs_go_on_through_a_file(reduced, method, tmp_path):
    """In the maneuver, and inside a block of steps whose frame terms are sampled together."""
    for cut, every in ((0.007, 1), (0.6, 3)):
        parts = cut_and_whole(reduced, STOP, cut, max(0.04, 2.0 * cut), tmp_path / "run.nc", method=method, every=every)
        assert set(differing(*parts)) <= CHECKED
        assert parts[1].energy_balance == parts[2].energy_balance
        np.testing.assert_allclose(parts[1].error, parts[2].error, rtol=0.05)


@pytest.mark.slow
def test_hyper_reduced_runs_go_on():
    state = soft_film((3, 2))
    asked = {"time_step": 5e-3, "probes": {"A": (0.12, 0.1)}, "method": tf.GeneralizedAlpha(0.8)}
    throw = {"initial_velocity": lambda x, y: 2.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x)}
    training = tf.simulate(state, STOP, end_time=0.2, fields="all", **asked, **throw).data
    rom = tf.hyper_reduce(state, training, lost=(0.0, 0.0), tolerance=0.0)
    assert set(differing(*cut_and_whole(rom, STOP, 0.05, 0.2, **asked))) <= CHECKED


def test_one_state_starts_many_runs(film):
    asked = ASKED | {"method": tf.GeneralizedAlpha(0.8)}
    first = tf.simulate(film, STOP, end_time=0.01, **asked)
    one, other = (tf.simulate(film, STOP, end_time=0.03, initial=given, **asked) for given in (first.final, first))
    np.testing.assert_array_equal(one.data.w.values, other.data.w.values)
    assert one.data.time.values[0] == pytest.approx(0.011)
    assert one.data.attrs["resumed_from"] == first.final.time == first.reached


def test_another_method_or_step_starts_from_the_motion(film):
    """Second-order methods on both sides of the cut leave the error of the whole run, and no more."""
    throw = {
        "initial_velocity": lambda x, y: 0.2 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8),
        "probes": {"A": (0, 0)},
    }
    asked = {"damping": tf.Rayleigh(0.1, 1e-4), "probes": {"A": (0, 0)}}
    exact = tf.simulate(film, end_time=0.1, time_step=1e-4, method=tf.Newmark(), **(asked | throw))
    first = tf.simulate(film, end_time=0.05, time_step=5e-4, method=tf.Newmark(), **(asked | throw))
    size = float(np.abs(exact.data.w).max())
    for method, step in ((tf.GeneralizedAlpha(0.9), 5e-4), (tf.Newmark(), 2e-4), (tf.Bathe(), 3.7e-4)):
        second = tf.simulate(film, end_time=0.1, time_step=step, method=method, initial=first.final, **asked)
        w = np.interp(second.data.time.values, exact.data.time.values, exact.data.w.values[:, 0])
        assert np.abs(second.data.w.values[:, 0] - w).max() < 0.01 * size
        assert second.data.time.values[0] == pytest.approx(0.05 + step)


def test_a_reduced_run_goes_on_as_a_full_one_and_back(film):
    """The motion of coordinates is that of the structure."""
    rom = tf.reduce(film, tf.ModalBasis(count=8))
    first = tf.simulate(rom, STOP, end_time=0.05, method=tf.Newmark(), **ASKED)
    full, reduced = (
        tf.simulate(plant, STOP, end_time=0.08, method=tf.Newmark(), initial=first.final, **ASKED)
        for plant in (film, rom)
    )
    off = np.abs(full.data.w.values - reduced.data.w.values).max()
    assert off < 0.02 * float(np.abs(reduced.data.w).max())
    back = tf.simulate(rom, STOP, end_time=0.1, method=tf.Newmark(), initial=full.final, **ASKED)
    assert back.status is Status.COMPLETED


def test_forces_that_are_others_now_jump_at_the_cut(antenna):
    """A force that ends with the first run is one that jumps there; the work of its tension is in the books."""
    asked = ASKED | {"method": tf.GeneralizedAlpha(0.8)}
    for kind in (tf.CableTension, lambda value: tf.NodalForce([8], value)):
        low, high = (1.0, 1.3) if kind is tf.CableTension else ((0.0, 0.0, 0.0), (0.0, 0.0, 1e-3))
        jumping = kind(tf.TimeTable([0.0, 0.01, 0.01], [high, high, low]))
        whole = tf.simulate(antenna, end_time=0.02, inputs=[jumping], **asked)
        first = tf.simulate(antenna, end_time=0.01, inputs=[kind(high)], **asked)
        second = tf.simulate(antenna, end_time=0.02, inputs=[kind(low)], initial=first.final, **asked)
        expected = whole.data.w.values[11:]
        np.testing.assert_allclose(second.data.w.values, expected, atol=1e-9 * np.abs(expected).max())
        for name, value in whole.energy_balance.items():
            assert second.energy_balance[name] == pytest.approx(value, abs=1e-9 * abs(whole.energy_balance["loads"]))


def test_a_hub_keeps_its_momentum_over_a_cut(antenna):
    hub = replace(HUB, torque=None)
    first = tf.simulate(antenna, hub, end_time=0.01, method=tf.Newmark(), **ASKED)
    second = tf.simulate(antenna, hub, end_time=0.02, method=tf.Bathe(), initial=first.final, **ASKED)
    momenta = [run.data.angular_momentum.values[-1] for run in (first, second)]
    np.testing.assert_allclose(*momenta, atol=1e-12)


def test_interrupted_runs_go_on(film):
    asked = ASKED | {"method": tf.GeneralizedAlpha(0.8)}

    def stop_half_way(fraction: float, message: str) -> None:
        if fraction > 0.4:
            raise KeyboardInterrupt

    first = tf.simulate(film, STOP, end_time=0.03, progress=stop_half_way, **asked)
    assert first.status is Status.INTERRUPTED
    second = tf.simulate(film, STOP, end_time=0.03, initial=first.final, **asked)
    assert differing(first, second, tf.simulate(film, STOP, end_time=0.03, **asked)) == []


def test_a_state_of_another_structure_is_refused(film, antenna):
    final = tf.simulate(film, end_time=0.01, time_step=1e-3).final
    options = {"end_time": 0.02, "time_step": 1e-3}
    with pytest.raises(InputError, match=r"initial: expected a state of this structure, of \d+ unknowns, got one of"):
        tf.simulate(antenna, initial=final, **options)
    taut = tf.solve_prestress(replace(film.model, groups=tuple(replace(g) for g in film.model.groups)))
    tf.simulate(taut, initial=final, **options)  # the same one, built twice
    with pytest.raises(InputError, match="got one whose stiffness and prestress differ"):
        tf.simulate(soft_film(strain="green-lagrange"), initial=final, **options)
    moved = replace(film.model, nodes=film.model.nodes * [1.0, 1.1, 1.0])
    with pytest.raises(InputError, match=r"whose node positions and masses and stiffness and prestress differ"):
        tf.simulate(tf.solve_prestress(moved), initial=final, **options)


def test_bad_starts_are_told(film):
    run = tf.simulate(film, end_time=0.01, time_step=1e-3)
    for more, message in (
        ({"initial": run.final, "end_time": 0.01}, "end_time: expected at least one time_step"),
        ({"initial": run.data, "end_time": 0.02}, "initial: expected a state to go on from"),
        (
            {"initial": run.final, "end_time": 0.02, "initial_velocity": lambda x, y: x},
            "initial_velocity: expected none",
        ),
        ({"initial": run.final, "end_time": 0.02, "initial_imperfection": 1e-3}, "initial_imperfection: expected none"),
        ({"initial": run.final, "end_time": 0.02, "fields": [0.005]}, "fields: expected times in"),
        ({"initial": run.final, "end_time": 0.012, "every": 7}, "every: expected an instant to store between 0.01 s"),
    ):
        with pytest.raises(InputError, match=message):
            tf.simulate(film, time_step=1e-3, **more)
    assert "goes on" in repr(run.final)


def test_files_without_a_state_and_other_results(film, tmp_path):
    run = tf.simulate(film, end_time=0.01, time_step=1e-3)
    tf.save(run.data, tmp_path / "bare.nc")
    bare = tf.load_run(tmp_path / "bare.nc")
    assert bare.final is None
    assert bare.stats == run.stats
    assert bare.energy_balance == run.energy_balance
    with pytest.raises(InputError, match="run without a state"):
        tf.simulate(film, end_time=0.02, time_step=1e-3, initial=bare)
    tf.save(tf.solve_modes(film, n=3).to_dataset(), tmp_path / "modes.nc")
    with pytest.raises(InputError, match="expected a run"):
        tf.load_run(tmp_path / "modes.nc")
