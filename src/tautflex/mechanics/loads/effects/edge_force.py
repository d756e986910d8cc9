"""Forces along edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.nodes import checked_nodes, shared_force
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PreparedInput
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class EdgeForce(Effect):
    """Dead force per length along a chain of nodes.

    Parameters
    ----------
    nodes
        Node numbers in order along the edge, at least two.
    force
        Force per length in floating-frame axes [N/m], three numbers, or one along ``direction``, or a function of
        time; None where a plant commands it.
    breaks
        Instants at which the function jumps [s].
    direction
        Direction in floating-frame axes, of any length: the force is then one number.
    """

    nodes: Sequence[int]
    force: Signal | None = None
    breaks: tuple[float, ...] = ()
    direction: Sequence[float] | None = None
    signal: ClassVar[str] = "force"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system; each piece gives half of its length to either end (consistent for linear edges)."""
        nodes = checked_nodes(system, self.nodes)
        if len(nodes) < 2:
            raise InputError(f"nodes: expected at least two nodes along an edge, got {list(self.nodes)}")
        piece = np.linalg.norm(np.diff(system.model.nodes[nodes], axis=0), axis=1)
        share = 0.5 * (np.append(piece, 0.0) + np.insert(piece, 0, 0.0))
        return shared_force(system, nodes, share, self.direction, self.force, "N/m")
