"""The driver of a run: start, time grid, what is stored, and every way it can end."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tautflex import (
    BeamSection,
    CableSection,
    Coupling,
    GeneralizedAlpha,
    InputError,
    Material,
    MembraneSection,
    Newmark,
    NotConvergedError,
    Stop,
    UnsupportedError,
    WilsonTheta,
    simulate,
    solve_prestress,
)
from tautflex.files import netcdf
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.march.stretch import March
from tautflex.solvers.transient.status import Status
from tautflex.structure.antenna import AntennaLayout, build_antenna
from verification.dynamic_cases import SuddenSpin, oscillator, small_antenna, soft_film, string


@pytest.fixture(scope="module")
def film():
    return soft_film()


@pytest.fixture(scope="module")
def antenna():
    return solve_prestress(small_antenna())


def test_stop_brakes_uniformly_about_its_axis():
    stop = Stop(rate=0.8, duration=0.5, axis=(0.0, 3.0, 4.0), origin=(0.2, -0.1, 0.4))
    unit, origin = np.array([0.0, 0.6, 0.8]), np.array([0.2, -0.1, 0.4])
    braking, rest = stop.segments()
    assert (braking.start, braking.end, rest.start, rest.end) == (0.0, 0.5, 0.5, np.inf)
    for time in (0.0, 0.1, 0.5):
        motion = braking.motion(time)
        spin, change = 0.8 * (1.0 - time / 0.5) * unit, -1.6 * unit
        np.testing.assert_allclose(motion.angular_velocity, spin, atol=1e-15)
        np.testing.assert_allclose(motion.angular_acceleration, change, atol=1e-15)
        # A point of the axis stays where it is: a0 + dw x o + w x (w x o) = 0.
        acceleration = np.cross(change, origin) + np.cross(spin, np.cross(spin, origin))
        np.testing.assert_allclose(motion.origin_acceleration, -acceleration, atol=1e-15)
    for motion, spin in ((stop.start(), 0.8 * unit), (rest.motion(0.7), 0.0 * unit)):
        np.testing.assert_allclose(motion.angular_velocity, spin, atol=1e-15)
        assert not motion.angular_acceleration.any()


def test_recorded_motion_of_the_frame(film):
    run = simulate(film, Stop(0.9, 0.03, axis=(0.0, 0.0, -1.0)), time_step=0.01, end_time=0.06)
    time = run.data.time.values
    np.testing.assert_allclose(time, 0.01 * np.arange(7), atol=1e-15)
    rate = np.where(time < 0.03 - 1e-9, 0.9 * (1.0 - time / 0.03), 0.0)
    np.testing.assert_allclose(run.data.angular_velocity.values[:, 2], -rate, atol=1e-14)
    np.testing.assert_allclose(
        run.data.angular_acceleration.values[:, 2], np.where(time < 0.03 - 1e-9, 30.0, 0.0), atol=1e-12
    )
    assert not run.data.angular_velocity.values[:, :2].any()


@pytest.mark.parametrize("method", [WilsonTheta(), GeneralizedAlpha(rho_inf=0.8)])
def test_a_run_starts_from_its_steady_spin(antenna, method):
    """A stop that takes for ever leaves the antenna in its spinning equilibrium; a sudden spin does not."""
    stop = Stop(2.0, 1e9, axis=(0.2, 0.3, 1.0))
    options = {"method": method, "time_step": 5e-3, "end_time": 0.2, "fields": "all"}
    field = simulate(antenna, stop, tolerance=1e-9, **options).data.displacement.values
    size = np.abs(field[0]).max()
    assert size > 1e-7
    assert np.abs(field - field[0]).max() < 1e-5 * size
    assert np.abs(simulate(antenna, SuddenSpin(stop), **options).data.displacement.values[1:]).max() > 1.2 * size


def test_initial_velocity_as_function_and_as_array(antenna):
    nodes = antenna.model.nodes
    array = np.zeros((len(nodes), 3))
    array[:, 2] = 1e-3 * (1.0 + nodes[:, 0] ** 2)
    options = {"time_step": 1e-3, "end_time": 0.02, "probes": {"A": (0.0, 0.0), "B": (0.6, 0.3)}}
    by_array = simulate(antenna, initial_velocity=array, **options)
    by_function = simulate(antenna, initial_velocity=lambda x, y: 1e-3 * (1.0 + x**2), **options)
    np.testing.assert_array_equal(by_array.data.w.values, by_function.data.w.values)
    free = antenna.system.full(np.ones(antenna.system.size))[antenna.model.translation_dofs[:, 2]] == 1.0
    velocity = antenna.system.inertia.mass_matrix
    v = np.zeros(antenna.model.dof_count)
    v[antenna.model.translation_dofs[free, 2]] = array[free, 2]
    v = v[antenna.model.free_dofs]
    assert by_array.data.kinetic_energy.values[0] == pytest.approx(0.5 * v @ velocity @ v, rel=1e-12)


def test_a_constant_is_a_valid_initial_velocity_function():
    run = simulate(oscillator(), initial_velocity=lambda x, y: 1e-3, time_step=1e-3, end_time=2e-3)
    assert run.data.kinetic_energy.values[0] == pytest.approx(0.5 * 1e-6 / 3.0)  # mass rho A L/3 of the one unknown


def test_probes_interpolate_linear_fields_exactly_and_snap_to_nodes(antenna):
    """Velocity a + b x + c y on the film: an interpolated probe reads it exactly, a snapped one its node."""

    def field(x, y):
        return 0.2 - 0.5 * x + 0.8 * y

    points = {"A": (0.13, -0.21), "B": (-0.77, 0.41), "corner": (1.0, 0.5), "deep": (0.13, -0.21, 0.0)}
    options = {"time_step": 1e-4, "end_time": 1e-4, "initial_velocity": field, "probes": points}
    read = simulate(antenna, **options).data
    exact = [field(*point[:2]) for point in points.values()]
    np.testing.assert_allclose(read.w_velocity.values[0], exact, atol=1e-14)
    np.testing.assert_allclose(read.probe_position.values[:, :2], [p[:2] for p in points.values()], atol=1e-12)
    snapped = simulate(antenna, probe_reading="nearest-node", **options).data
    nodes = {"A": (0.0, 0.0), "B": (-1.0, 0.5), "corner": (1.0, 0.5), "deep": (0.0, 0.0)}  # cells of 0.5 m
    np.testing.assert_allclose(snapped.probe_position.values[:, :2], list(nodes.values()), atol=1e-12)
    np.testing.assert_allclose(snapped.w_velocity.values[0], [field(*p) for p in nodes.values()], atol=1e-14)


def test_every_and_fields_choose_among_the_same_steps(film):
    options = {
        "time_step": 0.01,
        "end_time": 0.1,
        "initial_velocity": lambda x, y: 0.1 + 0.2 * x,
        "probes": {"A": (0.1, 0.05)},
    }
    dense = simulate(film, fields="all", **options).data
    sparse = simulate(film, every=3, fields="all", **options).data
    chosen = simulate(film, every=4, fields=[0.0, 0.0212, 0.1], **options).data
    np.testing.assert_array_equal(sparse.w.values, dense.w.values[::3])
    np.testing.assert_array_equal(sparse.time.values, dense.time.values[::3])
    np.testing.assert_array_equal(sparse.displacement.values, dense.displacement.values[::3])
    np.testing.assert_array_equal(chosen.displacement.values, dense.displacement.values[[0, 2, 10]])
    np.testing.assert_allclose(chosen.field_time.values, [0.0, 0.02, 0.1], atol=1e-15)
    assert simulate(film, **options).data.sizes["field_time"] == 0


def test_field_and_probe_agree_at_a_node(film):
    node = 7
    x, y, _ = film.model.nodes[node]
    run = simulate(
        film,
        time_step=0.01,
        end_time=0.05,
        initial_velocity=lambda x, y: 2.0 + x,
        probes={"N": (x, y)},
        fields="all",
    )
    probe = np.stack([run.data[name].values[:, 0] for name in "uvw"], axis=1)
    np.testing.assert_allclose(run.data.displacement.values[:, node], probe, atol=1e-12 * np.abs(probe).max())


def test_interrupt_leaves_readable_partial_data(film, tmp_path):
    def stop_half_way(fraction: float, message: str) -> None:
        seen.append((fraction, message))
        if fraction >= 0.5:
            raise KeyboardInterrupt

    seen: list[tuple[float, str]] = []
    options = {"time_step": 0.01, "end_time": 1.0, "initial_velocity": lambda x, y: 0.1, "probes": {"A": (0.1, 0.05)}}
    run = simulate(film, progress=stop_half_way, fields="all", **options)
    assert run.status is Status.INTERRUPTED
    assert run.data.attrs["status"] == "interrupted"
    assert seen[-1][0] == pytest.approx(0.5)
    assert "0.5 s" in seen[-1][1]
    whole = simulate(film, **options).data
    np.testing.assert_array_equal(run.data.w.values, whole.w.values[:51])
    path = tmp_path / "part.nc"
    netcdf.save(run.data, path)
    again = netcdf.load(path)
    np.testing.assert_array_equal(again.w.values, run.data.w.values)
    assert again.sizes["field_time"] == 51


def test_progress_goes_up_to_one(film):
    seen = []
    simulate(film, time_step=0.01, end_time=2.5, progress=lambda fraction, message: seen.append(fraction))
    assert 4 <= len(seen) <= 130
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


HARD = {
    "method": Newmark(),
    "time_step": 0.1,
    "end_time": 0.4,
    "initial_velocity": lambda x, y: 100.0 * np.cos(1.5 * x),
}


def hard_string():
    """Slack-like string thrown a hundred of its lengths per second in steps of a hundred of its periods."""
    return string(8, tension=1e-3, modulus=1e6)


def test_failure_carries_the_partial_run_and_its_history():
    with pytest.raises(NotConvergedError, match="time_step") as caught:
        simulate(hard_string(), max_halvings=0, **HARD)
    run, history = caught.value.result, caught.value.history
    assert run.status is Status.NOT_CONVERGED
    assert run.data.attrs["status"] == "not-converged"
    assert 1 <= run.data.sizes["time"] < 5
    assert np.isfinite(run.data.kinetic_energy.values).all()
    assert len(history) > 1
    assert history[-1] > 1e-6
    labelled = simulate(hard_string(), max_halvings=0, throw=False, **HARD)
    assert labelled.status is Status.NOT_CONVERGED
    np.testing.assert_array_equal(labelled.data.kinetic_energy.values, run.data.kinetic_energy.values)


def test_halving_recovers_a_hard_case_and_is_counted():
    run = simulate(hard_string(), max_halvings=8, **HARD)
    assert run.status is Status.COMPLETED
    assert run.stats.halvings > 0
    assert run.stats.steps == 4 + run.stats.halvings  # every halving makes one step two
    np.testing.assert_allclose(run.data.time.values, 0.1 * np.arange(5), atol=1e-14)
    assert json.loads(run.data.attrs["statistics"])["halvings"] == run.stats.halvings


@pytest.mark.parametrize("method", [WilsonTheta(), GeneralizedAlpha(rho_inf=0.6)])
def test_halved_steps_equal_steps_of_half_the_size(film, method, monkeypatch):
    """Steps above 10 ms are made to fail: the run must equal one of 10 ms, maneuver and all."""
    options = {"method": method, "end_time": 0.2, "probes": {"A": (0.1, 0.05)}, "tolerance": 1e-11}
    stop = Stop(3.0, 0.1, origin=(0.0, 0.5, 0.0))
    small = simulate(film, stop, time_step=0.01, **options)
    true_step = Stepper.step

    def refuse_long_steps(self, at, size, segment):
        end, outcome = true_step(self, at, size, segment)
        outcome.converged = outcome.converged and size < 0.0101
        return end, outcome

    monkeypatch.setattr(Stepper, "step", refuse_long_steps)
    monkeypatch.setattr(March, "serves", staticmethod(lambda *parts: False))  # steps one by one: refused where needed
    halved = simulate(film, stop, time_step=0.02, **options)
    assert halved.stats.halvings == 10
    assert halved.stats.steps == small.stats.steps == 20
    expected = small.data.w.values[::2]
    np.testing.assert_allclose(halved.data.w.values, expected, atol=1e-9 * np.abs(expected).max())
    with pytest.raises(NotConvergedError):
        simulate(film, stop, time_step=0.05, max_halvings=2, **options)


@pytest.mark.parametrize("step", [1e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("method", [WilsonTheta(), Newmark()])
def test_tiny_steps_converge(film, method, step):
    """Inertia forces M v/h exceed internal forces K v h so far that their round-off is a large residual."""
    run = simulate(
        film,
        method=method,
        time_step=step,
        end_time=5 * step,
        initial_velocity=lambda x, y: 0.1 + 0.0 * x,
        probes={"A": (0.0, 0.0)},
    )
    assert run.stats.halvings == 0
    np.testing.assert_allclose(run.data.w.values[:, 0], 0.1 * run.data.time.values, rtol=1e-3)


BAD = {
    "time_step": {"time_step": 0.0},
    "time_step negative": {"time_step": -1e-3},
    "time_step nan": {"time_step": float("nan")},
    "time_step text": {"time_step": "fast"},
    "end_time": {"end_time": 0.005},
    "end_time inf": {"end_time": float("inf")},
    "tolerance": {"tolerance": 0.0},
    "every": {"every": 0},
    "every fraction": {"every": 1.5},
    "max_halvings": {"max_halvings": -1},
    "fields word": {"fields": "some"},
    "fields late": {"fields": [0.5]},
    "fields early": {"fields": [-0.01]},
    "fields nan": {"fields": [float("nan")]},
    "fields number": {"fields": 0.01},
    "probe_reading": {"probe_reading": "best"},
    "probes outside": {"probes": {"A": (0.6, 0.0)}},
    "probes above": {"probes": {"A": (0.1, 0.0, 0.2)}},
    "probes short": {"probes": {"A": (0.1,)}},
    "probes nan": {"probes": {"A": (float("nan"), 0.0)}},
    "probes text": {"probes": {"A": "middle"}},
    "initial_velocity": {"initial_velocity": np.zeros((3, 3))},
    "initial_velocity nan": {"initial_velocity": lambda x, y: np.nan * x},
    "initial_velocity length": {"initial_velocity": lambda x, y: np.zeros(3)},
    "initial_velocity text": {"initial_velocity": lambda x, y: "fast"},
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arguments_are_named(film, name):
    options = {"time_step": 0.01, "end_time": 0.05} | BAD[name]
    with pytest.raises(InputError, match=name.split()[0]):
        simulate(film, **options)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("duration", {"duration": 0.0}),
        ("duration", {"duration": float("nan")}),
        ("rate", {"rate": float("inf")}),
        ("axis", {"axis": (0.0, 0.0, 0.0)}),
        ("axis", {"axis": (1.0, 0.0)}),
        ("origin", {"origin": (float("nan"), 0.0, 0.0)}),
    ],
)
def test_bad_maneuvers_are_named(name, options):
    with pytest.raises(InputError, match=name):
        Stop(**({"rate": 0.1, "duration": 1.0} | options))


def test_a_free_antenna_cannot_be_maneuvered():
    layout = AntennaLayout(2.0, 1.0, (4, 2), "alternating", 2.5, 1.5, 5, 3, "tributary", "free")
    model = build_antenna(
        layout,
        MembraneSection(Material(3.5e9, 1530.0, 0.34), 1e-4, "green-lagrange"),
        CableSection(Material(133e9, 1440.0), 3.14e-6, "green-lagrange"),
        BeamSection(Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7, "green-lagrange"),
        pretension_x=0.1,
        pretension_y=0.2,
    )
    state = solve_prestress(model)
    with pytest.raises(UnsupportedError, match=r"6 rigid motion.*frame\.support = 'corners'"):
        simulate(state, Stop(0.1, 1.0), time_step=0.01, end_time=0.1)
    # Free vibration is allowed and, without load, stays where it is: momentum is kept.
    array = np.zeros((len(model.nodes), 3))
    array[:, 2] = 0.01
    run = simulate(state, time_step=0.01, end_time=0.1, initial_velocity=array, fields=[0.1])
    np.testing.assert_allclose(run.data.displacement.values[0, :, 2], 0.01 * 0.1, rtol=1e-6)


def test_couplings_change_the_recorded_motion_and_are_labelled(antenna):
    options = {"time_step": 5e-3, "end_time": 0.1, "probes": {"A": (0.6, 0.3)}}
    stop = Stop(2.0, 0.05)
    runs = {
        name: simulate(antenna, stop, coupling=Coupling(**{name: False}), **options)
        for name in ("gyroscopic", "euler", "centrifugal", "inertial_load")
    }
    full = simulate(antenna, stop, **options)
    for name, run in runs.items():
        assert f"{name}=False" in run.data.attrs["coupling"]
    assert not runs["inertial_load"].data.w.values.any()  # nothing else pushes a flat antenna
    assert np.abs(full.data.w.values).max() > 1e-4
