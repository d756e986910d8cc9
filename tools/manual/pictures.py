"""Figures of the examples: every matplotlib figure that a block made, also those that pyplot does not know of."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from tautflex.plot.style import styled


def figures(block: Any, names: dict[str, Any], settings: dict[str, Any]) -> str:
    """Save what the block drew, once; sphinx-gallery calls this after each block."""
    scope = names["example_globals"]
    drawn = scope.setdefault("_drawn", [])
    new = [value for value in scope.values() if isinstance(value, Figure) and value not in drawn]
    drawn += new
    paths = []
    for figure in new:
        paths.append(next(names["image_path_iterator"]))
        with styled:
            figure.savefig(paths[-1], dpi=150)
    return figure_rst(paths, settings["src_dir"]) if paths else ""
