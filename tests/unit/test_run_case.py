"""One way from a case to its run: in Python, on the command line, and in the reproduction of the paper."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case
from tautflex.cli import main
from tautflex.paper.cases.catalogue import RunSpec
from tautflex.paper.engine import perform
from verification.builders import FILM_CASE

FILM = f"""{FILM_CASE}[maneuver]
kind = "stop"
rate = 0.5
duration = 0.1
[output]
fields = [0.1, 5.0]
"""
VARIANTS = {
    "plain": "",
    "adaptive": 'solver.method="generalized-alpha" solver.adaptive_tolerance=1e-3 solver.max_step=0.02',
    "tight": "solver.tolerance=1e-12 solver.max_halvings=2",
    "reduced": 'reduction.directions=["rx"] reduction.count=3',
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_the_same_numbers_wherever_a_case_runs(name, tmp_path, capsys):
    """Options that the reproduction used to drop are among these."""
    path = tmp_path / "film.toml"
    overrides = VARIANTS[name].split()
    path.write_text(parse_case(FILM, overrides).to_toml(), encoding="utf-8")
    case = tf.load_case(path)
    run = tf.run_case(case)
    assert run.status.value == "completed"
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--json"]) == 0
    capsys.readouterr()
    spec = RunSpec("film", case, "published", "M2", 0.5, 0.1)
    kept = perform([spec], tmp_path / "kept", workers=1)["film"]
    for other in map(tf.load, (tmp_path / "out" / "run.nc", kept)):
        assert other.sizes == run.data.sizes
        for variable in ("w", "strain_energy", "kinetic_energy", "max_principal_resultant"):
            np.testing.assert_array_equal(other[variable], run.data[variable])
    # what the options do is seen in the run
    assert ("adaptive" in run.data.attrs) == (name == "adaptive")
    assert ("reduced_model" in run.data.attrs) == (name == "reduced")
    if name == "tight":
        assert run.stats.back_substitutions > tf.run_case(parse_case(FILM)).stats.back_substitutions


def test_a_run_that_fails_raises_or_is_returned_as_asked():
    maneuver = "maneuver.kind=stop maneuver.rate=30.0 maneuver.duration=0.5"
    solver = "solver.method=energy-conserving solver.time_step=0.1 solver.max_halvings=0"
    impossible = parse_case(FILM, [*maneuver.split(), *solver.split()])
    with pytest.raises(tf.NotConvergedError):
        tf.run_case(impossible)
    assert tf.run_case(impossible, throw=False).status.value == "not-converged"


def test_progress_is_told():
    told = []
    tf.run_case(parse_case(FILM), lambda fraction, message: told.append((fraction, message)))
    assert told[0] == (0.0, "prestress")
    assert told[-1][0] == 1.0


def test_a_record_that_ends_before_the_maneuver_has_nothing_after_it(tmp_path, capsys):
    """The film is held off its plane by the maneuver then: its largest rms and a time to settle would mean nothing."""
    path = tmp_path / "film.toml"
    path.write_text(FILM.replace("duration = 0.1", "duration = 1.0"), encoding="utf-8")
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == 0
    assert "before the maneuver's end" in " ".join(capsys.readouterr().out.split())
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["surface"]["rms"] > 0.0
    assert summary["surface"]["rms_max"] is None
    assert summary["surface"]["settling_time"] is None
    assert summary["probes"]["A"]["amplitude"] > 0.0
    assert summary["probes"]["A"]["dominant_frequency"] is None
