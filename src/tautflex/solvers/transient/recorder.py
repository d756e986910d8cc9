"""What a run stores, and the Dataset it becomes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.mechanics.kernel import add_forces
from tautflex.mechanics.membrane import MEMBRANE_STATES, SURVEYED, StressSurvey, survey_stresses
from tautflex.mechanics.products import inner, quadratic_form
from tautflex.mechanics.surface import measure_surface
from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, jit
from tautflex.solvers.plausibility import MotionWatch
from tautflex.solvers.remembering import Memory
from tautflex.solvers.transient.accuracy.compression import CompressionWatch
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.probes import ProbeSet
from tautflex.solvers.transient.restart.keeper import Storage, in_memory, let_go
from tautflex.solvers.transient.state import MotionState
from tautflex.solvers.variables import COMPONENTS, OF_SURFACE, RUN, SCALARS, described, mesh_variables
from tautflex.structure.model import Model

# Samples that are looked at together.
_PART = 2**14


class Samples(NamedTuple):
    """Stored instants of a run.

    Parameters
    ----------
    time
        [s], shape (sample,).
    probe
        Displacement and velocity of the probes [m, m/s], shape (sample, 2, probe, 3).
    spin
        Angular velocity and acceleration of the frame, shape (sample, 2, 3).
    scalars
        Name in `SCALARS` or `OF_SURFACE` -> values, shape (sample,).
    fields
        Times [s], displacement of all nodes (field, node, 3) [m] and states of the film's elements, of stored fields.
    frame_time, frames
        Time [s] and displacement of all nodes in single precision [m] of frames, shapes (frame,), (frame, node, 3).
    """

    time: Array
    probe: Array
    spin: Array
    scalars: dict[str, Array]
    fields: tuple[Array, Array, NDArray[np.int8]]
    frame_time: Array
    frames: NDArray[np.float32]


@jit
def record(parts: Any, q: Array, v: Array, time: float, row: int, kinetic: float, strain: float) -> None:
    """Store a sample in a row of the arrays of a `Recorder`, whose ``parts`` these are.

    ``kinetic`` is the energy of the motion [J], NaN: not known; ``strain`` the strain energy above zero unknowns [J],
    whose stresses then are those at hand, and NaN likewise.
    """
    elements, (reference, start, column, mass), probes, surface, (largest, places), stored = parts
    (store, stresses, table, held, rate), (first, unknown, weights) = elements, probes
    times, numbers, probe, surfaces = stored
    size, square, extended, found = q.size, inner(q, q), np.empty(q.size + held.size + 1), numbers[row]
    extended[:size] = q
    extended[size : size + held.size] = held
    extended[size + held.size] = 0.0
    times[row] = time
    found[0] = 0.5 * quadratic_form(start, column, mass, v) if np.isnan(kinetic) else kinetic
    if np.isnan(strain):
        strain = add_forces(store, extended, extended, stresses, False, True, False)
    found[1] = strain - inner(reference, q)
    survey_stresses(table, stresses, found[2:])
    for k in range(first.size - 1):
        place, speed = 0.0, 0.0
        for entry in range(first[k], first[k + 1]):
            at = unknown[entry]
            place += weights[entry] * extended[at]
            speed += weights[entry] * (v[at] if at < size else rate[at - size])
        probe[row, 0, k], probe[row, 1, k] = place, speed
    measure_surface(surface, extended, surfaces[row])
    for k, value in ((0, found[1]), (1, square)):
        if value > largest[k, 0]:
            largest[k, 0], largest[k, 1] = value, time
            places[k] = q


class Recorder:
    """Collects samples of a run.

    Parameters
    ----------
    equation
        Equation of motion.
    probes
        Measuring points.
    samples
        Number of stored instants at most.
    field_steps, frame_steps
        Steps whose whole displacement field is stored, and those that are kept as frames.
    storage
        Where its arrays are.

    Attributes
    ----------
    count
        Samples stored so far.
    parts
        What `record` reads and writes.
    """

    def __init__(
        self, equation: EquationOfMotion, probes: ProbeSet, samples: int, field_steps: set[int], frame_steps: set[int],
        storage: Storage = in_memory,
    ) -> None:  # fmt: skip
        self._equation, self._probes, self._field_steps, self._frame_steps = equation, probes, field_steps, frame_steps
        self._survey = StressSurvey(equation.system, equation.workspace)
        self._time, self._spin = storage("time", (samples,), "f8"), storage("spin", (samples, 2, 3), "f8")
        self._probe = storage("probe", (samples, 2, 3 * len(probes.names)), "f8")
        # The `SCALARS` and what else `survey_stresses` finds.
        self._numbers = storage("numbers", (samples, 2 + SURVEYED), "f8")
        self._surface = storage("surface", (samples, len(OF_SURFACE)), "f8")
        fields, model = len(field_steps), equation.system.model
        self._field_time = storage("field_time", (fields,), "f8")
        self._field = storage("field", (fields, len(model.nodes), 3), "f8")
        self._field_states = storage("field_states", (fields, int(model.triangle_owner.max(initial=-1)) + 1), "i1")
        self._watch = MotionWatch(equation.system, equation.inputs)
        self._frame_time = storage("frame_time", (len(frame_steps),), "f8")
        self._frames = storage("frames", (len(frame_steps), len(model.nodes), 3), "f4")
        self.count = self._field_count = self._frame_count = 0
        workspace, products, moved = equation.workspace, equation.products, equation.moved
        rate, whole = (workspace.held, equation.system) if moved is None else (moved.rate, moved.system)
        self._translations = (equation.system if moved is None else moved).translations
        self.parts: Any = (
            (workspace.store, workspace.stresses, self._survey.table, workspace.held, rate),
            (equation.state.reference_force, products.start, products.column, products.mass),
            probes.rows,
            whole.surface.parts,
            (self._watch.largest, self._watch.places),
            (self._time, self._numbers, self._probe, self._surface),
        )

    def store(self, at: MotionState, segment: Segment) -> None:
        """Store one sample, of an instant in this stretch of the maneuver."""
        self._equation.set_time(at.time)
        record(self.parts, at.q, at.v, at.time, self.count, np.nan, np.nan)
        if self._equation.moved is not None:
            self._numbers[self.count, 0] = self._equation.moved.kinetic_energy(at.v)
        self.stored(self._equation.motion(at, segment).row[None])

    def stored(self, motions: Array) -> None:
        """Count samples that `record` has stored, with the motion of the frame at each, rows of `Segment.rows`."""
        self._spin[self.count : self.count + len(motions)] = motions[:, :6].reshape(-1, 2, 3)
        self.count += len(motions)

    def store_field(self, step: int, time: float, q: Array) -> None:
        """Store the whole field, and a frame, if this step was asked for."""
        if step in self._frame_steps or step in self._field_steps:
            self._equation.set_time(time)
        if step in self._frame_steps:
            row = self._frame_count
            self._frame_time[row], self._frames[row] = time, self._translations(q)
            self._frame_count += 1
        if step in self._field_steps:
            self._equation.workspace.strain_energy(q)  # the stresses on which the states depend
            row = self._field_count
            self._field_time[row], self._field[row] = time, self._translations(q)
            self._field_states[row] = self._survey.membrane_states()
            self._field_count += 1

    def memory(self) -> Memory:
        """How far the arrays are filled, and what else is watched."""
        watch = self._watch
        counts = {"count": self.count, "field_count": self._field_count, "frame_count": self._frame_count}
        return counts | {"largest": watch.largest.copy(), "places": watch.places.copy()}

    def recall(self, memory: Memory) -> None:
        """Go on behind what another recorder stored."""
        counts = (int(memory[name]) for name in ("count", "field_count", "frame_count"))
        self.count, self._field_count, self._frame_count = counts
        self._watch.largest[:], self._watch.places[:] = memory["largest"], memory["places"]

    def to_dataset(self, attributes: dict[str, Any]) -> xr.Dataset:
        """Dataset of everything stored so far; ``attrs["warnings"]`` lists what the user should know."""
        n = self.count
        compression = CompressionWatch(self._equation.system)
        for part in (slice(first, min(first + _PART, n)) for first in range(0, n, _PART)):
            compression.look_through(self._time[part], self._numbers[part, 2:])
            let_go(self._time, self._numbers)
        scalars = dict(zip(SCALARS, self._numbers[:n].T, strict=False))
        scalars |= zip(OF_SURFACE, self._surface[:n].T, strict=True)
        probe = self._probe[:n].reshape(n, 2, -1, 3)
        stored, frames = self._field_count, self._frame_count
        fields = self._field_time[:stored], self._field[:stored], self._field_states[:stored]
        kept = fields, self._frame_time[:frames], self._frames[:frames]
        samples = Samples(self._time[:n], probe, self._spin[:n], scalars, *kept)
        attributes = {
            **attributes,
            "warnings": [*attributes.get("warnings", ()), *compression.warnings(), *self._watch.warnings()],
        }
        return run_dataset(self._equation.system.model, self._probes, samples, attributes)


def run_dataset(model: Model, probes: ProbeSet, samples: Samples, attributes: dict[str, Any]) -> xr.Dataset:
    """Dataset of the samples of a run, with the mesh."""
    arrays: dict[str, Any] = {}
    for kind, suffix in enumerate(("", "_velocity")):
        arrays |= {name + suffix: samples.probe[:, kind, :, axis] for axis, name in enumerate("uvw")}
    arrays["angular_velocity"], arrays["angular_acceleration"] = samples.spin[:, 0], samples.spin[:, 1]
    arrays |= samples.scalars
    field_time, arrays["displacement"], states = samples.fields
    arrays["film_state"] = states[:, model.triangle_owner]
    arrays["probe_position"], arrays["frame_displacement"] = probes.positions, samples.frames
    data = described(RUN, arrays)
    data["film_state"][-1].update(
        flag_values=np.arange(len(MEMBRANE_STATES), dtype=np.int8), flag_meanings=" ".join(MEMBRANE_STATES)
    )
    times = {"time": samples.time, "field_time": field_time}
    times["frame_time"] = samples.frame_time
    return xr.Dataset(
        {**data, **mesh_variables(model)},
        coords={**described(RUN, times), "probe": list(probes.names), "component": COMPONENTS},
        attrs=attributes,
    )
