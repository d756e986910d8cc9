"""Hinges at the ends of beams of an Abaqus file."""

from __future__ import annotations

from collections.abc import Iterator

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.raw import shorten

# Directions 0 to 5 along the beam's axes, of which y is n1: M1 is the moment about it.
_FREE = {"T": {3}, "M1": {4}, "M2": {5}}
_FREE |= {"M1-M2": {4, 5}, "M1-T": {3, 4}, "M2-T": {3, 5}, "ALLM": {3, 4, 5}}
_ENDS = {"S1": 0, "S2": 1}


def releases(block: Block) -> Iterator[tuple[str, str, int, set[int]]]:
    """Place for messages, element or set, end 0 or 1, and directions that a RELEASE frees there."""
    block.require_options()
    for where, line in block.lines:
        target, *parts = fields(line.upper()) or [""]
        if len(parts) != 2 or parts[0] not in _ENDS or parts[1] not in _FREE:
            raise MeshError(
                f"{where}: expected element or set, S1 or S2, and one of {', '.join(_FREE)}, got {shorten(line)}; "
                "correct the line"
            )
        yield where, target, _ENDS[parts[0]], _FREE[parts[1]]
