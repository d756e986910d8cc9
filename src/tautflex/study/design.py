"""Search for the best values of keys: trials chosen by Optuna, run as points of a study (extra ``design``)."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import xarray as xr

from tautflex import checks
from tautflex.errors import CaseError
from tautflex.files import netcdf
from tautflex.files.transaction import result_folder
from tautflex.study.points import Grid
from tautflex.study.reading import load_study
from tautflex.study.results import Figures, write_table, write_together
from tautflex.study.search import JOURNAL, Search
from tautflex.study.sections import Study
from tautflex.study.sweep import mark, require_own_folder, with_workers, workforce
from tautflex.study.work import Task
from tautflex.writing import write_text

Progress = Callable[[float, str], None]


def design(
    study: Study | str | os.PathLike[str],
    directory: str | os.PathLike[str],
    *,
    trials: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    force: bool = False,
) -> xr.Dataset:
    """Search the values of a case's keys that make measures small or large within limits.

    Trials are chosen by the tree-structured Parzen estimator [Bergstra et al. 2011] of Optuna, with constraints. They
    stand in a journal, and their points in files: after an end of any kind the same call goes on, to the same result.

    Parameters
    ----------
    study
        Study with a [design], or its file; its axes do not count.
    directory
        Where results are kept; made if missing: ``journal.log``, ``points/``, ``design.nc``, ``trials.csv`` and
        ``best.toml``, the case of the best trial.
    trials
        Number of trials in all, in place of the study's: more of them go on with an earlier search.
    workers, scheduler, progress, force
        As for :func:`tautflex.sweep`; as many trials as the study says are ``together`` run at the same time.

    Returns
    -------
    xarray.Dataset
        Over ``trial``: the variables, ``objective`` (trial, measure), the measures that are limited, ``feasible``,
        ``status`` and ``message``. Attribute ``best``: numbers of the trials that no other one beats in every
        objective, one if there is one objective, none if no trial keeps the limits.

    Raises
    ------
    InputError
        If an argument or the study is wrong, or another process works in the directory.
    NotWrittenError
        If the directory cannot be written.
    MissingExtraError
        If Optuna is not installed.

    Examples
    --------
    >>> import tautflex as tf
    >>> case = tf.load_case("m2.toml", ["solver.time_step=0.01", "solver.end_time=1.5"])
    >>> chosen = {"variables": {"maneuver.duration": {"from": 0.5, "to": 1.0}}, "minimize": ["probes.A.amplitude"]}
    >>> found = tf.design(tf.Study(base=case, design=chosen), "best", trials=2, workers=1)
    >>> found.sizes["trial"]
    2
    """
    return write_design(
        study, directory, trials=trials, workers=workers, scheduler=scheduler, progress=progress, force=force
    )[0]


def write_design(
    study: Study | str | os.PathLike[str],
    directory: str | os.PathLike[str],
    *,
    trials: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    force: bool = False,
    figures: Figures | None = None,
) -> tuple[xr.Dataset, dict[str, Path]]:
    """Search as `design` says, no other command in the folder; the trials, and files by name, figures too."""
    given = study if isinstance(study, Study) else load_study(study)
    folder, tell = checks.path("directory", directory), checks.teller(progress)
    wanted = given.design
    if wanted is None:
        raise CaseError("design: missing, expected a [design] section; `tautflex init --template study` shows one")
    asked = wanted.trials if trials is None else checks.whole("trials", trials, 1)
    given = with_workers(given, workers, scheduler)
    require_own_folder(folder, force)
    with result_folder(folder), _whole_journal(folder / JOURNAL):
        search = Search(given, wanted, folder)
        with workforce(given.engine, wanted.together) as engine:
            mark(folder)
            search.store.sweep_leftovers()
            while len(search.finished) < asked:
                chosen = search.next_trials(asked)
                points = Grid(search.base, [[search.keys_of(trial) for trial in chosen]])
                task = Task.of(points, search.store, search.names)
                for outcomes in engine.perform(task, [[number] for number in range(len(chosen))]):
                    for one in outcomes:
                        search.tell(chosen[one.number], one.status, one.message)
                    tell(len(search.finished) / asked, f"{len(search.finished)} of {asked} trials")
        data = search.dataset()
        files: dict[str, Callable[[Path], object]] = {
            "design.nc": partial(netcdf.save, data),
            "trials.csv": partial(write_table, data.drop_dims("measure")),
        }
        if data.attrs["best"]:
            best = search.case_of(data.attrs["best"][0]).to_toml()
            files["best.toml"] = lambda path: write_text(path, best)
        return data, write_together(folder, files, None if figures is None else partial(figures, data))


@contextmanager
def _whole_journal(path: Path) -> Iterator[None]:
    """Make one line of a journal that was damaged, or removed while the search goes on."""
    try:
        yield
    except json.JSONDecodeError as error:
        text = f"{path}: expected the whole journal of a search, got a damaged one ({error})"
        raise CaseError(f"{text}; remove the file and repeat the command: finished points are kept") from None
