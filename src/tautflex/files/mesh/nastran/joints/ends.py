"""Ends of beams that are not where their grid points are, or not fixed to them: offsets and pin flags."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.supports import components
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.new_ends import NewEnds
from tautflex.files.mesh.numerals import vector
from tautflex.numeric import Array, Indices

ENDS = tuple(range(9, 17))
"""Fields of CBAR and CBEAM about the ends: pin flags, then both offsets."""
Turned = Callable[[int, Array, str], Array]


def offset(card: Card, end: int, number: int, turned: Turned) -> Array:
    """Vector from the grid point of an end (0 or 1) to the end, in basic coordinates."""
    given = vector([card.get(11 + 3 * end + k) for k in range(3)], card.where)
    if not given.any():
        return given
    if card.get(8)[1 + end : 2 + end].upper() == "O":
        raise MeshError(f"{card.where}: expected offsets in the system of the grid point (G), got O; write them there")
    return turned(number, given, card.where)


def placed(
    ends: NewEnds, card: Card, lines: Indices, numbers: list[int], orientation: Array, turned: Turned
) -> Indices:
    """Rows of the ends of a beam whose grid points have these rows and numbers, new ones where they are elsewhere."""
    rows = lines.tolist()
    for end in (0, 1):
        arm = offset(card, end, numbers[end], turned)
        if arm.any():
            rows[end] = ends.moved(card.where, rows[end], arm)
    for end in (0, 1):
        flags = card.get(9 + end)
        if flags not in ("", "0"):
            rows[end] = ends.hinged(card.where, rows, end, components(flags, card.where), orientation)
    return np.array(rows, dtype=np.int64)
