"""What a run stores, and the Dataset it becomes."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.elements.laws import FILM_STATES
from tautflex.mechanics.membrane import current_film_states, survey_film
from tautflex.mechanics.system import StructuralSystem
from tautflex.motion.kinematics import RigidMotion
from tautflex.solvers.transient.compression import CompressionWatch
from tautflex.solvers.transient.probes import ProbeSet
from tautflex.solvers.variables import COMPONENTS, RUN, SCALARS, described, mesh_variables
from tautflex.structure.model import Model

Array = NDArray[np.float64]


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
    scalar
        Columns of `SCALARS`, shape (sample, column).
    fields
        Time [s], displacement of all nodes (node, 3) [m] and state of the film's elements, of every stored field.
    """

    time: Array
    probe: Array
    spin: Array
    scalar: Array
    fields: list[tuple[float, Array, NDArray[np.int8]]]


class Recorder:
    """Collects samples of a run.

    Parameters
    ----------
    system
        The structure.
    probes
        Measuring points.
    samples
        Number of stored instants at most.
    field_steps
        Steps whose whole displacement field is stored.
    """

    def __init__(self, system: StructuralSystem, probes: ProbeSet, samples: int, field_steps: set[int]) -> None:
        self._system, self._probes, self._field_steps = system, probes, field_steps
        self._time = np.zeros(samples)
        self._probe = np.zeros((samples, 2, len(probes.names), 3))
        self._spin = np.zeros((samples, 2, 3))
        self._scalar = np.zeros((samples, len(SCALARS)))
        self._fields: list[tuple[float, Array, NDArray[np.int8]]] = []
        self._watch = CompressionWatch(system)
        self._count = 0

    def store(self, time: float, q: Array, v: Array, motion: RigidMotion, energies: tuple[float, float]) -> None:
        """Store one sample; the system's stresses must belong to ``q``."""
        row = self._count
        self._time[row] = time
        probe, spin = self._probe[row], self._spin[row]
        probe[0], probe[1] = self._probes.read(q), self._probes.read(v)
        spin[0], spin[1] = motion.angular_velocity, motion.angular_acceleration
        survey = survey_film(self._system)
        slack = sum(int(np.count_nonzero(stress < 0.0)) for stress, _, _ in self._system.cables)
        self._scalar[row] = *energies, survey.smallest, survey.largest, survey.wrinkled, survey.slack, slack
        self._watch.see(time, survey)
        self._count += 1

    def store_field(self, step: int, time: float, q: Array) -> None:
        """Store the whole field if this step was asked for."""
        if step in self._field_steps:
            self._system.force(q)  # the stresses on which the states depend
            self._fields.append((time, self._system.translations(q), current_film_states(self._system)))

    def to_dataset(self, attributes: dict[str, Any]) -> xr.Dataset:
        """Dataset of everything stored so far; ``attrs["warnings"]`` lists what the user should know."""
        n = self._count
        samples = Samples(self._time[:n], self._probe[:n], self._spin[:n], self._scalar[:n], self._fields)
        return run_dataset(
            self._system.model, self._probes, samples, {**attributes, "warnings": self._watch.warnings()}
        )


def run_dataset(model: Model, probes: ProbeSet, samples: Samples, attributes: dict[str, Any]) -> xr.Dataset:
    """Dataset of the samples of a run, with the mesh."""
    arrays: dict[str, Any] = {}
    for kind, suffix in enumerate(("", "_velocity")):
        arrays |= {name + suffix: samples.probe[:, kind, :, axis] for axis, name in enumerate("uvw")}
    arrays["angular_velocity"], arrays["angular_acceleration"] = samples.spin[:, 0], samples.spin[:, 1]
    arrays |= dict(zip(SCALARS, samples.scalar.T, strict=True))
    arrays["displacement"] = np.array([field for _, field, _ in samples.fields]).reshape(-1, len(model.nodes), 3)
    states = np.array([state for _, _, state in samples.fields], dtype=np.int8)
    arrays["film_state"] = states.reshape(len(samples.fields), len(model.triangles))
    arrays["probe_position"] = probes.positions
    data = described(RUN, arrays)
    data["film_state"][-1].update(
        flag_values=np.arange(len(FILM_STATES), dtype=np.int8), flag_meanings=" ".join(FILM_STATES)
    )
    times = {"time": samples.time, "field_time": np.array([time for time, *_ in samples.fields])}
    return xr.Dataset(
        {**data, **mesh_variables(model)},
        coords={**described(RUN, times), "probe": list(probes.names), "component": COMPONENTS},
        attrs=attributes,
    )
