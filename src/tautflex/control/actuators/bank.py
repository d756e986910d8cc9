"""All actuators of a plant: their drives, what they hold, and the work each of them does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.drive import Drive, DriveMemory
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.control.actuators.monitor import Monitor, Watch
from tautflex.control.runs.run_of_plant import Place, RunOfPlant
from tautflex.control.signals import Channel
from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import Effect, TimeInput
from tautflex.mechanics.loads.prepared import LinearInput, StressChange
from tautflex.mechanics.loads.signals import Held
from tautflex.mechanics.system import StructuralSystem
from tautflex.motion import rotations
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array
from tautflex.solvers.remembering import Memory, copied
from tautflex.solvers.transient.free_hub.balance import rigid_parts
from tautflex.text import shown


@dataclass
class Driven:
    """One actuator at work.

    Parameters
    ----------
    drive
        The actuator.
    channel
        Its name, unit and size.
    bound
        Its effect on the structure; None of wheels.
    held
        Numbers that its effect has now.
    memory
        Of its drive.
    value
        What acts in this interval, shape (n,).
    stored
        Momentum of the wheels in inertial axes [N m s], shape (3,).
    work
        Done on spacecraft and structure since the reset [J].
    watch
        What its monitor has seen.
    """

    drive: Drive
    channel: Channel
    bound: LinearInput | None
    held: Held
    memory: DriveMemory
    value: Array
    stored: Array = field(default_factory=lambda: np.zeros(3))
    work: float = 0.0
    watch: Watch = field(default_factory=Watch)


def checked_actuators(given: Any, hub: FreeHub | None, system: StructuralSystem) -> dict[str, Drive]:
    """Actuators by name, bare effects with a drive that does as it is told; InputError for what does not fit."""
    example = "a mapping such as {'torque': HubTorque('x')}"
    actuators = checks.instance("actuators", {} if given is None else given, Mapping, example)
    found: dict[str, Drive] = {}
    for name, item in actuators.items():
        if not isinstance(name, str) or not name:
            raise InputError(f"actuators: expected names, got {shown(name)}; write for example {{'torque': ...}}")
        drive = Actuator(item) if isinstance(item, Effect) else item
        checks.instance(f"actuators.{name}", drive, (Actuator, HubTorque), "HubTorque(...), or an effect")
        if isinstance(drive, HubTorque) and hub is None:
            raise InputError(
                f"actuators.{name}: expected a free hub for {shown(drive)}, got none; give hub=FreeHub(...)"
            )
        if isinstance(drive, HubTorque) and hub is not None:
            free = "xyz" if hub.axes == "free" else hub.axes
            if set(drive.axis) - set(free):
                raise InputError(
                    f"actuators.{name}.axis: expected an axis that the hub turns about, {free!r}, got {drive.axis!r}; "
                    f"set axis = {free!r}, or free the hub's axes"
                )
        if isinstance(drive, Actuator) and getattr(drive.effect, drive.effect.signal) is not None:
            raise InputError(
                f"actuators.{name}: expected an effect without a signal, got {shown(drive.effect)}; leave "
                f"{drive.effect.signal} out, the plant commands it"
            )
        if isinstance(drive, Actuator):
            with checks.within(f"actuators.{name}"):
                drive.effect.prepare(drive.effect.equipped(system))
        found[name] = drive
    return found


class Bank:
    """Actuators in their order, at rest.

    Parameters
    ----------
    actuators
        Name -> actuator.
    system
        The structure, equipped for them.
    interval
        Time between two commands [s].
    monitor
        Of those that are watched.
    """

    def __init__(
        self, actuators: Mapping[str, Drive], system: StructuralSystem, interval: float, monitor: Monitor
    ) -> None:
        self._interval, self._monitor, self.items = interval, monitor, list[Driven]()
        for name, drive in actuators.items():
            bound: LinearInput | None = None
            if isinstance(drive, Actuator):
                found = drive.effect.prepare(system)
                text = "an effect that is linear in a few numbers; others are inputs"
                bound = checks.instance(f"actuators.{name}", found, LinearInput, text)
                unit, size = bound.labels[0].partition("[")[2].rstrip("]"), bound.count
            else:
                assert isinstance(drive, HubTorque)
                unit, size = drive.unit, len(drive.rows)
            with checks.within(f"actuators.{name}"):
                memory = drive.start(size, interval)
            self.items.append(
                Driven(drive, Channel(name, unit, size), bound, Held(np.zeros(size)), memory, np.zeros(size))
            )

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Names, units and sizes."""
        return tuple(item.channel for item in self.items)

    @property
    def size(self) -> int:
        """Numbers of a command."""
        return sum(item.channel.size for item in self.items)

    @property
    def inputs(self) -> list[TimeInput]:
        """Effects under what is held."""
        return [item.drive.effect.driven(item.held) for item in self.items if isinstance(item.drive, Actuator)]

    @property
    def effects(self) -> dict[str, Any]:
        """Effects per unit by name: bound to the structure, or wrenches on the hub, shape (6, n)."""
        found: dict[str, Any] = {}
        for item in self.items:
            found[item.channel.name] = item.bound
            if isinstance(item.drive, HubTorque):
                found[item.channel.name] = np.pad(item.drive.rows.T, ((3, 0), (0, 0)))
        return found

    @property
    def value(self) -> Array:
        """What acts in this interval, shape (size,)."""
        return np.concatenate([np.zeros(0), *(item.value for item in self.items)])

    def push(self, run: RunOfPlant, time: float) -> None:
        """Give the torques of wheels to a run from an instant [s] on."""
        torque = [i.value @ i.drive.rows for i in self.items if isinstance(i.drive, HubTorque)]
        if torque:
            run.push(np.concatenate([np.zeros(3), np.sum(torque, axis=0)]), time)

    def command(self, run: RunOfPlant, place: Place, numbers: Array) -> None:
        """Let a command act from the present place of a run on."""
        first, changed, time = 0, False, place.time
        energies: list[float] = []
        for item in self.items:
            own = np.zeros(item.channel.size) if item.watch.off else numbers[first : first + item.channel.size]
            first, pumped = first + item.channel.size, 0.0
            item.memory, value = item.drive.act(item.memory, own, self._interval)
            if isinstance(item.drive, HubTorque):
                value = item.drive.within(value, item.drive.rows @ self._in_hub_axes(place, item), self._interval)
            elif item.bound is not None:
                value = np.maximum(value, item.bound.lowest)
            if not np.array_equal(value, item.value):
                stressed, last, vibration = isinstance(item.bound, StressChange), item.value, self._monitor.vibration
                if stressed and not energies:
                    energies.append(run.strain_energy())
                if item.drive.monitor and vibration is not None:
                    acting = {each.channel.name: each.value for each in self.items}
                    pumped = vibration.pumped(item.channel.name, place.q, value - last, acting)
                item.value, changed = value, True
                item.held.hold(value, time)
                if stressed:
                    energies.append(run.strain_energy())
                    work = energies[-1] - energies[-2]
                    item.work += work
                    if vibration is None:
                        pumped = work - self._stored(run, item, last, value - last)
            if item.drive.monitor:
                item.watch = item.watch.seen(pumped, self._monitor.window)
        if changed:
            self.push(run, time)
            run.renew()

    def _stored(self, run: RunOfPlant, item: Driven, value: Array, change: Array) -> float:
        """Work of a change that the structure gives back, see `Monitor` [J]; 0 of what is not watched."""
        if not item.drive.monitor:
            return 0.0
        stresses = [each for each in self.items if isinstance(each.bound, StressChange)]
        behind = sum(each.channel.size for each in stresses[stresses.index(item) :])
        own = run.own[len(run.own) - behind :, len(run.own) - behind :][: len(value), : len(value)]
        return float(change @ self._monitor.own[item.channel.name] @ value + 0.5 * change @ own @ change)

    def count(self, run: RunOfPlant, before: Place, at: Place) -> None:
        """Take in one step from a place to the present one."""
        for item in self.items:
            if not item.value.any():
                continue
            if isinstance(item.drive, HubTorque):
                torque, mean = item.value @ item.drive.rows, np.zeros(3)
                for hub in (rigid_parts(before.rigid), rigid_parts(at.rigid)):
                    mean += 0.5 * rotations.matrix(hub.attitude) @ torque
                    item.work += 0.5 * (at.time - before.time) * float(torque @ hub.twist[3:])
                item.stored -= (at.time - before.time) * mean
            elif item.bound is not None and not isinstance(item.bound, StressChange):
                item.work += run.work_of(item.bound, item.value, before, at)
                for end in (before, at) if at.rigid.size else ():
                    wrench = run.push_of(item.bound, item.value, end)
                    item.work += 0.5 * (at.time - before.time) * float(wrench @ rigid_parts(end.rigid).twist)

    def _in_hub_axes(self, place: Place, item: Driven) -> Array:
        stored: Array = rotations.matrix(rigid_parts(place.rigid).attitude).T @ item.stored
        return stored

    @property
    def work(self) -> dict[str, float]:
        """Work of each since the reset [J]."""
        return {item.channel.name: item.work for item in self.items}

    def memory(self) -> Memory:
        """What the next interval depends on, by number of the actuator."""
        parts = "memory", "value", "stored", "work", "watch"
        return {str(n): {name: copied(getattr(i, name)) for name in parts} for n, i in enumerate(self.items)}

    def recall(self, memory: Memory) -> None:
        """Go on where another bank stood."""
        for number, item in enumerate(self.items):
            then = copied(memory[str(number)])
            item.memory, item.watch = DriveMemory(**then["memory"]), Watch(**then["watch"])
            item.value, item.stored, item.work = then["value"], then["stored"], then["work"]
            item.held = Held(item.value)
