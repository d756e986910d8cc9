"""What a law is told before it starts: names, units and sizes of what it reads and commands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tautflex import checks
from tautflex.control.linear import LinearPlant
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices


@dataclass(frozen=True)
class Channel:
    """One sensor's measurement or one actuator's command.

    Parameters
    ----------
    name
        Its name in the plant.
    unit
        Unit of its numbers.
    size
        How many numbers it has.
    noise
        Standard deviation of the noise in them, as far as it is known.
    """

    name: str
    unit: str
    size: int = 1
    noise: float = 0.0

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of its numbers, such as ``torque``, or ``film[0]`` and ``film[1]``."""
        return (self.name,) if self.size == 1 else tuple(f"{self.name}[{k}]" for k in range(self.size))


def labels_of(channels: Iterable[Channel]) -> tuple[str, ...]:
    """Names of all numbers of some channels in order."""
    return tuple(label for channel in channels for label in channel.labels)


def units_of(channels: Iterable[Channel]) -> tuple[str, ...]:
    """Units of the same."""
    return tuple(channel.unit for channel in channels for _ in range(channel.size))


@dataclass(frozen=True, eq=False)
class LoopSpec:
    """What a law is told before it starts.

    Parameters
    ----------
    measurements, commands
        Channels in the order in which their numbers come.
    interval
        Time between two commands [s].
    axes
        Axes of the hub that the reference has: 0, 1 or 3.
    model
        Linear view of the plant in continuous time; None where there is none.
    beyond
        The same with more modes, which laws that know the model must leave stable; None: the model itself.
    remarks
        What laws say about the loop as they start, in words; runs have it among their warnings.
    """

    measurements: tuple[Channel, ...]
    commands: tuple[Channel, ...]
    interval: float
    axes: int = 0
    model: LinearPlant | None = None
    beyond: LinearPlant | None = None
    remarks: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        checks.positive("interval", self.interval)
        for name in ("model", "beyond"):
            checks.instance(name, getattr(self, name), (LinearPlant, type(None)), "plant.linearize(), or None")

    @property
    def measured(self) -> tuple[str, ...]:
        """Labels of all numbers of the measurement."""
        return labels_of(self.measurements)

    @property
    def commanded(self) -> tuple[str, ...]:
        """Labels of all numbers of the command."""
        return labels_of(self.commands)

    def measurement(self, key: str, name: str, unit: str | None = None) -> Indices:
        """Places of a channel, or of one of its numbers, in the measurement; ``key`` is the law's word for it.

        Another unit than one that is given is refused.
        """
        return _places(key, name, self.measurements, "a sensor", unit)

    def command(self, key: str, name: str, unit: str | None = None) -> Indices:
        """The same in the command."""
        return _places(key, name, self.commands, "an actuator", unit)

    def plant(self, law: str) -> LinearPlant:
        """The linear model, with the commands and measurements of the loop alone, in their order.

        Raises
        ------
        InputError
            If there is none, or it knows one of them not.
        """
        if self.model is None:
            raise InputError(f"model: expected the plant's linear model for {law}, got none; give plant.linearize()")
        if self.model.interval is not None:
            raise InputError(
                f"model: expected one in continuous time for {law}, got one of {self.model.interval:g} s; give it "
                "before discretize"
            )
        return self.model.selected(self.commanded, self.measured)

    @property
    def noise(self) -> Array:
        """Standard deviation of the noise of every number of the measurement, shape (measurement,)."""
        return np.array([channel.noise for channel in self.measurements for _ in range(channel.size)])


def labelled(key: str, values: Mapping[str, float], labels: Sequence[str], least: bool = True) -> dict[int, float]:
    """Positive numbers given for labels, or for all numbers of a channel by its name: place -> number.

    Raises
    ------
    InputError
        If a name is unknown, a number is not positive, or there is none where one is needed.
    """
    example = f"write for example {{{next(iter(labels), 'rate')!r}: 1.0}}"
    if not isinstance(values, Mapping):
        raise InputError(f"{key}: expected numbers by name, got {values!r}; {example}")
    found: dict[int, float] = {}
    for name, value in values.items():
        places = [k for k, label in enumerate(labels) if name in (label, label.partition("[")[0])]
        if not places:
            known = ", ".join(map(repr, labels[:8])) + (" ..." if len(labels) > 8 else "") or "none"
            raise InputError(f"{key}: expected names among {known}, got {name!r}; {checks.pick(name, labels)}")
        found |= dict.fromkeys(places, checks.positive(f"{key}.{name}", value))
    if least and not found:
        raise InputError(f"{key}: expected at least one number, got none; {example}")
    return found


def check_numbers(key: str, values: Mapping[str, float] | None, least: int = 0) -> None:
    """Raise InputError unless values are positive numbers by name, as many as needed; which names is not asked yet."""
    if values is not None or least:
        known = list(values) if isinstance(values, Mapping) else []
        labelled(key, values, list(map(str, known)), bool(least))  # type: ignore[arg-type]


def _places(key: str, name: str, channels: tuple[Channel, ...], role: str, unit: str | None) -> Indices:
    checks.instance(key, name, str, f"the name of {role}")
    first = 0
    for channel in channels:
        if unit not in (None, channel.unit) and name in (channel.name, *channel.labels):
            raise InputError(
                f"{key}: expected the name of {role} in {unit}, got {name!r} in {channel.unit}; choose another"
            )
        if name == channel.name:
            return np.arange(first, first + channel.size)
        if name in channel.labels:
            return np.array([first + channel.labels.index(name)])
        first += channel.size
    known = ", ".join(repr(channel.name) for channel in channels) or "none"
    fitting = [channel.name for channel in channels if unit in (None, channel.unit)]
    remedy = f"try {fitting[0]!r} for {key}, or add it" if fitting else "add it"
    raise InputError(f"{key}: expected the name of {role}, one of {known}, got {name!r}; {remedy}")


class Reference(NamedTuple):
    """What a law is to follow at an instant.

    Parameters
    ----------
    time
        [s].
    attitude, rate, acceleration
        Rotation vector [rad], angular velocity [rad/s] and acceleration [rad/s^2] about the hub's axes, shapes (axes,).
    goal
        Attitude at the end of the maneuver [rad]; None where it has none.
    """

    time: float
    attitude: Array
    rate: Array
    acceleration: Array
    goal: Array | None = None

    @property
    def numbers(self) -> Array:
        """Attitude, rate and acceleration, shape (3 axes,)."""
        return np.concatenate([self.attitude, self.rate, self.acceleration])

    @classmethod
    def rest(cls, time: float, axes: int) -> Reference:
        """Stay where you are."""
        return cls(time, *np.zeros((3, axes)))
