"""One run of a reduced model: its start, its steps, and what is read from it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from tautflex.errors import InputError, NotConvergedError, UnsupportedError
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment
from tautflex.reduction.marching import steps
from tautflex.reduction.marching.dispatch import internal_force, tangent
from tautflex.reduction.marching.frame_terms import ReducedMoments, frame_at, frame_terms, sample
from tautflex.reduction.marching.loads import InputLoads
from tautflex.reduction.marching.schedule import Stretch, stretches
from tautflex.reduction.polynomial.forces import Frame, derivative_forces, rows_from, total_force
from tautflex.solvers.transient.explicit import CentralDifference
from tautflex.solvers.transient.methods.scheme import ExplicitMethod, ImplicitMethod
from tautflex.solvers.transient.status import Statistics

if TYPE_CHECKING:
    from tautflex.reduction.on_basis import OnBasis

Array = NDArray[np.float64]

# Steps between two looks at the keyboard and the progress bar; bounds the memory of sampled frame terms.
_LONGEST = 4096


class ReducedFlight:
    """State and record of a run.

    Parameters
    ----------
    rom
        Reduced model.
    method
        Implicit method, or central differences.
    damping, coupling, inputs
        As for `simulate`.
    tolerance
        Newton tolerance; None takes the method's.
    stored
        Numbers of the grid instants whose coordinates are kept, sorted, the first is 0.
    """

    def __init__(
        self,
        rom: OnBasis,
        method: ImplicitMethod | ExplicitMethod,
        damping: Rayleigh,
        coupling: Coupling,
        inputs: Sequence[TimeInput],
        tolerance: float | None,
        stored: NDArray[np.int64],
    ) -> None:
        self.rom, self.method, self.coupling, self.damping = rom, method, coupling, damping
        self.plant = rom.plant(damping)
        c = rom.coefficients
        self.moments = ReducedMoments(c.first, c.zeroth)
        self.inputs = InputLoads(rom, InputSet(rom.state.system, inputs))
        self.explicit = not hasattr(method, "scheme")
        if self.explicit and not isinstance(method, CentralDifference):
            raise UnsupportedError(f"method: expected an implicit method or CentralDifference(), got {method!r}")
        self.tolerance = tolerance or (1.0 if self.explicit else _implicit(method).scheme(1.0).tolerance)
        self.stored = stored
        self.eta, self.rate = np.zeros((2, len(stored), rom.size))
        self.reached = 0
        r = rom.size
        self._work = steps.new_work(r)
        self._march = steps.march_explicit if self.explicit else steps.march
        self._halvings = 0

    @property
    def statistics(self) -> Statistics:
        """Work done so far."""
        taken, iterations, renewals, evaluations = (int(count) for count in self._work.counts)
        return Statistics(taken, iterations, renewals, iterations, evaluations, self._halvings)

    def start(self, maneuver: Maneuver, segments: tuple[Segment, ...], velocity: Array) -> None:
        """Steady spinning equilibrium, projected velocity, and the acceleration that follows."""
        work = self._work
        work.q[:] = self._equilibrium(maneuver.start())
        work.v[:] = self.rom.coordinates(velocity)
        self._balance(self._frame(segments[0], 0.0))
        self.eta[0], self.rate[0] = work.q, work.v

    def fly(
        self,
        segments: tuple[Segment, ...],
        step: float,
        count: int,
        halvings: int,
        progress: Callable[[float, str], None] | None,
    ) -> bool:
        """Take all steps; whether the end was reached."""
        current = 0
        for stretch in stretches(segments, step, count, _LONGEST):
            while current < stretch.segment:
                self._jump(segments, current, float(stretch.starts[0]))
                current += 1
            if not self._fly_stretch(segments[current], stretch, halvings):
                return False
            if progress is not None:
                progress(self.reached / count, f"t = {self.reached * step:.3g} s")
        if current + 1 < len(segments) and segments[current].end <= count * step * (1.0 + 1e-12):
            self._jump(segments, current, count * step)
        return True

    def _fly_stretch(self, segment: Segment, stretch: Stretch, halvings: int) -> bool:
        """Steps of equal size; those that fail are halved."""
        scheme = self._scheme(stretch.size)
        instants = stretch.starts + scheme.evaluation * stretch.size
        frame = self.inputs.added(
            frame_terms(self.coupling, self.moments, segment, instants, self.rom.size), instants, segment.end
        )
        rows = self._rows(stretch.grid)
        first = 0
        while first < len(rows):
            part, stored = rows_from(frame, first), (self.eta, self.rate)
            first += self._march(self.plant, part, scheme, self._work, rows[first:], stored, self.tolerance)
            if first < len(rows):
                if not self._halve(segment, float(stretch.starts[first]), stretch.size, halvings):
                    self._note(stretch.grid[:first])
                    return False
                if rows[first] >= 0:
                    self.eta[rows[first]], self.rate[rows[first]] = self._work.q, self._work.v
                first += 1
        self._note(stretch.grid)
        return True

    def _note(self, grid: NDArray[np.int64]) -> None:
        self.reached = max(self.reached, int(grid.max(initial=0)))

    def _rows(self, grid: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where each grid instant is stored; -1: nowhere."""
        place = np.minimum(np.searchsorted(self.stored, grid), len(self.stored) - 1)
        return np.where(self.stored[place] == grid, place, -1)

    def _halve(self, segment: Segment, start: float, size: float, left: int) -> bool:
        """One failed step as two of half its size."""
        if left == 0:
            return False
        self._halvings += 1
        scheme, stored = self._scheme(0.5 * size), (self.eta, self.rate)
        nowhere = np.full(1, -1)
        for begin in (start, start + 0.5 * size):
            instant = np.array([begin + scheme.evaluation * 0.5 * size])
            frame = frame_terms(self.coupling, self.moments, segment, instant, self.rom.size)
            frame = self.inputs.added(frame, instant, segment.end)
            done = self._march(self.plant, frame, scheme, self._work, nowhere, stored, self.tolerance)
            if not done and not self._halve(segment, begin, 0.5 * size, left - 1):
                return False
        return True

    def _scheme(self, size: float) -> steps.Coefficients:
        return (
            steps.EXPLICIT._replace(size=size)
            if self.explicit
            else steps.coefficients(_implicit(self.method).scheme(size), size)
        )

    def _frame(self, segment: Segment, time: float, before: float = np.inf) -> Frame:
        """Terms of the moving frame and inputs at one instant."""
        frame = frame_at(self.coupling, self.moments, segment.motion(time), self.rom.size)
        return self.inputs.added(frame, np.array([time]), before)

    def _balance(self, frame: Frame) -> None:
        """Acceleration that balances all forces at the present state."""
        work = self._work
        total_force(self.plant, frame, 0, work.q, work.v, work.forces)
        work.a[:] = -np.linalg.solve(self.plant.mass, work.forces)
        work.numbers[2] = 0.0
        if self.explicit:
            stress, other = np.empty(len(self.plant.first)), np.empty(self.rom.size)
            derivative_forces(self.plant, frame, 0, work.q, work.v, stress, other)
            internal_force(self.plant, work.q, work.v, stress, work.forces)

    def check_step(self, time_step: float) -> None:
        """Raise InputError if the step [s] of an explicit method is not stable at the start of the run."""
        if not self.explicit:
            return
        stiffness = tangent(self.plant, self._work.q, np.zeros(len(self.plant.first)))
        limit = 2.0 / float(np.sqrt(eigh(stiffness, self.plant.mass, eigvals_only=True)[-1]))
        if time_step > limit:
            raise InputError(
                f"time_step: expected at most the stable step {limit:.3g} s of the explicit method, got {time_step:g}; "
                "use a smaller one, or an implicit method"
            )

    def _jump(self, segments: tuple[Segment, ...], current: int, time: float) -> None:
        """Let the rigid motion jump; the acceleration takes up the change of the forces."""
        work = self._work
        before, after = np.empty(self.rom.size), np.empty(self.rom.size)
        total_force(self.plant, self._frame(segments[current], time, time), 0, work.q, work.v, before)
        total_force(self.plant, self._frame(segments[current + 1], time), 0, work.q, work.v, after)
        change = after - before
        if change.any():
            if not self.explicit:
                work.forces[:] += change
            work.a[:] -= np.linalg.solve(self.plant.mass, change)
            work.numbers[2] = 0.0

    def _equilibrium(self, motion: RigidMotion) -> Array:
        """Steady equilibrium of the coordinates under a constant motion, by Newton's method, shape (r,)."""
        frame = frame_at(self.coupling, self.moments, motion, self.rom.size)
        q, v = np.zeros(self.rom.size), np.zeros(self.rom.size)
        stress, other = np.empty(len(self.plant.first)), np.empty(self.rom.size)
        if not (frame.load.any() or frame.turns):
            return q
        turning = np.einsum("ab,abij->ij", frame.displacement[0], self.plant.turning)
        force = np.empty(self.rom.size)
        for _ in range(50):
            total_force(self.plant, frame, 0, q, v, force)
            scale = max(float(np.linalg.norm(frame.load)), 1e-300)
            if float(np.linalg.norm(force)) <= 1e-9 * scale:
                return q
            derivative_forces(self.plant, frame, 0, q, v, stress, other)
            q = q - np.linalg.solve(tangent(self.plant, q, stress) + turning, force)
        raise NotConvergedError(
            "spinning equilibrium of the reduced model: Newton's method failed; reduce the angular rate or raise the "
            "pretension"
        )

    def frame_now(self, segments: tuple[Segment, ...], time: float) -> Frame:
        """Terms of the moving frame and inputs at a sample."""
        return self._frame(segments[int(_place(segments, np.array([time]))[0])], time)

    def motions(self, segments: tuple[Segment, ...], times: Array) -> Array:
        """Angular velocity, angular acceleration and origin acceleration at instants, shape (time, 9)."""
        result = np.empty((len(times), 9))
        place = _place(segments, times)
        for number in np.unique(place):
            here = place == number
            motion = segments[number].motion

            def at(time: float, motion: Callable[[float], RigidMotion] = motion) -> Array:
                now = motion(time)
                return np.concatenate([now.angular_velocity, now.angular_acceleration, now.origin_acceleration])

            result[here] = sample(at, times[here])
        return result

    def pulled(self, motions: Array) -> Array:
        """Companions held off by the inertial load, shape (time, p)."""
        c = self.rom.coefficients
        if not self.coupling.inertial_load or not motions.any():
            return np.zeros((len(motions), len(c.follow_linear)))
        spin, turn = _cross(motions[:, :3]), _cross(motions[:, 3:6])
        weight = turn + spin @ spin
        return np.einsum("tab,abp->tp", weight, c.follow_first) + motions[:, 6:] @ c.follow_zeroth

    def read(self, probes: Any, eta: Array, rate: Array, motions: Array) -> Array:
        """Displacements and velocities of probes, shape (time, 2, probe, 3)."""
        if not probes.names:
            return np.zeros((len(eta), 2, 0, 3))
        place, speed = self.rom.seen(probes.map, eta, rate, self.pulled(motions))
        return np.stack([place, speed], axis=1).reshape(len(eta), 2, -1, 3)


def _implicit(method: ImplicitMethod | ExplicitMethod) -> ImplicitMethod:
    return cast(ImplicitMethod, method)


def _place(segments: tuple[Segment, ...], times: Array) -> NDArray[np.int64]:
    """Number of the segment of each instant; a limit belongs to the segment after it."""
    slack = 1e-9 * max(1.0, float(times[-1]))
    return np.searchsorted([segment.start - slack for segment in segments], times, side="right") - 1


def _cross(vectors: Array) -> Array:
    """Cross-product matrices, shape (n, 3) -> (n, 3, 3)."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    return np.stack([none, -z, y, z, none, -x, -y, x, none], axis=1).reshape(-1, 3, 3)
