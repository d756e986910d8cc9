"""Whether a reduced run stayed where its model holds: tension everywhere, and little energy outside the basis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tautflex.mechanics.membrane import survey_film
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.reduction.marching.run import ReducedFlight
from tautflex.reduction.polynomial.forces import total_force
from tautflex.solvers.transient.compression import CompressionWatch

Array = NDArray[np.float64]

# Windows of a run; each is checked where its coordinates store most energy.
_WINDOWS = 8
# Part of the run's energy beyond which the truncated directions are worth a warning.
_NOTABLE = 0.05


class Checked(NamedTuple):
    """Result of the checks.

    Parameters
    ----------
    samples
        Numbers of the samples that were checked, shape (check,).
    scalars
        Columns of `SCALARS` behind the energies, shape (check, column).
    truncated
        Energy in truncated directions over the largest energy of the run, shape (check,).
    warnings
        What the user should know, in words.
    """

    samples: NDArray[np.int64]
    scalars: Array
    truncated: Array
    warnings: list[str]


def check_validity(
    flight: ReducedFlight,
    segments: tuple[Segment, ...],
    times: Array,
    eta: Array,
    rate: Array,
    motions: Array,
    energy: Array,
) -> Checked:
    """Look at the full field at the largest motion of every window of a run.

    The force that the full equation of motion leaves unbalanced at the reduced solution is what the basis cannot
    answer; the strain energy of its static response measures the motion that is missing.

    Parameters
    ----------
    flight
        The run.
    segments
        Its maneuver.
    times, eta, rate, motions, energy
        Samples: instants [s], coordinates and rates (n, r), motion of the frame (n, 9), total energy [J].
    """
    system, solver = flight.rom.state.system, flight.rom.reference
    size = np.einsum("nr,nr->n", eta @ flight.plant.linear, eta)
    chosen = np.array(
        [part[np.argmax(size[part])] for part in np.array_split(np.arange(len(times)), _WINDOWS) if part.size]
    )
    watch = CompressionWatch(system)
    inertia = system.inertia
    damping = system.pattern.symmetric_matrix(
        flight.damping.entries(inertia.mass_entries, flight.rom.state.tangent_entries)
    )
    scalars, left = [], []
    for row, pulled in zip(chosen, flight.pulled(motions[chosen]), strict=True):
        motion = RigidMotion(motions[row, :3], motions[row, 3:6], motions[row, 6:])
        unbalanced = _unbalanced(flight, segments, float(times[row]), eta[row], rate[row], pulled, motion, damping)
        survey = survey_film(system)
        slack = sum(int((system.stress[i] < 0.0).sum()) for i in system.block_index("cable"))
        scalars.append((survey.smallest, survey.largest, survey.wrinkled, survey.slack, slack))
        watch.see(float(times[row]), survey)
        left.append(0.5 * float(unbalanced @ solver.solve(unbalanced)))
    truncated = np.array(left) / max(float(energy.max()), 1e-300)
    return Checked(chosen, np.array(scalars), truncated, [*watch.warnings(), *_truncation_warning(truncated)])


def _truncation_warning(truncated: Array) -> list[str]:
    worst = float(truncated.max())
    if worst <= _NOTABLE:
        return []
    return [
        f"the reduced model leaves {worst:.1%} of the run's largest energy outside its basis; take more modes (count, "
        "threshold), directions of all accelerations that act, or a PodBasis of a run like this one"
    ]


def _unbalanced(
    flight: ReducedFlight,
    segments: tuple[Segment, ...],
    time: float,
    eta: Array,
    rate: Array,
    pulled: Array,
    motion: RigidMotion,
    damping: csr_array,
) -> Array:
    """Force that the full equation of motion leaves unbalanced [N, N m], shape (size,)."""
    rom, plant, state = flight.rom, flight.plant, flight.rom.state
    system, inertia = state.system, state.system.inertia
    force = np.empty(rom.size)
    total_force(plant, flight.frame_now(segments, time), 0, eta, rate, force)
    acceleration = np.asarray(-np.linalg.solve(plant.mass, force), dtype=np.float64)
    q, v, a = rom.motion(eta, rate, acceleration, pulled)
    result, _ = system.force(q)
    result = result - state.reference_force + inertia.mass_matrix @ a + damping @ v
    result += inertia.apply(flight.coupling.velocity_weight(motion), v)
    result += inertia.apply(flight.coupling.displacement_weight(motion), q)
    return result + flight.coupling.load(motion, inertia) - flight.inputs.full_load(time)
