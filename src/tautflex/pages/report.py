"""Report of a run as a page that stands alone: the antenna as it turns and rings, its curves, modes and numbers."""

from __future__ import annotations

import os
from pathlib import Path

import xarray as xr

from tautflex import checks
from tautflex._version import __version__
from tautflex.errors import InputError
from tautflex.files.results import results_of_a_run
from tautflex.pages.assemble import assembled, page_file
from tautflex.pages.content import content_of
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import RUN, dataset_of
from tautflex.writing import write_text

# Bytes of the page [MB] that everything but frames takes: library, curves, modes, text; and of every run.
_LIBRARY, _FIXED = 1.1, 0.6


@results_of_a_run()
def report(
    run: xr.Dataset | Run,
    path: str | os.PathLike[str],
    *,
    other: xr.Dataset | Run | None = None,
    state: PrestressedState | None = None,
    folder: str | os.PathLike[str] = ".",
    size: float = 6.0,
    names: tuple[str, str] = ("A", "B"),
) -> Path:
    """Write a run as one HTML file that opens in any browser, without a network.

    It shows the structure in 3-D as it turns and rings, its modes, the records of the run with one cursor in time,
    spectrum and scalogram of the liveliest probe, numbers, warnings, versions and the text of the case.

    Parameters
    ----------
    run
        A run with frames, or its Dataset, also from ``load("run.nc")``.
    path
        File to write, ``*.html``.
    other
        A second run, shown beside the first one with the same time, camera and controls.
    state
        Prestressed state of a run that was not made from a case file: modes and cable tensions are those of it.
    folder
        Where files that the text of the case names are sought.
    size
        Largest size of the page [MB], 2 or more; frames and meshes beyond it are thinned, and the page says to what.
    names
        What two runs are called.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        If the run has no frames, or an argument is out of range.
    NotWrittenError
        If the file cannot be written.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.report(run, "stop.html").name
    'stop.html'
    """
    given = [run] if other is None else [run, other]
    data = [_framed(each, "run" if number == 0 else "other") for number, each in enumerate(given)]
    target, place = page_file(path, "report.html"), checks.path("folder", folder)
    if not checks.finite("size", size) >= 2.0:
        raise InputError(f"size: expected 2 MB or more, which hold the page and a picture, got {size:g}; try 6")
    checks.instance("state", state, (PrestressedState, type(None)), "a prestressed state, or None")
    if state is not None and any(each.sizes["node"] != len(state.model.nodes) for each in data):
        text = f"state: expected the state of this run, got one of {len(state.model.nodes)} nodes"
        raise InputError(f"{text}; leave it out where two runs are of two structures")
    called = checks.several("names", names, str, "'before', 'after'")
    if len(called) < len(data):
        raise InputError(f"names: expected {len(data)} names, got {len(called)}")
    budget = 1e6 * max(0.2, (size - _LIBRARY) / len(data) - _FIXED)
    runs = [content_of(each, name, place, state, budget) for each, name in zip(data, called, strict=False)]
    titles = {each["title"] for each in runs}
    title = titles.pop() if len(titles) == 1 else " and ".join(called)
    text = assembled("report", title, {"title": title, "made": f"tautflex {__version__}", "runs": runs})
    return write_text(target, text)


def _framed(run: xr.Dataset | Run, name: str) -> xr.Dataset:
    wanted = "frame_displacement", "frame_time", "node_position"
    data = dataset_of(name, run, *wanted[:2], remedy="simulate(..., frames=300) gives one", table=RUN)
    if data.sizes["frame_time"] < 2:
        found = data.sizes["frame_time"]
        raise InputError(f"{name}: expected two frames or more, got {found}; simulate with frames=300")
    return data
