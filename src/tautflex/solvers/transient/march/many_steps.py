"""Compiled march of a method whose stages share one tangent: whole steps of a fixed size, one after the other.

They are those of `Stepper`, number by number: the same compiled parts in the same order. What a step meets beside the
plain course of things (a tangent that has to be renewed, an iteration that does not converge) it leaves undone, as if
it had not been tried, and whoever called takes it.

Arguments come in groups:

========= ==================================================================================================
group     what
========= ==================================================================================================
matrices  start, column, mass, damping, whether there is damping, ``linear`` of `StepNumbers`, pair products, force
          of the reference; vectors of damping beside the matrix, their coefficients, and these times the weight that
          the increment's velocity has; ``linear`` and the last for every stage
elements  store and stresses of a `Workspace`
scheme    for every stage ``known``, ``end`` and ``recalled`` of `StepNumbers`, whether it recalls states, and weight,
          evaluation instant after its start [s], size [s], share of the stiffness that turns, ``part`` of
          `StepNumbers`; whether the stresses of a step's last evaluation are those of its end
tangent   pattern, values and reciprocal pivots of L D L', see `substitute`; diagonal of the stiffness for the first
          step, and for the others; share of the mass; parts of a `LowRankUpdate`
axes      operator, places, owner of a `Corotation` and where the tangent was factorized
pairs     changes, shifts, Gram matrix and last step of `AndersonAcceleration`
frame     motion of the frame at the evaluation instants, see `Segment.rows`, and what `frame_of` gives; loads of
          inputs, and which one every stage has at its evaluation instant; stresses that change, see `restress_stage`
hub       of a free hub what `on_hub` tells; None under a prescribed motion
limits    Newton tolerance, iterations allowed, round-off over tolerance, sizes of the elements' forces at the tangent,
          floor of the force scale over its largest value, iterations that pay for a new tangent
========= ==================================================================================================
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.lending import lent
from tautflex.mechanics.products import add_low_rank, inner, product, quadratic_form
from tautflex.mechanics.restressing import restress_sample, restress_stage, restressing_work
from tautflex.numeric import Array, Indices, jit
from tautflex.solvers.linear.low_rank import take_back
from tautflex.solvers.linear.substitution import substitute
from tautflex.solvers.nonlinear.anderson import propose_step
from tautflex.solvers.nonlinear.newton import PATIENCE, SLOPE_ACCEPTED
from tautflex.solvers.transient.accuracy.books import INERTIA, STRESS
from tautflex.solvers.transient.accuracy.time_error import is_sampled, see_step
from tautflex.solvers.transient.corotation import node_angles, turn
from tautflex.solvers.transient.free_hub.balance import mobile_product
from tautflex.solvers.transient.free_hub.momentum import carried_energy
from tautflex.solvers.transient.march.control import LEVEL, SHARE, is_kept
from tautflex.solvers.transient.march.frame import frame_terms
from tautflex.solvers.transient.march.grid import record_between
from tautflex.solvers.transient.march.on_hub import add_reaction, end_of_hub, foretold
from tautflex.solvers.transient.recorder import record
from tautflex.solvers.transient.step_kernel import begin_step, end_of_step, first_guess, recalled, step_residual

# Of `counts`: pairs learned, fewest iterations with this tangent, iterations lost to its age; iterations,
# evaluations and substitutions of all steps.
LEARNED, FEWEST, LOST, ITERATIONS, EVALUATIONS, SOLVES = range(6)


@jit
def _left(
    x: Array, q: Array, matrices: Any, elements: Any, stage: int, sizes: Array, begun: Any, round_off: float,
    lost: float, met: float, floor: float, energies: bool, hub: Any, motion: Any, guess: Array,
) -> tuple[Array, Array, float, float, float, Array, Array]:  # fmt: skip
    """Internal force of an increment, what it leaves unbalanced, that over the force scale, the scale, and energy.

    Then what `add_reaction` adds and the hub, from ``motion`` at the start of the stage and a guess, of a free one.
    """
    start, column, _, _, _, linear, pairs, reference, vectors, _, losses = matrices
    rows, turning, _, load_norm, _ = begun
    weight, reach, part = sizes[0], sizes[1], sizes[4]
    force, residual, norm, internal, inertia, energy = step_residual(
        x, q, elements[0], elements[1], elements[2], start, column, linear[stage], pairs, turning, weight, reference,
        rows, energies, part,
    )  # fmt: skip
    if losses.size:
        add_low_rank(vectors, losses[stage], 1.0, x, residual)
        norm = np.sqrt(inner(residual, residual))
    scale, frame = max(internal, load_norm), guess
    if hub is not None:
        frame, guess, load, norm = add_reaction(hub, motion, guess, x, q, reach, weight, residual)
        scale = max(scale, load)
    measured = max(scale, lost + round_off * (inertia + 0.02 * met), floor)
    error = 0.0
    if norm != 0.0:
        error = norm / measured if 0.0 < measured < np.inf else np.inf
    return force, residual, error, scale, energy, frame, guess


@jit
def _solution(tangent: Any, right: Array) -> Array:
    solution = substitute(tangent[0], tangent[1], tangent[2], right)
    take_back(tangent[5], tangent[6], solution)
    return solution


@jit
def _given_up(before: float, after: float, tolerance: float, iterations: int) -> bool:
    """Whether the tangent is too slow, see `solve_newton`."""
    if after <= tolerance or not np.isfinite(after):
        return False
    if not after < before:
        return True
    return iterations > 1 and np.log(after / tolerance) / np.log(before / after) > PATIENCE


@jit
def _restore(pairs: Any, kept: Any, first: int, count: int) -> None:
    """Forget the pairs that were learned after the first ones."""
    changes, shifts, gram, _ = pairs
    for k in range(min(count - first, changes.shape[0])):
        row = (first + k) % changes.shape[0]
        changes[row], shifts[row] = kept[0][k], kept[1][k]
    gram[:] = kept[2]


@jit
def _solve(
    x: Array, q: Array, matrices: Any, elements: Any, stage: int, sizes: Array, begun: Any, tangent: Any, axes: Any,
    pairs: Any, kept: Any, first: int, limits: Any, lost: float, counts: Indices, scales: Array, energies: bool,
    hub: Any, motion: Any, guess: Array,
) -> tuple[bool, Array, Array, Array, float, Array, Array]:  # fmt: skip
    """Whether the iteration converges with the tangent at hand; increment, residual, and the rest of `_left`.

    ``kept`` is for pairs that give way to ones learned after the ``first`` of the step.
    """
    tolerance, depth, floor = limits[0], pairs[0].shape[0], limits[4] * scales[0]
    places, owner, angle = axes
    learned = counts[LEARNED]
    iterations, evaluations, known = 0, 1, False
    force, residual, error, scale, energy, frame, rigid = _left(
        x, q, matrices, elements, stage, sizes, begun, limits[2], lost, scales[1], floor, energies, hub, motion, guess
    )
    good = True
    while good and error > tolerance and iterations < limits[1] and np.isfinite(error):
        turned = residual.copy()
        turn(places, owner, angle, -1.0, turned)
        solution = _solution(tangent, turned)
        if known and learned - first < depth:
            if learned == first:
                kept[2][:] = pairs[2]
            kept[0][learned - first], kept[1][learned - first] = pairs[0][learned % depth], pairs[1][learned % depth]
        step, slope, learned = propose_step(pairs[0], pairs[1], pairs[2], learned, known, pairs[3], solution, turned)
        turn(places, owner, angle, 1.0, step)
        iterations, evaluations, known, before = iterations + 1, evaluations + 1, True, error
        x = x + step
        force, residual, error, scale, energy, frame, rigid = _left(
            x, q, matrices, elements, stage, sizes, begun, limits[2], lost, limits[3], floor, energies, hub, motion,
            rigid,
        )  # fmt: skip
        good = error <= tolerance or abs(inner(step, residual)) <= SLOPE_ACCEPTED * abs(slope)
        good = good and not _given_up(before, error, tolerance, iterations)
    counts[LEARNED] = learned
    if not good or not error <= tolerance:
        return False, x, residual, force, energy, frame, rigid
    counts[LOST] += max(iterations - counts[FEWEST], 0)
    counts[FEWEST] = min(iterations, counts[FEWEST])
    counts[ITERATIONS] += iterations
    counts[SOLVES] += iterations
    counts[EVALUATIONS] += evaluations
    scales[0], scales[1] = max(scales[0], scale), limits[3]
    return True, x, residual, force, energy, frame, rigid


@jit
def _stage(
    stage: int, row: int, at: Any, own: Any, passed: Array, matrices: Any, elements: Any, scheme: Any, tangent: Any,
    axes: Any, pairs: Any, kept: Any, first: int, frame: Any, terms: Any, hub: Any, limits: Any, counts: Indices,
    scales: Array, energies: bool,
) -> tuple[bool, tuple[float, float], Any, Any]:  # fmt: skip
    """Whether a stage converges; energies of the motion and of strain, and state and hub at its end.

    It is the ``row``-th of the stretch; ``passed`` holds the states that the step has passed, see `recalled`, and
    ``terms`` the frame's at the evaluation instant.
    """
    start, column, mass, damping, damped, _, products, reference, vectors, strengths, _ = matrices
    known, ends, factors, recalls, sizes, _ = scheme
    q, speed, pace, jerk, forces, work, before, now, late = at
    (rigid, true, power), (velocity, displacement, load) = own, terms
    known, (weight, reach, size) = known[stage], sizes[stage, :3]
    pushes, push, stress = frame[2], frame[3], frame[4]
    restress_stage(stress, elements, row)
    v, a = speed, pace
    if recalls[stage]:
        both = recalled(factors[stage], passed)
        v, a = both[0], both[1]
    begun = begin_step(
        start, column, mass, damping, damped, products, known, velocity, displacement, load - pushes[push[row]],
        tangent[3][min(row, 1)], q, v, a,
    )  # fmt: skip
    parts, known_norm = begun[0], begun[2]
    if strengths.size:
        add_low_rank(vectors, strengths, weight, known[3] * v + known[4] * a, parts[0])
        known_norm = np.sqrt(inner(parts[0], parts[0]))
    if weight < 1.0:
        for i in range(q.size):
            parts[0, i] += (1.0 - weight) * forces[i]
        known_norm = np.sqrt(inner(parts[0], parts[0]))
    lost = limits[2] * (known_norm + 0.1 * begun[4])
    guess = first_guess(reach, speed, pace, jerk)
    angle = node_angles(axes[0], axes[1], axes[2], q + guess, axes[5], sizes[stage, 3])
    turned, motion = rigid, ((v, a, true, rigid), stage, row)
    if hub is not None:
        turned = foretold(rigid, reach)
    converged, x, residual, force, energy, added, turned = _solve(
        guess, q, matrices, elements, stage, sizes[stage], begun, tangent, (axes[3], axes[4], angle), pairs, kept,
        first, limits, lost, counts, scales, energies, hub, motion, turned,
    )  # fmt: skip
    if not converged:
        return False, (0.0, energy), at, own
    reaction = load
    if hub is not None:
        reaction = added
    end, done, kinetic = end_of_step(
        ends[stage], size, weight * reach, late, start, column, mass, damped, vectors, strengths, weight, parts,
        force, reference, reaction, pushes[push[row]], now, before, work, x, q, v, a,
    )  # fmt: skip
    done[STRESS] += restressing_work(stress, elements, row, q, end[0])
    left = forces
    if weight < 1.0:
        left = np.empty(q.size)
        for i in range(q.size):
            left[i] = (residual[i] - end[9 + INERTIA, i] - (1.0 - weight) * forces[i]) / weight
        now = end[9:]
    if recalls[stage]:
        for i in range(q.size):
            end[3, i] = (end[2, i] - pace[i]) / size
    if hub is not None:
        rigid, true, power = end_of_hub(hub, motion, turned, x, q, end, reach, size, weight, power, done)
    reached = end[0], end[1], end[2], end[3], left, done, end[4:9], now, weight * reach - size
    return True, (kinetic, energy), reached, (rigid, true, power)


@jit
def _keeps(control: Any, begins: float, at: Any, now: Any, matrices: Any, tangent: Any, counts: Indices) -> bool:
    """Whether a step from an instant [s] keeps the tolerance of ``control``, if there is one, see `is_kept`."""
    if control is None:
        return True
    start, column, mass = matrices[:3]
    error = _solution(tangent, tangent[4] * product(start, column, mass, control[0][SHARE] * (now[2] - at[2])))
    counts[SOLVES] += 1
    found, speed = quadratic_form(start, column, mass, error), quadratic_form(start, column, mass, now[1])
    return is_kept(control, begins, np.sqrt(max(found, 0.0)), np.sqrt(max(speed, 0.0)))


@jit
def take_steps(
    times: Array, matrices: Any, elements: Any, scheme: Any, tangent: Any, axes: Any, pairs: Any, frame: Any,
    hub: Any, limits: Any, counts: Indices, scales: Array, begin: Any, watched: bool, watch: Any, samples: Any,
    control: Any,
) -> tuple[int, Any, Any, Any]:  # fmt: skip
    """Take steps between instants, shape (steps + 1,), until one is left undone or the tangent is to be renewed.

    ``scales`` holds the largest force scale of the run, and sizes of the elements' forces by which the first guess is
    judged; ``begin`` the parts of a `MotionState`: displacement, velocity, acceleration, jerk, forces, and of its
    `Books` work, forces by kind of the last equilibrium and of its evaluation instant alone, and lateness; ``watch``
    those of a `TimeError`, if the run is ``watched``; ``samples`` what `record` writes to and where, for every step,
    then an array for displacements and the row of every step; -1: nowhere; ``control`` what `is_kept` reads, of steps
    that are to be of another size where their error asks for it, else None.

    Returns the number of steps taken, then the parts of the state that they end in, as in ``begin``; of a free hub the
    hub there, its balanced acceleration, power and work; and the parts of the state where the last step begins.
    """
    at, prior, own, level, size = begin, begin, (np.zeros(0), np.zeros(0), np.zeros(2)), 0.0, begin[0].size
    if hub is not None:
        own = hub[7], hub[8], hub[9]
    if control is not None:
        level = control[1][LEVEL]
    # What stays as it is or is filled in where it is; not what may be returned.
    matrices, elements, scheme, tangent, axes, pairs = lent((matrices, elements, scheme, tangent, axes, pairs))
    frame, watch, samples, on_hub = lent((frame, watch, samples, hub))
    start, column, mass = matrices[0], matrices[1], matrices[2]
    (motions, fixed, _, _, stress), (recorded, rows, fields, places) = frame, samples
    sizes, there, stages = scheme[4], scheme[5], scheme[4].shape[0]
    terms, passed = frame_terms(motions[0], fixed), np.empty((stages, 3, size))
    taken, depth, unseen = 0, pairs[0].shape[0], np.zeros(0)
    kept = np.empty((depth, size)), np.empty((depth, size)), np.empty((depth, depth))
    for k in range(times.size - 1):
        first, counted, scaled = counts[LEARNED], counts.copy(), scales.copy()
        now, new, energies, time, good = at, own, (0.0, 0.0), times[k], True
        for stage in range(stages):
            row = stages * k + stage
            if row and not np.array_equal(motions[row], motions[row - 1]):
                terms = frame_terms(motions[row], fixed)
            if stages > 1:
                passed[stage, 0], passed[stage, 1], passed[stage, 2] = now[0], now[1], now[2]
            good, energies, now, new = _stage(
                stage, row, now, new, passed[: stage + 1], matrices, elements, scheme, tangent, axes, pairs, kept,
                first, frame, terms, on_hub, limits, counts, scales, there and rows[k] >= 0 and stage == stages - 1,
            )  # fmt: skip
            time += sizes[stage, 2]
            # Within a step a tangent that is too old leaves the whole step to the driver.
            good = good and (stage == stages - 1 or counts[LOST] <= limits[5])
            if not good:
                break
        good = good and _keeps(control, times[k], at, now, matrices, tangent, counts)
        if not good:
            if counts[LEARNED] > first:
                _restore(pairs, kept, first, counts[LEARNED])
            counts[:], scales[:] = counted, scaled
            break
        if watched:
            error = unseen
            if is_sampled(watch[1][0]):
                moved = now[2] - at[2]
                if hub is None:
                    moved = product(start, column, mass, moved)
                else:
                    moved = mobile_product(hub[0], start, column, mass, now[0], moved)
                error = _solution(tangent, tangent[4] * moved)
                counts[SOLVES] += 1
            see_step(watch, now[0], now[1], now[2], at[2], error, time, time - times[k])
        prior, at, own = at, now, new
        if hub is not None:
            hub[10][k, :31], hub[10][k, 31] = own[0], own[2][1]
        if rows[k] >= 0:
            restress_sample(stress, elements, k)
            record(recorded, at[0], at[1], times[k + 1], rows[k], energies[0], energies[1] if there else np.nan)
            if hub is not None:
                recorded[5][1][rows[k], 0] += carried_energy(hub[0], at[0], at[1], own[0][7:13])
        if places[k] >= 0:
            fields[places[k]] = at[0]
        taken, done = taken + 1, counts[LOST] > limits[5]
        if control is not None:
            record_between(control[5], k, prior, at, times[k], times[k + 1], samples, stress)
            done = done or control[1][LEVEL] != level
        if done:
            break
    return taken, at, own, prior
