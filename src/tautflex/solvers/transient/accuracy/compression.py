"""Notices when an elastic film or cable carries compression that a real one could not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.plausibility import place_of
from tautflex.solvers.static.diagnosis import film_wrinkles

# Compression below this part of the largest resultant is not worth a word.
_NOTABLE = 1e-3


@dataclass
class _Worst:
    """The largest compression met, and how often there was any."""

    value: float = 0.0
    time: float = 0.0
    element: int = -1
    area: float = 0.0
    instants: int = 0

    def see(self, value: float, time: float, element: int, area: float) -> None:
        self.instants += 1
        self.area = max(self.area, area)
        if value < self.value:
            self.value, self.time, self.element = value, time, element

    def told(self, unit: str, name: str, place: str, instants: int) -> str:
        """How much, when, where and how often, of a number of instants looked at."""
        return (
            f"{self.value:.3g} {unit} at t = {self.time:.4g} s, {name} {self.element} at {place}; "
            f"at {self.instants / instants:.0%} of the stored instants"
        )


class CompressionWatch:
    """Follows a run and puts what it saw into sentences.

    Parameters
    ----------
    system
        The structure; parts with a nonlinear law are not watched.
    """

    def __init__(self, system: StructuralSystem) -> None:
        self._system = system
        self._film, self._cable, self._instants = _Worst(), _Worst(), 0
        self._film_elastic = not film_wrinkles(system)

    def see(self, time: float, found: list[float]) -> None:
        """Look at what `survey_stresses` found at one instant."""
        self._instants += 1
        smallest, largest, wrinkled, slack, _, element, push, pushing = found
        if self._film_elastic and smallest < -_NOTABLE * max(largest, 0.0):
            self._film.see(smallest, time, int(element), wrinkled + slack)
        if push < 0.0:
            self._cable.see(push, time, int(pushing), 0.0)

    def look_through(self, times: Array, found: Array) -> None:
        """Look at all instants [s] of a run, shape (time, 8)."""
        smallest, largest, push = found[:, 0], found[:, 1], found[:, 6]
        some = (smallest < -_NOTABLE * np.maximum(largest, 0.0)) | (push < 0.0)
        self._instants += int(np.count_nonzero(~some))
        for time, numbers in zip(times[some].tolist(), found[some].tolist(), strict=True):
            self.see(time, numbers)

    def warnings(self) -> list[str]:
        """Sentences with how much, where, when, and what to switch on; empty if there is nothing to say."""
        found, model = [], self._system.model
        if (worst := self._film).instants:
            told = worst.told("N/m", "element", place_of(model, "membrane", worst.element), self._instants)
            found.append(
                f"the elastic film carried compression: {told}, up to {worst.area:.0%} of its area; a real film "
                "wrinkles, set membrane.law = 'tension-field'"
            )
        if (worst := self._cable).instants:
            told = worst.told("N", "cable", place_of(model, "cable", worst.element), self._instants)
            found.append(f"an elastic cable pushed: {told}; a real cable goes slack, set cables.slack = true")
        return found
