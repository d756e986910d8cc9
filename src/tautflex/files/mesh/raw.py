"""What every mesh format has in common: numbered nodes, triangles, quads, lines, and named groups of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import MeshError
from tautflex.files.mesh.raw_links import RawLink
from tautflex.files.mesh.section.section_data import RawSection
from tautflex.numeric import Array, Indices

CORNERS = {"triangles": 3, "quads": 4, "lines": 2}
KINDS = tuple(CORNERS)
_LARGEST_COORDINATE = 1e9  # [m]; squares and products of any two lengths stay finite
_LARGEST_EXPANSION = 50_000_000


@dataclass(frozen=True)
class RawGroup:
    """Named selection in a file: rows of ``"nodes"`` and of each kind (or, before that, shape) of elements.

    ``directions`` are those that the file itself holds at these nodes; empty if it says nothing. ``doubt`` is why the
    file alone does not tell what the group is: an error, unless the user's names tell. ``sections`` are what the file
    states of its elements of one kind or several, ``nonstructural`` masses spread over them. ``links`` are equations of
    nodes that are held along other directions, ``role`` what the file itself makes of the group.
    """

    name: str
    rows: Mapping[str, Indices]
    directions: tuple[str, ...] = ()
    doubt: str = ""
    sections: tuple[RawSection, ...] = ()
    links: tuple[RawLink, ...] = ()
    role: str = ""
    nonstructural: tuple[RawNonstructural, ...] = ()

    def of(self, kind: str) -> Indices:
        """Rows of one kind."""
        return self.rows.get(kind, np.zeros(0, dtype=np.int64))


@dataclass(frozen=True)
class RawMass:
    """Rigid body of a file: mass, inertia about its centre (3, 3), centre from its node (3,), in the file's units.

    ``where`` is its place for messages, ``node`` the row of its node.
    """

    where: str
    mass: float
    inertia: Array
    offset: Array
    node: int = -1


@dataclass(frozen=True)
class RawNonstructural:
    """Mass without stiffness of the elements of a group, in the file's units.

    ``per`` is ``"membrane"`` (per area), ``"line"`` (per length), ``"total"``, in proportion to the masses of elements
    or ``"shared"``, to their areas or lengths; ``where`` is its place for messages.
    """

    where: str
    per: str
    value: float


@dataclass(frozen=True)
class RawMesh:
    """A file's mesh before its groups have a meaning.

    Parameters
    ----------
    nodes
        Positions in the unit of the file, shape (node, 3).
    elements
        Rows of ``nodes`` for each of `KINDS`, shapes (t, 3) or (t, 6), (q, 4) and (l, 2).
    roles
        What the element type says about each element of a kind, shapes (element,): ``"membrane"``, ``"cable"``,
        ``"beam"``, ``"shell"`` for a surface that also bends, or ``""`` where the name of the group decides.
    orientation
        Direction of each line's local z axis as a beam, nan if the file states none, shape (l, 3).
    groups
        Named selections.
    typed
        Whether the format's element types decide about roles (Abaqus, Nastran) or its names do (Gmsh).
    masses
        Rigid bodies at nodes.
    links
        Links and springs between nodes.
    stress
        Initial stress (sx, sy, txy) of elements of a kind, along lines the first alone, shapes (element, 3).
    strain
        Strain that elements of a kind would take if they were free, shapes (element,).
    """

    nodes: Array
    elements: Mapping[str, Indices]
    roles: Mapping[str, NDArray[np.str_]]
    orientation: Array
    groups: tuple[RawGroup, ...]
    typed: bool
    masses: tuple[RawMass, ...] = ()
    links: tuple[RawLink, ...] = ()
    stress: Mapping[str, Array] = field(default_factory=dict)
    strain: Mapping[str, Array] = field(default_factory=dict)


class Numbering:
    """Translates the numbers a file gives its nodes or elements into rows; MeshError if two have the same one."""

    def __init__(self, what: str, numbers: Indices) -> None:
        self._what = what
        self._order = np.argsort(numbers, kind="stable")
        self._sorted = numbers[self._order]
        twice = np.flatnonzero(self._sorted[1:] == self._sorted[:-1])
        if twice.size:
            raise MeshError(f"{what} {self._sorted[twice[0]]}: defined twice; give every {what} its own number")

    def rows(self, numbers: Indices, of: str) -> Indices:
        """Rows of ``numbers`` (any shape), or MeshError naming the first that does not exist."""
        if not numbers.size:
            return np.zeros(numbers.shape, dtype=np.int64)
        if not self._sorted.size:
            raise MeshError(f"{of}: expected an existing {self._what}, got {numbers.flat[0]} but there are none")
        place = np.minimum(np.searchsorted(self._sorted, numbers), len(self._sorted) - 1)
        wrong = self._sorted[place] != numbers
        if wrong.any():
            missing = numbers[wrong].flat[0]
            raise MeshError(f"{of}: expected an existing {self._what}, got {missing}; define it or correct the number")
        return self._order[place].astype(np.int64)

    def within(self, first: int, last: int, step: int = 1) -> Indices:
        """Existing numbers from ``first`` to ``last`` in steps, without spelling out the range itself."""
        low, high = np.searchsorted(self._sorted, [first, last + 1])
        found = self._sorted[low:high]
        return found[(found - first) % step == 0]


class Budget:
    """Bounds the work that nested sets and repeated ranges of a small file can ask for."""

    def __init__(self) -> None:
        self._left = _LARGEST_EXPANSION

    def spend(self, count: int, where: str) -> None:
        """Count ``count`` more set members, or raise MeshError."""
        self._left -= count
        if self._left < 0:
            raise MeshError(
                f"{where}: the sets of this file have more than {_LARGEST_EXPANSION} members in total; remove sets"
            )


def integers(values: Iterable[object]) -> Indices:
    """Integers as an array, also none at all."""
    return np.array(list(values), dtype=np.int64)


def require_coordinates(nodes: Array, numbers: Indices) -> None:
    """Raise MeshError if a coordinate is not finite or absurdly large."""
    bad = np.flatnonzero(~(np.abs(nodes) <= _LARGEST_COORDINATE).all(axis=1))
    if bad.size:
        position = ", ".join(f"{value:g}" for value in nodes[bad[0]])
        raise MeshError(
            f"node {numbers[bad[0]]}: expected finite coordinates below {_LARGEST_COORDINATE:g}, got ({position}); "
            "correct the node"
        )


def shorten(text: str, longest: int = 40) -> str:
    """Quote foreign text on one line."""
    shown = ascii(text)
    return shown if len(shown) <= longest else shown[: longest - 4] + "...'"
