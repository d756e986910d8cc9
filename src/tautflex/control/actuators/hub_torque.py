"""Reaction wheels: torques on the hub, whose reaction they keep."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.actuators.drive import Drive
from tautflex.numeric import Array
from tautflex.text import brief

AXES = ("x", "y", "z", "xyz")


@dataclass(frozen=True)
class HubTorque(Drive):
    """Torque of reaction wheels on a free hub [N m], about its own axes.

    The wheels take up what they give: the momentum of spacecraft and wheels stays. The command is the whole torque on
    the hub; that of turning wheels about other axes is the drive's own business.

    Parameters
    ----------
    axis
        ``"x"``, ``"y"``, ``"z"``, or ``"xyz"``: three numbers.
    momentum
        Largest angular momentum of the wheel of each axis [N m s], > 0; beyond it there is no torque. None is none.

    Raises
    ------
    InputError
        If the axis is unknown or a number out of range.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.HubTorque("x", limit=6.0).axis
    'x'
    """

    axis: str = "x"
    momentum: float | None = None
    unit: ClassVar[str] = "N m"
    __repr__ = brief

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.one_of("axis", self.axis, AXES)
        if self.momentum is not None:
            checks.positive("momentum", self.momentum)

    @cached_property
    def rows(self) -> Array:
        """Axes of its numbers, shape (n, 3)."""
        return np.eye(3)[["xyz".index(letter) for letter in self.axis]]

    def within(self, torque: Array, stored: Array, interval: float) -> Array:
        """What of a torque wheels with some momentum [N m s] can give over an interval [s], shapes (n,)."""
        if self.momentum is None:
            return torque
        low, high = (stored - self.momentum) / interval, (stored + self.momentum) / interval
        return np.clip(torque, np.minimum(low, 0.0), np.maximum(high, 0.0))
