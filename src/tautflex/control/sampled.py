"""Plants in discrete time behind drives and in front of late sensors, as a loop meets them.

A plant that is commanded once per interval knows exactly what is under way: commands of whole intervals, the output of
a drive's lag, whose mean over the interval acts (`Drive`), readings that have been taken and not told yet (`Sensor`).
They are further states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tautflex.errors import InputError
from tautflex.numeric import Array, Indices


@dataclass(frozen=True)
class Lateness:
    """How late inputs act and outputs tell.

    Parameters
    ----------
    lag, delay
        Time constant of a first-order lag, and time until a command acts, of each input [s].
    age
        Age of what each output tells [s].
    """

    lag: tuple[float, ...]
    delay: tuple[float, ...]
    age: tuple[float, ...]

    def __bool__(self) -> bool:
        return any(self.lag) or any(self.delay) or any(self.age)

    def selected(self, inputs: Indices, outputs: Indices) -> Lateness:
        """That of some inputs and outputs."""
        return Lateness(
            tuple(self.lag[k] for k in inputs),
            tuple(self.delay[k] for k in inputs),
            tuple(self.age[k] for k in outputs),
        )


class Carried(NamedTuple):
    """What a further state holds: a command, or a reading some samples old, and of which input or output."""

    of_output: bool
    place: int
    samples: int


@dataclass
class Sampled:
    """Matrices of a plant with further states, and their labels.

    Parameters
    ----------
    A, B, C, D
        Of the plant over one interval with what acts held; on return those of the whole.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    labels: list[str] = field(default_factory=list)
    carried: list[Carried] = field(default_factory=list)

    def take_in(self, late: Lateness, interval: float, inputs: Sequence[str], outputs: Sequence[str]) -> None:
        """Add the states of drives and sensors.

        Raises
        ------
        InputError
            If the delay of an input is no multiple of the interval.
        """
        n, m = self.B.shape
        waits, olds = self._samples(late, interval, inputs)
        lagging = [lag > 0.0 for lag in late.lag]
        shown = [bool(waits[k] or lagging[k] or (any(olds) and self.D[:, k].any())) for k in range(m)]
        places: dict[tuple[str, int], int] = {}
        for k, label in enumerate(inputs):
            for kind, count in (("waiting", waits[k]), ("lag", lagging[k]), ("acting", shown[k])):
                self._reserve(places, kind, k, int(count), label, of_output=False)
        for k, label in enumerate(outputs):
            self._reserve(places, "past", k, olds[k], label, of_output=True)
        size = n + len(self.carried)
        moved, given = np.zeros((size, size)), np.zeros((size, m))
        acts, acts_now = np.zeros((m, size)), np.zeros((m, m))
        for k in range(m):
            # What the drive is told: a command that has waited, or the one of now.
            target, now = np.zeros(size), np.zeros(m)
            if waits[k]:
                first = places["waiting", k]
                target[first + waits[k] - 1] = given[first, k] = 1.0
                moved[first + np.arange(1, waits[k]), first + np.arange(waits[k] - 1)] = 1.0
            else:
                now[k] = 1.0
            acts[k], acts_now[k] = target, now
            if lagging[k]:
                place, decay = places["lag", k], float(np.exp(-interval / late.lag[k]))
                mean = late.lag[k] / interval * (1.0 - decay)
                own = np.eye(size)[place]
                acts[k], acts_now[k] = mean * own + (1.0 - mean) * target, (1.0 - mean) * now
                moved[place], given[place] = decay * own + (1.0 - decay) * target, (1.0 - decay) * now
            if shown[k]:
                moved[places["acting", k]], given[places["acting", k]] = acts[k], acts_now[k]
        moved[:n, :n] = self.A
        moved[:n] += self.B @ acts
        given[:n] = self.B @ acts_now
        exact = np.concatenate([self.C, np.zeros((len(self.C), size - n))], axis=1)
        for k in range(m):
            if shown[k]:
                exact[:, places["acting", k]] += self.D[:, k]
        self.D = self.D * ~np.array(shown, dtype=bool)
        told = exact.copy()
        for k, old in enumerate(olds):
            if not old:
                continue
            first, share = places["past", k], late.age[k] / interval - (old - 1)
            moved[first] = exact[k]
            moved[first + np.arange(1, old), first + np.arange(old - 1)] = 1.0
            told[k] = (1.0 - share) * (exact[k] if old == 1 else np.eye(size)[first + old - 2])
            told[k, first + old - 1] += share
            self.D[k] = 0.0
        self.A, self.B, self.C = moved, given, told

    @staticmethod
    def _samples(late: Lateness, interval: float, inputs: Sequence[str]) -> tuple[list[int], list[int]]:
        """Intervals that commands wait and readings are kept."""
        waits = list[int]()
        for label, delay in zip(inputs, late.delay, strict=True):
            waits.append(round(delay / interval))
            if abs(delay / interval - waits[-1]) > 1e-6:
                raise InputError(
                    f"interval: expected one of which the delay of {label!r}, {delay:g} s, is a multiple, got "
                    f"{interval:g}; take for example {delay / max(1, waits[-1]):.6g}"
                )
        return waits, [int(np.ceil(age / interval - 1e-9)) for age in late.age]

    def _reserve(
        self, places: dict[tuple[str, int], int], kind: str, index: int, count: int, label: str, *, of_output: bool
    ) -> None:
        places[kind, index] = len(self.A) + len(self.carried)
        self.labels += [f"{label} {kind} {number + 1}" for number in range(count)]
        self.carried += [Carried(of_output, index, number + 1) for number in range(count)]
