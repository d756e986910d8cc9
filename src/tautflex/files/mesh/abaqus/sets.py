"""Nodes and elements by the numbers and set names that hold in one scope."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import natural
from tautflex.files.mesh.raw import Budget, Numbering, integers, shorten
from tautflex.numeric import Indices


class Names:
    """Nodes or elements of one scope, as rows of the whole mesh; names are the same in any case.

    Parameters
    ----------
    numbering
        Numbers that the scope gives them.
    rows
        Row in the whole mesh of each, in the order of the numbering.
    instances
        The same of each instance, by its name in lower case: ``instance.name`` is looked up there.
    """

    def __init__(self, numbering: Numbering, rows: Indices, instances: Mapping[str, Names] | None = None) -> None:
        self._numbering, self._rows = numbering, rows
        self.instances = instances or {}
        self._sets: dict[str, tuple[str, list[Indices]]] = {}

    def __contains__(self, name: str) -> bool:
        return self.key(name) in self._sets

    @staticmethod
    def key(name: str) -> str:
        """Name of a set as it is compared: bare, in lower case."""
        return name.strip().strip('"').strip().casefold()

    def add(self, name: str, rows: Indices) -> None:
        """Add members to a set, which need not exist before."""
        bare = name.strip().strip('"').strip()
        self._sets.setdefault(bare.casefold(), (bare, []))[1].append(rows)

    def add_numbers(self, name: str, numbers: Indices) -> None:
        """The same by the numbers of the scope."""
        self.add(name, self._rows[self._numbering.rows(numbers, f"set {shorten(name)}")])

    def items(self) -> Iterator[tuple[str, Indices]]:
        """Names as the file first writes them, and rows."""
        for name, parts in self._sets.values():
            yield name, np.unique(np.concatenate(parts))

    def find(self, text: str, where: str) -> Indices:
        """Rows of a number, of a set above, or of either in an instance; MeshError if there is none."""
        bare = text.strip().strip('"').strip()
        if bare.isdigit() and bare.isascii():
            return self._rows[self._numbering.rows(integers([natural(bare, where)]), where)]
        if bare.casefold() in self._sets:
            return np.unique(np.concatenate(self._sets[bare.casefold()][1]))
        instance, dot, rest = bare.partition(".")
        inner = self.instances.get(instance.strip().strip('"').casefold())
        if dot and inner is not None:
            return inner.find(rest, where)
        elsewhere = [name for name, names in self.instances.items() if bare.casefold() in names._sets]
        hint = f"write {elsewhere[0]}.{bare}" if elsewhere else "correct the name, or define the set"
        raise MeshError(f"{where}: expected numbers or sets above, got {shorten(text)}; {hint}")

    def read(self, block: Block, budget: Budget) -> None:
        """Read a block that lists members, ranges of them, or sets above it."""
        block.require_options(block.keyword, "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED")
        name = block.option(block.keyword)
        if not name:
            raise MeshError(f"{block.where}: expected {block.keyword}=name, got none; name the set")
        source: Names = self
        if "INSTANCE" in block.options:
            found = self.instances.get(block.option("INSTANCE").casefold())
            if found is None:
                wrong = shorten(block.option("INSTANCE"))
                raise MeshError(f"{block.where}: expected an instance above, got {wrong}; correct the name")
            source = found
        listed = source._ranges if "GENERATE" in block.options else source._listed
        self.add(name, np.concatenate([integers([]), *listed(block, budget)]))

    def _ranges(self, block: Block, budget: Budget) -> Iterator[Indices]:
        for where, line in block.lines:
            parts = [natural(part, where) for part in fields(line)]
            if len(parts) not in (2, 3) or parts[0] > parts[1]:
                raise MeshError(f"{where}: expected first, last, step, got {shorten(line)}; correct the line")
            found = self._numbering.within(*parts)
            budget.spend(len(found) + 1, where)
            yield self._rows[self._numbering.rows(found, where)]

    def _listed(self, block: Block, budget: Budget) -> Iterator[Indices]:
        for where, line in block.lines:
            for part in fields(line):
                found = self.find(part, where)
                budget.spend(len(found) + 1, where)
                yield found
