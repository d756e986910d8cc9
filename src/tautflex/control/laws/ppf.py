"""Positive position feedback."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.law import LawMatrices, LinearLaw, LinearMemory
from tautflex.control.linear import LinearPlant
from tautflex.control.signals import LoopSpec
from tautflex.control.spillover import refuse_spillover
from tautflex.errors import InputError

# Static answers below this part of those of the modes are round-off.
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class PositivePositionFeedback(LinearLaw):
    """Positive position feedback: a second-order filter of a displacement pushes back [Goh & Caughey 1985].

    ``xi'' + 2 z w xi' + w^2 xi = w^2 y``, ``u = gain xi``. With sensor and actuator at the same place it damps all
    modes near the filter's frequency and is stable as long as ``gain G(0) < 1``, G(0) being the static displacement
    per command of all modes [Fanson & Caughey 1990]: at zero frequency the filter softens the structure, and at the
    limit nothing of its stiffness is left. The filter is discretized by the trapezoidal rule, which keeps that limit.

    Parameters
    ----------
    gain
        Command per displacement, in the units of the two; its sign is that of ``G(0)``.
    frequency
        Natural frequency of the filter [Hz], > 0; about that of the mode that is to be damped, or slightly above.
    measurement
        Name of the sensor, or of one of its numbers, such as ``"film[0]"``.
    command
        Name of the actuator, or of one of its numbers.
    damping_ratio
        Damping ratio of the filter, z, > 0.

    Raises
    ------
    InputError
        If a number is out of range; when a loop starts, if the gain is beyond the limit of its model.
    """

    gain: float
    frequency: float
    measurement: str
    command: str
    damping_ratio: float = 0.5
    follows_reference: ClassVar[bool] = False

    def __post_init__(self) -> None:
        checks.finite("gain", self.gain)
        checks.positive("frequency", self.frequency)
        checks.positive("damping_ratio", self.damping_ratio)

    def limit(self, plant: LinearPlant) -> float:
        """Gain at which the loop with a plant loses its static stiffness, ``1/G(0)``.

        Raises
        ------
        InputError
            If the command does not move what is measured.
        """
        plant = plant.selected([self.command], [self.measurement])
        eta, half = plant.positions, plant.half
        lean = -np.linalg.solve(plant.A[np.ix_(eta + half, eta)], plant.B[eta + half])
        static = float((plant.C[:, eta] @ lean + plant.D)[0, 0])
        if abs(static) <= _ROUND_OFF * np.abs(plant.C[:, eta]).max(initial=0.0) * np.abs(lean).max(initial=0.0):
            why = plant.remarks.get(self.command, "they may be apart by a nodal line")
            raise InputError(
                f"command: expected one that moves {self.measurement!r}, got {self.command!r}, whose static answer "
                f"there is zero: {why}; push where the sensor is"
            )
        return 1.0 / static

    def start(self, spec: LoopSpec) -> LinearMemory:
        """At rest, below the limit of the loop's model, which it leaves stable."""
        name = type(self).__name__
        spec.plant(name)
        memory, remedy = (
            super().start(spec),
            "lower gain, give it the sign of G(0), or put sensor and actuator in one place",
        )
        refuse_spillover(spec, memory.matrices, name, "gain", remedy)
        return memory

    def matrices(self, spec: LoopSpec) -> LawMatrices:
        """The filter by the trapezoidal rule; where there is a model, its limit is looked at."""
        places = checks.together(
            lambda: spec.measurement("measurement", self.measurement), lambda: spec.command("command", self.command)
        )
        for name, place in zip(("measurement", "command"), places, strict=True):
            if len(place) != 1:
                given = getattr(self, name)
                raise InputError(f"{name}: expected one number, got all {len(place)} of {given!r}; write '{given}[0]'")
        if spec.model is not None:
            labels = spec.commanded[places[1][0]], spec.measured[places[0][0]]
            own = PositivePositionFeedback(self.gain, self.frequency, labels[1], labels[0])
            limit = own.limit(spec.plant(type(self).__name__))
            if self.gain / limit >= 1.0:
                raise InputError(
                    f"gain: expected less than the static limit {limit:.6g}, where no stiffness is left, got "
                    f"{self.gain:g}; half of the limit is much already"
                )
        w = 2.0 * np.pi * self.frequency
        a = np.array([[0.0, 1.0], [-(w**2), -2.0 * self.damping_ratio * w]])
        b, c = np.array([0.0, w**2]), np.array([self.gain, 0.0])
        # x of the trapezoidal rule in the form that needs no earlier measurement.
        half = 0.5 * spec.interval
        inverse = np.linalg.inv(np.eye(2) - half * a)
        seen, given = len(spec.measured) + 3 * spec.axes, len(spec.commanded)
        into, out, through = np.zeros((2, seen)), np.zeros((given, 2)), np.zeros((given, seen))
        into[:, places[0][0]] = 2.0 * half * inverse @ (inverse @ b)
        out[places[1][0]] = c
        through[places[1][0], places[0][0]] = half * float(c @ inverse @ b)
        transition = inverse @ (np.eye(2) + half * a)
        level = None if spec.model is None else spec.plant(type(self).__name__).level
        return LawMatrices.of(transition, into, out, through, level)
