"""Constants of the functional twin: a reduced plant that turns about one axis, in natural coordinates, and its loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex.control.actuators.bank import Bank
from tautflex.control.actuators.monitor import monitor_of
from tautflex.control.compiled.drives import drives_of
from tautflex.control.compiled.parts import WHEEL
from tautflex.control.compiled.sensing import sensing_of
from tautflex.control.runs.timing import steps_of
from tautflex.control.tasks.hold import HoldTask
from tautflex.control.tasks.slew import SlewTask
from tautflex.control.tasks.stop import StopTask
from tautflex.errors import UnsupportedError
from tautflex.learning.arena import Arena
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import unit_axis
from tautflex.numeric import Array, Indices, cross_matrix
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.problem import TransientProblem

# Terms below this part of the largest one they stand beside are round-off.
_ROUND_OFF = 1e-10


@dataclass(frozen=True, eq=False)
class TwinConstants:
    """Of r natural coordinates, m monomials, c numbers of a command (disturbances last), and o readings.

    Parameters
    ----------
    squares, damping
        Squared frequencies, and damping of the coordinates, shape (r,).
    cubic
        Stress on the monomials per monomial, shape (m, m).
    viscous
        Fields V: ``V'V`` is stress per rate of a monomial, shape (k, m).
    quadratic
        Second-degree force, shape (r, m); None: a flat structure has none.
    reach, reach_follow, spin, spin_follow, pull, pull_follow, square, square_follow
        As of `HubArrays` about the axis; None: round-off. ``reach`` and ``pull`` are always there.
    inertia
        Of hub and structure at rest about the axis [kg m^2].
    load, stress, torque, arms
        Per number of a command: force on the coordinates (c, r), stress on the monomials (c, m), torque on the hub
        (c,), and what forces gain in arm (c, r).
    limit, rate, lag, resolution, lowest, delay
        Of the drives, shape (c,).
    look, look_follow, look_value, look_acceleration, look_square
        Readings of coordinates (o, r), monomials (o, m), values (o, c), and acceleration and squared rate (o,).
    speed, speed_follow, rotation, spinning, level
        Of rates of coordinates and monomials, angle and rate of the hub; at rest (o,).
    bias, reading_resolution, noise
        Of the sensors, shape (o,).
    form
        The film's mean square of the coordinates, shape (r, r).
    step, count
        Of central differences [s], and steps of an interval.
    driven
        Whether the motion of the hub is prescribed.
    """

    squares: Array
    damping: Array
    cubic: Array
    viscous: Array
    quadratic: Array | None
    reach: Array
    reach_follow: Array | None
    spin: Array | None
    spin_follow: Array | None
    pull: Array
    pull_follow: Array
    square: Array
    square_follow: Array | None
    inertia: float
    load: Array
    stress: Array
    torque: Array
    arms: Array
    limit: Array
    rate: Array
    lag: Array
    resolution: Array
    lowest: Array
    delay: Indices
    look: Array
    look_follow: Array | None
    look_value: Array
    look_acceleration: Array
    look_square: Array
    speed: Array
    speed_follow: Array | None
    rotation: Array
    spinning: Array
    level: Array
    bias: Array
    reading_resolution: Array
    noise: Array
    form: Array
    step: float
    count: int
    driven: bool

    @classmethod
    def of(cls, arena: Arena) -> TwinConstants:
        """Constants of an arena's reduced plant.

        Raises
        ------
        UnsupportedError
            If the task is neither slew nor hold, the hub does not turn about one axis, a sensor is late or not
            linear, wheels have a momentum, or the damping couples natural coordinates.
        """
        _require(arena)
        rom, hub = arena.reduced, _hub_of(arena)
        actuators = {**arena.actuators, **arena.disturbances}
        monitor = monitor_of(actuators, rom.state, arena.interval)
        bank = Bank(actuators, rom.state.system, arena.interval, monitor)
        count = steps_of(arena.interval, arena.case.solver.time_step)
        step = arena.interval / count
        question = {"time_step": step, "end_time": arena.interval, "method": CentralDifference()}
        run = HubRun(
            rom, TransientProblem.asked(rom, hub, question | {"damping": arena.damping, "inputs": bank.inputs})
        )
        sensors = arena.sensors
        prepared = {name: each.prepare(rom.state, hub) for name, each in sensors.items()}
        sensing = sensing_of(run, sensors, prepared, arena.interval, bank)
        drives = drives_of(run, bank, monitor, np.array([arena.interval, step, count, monitor.window]))
        arrays, a = run.arrays, run.hub
        axis, r, m, c = int(a.turns[0]), rom.size, rom.monomial_count, bank.size
        row = 3 + axis
        if len(sensing.reading) or len(sensing.rms) or (sensing.kept > 1).any():
            raise UnsupportedError(
                "sensors: expected linear ones without delay in a functional twin, got a CableTensionSensor, "
                "SurfaceRms or one that is late; leave it out, or train on the environments"
            )
        if np.isfinite(drives.momentum[drives.kind == WHEEL]).any():
            raise UnsupportedError(
                "actuators: expected wheels without a limit of momentum in a functional twin, got one; leave it out"
            )
        for name, matrix in (
            ("mass", arrays.mass - np.eye(r)),
            ("stiffness", arrays.linear),
            ("damping", arrays.damping),
        ):
            beside = matrix - (0.0 if name == "mass" else np.diag(matrix.diagonal()))
            if np.abs(beside).max() > 1e-8 * max(1.0, float(np.abs(matrix).max())):
                raise UnsupportedError(
                    f"{name}: expected natural coordinates that it does not couple in a functional twin, got others; "
                    "use Rayleigh damping and a ModalBasis"
                )
        squares = arrays.linear.diagonal().copy()
        amplitude = rom.basis.amplitude
        pairs = amplitude[arrays.first] * amplitude[arrays.second]
        frame = np.zeros((2, 12))
        cross = cross_matrix(np.eye(3)[axis])
        frame[0, :9], frame[1, :9] = cross.ravel(), (cross @ cross).ravel()
        moving = r + m + c
        columns = sensing.look[:, moving:] @ frame.T
        coupling = np.abs(a.reach[row]).max()

        def kept(part: Array, size: float) -> Array | None:
            """None for what is round-off beside a size."""
            return None if np.abs(part).max(initial=0.0) <= _ROUND_OFF * size else part

        look = np.abs(sensing.look[:, :r] * amplitude).max(initial=0.0)
        seen = kept(sensing.look[:, r : r + m] * pairs, look)
        moved = np.abs(sensing.speed[:, :r] * amplitude).max(initial=0.0)
        spin = kept(a.spin[0] * amplitude, coupling)
        if arena.hub is None and (spin is not None or kept(a.pull[0], coupling) is not None):
            raise UnsupportedError(
                "structure: expected coordinates that a steady spin neither bends nor couples in a functional twin, "
                "got others; train on the environments"
            )
        return cls(
            squares=squares,
            damping=arrays.damping.diagonal().copy(),
            cubic=arrays.fields.T @ arrays.fields,
            viscous=arrays.viscous,
            quadratic=arrays.quadratic if len(arrays.quadratic) else None,
            reach=a.reach[row],
            reach_follow=None if kept(a.reach_follow[row] * pairs, coupling) is None else a.reach_follow[row],
            spin=None if spin is None else a.spin[0],
            spin_follow=a.spin_follow[0] if a.spun[0] else None,
            pull=a.pull[0],
            pull_follow=a.pull_follow[0],
            square=a.square[0],
            square_follow=a.square_follow[0] if a.squared[0] else None,
            inertia=float(a.tensor[axis, axis]),
            load=drives.load,
            stress=drives.stress,
            torque=drives.wrench[:, row],
            arms=drives.arms[:, axis - 3],
            limit=drives.limit,
            rate=drives.rate,
            lag=drives.lag,
            resolution=drives.resolution,
            lowest=drives.lowest,
            delay=drives.delay,
            look=sensing.look[:, :r],
            look_follow=None if seen is None else sensing.look[:, r : r + m],
            look_value=sensing.look[:, r + m : moving],
            look_acceleration=columns[:, 0],
            look_square=columns[:, 1],
            speed=sensing.speed[:, :r],
            speed_follow=None if kept(sensing.speed[:, r:] * pairs, moved) is None else sensing.speed[:, r:],
            rotation=sensing.rotation[:, axis],
            spinning=sensing.rate[:, axis],
            level=sensing.level,
            bias=sensing.bias,
            reading_resolution=sensing.resolution,
            noise=sensing.noise,
            form=rom.film.form,
            step=step,
            count=count,
            driven=arena.hub is None,
        )


def _hub_of(arena: Arena) -> FreeHub:
    """Hub of an arena; where the motion is prescribed, any that turns about its axis: its tables are those of both."""
    if arena.hub is not None:
        return arena.hub
    axis = getattr(arena.task, "axis", (0.0, 0.0, 0.0))
    names = [name for name, unit in zip("xyz", np.eye(3), strict=True) if np.array_equal(unit_axis(axis), unit)]
    if not names:
        raise UnsupportedError(
            f"task.axis: expected that of x, y or z in a functional twin, got {axis}; train on the environments"
        )
    return FreeHub(1.0, (1.0, 1.0, 1.0), axes=names[0])


def _require(arena: Arena) -> None:
    """Raise UnsupportedError for a task or hub without a functional form."""
    task, hub = arena.task, arena.hub
    if type(task) not in (SlewTask, StopTask, HoldTask):
        raise UnsupportedError(
            f"task: expected a slew, a stop or a hold in a functional twin, got {type(task).__name__}; train on the "
            "environments"
        )
    if isinstance(task, StopTask) != (hub is None) or (hub is not None and hub.axes not in ("x", "y", "z")):
        raise UnsupportedError(
            "hub: expected one that turns about one axis in a functional twin (axes = 'x', 'y' or 'z'), and none for a "
            "stop, got another; train on the environments"
        )
    intervals = task.stop_duration / arena.interval if isinstance(task, StopTask) else 1.0
    if abs(intervals - round(intervals)) > 1e-9 * intervals:
        raise UnsupportedError(
            f"task.stop_duration: expected a whole number of intervals of {arena.interval:g} s in a functional twin, "
            f"got {intervals:.6g}; set for example stop_duration = {max(1, round(intervals)) * arena.interval:g}"
        )
    watched = next((name for name, drive in arena.actuators.items() if drive.monitor), None)
    if watched is not None:
        raise UnsupportedError(
            f"actuators.{watched}.monitor: expected false in a functional twin, got true; train without it"
        )
    if arena.reduced.film.count != arena.reduced.size:
        raise UnsupportedError(
            "structure: expected a flat film in a functional twin, got one whose surface moves with what follows the "
            "coordinates; train on the environments"
        )
    if hub is None:
        return
    moved = hub.torque is not None or hub.force is not None or any(hub.angular_velocity)
    if moved or not np.array_equal(hub.attitude, (1.0, 0.0, 0.0, 0.0)):
        raise UnsupportedError(
            "hub: expected one at rest, not turned, without torque or force in a functional twin, got another; "
            "command a HubTorque"
        )
    if isinstance(task, SlewTask) and not np.allclose(unit_axis(task.axis), hub.freedom[3:]):
        raise UnsupportedError(
            f"task.axis: expected the hub's, {hub.axes}, in a functional twin, got {task.axis}; turn about it"
        )
