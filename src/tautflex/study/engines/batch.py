"""Reduced points side by side on JAX (extra ``batch``): those that share a structure are one batch."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tautflex.case import build
from tautflex.case.registry import METHODS
from tautflex.case.schema import Case
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.status import Status
from tautflex.study.measures import probe_measures
from tautflex.study.work import Outcome, Task, perform_point, prepared

_BLOCK = 512  # runs whose records are held at the same time
# Sections whose numbers may differ from run to run; all else is the structure's or that of all runs.
_SECTIONS = ("damping", "maneuver")


def refusal(case: Case, values: Mapping[str, Sequence[Any]], task: Task) -> str | None:
    """Why points cannot be batches, None if they can; ``values`` has those of every axis."""
    if importlib.util.find_spec("jax") is None:
        return "expected the package jax for a batch, not installed; pip install 'tautflex[batch]'"
    if case.reduction is None:
        return "expected a [reduction] in the case for a batch, got none; add it, or set kind = 'serial'"
    if task.names is None or not task.names or not all(name.startswith("probes.") for name in task.names):
        return "expected measures.names of probes alone for a batch; name for example 'probes.A.amplitude'"
    if task.store.records:
        return "expected measures.records = false for a batch, got true; a batch keeps no record"
    method = METHODS[case.solver.method]
    if case.controller is not None or not (issubclass(method, CentralDifference) or _implicit(case)):
        return f"expected an open loop and a method of batches, got {case.solver.method!r}; set kind = 'serial'"
    for name in ("initial_imperfection", "max_halvings"):
        if getattr(case.solver, name):
            return f"expected no solver.{name} for a batch, got one; remove it, or set kind = 'serial'"
    if case.output.every != 1:
        return f"expected output.every = 1 for a batch, got {case.output.every}; remove it"
    for name, column in values.items():
        section, _, key = name.partition(".")
        numbers = all(isinstance(one, int | float) and not isinstance(one, bool) for one in column)
        if section in ("solver", "coupling", "output") or (section in _SECTIONS and not (key and numbers)):
            return f"expected axes of numbers of the maneuver or damping, or of the structure, got {name}"
    return None


def _implicit(case: Case) -> bool:
    method = case.solver.build()
    return isinstance(method, Method) and not method.average_stress


def perform(task: Task, structures: Sequence[Sequence[int]], keys: Sequence[str]) -> Iterator[list[Outcome]]:
    """Perform points, those of each structure as batches; one that fails there is run alone, which may halve steps.

    ``keys`` are those of all points, see `case_key`.
    """
    for numbers in structures:
        batch: Any = None
        for first in range(0, len(numbers), _BLOCK):
            block = numbers[first : first + _BLOCK]
            if batch is None:
                from tautflex.batch import Batch
                from tautflex.batch.chunks import usual_chunk

                batch = Batch(prepared(task.points.case(block[0])).plant)
                at_once = usual_chunk(len(block), reduced=True)  # of the short last block too: it is compiled for it
            yield _block(task, batch, block, keys, at_once)


def _block(task: Task, batch: Any, numbers: Sequence[int], keys: Sequence[str], at_once: int) -> list[Outcome]:
    first = task.points.case(numbers[0])
    ready = prepared(first)
    data = batch.simulate(
        _parameters(task, numbers),
        build.build_maneuver(first),
        store=("displacement",),
        chunk=at_once,
        throw=False,
        method=first.solver.build(),
        time_step=first.solver.time_step,
        end_time=first.solver.end_time,
        damping=build.build_damping(first, ready.state),
        coupling=first.coupling.build(),
        inputs=ready.inputs,
        probes=first.output.probes,
        probe_reading=first.output.probe_reading,
        **({} if first.solver.tolerance is None else {"tolerance": first.solver.tolerance}),
    )
    outcomes = []
    for place, number in enumerate(numbers):
        if data["status"].values[place] != Status.COMPLETED.value:
            outcomes.append(perform_point(task, number))
            continue
        assert task.names is not None
        content = {
            "point": task.points.name(number),
            "status": Status.COMPLETED.value,
            "message": "",
            "measures": probe_measures(data, place, task.names),
            "warnings": [*ready.state.warnings, *data.attrs["warnings"]],
        }
        task.store.write(keys[number], content)
        outcomes.append(Outcome(number, Status.COMPLETED.value, "", new=True))
    return outcomes


def _parameters(task: Task, numbers: Sequence[int]) -> dict[str, list[float]]:
    """Numbers of the maneuver and the damping that differ, one per run."""
    given = [task.points.values(number) for number in numbers]  # type: ignore[attr-defined]
    names = [name for name in given[0] if name.partition(".")[0] in _SECTIONS]
    return {name: [float(values[name]) for values in given] for name in names}
