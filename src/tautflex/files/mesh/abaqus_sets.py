"""Sets and boundary conditions of Abaqus input files."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus_text import Block, bare_name, fields
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Budget, Numbering, RawGroup, integers, shorten
from tautflex.numeric import Indices
from tautflex.structure.groups import DIRECTIONS

NAMED_CONDITIONS = {"ENCASTRE": (1, 6), "PINNED": (1, 3)}


class NamedSets:
    """Members of the sets of one kind, ``"NSET"`` or ``"ELSET"``, by name; names are the same in any case."""

    def __init__(self, keyword: str) -> None:
        self.keyword = keyword
        self._sets: dict[str, tuple[str, list[Indices]]] = {}

    def __contains__(self, name: str) -> bool:
        return bare_name(name).casefold() in self._sets

    def add(self, name: str, numbers: Indices) -> None:
        """Add members to a set, which need not exist before."""
        bare = bare_name(name)
        self._sets.setdefault(bare.casefold(), (bare, []))[1].append(numbers)

    def members(self, name: str) -> Indices:
        """Numbers in a set that exists."""
        return np.unique(np.concatenate(self._sets[bare_name(name).casefold()][1]))

    def items(self) -> Iterator[tuple[str, Indices]]:
        """Names as the file first writes them, and numbers."""
        for name, parts in self._sets.values():
            yield name, np.unique(np.concatenate(parts))

    def read(self, block: Block, numbering: Numbering, budget: Budget) -> None:
        """Read a block that lists members, ranges of them, or sets above it; MeshError if one does not exist."""
        name = block.options.get(self.keyword, "")
        if not name:
            raise MeshError(f"{block.where}: expected {self.keyword}=name, got none; name the set")
        if self.keyword == "NSET" and "ELSET" in block.options:
            raise MeshError(f"{block.where}: a node set made of an element set is not read here; list its nodes")
        found = self._ranges if "GENERATE" in block.options else self._listed
        self.add(name, np.concatenate([integers([]), *found(block, numbering, budget)]))

    def _ranges(self, block: Block, numbering: Numbering, budget: Budget) -> Iterator[Indices]:
        for where, line in block.lines:
            parts = [natural(part, where) for part in fields(line)]
            if len(parts) not in (2, 3) or parts[0] > parts[1]:
                raise MeshError(f"{where}: expected first, last, step, got {shorten(line)}; correct the line")
            found = numbering.within(*parts)
            budget.spend(len(found) + 1, where)
            yield found

    def _listed(self, block: Block, numbering: Numbering, budget: Budget) -> Iterator[Indices]:
        for where, line in block.lines:
            for part in fields(line):
                if bare_name(part).isdigit():
                    yield integers([natural(bare_name(part), where)])
                elif part in self:
                    found = self.members(part)
                    budget.spend(len(found) + 1, where)
                    yield found
                else:
                    expected = f"{where}: expected numbers or sets above"
                    raise MeshError(f"{expected}, got {shorten(part)}; correct the name")


def element_groups(sets: NamedSets, elements: Numbering, triangle_count: int) -> Iterator[RawGroup]:
    """Groups of element sets; rows from ``triangle_count`` on are lines."""
    for name, numbers in sets.items():
        rows = elements.rows(numbers, f"set {shorten(name)}")
        lines = rows[rows >= triangle_count] - triangle_count
        yield RawGroup(name, {"triangles": rows[rows < triangle_count], "lines": lines})


def node_groups(sets: NamedSets, nodes: Numbering) -> Iterator[RawGroup]:
    """Groups of node sets."""
    for name, numbers in sets.items():
        yield RawGroup(name, {"nodes": nodes.rows(numbers, f"set {shorten(name)}")})


def held_groups(conditions: list[Block], sets: NamedSets, nodes: Numbering, budget: Budget) -> Iterator[RawGroup]:
    """Boundary conditions, one group per line: nodes and the directions they hold."""
    for block in conditions:
        kind = block.options.get("TYPE", "DISPLACEMENT")
        if kind.upper() != "DISPLACEMENT":
            raise MeshError(f"{block.where}: expected TYPE=DISPLACEMENT, got {shorten(kind)}; remove the condition")
        for where, line in block.lines:
            target, directions = _condition(where, line)
            if target in sets:
                numbers = sets.members(target)
            elif target.isdigit():
                numbers = integers([natural(target, where)])
            else:
                raise MeshError(f"{where}: expected a node or node set, got {shorten(target)}; define the set")
            budget.spend(len(numbers) + 1, where)
            yield RawGroup(f"boundary {target}", {"nodes": nodes.rows(numbers, where)}, directions)


def _condition(where: str, line: str) -> tuple[str, tuple[str, ...]]:
    target, *rest = fields(line) or [""]
    if not rest:
        raise MeshError(f"{where}: expected node or set and directions, got {shorten(line)}; correct the line")
    if rest[0].upper() in NAMED_CONDITIONS:
        first, last = NAMED_CONDITIONS[rest[0].upper()]
    else:
        first = natural(rest[0], where)
        last = natural(rest[1], where) if len(rest) > 1 and rest[1] else first
    if not 1 <= first <= last <= 6:
        raise MeshError(f"{where}: expected directions 1 to 6, got {shorten(line)}; correct the line")
    if len(rest) > 2 and real(rest[2], where) != 0.0:
        raise MeshError(f"{where}: expected held nodes, got a displacement in {shorten(line)}; set it to zero")
    return bare_name(target), DIRECTIONS[first - 1 : last]
