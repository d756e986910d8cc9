"""Links of an Abaqus or CalculiX file: multipoint constraints, equations, rigid bodies, couplings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh.abaqus.joints.surfaces import Surface
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import shorten
from tautflex.files.mesh.raw_links import RawLink, equation
from tautflex.files.mesh.systems import global_directions
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.distributing import DistributingLink
from tautflex.structure.links.link import Link
from tautflex.structure.links.rigid import RigidLink
from tautflex.structure.links.tie import Tie

LINKS = ("MPC", "EQUATION", "RIGID BODY", "KINEMATIC COUPLING", "COUPLING", "KINEMATIC", "DISTRIBUTING")
_MPC: Mapping[str, Callable[[int, list[int]], Link]] = {
    "BEAM": RigidLink,
    "TIE": Tie,
    "PIN": lambda one, nodes: Tie(one, nodes, DIRECTIONS[:3]),
}


@dataclass(frozen=True)
class Joints:
    """Blocks of one scope that link nodes, and what its numbers and names stand for.

    Parameters
    ----------
    blocks
        In the order of the file.
    nodes, elements
        Names and numbers of the scope.
    corners
        Rows of the nodes of elements, those of beams and those of others, from the elements' rows.
    axes
        Directions of transformed nodes by row.
    surface
        Surface of a name, with a place for messages.
    """

    blocks: Sequence[Block]
    nodes: Names
    elements: Names
    corners: Callable[[Indices], tuple[Indices, Indices]]
    axes: Mapping[int, Array]
    surface: Callable[[str, str], Surface]

    def links(self) -> Iterator[RawLink]:
        """Links of all blocks."""
        coupling: Block | None = None
        for block in self.blocks:
            if block.keyword == "COUPLING":
                if coupling is not None:
                    raise _incomplete(coupling)
                coupling = block
                continue
            try:
                if block.keyword in ("KINEMATIC", "DISTRIBUTING"):
                    if coupling is None:
                        raise MeshError(f"{block.where}: expected it below a *COUPLING, got none; move it there")
                    found = self._coupling(coupling, block)
                    coupling = None
                else:
                    found = list(self._of(block))
            except MeshError:
                raise
            except InputError as error:
                raise MeshError(f"{block.where}: {error}") from None
            yield from (RawLink(block.where, link) for link in found)
        if coupling is not None:
            raise _incomplete(coupling)

    def _of(self, block: Block) -> Iterator[Link]:
        if block.keyword == "MPC":
            yield from self._multipoint(block)
        elif block.keyword == "EQUATION":
            yield from self._equations(block)
        elif block.keyword == "RIGID BODY":
            yield from self._rigid_body(block)
        else:
            block.require_options("REF NODE")
            for where, line in block.lines:
                target, *ways = fields(line)
                yield RigidLink(self._one(block.option("REF NODE"), where), *self._followers(target, ways, where))

    def _multipoint(self, block: Block) -> Iterator[Link]:
        block.require_options()
        for where, line in block.lines:
            kind, *parts = fields(line) or [""]
            if kind.upper() not in _MPC or len(parts) != 2:
                raise MeshError(
                    f"{where}: expected {', '.join(_MPC)}, the node that follows and the one that leads, got "
                    f"{shorten(line)}; write it as an equation or a rigid body"
                )
            follow, lead = (self.nodes.find(part, where) for part in parts)
            if len(lead) not in (1, len(follow)):
                raise MeshError(f"{where}: expected as many nodes that lead, or one, got {len(lead)}; correct the sets")
            for one, other in zip(follow.tolist(), np.broadcast_to(lead, follow.shape).tolist(), strict=True):
                yield _MPC[kind.upper()](other, [one])

    def _equations(self, block: Block) -> Iterator[Link]:
        block.require_options()
        waiting, texts, where = 0, list[str](), block.where
        for where, line in block.lines:
            parts = fields(line)
            if not waiting:
                waiting = 3 * natural(parts[0], where) if len(parts) == 1 else 0
                if not waiting:
                    raise MeshError(f"{where}: expected the number of terms, got {shorten(line)}; correct the line")
                continue
            texts += parts
            if len(texts) > waiting:
                raise MeshError(f"{where}: expected {waiting // 3} terms, got more; correct the number")
            if len(texts) == waiting:
                yield from self._equation(texts, where)
                waiting, texts = 0, []
        if waiting:
            raise MeshError(f"{where}: expected {waiting // 3} terms, got fewer; complete the equation")

    def _equation(self, texts: list[str], where: str) -> Iterator[Link]:
        """One equation, or one for each node of sets of the same size."""
        rows = [self.nodes.find(text, where) for text in texts[::3]]
        ways = [natural(text, where) for text in texts[1::3]]
        if max(ways) > 6:
            raise MeshError(f"{where}: expected directions 1 to 6, got {max(ways)}; correct the line")
        factors, count = [real(text, where) for text in texts[2::3]], len(rows[0])
        if any(len(own) not in (1, count) for own in rows):
            raise MeshError(f"{where}: expected sets of the same size, got {[len(own) for own in rows]}; correct them")
        for each in zip(*(np.broadcast_to(own, count).tolist() for own in rows), strict=True):
            terms = [(row, way - 1, factor) for row, way, factor in zip(each, ways, factors, strict=True)]
            yield equation(terms, self.axes.get, where)

    def _rigid_body(self, block: Block) -> Iterator[Link]:
        """Nodes of beams follow with their rotations, those of film and cables without."""
        block.require_options("REF NODE", "ELSET", "NSET", "PIN NSET", "TIE NSET")
        reference = self._one(block.option("REF NODE"), block.where)
        whole, pinned = set[int](), set[int]()
        for option, target in (("NSET", whole), ("TIE NSET", whole), ("PIN NSET", pinned)):
            if block.option(option):
                target.update(self.nodes.find(block.option(option), block.where).tolist())
        if block.option("ELSET"):
            beams, others = self.corners(self.elements.find(block.option("ELSET"), block.where))
            whole.update(beams.tolist())
            pinned.update(others.tolist())
        for found, directions in ((whole, DIRECTIONS), (pinned - whole, DIRECTIONS[:3])):
            rows = sorted(found - {reference})
            if rows:
                yield RigidLink(reference, rows, directions)

    def _coupling(self, coupling: Block, kind: Block) -> list[Link]:
        coupling.require_options("CONSTRAINT NAME", "REF NODE", "SURFACE")
        members = dict(self.surface(coupling.option("SURFACE"), coupling.where).nodes)
        kind.require_options()
        reference = self._one(coupling.option("REF NODE"), coupling.where)
        ways: set[int] = set()
        for where, line in kind.lines:
            ways.update(_ways(fields(line), where))
        chosen = sorted(ways) or range(6)
        members.pop(reference, None)
        rows = list(members)
        if kind.keyword == "KINEMATIC":
            return [RigidLink(reference, rows, self._directions(chosen, rows, kind.where))]
        directions = self._directions(chosen, [reference], kind.where)
        return [DistributingLink(reference, rows, tuple(members.values()), directions)]

    def _followers(self, target: str, ways: list[str], where: str) -> tuple[list[int], tuple[str, ...]]:
        rows = self.nodes.find(target, where).tolist()
        return rows, self._directions(_ways(ways, where), rows, where)

    def _directions(self, chosen: Sequence[int], rows: list[int], where: str) -> tuple[str, ...]:
        found = {global_directions(chosen, self.axes.get(row), where) for row in rows}
        if len(found) != 1:
            raise MeshError(f"{where}: expected nodes with the same directions, got {len(found)} kinds; split the line")
        return found.pop()

    def _one(self, text: str, where: str) -> int:
        rows = self.nodes.find(text, where)
        if len(rows) != 1:
            raise MeshError(f"{where}: expected one reference node, got {len(rows)} under {shorten(text)}; name one")
        return int(rows[0])


def _incomplete(block: Block) -> MeshError:
    return MeshError(f"{block.where}: expected *KINEMATIC or *DISTRIBUTING below it, got none; add it")


def _ways(texts: list[str], where: str) -> list[int]:
    """Directions 0 to 5 from the first to the last; all, if none is given."""
    if not any(texts):
        return list(range(6))
    first = natural(texts[0], where)
    last = natural(texts[1], where) if len(texts) > 1 and texts[1] else first
    if not 1 <= first <= last <= 6 or len(texts) > 2:
        raise MeshError(f"{where}: expected directions 1 to 6, got {', '.join(texts)}; correct the line")
    return list(range(first - 1, last))
