"""Figures of results, for papers: functions on Datasets; matplotlib is imported only when one is used."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tautflex.plot.campbell import plot_campbell, save_campbell
    from tautflex.plot.history import plot_time_history, save_time_history
    from tautflex.plot.modes import plot_modes, save_modes
    from tautflex.plot.shapes import plot_shapes, save_shapes
    from tautflex.plot.spectrum import plot_spectrum, save_spectrum
    from tautflex.plot.style import save_figure
    from tautflex.plot.timefrequency import plot_scalogram, save_scalogram

_HOME = {
    "plot_campbell": "campbell",
    "plot_modes": "modes",
    "plot_scalogram": "timefrequency",
    "plot_shapes": "shapes",
    "plot_spectrum": "spectrum",
    "plot_time_history": "history",
    "save_campbell": "campbell",
    "save_figure": "style",
    "save_modes": "modes",
    "save_scalogram": "timefrequency",
    "save_shapes": "shapes",
    "save_spectrum": "spectrum",
    "save_time_history": "history",
}

__all__ = [
    "plot_campbell",
    "plot_modes",
    "plot_scalogram",
    "plot_shapes",
    "plot_spectrum",
    "plot_time_history",
    "save_campbell",
    "save_figure",
    "save_modes",
    "save_scalogram",
    "save_shapes",
    "save_spectrum",
    "save_time_history",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"tautflex.plot.{_HOME[name]}"), name)
    raise AttributeError(f"module 'tautflex.plot' has no attribute {name!r}")
