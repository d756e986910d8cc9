"""What a run stores, and the Dataset it becomes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.mechanics.membrane import MEMBRANE_STATES, MembraneSurvey, StressSurvey
from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array
from tautflex.solvers.plausibility import MotionWatch
from tautflex.solvers.transient.accuracy.compression import CompressionWatch
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.probes import ProbeSet
from tautflex.solvers.transient.state import MotionState
from tautflex.solvers.variables import COMPONENTS, RUN, SCALARS, described, mesh_variables
from tautflex.structure.model import Model


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
        Name in `SCALARS` -> values, shape (sample,).
    fields
        Time [s], displacement of all nodes (node, 3) [m] and state of the film's elements, of every stored field.
    """

    time: Array
    probe: Array
    spin: Array
    scalars: dict[str, Array]
    fields: list[tuple[float, Array, NDArray[np.int8]]]


def stress_scalars(survey: StressSurvey, film: MembraneSurvey) -> dict[str, float]:
    """Scalars of a sample that stresses tell, by their names."""
    return {
        "min_principal_resultant": film.smallest,
        "max_principal_resultant": film.largest,
        "wrinkled_fraction": film.wrinkled,
        "slack_fraction": film.slack,
        "slack_cables": survey.slack_cables(),
    }


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
    field_steps
        Steps whose whole displacement field is stored.
    """

    def __init__(self, equation: EquationOfMotion, probes: ProbeSet, samples: int, field_steps: set[int]) -> None:
        self._equation, self._probes, self._field_steps = equation, probes, field_steps
        self._survey = StressSurvey(equation.system, equation.workspace)
        self._time = np.zeros(samples)
        self._probe = np.zeros((samples, 2, len(probes.names), 3))
        self._spin = np.zeros((samples, 2, 3))
        self._scalars = {name: np.zeros(samples) for name in SCALARS}
        self._fields: list[tuple[float, Array, NDArray[np.int8]]] = []
        self._watch = CompressionWatch(equation.system)
        self._motion = MotionWatch(equation.system, equation.inputs)
        self._count = 0

    def store(self, at: MotionState, segment: Segment) -> None:
        """Store one sample, of an instant in this stretch of the maneuver."""
        equation, row = self._equation, self._count
        equation.set_time(at.time)
        strain = equation.strain_energy(at.q)
        motion, film = equation.motion(at, segment), self._survey.membrane()
        self._time[row] = at.time
        self._probe[row] = self._probes.read(at.q), self._probes.read(at.v)
        self._spin[row] = motion.angular_velocity, motion.angular_acceleration
        energies = {"kinetic_energy": equation.kinetic_energy(at), "strain_energy": strain}
        for name, value in (stress_scalars(self._survey, film) | energies).items():
            self._scalars[name][row] = value
        self._watch.see(at.time, film, self._survey.cables)
        self._motion.see(at.time, at.q, strain)
        self._count += 1

    def store_field(self, step: int, at: MotionState) -> None:
        """Store the whole field if this step was asked for."""
        if step in self._field_steps:
            self._equation.workspace.strain_energy(at.q)  # the stresses on which the states depend
            self._fields.append((at.time, self._equation.system.translations(at.q), self._survey.membrane_states()))

    def to_dataset(self, attributes: dict[str, Any]) -> xr.Dataset:
        """Dataset of everything stored so far; ``attrs["warnings"]`` lists what the user should know."""
        n = self._count
        scalars = {name: values[:n] for name, values in self._scalars.items()}
        samples = Samples(self._time[:n], self._probe[:n], self._spin[:n], scalars, self._fields)
        attributes = {
            **attributes,
            "warnings": [*attributes.get("warnings", ()), *self._watch.warnings(), *self._motion.warnings()],
        }
        return run_dataset(self._equation.system.model, self._probes, samples, attributes)


def run_dataset(model: Model, probes: ProbeSet, samples: Samples, attributes: dict[str, Any]) -> xr.Dataset:
    """Dataset of the samples of a run, with the mesh."""
    arrays: dict[str, Any] = {}
    for kind, suffix in enumerate(("", "_velocity")):
        arrays |= {name + suffix: samples.probe[:, kind, :, axis] for axis, name in enumerate("uvw")}
    arrays["angular_velocity"], arrays["angular_acceleration"] = samples.spin[:, 0], samples.spin[:, 1]
    arrays |= samples.scalars
    arrays["displacement"] = np.array([field for _, field, _ in samples.fields]).reshape(-1, len(model.nodes), 3)
    states = np.array([state[model.triangle_owner] for _, _, state in samples.fields], dtype=np.int8)
    arrays["film_state"] = states.reshape(len(samples.fields), len(model.triangles))
    arrays["probe_position"] = probes.positions
    data = described(RUN, arrays)
    data["film_state"][-1].update(
        flag_values=np.arange(len(MEMBRANE_STATES), dtype=np.int8), flag_meanings=" ".join(MEMBRANE_STATES)
    )
    times = {"time": samples.time, "field_time": np.array([time for time, *_ in samples.fields])}
    return xr.Dataset(
        {**data, **mesh_variables(model)},
        coords={**described(RUN, times), "probe": list(probes.names), "component": COMPONENTS},
        attrs=attributes,
    )
