"""Parts in their places: every instance a copy of its part, moved and turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.scope import Scope
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array


@dataclass
class Placement:
    """A scope's content in the global system: ``x -> turn (x + shift - centre) + centre``.

    ``own`` are sets and sections, without a mesh, that hold in this place only.
    """

    name: str
    scope: Scope
    own: Scope
    shift: Array
    centre: Array
    turn: Array

    @classmethod
    def at_rest(cls, scope: Scope) -> Placement:
        """What stands outside of parts."""
        return cls("", scope, Scope(), np.zeros(3), np.zeros(3), np.eye(3))

    @classmethod
    def of_instance(cls, block: Block, part: Scope | None, own: Scope) -> Placement:
        """Instance of a part; the lines of its block shift it, then turn it about an axis.

        ``own`` is what stands between the instance and its end: sets, or a mesh if the part has none.
        """
        block.require_options("NAME", "PART")
        if not block.option("NAME") or part is None:
            named = shorten(block.option("PART"))
            raise MeshError(
                f"{block.where}: expected NAME and PART of a part above, got part {named}; correct the line"
            )
        if part.has_mesh and own.has_mesh:
            raise MeshError(f"{block.where}: expected a mesh in the part or in the instance, got both; remove one")
        numbers = [vector(fields(line), where) for where, line in block.lines]
        lengths = [len(row) for row in numbers]
        if lengths not in ([], [3], [3, 7]):
            raise MeshError(
                f"{block.where}: expected a line of 3 numbers (shift) and one of 7 (points a, b, angle), got lines of "
                f"{lengths}; correct them"
            )
        shift, centre, turn = np.zeros(3), np.zeros(3), np.eye(3)
        if numbers:
            shift = numbers[0]
        if len(numbers) == 2:
            centre = numbers[1][:3]
            turn = _turn(numbers[1][3:6] - centre, numbers[1][6], block.where)
        scopes = (own, part) if own.has_mesh else (part, own)
        return cls(block.option("NAME"), *scopes, shift, centre, turn)

    def blocks(self, kind: str) -> list[Block]:
        """Blocks of ``"sets"``, ``"sections"`` or ``"transforms"``."""
        return [*getattr(self.scope, kind), *getattr(self.own, kind)]

    @property
    def is_turned(self) -> bool:
        """Whether directions of the part are others in the structure."""
        return not np.array_equal(self.turn, np.eye(3))

    def points(self, positions: Array) -> Array:
        """Points of the scope in the global system, shape (point, 3)."""
        return np.asarray((positions + self.shift - self.centre) @ self.turn.T + self.centre)


def _turn(axis: Array, degrees: float, where: str) -> Array:
    """Rotation about an axis by Rodrigues' formula."""
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        raise MeshError(f"{where}: expected an axis through two points, got one point twice; correct it")
    x, y, z = axis / length
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.radians(degrees)
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)
