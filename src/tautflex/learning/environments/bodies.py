"""Plants of an arena side by side, commanded and read as rows of arrays."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tautflex import checks
from tautflex.errors import NotConvergedError
from tautflex.learning.arena import Arena
from tautflex.motion.kinematics import Maneuver
from tautflex.numeric import Array, Indices

KINDS = ("reduced", "full")


class Bodies(Protocol):
    """Plants side by side.

    Attributes
    ----------
    readings
        Exact readings of the last instant, shape (count, outputs).
    failed
        Not 0 of plants whose steps failed since their reset, shape (count,).
    """

    readings: Array
    failed: Indices

    def reset(self, row: int, maneuver: Maneuver) -> None:
        """Begin anew."""

    def step(self, command: Array) -> None:
        """Hold commands over one interval, shape (count, inputs)."""

    def displacement(self, row: int) -> Array:
        """Displacement of all nodes [m], shape (node, 3)."""


class PlantBodies:
    """Plants that each keep their run, as they are judged."""

    def __init__(self, arena: Arena, kind: str, count: int) -> None:
        self.plants = [arena.plant(kind) for _ in range(count)]
        self._free = arena.hub is not None
        self.readings = np.zeros((count, sum(each.size for each in self.plants[0].outputs)))
        self.failed = np.zeros(count, dtype=np.int64)

    def reset(self, row: int, maneuver: Maneuver) -> None:
        """Begin anew, along a maneuver where the motion is prescribed."""
        self.failed[row] = 0
        self.readings[row] = self.plants[row].reset(0, None if self._free else {"maneuver": maneuver})

    def step(self, command: Array) -> None:
        """Hold commands; a plant whose steps do not converge fails and stays as it was."""
        for row, plant in enumerate(self.plants):
            if self.failed[row]:
                continue
            try:
                self.readings[row] = plant.step(command[row])
            except NotConvergedError:
                self.failed[row] = 1

    def displacement(self, row: int) -> Array:
        """Displacement of all nodes [m], shape (node, 3)."""
        plant = self.plants[row]
        return plant.state_of.system.translations(plant.state.motion.displacement)


class CompiledBodies:
    """Reduced models, all in one compiled call."""

    def __init__(self, arena: Arena, count: int) -> None:
        self._plants, self._free = arena.compiled(count), arena.hub is not None
        self.readings, self.failed = self._plants.measurement, self._plants.failures

    def reset(self, row: int, maneuver: Maneuver) -> None:
        """Begin anew, along a maneuver where the motion is prescribed."""
        self._plants.reset(0, row, maneuver=None if self._free else maneuver)

    def step(self, command: Array) -> None:
        """Hold commands; a plant whose step is not stable fails."""
        self._plants.step(command)

    def displacement(self, row: int) -> Array:
        """Displacement of all nodes [m], shape (node, 3)."""
        return self._plants.displacement(row)


def bodies_of(arena: Arena, kind: str, count: int) -> Bodies:
    """Plants of a kind side by side.

    Raises
    ------
    InputError
        If the kind is unknown.
    UnsupportedError
        If the structure cannot be reduced.
    """
    if checks.one_of("plant", kind, KINDS) == "reduced" and arena.compiles:
        return CompiledBodies(arena, count)
    return PlantBodies(arena, kind, count)
