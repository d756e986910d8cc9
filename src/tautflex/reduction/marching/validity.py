"""Whether a reduced run stayed where its model holds: tension everywhere, and little energy outside the basis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.mechanics.membrane import STORED, StressSurvey
from tautflex.mechanics.products import MassDamping
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array, Indices
from tautflex.reduction.marching.readout import Readout
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.polynomial.forces import total_force
from tautflex.solvers.transient.accuracy.compression import CompressionWatch
from tautflex.solvers.variables import SCALARS

# Windows of a run; each is checked where its coordinates store most energy.
_WINDOWS = 8
# Part of the run's energy beyond which the truncated directions are worth a warning.
_NOTABLE = 0.05
# Part of what stresses store at rest that counts as energy of motion where hardly anything moves.
_STILL = 0.01
# Part of the force of pressure that the polynomial may lack.
_NOTABLE_PRESSURE = 0.01


class Checked(NamedTuple):
    """Numbers of the samples that were checked, what stresses tell there by name in `SCALARS`, shape (check,) each.

    ``truncated`` is the energy in truncated directions over the largest energy of the run.
    """

    samples: Indices
    scalars: dict[str, Array]
    truncated: Array
    warnings: list[str]


def check_validity(run: ReducedRun, read: Readout) -> Checked:
    """Look at the full field at the largest motion of every window of a run.

    The force that the full equation of motion leaves unbalanced at the reduced solution is what the basis cannot
    answer; the strain energy of its static response measures the motion that is missing.
    """
    state, system, solver = run.rom.state, run.rom.state.system, run.rom.reference
    windows = np.array_split(np.arange(len(read.times)), _WINDOWS)
    chosen = np.array([part[np.argmax(read.size[part])] for part in windows if part.size], dtype=int)
    motions = run.motions(read.times[chosen])
    workspace, watch, moments = system.workspace(), CompressionWatch(system), run.problem.coupling.moments(system)
    survey = StressSurvey(system, workspace)
    matrix = run.problem.damping.of(state.linear)
    kinds = state.linear.by_kind if matrix.kinds else None
    damping = MassDamping(system.pattern, system.inertia.mass_entries, state.tangent_entries, matrix, kinds)
    scalars, left, pushed = [], [], 0.0
    for row, moves, offset in zip(chosen, motions, run.prescribed_offset(motions), strict=True):
        motion, time = RigidMotion(moves[:3], moves[3:6], moves[6:]), float(read.times[row])
        eta, rate = run.eta[read.place[row]], run.rate[read.place[row]]
        q, v, a = _full_motion(run, time, eta, rate, offset)
        workspace.change_initial_stress(run.inputs.given.stress(time))
        unbalanced = workspace.force(q)[0] - state.reference_force
        unbalanced += system.inertia.mass_matrix @ a + damping.damping_product(v)
        unbalanced += system.inertia.apply(run.problem.coupling.velocity_weight(motion), v)
        unbalanced += system.inertia.apply(run.problem.coupling.displacement_weight(motion), q)
        unbalanced += run.problem.coupling.load(motion, moments) - run.inputs.given.load(time)
        unbalanced -= sum(item.force(q) for item in run.inputs.given.followers(time))
        pushed = max(pushed, run.inputs.left_out(time, eta, q))
        found = survey.stresses()
        scalars.append(found[:STORED])
        watch.see(time, found.tolist())
        left.append(0.5 * float(unbalanced @ solver.solve(unbalanced)))
    truncated = np.array(left) / max(read.moving, _STILL * read.still, 1e-300)
    warnings = list(watch.warnings())
    if (worst := float(truncated.max(initial=0.0))) > _NOTABLE:
        warnings.append(
            f"the reduced model leaves {worst:.1%} of the run's largest energy outside its basis; take more modes "
            "(count, threshold), directions of all accelerations that act, or a PodBasis of a run like this one"
        )
    if pushed > _NOTABLE_PRESSURE:
        warnings.append(
            f"pressure: film that turns and stretches changes its force by {pushed:.1%} more than the reduced model "
            "has, which takes it as linear about rest; simulate the full state"
        )
    numbers = np.array(scalars).reshape(-1, STORED).T
    named = dict(zip(list(SCALARS)[-STORED:], numbers, strict=True))
    return Checked(chosen, named, truncated, warnings)


def _full_motion(run: ReducedRun, time: float, eta: Array, rate: Array, offset: Array) -> tuple[Array, Array, Array]:
    """Free unknowns, their velocities and accelerations at the reduced solution, shapes (size,)."""
    force = np.empty(run.rom.size)
    total_force(run.arrays, run.frame_now(time), 0, eta, rate, force)
    q, v, a = run.rom.motion(eta, rate, np.asarray(-np.linalg.solve(run.arrays.mass, force), dtype=np.float64), offset)
    return q + run.inputs.answer(np.array([time]))[0], v, a
