"""Linear springs between nodes, or to the floating frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.structure.links.tie import rotation
from tautflex.text import brief


@dataclass(frozen=True)
class Spring:
    """Spring without mass between two nodes, or between one and the floating frame; linear, its axes do not turn.

    Parameters
    ----------
    nodes
        Numbers of two nodes, or of one that is held to the floating frame.
    stiffness
        Along the line between two nodes, one number [N/m]; or along x, y, z of the axes, three numbers [N/m]; or these
        and three about x, y, z [N m/rad].
    axes
        Directions x, y, z that are meant, rows of shape (3, 3) at right angles; None is the floating frame's.
    place
        Where it acts between two nodes, 0 at the first and 1 at the second, with rigid arms to both; None takes the
        differences of their displacements as they are, which hold nodes at different places against turning.

    Raises
    ------
    InputError
        If a stiffness is negative or all are 0, or nodes or axes are none.
    """

    nodes: Sequence[int]
    stiffness: ArrayLike
    axes: ArrayLike | None = None
    place: float | None = None
    __repr__ = brief

    def __post_init__(self) -> None:
        nodes = checks.indices("nodes", self.nodes, np.iinfo(np.int64).max).tolist()
        if len(nodes) not in (1, 2) or len(set(nodes)) < len(nodes):
            raise InputError(f"nodes: expected one node, or two different ones, got {nodes}; correct them")
        given = checks.numbers("stiffness", self.stiffness)
        if given.shape not in ((), (3,), (6,)):
            raise InputError(f"stiffness: expected one number, three or six, got shape {given.shape}; correct it")
        checks.float_array("stiffness", given.ravel(), (None,))
        if np.any(given < 0.0) or not np.any(given):
            raise InputError(f"stiffness: expected numbers >= 0, not all 0, got {given.tolist()}; correct them")
        rotation("axes", self.axes)
        if given.shape == () and (len(nodes) == 1 or self.axes is not None):
            raise InputError(
                f"stiffness: expected three or six numbers with {'axes' if len(nodes) == 2 else 'one node'}, got "
                f"{given:g}, which is along the line between two nodes; write ({given:g}, 0.0, 0.0)"
            )
        if self.place is not None:
            checks.between("place", self.place, 0.0, 1.0)
            if len(nodes) == 1:
                raise InputError(f"place: expected none of a spring at one node, got {self.place:g}; leave it out")

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of its nodes."""
        return tuple(self.nodes)

    @property
    def stiffnesses(self) -> Array:
        """Along and about the axes [N/m, N m/rad], shape (6,)."""
        given = checks.numbers("stiffness", self.stiffness).ravel()
        return np.concatenate([given, np.zeros(6 - len(given))])

    @property
    def turns(self) -> bool:
        """Whether it feels rotations of its nodes."""
        return bool(self.stiffnesses[3:].any()) or self.place is not None

    def axes_at(self, nodes: Array) -> Array:
        """Axes as rows, shape (3, 3), among nodes at these positions [m], shape (node, 3).

        Raises
        ------
        InputError
            If two nodes of a spring along their line are at the same place.
        """
        if np.ndim(self.stiffness):
            return rotation("axes", self.axes)
        first, second = nodes[list(self.nodes)]
        length = float(np.linalg.norm(second - first))
        if length <= 1e-10 * float(np.ptp(nodes, axis=0).max()):
            raise InputError(
                f"springs: expected nodes at two places for a stiffness along their line, got nodes {list(self.nodes)} "
                "at one; give three stiffnesses along x, y, z"
            )
        along = (second - first) / length
        # A reflection takes x to the line; the sign of the other axes, which are free, does not matter.
        mirror = along - np.eye(3)[0]
        square = float(mirror @ mirror)
        return np.eye(3) if square < 1e-30 else np.eye(3) - 2.0 * np.outer(mirror, mirror) / square
