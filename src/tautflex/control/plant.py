"""A structure on its hub that is commanded and measured once per interval [control.md 4]."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.bank import Bank, checked_actuators
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.control.actuators.monitor import monitor_of
from tautflex.control.authority import authority
from tautflex.control.late import behind_drives
from tautflex.control.linear import LinearPlant
from tautflex.control.linearize import linearize
from tautflex.control.runs.full import FullPlantRun
from tautflex.control.runs.record import joined
from tautflex.control.runs.reduced import ReducedPlantRun
from tautflex.control.runs.run_of_plant import RunOfPlant
from tautflex.control.runs.timing import doubts_about_steps, stable_step_of, steps_of
from tautflex.control.sensors.sensor import SensedMotion, Sensor, checked_sensors, kept, noise_of, recalled
from tautflex.control.signals import Channel
from tautflex.errors import InputError, NotConvergedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import TimeInput, require_equipped, require_still
from tautflex.mechanics.loads.prepared import LinearInput
from tautflex.motion.attitude import attitude
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.motion.rotations import rotation_vector
from tautflex.numeric import Array, within_arithmetic
from tautflex.reduction.on_basis import OnBasis
from tautflex.solvers.remembering import Memory
from tautflex.solvers.static.equip import equip
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.methods.generalized_alpha import GeneralizedAlpha
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.solvers.transient.status import Run, Statistics, Status
from tautflex.text import card, shown

# Intervals whose samples are reserved at a time.
_RESERVED = 1024


@dataclass(frozen=True, eq=False)
class PlantState:
    """State of a plant between two intervals: ``reset(options={"state": plant.state})``.

    Parameters
    ----------
    motion
        State of the run.
    intervals
        Intervals since the start of its clock.
    actuators, sensors
        What drives and sensors remember, by number.
    measurement
        What was measured there, shape (outputs,).
    """

    motion: Checkpoint
    intervals: int
    actuators: Memory
    sensors: Memory
    measurement: Array

    def __repr__(self) -> str:
        return card(self, {"time": f"{self.motion.time:.6g} s", "structure": f"{len(self.motion.velocity)} unknowns"})


class Plant:
    """A structure that is commanded and measured: `reset`, then `step` after `step`.

    Parameters
    ----------
    state
        Prestressed state, which is equipped for its actuators (`equip`), or a reduced model of one that is.
    hub
        Free hub; None: the motion is prescribed.
    actuators
        Name -> `HubTorque`, `Actuator`, or a bare effect.
    sensors
        Name -> sensor.
    interval
        Time between two commands [s]; between them a command acts as it is.
    time_step
        Step of the integrator [s], a whole part of the interval; None is the largest one up to 5 ms and, of an
        explicit method, up to half of the step that is stable at the start.
    method
        Integrator; None is `GeneralizedAlpha()`, or `CentralDifference()` of a reduced model.
    damping
        Any `Damping`; None is none.
    maneuver
        Prescribed motion; on a free hub what laws are to follow. None is none.
    inputs
        Inputs in time beside the actuators.
    probes
        Name -> (x, y) or (x, y, z) [m], for the record.

    Raises
    ------
    InputError
        If an argument is wrong, names clash, or the interval is no multiple of the step.
    UnsupportedError
        If an actuator, input or method has no answer in a reduced model.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> plant = tf.Plant(state, sensors={"film": tf.SurfaceRms()}, maneuver=tf.Stop(0.6, 1.0), interval=0.02)
    >>> y = plant.reset(seed=0)
    """

    def __init__(
        self,
        state: PrestressedState | OnBasis,
        hub: FreeHub | None = None,
        actuators: Mapping[str, Any] | None = None,
        sensors: Mapping[str, Sensor] | None = None,
        *,
        interval: float = 0.01,
        time_step: float | None = None,
        method: Method | None = None,
        damping: Damping | None = None,
        maneuver: Maneuver | None = None,
        inputs: Sequence[TimeInput] = (),
        probes: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        checks.instance(
            "state",
            state,
            (PrestressedState, OnBasis),
            "a prestressed state or a reduced model",
            remedy="solve_prestress(model) gives one",
        )
        reduced = isinstance(state, OnBasis)
        self.hub: FreeHub | None = checks.instance("hub", hub, (FreeHub, type(None)), "a FreeHub(...), or None")
        self.maneuver = _maneuver(maneuver)
        self._rom = state if isinstance(state, OnBasis) else None
        bare = state.state if isinstance(state, OnBasis) else state
        self.actuators = checked_actuators(actuators, hub, bare.system)
        self.interval = checks.positive("interval", interval)
        known = (Method, CentralDifference, type(None)) if reduced else (Method, type(None))
        checks.instance("method", method, known, "an implicit method such as GeneralizedAlpha()")
        given = require_still("in a plant", checks.several("inputs", inputs, TimeInput, "NodalForce(...)"))
        effects = [*given, *(each.effect for each in self.actuators.values() if isinstance(each, Actuator))]
        self.state_of = bare if reduced else equip(bare, effects)
        for each in effects if reduced else ():
            require_equipped(each, self.state_of.system)
        self._monitor = monitor_of(self.actuators, self.state_of, self.interval, full=not reduced)
        self.sensors, self._prepared = checked_sensors(sensors, self.actuators, self.state_of, hub)
        self._looks = any(p.function is not None or p.rows is None or p.rows.stress for p in self._prepared.values())
        asked = {"method": method or (CentralDifference() if reduced else GeneralizedAlpha()), "damping": damping}
        moved = self.maneuver if hub is None else hub, {**asked, "inputs": given}
        self._steps = steps_of(self.interval, time_step, lambda: stable_step_of(state, *moved))
        step, self.remarks = self.interval / self._steps, doubts_about_steps(asked["method"], interval, self._steps)
        self._asked: dict[str, Any] = {**asked, "time_step": step, "probes": probes, "every": self._steps}
        self._inputs, self._frames = given, np.zeros(0)
        self._problem([], interval)
        self._run: RunOfPlant | None = None
        self._bank = self._new_bank()
        self._views: dict[tuple[int, tuple[float, ...]], LinearPlant] = {}

    def _new_bank(self) -> Bank:
        return Bank(self.actuators, self.state_of.system, self.interval, self._monitor)

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """Names, units and sizes of the parts of a command, in order."""
        return self._bank.channels

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """Names, units and sizes of the parts of a measurement, in order."""
        return tuple(
            Channel(name, bound.unit, bound.size, self.sensors[name].noise) for name, bound in self._prepared.items()
        )

    @property
    def time(self) -> float:
        """Where the plant has come to [s]."""
        return self._at_work.place.time

    @within_arithmetic()
    def reset(self, seed: int | None = None, options: Mapping[str, Any] | None = None) -> Array:
        """Begin anew.

        Parameters
        ----------
        seed
            Of the sensors' noise; None is 0.
        options
            ``{"state": plant.state}`` goes on from there, noise included; ``{"maneuver": ...}`` follows another one;
            ``{"frames": times}`` keeps frames at instants [s]; ``{"runs": plant.cut()}`` are what the state ends.

        Returns
        -------
        numpy.ndarray
            Measurement, shape (outputs,).
        """
        given = checks.mapping("options", options)
        known = (PlantState, type(None))
        state: PlantState | None = checks.instance("options.state", given.pop("state", None), known, "plant.state")
        self.maneuver = _maneuver(given.pop("maneuver", self.maneuver))
        self._frames = checks.float_array("options.frames", given.pop("frames", ()), (None,))
        runs = list(checks.several("options.runs", given.pop("runs", ()), Run, "plant.cut()"))
        if given:
            text = f"options: expected 'state', 'maneuver', 'frames' or 'runs', got {shown(next(iter(given)))}"
            raise InputError(f"{text}; leave it out")
        chosen = 0 if seed is None else checks.whole("seed", seed, 0)
        self._bank, self._parts, self._intervals = self._new_bank(), runs, 0
        if state is None:
            self._begin(None)
            exact = self._exact()
            self._memories = {
                name: sensor.start(exact[name], self.interval, noise_of(chosen, name))
                for name, sensor in self.sensors.items()
            }
        else:
            self._bank.recall(state.actuators)
            self._intervals = state.intervals
            self._memories = recalled(self.sensors, state.sensors)
            self._begin(state.motion)
            self._last = state.measurement.copy()
            return state.measurement.copy()
        return self._observe()

    def _problem(
        self, driven: Sequence[TimeInput], end_time: float, initial: Checkpoint | None = None
    ) -> TransientProblem:
        """What the integrator is asked."""
        asked = {**self._asked, "inputs": [*self._inputs, *driven], "end_time": end_time, "initial": initial}
        start = -1.0 if initial is None else initial.time
        asked["frames"] = self._frames[(self._frames > start) & (self._frames <= end_time)]
        return TransientProblem(
            self._rom or self.state_of, self.hub if self.hub is not None else self.maneuver, **asked
        )

    def _begin(self, initial: Checkpoint | None) -> None:
        """Take up a run, from the start or a state."""
        problem = self._problem(self._bank.inputs, (self._intervals + _RESERVED) * self.interval, initial)
        run = self._run = (FullPlantRun if self._rom is None else ReducedPlantRun)(problem)
        self._bank.push(run, problem.start_time)
        run.start()

    @property
    def _at_work(self) -> RunOfPlant:
        if self._run is None:
            raise InputError("plant: expected reset before this, got none; call y = plant.reset(seed=0)")
        return self._run

    @within_arithmetic()
    def step(self, command: ArrayLike) -> Array:
        """Hold a command over one interval.

        Parameters
        ----------
        command
            Shape (inputs,), in the order and units of ``plant.inputs``; one number where there is one.

        Returns
        -------
        numpy.ndarray
            Measurement at its end, shape (outputs,).

        Raises
        ------
        InputError
            If the command has another shape or is not finite.
        NotConvergedError
            If a step fails; ``.result`` is the run until then.
        """
        size = self._bank.size
        self.cut()
        run = self._at_work
        numbers = checks.numbers("command", command)
        numbers = checks.float_array(
            "command", numbers.reshape(1) if numbers.ndim == 0 and size == 1 else numbers, (size,)
        )
        before = run.place
        self._bank.command(run, before, numbers)
        for number in range(self._intervals * self._steps + 1, (self._intervals + 1) * self._steps + 1):
            if not run.advance(number):
                raise NotConvergedError(
                    f"t = {run.place.time:.6g} s: {Status.NOT_CONVERGED.message}",
                    result=self.result(Status.NOT_CONVERGED),
                )
            reached = run.place
            self._bank.count(run, before, reached)
            before = reached
        self._intervals += 1
        return self._observe()

    def cut(self) -> list[Run]:
        """Runs that make up the record so far but for the present one, which begins here if a long one is to end."""
        if self.time > self._at_work.problem.start_time and self._intervals % _RESERVED == 0:
            self._parts.append(self._at_work.result(Status.COMPLETED))
            self._begin(self._parts[-1].final)
        return list(self._parts)

    def _exact(self) -> dict[str, Array]:
        """Exact readings of all sensors now."""
        run, prepared = self._at_work, self._prepared
        place, turn, sight = run.place, np.zeros(3), run.look(self._looks)
        if place.rigid.size:
            turn = rotation_vector(place.rigid[:4])
        elif any(each.rows is not None and each.rows.rotation is not None for each in prepared.values()):
            turn = rotation_vector(attitude(self.maneuver, [place.time])[0])
        seen = SensedMotion(sight.q, sight.v, turn, sight.rate, sight.stress)
        return {name: each.read(seen) for name, each in prepared.items()}

    def _observe(self) -> Array:
        """Measurement now."""
        exact, readings = self._exact(), [np.zeros(0)]
        for name, sensor in self.sensors.items():
            self._memories[name], reading = sensor.observe(self._memories[name], exact[name], self.interval)
            readings.append(reading)
        self._last = np.concatenate(readings)
        return self._last.copy()

    @property
    def run(self) -> Run:
        """The run since the reset: what `simulate` gives, and ``energy_by_source`` [J] among its attributes."""
        return self.result(Status.COMPLETED)

    def result(self, status: Status) -> Run:
        """The run since the reset, with a word about how it ended."""
        runs = [*self._parts, self._at_work.result(status)]
        data = joined([run.data for run in runs]).assign_attrs(energy_by_source=json.dumps(self._bank.work))
        work = [asdict(run.stats) for run in runs]
        return replace(runs[-1], data=data, stats=Statistics(**{name: sum(w[name] for w in work) for name in work[0]}))

    @property
    def energy_by_source(self) -> dict[str, float]:
        """Work of each actuator since the start [J]."""
        return self._bank.work

    @property
    def switched_off(self) -> tuple[str, ...]:
        """Actuators that their monitor has switched off since the start."""
        return tuple(item.channel.name for item in self._bank.items if item.watch.off)

    def linearize(self, modes: int = 60) -> LinearPlant:
        """Linear view of small motion about the start, see `linearize`; with lags and delays of drives and sensors."""
        motion = None if self.hub is not None else self.maneuver.start()
        steady = () if motion is None else (*motion.angular_velocity.tolist(), *motion.origin_acceleration.tolist())
        known = modes, steady
        if known not in self._views:
            asked = {"hub": self.hub, "damping": self._asked["damping"], "motion": motion, "modes": modes}
            view = linearize(self.state_of, self._bank.effects, self.sensors, **asked)
            self._views[known] = behind_drives(view, self.actuators, self.inputs, self.sensors, self.outputs)
        return self._views[known]

    def authority(self, modes: int = 10) -> xr.Dataset:
        """What each effect at its limit can do to the lowest modes, see `authority`."""
        effects = {name: effect for name, effect in self._bank.effects.items() if isinstance(effect, LinearInput)}
        limits = {name: limit for name in effects if (limit := self.actuators[name].limit) is not None}
        motion = None if self.hub is not None else self.maneuver.start()
        return authority(self.state_of, effects, limits=limits, motion=motion, modes=modes)

    @property
    def wheel_momentum(self) -> dict[str, Array]:
        """Angular momentum that wheels have taken up since the start, inertial axes [N m s], shapes (3,)."""
        wheels = [each for each in self._bank.items if isinstance(each.drive, HubTorque)]
        return {each.channel.name: each.stored.copy() for each in wheels}

    @property
    def state(self) -> PlantState:
        """State to go on from."""
        parts = self._bank.memory(), kept(self._memories), self._last.copy()
        return PlantState(self._at_work.checkpoint(), self._intervals, *parts)

    def __repr__(self) -> str:
        lines = {
            "structure": f"{self.state_of.system.size} unknowns",
            "hub": "" if self.hub is None else shown(self.hub),
            "maneuver": shown(self.maneuver),
            "commands": ", ".join(f"{each.name} [{each.unit}]" for each in self.inputs),
            "measurements": ", ".join(f"{each.name} [{each.unit}]" for each in self.outputs),
            "interval": f"{self.interval:g} s, {self._steps} step(s) of {self._asked['method'].name}",
        }
        return card(self, lines)


def _maneuver(given: Any) -> Maneuver:
    given = AtRest() if given is None else given
    wanted: Maneuver = checks.instance("maneuver", given, Maneuver, "a maneuver, or None")
    return wanted
