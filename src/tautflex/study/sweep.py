"""A study from its points to one Dataset: planned, performed, put together."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

import xarray as xr

from tautflex import checks
from tautflex._version import __version__
from tautflex.case.prepared import structure_key
from tautflex.errors import CaseError
from tautflex.files import netcdf
from tautflex.files.transaction import result_folder
from tautflex.study.axes import values_of
from tautflex.study.engines import batch
from tautflex.study.engines.dask import Cluster
from tautflex.study.engines.serial import Pool
from tautflex.study.measures import check_names
from tautflex.study.points import Grid
from tautflex.study.reading import load_study
from tautflex.study.results import Figures, study_dataset, write_table, write_together
from tautflex.study.sections import Engine, Study
from tautflex.study.store import Store, case_key, code_key
from tautflex.study.work import INVALID, Outcome, Task
from tautflex.writing import write_text

Progress = Callable[[float, str], None]
_LARGEST_CHUNK = 32  # points that a worker is given at a time
_WORTH_A_BATCH = 200  # points of one structure: compiling takes as long as some hundred runs


def sweep(
    study: Study | str | os.PathLike[str],
    directory: str | os.PathLike[str],
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    force: bool = False,
) -> xr.Dataset:
    """Run a case at all combinations of the values of a study's axes.

    Every point writes a small file when it is finished, and is not computed again: after an end of any kind the same
    call goes on. A point that fails is labelled and does not end the study. With several workers, processes are
    spawned: a script that calls this needs the usual ``if __name__ == "__main__":``.

    Parameters
    ----------
    study
        Study, or its file.
    directory
        Where results are kept; made if missing: ``points/``, ``study.nc`` and ``table.csv``.
    workers
        Processes, those of the study by default, else one per core; 1 stays in this one.
    scheduler
        Address of a running Dask scheduler, in place of the study's engine.
    progress
        Called with the fraction of points done and a short message; KeyboardInterrupt raised in it ends the study.
    force
        Go on in a folder with points of another version of tautflex, which are not used.

    Returns
    -------
    xarray.Dataset
        A dimension for each axis, or group of axes that change together; the measures, ``status`` and ``message`` of
        every point. Attributes ``resumed`` (points that were there) and ``seconds``.

    Raises
    ------
    InputError
        If an argument or the study is wrong, no point of it is valid, or another process works in the directory.
    NotWrittenError
        If the directory cannot be written.
    WorkerLostError
        If a worker process died.
    MissingExtraError
        If the engine's package is not installed.

    Examples
    --------
    >>> import tautflex as tf
    >>> case = tf.load_case("m2.toml", ["solver.time_step=0.01", "solver.end_time=1.5"])
    >>> study = tf.Study(base=case, axes={"maneuver.duration": [0.5, 1.0]})
    >>> data = tf.sweep(study, "study", workers=1)
    >>> data["probes.A.amplitude"].shape
    (2,)
    """
    folder, tell = checks.path("directory", directory), checks.teller(progress)
    plan = make_plan(study, folder, workers=workers, scheduler=scheduler, force=force)
    return write_sweep(plan, folder, tell)[0]


def write_sweep(
    plan: Plan, directory: Path, progress: Progress | None = None, figures: Figures | None = None
) -> tuple[xr.Dataset, dict[str, Path]]:
    """Perform a plan as `sweep` says, no other command in its folder; the Dataset, and files by name, figures too."""
    with result_folder(directory):
        data = _performed(plan, checks.teller(progress))
        files = {"study.nc": partial(netcdf.save, data), "table.csv": partial(write_table, data)}
        return data, write_together(directory, files, None if figures is None else partial(figures, data))


def _performed(plan: Plan, tell: Progress) -> xr.Dataset:
    started = time.perf_counter()
    plan.task.store.sweep_leftovers()
    unkept = {number: (INVALID, message) for number, message in plan.invalid.items()}
    done, failed, count = len(plan.points) - len(plan.todo), len(unkept), len(plan.points)
    with closing(perform_plan(plan)) as performed:
        for outcomes in performed:
            for one in outcomes:
                unkept[one.number] = one.status, one.message
                failed += one.status != "completed"
            done += len(outcomes)
            tell(done / count, f"{done} of {count} points" + (f", {failed} failed" if failed else ""))
    data = study_dataset(plan.study, plan.points, plan.task.store, plan.keys, unkept)
    data.attrs |= {"resumed": plan.resumed, "seconds": time.perf_counter() - started}
    return data


@dataclass(frozen=True)
class Plan:
    """What a study asks for, before anything runs.

    Parameters
    ----------
    study
        With the engine that was chosen.
    points, task
        Its points, and what workers are told.
    keys
        Key of each point, "" of one that is not valid.
    todo
        Structure and number of each point that is not finished, those of one structure together.
    invalid
        Number -> message of points whose case is not valid.
    """

    study: Study
    points: Grid
    task: Task
    keys: list[str]
    todo: list[tuple[str, int]]
    invalid: dict[int, str]

    @property
    def resumed(self) -> int:
        """Number of points that are finished already."""
        return len(self.points) - len(self.todo) - len(self.invalid)

    def chunks(self, workers: int) -> list[list[int]]:
        """Points in the order of their structures, a few at a time."""
        size = max(1, min(_LARGEST_CHUNK, len(self.todo) // (8 * workers)))
        numbers = [number for _, number in self.todo]
        return [numbers[first : first + size] for first in range(0, len(numbers), size)]

    def structures(self) -> list[list[int]]:
        """Points of each structure."""
        return [[number for _, number in group] for _, group in groupby(self.todo, lambda one: one[0])]


def make_plan(
    study: Study | str | os.PathLike[str],
    directory: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
) -> Plan:
    """Check a study, its axes and every point's case, look what is finished, and choose an engine; nothing is written.

    Raises
    ------
    InputError
        One line: what is wrong with the study, or with the folder.
    """
    given = with_workers(study if isinstance(study, Study) else load_study(study), workers, scheduler)
    if not given.axes:
        raise CaseError(
            "axes: missing, expected at least one; add for example [axes] with 'maneuver.duration' = [1, 2]"
        )
    require_own_folder(directory, force)
    points = Grid.of(given)
    check_names(given.measures.names, points.start)
    task = Task.of(points, Store(directory / "points", given.measures.records), given.measures.names)
    keys, todo, invalid = list[str](), list[tuple[str, int]](), dict[int, str]()
    for number in range(len(points)):
        try:
            case = points.case(number)
        except CaseError as error:
            if "unknown key" in str(error):
                raise error.behind("axes.") from None
            invalid[number] = "; ".join(error.problems)
            keys.append("")
            continue
        keys.append(case_key(case))
        if task.store.read(keys[-1]) is None:
            todo.append((structure_key(case), number))
    if len(invalid) == len(points):
        raise CaseError(f"axes: expected at least one valid point, got none: {invalid[0]}")
    order: dict[str, int] = {}
    for key, number in todo:
        order.setdefault(key, number)
    todo.sort(key=lambda one: (order[one[0]], one[1]))
    return _with_engine(Plan(given, points, task, keys, todo, invalid), workers is not None)


def with_workers(study: Study, workers: int | None, scheduler: str | None) -> Study:
    """Study whose engine has the workers and the scheduler of a call, its own where that names none."""
    engine = study.engine
    if workers is not None:
        engine = engine.model_copy(update={"workers": checks.whole("workers", workers, 1)})
    if scheduler is not None:
        checks.instance("scheduler", scheduler, str, "an address such as 'tcp://10.0.0.1:8786'")
        engine = engine.model_copy(update={"scheduler": scheduler})
    if engine.scheduler is not None:
        engine = engine.model_copy(update={"kind": "dask"})
    return study.model_copy(update={"engine": engine})


def _with_engine(plan: Plan, processes: bool) -> Plan:
    """Plan with its engine chosen; ``processes`` tells whether a number of them was asked for."""
    kind = plan.study.engine.kind
    if kind not in ("auto", "batch"):
        return plan
    reason = batch.refusal(
        plan.points.start, {name: values_of(axis) for name, axis in plan.study.axes.items()}, plan.task
    )
    if kind == "batch" and reason is not None:
        raise CaseError(f"engine.kind: {reason}")
    many = reason is None and not processes and len(plan.todo) >= _WORTH_A_BATCH * max(1, len(plan.structures()))
    chosen = plan.study.engine.model_copy(update={"kind": "batch" if many or kind == "batch" else "serial"})
    return replace(plan, study=plan.study.model_copy(update={"engine": chosen}))


def perform_plan(plan: Plan) -> Generator[Sequence[Outcome], None, None]:
    """Perform what a plan lacks, by its engine."""
    chosen, folder = plan.study.engine, plan.task.store.directory.parent
    if plan.todo and chosen.kind == "batch":
        mark(folder)
        yield from batch.perform(plan.task, plan.structures(), plan.keys)
    elif plan.todo:
        with workforce(chosen, len(plan.todo)) as engine:
            mark(folder)
            yield from engine.perform(plan.task, plan.chunks(chosen.workers or os.cpu_count() or 1))


def workforce(engine: Engine, most: int) -> Pool | Cluster:
    """Processes or a cluster for at most so many points at a time."""
    if engine.kind == "dask":
        return Cluster(engine.workers, engine.scheduler)
    return Pool(min(engine.workers or os.cpu_count() or 1, most))


def _marker(directory: Path) -> Path:
    return directory / "points" / "code.json"


def require_own_folder(directory: Path, force: bool) -> None:
    """Raise CaseError if a folder holds points of another version, or ones of which it cannot tell."""
    checks.flag("force", force)
    marker = _marker(directory)
    if force or not any(marker.parent.glob("??/*.json")):
        return
    try:
        found: Any = json.loads(marker.read_bytes())
        code, other = found["code"], found["version"]
    except (OSError, ValueError, LookupError, TypeError) as error:
        text = f"{marker}: expected the version of tautflex that its points are of, got no such file or a damaged one"
        remedy = "--force (force=True) uses points of this version and computes others anew"
        raise CaseError(f"{text} ({type(error).__name__}); {remedy}, or choose another folder") from None
    if code != code_key():
        which = (
            f"version {other}" if other != __version__ else f"other sources or plugins than these of version {other}"
        )
        text = f"{directory}: expected no points of another tautflex, got those of {which}"
        raise CaseError(f"{text}; choose another folder, or --force (force=True) computes all points anew beside them")


def mark(directory: Path) -> None:
    """Write which version the points of a folder are of."""
    write_text(_marker(directory), json.dumps({"version": __version__, "code": code_key()}) + "\n")
