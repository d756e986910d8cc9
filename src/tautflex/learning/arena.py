"""A case and its task as plants: with the loop's actuators and sensors, disturbances, and readings for the judge."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.case.build import build_actuators, build_damping, build_state
from tautflex.case.loop import build_sensors
from tautflex.case.schema import Case
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.bank import checked_actuators
from tautflex.control.actuators.drive import Drive
from tautflex.control.compiled.compiled_plant import CompiledPlant
from tautflex.control.compiled.prescribed import is_course
from tautflex.control.linear import LinearPlant
from tautflex.control.plant import Plant
from tautflex.control.runs.following import MODES_BEYOND
from tautflex.control.runs.timing import steps_of
from tautflex.control.sensors.attitude import Attitude
from tautflex.control.sensors.sensor import Sensor, checked_sensors, hub_rows
from tautflex.control.sensors.surface_rms import SurfaceRms
from tautflex.control.signals import Channel, LoopSpec
from tautflex.control.tasks.observation import Observation
from tautflex.control.tasks.task import Task
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.tension_group import ReeledCables, TensionGroup
from tautflex.numeric import Array
from tautflex.reduction.polynomial.model import ReducedModel, reduce
from tautflex.solvers.static.equip import equip

# What only the judge reads, behind the sensors of the loop.
TRUTH = ("true attitude", "true surface")


class Arena:
    """Structure, hub, actuators, sensors and task of a case, from which plants are made.

    Parameters
    ----------
    case
        Case with [actuators], [sensors] and a [task].
    task
        In place of that of the case.
    actuators, sensors
        By name, in place of those of the case.
    coordinates
        Of the reduced model, in place of those of the task.

    Raises
    ------
    InputError
        If the case has no task, an actuator that is commanded has no limit, or a part does not fit the structure.
    """

    def __init__(
        self,
        case: Case,
        task: Task | None = None,
        actuators: Mapping[str, Any] | None = None,
        sensors: Mapping[str, Sensor] | None = None,
        coordinates: int | None = None,
    ) -> None:
        self.case = checks.instance("case", case, Case, "a case", remedy="load_case('slew.toml') gives one")
        given = task or (case.task.build() if case.task is not None else None)
        if given is None:
            text = "task: missing, expected a [task] section with kind = 'slew' or another task"
            raise InputError(
                f"{text}; add it, or write a case that has one: tautflex init slew.toml --template task-slew"
            )
        chosen: Task = checks.instance("task", given, Task, "SlewTask()")
        self.task = chosen if coordinates is None else replace(chosen, coordinates=coordinates)
        self.state = build_state(case)
        self.hub = None if case.hub is None else case.hub.build()
        every = (
            build_actuators(case, self.state)
            if actuators is None
            else checked_actuators(actuators, self.hub, self.state.system)
        )
        self.actuators: dict[str, Drive] = {name: every[name] for name in self._commanded(every)}
        self.state = equip(self.state, [each.effect for each in self.actuators.values() if isinstance(each, Actuator)])
        chosen_sensors = build_sensors(case, self.state, self.hub) if sensors is None else sensors
        self.sensors, _ = checked_sensors(chosen_sensors, self.actuators, self.state, self.hub)
        self.damping = build_damping(case, self.state)
        self.interval = case.loop.interval
        self.steps = round(self.task.duration / self.interval)

    def _commanded(self, every: Mapping[str, Drive]) -> tuple[str, ...]:
        names = self.task.commands or tuple(every)
        for name in names:
            if name not in every:
                known = ", ".join(map(repr, every)) or "none"
                text = f"task.commands: expected names of actuators, {known}, got {name!r}"
                raise InputError(f"{text}; correct it, or add [actuators.{name}]")
            if every[name].limit is None:
                text = f"actuators.{name}.limit: missing, expected one, which counts as an action of 1"
                raise InputError(f"{text}; add it")
        if not names:
            raise InputError("actuators: expected at least one that is commanded, got none; add [actuators.NAME]")
        return names

    @cached_property
    def disturbances(self) -> dict[str, Actuator]:
        """What disturbs, by name: first that of the task, then errors of tension."""
        found = dict(self._effects)
        for name, drive in self.actuators.items():
            if isinstance(drive, Actuator) and isinstance(drive.effect, TensionGroup):
                found[f"{name} error"] = Actuator(drive.effect)
        return found

    @cached_property
    def _effects(self) -> dict[str, Actuator]:
        return {name: Actuator(effect) for name, effect in self.task.effects(self.state.model).items()}

    @cached_property
    def tension_units(self) -> Array:
        """What a command of each error of tension is where it equals the largest pretension, shape (errors,)."""
        found = list[float]()
        for drive in self.disturbances.values():
            if isinstance(drive.effect, TensionGroup):
                bound = drive.effect.prepare(self.state.system)
                assert isinstance(bound, ReeledCables)
                tension = self.state.cable_tension[bound.cables]
                per_unit = bound.share * (bound.stiffness if bound.command == "length" else 1.0)
                found.append(float(tension.max() / per_unit[tension.argmax()]))
        return np.array(found)

    @cached_property
    def spec(self) -> LoopSpec:
        """The loop as laws see it, without a model."""
        plant, names = self.plant("full"), {*TRUTH, *self.disturbances}
        measured = (
            replace(channel, noise=self.sensors[channel.name].noise)
            for channel in plant.outputs
            if channel.name not in names
        )
        commanded = (channel for channel in plant.inputs if channel.name not in names)
        axes = 0 if self.hub is None else len(hub_rows(self.hub))
        return LoopSpec(tuple(measured), tuple(commanded), self.interval, axes)

    @cached_property
    def observation(self) -> Observation:
        """What a policy sees of the loop."""
        return Observation.of(self.spec, self.task.duration)

    @cached_property
    def limits(self) -> Array:
        """Command that an action of 1 is, shape (commands,)."""
        return np.concatenate([_spread(self.actuators[channel.name], channel) for channel in self.spec.commands])

    @cached_property
    def on_structure(self) -> Array:
        """1 where a command acts on the structure, 0 where on the hub, shape (commands,)."""
        return np.concatenate(
            [
                np.full(channel.size, float(isinstance(self.actuators[channel.name], Actuator)))
                for channel in self.spec.commands
            ]
        )

    @cached_property
    def reduced(self) -> ReducedModel:
        """Reduced model for training."""
        return reduce(self.state, self.task.basis)

    @cached_property
    def model(self) -> LinearPlant:
        """Linear view of the loop, without disturbances."""
        return self._linear()

    @cached_property
    def beyond(self) -> LinearPlant:
        """The same with more modes than laws know, among which spillover is looked for."""
        return self._linear(MODES_BEYOND)

    def _linear(self, *modes: int) -> LinearPlant:
        spec = self.spec
        return self.plant("full", exact=False).linearize(*modes).selected(spec.commanded, spec.measured)

    def plant(self, kind: str, time_step: float | None = None, exact: bool = True) -> Plant:
        """Plant on the full structure or on the reduced model.

        With exact sensors it has all disturbances and what the judge reads; else the loop as laws see it, which the
        task alone disturbs.
        """
        actuators, sensors = self._parts() if exact else ({**self.actuators, **self._effects}, self.sensors)
        step = self.case.solver.time_step if time_step is None else time_step
        asked: dict[str, Any] = {"interval": self.interval, "time_step": step, "damping": self.damping}
        if self.hub is None:
            asked["maneuver"] = self.task.maneuver(self.task.nominal())
        state: Any = self.state if kind == "full" else self.reduced
        return Plant(state, self.hub, actuators, sensors, **asked)

    @cached_property
    def compiles(self) -> bool:
        """Whether reduced plants are one array program: on a hub, or in turns about one axis that jump at steps."""
        task = self.task
        if self.hub is not None:
            return True
        step = self.interval / steps_of(self.interval, self.case.solver.time_step)
        return all(is_course(task.maneuver(each), step) for each in (task.nominal(), *task.grid()))

    def compiled(self, count: int, exact: bool = True) -> CompiledPlant:
        """Reduced models side by side, with exact sensors and all disturbances, or as laws see them.

        What the judge reads comes behind the sensors.
        """
        actuators, sensors = self._parts()
        if not exact:
            actuators = {**self.actuators, **self._effects}
            sensors = sensors | self.sensors
        return CompiledPlant(
            self.reduced,
            self.hub,
            actuators,
            sensors,
            interval=self.interval,
            time_step=self.case.solver.time_step,
            damping=self.damping,
            maneuver=self.task.maneuver(self.task.nominal()) if self.hub is None else None,
            count=count,
        )

    def _parts(self) -> tuple[dict[str, Drive], dict[str, Sensor]]:
        truth: dict[str, Sensor] = {} if self.hub is None else {TRUTH[0]: Attitude()}
        exact: dict[str, Sensor] = {
            name: replace(sensor, noise=0.0, resolution=0.0) for name, sensor in self.sensors.items()
        }
        return {**self.actuators, **self.disturbances}, exact | truth | {TRUTH[1]: SurfaceRms()}

    def draw(self, random: np.random.Generator, options: Mapping[str, Any] | None = None) -> dict[str, float]:
        """Parameters of an episode, those in ``options`` as they are; InputError if one is unknown or out of range."""
        limits, given = self.task.limits(), checks.mapping("options", options)
        found = {name: float(random.uniform(*limits[name])) for name in self.task.drawn}
        for name, value in given.items():
            if name not in found:
                raise InputError(
                    f"options: expected parameters among {', '.join(found)}, got {name!r}; choose one of them"
                )
            low, high = limits[name]
            # Tests reach beyond what is trained, nothing beyond what could be meant.
            reach = high - low if high > low else max(abs(high), 1.0)
            found[name] = checks.between(f"options.{name}", value, low - reach, high + reach)
        return found


def _spread(drive: Drive, channel: Channel) -> Array:
    assert drive.limit is not None
    return checks.spread("limit", drive.limit, channel.size)
