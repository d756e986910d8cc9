"""One run of a reduced model: its start, its steps, and what is read from it."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import xarray as xr
from scipy.linalg import eigh

from tautflex.errors import InputError, UnsupportedError
from tautflex.mechanics.inertia import WeighedMoments
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.kinematics import RigidMotion, Segment, split_segments
from tautflex.numeric import Array, Indices, cross_matrices
from tautflex.reduction.inputs import ReducedInputs
from tautflex.reduction.marching.beginning import Beginning
from tautflex.reduction.marching.books import ReducedBooks, Start
from tautflex.reduction.marching.dispatch import internal_force, tangent
from tautflex.reduction.marching.frame_terms import BLOCK, Span, frame_at, frame_terms, sample
from tautflex.reduction.marching.schedule import Stretch, segment_numbers, stretches
from tautflex.reduction.marching.steps import march, march_explicit
from tautflex.reduction.marching.work import LOOKED, StageNumbers, Work, new_work, stage_numbers
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import FrameTerms, derivative_forces, energies, rows_from, total_force
from tautflex.solvers.remembering import Memory
from tautflex.solvers.transient.accuracy.between import doubts_about_inputs
from tautflex.solvers.transient.accuracy.books import STRESS
from tautflex.solvers.transient.accuracy.energy import Energies, energy_balance, frame_twist
from tautflex.solvers.transient.free_hub.momentum import Body, carried_energy
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.methods.generalized_alpha import Newmark
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import Progress, TransientProblem
from tautflex.solvers.transient.status import Statistics


class ReducedRun:
    """State and record of a run.

    Raises UnsupportedError if adaptive steps or an unknown explicit method are asked for, or an input is not linear
    in a few numbers.
    """

    on_hub: ClassVar[bool] = False  # whether the motion of the hub is part of the answer

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
        self.inputs = ReducedInputs(rom, InputSet(rom.state.system, problem.inputs))
        self._looked = rom.looked(problem.placed.map, self.inputs.answers)
        self.arrays, kinds = self.inputs.arrays(problem.damping), problem.coupling.load_by_kind
        c = rom.coefficients if kinds is None else rom.weighed(kinds)
        self.moments = WeighedMoments(np.concatenate([c.load, c.load_stress], axis=1))
        self._offsets = WeighedMoments(c.follow_load)
        self._began, self.segments = self._plan(problem.maneuver)
        self._tolerance = problem.tolerance or self._method.tolerance
        # Numbers of the grid instants whose coordinates are kept, sorted.
        kept = problem.stored_steps, sorted(problem.field_steps), sorted(problem.frame_steps)
        self.stored = np.unique(np.concatenate([np.asarray(each, dtype=np.int64) for each in kept]))
        self.eta, self.rate = np.zeros((2, len(self.stored), rom.size))
        self.reached, self.halvings = problem.begin, 0
        self._work = new_work(rom.size, self._method.tangents)
        self._march = march_explicit if self._explicit else march
        beta = float(problem.damping.matrix(rom.state.linear).stiffness)
        self.warnings = [*problem.doubts, *doubts_about_inputs(self.inputs.given, problem)]
        self.warnings += self.inputs.doubts(problem.count * problem.time_step, beta)
        self.books = ReducedBooks(rom, self.arrays, self.inputs, problem.time_error)
        self.first: Energies | None = None
        self.first_stored = self.largest = 0.0
        self.before = self._work.counts.copy()
        self._trace = np.empty((0, 8, rom.size))

    def _plan(self, maneuver: Any) -> tuple[RigidMotion, tuple[Segment, ...]]:
        """Motion at the start, and smooth segments of the motion and the inputs."""
        return maneuver.start(), split_segments(maneuver.segments(), self.inputs.breaks)

    @property
    def time(self) -> float:
        """Instant that the steps have come to [s]."""
        return self.problem.instant(self.reached)

    def energies(self, times: Array, eta: Array, rate: Array) -> Array:
        """Kinetic and strain energy at instants [s] [J], shape (time, 2)."""
        found = energies(self.arrays, eta, rate)
        found[:, 1] += self.inputs.stored(self.arrays, eta, times)
        return found

    def balance(self) -> dict[str, float]:
        """Energy balance from the start to where the steps have come [J]."""
        assert self.first is not None
        work = self.books.work.copy()
        if not self.rom.in_elements:
            # The steps' books have what stresses of inputs do as the work of a load.
            work[STRESS] += self.stored_now() - self.first_stored
        return energy_balance(self.first, self._energies_now(), work, self.on_hub)

    def stored_now(self) -> float:
        """What stresses of inputs add to the strain energy where the steps have come to [J]."""
        return float(self.inputs.stored(self.arrays, self._work.q[None], np.array([self.time]))[0])

    def _energies_now(self) -> Energies:
        """Energies where the steps have come to."""
        work, body = self._work, tuple(Body.of(self.rom.state.system.inertia, None))
        q, v = self.motion_at(self.time, work.q, work.v)
        elastic, strain = self.energies(np.array([self.time]), work.q[None], work.v[None])[0]
        twist = frame_twist(self.problem.maneuver, self.segments, self.time)
        return Energies(elastic, carried_energy(body, q, v, twist), strain)

    def motion_at(self, time: float, eta: Array, rate: Array) -> tuple[Array, Array]:
        """Free unknowns and their velocities of coordinates at an instant [s], shape (size,)."""
        offset = self.prescribed_offset(self.motions(np.array([time])))[0]
        q, v, _ = self.rom.motion(eta, rate, rate, offset)
        return q + self.inputs.answer(np.array([time]))[0], v

    @property
    def idle(self) -> list[str]:
        """What to know about inputs that move nothing."""
        return self.inputs.given.idle()

    @property
    def work(self) -> Work:
        """What survives from step to step."""
        return self._work

    @property
    def statistics(self) -> Statistics:
        """Work done so far."""
        taken, iterations, renewals, evaluations = map(int, (self._work.counts - self.before)[:4])
        return Statistics(taken, iterations, renewals, iterations, evaluations, self.halvings)

    def start(self) -> None:
        """Steady spinning equilibrium and projected velocity, or those another run ended with; accelerations follow."""
        work, initial = self._work, self.problem.initial
        if initial is None:
            beginning = self.beginning(self._began)
            work.q[:] = beginning.equilibrium()
            offset, found = beginning.imperfection(work.q.copy(), self.problem.initial_imperfection)
            work.q[:] += offset
            self.warnings += found
            work.v[:] = self.rom.coordinates(self.problem.velocity)
        else:
            work.q[:], work.v[:] = self.rom.coordinates(np.stack([initial.displacement, initial.velocity]))
        self._begin()
        self.first, self.first_stored = self._energies_now(), self.stored_now()
        if initial is None:
            self._keep(0)
        if self._explicit:
            limit, asked, on_hub = self.stable_step(), self.problem.time_step, " on this hub" * self.on_hub
            if asked > limit:
                raise InputError(
                    f"time_step: expected at most the stable step {limit:.3g} s of the explicit method{on_hub}, got "
                    f"{asked:g}; use a smaller one, or an implicit method"
                )

    def beginning(self, motion: RigidMotion) -> Beginning:
        """Where the coordinates begin under a constant motion."""
        return Beginning(self.rom, self.arrays, self.problem.coupling, self.moments, motion)

    def _begin(self) -> None:
        """Accelerations at the start."""
        self._balance(self._frame(self.segments[self._current], self.time))

    def _keep(self, row: int) -> None:
        """Store the present state."""
        self.eta[row], self.rate[row] = self._work.q, self._work.v

    @property
    def _current(self) -> int:
        """Number of the segment where the next step starts."""
        reached = self.time * (1.0 + 1e-12)
        return min(sum(segment.end <= reached for segment in self.segments), len(self.segments) - 1)

    def pushed(self) -> Memory:
        """What acts where the steps have come to."""
        return {"balance": self._forces_now()[0]}

    def meet(self, memory: Memory) -> None:
        """Let accelerations take up what acts else than where another run stood."""
        forces, frame = self._forces_now()
        self._take_up(forces - memory["balance"], frame)

    def _forces_now(self) -> tuple[Array, FrameTerms]:
        """All forces but inertia where the steps have come to, shape (r,), and their frame terms."""
        force = np.empty(self.rom.size)
        frame = self._frame(self.segments[self._current], self.time)
        total_force(self.arrays, frame, 0, self._work.q, self._work.v, force)
        return force, frame

    def advance(self, number: int, progress: Progress = None) -> bool:
        """Take the steps to an instant of the grid; whether it was reached."""
        problem, segments, current = self.problem, self.segments, self._current
        for stretch in stretches(segments, problem.time_step, self.reached, number, problem.shift):
            while current < stretch.segment:
                self._jump(segments[current], segments[current + 1], float(stretch.starts[0]))
                current += 1
            if not self._march_stretch(segments[current], stretch):
                return False
            if progress is not None:
                progress((self.reached - problem.begin) / (problem.count - problem.begin), f"t = {self.time:.3g} s")
        if current < self._current:
            self._jump(segments[current], segments[current + 1], self.time)
        return True

    def renew(self) -> None:
        """Meet a change of inputs that were set anew where the steps have come to."""
        segment = self.segments[self._current]
        self._jump(segment, segment, self.time)

    def _march_stretch(self, segment: Segment, stretch: Stretch) -> bool:
        """Steps of equal size; those that fail are halved."""
        stages = stage_numbers(self._method, stretch.size)
        frame = self._frames(segment, stretch.starts, stages, stretch.span)
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
        ends = trace[len(stages) - 1 : done * len(stages) : len(stages), 0]
        self._restress_steps(start.q, ends, starts[:done], stages[0].step, segment)
        return int(done)

    def _restress_steps(self, q: Array, ends: Array, starts: Array, step: float, segment: Segment) -> None:
        """Book what stresses in elements add in steps from q to ``ends``, at the middle of each."""
        if len(ends) and self.rom.in_elements:
            before = np.concatenate([q[None], ends[:-1]])
            self._restress(0.5 * (ends + before), starts, starts + step, segment.end)

    def _restress(self, q: Array, starts: Array, ends: Array, before: float, jump: float = np.inf) -> None:
        """Book what stresses in elements add to the strain energy of coordinates (n, r) between instants [s]."""
        if self.rom.in_elements and self.inputs.columns:
            stored = self.inputs.stored
            added = stored(self.arrays, q, ends, before) - stored(self.arrays, q, starts, jump)
            self.books.work[STRESS] += added.sum()

    def _rows(self, grid: Indices) -> Indices:
        """Where each grid instant is stored; -1: nowhere."""
        place = np.minimum(np.searchsorted(self.stored, grid), len(self.stored) - 1)
        return np.where(self.stored[place] == grid, place, -1)

    def _halve(self, segment: Segment, start: float, size: float, left: int) -> bool:
        """One failed step as two of half its size."""
        if left == 0:
            return False
        self.halvings += 1
        stages, nowhere = stage_numbers(self._method, 0.5 * size), np.full(1, -1)
        for begin in (start, start + 0.5 * size):
            starts = np.array([begin])
            self._work.counts[LOOKED] = 0
            done = self._steps(self._frames(segment, starts, stages), stages, nowhere, starts, segment)
            if not done and not self._halve(segment, begin, 0.5 * size, left - 1):
                return False
        self._work.counts[LOOKED] = 0
        return True

    def _frames(
        self, segment: Segment, starts: Array, stages: tuple[StageNumbers, ...], span: Span | None = None
    ) -> Any:
        """Terms of the moving frame and inputs for every stage of steps inside one segment, sampled over a span."""
        into = np.cumsum([0.0, *(stage.size for stage in stages[:-1])])
        offsets = into + np.array([stage.evaluation * stage.size for stage in stages])
        instants = (starts[:, None] + offsets).ravel()
        low, high, count = span or (starts[0], starts[-1], len(starts))
        span = low + offsets[0], high + offsets[-1], count * len(stages)
        frame = frame_terms(self.problem.coupling, self.moments, segment, instants, self.rom.size, span)
        return self._pushed(frame, instants, segment.end)

    def _frame(self, segment: Segment, time: float, before: float = np.inf) -> FrameTerms:
        """Terms of the moving frame and inputs at one instant."""
        frame = frame_at(self.problem.coupling, self.moments, segment.motion(time), self.rom.size)
        return self._pushed(frame, np.array([time]), before)

    def _pushed(self, frame: FrameTerms, times: Array, before: float) -> FrameTerms:
        """FrameTerms terms less the inputs at the given instants; a jump at ``before`` is not met yet."""
        if not self.inputs:
            return frame
        load, given = self.inputs.forces(times, before)
        return frame._replace(load=frame.load + load, stress=given if self.rom.in_elements else frame.stress + given)

    def _balance(self, frame: FrameTerms) -> None:
        """Acceleration that balances all forces at the present state."""
        work = self._work
        total_force(self.arrays, frame, 0, work.q, work.v, work.forces)
        work.a[:] = -np.linalg.solve(self.arrays.mass, work.forces)
        work.jerk[:] = 0.0
        if self._explicit:
            self._recall(frame)

    def _recall(self, frame: FrameTerms) -> None:
        """Internal force at the present state, which an explicit step compares with that at its end."""
        work = self._work
        stress, other = np.empty(frame.stress.shape[1]), np.empty(self.rom.size)
        derivative_forces(self.arrays, frame, 0, work.q, work.v, stress, other)
        internal_force(self.arrays, work.q, work.v, stress, work.forces)

    def stable_step(self) -> float:
        """Longest stable step of an explicit method [s] where the steps have come to."""
        return 2.0 / float(np.sqrt(self._stiffest()))

    def _stiffest(self) -> float:
        """Largest squared angular frequency of the coordinates at the present state [1/s^2]."""
        stiffness = tangent(self.arrays, self._work.q, np.zeros(len(self.arrays.first)))
        return float(eigh(stiffness, self.arrays.mass, eigvals_only=True)[-1])

    def _jump(self, ended: Segment, begun: Segment, time: float) -> None:
        """Let the rigid motion and inputs jump; the acceleration takes up the change of the forces."""
        work = self._work
        work.counts[LOOKED] = 0
        before, after = np.empty(self.rom.size), np.empty(self.rom.size)
        frame, at = self._frame(begun, time), np.array([time])
        total_force(self.arrays, self._frame(ended, time, time), 0, work.q, work.v, before)
        total_force(self.arrays, frame, 0, work.q, work.v, after)
        if np.any(after != before):
            self._restress(work.q[None], at, at, np.inf, time)
            self._take_up(after - before, frame)

    def _take_up(self, change: Array, frame: FrameTerms) -> None:
        """Let the acceleration take up a change of the forces, which are those of a frame now."""
        work = self._work
        if change.any():
            if self._explicit:
                self._recall(frame)
            else:
                work.forces[:] += change
            work.a[:] -= np.linalg.solve(self.arrays.mass, change)
            work.jerk[:] = 0.0
            self.books.restart()

    def frame_now(self, time: float) -> FrameTerms:
        """Terms of the moving frame and inputs at a sample."""
        return self._frame(self.segments[int(segment_numbers(self.segments, np.array([time]))[0])], time)

    def motions(self, times: Array) -> Array:
        """Angular velocity, angular acceleration and origin acceleration at instants, shape (time, 9)."""
        result = np.empty((len(times), 9))
        place, step = segment_numbers(self.segments, times), self.problem.every * self.problem.time_step
        block = np.floor((times - self.problem.shift) / (BLOCK * step) + 1e-9).astype(np.int64)
        cuts = np.flatnonzero((np.diff(place) != 0) | (np.diff(block) != 0)) + 1
        for here in filter(len, np.split(np.arange(len(times)), cuts)):
            which, segment = int(block[here[0]]), self.segments[place[here[0]]]
            low, high = self.problem.shift + BLOCK * step * np.array([which, which + 1])
            low, high = max(float(low), segment.start), min(float(high), segment.end)

            def at(time: float, segment: Segment = segment) -> Array:
                now = segment.motion(time)
                return np.concatenate([now.angular_velocity, now.angular_acceleration, now.origin_acceleration])

            result[here] = sample(at, times[here], (low, high, int((high - low) / step + 1.5)))
        return result

    def prescribed_offset(self, motions: Array) -> Array:
        """Static derivatives prescribed by the inertial load, shape (time, p)."""
        if (factor := self.problem.coupling.load_factor) == 0.0 or not motions.any():
            return np.zeros((len(motions), self._offsets.size))
        spin, turn = cross_matrices(motions[:, :3]), cross_matrices(motions[:, 3:6])
        return factor * self._offsets.load(turn + spin @ spin, motions[:, 6:])

    def read(self, times: Array, eta: Array, rate: Array, motions: Array) -> Array:
        """Displacements and velocities of probes, shape (time, 2, probe, 3)."""
        seen = self.rom.seen(self._looked, eta, rate, self.prescribed_offset(motions), self.inputs.stresses(times))
        return np.stack(seen, axis=1).reshape(len(eta), 2, len(self.problem.placed.names), 3)

    def complete(self, data: xr.Dataset, place: Indices) -> xr.Dataset:
        """The record with what else is known of samples with these places among the stored ones."""
        return data

    def hub_at(self, time: float, eta: Array, rate: Array) -> Array:
        """Free hub at a stored instant or where the steps have come to, shape (31,); (0,): there is none."""
        return np.zeros(0)
