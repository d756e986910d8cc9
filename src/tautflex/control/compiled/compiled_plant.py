"""Reduced models on their hubs, commanded and measured in compiled code, many side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.control.actuators.bank import Bank, checked_actuators
from tautflex.control.actuators.monitor import PERIODS, monitor_of
from tautflex.control.compiled.addresses import table_of
from tautflex.control.compiled.blocks import blocks_of
from tautflex.control.compiled.drives import drives_of
from tautflex.control.compiled.parts import DRAWN, INTERVALS, Drives, LinearLoop, LoopState, Sensing
from tautflex.control.compiled.prescribed import Prescribed, require_no_motion_of
from tautflex.control.compiled.sensing import moved_by, sensing_of
from tautflex.control.late import behind_drives
from tautflex.control.law import ControlLaw, law_of
from tautflex.control.linear import LinearPlant
from tautflex.control.linearize import linearize
from tautflex.control.runs.following import references, spec_of
from tautflex.control.runs.timing import stable_step_of, steps_of
from tautflex.control.sensors.sensor import Sensor, checked_sensors, noise_of
from tautflex.control.signals import Channel
from tautflex.errors import NotConvergedError, UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.numeric import Array, Indices, Mask
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.text import card, shown

# Draws of noise that are made at a time.
_DRAWS = 512
# What is followed where there is no law, and no record.
_NONE, _NOT = np.zeros((1, 0)), np.zeros((0, 0, 0))


class CompiledPlant:
    """Plants of one reduced model side by side, by central differences: what training and tuning run on.

    The same drives, steps, sensors and noise as `Plant` has, in one compiled call for all of them. What a plant keeps
    beside is left out: there is no record, no time error, and a step that is not stable is not halved but fails.

    Parameters
    ----------
    rom
        Reduced model (`reduce`) of a state that is equipped for the actuators.
    hub
        Free hub, without functions of time and motion; None: the motion is prescribed.
    actuators, sensors, interval, time_step, damping
        As of `Plant`.
    maneuver
        Prescribed motion about x, y or z, which may jump between two steps of ``time_step``, not within one; None is
        none. Each plant may be given another one by `reset`.
    count
        Number of plants side by side, >= 1.

    Attributes
    ----------
    inputs, outputs
        Names, units and sizes of the parts of a command and of a measurement.
    measurement
        The last ones, shape (count, outputs). Steps write into it.
    gain, offset
        What acts is ``gain`` times what a drive gives, plus ``offset``: effectiveness of an actuator, and error of a
        tension; shapes (count, inputs). Set before `reset`.
    value
        What acts now, shape (count, inputs).
    failures
        Not 0 where a step was not stable since the reset, shape (count,).
    work
        Work of every number of the command since the reset [J], shape (count, inputs).

    Raises
    ------
    InputError
        If an argument is wrong, or the step is not stable.
    UnsupportedError
        If the model is hyper-reduced, the hub has feedback, a maneuver is no turn about one axis through the origin, or
        a sensor is not linear.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))
    >>> hub = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), axes="x")
    >>> plants = tf.CompiledPlant(rom, hub, {"torque": tf.HubTorque("x")}, {"rate": tf.Rate()}, count=3)
    >>> y = plants.reset(seed=1)
    >>> plants.step([[-1.0], [0.0], [1.0]]).shape  # a row per plant [N m]
    (3, 1)
    """

    def __init__(
        self,
        rom: ReducedModel,
        hub: FreeHub | None = None,
        actuators: Mapping[str, Any] | None = None,
        sensors: Mapping[str, Sensor] | None = None,
        *,
        interval: float = 0.01,
        time_step: float | None = None,
        damping: Damping | None = None,
        maneuver: Maneuver | None = None,
        count: int = 1,
    ) -> None:
        if not isinstance(rom, ReducedModel):
            raise UnsupportedError(
                f"rom: expected a reduced model whose forces are polynomials, got {shown(rom)}; reduce(state) makes "
                "one, or use Plant"
            )
        self.rom = rom
        self.hub: FreeHub | None = checks.instance("hub", hub, (FreeHub, type(None)), "a FreeHub(...), or None")
        if hub is not None and hub.feedback:
            raise UnsupportedError(
                "hub: expected constant force and torque, got functions of time and motion; command a HubTorque"
            )
        self.actuators = checked_actuators(actuators, hub, rom.state.system)
        self.interval = checks.positive("interval", interval)
        self.count = checks.whole("count", count, 1)
        monitor = monitor_of(self.actuators, rom.state, interval)
        bank = self._bank = Bank(self.actuators, rom.state.system, interval, monitor)
        self.inputs: tuple[Channel, ...] = bank.channels
        question: dict[str, Any] = {"method": CentralDifference(), "damping": damping, "inputs": bank.inputs}
        require_no_motion_of(hub, maneuver)
        moved = hub or maneuver or AtRest(), question
        self._steps = steps_of(interval, time_step, lambda: stable_step_of(rom, *moved))
        step = interval / self._steps
        question |= {"time_step": step, "end_time": interval}
        self._along = Prescribed(rom, maneuver, question) if hub is None else None
        self._run = HubRun(rom, TransientProblem.asked(rom, self._along.hub if self._along else hub, question))
        if self._along is None:
            self._run.start()
        self.sensors, prepared = checked_sensors(sensors, self.actuators, rom.state, hub)
        self.outputs: tuple[Channel, ...] = tuple(
            Channel(name, bound.unit, bound.size, self.sensors[name].noise) for name, bound in prepared.items()
        )
        sensing = sensing_of(self._run, self.sensors, prepared, interval, bank)
        drives = drives_of(self._run, bank, monitor, np.array([interval, step, self._steps, monitor.window]))
        if self._along is not None:  # forces do no work on a hub that is driven
            drives = drives._replace(pushing=0 * drives.pushing)
        self._blocks = blocks_of(self._run, drives, sensing, self._along is not None)
        self._fixed, self._kept = table_of(*self._blocks.fixed)
        self._watched, self._views = drives.watched, dict[int, LinearPlant]()
        self._make_blocks(drives, sensing)

    def _make_blocks(self, drives: Drives, sensing: Sensing) -> None:
        """Arrays of every block of plants."""
        count, none = self.count, np.zeros((0, 0))
        instants = 0 if self._along is None else _DRAWS * self._steps
        loop = self._loop = LoopState.before_reset(count, drives, sensing, _DRAWS, instants)
        self.measurement, self._command = np.zeros((count, len(sensing.bias))), np.zeros((1, *loop.value.shape))
        self.gain, self.offset, self.value = loop.gain, loop.offset, loop.value
        self.work, self.failures = loop.work, loop.failed
        self._noise: list[dict[str, np.random.Generator]] = [{} for _ in range(count)]
        tables, lanes = [], self._blocks.lanes
        for first in range(0, count, lanes):
            parts: Any = (part[first : first + lanes] for part in loop)
            table, kept = table_of(*self._blocks.block(LoopState(*parts)))
            tables.append(table)
            self._kept += kept
        self._own, self._left = np.array(tables), 0
        self._free, kept = table_of(LinearLoop(none, none, none, none, np.zeros(0), np.zeros(0), np.zeros((count, 0))))
        self._kept += kept

    def reset(
        self,
        seed: int | None = None,
        row: int | None = None,
        coordinates: ArrayLike | None = None,
        rates: ArrayLike | None = None,
        maneuver: Maneuver | None = None,
    ) -> Array:
        """Begin anew: all plants, row n with ``seed + n``, or one of them with ``seed``.

        Parameters
        ----------
        seed
            Of the sensors' noise; None is 0.
        row
            Number of the plant; None is all.
        coordinates, rates
            Where the structure begins in place of its equilibrium, shape (r,).
        maneuver
            Motion in place of the prescribed one.

        Returns
        -------
        numpy.ndarray
            Measurement, shape (outputs,) of one plant, else (count, outputs).
        """
        chosen = 0 if seed is None else seed
        require_no_motion_of(self.hub, maneuver)
        start: tuple[Array, Array | None] = self._run.work.q, None
        v = self._run.work.v if rates is None else np.asarray(rates, dtype=float)
        fresh = np.full(self.count, row is None)
        if row is not None:
            checks.between("row", checks.whole("row", row, 0), 0, self.count - 1)
            fresh[row] = True
        for n in np.flatnonzero(fresh).tolist():
            q, told = start if self._along is None else self._along.begin(n, maneuver)
            self._blocks.place(n, q if coordinates is None else np.asarray(coordinates, dtype=float), v, told)
            own = chosen + n if row is None else chosen
            self._noise[n] = {name: noise_of(own, name) for name, each in self.sensors.items() if each.noise > 0.0}
            self._draw(n, self._steps)
        lanes = self._blocks.lanes
        for number in np.unique(np.flatnonzero(fresh) // lanes).tolist():
            part = slice(number * lanes, (number + 1) * lanes)
            self._blocks.kernels.begin(self._fixed, self._own[number], fresh[part], self.measurement[part])
        self._left = int(_DRAWS - self._loop.counts[:, DRAWN].max())
        if row is None and self.count > 1:
            return self.measurement.copy()
        return self.measurement[row or 0].copy()

    def _draw(self, row: int, before: int = 0) -> None:
        """Draw noise for the next measurements of a plant, and its motion in what steps they leave before the first."""
        first = 0
        if self._along is not None:
            self._along.fill(row, self._loop.motion[row, before:])
        for channel in self.outputs:
            if channel.name in self._noise[row]:
                drawn = self._noise[row][channel.name].standard_normal((_DRAWS, channel.size))
                self._loop.draws[row, :, first : first + channel.size] = drawn
            first += channel.size
        self._loop.counts[row, DRAWN] = 0

    def step(self, command: ArrayLike) -> Array:
        """Hold commands over one interval.

        Parameters
        ----------
        command
            Shape (count, inputs); (inputs,) where there is one plant.

        Returns
        -------
        numpy.ndarray
            Measurement at its end, shape (count, outputs) or (outputs,); `measurement` itself, which the next step
            overwrites. That of a plant that `failed` stays as it was.
        """
        if self._left == 0:
            self._refill()
        self._left -= 1
        try:
            self._command[0] = command
        except (TypeError, ValueError):
            checks.float_array("command", command, self._command.shape[1:])
            raise
        self._blocks.kernels.run(self._fixed, self._own, self._free, _NONE, self._command, self.measurement, _NOT)
        return self.measurement if self.count > 1 else self.measurement[0]

    def run(
        self,
        law: ControlLaw | Callable[[float, Array], ArrayLike] | ArrayLike,
        maneuver: Maneuver | None = None,
        end_time: float = 10.0,
        seed: int | None = None,
    ) -> tuple[Array, Array]:
        """Run all plants from a reset on, under a linear law in compiled code, or any law, or a table of commands.

        Parameters
        ----------
        law
            Control law, a function (time [s], measurement) -> command, or commands, shape (interval, count, inputs) or
            (interval, inputs).
        maneuver
            What the hub is to follow, or how it is prescribed to move; None is rest, or the plant's own.
        end_time
            Duration under a law [s].
        seed
            As of `reset`.

        Returns
        -------
        measurement
            At every sample, shape (interval + 1, count, outputs).
        command
            As asked for, shape (interval, count, inputs).

        Raises
        ------
        InputError
            If an argument is wrong, or the loop has not what the law needs.
        NotConvergedError
            If the law fails; ``.result`` is what was measured and asked for until then.
        """
        law = law_of("law", law) if callable(law) else law
        given = maneuver if self.hub is None else None
        first, size = self.reset(seed, maneuver=given).reshape(self.count, -1), self._command.shape[2]
        if not isinstance(law, ControlLaw):
            table = checks.numbers("law", law)
            if table.ndim == 2 and table.shape[1] == size:
                table = np.broadcast_to(table[:, None], (len(table), self.count, size))
            command = checks.float_array("law", table, (None, self.count, size)).copy()
            return self._march(first, command, _NONE.repeat(len(command), axis=0), self._free), command
        last = np.ceil(checks.positive("end_time", end_time) / self.interval - 1e-6)
        times = np.asarray(self.interval * np.arange(last), dtype=np.float64)
        follow = references(AtRest() if maneuver is None else maneuver, times, self.hub)
        command, spec = np.zeros((len(times), self.count, size)), spec_of(self, law)
        matrices = law.matrices(spec)
        if matrices is not None:
            law.start(spec)  # refuses spillover
            a, b, c, d, *shift = (np.ascontiguousarray(part) for part in matrices)
            around, _alive = table_of(LinearLoop(a, b, c, d, shift[0], shift[1], np.zeros((self.count, len(a)))))
            numbers = np.array([each.numbers for each in follow])
            return self._march(first, command, numbers, around), command
        memories, measured = [law.start(spec) for _ in range(self.count)], [first]
        for number, reference in enumerate(follow):
            for n in range(self.count):
                try:
                    memories[n], command[number, n] = law.act(memories[n], measured[-1][n].copy(), reference)
                except Exception as error:
                    raise NotConvergedError(
                        f"t = {reference.time:.6g} s: the law failed ({type(error).__name__}: {error}); correct it",
                        result=(np.array(measured), command[:number]),
                    ) from error
            measured.append(self.step(command[number]).reshape(self.count, -1).copy())
        return np.array(measured), command

    def _march(self, first: Array, command: Array, follow: Array, around: Indices) -> Array:
        """Measurements of many intervals, as many at a time as there are draws of noise."""
        measured, begin = np.zeros((len(command) + 1, *first.shape)), 0
        measured[0] = first
        while begin < len(command):
            if self._left == 0:
                self._refill()
            part = slice(begin, begin + min(self._left, len(command) - begin))
            own = measured[1:][part]
            self._blocks.kernels.run(self._fixed, self._own, around, follow[part], command[part], self.measurement, own)
            begin, self._left = part.stop, self._left - len(own)
        return measured

    def linearize(self, modes: int = 60) -> LinearPlant:
        """Linear view of small motion of the structure that was reduced, see `Plant.linearize`."""
        if modes not in self._views:
            motion = None if self._along is None else self._along.maneuver.start()
            asked: dict[str, Any] = {"damping": self._run.problem.damping, "motion": motion, "modes": modes}
            view = linearize(self.rom.state, self._bank.effects, self.sensors, hub=self.hub, **asked)
            self._views[modes] = behind_drives(view, self.actuators, self.inputs, self.sensors, self.outputs)
        return self._views[modes]

    def _refill(self) -> None:
        for n in np.flatnonzero(self._loop.counts[:, DRAWN] >= _DRAWS):
            self._draw(int(n))
        self._left = int(_DRAWS - self._loop.counts[:, DRAWN].max())

    @property
    def constants(self) -> tuple[Any, ...]:
        """Arrays of the compiled loop; on a hub of one axis `AxisModel`, `Drives` and `Sensing`."""
        return self._blocks.fixed

    @property
    def failed(self) -> Mask:
        """Plants whose step was not stable since their reset, shape (count,)."""
        return self.failures != 0

    def displacement(self, row: int = 0) -> Array:
        """Displacement of all nodes of a plant by its coordinates [m], without answers to inputs, shape (node, 3)."""
        return self.rom.state.system.translations(self.rom.displacement(self._blocks.coordinates(row)[None])[0])

    def coordinates(self, row: int = 0) -> Array:
        """Coordinates of a plant now, shape (r,)."""
        return self._blocks.coordinates(row).copy()

    def moved_by(self) -> tuple[Array, dict[int, Array]]:
        """Displacement by coordinates, monomials, numbers of the command and motion of the frame, shape (z, size).

        And the stresses of these numbers by block, shapes (row, strain, c).
        """
        return moved_by(self._run, self._bank)

    @property
    def switched_off(self) -> Mask:
        """Numbers of the command that a monitor has switched off since the reset, shape (count, inputs)."""
        off = self._loop.watch[:, :, 3] >= PERIODS
        return np.asarray(off[:, self._watched] & (self._watched >= 0))

    @property
    def time(self) -> Array:
        """Time since their reset [s], shape (count,)."""
        return np.asarray(self.interval * self._loop.counts[:, INTERVALS], dtype=np.float64)

    def __repr__(self) -> str:
        lines = {
            "plants": str(self.count),
            "structure": shown(self.rom),
            "hub": "" if self.hub is None else shown(self.hub),
            "maneuver": "" if self._along is None else shown(self._along.maneuver),
            "commands": ", ".join(f"{each.name} [{each.unit}]" for each in self.inputs),
            "measurements": ", ".join(f"{each.name} [{each.unit}]" for each in self.outputs),
            "interval": f"{self.interval:g} s, {self._steps} step(s)",
        }
        return card(self, lines)
