"""Whether a reduced run stayed where its model holds: tension everywhere, and little energy outside the basis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.mechanics.membrane import StressSurvey
from tautflex.mechanics.products import MassDamping
from tautflex.mechanics.workspace import Workspace
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array, Indices
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.polynomial.forces import total_force
from tautflex.solvers.transient.accuracy.compression import CompressionWatch
from tautflex.solvers.transient.recorder import stress_scalars

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
        What stresses tell: name in `SCALARS` -> values, shape (check,).
    truncated
        Energy in truncated directions over the largest energy of the run, shape (check,).
    warnings
        What the user should know, in words.
    """

    samples: Indices
    scalars: dict[str, Array]
    truncated: Array
    warnings: list[str]


def check_validity(run: ReducedRun, times: Array, eta: Array, rate: Array, motions: Array, energy: Array) -> Checked:
    """Look at the full field at the largest motion of every window of a run.

    The force that the full equation of motion leaves unbalanced at the reduced solution is what the basis cannot
    answer; the strain energy of its static response measures the motion that is missing.

    Parameters
    ----------
    run
        The run.
    times, eta, rate, motions, energy
        Samples: instants [s], coordinates and rates (n, r), motion of the frame (n, 9), total energy [J].
    """
    system, solver = run.rom.state.system, run.rom.reference
    size = np.einsum("nr,nr->n", eta @ run.arrays.linear, eta)
    chosen = np.array(
        [part[np.argmax(size[part])] for part in np.array_split(np.arange(len(times)), _WINDOWS) if part.size]
    )
    workspace, watch = system.workspace(), CompressionWatch(system)
    survey = StressSurvey(system, workspace)
    inertia = system.inertia
    state = run.rom.state
    damping = MassDamping(
        system.pattern, inertia.mass_entries, state.tangent_entries, run.problem.damping.matrix(state.linear)
    )
    scalars, left = [], []
    for row, offset in zip(chosen, run.prescribed_offset(motions[chosen]), strict=True):
        motion = RigidMotion(motions[row, :3], motions[row, 3:6], motions[row, 6:])
        time = float(times[row])
        unbalanced = _unbalanced(run, workspace, time, eta[row], rate[row], offset, motion, damping)
        film = survey.membrane()
        scalars.append(stress_scalars(survey, film))
        watch.see(time, film, survey.cables)
        left.append(0.5 * float(unbalanced @ solver.solve(unbalanced)))
    truncated = np.array(left) / max(float(energy.max()), 1e-300)
    named = {name: np.array([each[name] for each in scalars]) for name in scalars[0]}
    return Checked(chosen, named, truncated, [*watch.warnings(), *_truncation_warning(truncated)])


def _truncation_warning(truncated: Array) -> list[str]:
    worst = float(truncated.max())
    if worst <= _NOTABLE:
        return []
    return [
        f"the reduced model leaves {worst:.1%} of the run's largest energy outside its basis; take more modes (count, "
        "threshold), directions of all accelerations that act, or a PodBasis of a run like this one"
    ]


def _unbalanced(
    run: ReducedRun,
    workspace: Workspace,
    time: float,
    eta: Array,
    rate: Array,
    offset: Array,
    motion: RigidMotion,
    damping: MassDamping,
) -> Array:
    """Force that the full equation of motion leaves unbalanced [N, N m], shape (size,)."""
    rom, arrays, state, coupling = run.rom, run.arrays, run.rom.state, run.problem.coupling
    inertia = state.system.inertia
    force = np.empty(rom.size)
    total_force(arrays, run.frame_now(time), 0, eta, rate, force)
    acceleration = np.asarray(-np.linalg.solve(arrays.mass, force), dtype=np.float64)
    q, v, a = rom.motion(eta, rate, acceleration, offset)
    result, _ = workspace.force(q)
    result = result - state.reference_force + inertia.mass_matrix @ a + damping.damping_product(v)
    result += inertia.apply(coupling.velocity_weight(motion), v)
    result += inertia.apply(coupling.displacement_weight(motion), q)
    return result + coupling.load(motion, inertia) - run.inputs.full_load(time)
