"""Tasks: what an agent is to do, what it is paid, and when an episode ends [control.md 5].

The formulas take an array module, so that environments, batches and traced programs pay the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import Effect
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.numeric import Array
from tautflex.reduction.bases.modal_basis import ModalBasis
from tautflex.structure.model import Model

Range = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Task:
    """What an agent is to do, as fixed numbers.

    Cost and reward of an interval are, with the angle e between hub and goal, the film's rms s and commands u in parts
    of their limits,

    ``cost = log(1 + (e/e_tol)^2 + (s/s_tol)^2)``,
    ``reward = -cost/log(1 + 1e4) - effort_weight |u|^2 - change_weight |u - u_before|^2``.

    Parameters
    ----------
    duration
        Length of an episode [s], > 0.
    commands
        Actuators of the case that the agent commands; none: all of them.
    attitude_tolerance
        Angle that counts one [rad], > 0.
    surface_tolerance
        Rms of the film that counts one [m], > 0.
    attitude_limit
        Angle from the goal at which an episode ends [rad], > attitude_tolerance.
    surface_limit
        Rms of the film at which an episode ends [m], > surface_tolerance.
    wrinkled_limit
        Part of the film's area that may wrinkle, of those plants that tell it, in (0, 1]; more is a failure.
    effort_weight
        What commands cost, >= 0.
    change_weight
        What their changes cost, >= 0.
    tension_error
        Largest error of the tension that is drawn, as a part of it, in [0, 0.5].
    effectiveness
        Least and largest part of a command that an actuator on the structure gives, > 0.
    noise
        Least and largest factor of the sensors' noise, >= 0.
    coordinates
        Coordinates of the reduced model for training, > 2.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    duration: float = 10.0
    commands: tuple[str, ...] = ()
    attitude_tolerance: float = 1e-3
    surface_tolerance: float = 2e-5
    attitude_limit: float = 1.5
    surface_limit: float = 0.02
    wrinkled_limit: float = 0.5
    effort_weight: float = 1e-3
    change_weight: float = 1e-3
    tension_error: float = 0.08
    effectiveness: Range = (0.6, 1.1)
    noise: Range = (0.5, 2.0)
    coordinates: int = 8

    drawn: ClassVar[tuple[str, ...]] = ("tension_error", "effectiveness", "noise")
    """Parameters of an episode, in the order in which they are drawn."""
    directions: ClassVar[tuple[str, ...]] = ("rx",)
    """Rigid accelerations that excite the film, see `ModalBasis`."""

    def __post_init__(self) -> None:
        for name in ("duration", "attitude_tolerance", "surface_tolerance"):
            checks.positive(name, getattr(self, name))
        for what in ("attitude", "surface"):
            limit, tolerance = getattr(self, f"{what}_limit"), getattr(self, f"{what}_tolerance")
            if not checks.finite(f"{what}_limit", limit) > tolerance:
                raise InputError(
                    f"{what}_limit: expected more than {what}_tolerance = {tolerance:g}, got {limit:g}; enlarge it"
                )
        checks.between("wrinkled_limit", self.wrinkled_limit, 1e-9, 1.0)
        checks.non_negative("effort_weight", self.effort_weight)
        checks.non_negative("change_weight", self.change_weight)
        checks.between("tension_error", self.tension_error, 0.0, 0.5)
        rising_range("effectiveness", self.effectiveness, 1e-9)
        rising_range("noise", self.noise, 0.0)
        checks.whole("coordinates", self.coordinates, 3)

    def limits(self) -> dict[str, Range]:
        """Least and largest value of each drawn parameter."""
        return {
            "tension_error": (-self.tension_error, self.tension_error),
            "effectiveness": self.effectiveness,
            "noise": self.noise,
        }

    def nominal(self) -> dict[str, float]:
        """Parameters of an episode without errors, in the middle of what is drawn."""
        return {"tension_error": 0.0, "effectiveness": 1.0, "noise": 1.0}

    @property
    def basis(self) -> ModalBasis:
        """Basis of the reduced model for training."""
        return ModalBasis(directions=self.directions, count=self.coordinates - len(self.directions))

    def grid(self, count: int = 4) -> list[dict[str, float]]:
        """Parameters of episodes to judge on, without errors: the first that is drawn, from end to end."""
        first, nominal = self.drawn[0], self.nominal()
        return [nominal | {first: float(value)} for value in np.linspace(*self.limits()[first], count)]

    def maneuver(self, parameters: dict[str, float]) -> Maneuver:
        """What laws are to follow, or what is prescribed where there is no hub; its end is the goal."""
        return AtRest()

    def goal(self, parameters: dict[str, Any]) -> Any:
        """Angle about the hub's axis at the end [rad]."""
        return 0.0

    def reference(self, time: Any, parameters: dict[str, Any], xp: Any = np) -> list[Any]:
        """Angle, rate and acceleration about the hub's axis that laws follow, at instants [s]."""
        return [0.0 * time] * 3

    def effects(self, model: Model) -> dict[str, Effect]:
        """What disturbs the structure, beside errors of its tension, by name."""
        return {}

    def acting(self, parameters: dict[str, Any], place: Any, interval: float, xp: Any = np) -> list[Any]:
        """How much of each effect acts in intervals [s] of some numbers, each of the shape of ``place``."""
        return []

    def disturbances(self, parameters: dict[str, float], count: int, interval: float) -> Array:
        """The same in each interval of an episode, shape (count, effects)."""
        found = self.acting(parameters, np.arange(count), interval)
        return np.reshape(np.array(found, dtype=float), (len(found), count)).T

    def cost(self, attitude_error: Any, surface_rms: Any, xp: Any = np) -> Any:
        """Cost of an instant, angle [rad] and rms [m] of any shape; ``xp`` is their array module."""
        angle, rms = attitude_error / self.attitude_tolerance, surface_rms / self.surface_tolerance
        return xp.log1p(angle * angle + rms * rms)

    def reward(self, attitude_error: Any, surface_rms: Any, command: Any, before: Any, xp: Any = np) -> Any:
        """Reward of an interval that ends at an angle [rad] and rms [m], commands of shape (..., n) in [-1, 1]."""
        change = command - before
        effort = self.effort_weight * xp.sum(command * command, axis=-1)
        return (
            -self.cost(attitude_error, surface_rms, xp) / np.log1p(1e4)
            - effort
            - self.change_weight * xp.sum(change * change, axis=-1)
        )

    def failed(self, attitude_error: Any, surface_rms: Any, xp: Any = np) -> Any:
        """Whether an episode ends here: out of range, or no number."""
        return ~((xp.abs(attitude_error) <= self.attitude_limit) & (surface_rms <= self.surface_limit))

    @property
    def worst_cost(self) -> float:
        """Cost of an instant after a failure: no instant before one costs more."""
        return float(self.cost(self.attitude_limit, self.surface_limit))

    def worst_reward(self, commands: int) -> float:
        """Reward of an interval after a failure, no more than that of any interval before one."""
        return float(-self.worst_cost / np.log1p(1e4) - commands * (self.effort_weight + 4.0 * self.change_weight))


def rising_range(name: str, limits: Range, least: float) -> None:
    """Raise InputError unless limits rise from ``least`` on."""
    low, high = checks.float_array(name, limits, (2,))
    if not least <= low <= high:
        text = f"{name}: expected two rising numbers, the first >= {least:g}, got {list(limits)}"
        raise InputError(f"{text}; correct them")
