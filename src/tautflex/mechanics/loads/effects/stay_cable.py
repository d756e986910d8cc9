"""Stay cables: from a point of the structure to an anchor on the spacecraft."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.nodes import nodal_pattern
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PatternLoad
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.structure.locate import locate
from tautflex.text import brief


@dataclass(frozen=True)
class StayCable(Effect):
    """Cable from a point of the film to an anchor that is fixed in the floating frame, without mass.

    It pulls along its reference direction, also where the point has moved: of the true pull this leaves out the part
    across, tension times displacement across over length, which is the share (displacement / length) of the force and
    a lateral stiffness of tension / length. Its pull on the anchor is its pull on the film, backwards along the same
    line, so that it moves no momentum of the spacecraft.

    Parameters
    ----------
    point
        Where it holds the film (x, y), or (x, y, z) [m]: a point of the film, or a node of anything.
    anchor
        Its other end (x, y, z) in the floating frame [m].
    tension
        Tension [N], never negative: a number or a function of time; None where a plant commands it.
    breaks
        Instants at which the function jumps [s].
    """

    point: Sequence[float]
    anchor: Sequence[float]
    tension: Signal | None = None
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "tension"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PatternLoad:
        """Bind to a system: the nodes around the point share the pull as they share its displacement."""
        nodes, share = _holding(system, self.point)
        anchor, held_at = checks.vector3("anchor", self.anchor), share @ system.model.nodes[nodes]
        length = float(np.linalg.norm(anchor - held_at))
        if length <= 1e-9 * float(np.ptp(system.model.nodes, axis=0).max()):
            raise InputError(f"anchor: expected a place away from the point, got {anchor.tolist()}; move it")
        along = (anchor - held_at) / length
        pattern, held = nodal_pattern(system, nodes, share)
        # The anchor's pull closes the balance of the whole spacecraft.
        anchored = held @ along - np.concatenate([along, np.cross(held_at, along)])
        pull = (pattern @ along)[:, None], anchored[:, None]
        known = self.tension, "tension", ("tension [N]",), 0.0, *pull
        return _Stay(*known, internal=True, reading=pattern, line=along * length)


@dataclass(frozen=True, kw_only=True)
class _Stay(PatternLoad):
    """``reading`` gives the displacement of the point, shape (size, 3), ``line`` leads to the anchor [m]."""

    reading: Array
    line: Array

    def turned(self, q: Array) -> float:
        """Angle between the reference direction and the true one [rad]."""
        line = self.line - q @ self.reading
        across = np.linalg.norm(np.cross(line, self.line))
        return float(np.arctan2(across, line @ self.line))


def _holding(system: StructuralSystem, point: Sequence[float]) -> tuple[Indices, Array]:
    """Nodes that carry a point, and the share of each."""
    model = system.model
    place = checks.float_array("point", point, (3 if checks.numbers("point", point).size == 3 else 2,))
    away = np.linalg.norm(model.nodes[:, : place.size] - place, axis=1)
    met = np.flatnonzero(away <= 1e-9 * float(np.ptp(model.nodes, axis=0).max()))
    if met.size == 1:
        return met, np.ones(1)
    for group in model.surfaces if not met.size else ():
        found = locate(group.shape, model.nodes, group.connectivity, place)
        if found is not None:
            return group.connectivity[found[0]], found[1]
    got = (
        f"{place.tolist()}, {f'where {met.size} nodes are; give z too' if met.size else 'which is beside it; move it'}"
    )
    raise InputError(f"point: expected a point of the film or a node, got {got}")
