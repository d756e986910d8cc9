"""`tautflex reproduce` as a command: what it prints, writes, refuses and leaves for the next call."""

from __future__ import annotations

import csv
import json
from types import SimpleNamespace

import pytest

from tautflex.cli import main
from tautflex.cli.runs.reproduce import _answer, _Made
from tautflex.paper.tables import published
from tautflex.paper.tables.rows import Row
from tautflex.solvers.transient.status import Status
from tautflex.study import work


def call(tmp_path, *words):
    return main(["reproduce", *words, "--quick", "--workers", "1", "-o", str(tmp_path)])


@pytest.mark.slow
def test_tables_and_figures_without_runs(tmp_path, capsys):
    assert call(tmp_path, "--table", "2", "--figure", "3", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    rows = found["tables"]["2"]
    assert [row["paper"] for row in rows] == [row["frequency"] for row in published.table(2)]
    assert all(abs(row["ours"] / row["paper"] - 1.0) < 0.04 for row in rows)
    assert sum(abs(row["ours"] / row["paper"] - 1.0) for row in rows) < 10 * 0.01
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["figure_3.png"]
    with (tmp_path / "comparison.csv").open(encoding="utf-8", newline="") as file:
        listed = [line for line in csv.DictReader(file) if line["table"] == "2"]
    assert [line["ours"] for line in listed] == [f"{row['ours']:.6g}" for row in rows]
    assert call(tmp_path, "--table", "2") == 0
    card = capsys.readouterr().out
    assert f"{rows[0]['ours']:.4f}" in card
    assert "comparison.csv" in card


@pytest.mark.slow
def test_a_second_call_uses_the_runs_of_the_first(tmp_path, capsys, monkeypatch):
    assert call(tmp_path, "--table", "7", "--json") == 0
    first = json.loads(capsys.readouterr().out)
    assert len(list((tmp_path / "runs").glob("*/*.nc"))) == 3
    monkeypatch.setattr(work, "simulated", lambda *given: pytest.fail("performed again"))
    assert call(tmp_path, "--table", "7", "--json") == 0
    assert json.loads(capsys.readouterr().out)["tables"] == first["tables"]


def test_interruption_is_one_line_and_a_status(tmp_path, capsys, monkeypatch):
    """A run that Ctrl-C ended comes back as far as it got."""

    def interrupted(case, ready, tell):
        return SimpleNamespace(status=Status.INTERRUPTED), ""

    monkeypatch.setattr(work, "simulated", interrupted)
    assert call(tmp_path, "--table", "7") == 130
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines()[-1].endswith("repeat the command to go on")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--table", "5"], "--table: expected one of"),
        (["--figure", "99"], "--figure: expected one of"),
        (["--table", "convergence"], "leave out --quick"),
        (["--table", "2", "--workers", "0"], "--workers: expected a number >= 1"),
    ],
)
def test_refusals(tmp_path, capsys, words, told):
    assert main(["reproduce", "--quick", *words, "-o", str(tmp_path / "out")]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_answer_has_every_reading():
    """`ours` is m2-paper's; the others stand beside it by the names of their templates."""

    def rows(variant, factor):
        row = Row("7", "M3", "amplitude", 1.412, factor * 1.412, "mm", "", variant)
        return [row, Row("7", "M3", "amplitude", 1.412, 9.0, "mm", "", variant, repeats="6")]

    made = _Made(
        {
            ("published", "7"): rows("published", 1.0),
            ("nearest-node", "7"): rows("nearest-node", 0.5),
            ("consistent", "7"): rows("consistent", 2.0),
            ("consistent", "compression"): [Row("compression", "M3", "time", None, 1.0, "s", "", "consistent")],
        },
        [],
        {},
        1.0,
    )
    found = _answer(made)
    (row,) = found["tables"]["7"]
    assert row["ours"] == row["readings"]["m2-paper"] == 1.412e-3
    assert row["readings"] == {"m2-paper": 1.412e-3, "m2-nearest-node": 0.706e-3, "m2": 2.824e-3}
    (extra,) = found["extra"]["compression"]
    assert (extra["reading"], extra["ours"]) == ("m2", 1.0)
