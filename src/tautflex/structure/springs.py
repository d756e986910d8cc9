"""Linear springs and dampers between nodes, or to the floating frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.structure.links.tie import rotation
from tautflex.text import brief


class Joint:
    """Base of springs and dampers: what they give is linear in differences of displacements or of velocities."""

    nodes: Sequence[int]
    axes: ArrayLike | None
    place: float | None
    quantity: ClassVar[str]

    @property
    def given(self) -> ArrayLike:
        """Number along the line, or three or six along and about the axes, as they were given."""
        found: ArrayLike = getattr(self, self.quantity)
        return found

    def __post_init__(self) -> None:
        name, nodes = self.quantity, checks.indices("nodes", self.nodes, np.iinfo(np.int64).max).tolist()
        if len(nodes) not in (1, 2) or len(set(nodes)) < len(nodes):
            raise InputError(f"nodes: expected one node, or two different ones, got {nodes}; correct them")
        given = checks.numbers(name, self.given)
        if given.shape not in ((), (3,), (6,)):
            raise InputError(f"{name}: expected one number, three or six, got shape {given.shape}; correct it")
        checks.float_array(name, given.ravel(), (None,))
        if np.any(given < 0.0) or not np.any(given):
            raise InputError(f"{name}: expected numbers >= 0, not all 0, got {given.tolist()}; correct them")
        rotation("axes", self.axes)
        if given.shape == () and (len(nodes) == 1 or self.axes is not None):
            raise InputError(
                f"{name}: expected three or six numbers with {'axes' if len(nodes) == 2 else 'one node'}, got "
                f"{given:g}, which is along the line between two nodes; write ({given:g}, 0.0, 0.0)"
            )
        if self.place is not None:
            checks.between("place", self.place, 0.0, 1.0)
            if len(nodes) == 1:
                raise InputError(f"place: expected none at one node, got {self.place:g}; leave it out")

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of its nodes."""
        return tuple(self.nodes)

    @property
    def values(self) -> Array:
        """Along and about the axes, shape (6,)."""
        given = checks.numbers(self.quantity, self.given).ravel()
        return np.concatenate([given, np.zeros(6 - len(given))])

    @property
    def turns(self) -> bool:
        """Whether it feels rotations of its nodes."""
        return bool(self.values[3:].any()) or self.place is not None

    def axes_at(self, nodes: Array) -> Array:
        """Axes as rows, shape (3, 3), among nodes at these positions [m], shape (node, 3).

        Raises
        ------
        InputError
            If two nodes at the same place have one number along their line.
        """
        if np.ndim(self.given):
            return rotation("axes", self.axes)
        first, second = nodes[list(self.nodes)]
        length = float(np.linalg.norm(second - first))
        if length <= 1e-10 * float(np.ptp(nodes, axis=0).max()):
            raise InputError(
                f"{self.quantity}: expected nodes at two places for one number along their line, got nodes "
                f"{list(self.nodes)} at one; give three along x, y, z"
            )
        along = (second - first) / length
        # A reflection takes x to the line; the sign of the other axes, which are free, does not matter.
        mirror = along - np.eye(3)[0]
        square = float(mirror @ mirror)
        return np.eye(3) if square < 1e-30 else np.eye(3) - 2.0 * np.outer(mirror, mirror) / square


@dataclass(frozen=True)
class Spring(Joint):
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

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Spring([5], (0.0, 0.0, 100.0)).nodes
    [5]
    """

    nodes: Sequence[int]
    stiffness: ArrayLike
    axes: ArrayLike | None = None
    place: float | None = None
    quantity: ClassVar[str] = "stiffness"
    __repr__ = brief

    @property
    def stiffnesses(self) -> Array:
        """Along and about the axes [N/m, N m/rad], shape (6,)."""
        return self.values


@dataclass(frozen=True)
class Damper(Joint):
    """Viscous damper (dashpot) between two nodes, or between one and the floating frame; linear, its axes do not turn.

    It belongs to the structure: every run, linear view, reduced model and batch has it beside its `Damping`.

    Parameters
    ----------
    nodes
        Numbers of two nodes, or of one against the floating frame.
    damping
        Along the line between two nodes, one number [N s/m]; or along x, y, z of the axes, three numbers [N s/m]; or
        these and three about x, y, z [N m s/rad].
    axes
        Directions x, y, z that are meant, rows of shape (3, 3) at right angles; None is the floating frame's.
    place
        Where it acts between two nodes, 0 at the first and 1 at the second, with rigid arms to both; None takes the
        differences of their velocities as they are, which resist turning as a whole between nodes at different places.

    Raises
    ------
    InputError
        If a number is negative or all are 0, or nodes or axes are none.
    """

    nodes: Sequence[int]
    damping: ArrayLike
    axes: ArrayLike | None = None
    place: float | None = None
    quantity: ClassVar[str] = "damping"
    __repr__ = brief
