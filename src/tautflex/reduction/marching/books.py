"""Books of energy and time error of a reduced run, from what its compiled steps noted; twin of those of a full run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, jit
from tautflex.reduction.inputs import ReducedInputs
from tautflex.reduction.marching.dispatch import internal_force
from tautflex.reduction.marching.work import StageNumbers, Work
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import strain_energies
from tautflex.solvers.remembering import Remembering
from tautflex.solvers.transient.accuracy.time_error import GROWTH, ErrorSum, missed_between

# One of so many steps is looked at for more than its local error, and of these one for its energy; steps of a stretch
# that may be too long for it.
_SAMPLED, _WEIGHED, _FEW = 8, 8, 20


class Start(NamedTuple):
    """State before some steps: coordinates, their velocities and accelerations, all forces but inertia, shape (r,)."""

    q: Array
    v: Array
    a: Array
    forces: Array

    @classmethod
    def of(cls, work: Work) -> Start:
        """Copy of where the steps stand."""
        return cls(work.q.copy(), work.v.copy(), work.a.copy(), work.forces.copy())


@jit
def _add_works(
    trace: Array, load: Array, numbers: Array, q: Array, own: Array, now: Array, known: bool, late: float, work: Array
) -> float:
    """Add the work of stages to ``work``, as `written` does for a full run, and keep their last forces by kind.

    ``numbers`` holds weight, evaluation instant and size of the stages of a step, shape (stage, 3); ``q`` starts at the
    start of the first. Returns how late the last equilibrium is.
    """
    for n in range(trace.shape[0]):
        weight, evaluation, size = numbers[n % numbers.shape[0]]
        at, row = weight * evaluation * size, trace[n]
        share = (0.5 * size - late) / (at - late) if known else 1.0
        for kind in range(5):
            done, other = 0.0, 0.0
            for i in range(q.size):
                given = load[n, i] if load.shape[0] else 0.0
                if kind < 3:
                    force = row[3 + kind, i]
                elif kind == 3:
                    force = row[6, i] - row[4, i] - row[5, i] - given
                else:
                    force = given
                mixed = force if kind == 0 else weight * force + (1.0 - weight) * now[kind, i]
                done += mixed * (row[0, i] - q[i])
                other += own[kind, i] * (row[0, i] - q[i])
                now[kind, i], own[kind, i] = force, mixed
            work[kind] += share * done + (1.0 - share) * other
        for i in range(q.size):
            q[i] = row[0, i]
        known, late = True, at - size
    return late


class ReducedBooks(Remembering):
    """Work of a reduced run's forces by kind, and its local errors.

    Parameters
    ----------
    rom, arrays, inputs
        Reduced model, its compiled arrays, and the inputs on it.
    errors
        Whether local errors are summed up.
    """

    MEMORY = ("work", "_known", "_late", "_own", "_now", "errors")

    def __init__(self, rom: OnBasis, arrays: Any, inputs: ReducedInputs, errors: bool) -> None:
        self._rom, self._arrays, self._inputs, self._nodes = rom, arrays, inputs, rom.model.nodes
        self.work = np.zeros(7)
        self.errors = ErrorSum() if errors else None
        system = rom.state.system
        places = system.place[rom.model.translation_dofs]
        # Sums of squares of all displacements and of those across, as forms of the coordinates.
        vectors = [rom.basis.kept[:, some[some < system.size]] for some in (places, places[:, 2])]
        self._forms = [each @ each.T for each in vectors]
        self.restart()

    def restart(self) -> None:
        """Forget the last equilibrium: the rigid motion or an input jumped."""
        self._known, self._late = False, 0.0
        self._own, self._now = np.zeros((2, 5, len(self._arrays.mass)))

    def take(
        self, trace: Array, start: Start, stages: tuple[StageNumbers, ...], starts: Array, segment: Segment
    ) -> None:
        """Take in steps from ``start`` that began at ``starts`` [s], with a row of ``trace`` for each stage."""
        if not len(trace):
            return
        count, numbers = len(trace) // len(stages), np.array([(c.weight, c.evaluation, c.size) for c in stages])
        offsets = np.cumsum([0.0, *numbers[:-1, 2]]) + numbers[:, 1] * numbers[:, 2]
        load = self._loads((starts[:count, None] + offsets).ravel(), segment.end, trace[:, 7])
        if not self._known and numbers[0, 0] < 1.0:
            self._now = self._at(start)
        self._late = _add_works(
            trace, load, numbers, start.q.copy(), self._own, self._now, self._known, self._late, self.work
        )
        self._known = True
        if self.errors is not None:
            ends = trace.reshape(count, len(stages), *trace.shape[1:])[:, -1]
            self.add_errors(self.errors, ends, start, stages[-1], starts[:count], segment)

    def _loads(self, times: Array, before: float, places: Array) -> Array:
        """Forces of inputs on the left-hand side at instants and coordinates there, shape (time, r); (0, r): none."""
        if not self._inputs:
            return np.zeros((0, places.shape[1]))
        load, given = self._inputs.forces(times, before)
        result, (first, second) = load.T.copy(), self._arrays[:2]
        # Stresses in elements are part of the internal force.
        if len(first):
            np.add.at(result, first, given.T * places[:, second].T)
            np.add.at(result, second, given.T * places[:, first].T)
        return result.T

    def _at(self, start: Start) -> Array:
        """Forces at an instant by kind, shape (5, r); those of inputs are left with those of the frame."""
        parts, given = np.empty(2 * start.q.size), np.zeros(len(self._arrays.first))
        internal_force(self._arrays, start.q, start.v, given, parts)
        inside, other = np.split(parts, 2)
        loss = other + self._arrays.damping @ start.v
        inside = inside - other
        none = np.zeros_like(inside)
        return np.stack([none, inside, loss, start.forces - inside - loss, none])

    def add_errors(
        self, errors: ErrorSum, ends: Array, start: Start, stage: StageNumbers, starts: Array, segment: Segment
    ) -> None:
        """Sum up local errors of steps, filtered by the stiffness of the reference."""
        arrays, step, some = self._arrays, stage.step, ends[::_SAMPLED]
        resolved, inertia = np.eye(len(arrays.mass)), stage.inertia[0] * arrays.mass
        if inertia.any():
            stiffness = inertia + stage.weight * (arrays.linear + stage.velocity[0] * arrays.damping)
            resolved = np.linalg.solve(stiffness, inertia)
        change = np.diff(np.concatenate([start.a[None], ends[:, 2]]), axis=0)
        local = step**2 * np.sqrt(_squares(change, resolved.T @ self._forms[0] @ resolved))
        for number, form in enumerate(self._forms):
            errors.state[6 + number] = max(errors.state[6 + number], _squares(some[:, 0], form).max())
        velocity, acceleration = (_squares(some[:, row], arrays.mass) for row in (1, 2))
        errors.add_speeds(float(acceleration.sum()), float(velocity.sum()))
        loss, moving = _squares(some[:, 1], arrays.damping), velocity > 0.0
        decay = growth = 0.0
        if moving.any():
            if loss[moving].all():
                decay = 0.5 / float(np.mean(velocity[moving] / loss[moving]))
            few = np.ascontiguousarray(some[::_WEIGHED, 0])
            energy, linear = strain_energies(arrays, few), 0.5 * _squares(few, arrays.linear)
            other = float(np.abs(energy - linear).sum())
            share = other / max(other + float(np.minimum(energy, linear).sum()), 1e-300)
            stayed = change[::_SAMPLED] @ resolved.T
            lost = _squares(stayed, arrays.damping).sum() / max(float(_squares(stayed, arrays.mass).sum()), 1e-300)
            growth = GROWTH * float(np.sqrt(acceleration.sum() / velocity.sum())) * share - 0.5 * float(lost)
        errors.add(local, starts + step, step, decay, growth)
        for time in starts[:_FEW]:
            errors.missed += missed_between(self._nodes, float(time), step, segment)


@jit
def _squares(rows: Array, form: Array) -> Array:
    """``x' A x`` of every row, shape (row,)."""
    result = np.empty(rows.shape[0])
    for n in range(result.size):
        total = 0.0
        for i in range(form.shape[0]):
            part = 0.0
            for j in range(form.shape[1]):
                part += form[i, j] * rows[n, j]
            total += rows[n, i] * part
        result[n] = total
    return result
