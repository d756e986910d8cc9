"""Transient response: the driver that walks an implicit method along a maneuver [paper (49), theory.md 4, 8]."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError, UnsupportedError
from tautflex.mechanics.damping import Rayleigh
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment
from tautflex.motion.maneuvers import AtRest
from tautflex.solvers.integrator import ImplicitMethod
from tautflex.solvers.prestress import PrestressedState
from tautflex.solvers.probes import place_probes
from tautflex.solvers.record import Recorder
from tautflex.solvers.static import spinning_equilibrium
from tautflex.solvers.status import Statistics, Status
from tautflex.solvers.stepper import MotionState, Stepper
from tautflex.solvers.wilson import WilsonTheta

Array = NDArray[np.float64]
# Beyond this the time axis alone would fill the memory.
_MOST_STEPS = 1e9
InitialVelocity = Callable[[Array, Array], ArrayLike] | ArrayLike | None


@dataclass(frozen=True)
class Run:
    """Result of `simulate`.

    Parameters
    ----------
    data
        Time histories at the probes, energies, stored fields and the mesh.
    status
        How the run ended.
    stats
        What it cost.
    """

    data: xr.Dataset
    status: Status
    stats: Statistics


def simulate(
    state: PrestressedState,
    maneuver: Maneuver | None = None,
    *,
    method: ImplicitMethod | None = None,
    time_step: float,
    end_time: float,
    damping: Rayleigh | None = None,
    coupling: Coupling | None = None,
    probes: Mapping[str, ArrayLike] | None = None,
    probe_reading: str = "interpolate",
    initial_velocity: InitialVelocity = None,
    every: int = 1,
    fields: str | Sequence[float] | None = None,
    tolerance: float = 1e-6,
    max_halvings: int = 8,
    progress: Callable[[float, str], None] | None = None,
    throw: bool = True,
) -> Run:
    """Integrate the rigid-flexible equation of motion (49) of the paper.

    Parameters
    ----------
    state
        Prestressed state; the run starts from its steady spinning equilibrium at the maneuver's start.
    maneuver
        Prescribed rigid motion; None is none.
    method
        Implicit integrator; default `WilsonTheta()`.
    time_step, end_time
        Step and duration [s]; discontinuities of the maneuver are stepped onto.
    damping
        Rayleigh damping; None is none.
    coupling
        Switches of the rotating-frame terms; default all on.
    probes
        Name -> (x, y) or (x, y, z) [m].
    probe_reading
        ``"interpolate"`` or ``"nearest-node"``.
    initial_velocity
        Function (x, y) -> transverse velocity [m/s], or array (node, 3) [m/s]; None is rest.
    every
        Store every n-th step.
    fields
        None or ``"none"``: no fields; ``"all"``: one per stored step; or times [s], rounded to steps.
    tolerance
        Newton tolerance: residual norm over the norm of the forces.
    max_halvings
        Times a step may be halved when Newton fails.
    progress
        Called with (fraction done, message) about a hundred times.
    throw
        Raise when the run fails; False returns the labelled partial run.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        If an argument is out of range.
    UnsupportedError
        If the structure could drift away as a rigid body under a maneuver.
    NotConvergedError
        If a step fails and ``throw`` is set; ``.result`` holds the partial run.
    """
    count = _step_count(time_step, end_time, every)
    checks.positive("tolerance", tolerance)
    checks.whole("max_halvings", max_halvings, 0)
    maneuver = maneuver or AtRest()
    if state.model.rigid_freedom and not isinstance(maneuver, AtRest):
        raise UnsupportedError(
            f"supports: expected a structure held against rigid motion, {state.model.rigid_freedom} rigid motion(s) "
            "are free; hold the frame (frame.support = 'corners') or study its modes instead"
        )
    method, coupling, damping = method or WilsonTheta(), coupling or Coupling(), damping or Rayleigh()
    _check_parts(maneuver, method, coupling, damping)
    stepper = Stepper(state, method, damping, coupling, tolerance)
    placed = place_probes(state.system, probes or {}, probe_reading)
    recorder = Recorder(state.system, placed, count // every + 1, _field_steps(fields, time_step, count, every))
    driver = _Driver(stepper, maneuver.segments(), time_step, max_halvings)
    began = clock.perf_counter()
    status, history = Status.COMPLETED, tuple[float, ...]()
    try:
        at = _start(state, maneuver, stepper, coupling, initial_velocity)
        driver.record(recorder, 0, at, True)
        for step in range(1, count + 1):
            advanced = driver.advance(at, step * time_step)
            if advanced is None:
                status, history = Status.NOT_CONVERGED, tuple(driver.failure)
                break
            at = advanced
            driver.record(recorder, step, at, step % every == 0)
            if progress is not None and step % max(1, count // 100) == 0:
                progress(step / count, f"t = {at.time:.3g} s")
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    stepper.collect_counts()
    stepper.statistics.seconds = clock.perf_counter() - began
    attributes = _attributes(method, maneuver, stepper, status, time_step)
    run = Run(recorder.to_dataset(attributes), status, stepper.statistics)
    if status is Status.NOT_CONVERGED and throw:
        raise NotConvergedError(f"t = {at.time:.6g} s: {status.message}", result=run, history=history)
    return run


class _Driver:
    """Walks along the time grid, onto discontinuities, and halves steps that fail."""

    def __init__(self, stepper: Stepper, segments: tuple[Segment, ...], step: float, halvings: int) -> None:
        self._stepper, self._segments, self._step, self._halvings = stepper, segments, step, halvings
        self._current = 0
        self.failure: list[float] = []

    @property
    def segment(self) -> Segment:
        return self._segments[self._current]

    def advance(self, at: MotionState, target: float) -> MotionState | None:
        """Advance to a time of the grid; None if even the smallest step fails."""
        slack = 1e-9 * self._step
        while at.time < target - slack:
            end = min(target, self.segment.end)
            # Whole grid steps keep their nominal size, so that factors are re-used in spite of round-off.
            size = self._step if abs(end - at.time - self._step) < slack else end - at.time
            reached = self._halving_step(at, size, self._halvings)
            if reached is None:
                return None
            reached.time = end
            at = reached
            if self.segment.end <= end + slack and self._current + 1 < len(self._segments):
                before = self.segment.motion(at.time)
                self._current += 1
                at = self._stepper.jump(at, before, self.segment.motion(at.time))
        return at

    def _halving_step(self, at: MotionState, size: float, left: int) -> MotionState | None:
        try:
            reached, outcome = self._stepper.step(at, size, self.segment)
            converged, self.failure = outcome.converged, outcome.history
        except np.linalg.LinAlgError:
            converged = False
        if converged:
            self._stepper.statistics.steps += 1
            return reached
        if left == 0:
            return None
        self._stepper.statistics.halvings += 1
        middle = self._halving_step(at, 0.5 * size, left - 1)
        return None if middle is None else self._halving_step(middle, 0.5 * size, left - 1)

    def record(self, recorder: Recorder, step: int, at: MotionState, sample: bool) -> None:
        """Store the sample and the field of a grid step."""
        recorder.store_field(step, at.time, at.q)
        if not sample:
            return
        state = self._stepper.state
        _, energy = state.system.force(at.q)
        mass = state.system.inertia.mass_matrix
        kinetic = 0.5 * float(at.v @ (mass @ at.v))
        motion: RigidMotion = self.segment.motion(at.time)
        strain = energy - float(state.reference_force @ at.q)
        recorder.store(at.time, at.q, at.v, motion, (kinetic, strain))


def _step_count(time_step: float, end_time: float, every: int) -> int:
    """Steps of the grid that reaches ``end_time``."""
    step = checks.positive("time_step", time_step)
    if not checks.finite("end_time", end_time) >= step:
        raise InputError(f"end_time: expected at least one time_step ({step:g} s), got {end_time!r}")
    checks.whole("every", every, 1, remedy="1 stores every step")
    count = end_time / step
    if count > _MOST_STEPS:
        raise InputError(
            f"end_time: expected at most {_MOST_STEPS:g} steps, got {count:.3g}; run shorter or enlarge time_step"
        )
    return max(1, int(np.ceil(count - 1e-6)))


def _check_parts(maneuver: object, method: object, coupling: object, damping: object) -> None:
    """Raise InputError where an argument is not what its name says."""
    for name, value, needed, example in (
        ("maneuver", maneuver, "segments", "Stop(rate=0.628, duration=1.0)"),
        ("method", method, "scheme", "WilsonTheta()"),
        ("coupling", coupling, "velocity_weight", "Coupling()"),
        ("damping", damping, "entries", "Rayleigh(0.001, 0.001)"),
    ):
        if not hasattr(value, needed):
            raise InputError(f"{name}: expected an object such as {example}, got {value!r}")


def _start(
    state: PrestressedState,
    maneuver: Maneuver,
    stepper: Stepper,
    coupling: Coupling,
    initial_velocity: InitialVelocity,
) -> MotionState:
    """Steady spinning equilibrium, given velocity, and the acceleration that follows."""
    q = spinning_equilibrium(state, maneuver.start(), coupling)
    v = _initial_velocity(state, initial_velocity)
    return stepper.start(0.0, q, v, maneuver.segments()[0].motion(0.0))


def _initial_velocity(state: PrestressedState, given: InitialVelocity) -> Array:
    """Velocities of the free unknowns; rotations of beam nodes start at rest."""
    model = state.model
    if given is None:
        return np.zeros(state.system.size)
    if callable(given):
        x, y = model.nodes[:, 0], model.nodes[:, 1]
        values = np.zeros((len(model.nodes), 3))
        try:
            values[:, 2] = np.broadcast_to(np.asarray(given(x, y), dtype=float), x.shape)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"initial_velocity: expected a function (x, y) -> velocity of shape {x.shape}, got {error}"
            ) from None
    else:
        values = np.asarray(given)
    values = checks.float_array("initial_velocity", values, (len(model.nodes), 3))
    full = np.zeros(model.dof_count)
    full[model.translation_dofs] = values
    return full[model.free_dofs]


def _field_steps(fields: str | Sequence[float] | None, step: float, count: int, every: int) -> set[int]:
    if fields is None or isinstance(fields, str):
        checks.one_of("fields", fields or "none", ("none", "all"))
        return set(range(0, count + 1, every)) if fields == "all" else set()
    steps = set()
    for time in checks.float_array("fields", fields, (None,)):
        if not 0.0 <= time <= (count + 0.5) * step:
            raise InputError(f"fields: expected times in [0, {count * step:g}] s, got {time:g}")
        steps.add(round(time / step))
    return steps


def _attributes(
    method: ImplicitMethod, maneuver: Maneuver, stepper: Stepper, status: Status, step: float
) -> dict[str, Any]:
    last = maneuver.segments()[-1].start
    ended = {"maneuver_end": last} if last > 0.0 else {}
    return {
        **ended,
        "title": "rigid-flexible response of a tensioned membrane structure",
        "method": method.name,
        "maneuver": repr(maneuver),
        "damping": repr(stepper.damping),
        "coupling": repr(stepper.coupling),
        "time_step": step,
        "status": status.value,
        "status_message": status.message,
        "statistics": stepper.statistics.to_json(),
    }
