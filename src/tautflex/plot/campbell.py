"""Campbell figure: frequencies of a spinning structure over the spin rate."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tautflex import checks
from tautflex.numeric import Array, Mask
from tautflex.plot.style import COLORS, DOUBLE_COLUMN, GREY, new_axes, saving, styled
from tautflex.solvers.variables import CAMPBELL, dataset_of

_NAME_HEIGHT = 0.125  # [inch] a line of branch names needs
_HEIGHT = 3.6  # [inch]
_LOST = 0.5  # modal assurance criterion below which two shapes are not one branch


@styled
def plot_campbell(table: xr.Dataset, orders: Sequence[int] = (1, 2, 3), highest: float | None = None) -> Figure:
    """Draw every branch over the rate, and the lines on which a branch is excited ``orders`` times a revolution.

    Parameters
    ----------
    table
        Dataset of :func:`tautflex.solvers.modal.campbell.campbell`.
    orders
        Multiples k of the spin frequency, drawn as ``f = k |rate| / 2 pi``; empty for none.
    highest
        Largest frequency drawn [Hz]; by default a little above the highest branch.

    Returns
    -------
    matplotlib.figure.Figure
        Branches are named at the right by number and half-waves; crosses mark rates at which a branch grows. Where
        the shape of a branch was lost from one rate to the next (``mac`` below 0.5) its line is broken.

    Raises
    ------
    InputError
        If ``table`` is no Campbell table, or an order is below 1.
    """
    remedy = "campbell(state, rates) gives it"
    table = dataset_of("table", table, "frequency", "rate", remedy=remedy, table=CAMPBELL)
    table = table.transpose("rate", "branch", ...)
    orders = [checks.whole("orders", order, 1) for order in checks.several("orders", orders, int, "1")]
    if highest is not None:
        checks.positive("highest", highest)
    rate, frequency = table["rate"].values, table["frequency"].values
    top = highest or 1.06 * float(frequency.max(initial=0.0)) or 1.0
    about = f"angular rate about {_direction(np.asarray(table.attrs.get('axis', (np.nan,) * 3), dtype=float))} [rad/s]"
    figure, axes = new_axes(DOUBLE_COLUMN * 0.8, _HEIGHT, about, "frequency in the rotating frame [Hz]")
    around = 0.5 if len(rate) == 1 else 0.0
    axes.set_xlim(float(rate.min()) - around, float(rate.max()) + around)
    axes.set_ylim(0.0, top)
    _draw_orders(axes, orders, top)
    growth = _growing(table)
    for k in range(frequency.shape[1]):
        color = COLORS[k % len(COLORS)]
        axes.plot(rate, frequency[:, k], ".", color=color, markersize=3.5 if len(rate) <= 30 else 0.0)
        for part in _unbroken(table, k):
            axes.plot(rate[part], frequency[part, k], color=color)
        grows = growth[:, k]
        if grows.any():
            axes.plot(rate[grows], frequency[grows, k], "x", color=color, markersize=5, clip_on=False, zorder=4)
    _name_branches(axes, table, top)
    to_and_fro = (partial(np.multiply, 30.0 / np.pi), partial(np.multiply, np.pi / 30.0))
    above = axes.secondary_xaxis("top", functions=to_and_fro)
    above.set_xlabel("revolutions per minute")
    if growth.any():
        axes.plot([], [], "x", color=GREY, markersize=5, label="unstable")
        axes.legend(loc="upper left")
    return figure


save_campbell = saving(plot_campbell)


def branch_name(table: xr.Dataset, index: int) -> str:
    """Return e.g. "4 (1,2)", or "4 (1,2) to (4,1)" where the shape changes on the way, for a position in a table.

    A shape without half-waves to count at one end is "mixed" there.
    """
    one = table.isel(branch=index)
    name = str(int(one["branch"])) if "branch" in table.coords else str(index + 1)
    if "label_m" not in table:
        return name
    labels = [(int(one["label_m"][k]), int(one["label_n"][k])) for k in (0, -1)]
    words = [f"({m},{n})" if m > 0 else "mixed" for m, n in labels]
    if words == ["mixed", "mixed"]:
        return name
    return f"{name} {words[0]}" if words[0] == words[1] else f"{name} {words[0]} to {words[1]}"


def _unbroken(table: xr.Dataset, branch: int) -> list[slice]:
    """Stretches of rates over which the shape of a branch was followed."""
    count = table.sizes["rate"]
    links = table["mac"].values[:, branch] if "mac" in table else np.ones(count)
    breaks = [k for k in range(1, count) if links[k] < _LOST]
    return [slice(first, last) for first, last in pairwise([0, *breaks, count])]


def _growing(table: xr.Dataset) -> Mask:
    """Where a branch grows faster than round-off, shape (rate, branch)."""
    if "growth_rate" not in table:
        return np.zeros(table["frequency"].shape, dtype=bool)
    scale = 2.0 * np.pi * table["frequency"].values
    return np.asarray(table["growth_rate"].values > 1e-9 * scale)


def _draw_orders(axes: Axes, orders: Sequence[int], top: float) -> None:
    """Draw the lines ``f = k |rate| / 2 pi``, named where they leave the picture."""
    low, high = axes.get_xlim()
    largest = low if abs(low) > abs(high) else high
    corners = np.unique([low, high, *([0.0] if low < 0.0 < high else [])])
    for place, order in enumerate(orders):
        axes.plot(corners, order * np.abs(corners) / (2.0 * np.pi), color=GREY, linewidth=0.8, linestyle=":", zorder=1)
        end = np.sign(largest) * min(abs(largest), 2.0 * np.pi * top / order)
        at = end - (0.06 + 0.08 * (place % 3)) * np.sign(largest) * (high - low)
        look: dict[str, Any] = {"color": GREY, "size": 7, "ha": "center", "va": "center", "zorder": 1.5}
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        axes.text(at, order * abs(at) / (2.0 * np.pi), f"{order}/rev", bbox=box, **look)


def _name_branches(axes: Axes, table: xr.Dataset, top: float) -> None:
    """Write the branches' names at their right ends, pushed apart where they would overlap."""
    ends = table["frequency"].values[int(table["rate"].values.argmax())]
    shown = np.flatnonzero(ends <= top)
    order = shown[np.argsort(ends[shown], kind="stable")]
    places = _spread(ends[order], top * _NAME_HEIGHT / (0.75 * _HEIGHT))
    for k, place in zip(order, places, strict=True):
        color, beside = COLORS[int(k) % len(COLORS)], axes.get_yaxis_transform()
        axes.plot([1.005, 1.025], [ends[k], place], color=color, linewidth=0.5, transform=beside, clip_on=False)
        axes.text(1.03, place, branch_name(table, int(k)), va="center", size=7, color=color, transform=beside)


def _spread(values: Array, gap: float) -> Array:
    """Sorted values >= 0 moved, by little, so that neighbours are ``gap`` apart."""
    places = values.copy()
    for _ in range(100):
        close = np.diff(places) < 0.999 * gap
        if not close.any():
            break
        for k in np.flatnonzero(close):
            middle = 0.5 * (places[k] + places[k + 1])
            places[k], places[k + 1] = middle - 0.5 * gap, middle + 0.5 * gap
    floor = gap * np.arange(len(places))
    return np.maximum(places, floor)


def _direction(axis: Array) -> str:
    """Return "z" for a coordinate axis, else its components."""
    for name, direction in zip("xyz", np.eye(3), strict=True):
        if np.allclose(axis, direction, atol=1e-12):
            return f"${name}$"
    return "(" + ", ".join(f"{value:.3g}" for value in axis) + ")"
