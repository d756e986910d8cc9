"""Piezoelectric patches on beams: pairs of moments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.nodes import bound_forces
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PatternLoad, PreparedInput, StressChange
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.text import brief


@dataclass(frozen=True)
class PiezoPair(Effect):
    """Patches on both sides of beams that bend them: a pair of opposite moments on the two nodes of each.

    Moments on corotational beams turn with them, as a change of their bending stress.

    Parameters
    ----------
    beams
        Numbers of the beams (order of ``model.beams``); of neighbours in a row only the moments on the ends remain.
    moment
        Moment [N m], a number or a function of time; None where a plant commands it. It turns the second node of a
        beam about the axis, and the first one backwards.
    axis
        Axis of the beam about which it bends, ``"y"`` (out of the plane of a built-in antenna) or ``"z"``.
    breaks
        Instants at which the function jumps [s].

    Raises
    ------
    InputError
        If the axis is none of a beam's.
    """

    beams: Sequence[int]
    moment: Signal | None = None
    axis: str = "y"
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "moment"
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.one_of("axis", self.axis, ("y", "z"))

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with beams."""
        model, found = system.model, system.block_index("beam")
        if not found:
            raise InputError("PiezoPair: expected a model with beams, got none; add beams to the model")
        chosen = checks.indices("beams", self.beams, len(model.beams), "beam")
        if not chosen.size or len(np.unique(chosen)) < chosen.size:
            raise InputError(f"beams: expected at least one beam, every one once, got {chosen.tolist()}")
        if any(system.blocks[index].turns for index in found):
            return StressChange(self.moment, "moment", ("moment [N m]",), -np.inf, self._columns(system, found, chosen))
        about = np.concatenate([system.blocks[index].axes[:, "xyz".index(self.axis)] for index in found])[chosen]
        moments = np.zeros((model.dof_count, 1))
        for nodes, turn in ((model.beams[chosen, 0], -about), (model.beams[chosen, 1], about)):
            np.add.at(moments[:, 0], model.dof_offset[nodes][:, None] + np.arange(3, 6), turn)
        return PatternLoad(self.moment, "moment", ("moment [N m]",), -np.inf, *bound_forces(system, moments))

    def _columns(self, system: StructuralSystem, found: list[int], chosen: Indices) -> dict[int, Array]:
        """Stress of the difference of both ends' angles; the second plane's counts against y (`elements.beam`)."""
        strain, sign = (3, 1.0) if self.axis == "y" else (1, -1.0)
        columns, first = {}, 0
        for index in found:
            block = system.blocks[index]
            rows = chosen[(chosen >= first) & (chosen < first + len(block.dofs))] - first
            first += len(block.dofs)
            columns[index] = np.zeros((*block.initial_stress.shape, 1))
            columns[index][rows, strain, 0] = sign / block.measure[rows]
        return columns
