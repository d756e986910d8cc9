"""Bad input on the command line: exit code 2, one line with key, value and remedy, nothing written."""

from __future__ import annotations

import json
import os
import sys

import pytest

from tautflex.case import TEMPLATES, template, template_files
from tautflex.case.registry import DAMPINGS
from tautflex.cli import main

M2_TEMPLATE = template("m2-nearest-node")

# A plain film whose four edges are fixed: the smallest case there is.
FILM = """
schema = 1
[membrane]
length = 2.0
width = 1.0
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 4000.0
stress_y = 4000.0
[mesh]
divisions = [4, 2]
[solver]
end_time = 0.01
"""


@pytest.fixture
def refuse(tmp_path, monkeypatch, capsys):
    """Return a function that runs a command, checks that it is refused properly, and returns the message."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments, text=M2_TEMPLATE):
        case = tmp_path / "case.toml"
        if isinstance(text, bytes):
            case.write_bytes(text)
        else:
            case.write_text(text, encoding="utf-8")
        before = sorted(tmp_path.rglob("*"))
        code = main(list(arguments))
        captured = capsys.readouterr()
        assert code == 2
        assert captured.out == ""
        assert captured.err.startswith("tautflex: error: ")
        assert captured.err.endswith("\n")
        assert captured.err.count("\n") == 1
        assert sorted(tmp_path.rglob("*")) == before, "something was written"
        return captured.err

    return run


# override, and what the line must name: key, value or expectation, remedy
ROWS = {
    "unknown key": ("membrane.thicknes=1e-4", ["membrane.thicknes", "0.0001", "did you mean 'thickness'?"]),
    "unknown section": ("membran.length=1", ["membran", "expected one of", "did you mean 'membrane'?"]),
    "text for a number": ("membrane.thickness=thin", ["membrane.thickness", "'thin'", "a number", "0.0001"]),
    "truth value for a number": ("membrane.width=true", ["membrane.width", "true", "a number"]),
    "fraction for an integer": ("output.every=1.5", ["output.every", "1.5", "an integer"]),
    "number for a truth value": ("coupling.euler=1", ["coupling.euler", "got 1", "true or false"]),
    "value for a section": ("membrane=3", ["membrane", "got 3", "a table"]),
    "list too short": ("mesh.divisions=[10]", ["mesh.divisions", "[10]", "cells along x and y"]),
    "zero thickness": ("membrane.thickness=0", ["membrane.thickness", "got 0", "> 0", "0.0001"]),
    "negative thickness": ("membrane.thickness=-1e-4", ["membrane.thickness", "-0.0001", "> 0"]),
    "zero film density": ("membrane.density=0.0", ["membrane.density", "got 0", "> 0", "1530"]),
    "negative cable density": ("cables.density=-1", ["cables.density", "got -1", "> 0", "1440"]),
    "negative frame density": ("frame.density=-1", ["frame.density", "got -1", "> 0", "1380"]),
    "zero time step": ("solver.time_step=0", ["solver.time_step", "got 0", "> 0", "0.001"]),
    "negative time step": ("solver.time_step=-1e-3", ["solver.time_step", "-0.001", "> 0"]),
    "NaN": ("membrane.youngs_modulus=nan", ["membrane.youngs_modulus", "nan", "finite"]),
    "infinity": ("maneuver.rate=inf", ["maneuver.rate", "inf", "finite"]),
    "negative infinity": ("frame.area=-inf", ["frame.area", "-inf", "finite"]),
    "NaN in a list": ("output.probes.A=[nan,0]", ["output.probes.A", "nan", "finite"]),
    "Poisson 0.5": (
        "membrane.poisson_ratio=0.5",
        ["membrane.poisson_ratio", "0.5", "(-1, 0.5)", "0.3 to 0.4"],
    ),
    "Poisson -1": ("membrane.poisson_ratio=-1", ["membrane.poisson_ratio", "-1", "(-1, 0.5)"]),
    "Poisson of the frame": ("frame.poisson_ratio=0.6", ["frame.poisson_ratio", "0.6", "(-1, 0.5)"]),
    "probe off the film, x": (
        "output.probes.A=[1.01,0]",
        ["output.probes.A", "[1.01, 0.0]", "|x| <= 1", "move"],
    ),
    "probe off the film, y": ("output.probes.B=[0,-0.6]", ["output.probes.B", "[0.0, -0.6]", "|y| <= 0.5"]),
    "zero pretension": ("cables.pretension_x=0", ["cables.pretension_x", "got 0", "> 0", "singular", "give"]),
    "negative pretension": ("cables.pretension_y=-1", ["cables.pretension_y", "got -1", "> 0"]),
    "mesh beyond memory": ("mesh.divisions=[1000000,1000000]", ["mesh.divisions", "1e+06", "GB", "fewer"]),
    "history beyond memory": ("solver.time_step=1e-12", ["output.every", "memory", "raise every"]),
    "too few nodes for cables": (
        "mesh.divisions=[5,5]",
        ["mesh.divisions", "[5, 5]", "at least 10", "refine"],
    ),
    "frame inside film": ("frame.width=0.9", ["frame.width", "0.9", "membrane.width = 1", "enlarge"]),
    "option of another method": ("solver.rho_inf=0.8", ["solver.rho_inf", "0.8", "'wilson-theta'", "remove"]),
    "unknown method": ("solver.method=rk4", ["solver.method", "'rk4'", "'generalized-alpha'"]),
    "unknown support": ("frame.support=left", ["frame.support", "'left'", "'short-side'"]),
    "unknown law": ("membrane.law=plastic", ["membrane.law", "'plastic'", "'elastic'", "'tension-field'"]),
    "slack is no number": ("cables.slack=1", ["cables.slack", "got 1", "true or false"]),
    "end before first step": ("solver.end_time=1e-4", ["solver.end_time", "0.0001", "time_step", "longer"]),
    "stop without length": ("maneuver.duration=0", ["maneuver.duration", "got 0", "> 0"]),
    "axis without direction": ("maneuver.axis=[0,0,0]", ["maneuver.axis", "non-zero", "[1, 0, 0]"]),
    "stress stated twice": ("membrane.stress_x=1", ["membrane.stress_y", "stress_x = 1", "add"]),
    "other schema": ("schema=2", ["schema", "got 2", "expected 1", "tautflex init"]),
    "override without value": ("damping.alpha", ["--set", "damping.alpha", "section.key=value"]),
    "override into a value": ("membrane.length.x=1", ["--set", "'length' is a value"]),
}


@pytest.mark.parametrize(("override", "words"), ROWS.values(), ids=ROWS.keys())
def test_run_refuses_a_bad_key(refuse, override, words):
    message = refuse("run", "case.toml", "-o", "out", "--set", override)
    for word in words:
        assert word in message
    assert "case.toml: " in message or "--set: " in message


@pytest.mark.parametrize("key", ["length", "thickness", "density", "youngs_modulus", "poisson_ratio"])
def test_missing_key_is_named_with_an_example(refuse, key):
    lines = [line for line in FILM.splitlines() if not line.startswith(f"{key} =")]
    message = refuse("run", "case.toml", text="\n".join(lines))
    assert f"membrane.{key}: missing" in message
    assert f"for example {key} = " in message


def test_missing_section_is_named(refuse):
    message = refuse("check", "case.toml", text=M2_TEMPLATE.split("\n[frame]")[0])
    assert "frame: missing" in message
    assert "add it" in message


def test_missing_schema_is_named(refuse):
    assert "schema: missing, expected 1" in refuse("check", "case.toml", text=FILM.replace("schema = 1", ""))


def test_syntax_error_names_line_and_column(refuse):
    message = refuse("check", "case.toml", text="schema = 1\n[membrane\n")
    assert "line 2" in message
    assert "column" in message


def test_file_that_is_not_utf8(refuse):
    message = refuse("check", "case.toml", text=b"schema = 1\n# caf\xe9\n")
    assert "0xe9 at offset 16" in message
    assert "save the file as UTF-8" in message


def test_missing_file(refuse):
    assert "nowhere.toml: no such file; write one with `tautflex init" in refuse("run", "nowhere.toml")


def test_file_below_a_file(refuse):
    assert "cannot read the case file" in refuse("check", "case.toml/inner.toml")


def test_directory_instead_of_file(refuse):
    assert "got a directory" in refuse("modes", ".")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything")
def test_unreadable_file(refuse, tmp_path):
    secret = tmp_path / "secret.toml"
    secret.write_text(FILM, encoding="utf-8")
    secret.chmod(0)
    assert "cannot read the case file" in refuse("check", "secret.toml")


def test_compressive_prestress_says_where_how_much_and_what_to_do(refuse):
    message = refuse("run", "case.toml", "--set", "membrane.stress_x=-1.0", text=FILM)
    # -1 Pa in a film of 1e-4 m
    for words in ("case.toml", "film element", "compressed", "-0.0001 N/m", "positive stress_x"):
        assert words in message


def test_slack_film_is_singular(refuse):
    overrides = ["--set", "membrane.stress_x=0.0", "--set", "membrane.stress_y=0.0"]
    assert "singular" in refuse("run", "case.toml", *overrides, text=FILM)


def test_run_of_an_antenna_that_nothing_holds(refuse):
    message = refuse("run", "case.toml", "--set", "frame.support=free")
    assert "case.toml" in message
    assert "support" in message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fly"], ["fly", "init"]),
        (["run"], ["CASE"]),
        (["run", "case.toml", "surplus"], ["expected no more arguments, got 'surplus'", "`tautflex run --help`"]),
        (["--json", "check", "case.toml"], ["--json: expected a command before its options"]),
        (["init", "new.toml", "--template", "slw"], ["did you mean 'slew'"]),
        (["keys", "membran"], ["did you mean 'membrane'"]),
        (["sweep", "case.toml"], ["expected a study, got a case"]),
        (["run", "case.toml", "--sett", "a=b"], ["--sett"]),
        (["modes", "case.toml", "-n", "many"], ["-n", "many"]),
        (["modes", "case.toml", "-n", "0"], ["-n", "0", ">= 1"]),
        (["tune", "case.toml"], ["--frequency"]),
        (["tune", "case.toml", "--frequency", "1", "--frequency", "2", "--mode", "1"], ["--mode", "2 and 1"]),
    ],
)
def test_usage_errors_are_one_line_too(refuse, arguments, words):
    message = refuse(*arguments)
    for word in words:
        assert word in message


def test_a_study_is_no_case(refuse):
    assert "expected a case, got a study of 'm2-reduced.toml'" in refuse("run", "case.toml", text=template("study"))


def test_help_may_be_a_word(capsys):
    assert main(["help", "check"]) == 0
    assert "tautflex check" in capsys.readouterr().out


def test_tuning_a_film_without_cables(refuse):
    message = refuse("tune", "case.toml", "--frequency", "1", text=FILM)
    assert "membrane.edges: expected 'cables', got 'fixed'" in message


def test_init_keeps_an_existing_file(refuse, tmp_path):
    assert "--force" in refuse("init", "case.toml", text="mine")
    assert (tmp_path / "case.toml").read_text(encoding="utf-8") == "mine"
    assert main(["init", "case.toml", "--force", "--json"]) == 0
    assert (tmp_path / "case.toml").read_text(encoding="utf-8") == template("m2")


@pytest.mark.parametrize("name", TEMPLATES)
def test_init_writes_the_template_that_is_named(tmp_path, capsys, name):
    file = tmp_path / "case.toml"
    assert main(["init", str(file), "--template", name]) == 0
    assert file.read_text(encoding="utf-8") == template(name)
    for beside, text in template_files(name).items():
        assert (tmp_path / beside).read_text(encoding="utf-8") == text
    own = {"control": "control", "slew": "control", "task-slew": "train"}
    following = own.get(name, "evaluate" if name.startswith("task-") else "run")
    assert f"tautflex {following} {file}" in capsys.readouterr().out.replace("\n", "")


def test_init_without_such_a_template(refuse):
    message = refuse("init", "new.toml", "--template", "m3")
    known = (
        "'control', 'm2', 'm2-nearest-node', 'm2-paper', 'sail', 'scalloped', 'slew', 'task-hold', 'task-slew', "
        "'task-stop' or 'study'"
    )
    assert f"template: expected one of {known}, got 'm3'" in message


def test_init_keeps_a_mesh_that_is_there(refuse, tmp_path):
    (tmp_path / "sail.inp").write_text("mine", encoding="utf-8")
    assert "sail.inp: expected a new file" in refuse("init", "new.toml", "--template", "sail")
    assert not (tmp_path / "new.toml").exists()


def test_output_directory_that_is_a_file(refuse):
    message = refuse("run", "case.toml", "-o", "case.toml", text=FILM)
    assert "expected an output directory" in message


def test_tuned_case_needs_an_existing_directory(refuse):
    message = refuse("tune", "case.toml", "--frequency", "1", "-o", "nowhere/tuned.toml")
    assert "expected an existing directory" in message


def test_line_breaks_in_input_stay_on_the_error_line(refuse):
    assert r"no\nwhere.toml" in refuse("run", "no\nwhere.toml")


def test_check_as_json_answers_that_the_case_is_not_ok(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text(FILM.replace("1e-4", "-1.0"), encoding="utf-8")
    assert main(["check", str(case), "--json"]) == 2
    captured = capsys.readouterr()
    answer = json.loads(captured.out)
    assert answer["ok"] is False
    assert "membrane.thickness" in answer["error"]
    assert answer["error"] in captured.err


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["damping={kind='modal', ratio=0.01, modes=100000}"], "damping.modes: expected 1 to 402 modes, got 100000"),
        (["reduction={count=500, candidates=600}"], "reduction.count: expected at most the 401 modes of this mesh"),
        (["inputs.a={kind='cable-tension', cables=[0], change=[1.0, 2.0]}"], "inputs.a.change: expected one finite"),
        (["inputs.a={kind='nodal-force', near=[0.5, 'a'], force=[0, 0, 1]}"], "near: expected a number, got 'a' at in"),
    ],
)
def test_what_the_structure_has_no_room_for_is_known_to_check(overrides, words, refuse):
    said = refuse("check", "case.toml", *(part for one in overrides for part in ("--set", one)))
    assert f"case.toml: {words}" in said or words.startswith("near")
    assert words in said


PLUGIN = """
from dataclasses import dataclass
from typing import ClassVar
import numpy as np
import tautflex as tf
print("a word while it loads")

@tf.register
@dataclass(frozen=True)
class Chatty(tf.Damping):
    share: float
    table: np.ndarray | None = None  # no key: Python alone can give it
    {more}

    def matrix(self, structure):
        print("a word while it runs")
        return tf.DampingMatrix(mass=self.share)
"""


@pytest.fixture
def forgetful(monkeypatch):
    """What plugins register is forgotten behind the test; they leave no compiled file."""
    monkeypatch.setattr(DAMPINGS, "_classes", dict(DAMPINGS._classes))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)


@pytest.mark.usefixtures("forgetful")
def test_a_talking_plugin_leaves_stdout_to_the_json_object(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text(FILM + "[damping]\nkind = 'chatty'\nshare = 0.1\n", encoding="utf-8")
    (tmp_path / "chatty.py").write_text(PLUGIN.format(more=""), encoding="utf-8")
    assert main(["check", "case.toml", "--plugin", "chatty.py", "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["ok"]
    assert captured.err.count("a word while it") == 2
    case = (tmp_path / "case.toml").read_text(encoding="utf-8") + "table = [1.0]\n"
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    assert main(["check", "case.toml", "--plugin", "chatty.py"]) == 2
    assert "damping.table: unknown key" in " ".join(capsys.readouterr().err.split())


@pytest.mark.usefixtures("forgetful")
@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("kind: ClassVar[str] = 'two words'", "letters, digits and hyphens, got 'two words'"),
        ("kind: ClassVar[int] = 3", "letters, digits and hyphens, got 3"),
        ("kind: str = 'mine'", "expected no field kind in Odd"),
        ("path: set[int]", "Odd: expected path to be numbers, texts or true and false"),
    ],
)
def test_odd_classes_of_plugins_are_refused(more, words, refuse, tmp_path):
    odd = PLUGIN.replace("Chatty", "Odd").replace("share: float", more).replace("print(", "str(")
    (tmp_path / f"odd_{len(more)}.py").write_text(odd.format(more=""), encoding="utf-8")
    said = refuse("check", "case.toml", "--plugin", f"odd_{len(more)}.py", "--set", "damping.kind=odd")
    assert words in said


def test_every_problem_of_a_case_is_a_line_of_its_own(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "film.toml").write_text(FILM.replace("length = 2.0", "length = -2.0"))
    assert main(["check", "film.toml", "--set", "broken", "--set", "solver.end_time=x", "--json"]) == 2
    out, said = capsys.readouterr()
    lines = said.splitlines()
    assert [line.split(": expected")[0] for line in lines] == [
        "tautflex: error: --set",
        "tautflex: error: film.toml: membrane.length",
        "tautflex: error: film.toml: solver.end_time",
    ]
    assert json.loads(out)["error"].split("\n") == [line.removeprefix("tautflex: error: ") for line in lines]
