"""Forces along edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import PreparedInput, TimeInput
from tautflex.mechanics.loads.prepared import PatternLoad, TimeFunction, checked_nodes, nodal_pattern
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class EdgeForce(TimeInput):
    """Dead force per length along a chain of nodes.

    Parameters
    ----------
    nodes
        Node numbers in order along the edge, at least two.
    force
        Force per length in floating-frame axes [N/m], three numbers or a function of time.
    breaks
        Instants at which the function jumps [s].
    """

    nodes: Sequence[int]
    force: TimeFunction
    breaks: tuple[float, ...] = ()
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system; each piece gives half of its length to either end (consistent for linear edges)."""
        points = system.model.nodes[checked_nodes(system, self.nodes)]
        if len(points) < 2:
            raise InputError(f"nodes: expected at least two nodes along an edge, got {list(self.nodes)}")
        piece = np.linalg.norm(np.diff(points, axis=0), axis=1)
        share = 0.5 * (np.append(piece, 0.0) + np.insert(piece, 0, 0.0))
        return PatternLoad(*nodal_pattern(system, self.nodes, share), self.force, "force")
