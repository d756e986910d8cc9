"""Runs that are killed go on from their last checkpoint, and equal those that were not, to the bit."""

from __future__ import annotations

import dataclasses
import json

import pytest
import xarray as xr

import tautflex as tf
from tautflex.case import parse_case
from tautflex.files.checkpoints import FOLDER
from verification.builders import STOPPED_FILM as FILM

VARIANTS = {
    "plain": "",
    "adaptive": 'solver.method="generalized-alpha" solver.adaptive_tolerance=1e-3 solver.max_step=0.02',
    "explicit": 'solver.method="central-difference" solver.time_step=5e-5 solver.end_time=0.006 output.fields=[0.005]',
    "stages": 'solver.method="bathe" solver.time_step=0.01',
    "reduced": 'reduction.directions=["rx"] reduction.count=3 solver.time_step=2e-4 output.every=3',
}


class Killed(BaseException):
    """Ends a run where it stands, as a kill does."""


def killed_after(steps):
    """Progress that kills at its calls with these numbers, and goes on at others."""
    calls = []

    def progress(fraction, message):
        calls.append(fraction)
        if len(calls) in steps:
            raise Killed

    return progress


def same(one: tf.Run, other: tf.Run) -> None:
    first, second = (dataclasses.asdict(run.stats) | {"seconds": 0.0} for run in (one, other))
    assert first == second
    assert json.dumps(one.energy_balance) == json.dumps(other.energy_balance)
    assert one.error == other.error or one.error != one.error
    xr.testing.assert_identical(*(run.data.assign_attrs(statistics="", reduced_model="") for run in (one, other)))
    xr.testing.assert_identical(*(xr.Dataset(dict(enumerate_memory(run))) for run in (one, other)))


def enumerate_memory(run):
    for name, array in run.final.memory.items():
        yield name, xr.DataArray(array, dims=[f"{name}.{axis}" for axis in range(array.ndim)])


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_killed_runs_go_on_to_the_bit(name, tmp_path):
    case = parse_case(FILM, VARIANTS[name].split())
    whole = tf.run_case(case)
    for kill in (2, 3):
        with pytest.raises(Killed):
            tf.run_case(case, killed_after({kill}), checkpoint=tmp_path / "kept", seconds=1e-9)
    assert (tmp_path / "kept" / "state.npz").is_file()
    same(tf.run_case(case, checkpoint=tmp_path / "kept", seconds=1e-9), whole)
    assert list(tmp_path.iterdir()) == []


def test_checkpoints_of_another_case_and_damaged_ones_are_refused(tmp_path):
    case, other = parse_case(FILM), parse_case(FILM, ["maneuver.rate=0.4"])
    place = tmp_path / FOLDER
    with pytest.raises(Killed):
        tf.run_case(case, killed_after({3}), checkpoint=place, seconds=1e-9)
    with pytest.raises(tf.CaseError, match="of this case, got one of another case"):
        tf.run_case(other, checkpoint=place)
    (place / "probe.bin").write_bytes(b"")
    with pytest.raises(tf.CaseError, match=r"probe\.bin has another size"):
        tf.run_case(case, checkpoint=place)
    (place / "state.npz").write_bytes((place / "state.npz").read_bytes()[:-200])
    with pytest.raises(tf.CaseError, match="damaged"):
        tf.run_case(case, checkpoint=place)
