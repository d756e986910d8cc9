"""What a law is told before it starts, and what it is to follow."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from tautflex.control.law import ControlLaw
from tautflex.control.linear import LinearPlant
from tautflex.control.sensors.sensor import hub_rows
from tautflex.control.signals import Channel, LoopSpec, Reference
from tautflex.errors import InputError
from tautflex.motion.attitude import attitude
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import Maneuver
from tautflex.motion.rotations import rotation_vector
from tautflex.numeric import Array

# Modes that a law which knows fewer must leave stable: they reach a few times its own band.
MODES_BEYOND = 200


class Commanded(Protocol):
    """Any plant."""

    hub: FreeHub | None
    interval: float

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """Names, units and sizes of the parts of a command, in order."""

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """Names, units and sizes of the parts of a measurement, in order."""

    def linearize(self, modes: int = 60) -> LinearPlant:
        """Linear view of small motion."""


def spec_of(plant: Commanded, law: ControlLaw) -> LoopSpec:
    """What a law is told of a plant, with the linear model if it asks for it."""
    axes = 0 if plant.hub is None else len(hub_rows(plant.hub))
    spec = LoopSpec(plant.outputs, plant.inputs, plant.interval, axes)
    try:
        law.start(spec)
    except InputError as error:
        if not str(error).startswith("model:"):
            raise
        model, beyond = plant.linearize(), plant.linearize(MODES_BEYOND)
        more = beyond.coordinates > model.coordinates
        return replace(spec, model=model, beyond=beyond if more else None)
    return spec


def references(maneuver: Maneuver, times: Array, hub: FreeHub | None) -> list[Reference]:
    """What a maneuver asks of a hub's axes at rising instants [s]; of none where there is no hub."""
    if hub is None:
        return [Reference.rest(float(time), 0) for time in times]
    rows, segments, found = hub_rows(hub), maneuver.segments(), list[Reference]()
    goal = rows @ rotation_vector(attitude(maneuver, [maneuver.end])[0]) if maneuver.end < np.inf else None
    for time, quaternion in zip(times.tolist(), attitude(maneuver, times), strict=True):
        motion = next(s for s in reversed(segments) if s.start <= time + 1e-9).motion(time)
        parts = rotation_vector(quaternion), motion.angular_velocity, motion.angular_acceleration
        turn, rate, acceleration = (rows @ part for part in parts)
        found.append(Reference(time, turn, rate, acceleration, goal))
    return found
