"""One look for every figure, and one way to write them."""

from __future__ import annotations

import io
import os
import textwrap
from collections.abc import Callable, Sequence
from contextlib import ContextDecorator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.numeric import Array
from tautflex.writing import written

SINGLE_COLUMN = 3.5  # [inch], one column of a two-column page
DOUBLE_COLUMN = 7.0  # [inch], the whole page
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito's palette, told apart by every kind of colour vision."""
LINES = ("-", "--", "-.", ":")
GREY = "#5a5a5a"
SUPPORT = "#c2571a"
DIVERGING = "RdBu_r"
SEQUENTIAL = "viridis"
_LETTER, _ROW = 0.068, 0.18  # [inch] that words of a legend take: width of a letter, height of a row

_STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(color=COLORS),
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.1,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "none",
    "savefig.facecolor": "white",
    "pdf.fonttype": 42,  # text stays text, as publishers ask
    "svg.fonttype": "none",
    "svg.hashsalt": "tautflex",  # equal figures give equal files
}


class _HouseStyle(ContextDecorator):
    """Matplotlib's own context serves either as a decorator or in one ``with`` block: after that it is spent."""

    def __init__(self) -> None:
        self._entered: list[Any] = []

    def __enter__(self) -> None:
        self._entered.append(matplotlib.rc_context(_STYLE))
        self._entered[-1].__enter__()

    def __exit__(self, *error: Any) -> None:
        self._entered.pop().__exit__(*error)


styled = _HouseStyle()
"""Makes a function draw in the publication style, and ``with`` blocks too; global settings come back after it."""


def saving(plot: Callable[..., Figure]) -> Callable[..., list[Path]]:
    """Return the function of (data, stem, what else ``plot`` takes, ``formats``) that writes what ``plot`` draws."""

    def save(
        data: Any, stem: str | os.PathLike[str], *args: Any, formats: Sequence[str] = ("png", "pdf"), **kwargs: Any
    ) -> list[Path]:
        return save_figure(plot(data, *args, **kwargs), stem, formats)

    save.__name__ = save.__qualname__ = plot.__name__.replace("plot", "save")
    save.__doc__ = f"Write the figure of :func:`{plot.__name__}` as ``stem.png`` and ``stem.pdf``; return the files."
    return save


class _Shown(Figure):
    """A figure that notebooks show: without pyplot, which would tell them how, they print a line in its place."""

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=144)
        return picture.getvalue()


def new_figure(width: float, height: float, constrained: bool = True) -> Figure:
    """Return an empty figure of the given size [inch] that no global state of pyplot knows."""
    figure = _Shown(figsize=(width, height), layout="constrained" if constrained else None)
    FigureCanvasAgg(figure)
    return figure


def new_axes(width: float, height: float, xlabel: str, ylabel: str) -> tuple[Figure, Axes]:
    """Return an empty figure of the given size [inch] and its axes."""
    figure = new_figure(width, height)
    axes = figure.add_subplot()
    axes.set(xlabel=xlabel, ylabel=ylabel)
    return figure, axes


def save_figure(figure: Figure, stem: str | os.PathLike[str], formats: Sequence[str] = ("png", "pdf")) -> list[Path]:
    """Write a figure once per format.

    Parameters
    ----------
    figure
        Any matplotlib figure.
    stem
        Path without suffix; missing folders are made.
    formats
        Any of ``"png"`` (200 dpi), ``"pdf"``, ``"svg"``.

    Returns
    -------
    list of pathlib.Path
        The files written, in the order of ``formats``.

    Raises
    ------
    InputError
        If a format is unknown.
    NotWrittenError
        If a file cannot be written; what stood there is whole.
    """
    undated: dict[str, dict[str, Any]] = {"png": {}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}
    checks.instance("figure", figure, Figure, "a matplotlib Figure", remedy="plot_modes(modes) and its like give one")
    for kind in checks.several("formats", formats, str, "'png'"):
        checks.one_of("formats", kind, tuple(undated))
    base = checks.path("stem", stem)
    files = [base.with_name(f"{base.name}.{kind}") for kind in formats]
    with matplotlib.rc_context(_STYLE):
        for path, kind in zip(files, formats, strict=True):
            with written(path) as place:
                figure.savefig(place, dpi=200, metadata=undated[kind], format=kind)
    return files


def explain(axes: Axes, title: str | None = None, columns: int = 3) -> None:
    """Name the curves along the top of linear axes, which are raised for it, or below where that takes much room."""
    figure, (handles, names) = axes.get_figure(root=True), axes.get_legend_handles_labels()
    assert figure is not None
    width, height = figure.get_size_inches()
    room = width - 1.0  # beside the words of the axes [inch]
    names = [textwrap.fill(name, int(room / _LETTER) - 8) for name in names]
    letters = [8 + max(map(len, name.split("\n"))) for name in names]  # with a piece of the curve
    columns = min(columns, len(names))
    while columns > 1 and sum(max(part) for part in np.array_split(letters, columns)) * _LETTER > room:
        columns -= 1
    rows = max(sum(1 + name.count("\n") for name in part) for part in np.array_split(np.array(names), columns))
    rows += title is not None
    look: dict[str, Any] = {"handles": handles, "labels": names, "ncols": columns, "title": title}
    if rows > 3:
        figure.set_size_inches(width, height + _ROW * (rows + 0.5))
        figure.legend(loc="outside lower center", **look)
        return
    low, high = axes.get_ylim()
    part = _ROW * (rows + 0.5) / (height - 0.6)
    axes.set_ylim(low, low + (high - low) / (1.0 - part))
    axes.legend(loc="upper right", **look)


def thinned(x: Array, y: Array, most: int = 3000, as_it_is: int = 20_000) -> tuple[Array, Array]:
    """A curve of many points with the extremes of equal parts of them alone, so that none is lost to the eye.

    A figure is a thousand dots wide; strokes from one extreme to the next take much memory while they are drawn.
    """
    known = np.isfinite(y)
    if not known.all():
        x, y = x[known], y[known]
    if len(x) <= max(most, as_it_is):
        return x, y
    parts = np.array_split(np.arange(len(x)), most // 2)
    some = np.unique([part[index] for part in parts for index in (y[part].argmin(), y[part].argmax())])
    some = np.union1d(some, [0, len(x) - 1])
    return x[some], y[some]


def length_unit(values: ArrayLike) -> tuple[float, str]:
    """Return factor and name of the unit (m, mm or micrometre) in which values given in metres read well."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if largest >= 1.0:
        return 1.0, "m"
    return (1e3, "mm") if largest >= 5e-6 or largest == 0.0 else (1e6, "µm")
