"""One run of a reduced model: its start, its steps, and what is read from it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from scipy.linalg import eigh

from tautflex.errors import InputError, NotConvergedError, UnsupportedError
from tautflex.mechanics.inertia import WeighedMoments
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.kinematics import RigidMotion, Segment, split_segments
from tautflex.numeric import Array, Indices, cross_matrices
from tautflex.reduction.marching.books import ReducedBooks, Start
from tautflex.reduction.marching.dispatch import internal_force, tangent
from tautflex.reduction.marching.frame_terms import frame_at, frame_terms, sample
from tautflex.reduction.marching.schedule import Stretch, stretches
from tautflex.reduction.marching.steps import march, march_explicit
from tautflex.reduction.marching.work import StageNumbers, new_work, stage_numbers
from tautflex.reduction.on_basis import OnBasis, require_forces
from tautflex.reduction.polynomial.forces import FrameTerms, derivative_forces, energies, rows_from, total_force
from tautflex.solvers.static.stability import growth_text, largest_translation
from tautflex.solvers.transient.accuracy.energy import Energies, energy_balance, frame_twist
from tautflex.solvers.transient.free_hub.momentum import Body, carried_energy
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.methods.generalized_alpha import Newmark
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import Progress, TransientProblem
from tautflex.solvers.transient.status import Statistics

# Steps between two looks at the keyboard and the progress bar; bounds the memory of sampled frame terms.
_LONGEST = 4096
# Negative eigenvalues smaller than this part of the largest one are zero but for round-off.
_ROUND_OFF = 1e-12


class ReducedRun:
    """State and record of a run.

    Raises UnsupportedError if adaptive steps, changes of tension or an unknown explicit method are asked
    for.
    """

    def __init__(self, rom: OnBasis, problem: TransientProblem) -> None:
        self.rom, self.problem = rom, problem
        if problem.adaptive is not None:
            raise UnsupportedError("adaptive: expected None for a reduced model, whose steps cost next to nothing")
        method = problem.method
        if not isinstance(method, Method | CentralDifference):
            raise UnsupportedError(f"method: expected an implicit method or CentralDifference(), got {method!r}")
        self._explicit = isinstance(method, CentralDifference)
        # Of a scheme, an explicit step needs its size and that its forces are those at its end.
        self._method = method if isinstance(method, Method) else Newmark()
        self.arrays = rom.arrays(problem.damping)
        kinds = problem.coupling.load_by_kind
        c = rom.coefficients if kinds is None else rom.weighed(kinds)
        self.moments = WeighedMoments(np.concatenate([c.load, c.load_stress], axis=1))
        self._offsets = WeighedMoments(c.follow_load)
        self.inputs = InputSet(rom.state.system, problem.inputs)
        require_forces(self.inputs)
        self._began, self.segments = self._plan(problem.maneuver)
        self._tolerance = problem.tolerance or self._method.tolerance
        # Numbers of the grid instants whose coordinates are kept, sorted; the first is 0.
        fields = np.array(sorted(problem.field_steps), dtype=np.int64)
        self.stored = np.union1d(np.arange(0, problem.count + 1, problem.every), fields)
        self.eta, self.rate = np.zeros((2, len(self.stored), rom.size))
        self.reached = 0
        self._work = new_work(rom.size, self._method.tangents)
        self._march = march_explicit if self._explicit else march
        self._halvings = 0
        self.warnings = problem.doubts
        self.books = ReducedBooks(rom, self.arrays, self.inputs, problem.time_error)
        self.first: tuple[Array, Array]
        self._trace = np.empty((0, 8, rom.size))

    def _plan(self, maneuver: Any) -> tuple[RigidMotion, tuple[Segment, ...]]:
        """Motion at the start, and smooth segments of the motion and the inputs."""
        return maneuver.start(), split_segments(maneuver.segments(), self.inputs.breaks)

    @property
    def time(self) -> float:
        """Instant that the steps have come to [s]."""
        return self.reached * self.problem.time_step

    def balance(self) -> dict[str, float]:
        """Energy balance from the start to where the steps have come [J]."""
        rom, energies_of = self.rom, []
        body = tuple(Body.of(rom.state.system.inertia, None))
        for time, eta, rate in ((0.0, *self.first), (self.time, self._work.q, self._work.v)):
            offset = self.prescribed_offset(self.motions(np.array([time])))[0]
            q, v, _ = rom.motion(eta, rate, rate, offset)
            twist = frame_twist(self.problem.maneuver, self.segments, time)
            elastic, strain = energies(self.arrays, eta[None], rate[None])[0]
            energies_of.append(Energies(elastic, carried_energy(body, q, v, twist), strain))
        return energy_balance(energies_of[0], energies_of[1], self.books.work, free=False)

    @property
    def idle(self) -> list[str]:
        """What to know about inputs that move nothing."""
        return self.inputs.idle()

    @property
    def statistics(self) -> Statistics:
        """Work done so far."""
        taken, iterations, renewals, evaluations = (int(count) for count in self._work.counts)
        return Statistics(taken, iterations, renewals, iterations, evaluations, self._halvings)

    def start(self) -> None:
        """Steady spinning equilibrium, projected velocity, and the acceleration that follows."""
        work = self._work
        work.q[:] = self._equilibrium(self._began)
        work.q[:] += self._imperfection(work.q.copy())
        work.v[:] = self.rom.coordinates(self.problem.velocity)
        self._begin()
        self.eta[0], self.rate[0] = self.first = work.q.copy(), work.v.copy()
        if self._explicit:
            self._check_step(self.problem.time_step)

    def _begin(self) -> None:
        """Accelerations at the start."""
        self._balance(self._frame(self.segments[0], 0.0))

    def march(self, progress: Progress) -> bool:
        """Take all steps; whether the end was reached."""
        segments, step, count = self.segments, self.problem.time_step, self.problem.count
        current = 0
        for stretch in stretches(segments, step, count, _LONGEST):
            while current < stretch.segment:
                self._jump(current, float(stretch.starts[0]))
                current += 1
            if not self._march_stretch(segments[current], stretch):
                return False
            if progress is not None:
                progress(self.reached / count, f"t = {self.reached * step:.3g} s")
        if current + 1 < len(segments) and segments[current].end <= count * step * (1.0 + 1e-12):
            self._jump(current, count * step)
        return True

    def _march_stretch(self, segment: Segment, stretch: Stretch) -> bool:
        """Steps of equal size; those that fail are halved."""
        stages = stage_numbers(self._method, stretch.size)
        frame = self._frames(segment, stretch.starts, stages)
        rows = self._rows(stretch.grid)
        first = 0
        while first < len(rows):
            part = self._rest(frame, first * len(stages))
            first += self._steps(part, stages, rows[first:], stretch.starts[first:], segment)
            if first < len(rows):
                start = float(stretch.starts[first])
                if not self._halve(segment, start, stretch.size, self.problem.max_halvings):
                    break
                if rows[first] >= 0:
                    self._keep(int(rows[first]))
                first += 1
        self.reached = max(self.reached, int(stretch.grid[:first].max(initial=0)))
        return first == len(rows)

    def _rest(self, frame: Any, first: int) -> Any:
        """Terms from one instant on."""
        return rows_from(frame, first)

    def _keep(self, row: int) -> None:
        """Store the present state."""
        self.eta[row], self.rate[row] = self._work.q, self._work.v

    def _steps(
        self, frame: Any, stages: tuple[StageNumbers, ...], rows: Indices, starts: Array, segment: Segment
    ) -> int:
        """Steps of equal size from these instants on, and their books; how many converged."""
        start, count, stored = Start.of(self._work), len(rows) * len(stages), (self.eta, self.rate)
        if len(self._trace) < count:
            self._trace = np.empty((count, 8, self.rom.size))
        trace = self._trace[:count]
        done = self._march(self.arrays, frame, stages, self._work, rows, stored, self._tolerance, trace)
        self.books.take(trace[: done * len(stages)], start, stages, starts, segment)
        return int(done)

    def _rows(self, grid: Indices) -> Indices:
        """Where each grid instant is stored; -1: nowhere."""
        place = np.minimum(np.searchsorted(self.stored, grid), len(self.stored) - 1)
        return np.where(self.stored[place] == grid, place, -1)

    def _halve(self, segment: Segment, start: float, size: float, left: int) -> bool:
        """One failed step as two of half its size."""
        if left == 0:
            return False
        self._halvings += 1
        stages, nowhere = stage_numbers(self._method, 0.5 * size), np.full(1, -1)
        for begin in (start, start + 0.5 * size):
            starts = np.array([begin])
            done = self._steps(self._frames(segment, starts, stages), stages, nowhere, starts, segment)
            if not done and not self._halve(segment, begin, 0.5 * size, left - 1):
                return False
        return True

    def _frames(self, segment: Segment, starts: Array, stages: tuple[StageNumbers, ...]) -> Any:
        """Terms of the moving frame and inputs for every stage of steps inside one segment."""
        into = np.cumsum([0.0, *(stage.size for stage in stages[:-1])])
        offsets = into + np.array([stage.evaluation * stage.size for stage in stages])
        instants = (starts[:, None] + offsets).ravel()
        frame = frame_terms(self.problem.coupling, self.moments, segment, instants, self.rom.size)
        return self._pushed(frame, instants, segment.end)

    def _frame(self, segment: Segment, time: float, before: float = np.inf) -> FrameTerms:
        """Terms of the moving frame and inputs at one instant."""
        frame = frame_at(self.problem.coupling, self.moments, segment.motion(time), self.rom.size)
        return self._pushed(frame, np.array([time]), before)

    def _pushed(self, frame: FrameTerms, times: Array, before: float) -> FrameTerms:
        """FrameTerms terms less the inputs at the given instants; a jump at ``before`` is not met yet."""
        if not self.inputs:
            return frame
        forces = self.inputs.loads(times, before)
        frame = frame._replace(load=frame.load - forces @ self.rom.basis.kept.T)
        if not len(self.rom.basis.derivatives):
            return frame
        return frame._replace(stress=frame.stress - forces @ self.rom.monomial_vectors.T)

    def _balance(self, frame: FrameTerms) -> None:
        """Acceleration that balances all forces at the present state."""
        work = self._work
        total_force(self.arrays, frame, 0, work.q, work.v, work.forces)
        work.a[:] = -np.linalg.solve(self.arrays.mass, work.forces)
        work.jerk[:] = 0.0
        if self._explicit:
            stress, other = np.empty(len(self.arrays.first)), np.empty(self.rom.size)
            derivative_forces(self.arrays, frame, 0, work.q, work.v, stress, other)
            internal_force(self.arrays, work.q, work.v, stress, work.forces)

    def _check_step(self, time_step: float) -> None:
        """Raise InputError if the step [s] of an explicit method is not stable at the start of the run."""
        stiffness = tangent(self.arrays, self._work.q, np.zeros(len(self.arrays.first)))
        limit = 2.0 / float(np.sqrt(eigh(stiffness, self.arrays.mass, eigvals_only=True)[-1]))
        if time_step > limit:
            raise InputError(
                f"time_step: expected at most the stable step {limit:.3g} s of the explicit method, got {time_step:g}; "
                "use a smaller one, or an implicit method"
            )

    def _jump(self, current: int, time: float) -> None:
        """Let the rigid motion jump behind a segment; the acceleration takes up the change of the forces."""
        work, segments = self._work, self.segments
        before, after = np.empty(self.rom.size), np.empty(self.rom.size)
        total_force(self.arrays, self._frame(segments[current], time, time), 0, work.q, work.v, before)
        total_force(self.arrays, self._frame(segments[current + 1], time), 0, work.q, work.v, after)
        change = after - before
        if change.any():
            if not self._explicit:
                work.forces[:] += change
            work.a[:] -= np.linalg.solve(self.arrays.mass, change)
            work.jerk[:] = 0.0
            self.books.restart()

    def _equilibrium(self, motion: RigidMotion) -> Array:
        """Steady equilibrium of the coordinates under a constant motion, by Newton's method, shape (r,)."""
        frame = frame_at(self.problem.coupling, self.moments, motion, self.rom.size)
        q, v = np.zeros(self.rom.size), np.zeros(self.rom.size)
        if not (frame.load.any() or frame.turns):
            return q
        force = np.empty(self.rom.size)
        for _ in range(50):
            total_force(self.arrays, frame, 0, q, v, force)
            scale = max(float(np.linalg.norm(frame.load)), 1e-300)
            if float(np.linalg.norm(force)) <= 1e-9 * scale:
                return q
            q = q - np.linalg.solve(self._stiffness(q, frame), force)
        raise NotConvergedError(
            "spinning equilibrium of the reduced model: Newton's method failed; reduce the angular rate or raise the "
            "pretension"
        )

    def _stiffness(self, q: Array, frame: FrameTerms) -> Array:
        """``K_tan(q) + K_T`` of a steady motion on the coordinates, shape (r, r)."""
        stress, other = np.empty(len(self.arrays.first)), np.empty(self.rom.size)
        derivative_forces(self.arrays, frame, 0, q, np.zeros(self.rom.size), stress, other)
        return tangent(self.arrays, q, stress) + np.einsum("ab,abij->ij", frame.displacement[0], self.arrays.turning)

    def _imperfection(self, q: Array) -> Array:
        """Offset from the equilibrium, shape (r,); warns of motion that grows out of it, as `find_instability` does."""
        frame = frame_at(self.problem.coupling, self.moments, self._began, self.rom.size)
        stiffness, mass = self._stiffness(q, frame), self.arrays.mass
        values, vectors = eigh(0.5 * (stiffness + stiffness.T), mass)
        shape, count = vectors[:, 0], int(np.sum(values < -_ROUND_OFF * np.abs(values).max()))
        if count:
            velocity = self.arrays.damping + np.einsum("ab,abij->ij", frame.velocity[0], self.arrays.turning)
            down = -np.linalg.solve(mass, np.hstack([stiffness, velocity]))
            roots, motions = np.linalg.eig(np.vstack([np.eye(len(q), 2 * len(q), len(q)), down]))
            fastest = int(roots.real.argmax())
            if roots[fastest].real > 1e-6 * np.sqrt(-values[0]):
                shape, rate = motions[: len(q), fastest].real, float(roots[fastest].real)
                grown = self.rom.displacement(shape)
                self.warnings.append(growth_text(self.rom.state, count, rate, grown, self._began))
        largest = largest_translation(self.rom.state, self.rom.displacement(shape))
        return self.problem.initial_imperfection / largest * shape if largest else np.zeros(len(q))

    def complete(self, data: xr.Dataset, place: Indices) -> xr.Dataset:
        """The record with what else is known of samples with these places among the stored ones."""
        return data

    def frame_now(self, time: float) -> FrameTerms:
        """Terms of the moving frame and inputs at a sample."""
        return self._frame(self.segments[int(_place(self.segments, np.array([time]))[0])], time)

    def motions(self, times: Array) -> Array:
        """Angular velocity, angular acceleration and origin acceleration at instants, shape (time, 9)."""
        result = np.empty((len(times), 9))
        place = _place(self.segments, times)
        for number in np.unique(place):
            here = place == number

            def at(time: float, segment: Segment = self.segments[number]) -> Array:
                now = segment.motion(time)
                return np.concatenate([now.angular_velocity, now.angular_acceleration, now.origin_acceleration])

            result[here] = sample(at, times[here])
        return result

    def prescribed_offset(self, motions: Array) -> Array:
        """Static derivatives prescribed by the inertial load, shape (time, p)."""
        factor = self.problem.coupling.load_factor
        if factor == 0.0 or not motions.any():
            return np.zeros((len(motions), self._offsets.size))
        spin, turn = cross_matrices(motions[:, :3]), cross_matrices(motions[:, 3:6])
        return factor * self._offsets.load(turn + spin @ spin, motions[:, 6:])

    def read(self, probes: Any, eta: Array, rate: Array, motions: Array) -> Array:
        """Displacements and velocities of probes, shape (time, 2, probe, 3)."""
        if not probes.names:
            return np.zeros((len(eta), 2, 0, 3))
        place, speed = self.rom.seen(probes.map, eta, rate, self.prescribed_offset(motions))
        return np.stack([place, speed], axis=1).reshape(len(eta), 2, -1, 3)


def _place(segments: tuple[Segment, ...], times: Array) -> Indices:
    """Number of the segment of each instant; a limit belongs to the segment after it."""
    slack = 1e-9 * max(1.0, float(times[-1]))
    return np.searchsorted([segment.start - slack for segment in segments], times, side="right") - 1
