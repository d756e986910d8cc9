"""Examples in docstrings run, and print what stands there; none is left out.

They run in a folder with the files that they read: `m2.toml` of the template `m2-nearest-node` and its run `m2`,
`slew.toml` of `control`, `scalloped.toml`, `task.toml` of `task-slew`, `study.toml`, and the mesh `sail.inp`.
"""

from __future__ import annotations

import ast
import doctest
import importlib.util
from pathlib import Path

import pytest

import tautflex as tf
from tautflex.case import template, template_files

ROOT = Path(tf.__file__).parent
FILES = {"m2": "m2-nearest-node", "slew": "control", "scalloped": "scalloped", "task": "task-slew", "study": "study"}
# Beside these every example takes less than 0.9 s of a processor that has nothing else to do.
SLOW = {"animate", "control_case", "design", "plot_time_history", "reduce", "report", "save", "sweep", "write_vtu"}
SLOW |= {"Batch", "CompiledPlant", "close_loop", "evaluate", "explore", "tune_law"}
NEEDED = {"Batch": "jax", "design": "optuna"}


def examples():
    """A docstring with lines to run, by the name of what it is about."""
    for path in sorted(ROOT.rglob("*.py")):
        text = path.read_text("utf-8")
        if ">>>" not in text:
            continue
        tree = ast.parse(text)
        owners = {id(child): node.name for node in tree.body if isinstance(node, ast.ClassDef) for child in node.body}
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ">>>" in (
                ast.get_docstring(node) or ""
            ):
                name = getattr(node, "name", "tautflex")
                place = f"{owners[id(node)]}.{name}" if id(node) in owners else name
                marks = [pytest.mark.slow] * (name in SLOW) + [pytest.mark.jax] * (name == "Batch")
                yield pytest.param(ast.get_docstring(node), place, id=place, marks=marks)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What examples read."""
    place = tmp_path_factory.mktemp("examples")
    for name, kind in FILES.items():
        (place / f"{name}.toml").write_text(template(kind), "utf-8")
    for name, text in (template_files("sail") | template_files("study")).items():
        (place / name).write_text(text, "utf-8")
    (place / "m2").mkdir()
    case = tf.load_case(place / "m2.toml", ["solver.time_step=0.01", "solver.end_time=1.5"])
    tf.save(tf.run_case(case), place / "m2" / "run.nc")
    return place


@pytest.mark.parametrize(("text", "name"), list(examples()))
def test_example_prints_what_stands_there(text, name, folder, monkeypatch):
    needed = NEEDED.get(name)
    if needed is not None and importlib.util.find_spec(needed) is None:
        pytest.skip(f"{needed} is not installed")
    monkeypatch.chdir(folder)
    asked = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    assert not any(option == doctest.SKIP for each in asked.examples for option in each.options), "an example runs"
    told: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(asked, out=told.append)
    assert not told, "".join(told)


def test_names_that_users_reach_for_first_have_examples():
    """All names of the README's Python, and enough of the others."""
    found = {parameters.values[1] for parameters in examples()}
    assert len(found) >= 70
    assert {
        "build_model",
        "load_case",
        "solve_prestress",
        "solve_modes",
        "TransientProblem",
        "run_case",
        "reduce",
    } <= found
