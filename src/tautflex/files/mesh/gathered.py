"""Nodes and elements of a text file as its lines bring them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tautflex.files.mesh.raw import Numbering, integers
from tautflex.files.mesh.second_order import WIDTHS
from tautflex.numeric import Indices

SHAPES = {**WIDTHS, "point1": 1, "spring1": 1, "spring2": 2}
"""Number of nodes of the shapes that text files hold: those of meshes, points, which have masses, and springs."""
UNSTATED = (np.nan, np.nan, np.nan)
"""Orientation of a beam about which the file says nothing."""


@dataclass
class Gathered:
    """Nodes and elements by shape; each element its number before those of its nodes."""

    node_numbers: list[int] = field(default_factory=list)
    positions: list[Sequence[float]] = field(default_factory=list)
    elements: dict[str, list[Sequence[int]]] = field(default_factory=lambda: {shape: [] for shape in SHAPES})
    roles: dict[str, list[str]] = field(default_factory=lambda: {shape: [] for shape in SHAPES})
    words: dict[str, list[str]] = field(default_factory=lambda: {shape: [] for shape in SHAPES})

    def add(self, shape: str, role: str, numbers: Sequence[int], word: str) -> tuple[str, int]:
        """Add an element; its shape and its row among those of that. ``word`` is what the file calls it."""
        self.elements[shape].append(numbers)
        self.roles[shape].append(role)
        self.words[shape].append(word)
        return shape, len(self.elements[shape]) - 1

    def nodes(self, what: str) -> Numbering:
        """Numbering of the nodes, which the format calls ``what``."""
        return Numbering(what, integers(self.node_numbers))

    def element_rows(self) -> tuple[Numbering, Indices, Indices]:
        """Numbering of all elements, and of each the place of its shape in `SHAPES` and its row there."""
        numbers = [integers(row[0] for row in rows) for rows in self.elements.values()]
        shape = np.repeat(np.arange(len(SHAPES)), [len(own) for own in numbers])
        row = np.concatenate([np.arange(len(own)) for own in numbers])
        return Numbering("element", np.concatenate(numbers)), shape, row

    def connectivity(self, nodes: Numbering) -> dict[str, Indices]:
        """Rows of nodes of the elements of each shape; MeshError if a node does not exist."""
        found = {}
        for shape, rows in self.elements.items():
            what = ", ".join(dict.fromkeys(self.words[shape]))
            found[shape] = nodes.rows(integers(rows).reshape(-1, 1 + SHAPES[shape])[:, 1:], what or shape)
        return found
