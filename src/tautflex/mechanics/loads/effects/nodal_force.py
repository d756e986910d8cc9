"""Forces on nodes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex.mechanics.loads.effects.nodes import checked_nodes, shared_force
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PreparedInput
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class NodalForce(Effect):
    """Dead force on nodes, the same on each.

    Parameters
    ----------
    nodes
        Node numbers.
    force
        Force on every node in floating-frame axes [N], three numbers, or one along ``direction``, or a function of
        time; None where a plant commands it.
    breaks
        Instants at which the function jumps [s].
    direction
        Direction in floating-frame axes, of any length: the force is then one number.

    Examples
    --------
    >>> import tautflex as tf
    >>> knock = tf.NodalForce([7], lambda time: (0.0, 0.0, 1e-3 * (time < 0.05)), breaks=(0.05,))
    >>> knock.breaks
    (0.05,)
    """

    nodes: Sequence[int]
    force: Signal | None = None
    breaks: tuple[float, ...] = ()
    direction: Sequence[float] | None = None
    signal: ClassVar[str] = "force"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system."""
        nodes = checked_nodes(system, self.nodes)
        return shared_force(system, nodes, np.ones(len(nodes)), self.direction, self.force, "N")
