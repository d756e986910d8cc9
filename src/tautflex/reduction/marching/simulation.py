"""`simulate` for a reduced model: same call, same result."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import NotConvergedError, UnsupportedError
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.mechanics.membrane import current_film_states
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver, Segment, split_segments
from tautflex.reduction.marching.run import ReducedFlight
from tautflex.reduction.marching.validity import check_validity
from tautflex.reduction.polynomial.forces import energies
from tautflex.solvers.transient.adaptive import Adaptive
from tautflex.solvers.transient.methods.wilson import WilsonTheta
from tautflex.solvers.transient.probes import ProbeSet, place_probes
from tautflex.solvers.transient.problem import InitialVelocity, check_parts, field_steps, start_velocity, step_count
from tautflex.solvers.transient.recorder import Samples, run_dataset
from tautflex.solvers.transient.simulate import Method, Run
from tautflex.solvers.transient.status import Status
from tautflex.solvers.variables import REDUCED_RUN, SCALARS, described

if TYPE_CHECKING:
    from tautflex.reduction.on_basis import OnBasis

Array = NDArray[np.float64]


def simulate_reduced(
    rom: OnBasis,
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
    """Integrate the equation of motion of a reduced model; arguments and result of `tautflex.simulate`.

    Besides what a full run stores, ``run.data`` has the coordinates; resultants of the film are evaluated at the
    instants of ``check_time`` (the largest motion of each of a few windows) and are NaN between them.

    Raises
    ------
    InputError
        If an argument is out of range.
    UnsupportedError
        If a free hub, adaptive steps or changes of tension are asked for.
    NotConvergedError
        If a step fails and ``throw`` is set; ``.result`` holds the partial run.
    """
    count = step_count(time_step, end_time, every)
    if tolerance is not None:
        checks.positive("tolerance", tolerance)
    checks.whole("max_halvings", max_halvings, 0)
    method, coupling, damping = method or WilsonTheta(), coupling or Coupling(), damping or Rayleigh()
    check_parts(maneuver or AtRest(), method, coupling, damping, adaptive)
    maneuver = _prescribed(maneuver, adaptive)
    state = rom.state
    placed = place_probes(state.system, probes or {}, probe_reading)
    steps = field_steps(fields, time_step, count, every)
    stored = np.union1d(np.arange(0, count + 1, every), np.array(sorted(steps), dtype=np.int64))
    flight = ReducedFlight(rom, method, damping, coupling, inputs, tolerance, stored)
    segments = split_segments(maneuver.segments(), flight.inputs.breaks)
    began = clock.perf_counter()
    status, history = Status.COMPLETED, tuple[float, ...]()
    try:
        flight.start(maneuver, segments, start_velocity(state, initial_velocity))
        flight.check_step(time_step)
        if not flight.fly(segments, time_step, count, max_halvings, progress):
            status = Status.NOT_CONVERGED
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    statistics = flight.statistics
    statistics.seconds = clock.perf_counter() - began
    attributes = _attributes(rom, method, maneuver, damping, coupling, time_step)
    data = _dataset(rom, flight, segments, placed, time_step, every, steps, attributes)
    data = data.assign_attrs(status=status.value, status_message=status.message, statistics=statistics.to_json())
    run = Run(data, status, statistics)
    if status is Status.NOT_CONVERGED and throw:
        reached = flight.reached * time_step
        raise NotConvergedError(f"t = {reached:.6g} s: {status.message}", result=run, history=history)
    return run


def _prescribed(maneuver: Maneuver | FreeHub | None, adaptive: object) -> Maneuver:
    """Prescribed motion of a run; UnsupportedError for what reduced models do not do."""
    if adaptive is not None:
        raise UnsupportedError("adaptive: expected None for a reduced model, whose steps cost next to nothing")
    if isinstance(maneuver, FreeHub):
        raise UnsupportedError(
            "maneuver: expected a prescribed motion for a reduced model, got a free hub; simulate the full state"
        )
    return maneuver or AtRest()


def _attributes(
    rom: OnBasis, method: Any, maneuver: Maneuver, damping: Rayleigh, coupling: Coupling, step: float
) -> dict[str, Any]:
    last = maneuver.segments()[-1].start
    return {
        **({"maneuver_end": last} if last > 0.0 else {}),
        "title": "rigid-flexible response of a tensioned membrane structure, reduced model",
        "reduced_model": repr(rom),
        "method": method.name,
        "maneuver": repr(maneuver),
        "damping": repr(damping),
        "coupling": repr(coupling),
        "time_step": step,
    }


def _dataset(
    rom: OnBasis,
    flight: ReducedFlight,
    segments: tuple[Segment, ...],
    probes: ProbeSet,
    step: float,
    every: int,
    field_steps: set[int],
    attributes: dict[str, Any],
) -> xr.Dataset:
    """Everything a full run stores, from the stored coordinates."""
    rows = np.arange(0, flight.reached + 1, every)
    times = np.asarray(rows * step, dtype=np.float64)
    place = np.searchsorted(flight.stored, rows)
    eta, rate = flight.eta[place], flight.rate[place]
    motions = flight.motions(segments, times)
    scalar = np.full((len(rows), len(SCALARS)), np.nan)
    scalar[:, :2] = energies(flight.plant, eta, rate)
    checked = check_validity(flight, segments, times, eta, rate, motions, scalar[:, :2].sum(axis=1))
    scalar[checked.samples, 2:] = checked.scalars
    fields = [_field(flight, segments, row, step) for row in sorted(field_steps) if row <= flight.reached]
    spin = motions[:, :6].reshape(-1, 2, 3)
    samples = Samples(times, flight.read(probes, eta, rate, motions), spin, scalar, fields)
    data = run_dataset(rom.model, probes, samples, {**attributes, "warnings": checked.warnings})
    arrays = {"coordinate": eta, "truncated_energy": checked.truncated}
    instants = described(REDUCED_RUN, {"check_time": times[checked.samples]})
    return data.assign(described(REDUCED_RUN, arrays)).assign_coords(instants)


def _field(
    flight: ReducedFlight, segments: tuple[Segment, ...], row: int, step: float
) -> tuple[float, Array, NDArray[np.int8]]:
    """Time, displacement of all nodes and film states of a stored instant."""
    system = flight.rom.state.system
    eta = flight.eta[np.searchsorted(flight.stored, row)]
    pulled = flight.pulled(flight.motions(segments, np.array([row * step])))[0]
    q = flight.rom.displacement(eta, pulled)
    system.force(q)
    return row * step, system.translations(q), current_film_states(system)
