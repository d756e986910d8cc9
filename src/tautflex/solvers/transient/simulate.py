"""Transient response: a method walks along a maneuver and leaves a record [paper (49), theory.md 4, 8]."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError, UnsupportedError
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver, Segment, split_segments
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.adaptive import Adaptive, AdaptiveDriver
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.equation import EquationOfMotion, MotionState
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.free_hub.history import HubFlight, check_coupling
from tautflex.solvers.transient.free_hub.stepper import HubStepper
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.methods.scheme import ExplicitMethod, ImplicitMethod
from tautflex.solvers.transient.methods.wilson import WilsonTheta
from tautflex.solvers.transient.probes import ProbeSet, place_probes
from tautflex.solvers.transient.problem import InitialVelocity, check_parts, field_steps, start_velocity, step_count
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.status import Statistics, Status

Array = NDArray[np.float64]
Method = ImplicitMethod | ExplicitMethod


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


class ReducedPlant(Protocol):
    """A model that brings its own time stepping."""

    def simulate(self, maneuver: Maneuver | FreeHub | None, **options: Any) -> Run:
        """Integrate; arguments and result of `simulate`."""
        ...


def simulate(
    state: PrestressedState | ReducedPlant,
    maneuver: Maneuver | FreeHub | None = None,
    *,
    method: Method | None = None,
    time_step: float,
    end_time: float,
    adaptive: Adaptive | None = None,
    damping: Rayleigh | None = None,
    coupling: Coupling | None = None,
    inputs: Sequence[TimeInput] = (),
    probes: Mapping[str, ArrayLike] | None = None,
    probe_reading: str = "interpolate",
    initial_velocity: InitialVelocity = None,
    every: int = 1,
    fields: str | Sequence[float] | None = None,
    tolerance: float | None = None,
    max_halvings: int = 8,
    progress: Callable[[float, str], None] | None = None,
    throw: bool = True,
) -> Run:
    """Integrate the rigid-flexible equation of motion (49) of the paper.

    Parameters
    ----------
    state
        Prestressed state, or a reduced model of one (`reduce`); the run starts from its steady spinning equilibrium at
        the maneuver's start.
    maneuver
        Prescribed rigid motion, or a `FreeHub` whose motion is part of the answer; None is none.
    method
        Integrator; default `WilsonTheta()`.
    time_step, end_time
        Step and duration [s]; discontinuities of the maneuver are stepped onto.
    adaptive
        Error control of an implicit method's steps; ``time_step`` is then the spacing of the results and the first
        trial step. None takes every step ``time_step`` long.
    damping
        Rayleigh damping; None is none.
    coupling
        Switches of the rotating-frame terms; default all on.
    inputs
        Forces, cable tensions and film temperatures in time, see :mod:`tautflex.mechanics.loads.inputs`.
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
        Newton tolerance: residual norm over the norm of the forces; None takes what the method needs, 1e-6 for most.
    max_halvings
        Times a step may be halved when Newton fails; an adaptive run goes down to its smallest step instead.
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
        If an argument is out of range, or the step of an explicit method is not stable.
    UnsupportedError
        If the structure could drift away as a rigid body under a maneuver.
    NotConvergedError
        If a step fails and ``throw`` is set; ``.result`` holds the partial run.
    """
    if hasattr(state, "simulate"):
        # A reduced model brings its own stepping.
        return state.simulate(
            maneuver,
            method=method,
            time_step=time_step,
            end_time=end_time,
            adaptive=adaptive,
            damping=damping,
            coupling=coupling,
            inputs=inputs,
            probes=probes,
            probe_reading=probe_reading,
            initial_velocity=initial_velocity,
            every=every,
            fields=fields,
            tolerance=tolerance,
            max_halvings=max_halvings,
            progress=progress,
            throw=throw,
        )
    count = step_count(time_step, end_time, every)
    if tolerance is not None:
        checks.positive("tolerance", tolerance)
    checks.whole("max_halvings", max_halvings, 0)
    maneuver = maneuver or AtRest()
    if state.model.rigid_freedom and not isinstance(maneuver, AtRest):
        raise UnsupportedError(
            f"supports: expected a structure held against rigid motion, {state.model.rigid_freedom} rigid motion(s) "
            "are free; hold the frame (frame.support = 'corners') or study its modes instead"
        )
    method, coupling, damping = method or WilsonTheta(), coupling or Coupling(), damping or Rayleigh()
    check_parts(maneuver, method, coupling, damping, adaptive)
    driven = InputSet(state.system, inputs)
    placed = place_probes(state.system, probes or {}, probe_reading)
    recorder = Recorder(state.system, placed, count // every + 1, field_steps(fields, time_step, count, every))
    flight: _Flight | HubFlight
    stepper: Stepper | ExplicitStepper | HubStepper
    if isinstance(maneuver, FreeHub):
        check_coupling(coupling)
        stepper = _hub_stepper(state, maneuver, method, damping, coupling, tolerance, driven, placed)
        flight = HubFlight(state, maneuver, stepper)
        segments = split_segments(flight.segments(), (*driven.breaks, *maneuver.breaks))
    else:
        stepper = prescribed = _stepper(state, method, damping, coupling, tolerance, driven)
        flight = _Flight(state, maneuver, prescribed, coupling)
        segments = split_segments(maneuver.segments(), driven.breaks)
    driver = _driver(stepper, segments, time_step, max_halvings, count * time_step, adaptive)
    began = clock.perf_counter()
    status, history = Status.COMPLETED, tuple[float, ...]()
    try:
        at = flight.start(start_velocity(state, initial_velocity))
        if isinstance(stepper, ExplicitStepper):
            stepper.check(at, time_step)
        flight.record(recorder, driver, at, 0, every)
        for step in range(1, count + 1):
            advanced = driver.advance(at, step * time_step)
            if advanced is None:
                status, history = Status.NOT_CONVERGED, tuple(driver.failure)
                break
            at = advanced
            flight.record(recorder, driver, at, step, every)
            if progress is not None and step % max(1, count // 100) == 0:
                progress(step / count, f"t = {at.time:.3g} s")
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    finally:
        driven.release()
    stepper.collect_counts()
    statistics = stepper.equation.statistics
    statistics.seconds = clock.perf_counter() - began
    attributes = _attributes(method, maneuver, stepper.equation, status, time_step, adaptive)
    run = Run(flight.complete(recorder.to_dataset(attributes)), status, statistics)
    if status is Status.NOT_CONVERGED and throw:
        raise NotConvergedError(f"t = {at.time:.6g} s: {status.message}", result=run, history=history)
    return run


def _stepper(
    state: PrestressedState,
    method: Method,
    damping: Rayleigh,
    coupling: Coupling,
    tolerance: float | None,
    inputs: InputSet,
) -> Stepper | ExplicitStepper:
    """Stepper of a run; an explicit method brings its own."""
    if hasattr(method, "stepper"):
        return method.stepper(state, damping, coupling, inputs)
    return Stepper(state, method, damping, coupling, tolerance or method.scheme(1.0).tolerance, inputs=inputs)


def _hub_stepper(
    state: PrestressedState,
    hub: FreeHub,
    method: Method,
    damping: Rayleigh,
    coupling: Coupling,
    tolerance: float | None,
    inputs: InputSet,
    probes: ProbeSet,
) -> HubStepper:
    """Stepper of a run on a free hub."""
    if hasattr(method, "stepper"):
        raise InputError("method: expected an implicit method on a free hub, got an explicit one; use Newmark()")
    equation = EquationOfMotion(state, damping, coupling, inputs=inputs)
    return HubStepper(equation, hub, method, tolerance or min(1e-9, method.scheme(1.0).tolerance), probes)


def _driver(
    stepper: Stepper | ExplicitStepper | HubStepper,
    segments: tuple[Segment, ...],
    time_step: float,
    max_halvings: int,
    end_time: float,
    adaptive: Adaptive | None,
) -> GridDriver:
    """Driver of a run."""
    if adaptive is None:
        return GridDriver(stepper, segments, time_step, max_halvings)
    if not isinstance(stepper, Stepper):
        raise InputError(
            "adaptive: expected an implicit method, got an explicit one, whose step is limited by stability; "
            "leave adaptive out or use GeneralizedAlpha()"
        )
    return AdaptiveDriver(stepper, segments, time_step, end_time, adaptive)


class _Flight:
    """A run under prescribed rigid motion: its start and its record."""

    def __init__(
        self, state: PrestressedState, maneuver: Maneuver, stepper: Stepper | ExplicitStepper, coupling: Coupling
    ) -> None:
        self._state, self._maneuver, self._stepper, self._coupling = state, maneuver, stepper, coupling

    def start(self, velocity: Array) -> MotionState:
        """Steady spinning equilibrium, given velocity, and the acceleration that follows."""
        q = spinning_equilibrium(self._state, self._maneuver.start(), self._coupling)
        return self._stepper.start(0.0, q, velocity, self._maneuver.segments()[0].motion(0.0))

    def record(self, recorder: Recorder, driver: GridDriver, at: MotionState, step: int, every: int) -> None:
        """Store the sample and the field of a grid step."""
        recorder.store_field(step, at.time, at.q)
        if step % every:
            return
        state = self._state
        self._stepper.equation.set_time(at.time)
        energy = state.system.strain_energy(at.q)
        kinetic = 0.5 * self._stepper.equation.products.mass_norm(at.v)
        motion = driver.segment_at(at.time).motion(at.time)
        strain = energy - float(state.reference_force @ at.q)
        recorder.store(at.time, at.q, at.v, motion, (kinetic, strain))

    def complete(self, data: xr.Dataset) -> xr.Dataset:
        """Nothing to add."""
        return data


def _attributes(
    method: Method,
    maneuver: Maneuver | FreeHub,
    equation: EquationOfMotion,
    status: Status,
    step: float,
    adaptive: Adaptive | None,
) -> dict[str, Any]:
    last = 0.0 if isinstance(maneuver, FreeHub) else maneuver.segments()[-1].start
    ended = {"maneuver_end": last} if last > 0.0 else {}
    return {
        **ended,
        **({"adaptive": repr(adaptive)} if adaptive is not None else {}),
        "title": "rigid-flexible response of a tensioned membrane structure",
        "method": method.name,
        "maneuver": repr(maneuver),
        "damping": repr(equation.damping),
        "coupling": repr(equation.coupling),
        "time_step": step,
        "status": status.value,
        "status_message": status.message,
        "statistics": equation.statistics.to_json(),
    }
