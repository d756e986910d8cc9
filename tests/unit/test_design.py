"""Designs: the best value is found, limits hold, and a search that ended early goes on to the same trials."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main
from tautflex.study.search import _excess, _unbeaten
from tautflex.study.sections import Limit
from unit.study_cases import FILM, film_study

pytest.importorskip("optuna")
DESIGN = {
    "variables": {"maneuver.rate": {"from": 0.05, "to": 0.2}, "damping.beta": {"choices": [0.0, 2e-3]}},
    "minimize": ["probes.A.amplitude"],
    "trials": 8,
}


def wanted(**more):
    return film_study(design=DESIGN | more)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("design")
    return tf.design(wanted(), folder), folder


def test_the_best_trial_is_a_case_that_can_be_run(found):
    data, folder = found
    assert data.sizes["trial"] == 8
    (best,) = data.attrs["best"]
    amplitude = data["probes.A.amplitude"]
    assert float(amplitude.sel(trial=best)) == float(amplitude.min())
    case = tf.load_case(folder / "best.toml")
    assert case.maneuver.rate == float(data["maneuver.rate"].sel(trial=best))
    assert float(np.abs(tf.run_case(case).data["w"]).max()) == float(amplitude.min())
    assert tf.load(folder / "design.nc").drop_attrs().equals(data.drop_attrs())
    assert data["maneuver.rate"].attrs["units"] == "rad/s"


def test_a_search_that_ended_early_goes_on_to_the_same_trials(found, tmp_path):
    """Ended after three trials, with half a line in its journal, as a kill leaves it."""

    def stop(fraction: float, message: str) -> None:
        if fraction > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tf.design(wanted(), tmp_path, progress=stop)
    journal = tmp_path / "journal.log"
    whole = journal.read_bytes()
    journal.write_bytes(whole + b'{"op_code": 4, "wor')
    assert tf.design(wanted(), tmp_path).drop_attrs().equals(found[0].drop_attrs())


@pytest.mark.slow
@pytest.mark.parametrize("cut", [1, 2, 5])
def test_a_journal_that_lacks_its_last_lines_leads_to_the_same_trials(found, tmp_path, cut):
    tf.design(wanted(), tmp_path, trials=3)
    journal = tmp_path / "journal.log"
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:-cut]))
    assert tf.design(wanted(), tmp_path).drop_attrs().equals(found[0].drop_attrs())


@pytest.mark.slow
def test_limits_rule_out(found, tmp_path):
    """The smallest amplitude that is not below the limit; with a limit beyond all, none."""
    limit = float(found[0]["probes.A.amplitude"].median())
    free = tf.design(wanted(constraints={"probes.A.amplitude": {"above": limit}}), tmp_path / "a")
    (best,) = free.attrs["best"]
    assert (free["feasible"] == (free["probes.A.amplitude"] > limit)).all()
    assert 0 < int(free["feasible"].sum()) < 8
    feasible = free["probes.A.amplitude"].where(free["feasible"])
    assert float(free["probes.A.amplitude"].sel(trial=best)) == float(feasible.min())
    none = tf.design(wanted(constraints={"probes.A.amplitude": {"below": 1e-9}}), tmp_path / "b", trials=2)
    assert none.attrs["best"] == []
    assert not (tmp_path / "b" / "best.toml").exists()
    tf.plot.plot_design(none)


def test_several_objectives_and_failed_trials(tmp_path):
    """The two contradict each other: the faster, the larger; a negative damping is no case."""
    variables = {"maneuver.rate": {"from": 0.05, "to": 0.2}, "damping.beta": {"choices": [0.0, -1.0]}}
    more = {"variables": variables, "maximize": ["energy_balance.initial"], "minimize": ["probes.A.amplitude"]}
    data = tf.design(wanted(**more), tmp_path)
    assert set(data["status"].values) == {"completed", "invalid"}
    done = data.isel(trial=data["status"].values == "completed")
    assert sorted(data.attrs["best"]) == sorted(done["trial"].values.tolist())
    assert data["direction"].values.tolist() == ["minimize", "maximize"]


def test_excess_and_unbeaten():
    assert _excess(Limit(above=0.0), 0.5) == -0.5
    assert _excess(Limit(above=2.0, below=4.0), 5.0) == 0.25
    values = np.array([[1.0, 2.0], [2.0, 1.0], [2.0, 2.0], [0.0, 0.0], [1.0, 2.0]])
    assert _unbeaten(values, np.array([True, True, True, False, True])) == [0, 1]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"variables": {}}, "design.variables: expected at least one|at least one variable"),
        ({"variables": {"maneuver.rat": {"from": 1.0, "to": 2.0}}}, "unknown key .* did you mean 'rate'"),
        ({"variables": {"maneuver.rate": {"from": 2.0, "to": 1.0}}}, "expected from < to, got 2 and 1"),
        ({"variables": {"maneuver.rate": {"from": 2.0}}}, "expected from and to, or choices"),
        ({"minimize": []}, "minimize: expected measures"),
        ({"minimize": ["probes.A.amplitud"]}, "design.minimize: .* did you mean 'probes.A.amplitude'"),
        ({"constraints": {"probes.A.amplitude": {}}}, "above: missing"),
        ({"constraints": {"surface.rmsx": {"above": 0.0}}}, "design.constraints: .* did you mean 'surface.rms'"),
    ],
)
def test_refused_before_anything_runs(tmp_path, more, words):
    with pytest.raises(tf.CaseError, match=words):
        tf.design(wanted(**more), tmp_path / "out")
    assert not (tmp_path / "out" / "points").exists()


def test_the_journal_of_another_search_is_refused(tmp_path):
    tf.design(wanted(), tmp_path, trials=1)
    with pytest.raises(tf.CaseError, match="the journal of this search, got that of another"):
        tf.design(wanted(seed=5), tmp_path, trials=1)
    with pytest.raises(tf.CaseError, match="design: missing"):
        tf.design(film_study(), tmp_path)


def test_a_damaged_journal_is_one_line(tmp_path):
    (tmp_path / "journal.log").write_text('1, "worker_id"}\n')
    with pytest.raises(tf.CaseError, match=r"got a damaged one.*finished points are kept"):
        tf.design(wanted(), tmp_path)
    assert (tmp_path / "journal.log").exists()


def test_the_command(tmp_path, capsys):
    (tmp_path / "film.toml").write_text(FILM, encoding="utf-8")
    study = tmp_path / "s.toml"
    study.write_text(
        'base = "film.toml"\n[design]\nminimize = ["probes.A.amplitude"]\n'
        '[design.variables]\n"maneuver.rate" = { from = 0.05, to = 0.2 }\n',
        encoding="utf-8",
    )
    out = tmp_path / "out"
    assert main(["design", str(study), "-o", str(out), "--trials", "2", "--json", "--format", "svg"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["trials"], answer["failed"], len(answer["best"])) == (2, 0, 1)
    assert {path.name for path in out.glob("*.*")} == {"design.nc", "trials.csv", "history.svg", "best.toml",
                                                     "journal.log"}  # fmt: skip
