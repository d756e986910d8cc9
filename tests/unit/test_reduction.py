"""Parts of the reduction room: sampling, schedules, arguments, warnings, results."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import Segment
from tautflex.reduction.bases.snapshots import full_snapshots
from tautflex.reduction.marching.frame_terms import sample
from tautflex.reduction.marching.schedule import stretches
from tautflex.reduction.polynomial.monomials import monomial_rates, monomials, packed, pairs, stress_fields
from tautflex.solvers.static.across import transverse_unknowns
from verification.dynamic_cases import small_antenna, soft_film


def test_monomials_and_their_rates():
    rng = np.random.default_rng(0)
    eta, rate = rng.standard_normal((2, 5, 4))
    first, second = pairs(4)
    assert np.allclose(monomials(eta), eta[:, first] * eta[:, second])
    step = 1e-6
    slope = (monomials(eta + step * rate) - monomials(eta - step * rate)) / (2 * step)
    assert np.allclose(monomial_rates(eta, rate), slope, atol=1e-8)


def test_packing_keeps_quadratic_forms():
    rng = np.random.default_rng(1)
    table, eta = rng.standard_normal((4, 4)), rng.standard_normal(4)
    assert packed(table) @ monomials(eta) == pytest.approx(eta @ table @ eta)
    assert packed(np.stack([table, table.T]))[0] == pytest.approx(packed(table.T))


def test_stress_fields_rebuild_the_matrix_and_drop_what_is_weak():
    rng = np.random.default_rng(2)
    few = rng.standard_normal((3, 10))
    fields = stress_fields(few.T @ few, np.ones(4), 1e-9)
    assert fields.shape == (3, 10)
    assert np.allclose(fields.T @ fields, few.T @ few)
    assert stress_fields(np.zeros((10, 10)), np.ones(4)).shape == (0, 10)


def test_sampled_functions_are_exact_to_round_off():
    times = np.linspace(0.3, 2.0, 500)
    calls = []

    def smooth(time):
        calls.append(time)
        return np.array([np.sin(3.0 * time), time**2, 1.0])

    span = (times[0], times[-1], len(times))
    values = sample(smooth, times, span)
    assert len(calls) < 100
    assert np.abs(values - np.array([smooth(time) for time in times])).max() < 1e-12
    assert sample(lambda time: np.array([4.0, 5.0]), times, span).tolist() == [[4.0, 5.0]]
    kink = sample(lambda time: np.array([abs(time - 1.0)]), times, span)
    assert np.array_equal(kink[:, 0], np.abs(times - 1.0))
    # Some of the instants are read to the same bits as all of them.
    assert np.array_equal(sample(smooth, times[123:], span), values[123:])


def test_steps_meet_the_grid_and_the_limits():
    still = lambda time: None  # noqa: E731
    segments = (Segment(0.0, 0.25, still), Segment(0.25, 0.4, still), Segment(0.4, np.inf, still))
    pieces = list(stretches(segments, 0.1, 0, 7))
    starts = np.concatenate([piece.starts for piece in pieces])
    sizes = np.concatenate([np.full(len(piece.starts), piece.size) for piece in pieces])
    grid = np.concatenate([piece.grid for piece in pieces])
    assert np.allclose(starts + sizes, [0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7])
    assert grid.tolist() == [1, 2, -1, 3, 4, 5, 6, 7]
    assert [piece.segment for piece in pieces] == [0, 0, 1, 1, 2]
    # A run that begins later takes the same steps from there on, in blocks of the same limits.
    later = list(stretches(segments, 0.1, 4, 7))
    assert [piece.grid.tolist() for piece in later] == [[5, 6, 7]]
    assert np.array_equal(later[0].starts, pieces[-1].starts)
    assert later[0].span == pieces[-1].span


def test_blocks_of_steps_bound_memory():
    pieces = list(stretches((Segment(0.0, np.inf, lambda time: None),), 0.1, 0, 20_000))
    assert sum(len(piece.starts) for piece in pieces) == 20_000
    assert max(len(piece.starts) for piece in pieces) <= 4096


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


STOP = {"time_step": 1e-3, "end_time": 0.2, "damping": tf.Rayleigh(0.001, 0.001), "probes": {"A": (0.5, 0.25)}}


def test_result_has_what_a_full_result_has(antenna, tmp_path):
    maneuver = tf.Stop(rate=0.05, duration=0.1)
    rom = tf.reduce(antenna, tf.ModalBasis(("rx",), count=5))
    full = tf.simulate(antenna, maneuver, fields=[0.1], every=10, **STOP).data
    run = tf.simulate(rom, maneuver, fields=[0.1], every=10, **STOP)
    assert set(full.variables) <= set(run.data.variables)
    for name in full.variables:
        assert run.data[name].dims == full[name].dims, name
        attributes = {key: value for key, value in run.data[name].attrs.items() if key != "comment"}
        assert str(attributes) == str(full[name].attrs), name
    assert run.status.value == "completed"
    assert run.stats.steps == 200
    assert run.data.attrs["maneuver_end"] == full.attrs["maneuver_end"]
    tf.save(run.data, tmp_path / "run.nc")
    assert tf.load(tmp_path / "run.nc").equals(run.data)
    # What is not evaluated is missing, not zero.
    assert int(np.isfinite(run.data.min_principal_resultant).sum()) == run.data.sizes["check_time"]
    assert "no peaks of the run" in run.data.min_principal_resultant.comment


def test_every_stores_the_same_samples(antenna):
    rom = tf.reduce(antenna, tf.ModalBasis(("rx",), count=5))
    maneuver = tf.Stop(rate=0.05, duration=0.0503)
    dense, sparse = (tf.simulate(rom, maneuver, every=every, **STOP).data for every in (1, 20))
    assert np.allclose(dense.w[::20], sparse.w, rtol=1e-12, atol=1e-18)
    assert np.array_equal(dense.time[::20], sparse.time)


def test_compression_and_truncation_are_reported(antenna):
    maneuver = tf.Stop(rate=3.0, duration=0.1)
    rom = tf.reduce(antenna, tf.ModalBasis(("rx",), count=1, static_correction=False))
    warnings = tf.simulate(rom, maneuver, **STOP).data.attrs["warnings"]
    assert any("outside its basis" in text for text in warnings)
    strong = tf.simulate(tf.reduce(antenna, tf.ModalBasis(("rx",))), maneuver, **STOP)
    assert any("compression" in text for text in strong.data.attrs["warnings"])
    good = tf.simulate(
        tf.reduce(antenna, tf.ModalBasis(("rx",), threshold=1e-4)), tf.Stop(rate=0.003, duration=0.1), **STOP
    )
    assert not any("outside its basis" in text for text in good.data.attrs["warnings"])
    assert float(good.data.truncated_energy.max()) < 1e-2


def test_forces_in_time_act_on_a_reduced_model(antenna):
    node = int(np.argmin(np.abs(antenna.model.nodes[:, :2] - [0.5, 0.25]).sum(axis=1)))
    push = tf.NodalForce([node], lambda time: (0.0, 0.0, 1e-4 if time < 0.05 else 0.0), breaks=(0.05,))
    rom = tf.reduce(antenna, tf.ModalBasis(("z", "rx", "ry"), threshold=1e-6, candidates=45))
    full, reduced = (tf.simulate(plant, inputs=[push], **STOP).data for plant in (antenna, rom))
    assert float(np.abs(full.w - reduced.w).max()) < 0.02 * float(np.abs(full.w).max())


def test_snapshots_recover_rotations_and_know_what_is_transverse(antenna):
    run = tf.simulate(antenna, tf.Stop(rate=0.05, duration=0.1), fields="all", every=20, **STOP)
    snapshots = full_snapshots(antenna, run.data)
    translations = antenna.system.translations(snapshots)
    assert np.array_equal(translations, run.data.displacement.values)
    model = antenna.model
    transverse = transverse_unknowns(antenna)
    assert transverse[antenna.system.place[model.translation_dofs[model.triangles.ravel(), 2]]].all()
    assert not transverse[antenna.system.place[model.translation_dofs[model.triangles.ravel(), :2]]].any()
    # Modes know their rotations; snapshots made of their translations must find them again.
    mode = tf.solve_modes(antenna, 1)
    fields = run.data.displacement.copy(data=np.repeat(mode.shapes, run.data.sizes["field_time"], axis=0))
    found = full_snapshots(antenna, run.data.assign(displacement=fields))[0]
    assert np.abs(found - mode.vectors[0]).max() < 0.02 * np.abs(mode.vectors[0]).max()


def test_proper_orthogonal_modes_of_several_runs(antenna):
    """They hold the fields of both runs, those of one run hold its own."""
    maneuvers = (tf.Stop(rate=0.05, duration=0.1), tf.BaseAcceleration(0.1, axis=(0.0, 0.0, 1.0)))
    runs = [tf.simulate(antenna, each, fields="all", every=10, **STOP).data for each in maneuvers]
    mass = antenna.system.inertia.mass_matrix

    def lost(data, run):
        fields = full_snapshots(antenna, run) * transverse_unknowns(antenna)
        kept = tf.PodBasis(data, count=6, derivatives="none").vectors(antenna).kept
        rest = fields - (fields @ (mass @ kept.T)) @ kept
        return np.sum(rest * (mass @ rest.T).T) / np.sum(fields * (mass @ fields.T).T)

    assert lost(runs[0], runs[0]) < 0.01
    assert lost(runs[0], runs[1]) > 0.9  # a turn has nothing of a push across
    assert max(lost(runs, run) for run in runs) < 0.01
    with pytest.raises(tf.InputError, match="data: expected at least one run, got none"):
        tf.PodBasis([])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: tf.ModalBasis(()), "directions: expected at least one"),
        (lambda: tf.ModalBasis(("w",)), "directions: expected"),
        (lambda: tf.ModalBasis(count=0), "count: expected"),
        (lambda: tf.ModalBasis(threshold=2.0), "threshold"),
        (lambda: tf.ModalBasis(derivatives="some"), "derivatives"),
    ],
)
def test_bad_bases(make, words):
    with pytest.raises(tf.InputError, match=words):
        make()


def taut_cable(count):
    """A cable along x, held at both ends: nothing of it feels a turn about x."""
    section = tf.CableSection(tf.Material(7e8, 2700.0), 1e-6)
    links = [[k, k + 1] for k in range(count)]
    model = tf.Model.from_mesh(
        [[float(k), 0.0, 0.0] for k in range(count + 1)],
        cables=links,
        cable=section,
        cable_tension=5.0,
        supports=[tf.Support.pinned([0, count])],
    )
    return tf.solve_prestress(model)


def test_structures_without_film():
    state = taut_cable(6)
    reduced = tf.reduce(state)
    assert reduced.size == tf.reduce(state, tf.ModalBasis(("z", "ry"))).size < state.system.size
    push = tf.BaseAcceleration(40.0, axis=(0.0, 0.0, 1.0))
    given = {"time_step": 1e-3, "end_time": 0.5, "method": tf.Newmark(), "probes": {"A": (2.0, 0.0)}}
    full, few = (tf.simulate(plant, push, **given).data for plant in (state, reduced))
    assert float(np.abs(full.w).max()) > 0.1
    assert float(np.abs(full.w - few.w).max()) < 0.01 * float(np.abs(full.w).max())
    with pytest.raises(tf.InputError, match="directions: expected an acceleration that loads the structure, got rx"):
        tf.reduce(state, tf.ModalBasis(("rx",)))


def test_bad_reductions(antenna):
    maneuver = tf.Stop(rate=0.05, duration=0.1)
    with pytest.raises(tf.InputError, match="basis: expected an object"):
        tf.reduce(antenna, "modes")
    run = tf.simulate(antenna, maneuver, **STOP)
    with pytest.raises(tf.InputError, match="fields='all'"):
        tf.reduce(antenna, tf.PodBasis(run.data))
    other = tf.simulate(soft_film(), maneuver, fields="all", every=50, time_step=1e-3, end_time=0.2)
    with pytest.raises(tf.InputError, match="same mesh"):
        tf.reduce(antenna, tf.PodBasis(other.data))
    free = tf.solve_prestress(_free_antenna(), check=False)
    with pytest.raises(tf.UnsupportedError, match="rigid motion"):
        tf.reduce(free)
    slack = tf.solve_prestress(_slack_antenna())
    with pytest.raises(tf.UnsupportedError, match="hyper_reduce"):
        tf.reduce(slack)


def test_bad_runs(antenna):
    rom = tf.reduce(antenna, tf.ModalBasis(("rx",), count=3))
    maneuver = tf.Stop(rate=0.05, duration=0.1)
    with pytest.raises(tf.UnsupportedError, match="adaptive"):
        tf.simulate(rom, maneuver, adaptive=tf.Adaptive(1e-4), **STOP)
    with pytest.raises(tf.InputError, match="stable step"):
        tf.simulate(rom, maneuver, method=tf.CentralDifference(), **{**STOP, "time_step": 0.1})


def _free_antenna():
    from dataclasses import replace

    return replace(small_antenna(), supports=())


def _slack_antenna():
    from dataclasses import replace

    model = small_antenna()
    groups = tuple(
        replace(group, section=replace(group.section, slack=True)) if group.section.kind == "cable" else group
        for group in model.groups
    )
    return replace(model, groups=groups)
