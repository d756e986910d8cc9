"""Links, springs and dampers of a file, before its nodes have their numbers and its units are SI."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from tautflex.errors import MeshError
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.equation import LinkEquation
from tautflex.structure.links.link import Link
from tautflex.structure.springs import Joint

_ROUND_OFF = 1e-12


@dataclass(frozen=True)
class RawLink:
    """Link or spring whose nodes are rows of a file's, in its units; ``where`` is its place for messages."""

    where: str
    link: Link | Joint


def equation(terms: Iterable[tuple[int, int, float]], axes: Callable[[int], Array | None], where: str) -> LinkEquation:
    """Equation in global directions, of which the first node's largest term follows.

    Parameters
    ----------
    terms
        Row of the node, direction 0 to 5, coefficient.
    axes
        Directions of a node as rows, shape (3, 3), None where they are global.
    where
        Place for messages.
    """
    total, first = dict[tuple[int, str], float](), -1
    for row, direction, factor in terms:
        first = row if first < 0 else first
        own = axes(row)
        turned = np.eye(3)[direction % 3] if own is None else own[direction % 3]
        for axis, share in enumerate(turned):
            if abs(share) > _ROUND_OFF:
                key = row, DIRECTIONS[axis + 3 * (direction // 3)]
                total[key] = total.get(key, 0.0) + factor * float(share)
    leading = max((key for key in total if key[0] == first), key=lambda key: abs(total[key]), default=None)
    if leading is None or total[leading] == 0.0:
        raise MeshError(f"{where}: expected a first term with a coefficient, got none; complete the equation")
    ordered = [leading, *(key for key in total if key != leading)]
    return LinkEquation(tuple((node, way, total[node, way]) for node, way in ordered))


def attached(links: Iterable[RawLink], used: Indices) -> tuple[list[RawLink], Indices]:
    """Links that join nodes in use, themselves or through others, and all nodes that are then in use."""
    known, waiting, found = set(used.tolist()), list(links), set[int]()
    left, before = list(range(len(waiting))), -1
    while len(left) != before:
        before = len(left)
        for place in left:
            if not known.isdisjoint(waiting[place].link.joined):
                known.update(waiting[place].link.joined)
                found.add(place)
        left = [place for place in left if place not in found]
    return [waiting[place] for place in sorted(found)], np.array(sorted(known), dtype=np.int64)


def finished(
    links: Iterable[RawLink], new: Indices, unit_length: float, unit_mass: float | None
) -> Iterator[Link | Joint]:
    """Links, springs and dampers in SI units between nodes of the structure, given the new number of each row.

    Raises
    ------
    MeshError
        If the unit of force of a spring or damper is not known.
    """
    for raw in links:
        one: Any = raw.link
        changes: dict[str, Any] = {}
        names = {item.name for item in fields(one)}
        if "reference" in names:
            changes["reference"] = int(new[one.reference])
        if "nodes" in names:
            changes["nodes"] = tuple(new[list(one.nodes)].tolist())
        if isinstance(one, LinkEquation):
            # Rotations stand beside lengths in the unit of the file.
            terms = [
                (int(new[node]), way, float(c) * (unit_length if DIRECTIONS.index(way) > 2 else 1.0))
                for node, way, c in one.terms
            ]
            changes["terms"] = tuple(terms)
        if isinstance(one, Joint):
            if unit_length != 1.0 and unit_mass is None:
                raise MeshError(
                    f"{raw.where}: expected unit_mass beside unit_length = {unit_length:g}, got none; state the file's "
                    "unit of mass in kg (1000 for t, mm, s)"
                )
            unit = unit_mass or 1.0
            scale = unit * np.array([1.0] * 3 + [unit_length**2] * 3)
            given = np.asarray(one.given, dtype=float)
            changes[one.quantity] = tuple((given * scale[: len(given)]).tolist()) if given.ndim else float(unit * given)
        yield replace(one, **changes)
