r"""Equation of motion of a structure on a free hub [theory.md 9], for the steps of any method.

The elastic unknowns are those of any run. With M and P of the structure alone, r = (a0, dw) the hub's accelerations
and B(q), R(q) of `tautflex.solvers.transient.free_hub.momentum`,

    M ddq + B' r + P(q, dq, w) = 0,    R r = W - B ddq - c(q, dq, w),

so that the mass that moves, M - B' R^-1 B, depends on q. A scheme's inertia M a_s and its weighted forces are written
for a constant mass. They keep their order if the weighted forces hold the *true* accelerations of an instant, which
balance all forces there, and the scheme's own ones serve as their running mean alone [Arnold & Bruls, Multibody Syst.
Dyn. 18 (2007) 185]. With forces ``F = P + B' r`` weighted (g, 1 - g) between the evaluation instant e and the start n,
``M a_s + g F_e + (1 - g) F_n = 0`` and ``F = -M ddq`` at both give

    a_s = g ddq_e + (1 - g) ddq_n,    ddq_e = (a_s - (1 - g) ddq_n) / g,

and ddq_e is what enters r_e. Where the forces are those of one instant (g = 1) it is a_s itself.

The hub's velocities are not integrated but follow from the momenta, which external forces alone change: by their
impulse, with the trapezoidal rule, which is of second order like the methods. So free flight keeps linear and angular
momentum to round-off, whatever step, method and tolerance. W is the wrench of all external forces: those on the hub,
on the nodes of the structure and on its held nodes.

The effective stiffness loses ``c B' R^-1 B``, with c the factor of M in it for every g: a correction of rank six.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from scipy.linalg import block_diag

from tautflex.mechanics.loads.inputs import earlier
from tautflex.mechanics.products import inner
from tautflex.motion import rotations
from tautflex.motion.hub import FreeHub, HubState
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.numeric import Array, cross_matrix
from tautflex.solvers.linear.low_rank import LowRankUpdate
from tautflex.solvers.transient.accuracy.books import RIGID
from tautflex.solvers.transient.equation import EquationOfMotion, StepForces, StepNumbers
from tautflex.solvers.transient.free_hub.balance import (
    add_forces_at_rates,
    add_hub_forces,
    end_hub,
    inertial,
    mobile_product,
    motion_at,
    rigid_parts,
)
from tautflex.solvers.transient.free_hub.momentum import Body, carried_energy, momenta_of, rigid_blocks
from tautflex.solvers.transient.free_hub.motion import HubMotion, slopes
from tautflex.solvers.transient.free_hub.outside import points_of, power_of, wrench_of
from tautflex.solvers.transient.methods.scheme import StepScheme
from tautflex.solvers.transient.probes import ProbeSet
from tautflex.solvers.transient.state import MotionState, Resolved, hermite

_NONE = np.zeros(0)


@dataclass
class HubEquation(EquationOfMotion):
    """Forces of a structure on a free hub for one run.

    Parameters
    ----------
    hub
        The hub; `commanded` is a wrench on it that whoever drives may set, shape (6,).
    probes
        Measuring points that feedback laws may read.
    """

    kind: ClassVar[type[MotionState]] = HubMotion

    hub: FreeHub = field(kw_only=True)
    probes: ProbeSet = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.body: tuple[Any, ...] = tuple(Body.of(self.inertia, self.hub))
        self._mobile = LowRankUpdate(self._mass_factor)
        self._constant = None if self.hub.feedback else self.hub.wrench()
        self._held, self.outside = np.zeros(6), self.input_load
        self.commanded = np.zeros(6)
        self.points = points_of(self.system)

    def set_time(self, time: float, before: float = np.inf) -> bool:
        """Apply the inputs of an instant, those on held nodes too; a jump at ``before`` is not met yet."""
        changed = super().set_time(time, before)
        if changed and self.inputs:
            instant = earlier(time, before)
            self._held, self.outside = self.inputs.held_wrench(instant), self.input_load
            if self.inputs.internal:
                self.outside = self.inputs.outside_load(instant)
        return changed

    def wrench_of(self, load: Array, q: Array) -> Array:
        """Force, and torque about O, of forces on the free unknowns, hub axes, shape (6,)."""
        return np.asarray(wrench_of(self.points, load, q), dtype=np.float64)

    def rigid_wrench(self, state: HubState | None) -> Array:
        """That of the hub and its supports, at the instant that is set and a state (None where it asks for none)."""
        return (self.hub.wrench(state) if self._constant is None else self._constant) + self.added_wrench

    @property
    def added_wrench(self) -> Array:
        """That of the supports at the instant that is set, and what is commanded, shape (6,)."""
        return self._held + self.commanded

    def wrench(self, time: float, rigid: Array, q: Array, v: Array) -> Array:
        """Force, and torque about O, of everything outside at an instant, hub axes, shape (6,)."""
        state = None
        if self.hub.feedback:
            attitude, position, twist = rigid_parts(rigid)[:3]
            velocity = rotations.matrix(attitude) @ twist[:3]
            state = HubState(time, attitude, twist[3:], position, velocity, self.probes.read(q), self.probes.read(v))
        found = sum((item.wrench(q) for item in self.followers), self.rigid_wrench(state))
        return found + self.wrench_of(self.outside, q)

    def blocks(self, q: Array) -> tuple[Array, Array]:
        """R(q), shape (6, 6), and B(q), shape (6, size)."""
        blocks: tuple[Array, Array] = rigid_blocks(self.body, q)
        return blocks

    def start(self, time: float, q: Array, v: Array, motion: RigidMotion, hub: Array = _NONE) -> HubMotion:
        """State at the start of a run with a known hub, shape (31,), or the given attitude and velocities.

        ``motion`` is not looked at.
        """
        momenta = momenta_of(self.body, q, v, v)
        rigid = hub.copy() if hub.size else self._given()
        parts = rigid_parts(rigid)
        parts.momentum[:] = inertial(parts.attitude, parts.position, momenta.mass @ parts.twist + momenta.relative)
        self.set_time(time)
        parts.wrench[:] = self.wrench(time, rigid, q, v)
        return self._balanced(HubMotion(time, q, v, np.zeros_like(q), rigid=rigid))

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion, dulling: Resolved | None) -> MotionState:
        """Same positions and velocities under another wrench or other inputs; only the change is solved for."""
        assert isinstance(at, HubMotion)
        self.set_time(at.time, at.time)
        inside, applied, stored = self.force(at.q), self.applied(at.q), self._stored(at.q)
        self.set_time(at.time)
        pull, wrench = self.force(at.q) - inside, self.wrench(at.time, at.rigid, at.q, at.v)
        change, push = pull - (self.applied(at.q) - applied), wrench - at.hub.wrench
        if not (change.any() or push.any()):
            return at
        mass, coupling = self._mobilize(at.q)
        push = self.hub.freedom * push
        moved = self._mobile.solve(-change - coupling.T @ np.linalg.solve(mass, push))
        rates = np.asarray(np.linalg.solve(mass, push - coupling @ moved), dtype=np.float64)
        pushed = self._shifted(at, wrench, moved, rates, stored)
        return self.settled(pushed, pull, dulling) if dulling and pull.any() else pushed

    def _given(self) -> Array:
        """The hub with its given attitude and velocities, shape (31,)."""
        rigid = np.zeros(31)
        hub = rigid_parts(rigid)
        hub.attitude[:] = np.asarray(self.hub.attitude) / np.linalg.norm(self.hub.attitude)
        hub.twist[:3] = rotations.matrix(hub.attitude).T @ np.asarray(self.hub.velocity, dtype=float)
        hub.twist[3:] = self.hub.angular_velocity
        return rigid

    def balance(self, at: MotionState, motion: RigidMotion) -> Array:
        """Accelerations and wrench that balance an instant, and its strain energy, shape (size + 13,)."""
        assert isinstance(at, HubMotion)
        self.set_time(at.time)
        new = self._pushed(at)
        return np.concatenate([new.a, new.hub.rates, new.hub.wrench, [self.strain_energy(at.q)]])

    def rebalanced(self, at: MotionState, before: Array, motion: RigidMotion, dulling: Resolved | None) -> MotionState:
        """Same positions and velocities where `balance` was another before."""
        assert isinstance(at, HubMotion)
        change = self.balance(at, motion) - before
        if not change.any():
            return at
        moved, rates = change[:-13], change[-13:-7]
        if dulling and self.restressed:
            moved, rates = self._resolved(at, moved, rates, dulling)
        return self._shifted(at, self._pushed(at).hub.wrench, moved, rates, self._stored(at.q) - change[-1])

    def _pushed(self, at: HubMotion) -> HubMotion:
        """The state with the wrench and the accelerations of the instant that is set."""
        rigid = at.rigid.copy()
        rigid_parts(rigid).wrench[:] = self.wrench(at.time, rigid, at.q, at.v)
        return self._balanced(replace(at, rigid=rigid))

    def settled(self, at: MotionState, pull: Array, resolved: Resolved) -> MotionState:
        """A state with what steps resolve of the acceleration by a force of stresses, shape (size,); see `jump`."""
        assert isinstance(at, HubMotion)
        pushed = self._mobile.solve(-pull)
        change, rates = self._resolved(at, pushed, np.zeros(6), resolved)
        return self._shifted(at, at.hub.wrench, change - pushed, rates, self._stored(at.q))

    def _resolved(self, at: HubMotion, change: Array, rates: Array, resolved: Resolved) -> tuple[Array, Array]:
        """What steps resolve of a change of the elastic acceleration, and the hub's that goes with it."""
        kept, (mass, coupling) = resolved(at, change), self.blocks(at.q)
        return kept, rates + np.linalg.solve(mass, coupling @ (change - kept))

    def _shifted(self, at: HubMotion, wrench: Array, change: Array, rates: Array, stored: float) -> HubMotion:
        """State under a wrench with these changes of accelerations, from one that stored another energy [J]."""
        rigid = at.rigid.copy()
        hub = rigid_parts(rigid)
        hub.wrench[:] = wrench
        hub.rates[:] += rates
        forces = None if at.forces is None else at.forces - self.products.mass_product(change)
        balanced = at.balanced + change if at.balanced.size else _NONE
        books = self.books_behind_jump(at, stored)
        moved = replace(at, a=at.a + change, forces=forces, jerk=None, books=books)
        return replace(moved, rigid=rigid, balanced=balanced, power=self.power(rigid, at.q, at.v))

    def _mobilize(self, q: Array) -> tuple[Array, Array]:
        """`blocks`, with the factors of the mass that moves made anew."""
        if not self._mass_factor.ready:
            self._mass_factor.factorize(self.inertia.mass_entries)
        mass, coupling = self.blocks(q)
        free = self.hub.freedom > 0.0
        self._mobile.correct(coupling[free], -np.asarray(np.linalg.inv(mass[free][:, free]), dtype=np.float64))
        return mass, coupling

    def _balanced(self, at: HubMotion) -> HubMotion:
        """The state with the accelerations that balance all forces of the instant that is set."""
        forces = self.force(at.q) - self.applied(at.q)
        if self.products.damped:
            forces += self.products.damping_product(at.v)
        add_forces_at_rates(self.body, at.q, at.v, np.zeros_like(at.q), at.rigid, forces)
        self._mobilize(at.q)
        a = self._mobile.solve(-forces)
        rigid = add_forces_at_rates(self.body, at.q, at.v, a, at.rigid, forces)
        forces = -self.products.mass_product(a)
        return HubMotion(at.time, at.q, at.v, a, forces, rigid=rigid, power=self.power(rigid, at.q, at.v))

    def power(self, rigid: Array, q: Array, v: Array) -> float:
        """Power of all external forces [W]."""
        hub = rigid_parts(rigid)
        return float(power_of(hub.wrench, hub.twist, self.applied(q), v))

    def step_forces(
        self, numbers: StepNumbers, at: MotionState, size: float, segment: Segment, diagonal: Array
    ) -> StepForces:
        """Forces of a step of this size [s] inside one smooth segment, see `HubForces`."""
        assert isinstance(at, HubMotion)
        then = self.then(numbers, at, segment)
        self.set_time(at.time + numbers.scheme.evaluation * size, segment.end)
        return HubForces(self, numbers, at, size, diagonal, segment.end, then)

    def correction(self, q: Array, scheme: StepScheme) -> tuple[Array, Array]:
        """With what the free hub takes from the effective stiffness, ``-c B' R^-1 B``."""
        (mass, coupling), (vectors, core), free = self.blocks(q), super().correction(q, scheme), self.hub.freedom > 0.0
        taken = np.asarray(-scheme.inertia.d * np.linalg.inv(mass[free][:, free]), dtype=float)
        if not core.size:
            return coupling[free], taken
        return np.concatenate([coupling[free], vectors.reshape(-1, q.size)]), block_diag(taken, core)

    def motion(self, at: MotionState, segment: Segment) -> RigidMotion:
        """Motion of the floating frame."""
        assert isinstance(at, HubMotion)
        return RigidMotion(at.hub.twist[3:], at.hub.rates[3:], at.hub.rates[:3])

    def kinetic_energy(self, at: MotionState) -> float:
        """Energy of hub and structure in the inertial frame [J]."""
        assert isinstance(at, HubMotion)
        return carried_energy(self.body, at.q, at.v, at.hub.twist) + super().kinetic_energy(at)

    def between(self, start: MotionState, end: MotionState, time: float) -> MotionState:
        """State at an instant between two states; what has a known rate follows a cubic, the rest a line."""
        assert isinstance(start, HubMotion)
        assert isinstance(end, HubMotion)
        elastic, share = super().between(start, end, time), (time - start.time) / (end.time - start.time)
        rigid = start.rigid + share * (end.rigid - start.rigid)
        values = np.append(start.rigid[:19], start.work), np.append(end.rigid[:19], end.work)
        cubic, _ = hermite(start.time, end.time, time, values, (slopes(start), slopes(end)))
        rigid[:19] = cubic[:-1]
        rigid[:4] /= np.linalg.norm(rigid[:4])
        return HubMotion(time, elastic.q, elastic.v, elastic.a, rigid=rigid, work=float(cubic[-1]))

    def mobile_mass(self, at: MotionState, vector: Array) -> Array:
        """Mass that elastic motion alone moves, ``M - B' R^-1 B``, times a vector of shape (size,)."""
        products = self.products
        moved: Array = mobile_product(self.body, products.start, products.column, products.mass, at.q, vector)
        return moved

    def speeds(self, at: MotionState, since: MotionState) -> Array:
        """Norms that adaptive steps control each error against.

        Kinetic energy splits into that of the elastic motion about the momenta and that of the momenta. Errors of the
        former are measured by itself, as under a prescribed motion, those of the latter by what the run has changed.
        """
        assert isinstance(at, HubMotion)
        assert isinstance(since, HubMotion)
        gained = at.hub.twist - since.hub.twist
        gained[:3] = rotations.matrix(at.hub.attitude).T @ (at.velocity - since.velocity)
        elastic, rigid = self._norms(at.q, gained, at.v)
        return np.array([elastic, max(elastic, rigid)])

    def pushes(self, at: MotionState) -> Array:
        """The same norms of the accelerations."""
        assert isinstance(at, HubMotion)
        elastic, rigid = self._norms(at.q, at.hub.rates, at.true)
        return np.array([elastic, max(elastic, rigid)])

    def errors(self, at: MotionState, end: MotionState, share: float, smoothed: Callable[[Array], Array]) -> Array:
        """The same norms of the errors; those of the momenta are left as they are."""
        assert isinstance(at, HubMotion)
        assert isinstance(end, HubMotion)
        rigid = self._norms(end.q, share * (end.hub.rates - at.hub.rates), share * (end.true - at.true))[1]
        return np.array([self._norms(end.q, np.zeros(6), smoothed(share * (end.a - at.a)))[0], rigid])

    def _norms(self, q: Array, rigid: Array, elastic: Array) -> tuple[float, float]:
        """Norms of an elastic motion about the momenta, and of the momenta of both, in the metric of kinetic energy."""
        mass, coupling = self.blocks(q)
        relative = coupling @ elastic
        carried = np.linalg.solve(mass, relative)
        square = self.products.mass_norm(elastic) - float(carried @ relative)
        whole = rigid + carried
        return float(np.sqrt(max(square, 0.0))), float(np.sqrt(whole @ mass @ whole))


def motion_factors(scheme: StepScheme) -> Array:
    """What `motion_at` reads, shape (7,)."""
    velocity, inertia, weight = scheme.velocity, scheme.inertia, scheme.weight
    factors = (velocity.d, velocity.v, velocity.a, inertia.d / weight, inertia.v / weight, inertia.a / weight)
    return np.array([*factors, 1.0 - 1.0 / weight])


class HubForces(StepForces):
    """Forces of one step on a free hub as a function of its elastic increment.

    The terms of `StepForces` are those of a frame at rest: those of the hub follow from the increment.
    """

    equation: HubEquation
    at: HubMotion

    def __init__(
        self, equation: HubEquation, numbers: StepNumbers, at: HubMotion, size: float, diagonal: Array, before: float,
        then: Array,
    ) -> None:  # fmt: skip
        super().__init__(equation, numbers, equation.at_rest, at, size, diagonal, before, then)
        scheme, spin = numbers.scheme, cross_matrix(at.hub.twist[3:])
        self.displacement = spin @ spin
        self._reach = scheme.evaluation * size
        self._factors = motion_factors(scheme)
        self._start = at.q, at.v, at.a, at.true if scheme.weight < 1.0 else _NONE
        self._rigid, self._point = self._guess(self._reach), _NONE

    def _guess(self, reach: float) -> Array:
        """Hub with the twist that the rates at the start lead to."""
        rigid = self.at.rigid.copy()
        rigid[7:13] += reach * rigid[25:]
        return rigid

    def residual(self, x: Array) -> tuple[Array, float, float, float]:
        """As of `StepForces`, with the forces of the hub's motion that balances the momenta of the increment."""
        residual, _, scale, inertia = super().residual(x)
        q, v, a = motion_at(self._factors, x, *self._start)
        alone = residual.copy()
        wrench = self._settled(self._reach, q, v, a, self._rigid)
        self._rigid, load, norm = add_hub_forces(
            self.equation.body, q, v, a, self.at.rigid, self._reach, wrench, self._rigid[7:13], self._scheme.weight,
            residual,
        )  # fmt: skip
        self._point, self._frame = x, (residual - alone) / self._scheme.weight
        return residual, norm, max(scale, load), inertia

    def _settled(self, reach: float, q: Array, v: Array, a: Array, rigid: Array) -> Array:
        """Wrench at ``reach`` [s] after the start where it agrees with the motion that it leads to, shape (6,)."""
        equation, time = self.equation, earlier(self.at.time + reach, self.before)
        wrench, last = equation.wrench(time, rigid, q, v), np.inf
        while equation.hub.feedback:
            rigid = end_hub(equation.body, q, v, a, self.at.rigid, reach, wrench, rigid[7:13])
            before, wrench = wrench, equation.wrench(time, rigid, q, v)
            change = float(np.abs(wrench - before).max())
            # Down to round-off, where the changes stop falling.
            if not 1e-16 * float(np.abs(wrench).max()) < change < last:
                break
            last = change
        return wrench

    def end(self, x: Array, residual: Array) -> HubMotion:
        """State at the end of the step whose increment leaves this residual."""
        equation, at, weight, size = self.equation, self.at, self._scheme.weight, self.size
        elastic = super().end(x, residual)
        q, v, a = elastic.q, elastic.v, elastic.a
        rigid, balanced = self._rigid, _NONE
        if weight < 1.0:
            balanced = a = motion_at(self._factors, x, *self._start)[2]
        if self._scheme.evaluation != 1.0 or x is not self._point:
            equation.set_time(elastic.time, self.before)
            guess = self._guess(size)
            wrench = self._settled(size, q, v, a, guess)
            rigid = end_hub(equation.body, q, v, a, at.rigid, size, wrench, guess[7:13])
        power, hub = equation.power(rigid, q, v), rigid_parts(rigid)
        elastic.books.work[RIGID] += 0.5 * size * (inner(at.hub.wrench, at.hub.twist) + inner(hub.wrench, hub.twist))
        return HubMotion(
            elastic.time, q, v, elastic.a, elastic.forces, elastic.jerk, books=elastic.books, rigid=rigid,
            balanced=balanced, power=power, work=at.work + 0.5 * size * (at.power + power),
        )  # fmt: skip
