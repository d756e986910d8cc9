"""One run of a reduced model on a free hub."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import xarray as xr

from tautflex.mechanics.loads.inputs import earlier
from tautflex.mechanics.loads.prepared import FollowerForce
from tautflex.mechanics.loads.signals import Held
from tautflex.motion import rotations
from tautflex.motion.hub import FreeHub, HubState
from tautflex.motion.kinematics import AtRest, RigidMotion, Segment, split_segments
from tautflex.numeric import Array, Indices
from tautflex.reduction.inputs import Pressed
from tautflex.reduction.marching.books import Start
from tautflex.reduction.marching.frame_terms import Span, frame_at
from tautflex.reduction.marching.free_hub import hub_implicit, hub_mobile, hub_steps
from tautflex.reduction.marching.free_hub.hub_arrays import HubInputs, hub_arrays, inputs_from
from tautflex.reduction.marching.free_hub.hub_inertia import MOMENTUM, WRENCH, new_place
from tautflex.reduction.marching.free_hub.hub_work import DONE, new_hub_work
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.marching.work import StageNumbers
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import FrameTerms
from tautflex.solvers.remembering import Memory, copied
from tautflex.solvers.transient.accuracy.energy import Energies
from tautflex.solvers.transient.free_hub.balance import rigid_parts
from tautflex.solvers.transient.free_hub.record import check_coupling, hub_variables, steady_motion
from tautflex.solvers.transient.problem import TransientProblem

# What of the hub's work the next step depends on.
_KEPT = ("rigid", "balanced", "own", "now", "marks", "given", "last")
# Turns in which a torque that depends on the motion and the motion agree.
_MOST_TURNS = 50


class HubRun(ReducedRun):
    """State and record of a run on a free hub; see `ReducedRun`.

    Attributes
    ----------
    commanded
        Wrench on the hub that whoever drives holds, shape (6,); None: nobody does.
    """

    on_hub: ClassVar[bool] = True

    def __init__(self, rom: OnBasis, problem: TransientProblem) -> None:
        check_coupling(problem.coupling)
        assert isinstance(problem.maneuver, FreeHub)
        self.free = problem.maneuver
        super().__init__(rom, problem)
        self._tolerance = problem.tolerance or min(1e-9, self._method.tolerance)
        system, c = rom.state.system, rom.coefficients
        self.hub = hub_arrays(c, system.inertia, self.free, rom.size)
        self._whole = hub_arrays(c, system.inertia, self.free, rom.size, np.ones(6))
        given = len(self.inputs.answers) if rom.in_elements else rom.monomial_count
        self.ride = new_hub_work(self.hub, self.arrays.mass, given)
        # The steps enter their works themselves.
        self.books.work = self.ride.work
        self.rigid, self.outside = np.zeros((len(self.stored), 31)), np.zeros(len(self.stored))
        self._trace = np.empty((0, 3, rom.size))
        self.commanded: Held | None = None
        self._levers()
        self._pressed: list[tuple[Pressed, Array, Array]] = []

    def _levers(self) -> None:
        """Wrench of forces on the free unknowns at the reference, (size, 6), and per coordinate, (size, 3, r)."""
        system, kept = self.rom.state.system, self.rom.basis.kept
        model, size = system.model, system.size
        axes, wrench, arms = np.eye(3), np.zeros((size + 1, 6)), np.zeros((size + 1, 3, len(kept)))
        places = system.place[model.translation_dofs]
        moved = np.append(kept, np.zeros((len(kept), 1)), axis=1)[:, places]
        for a in range(3):
            wrench[places[:, a], a] = 1.0
            wrench[places[:, a], 3:] = np.cross(model.nodes, axes[a])
            arms[places[:, a]] = np.cross(moved, axes[a]).transpose(1, 2, 0)
        turning = np.flatnonzero(np.diff(model.dof_offset) == 6)
        wrench[system.place[model.dof_offset[turning][:, None] + np.arange(3, 6)], 3:] = axes
        self.to_wrench, self.to_arms = wrench[:-1], arms[:-1].reshape(size, -1)

    def _plan(self, maneuver: Any) -> tuple[RigidMotion, tuple[Segment, ...]]:
        """Motion at the start, and segments between jumps: the motion is not known beforehand."""
        segments = split_segments(AtRest().segments(), (*self.inputs.breaks, *maneuver.breaks))
        return steady_motion(maneuver, self.rom.state.system.inertia), segments

    @property
    def idle(self) -> list[str]:
        """None: forces on held nodes push the hub."""
        return []

    def _begin(self) -> None:
        """Hub and accelerations at the start."""
        hub, initial = rigid_parts(self.ride.rigid), self.problem.initial
        if initial is not None and initial.hub.size:
            self.ride.rigid[:] = initial.hub
            hub.rates[:] *= self.free.freedom
        else:
            hub.attitude[:] = np.asarray(self.free.attitude) / np.linalg.norm(self.free.attitude)
            hub.twist[:3] = rotations.matrix(hub.attitude).T @ np.asarray(self.free.velocity, dtype=float)
            hub.twist[3:] = self.free.angular_velocity
        hub_steps.start_hub(self.hub, self.arrays, self._work, self.ride)
        inputs = self._at(self.time, np.inf, self.ride.rigid)
        hub_steps.balance(self.arrays, self.hub, inputs, 0, self._work, self.ride, self._explicit)

    def inputs_at(self, times: Array, before: float) -> HubInputs:
        """What acts at instants but for feedback; a jump at ``before`` is not met yet."""
        rom, instants = self.rom, [earlier(float(time), before) for time in times]
        wrench = np.zeros((1, 6)) if self.free.feedback else self.free.wrench()[None]
        if self.commanded is not None:
            wrench = wrench + np.array([self.commanded(instant) for instant in instants])
        r, none = rom.size, (np.zeros((1, rom.size)), np.zeros((1, 0)))
        if not self.inputs:
            return HubInputs(none[0], np.zeros((1, self.ride.given.size)), *none, wrench, np.zeros((1, 3, r)))
        load, stress = self.inputs.forces(times, before)
        inside = none
        if self.inputs.columns and not rom.in_elements:
            pulled = self.inputs.stresses(times, before)
            inside = pulled @ self.inputs.beta, pulled @ self.inputs.stress
        given = self.inputs.given
        outside = np.array([given.outside_load(instant) for instant in instants])
        held = np.array([given.held_wrench(instant) for instant in instants])
        arms, wrench = (outside @ self.to_arms).reshape(-1, 3, r), wrench + held + outside @ self.to_wrench
        if self.inputs.followers:
            # Film that turns changes the force, too.
            arms = np.concatenate([np.zeros_like(arms), arms], axis=1)
            for row, instant in enumerate(instants):
                for film in given.followers(instant):
                    whole, slopes = self.pushed_by(film)
                    wrench[row], arms[row] = wrench[row] + whole, arms[row] + slopes
        return HubInputs(load, stress, *inside, wrench, arms)

    def pushed_by(self, film: FollowerForce) -> tuple[Array, Array]:
        """Force, and torque about O, of pressure at rest, shape (6,), and per coordinate, (6, r).

        As of the forces on the coordinates, this is what is constant and linear about rest.
        """
        size, pressed = self.inputs.pressed(film)
        for known, wrench, slopes in self._pressed:
            if known is pressed:
                return size * wrench, size * slopes
        system, kept = self.rom.state.system, self.rom.basis.kept
        found = pressed.unit.wrench(np.zeros(system.size)), pressed.unit.wrench_slopes(kept)
        self._pressed.append((pressed, *found))
        return size * found[0], size * found[1]

    def _at(self, time: float, before: float, rigid: Array, seen: Array | None = None) -> HubInputs:
        """What acts from outside at one instant with this hub and these coordinates and velocities, (2, r)."""
        inputs = self.inputs_at(np.array([time]), before)
        if not self.free.feedback:
            return inputs
        q, v = (self._work.q, self._work.v) if seen is None else seen
        return inputs._replace(wrench=inputs.wrench + self._fed(earlier(time, before), rigid, q, v))

    def _fed(self, time: float, rigid: Array, q: Array, v: Array) -> Array:
        """Force and torque on the hub of functions of time and motion, shape (6,)."""
        hub, probes = rigid_parts(rigid), self.problem.placed
        reading = np.zeros((2, 0, 3))
        if probes.names:
            motion = np.concatenate([hub.twist[3:], hub.rates[3:], hub.rates[:3]])[None]
            reading = self.read(np.array([time]), q[None], v[None], motion)[0]
        velocity = rotations.matrix(hub.attitude) @ hub.twist[:3]
        return self.free.wrench(
            HubState(time, hub.attitude.copy(), hub.twist[3:].copy(), hub.position.copy(), velocity, *reading)
        )

    def _frames(
        self, segment: Segment, starts: Array, stages: tuple[StageNumbers, ...], span: Span | None = None
    ) -> Any:
        """Inputs at the evaluation instants and at the ends of the stages of steps inside one segment."""
        into = np.cumsum([0.0, *(stage.size for stage in stages)])
        offsets = into[:-1] + np.array([stage.evaluation * stage.size for stage in stages])
        found = [self.inputs_at((starts[:, None] + each).ravel(), segment.end) for each in (offsets, into[1:])]
        return tuple(found)

    def _rest(self, frame: Any, first: int) -> Any:
        """Inputs from one instant on."""
        return tuple(inputs_from(inputs, first) for inputs in frame)

    def pushed(self) -> Memory:
        """What the hub's next step depends on, and what acts from outside now."""
        kept = {name: copied(getattr(self.ride, name)) for name in _KEPT}
        return {"ride": kept, "outside": copied(self._at(self.time, np.inf, self.ride.rigid))}

    def meet(self, memory: Memory) -> None:
        """Go on with the hub of another run; accelerations take up what acts else than there."""
        for name, part in memory["ride"].items():
            getattr(self.ride, name)[:] = part
        # The steps enter their works themselves.
        self.ride.work[:], self.books.work = self.books.work, self.ride.work
        before, after = HubInputs(**memory["outside"]), self._at(self.time, np.inf, self.ride.rigid)
        hub_steps.jump(self.arrays, self.hub, before, 0, after, 0, self._work, self.ride, self._explicit)

    def _keep(self, row: int) -> None:
        """Store the present state."""
        super()._keep(row)
        self.rigid[row], self.outside[row] = self.ride.rigid, self.ride.marks[DONE]

    def _steps(
        self, frame: Any, stages: tuple[StageNumbers, ...], rows: Indices, starts: Array, segment: Segment
    ) -> int:
        """Steps of equal size from these instants on; how many converged."""
        start = Start.of(self._work)
        if len(self._trace) < len(rows):
            self._trace = np.empty((len(rows), 3, self.rom.size))
        trace, stored = self._trace[: len(rows)], (self.eta, self.rate, self.rigid, self.outside)
        if self.free.feedback:
            done = self._fed_steps(frame, stages, rows, starts, segment, trace)
        elif self._explicit:
            done = hub_steps.march_explicit(
                self.arrays, self.hub, frame[1], stages[0].step, self._work, self.ride, rows, stored, trace
            )
        else:
            done = hub_implicit.march(
                self.arrays, self.hub, *frame, stages, self._work, self.ride, rows, stored, self._tolerance, trace
            )
        if done and self.books.errors is not None:
            self.books.add_errors(self.books.errors, trace[:done], start, stages[-1], starts[:done], segment)
        self._restress_steps(start.q, trace[:done, 0], starts[:done], stages[0].step, segment)
        return int(done)

    def _fed_steps(
        self, frame: Any, stages: tuple[StageNumbers, ...], rows: Indices, starts: Array, segment: Segment, trace: Array
    ) -> int:
        """As `_steps`, with functions of time and motion asked in every stage."""
        work, ride, none = self._work, self.ride, np.empty((0, 3, self.rom.size))
        stored, nowhere = (self.eta, self.rate, self.rigid, self.outside), np.full(1, -1)
        for n, start in enumerate(starts):
            before = [part.copy() for part in self._memory]
            time = float(start)
            for place, stage in enumerate(stages):
                work.passed[place] = work.state
                given = [inputs_from(inputs, len(stages) * n + place) for inputs in frame]
                if not self._fed_stage(given, stage, time, segment.end, (stored, nowhere, none)):
                    self._restore(before)
                    return n
                time += stage.size
            work.counts[0] += 0 if self._explicit else 1
            hub_steps.keep(work, ride, rows[n], stored, trace, n)
        return len(rows)

    @property
    def _memory(self) -> tuple[Any, ...]:
        """All that a stage changes and the next one reads."""
        work, ride = self._work, self.ride
        return work.state, ride.rigid, ride.balanced, ride.work, ride.own, ride.now, ride.marks, ride.last, work.counts

    def _restore(self, before: list[Array]) -> None:
        for part, old in zip(self._memory[:-1], before, strict=False):
            part[:] = old

    def _fed_stage(
        self, given: list[HubInputs], stage: StageNumbers, time: float, end: float, nowhere: tuple[Any, ...]
    ) -> bool:
        """One stage under forces of functions that agree with the motion they lead to, down to round-off."""
        work, ride, reach = self._work, self.ride, stage.evaluation * stage.size
        before, last = [part.copy() for part in self._memory], np.inf
        instants = [earlier(time + each, end) for each in (reach, stage.size)]
        guess = ride.rigid.copy()
        guess[7:13] += reach * guess[25:]
        fed = np.array([self._fed(instant, guess, work.q + reach * work.v, work.v) for instant in instants])
        for _ in range(_MOST_TURNS):
            inputs = [each._replace(wrench=each.wrench[:1] + own) for each, own in zip(given, fed, strict=True)]
            if self._explicit:
                stored, rows, none = nowhere
                done = hub_steps.march_explicit(
                    self.arrays, self.hub, inputs[1], stage.step, work, ride, rows, stored, none
                )
            else:
                done = hub_implicit.implicit_step(self.arrays, self.hub, *inputs, 0, stage, work, ride, self._tolerance)
            if not done:
                self._restore(before)
                return False
            then = self._fed(instants[1], ride.rigid, work.q, work.v)
            mid = then if self._explicit else self._fed(instants[0], ride.seen_hub, *ride.seen)
            new = np.array([mid, then])
            change = float(np.abs(new - fed).max())
            if not 1e-15 * float(np.abs(new).max()) < change < last:
                return True
            fed, last = new, change
            self._restore(before)
            work.counts[0] = before[-1][0]
        return False

    def _jump(self, ended: Segment, begun: Segment, time: float) -> None:
        """Let what acts from outside jump."""
        before, after = (self._at(time, limit, self.ride.rigid) for limit in (time, np.inf))
        work, ride, at = self._work, self.ride, np.array([time])
        if hub_steps.jump(self.arrays, self.hub, before, 0, after, 0, work, ride, self._explicit):
            self._restress(work.q[None], at, at, np.inf, time)

    def _stiffest(self) -> float:
        """Largest squared angular frequency of the coordinates on their hub at the present state [1/s^2]."""
        inputs = self._at(self.time, np.inf, self.ride.rigid)
        return float(hub_mobile.stiffest(self.arrays, self.hub, inputs, 0, self._work, self.ride))

    def _energies_now(self) -> Energies:
        """Energies where the steps have come to."""
        eta, rate = self._work.q[None], self._work.v[None]
        elastic, strain = self.energies(np.array([self.time]), eta, rate)[0]
        return Energies(elastic, float(self._carried(eta, rate, self.ride.rigid[None])[0, 6]), strain)

    def _carried(self, eta: Array, rate: Array, rigid: Array) -> Array:
        """Momenta and kinetic energy of samples, see `hub_steps.carried`."""
        found: Array = hub_steps.carried(self.arrays, self._whole, new_place(self._whole), eta, rate, rigid)
        return found

    def hub_at(self, time: float, eta: Array, rate: Array) -> Array:
        """The hub at a stored instant or where the steps have come to, with its whole momentum, shape (31,)."""
        rigid = self._rigid(np.array([time]))
        rigid[:, MOMENTUM:WRENCH] = self._carried(eta[None], rate[None], rigid)[:, :6]
        return rigid[0]

    def _rigid(self, times: Array) -> Array:
        """The hub at stored instants or where the steps have come to, shape (time, 31)."""
        rows = self._rows(np.rint((times - self.problem.shift) / self.problem.time_step).astype(np.int64))
        rigid = np.tile(self.ride.rigid, (len(rows), 1))
        rigid[rows >= 0] = self.rigid[rows[rows >= 0]]
        return rigid

    def motions(self, times: Array) -> Array:
        """Angular velocity, angular acceleration and origin acceleration at instants of `hub_at`, shape (time, 9)."""
        rigid = self._rigid(times)
        return np.concatenate([rigid[:, 10:13], rigid[:, 28:31], rigid[:, 25:28]], axis=1)

    def frame_now(self, time: float) -> FrameTerms:
        """Terms of the moving frame and inputs at a sample."""
        spin, turn, push = self.motions(np.array([time]))[0].reshape(3, 3)
        frame = frame_at(self.problem.coupling, self.moments, RigidMotion(spin, turn, push), self.rom.size)
        return self._pushed(frame, np.array([time]), np.inf)

    def complete(self, data: xr.Dataset, place: Indices) -> xr.Dataset:
        """The record with the hub's motion, momenta and work; kinetic energy is that of the whole spacecraft."""
        rigid = self.rigid[place]
        carried = self._carried(self.eta[place], self.rate[place], rigid)
        axes = np.array([rotations.matrix(row) for row in rigid[:, :4]]).reshape(-1, 3, 3)
        velocity = np.einsum("nij,nj->ni", axes, rigid[:, 7:10])
        vectors = np.stack([rigid[:, 4:7], velocity, carried[:, :3], carried[:, 3:6]], axis=1)
        data["kinetic_energy"] = data["kinetic_energy"] + carried[:, 6]
        return hub_variables(data, rigid[:, :4], vectors, self.outside[place])
