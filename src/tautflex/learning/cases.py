"""Cases of the registered tasks, whose numbers are frozen."""

from __future__ import annotations

from importlib.resources import files
from os import PathLike

from tautflex import checks
from tautflex.case.reading import load_case, parse_case
from tautflex.case.schema import Case

TASKS = ("slew", "stop", "hold")


def task_case(name: str) -> Case:
    """Case of a registered task: ``"slew"``, ``"stop"`` or ``"hold"``; InputError for another name."""
    checks.one_of("task", name, TASKS)
    text = files("tautflex").joinpath("data", "tasks", f"{name}.toml").read_text(encoding="utf-8")
    return parse_case(text, source=f"{name}.toml")


def case_of(given: Case | str | PathLike[str] | None, name: str) -> Case:
    """Case that was given as such or by its file; None is that of a task."""
    if given is None:
        return task_case(name)
    return given if isinstance(given, Case) else load_case(checks.path("case", given))
