"""What a sensor is: rows of an output matrix or a function, then noise, bias, delay and resolution."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np
from scipy.sparse import csr_array

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array
from tautflex.solvers.remembering import Memory
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import brief


class SensedMotion(NamedTuple):
    """What a sensor may look at.

    Parameters
    ----------
    q, v
        Free unknowns and their velocities, shape (size,).
    rotation, rate
        Rotation vector of the floating frame from the inertial frame [rad], and angular velocity in its own axes
        [rad/s], shape (3,).
    stress
        Stress of each block at q, shapes (row, strain).
    """

    q: Array
    v: Array
    rotation: Array
    rate: Array
    stress: list[Array]


@dataclass(frozen=True, eq=False)
class SensorRows:
    """Linear reading: the sum of all its parts; those left out are none.

    Parameters
    ----------
    displacement, velocity
        On the free unknowns and their velocities, shape (n, size).
    rotation, rate
        On rotation vector and angular velocity of the hub, shape (n, 3).
    stress
        Number of a block -> weights of its stresses, shape (n, row, strain).
    """

    displacement: csr_array | Array | None = None
    velocity: csr_array | Array | None = None
    rotation: Array | None = None
    rate: Array | None = None
    stress: Mapping[int, Array] = field(default_factory=dict)
    __repr__ = brief


@dataclass(frozen=True, eq=False)
class PreparedSensor:
    """Sensor bound to a structure and its hub: exact readings.

    Parameters
    ----------
    unit
        Unit of the numbers.
    size
        How many they are.
    rows
        Linear reading, of stresses too; of a `function` its derivative at the reference, or None where it has none.
    function
        Reading that is not linear; None: the rows are all.
    """

    unit: str
    size: int
    rows: SensorRows | None
    function: Callable[[SensedMotion], Array] | None = None
    __repr__ = brief

    def read(self, motion: SensedMotion) -> Array:
        """Exact reading, shape (size,)."""
        if self.function is not None:
            return self.function(motion)
        assert self.rows is not None, "a sensor has rows or a function"
        rows, result = self.rows, np.zeros(self.size)
        parts = (rows.displacement, motion.q), (rows.velocity, motion.v), (rows.rotation, motion.rotation)
        for matrix, vector in (*parts, (rows.rate, motion.rate)):
            if matrix is not None:
                result += matrix @ vector
        for index, weights in rows.stress.items():
            result += np.einsum("nrs,rs->n", weights, motion.stress[index])
        return result


class SensorMemory(NamedTuple):
    """What a sensor knows between two readings: exact ones, newest first, shape (k, n), and its source of noise."""

    past: Array
    noise: np.random.Generator


def kept(memories: Mapping[str, SensorMemory]) -> Memory:
    """Copy of what sensors know, by number, as arrays and texts."""
    found: Memory = {}
    for number, memory in enumerate(memories.values()):
        found[str(number)] = {"past": memory.past.copy(), "noise": json.dumps(memory.noise.bit_generator.state)}
    return found


def recalled(names: Iterable[str], memory: Memory) -> dict[str, SensorMemory]:
    """What sensors of these names know, from what `kept` gave."""
    found = dict[str, SensorMemory]()
    for number, name in enumerate(names):
        noise = np.random.default_rng()
        noise.bit_generator.state = json.loads(memory[str(number)]["noise"])
        found[name] = SensorMemory(memory[str(number)]["past"].copy(), noise)
    return found


@dataclass(frozen=True, kw_only=True)
class Sensor(ABC):
    """What a law may know: a frozen dataclass that binds itself to a structure and its hub.

    Parameters
    ----------
    noise
        Standard deviation of what is added at random to every reading, in the sensor's unit, >= 0.
    bias
        What is always added, in the sensor's unit.
    delay
        Age of what is read [s], >= 0; between two samples it is a straight line.
    resolution
        Step of the numbers that are read, in the sensor's unit, >= 0; 0 is none.
    """

    noise: float = 0.0
    bias: float = 0.0
    delay: float = 0.0
    resolution: float = 0.0

    privileged: ClassVar[bool] = False
    """Whether no instrument could read it: for training and judging, not for flight."""

    def __post_init__(self) -> None:
        for name in ("noise", "delay", "resolution"):
            checks.non_negative(name, getattr(self, name))
        checks.finite("bias", self.bias)

    @abstractmethod
    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Bind to a structure and its hub; raises InputError where it does not fit."""

    def start(self, exact: Array, interval: float, noise: np.random.Generator) -> SensorMemory:
        """Memory before the first reading, as if the first exact one had stood for ever; see `noise_of`."""
        kept = int(np.ceil(self.delay / interval - 1e-9)) + 1
        return SensorMemory(np.tile(exact, (kept, 1)), noise)

    def observe(self, memory: SensorMemory, exact: Array, interval: float) -> tuple[SensorMemory, Array]:
        """Reading one interval [s] later: late, off, noisy and rounded; the source of noise moves on."""
        past = np.concatenate([exact[None], memory.past[:-1]]) if len(memory.past) else exact[None]
        age = self.delay / interval
        last = len(past) - 1
        share = max(0.0, age - max(last - 1, 0)) if last else 0.0
        reading = past[last] * share + past[max(last - 1, 0)] * (1.0 - share) + self.bias
        # Drawn without noise too, so that a first bit of it does not change what others draw.
        reading = reading + self.noise * memory.noise.standard_normal(len(exact))
        if self.resolution > 0.0:
            reading = self.resolution * np.round(reading / self.resolution)
        return SensorMemory(past, memory.noise), reading


def checked_sensors(
    given: Any, actuators: Collection[str], state: PrestressedState, hub: FreeHub | None
) -> tuple[dict[str, Sensor], dict[str, PreparedSensor]]:
    """Sensors by name, and bound to a structure; InputError for what does not fit, or has an actuator's name."""
    example = "a mapping such as {'rate': Rate()}"
    sensors = dict(checks.instance("sensors", {} if given is None else given, Mapping, example))

    def bound(name: str, sensor: Any) -> PreparedSensor:
        checks.instance(f"sensors.{name}", sensor, Sensor, "a sensor such as Rate()")
        if name in actuators:
            raise InputError(f"sensors.{name}: expected a name of its own, got that of an actuator; choose another one")
        with checks.within(f"sensors.{name}"):
            return cast("PreparedSensor", sensor.prepare(state, hub))

    prepared = checks.together(*(partial(bound, name, sensor) for name, sensor in sensors.items()))
    return sensors, dict(zip(sensors, prepared, strict=True))


def noise_of(seed: int, name: str) -> np.random.Generator:
    """Source of noise of the sensor of this name: another sensor does not change it."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=tuple(name.encode())))


def hub_rows(hub: FreeHub | None) -> Array:
    """Rows of the hub's axes on vectors in its own axes, shape (axes, 3): three, or the one it may turn about."""
    axes = "free" if hub is None else hub.axes
    return np.eye(3) if axes in ("free", "xyz") else np.eye(3)[["xyz".index(axes)]]
