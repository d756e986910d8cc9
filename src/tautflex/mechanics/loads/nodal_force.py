"""Forces on nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tautflex.mechanics.loads.inputs import PreparedInput, TimeInput
from tautflex.mechanics.loads.prepared import PatternLoad, TimeFunction, checked_nodes, nodal_pattern
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class NodalForce(TimeInput):
    """Dead force on nodes, the same on each.

    Parameters
    ----------
    nodes
        Node numbers.
    force
        Force on every node in floating-frame axes [N], three numbers or a function of time.
    breaks
        Instants at which the function jumps [s].
    """

    nodes: Sequence[int]
    force: TimeFunction
    breaks: tuple[float, ...] = ()
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system."""
        share = np.ones(len(checked_nodes(system, self.nodes)))
        return PatternLoad(*nodal_pattern(system, self.nodes, share), self.force, "force")
