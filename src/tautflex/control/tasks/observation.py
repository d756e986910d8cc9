"""What a policy sees: combinations of readings and reference on a scale that spans decades, commands, and time to go.

Array modules are arguments, so that laws, environments, batches and traced programs see the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tautflex.control.signals import LoopSpec
from tautflex.errors import InputError
from tautflex.numeric import Array

# Unit -> below which number a scale is straight, and which number is 1.
SCALES = {
    "rad": (1e-3, 1.5),
    "rad/s": (1e-3, 1.5),
    "rad/s^2": (1e-2, 1.5),
    "m": (2e-5, 2e-2),
    "m/s": (1e-3, 1.0),
    "N": (1e-3, 10.0),
}


@dataclass(frozen=True, eq=False)
class Observation:
    """Numbers in [-1, 1] from a measurement, the one before, the reference and the goal.

    ``o = asinh(M z / knee) / asinh(largest / knee)``, with z the measurement, the one before, and attitude, rate and
    acceleration of the reference and the attitude of the goal, about the hub's axes; then the last commands in parts of
    their limits, and the time to go.

    Parameters
    ----------
    matrix
        M, shape (n, 2 measurement + 4 axes).
    knee, largest
        In the units of the rows, shape (n,).
    labels
        What the rows are, then names of the commands, then ``"time to go"``.
    duration
        Of an episode [s].
    """

    matrix: Array
    knee: Array
    largest: Array
    labels: tuple[str, ...]
    duration: float

    @classmethod
    def of(cls, spec: LoopSpec, duration: float) -> Observation:
        """What a policy sees of a loop.

        Angles and rates of the hub are seen against goal and reference, displacements with their mean velocity over the
        interval before, all else as it is measured.

        Raises
        ------
        InputError
            If a unit has no scale.
        """
        size, axes = len(spec.measured), spec.axes
        rows, units, labels = list[Array](), list[str](), list[str]()

        def see(label: str, unit: str, entries: dict[int, float]) -> None:
            row = np.zeros(2 * size + 4 * axes)
            row[list(entries)] = list(entries.values())
            rows.append(row)
            units.append(unit)
            labels.append(f"{label} [{unit}]")

        place = 0
        for channel in spec.measurements:
            turning = channel.size == axes and channel.unit in ("rad", "rad/s")
            for axis, label in enumerate(channel.labels):
                at, reference = place + axis, 2 * size + axis
                if turning and channel.unit == "rad":
                    see(f"{label} - goal", "rad", {at: 1.0, reference + 3 * axes: -1.0})
                    see(f"{label} - reference", "rad", {at: 1.0, reference: -1.0})
                elif turning:
                    see(f"{label} - reference", "rad/s", {at: 1.0, reference + axes: -1.0})
                    see("reference's rate", "rad/s", {reference + axes: 1.0})
                    see("reference's acceleration", "rad/s^2", {reference + 2 * axes: 1.0})
                else:
                    see(label, channel.unit, {at: 1.0})
                    if channel.unit == "m":
                        see(f"change of {label}", "m/s", {at: 1.0 / spec.interval, size + at: -1.0 / spec.interval})
            place += channel.size
        unknown = next((unit for unit in units if unit not in SCALES), None)
        if unknown is not None:
            raise InputError(
                f"sensors: expected readings in one of {', '.join(SCALES)}, got one in {unknown}; leave that sensor out"
            )
        knee, largest = np.array([SCALES[unit] for unit in units]).reshape(-1, 2).T
        matrix = np.array(rows).reshape(len(rows), 2 * size + 4 * axes)
        return cls(matrix, knee.copy(), largest.copy(), (*labels, *spec.commanded, "time to go"), duration)

    @property
    def size(self) -> int:
        """How many numbers a policy sees."""
        return len(self.labels)

    def __call__(self, z: Any, command: Any, time: Any, xp: Any = np) -> Any:
        """What is seen, shape (size,).

        Parameters
        ----------
        z
            Measurement, the one before, attitude, rate and acceleration of the reference, attitude of the goal.
        command
            Last commands in parts of their limits, shape (commands,).
        time
            [s].
        xp
            Array module.
        """
        seen = xp.arcsinh(self.matrix @ z / self.knee) / np.arcsinh(self.largest / self.knee)
        to_go = xp.reshape(1.0 - 2.0 * time / self.duration, (1,))
        return xp.clip(xp.concatenate([seen, command, to_go]), -1.0, 1.0)
