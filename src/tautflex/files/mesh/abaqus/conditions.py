"""Boundary conditions and temperatures of the step that is computed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Budget, RawGroup, integers, shorten
from tautflex.files.mesh.systems import held_directions
from tautflex.numeric import Array, Indices

# Directions 1 to 6 of the conditions that have names; those of symmetry and antisymmetry by their plane's normal.
NAMED = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6),
    "PINNED": (1, 2, 3),
    "XSYMM": (1, 5, 6),
    "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5),
    "XASYMM": (2, 3, 4),
    "YASYMM": (1, 3, 5),
    "ZASYMM": (1, 2, 6),
}


@dataclass
class Steps:
    """Boundary conditions of the model, then of each step, elements that come or go, and temperatures."""

    conditions: list[list[Block]] = field(default_factory=lambda: [[]])
    changes: list[list[Block]] = field(default_factory=lambda: [[]])
    temperatures: list[list[Block]] = field(default_factory=lambda: [[]])
    frequencies: list[int] = field(default_factory=list)
    inside: bool = False

    def read(self, block: Block) -> None:
        """Read a block that begins or ends a step, asks for frequencies, or holds nodes."""
        if block.keyword == "STEP":
            self.conditions.append([])
            self.changes.append([])
            self.temperatures.append([])
            self.inside = True
        elif block.keyword == "END STEP":
            self.inside = False
        elif block.keyword == "FREQUENCY":
            self.frequencies.append(len(self.conditions) - 1)
        elif block.keyword == "MODEL CHANGE":
            block.require_options("ADD", "REMOVE", "TYPE")
            if block.option("TYPE").upper() not in ("", "ELEMENT") or ("ADD" in block.options) == (
                "REMOVE" in block.options
            ):
                raise MeshError(f"{block.where}: expected ADD or REMOVE of elements, got another change; leave it out")
            self.changes[-1 if self.inside else 0].append(block)
        elif block.keyword == "TEMPERATURE":
            self.temperatures[-1 if self.inside else 0].append(block)
        else:
            block.require_options("TYPE", "OP", "AMPLITUDE", "FIXED", "REGION TYPE")
            self.conditions[-1 if self.inside else 0].append(block)

    def in_force(self, step: int | None) -> tuple[list[Block], list[Block], list[Block]]:
        """Conditions of a step, changes of elements up to it, and temperatures.

        Those of earlier steps are included, until an ``OP=NEW`` takes conditions or temperatures away.

        Without ``step`` it is the only one, the only one that asks for frequencies, or any if all hold the same.
        """
        count = len(self.conditions) - 1
        if step is not None and not 1 <= step <= max(count, 1):
            raise MeshError(f"expected step = 1 to {max(count, 1)}, a step of the file, got {step}; choose one")
        found = list(self._by_step())
        if step is None and len(self.frequencies) == 1:
            step = self.frequencies[0]
        if step is None and any(found[k] != found[1] for k in range(2, count + 1)):
            listed = ", ".join(
                f"{k} has {len(blocks)} conditions, {len(changes)} changes of elements, {len(warm)} of temperatures"
                for k, (blocks, changes, warm) in enumerate(found[1:21], start=1)
            )
            raise MeshError(
                f"expected steps with the same supports and elements, got others ({listed}); choose one with step = "
                "number"
            )
        return found[min(step or 1, count)]

    def _by_step(self) -> Iterator[tuple[list[Block], list[Block], list[Block]]]:
        held, changed, warm = list[Block](), list[Block](), list[Block]()
        for blocks, changes, warmer in zip(self.conditions, self.changes, self.temperatures, strict=True):
            held, changed, warm = _with(blocks, held), [*changed, *changes], _with(warmer, warm)
            yield held, changed, warm


def _with(blocks: list[Block], before: list[Block]) -> list[Block]:
    """Blocks of a step behind those of the step before, unless they take these away."""
    operations = {block.option("OP").upper() or "MOD" for block in blocks}
    if operations - {"NEW", "MOD"}:
        raise MeshError(f"{blocks[0].where}: expected OP=NEW or OP=MOD, got another; correct it")
    return [*([] if "NEW" in operations else before), *blocks]


def held_groups(conditions: list[Block], names: Names, axes: dict[int, Array], budget: Budget) -> Iterator[RawGroup]:
    """Boundary conditions, one group per line; what is held of nodes with axes of their own is joined first.

    ``axes`` are the directions of these nodes as rows, shape (3, 3), by row of the node.
    """
    turned: dict[int, set[int]] = {}
    for block in conditions:
        kind = block.option("TYPE") or "DISPLACEMENT"
        if kind.upper() != "DISPLACEMENT":
            raise MeshError(f"{block.where}: expected TYPE=DISPLACEMENT, got {shorten(kind)}; remove the condition")
        for where, line in block.lines:
            target, directions = _condition(where, line)
            rows = names.find(target, where)
            budget.spend(len(rows) + 1, where)
            own = np.array([row in axes for row in rows.tolist()], dtype=bool)
            for row in rows[own].tolist():
                turned.setdefault(row, set()).update(directions)
            if not own.all():
                held, _ = held_directions(directions, None, 0, where)
                yield RawGroup(f"boundary {target}", {"nodes": rows[~own]}, held)
    alike: dict[tuple[str, ...], list[int]] = {}
    for row, found in turned.items():
        along, links = held_directions(found, axes[row], row, "BOUNDARY of a transformed node")
        if along:
            alike.setdefault(along, []).append(row)
        if links:
            yield RawGroup("boundary in transformed directions", {"nodes": integers([row])}, links=tuple(links))
    for held, members in alike.items():
        yield RawGroup("boundary in transformed directions", {"nodes": integers(members)}, held)


def _condition(where: str, line: str) -> tuple[str, list[int]]:
    """Node or set, and directions 0 to 5."""
    target, *rest = fields(line) or [""]
    if not rest:
        raise MeshError(f"{where}: expected node or set and directions, got {shorten(line)}; correct the line")
    if rest[0].upper() in NAMED:
        if any(rest[1:]):
            raise MeshError(f"{where}: expected nothing behind {rest[0]}, got {shorten(line)}; correct the line")
        return target.strip().strip('"'), [direction - 1 for direction in NAMED[rest[0].upper()]]
    first = natural(rest[0], where)
    last = natural(rest[1], where) if len(rest) > 1 and rest[1] else first
    if not 1 <= first <= last <= 6 or len(rest) > 3:
        raise MeshError(f"{where}: expected directions 1 to 6, got {shorten(line)}; correct the line")
    if len(rest) > 2 and real(rest[2], where) != 0.0:
        raise MeshError(f"{where}: expected held nodes, got a displacement in {shorten(line)}; set it to zero")
    return target.strip().strip('"'), list(range(first - 1, last))


def removed_elements(changes: list[Block], names: Names) -> Indices:
    """Rows of the elements that are gone after some changes."""
    gone: set[int] = set()
    for block in changes:
        rows = {row for where, line in block.lines for name in fields(line) for row in names.find(name, where).tolist()}
        gone = gone | rows if "REMOVE" in block.options else gone - rows
    return integers(sorted(gone))
