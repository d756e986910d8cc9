r"""Equation of motion of a structure on a free hub [theory.md 9], for the steps of any method.

The elastic unknowns are those of any run. With M and P of the structure alone, r = (a0, dw) the hub's accelerations
and B(q), R(q) of `momentum`,

    M ddq + B' r + P(q, dq, w) = 0,    R r = W - B ddq - c(q, dq, w),

so that the mass that moves, M - B' R^-1 B, depends on q. A scheme's inertia M a_s and its weighted forces are written
for a constant mass. They keep their order if the forces that are weighted hold the *true* accelerations of an instant,
which balance all forces there, and the scheme's own ones serve as their running mean alone [Arnold & Bruls, Multibody
Syst. Dyn. 18 (2007) 185]. With forces ``F = P + B' r`` weighted (g, 1 - g) between the evaluation instant e and the start
n, ``M a_s + g F_e + (1 - g) F_n = 0`` and ``F = -M ddq`` at both give

    a_s = g ddq_e + (1 - g) ddq_n,    ddq_e = (a_s - (1 - g) ddq_n) / g,

and ddq_e is what enters r_e. Where the forces are those of one instant (g = 1) it is a_s itself.

The hub's velocities are not integrated but follow from the momenta, which external forces alone change: by their
impulse, with the trapezoidal rule, which is of second order like the methods. So free flight keeps linear and angular
momentum to round-off, whatever step, method and tolerance.

The effective stiffness loses ``c B' R^-1 B``, with c the factor of M in it for every g: a correction of rank six.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tautflex.motion import rotations
from tautflex.motion.hub import FreeHub, HubState
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.numeric import Array, cross_matrix
from tautflex.solvers.linear.low_rank import LowRankUpdate
from tautflex.solvers.transient.equation import EquationOfMotion, MotionState, MotionTerms, StepForces, StepNumbers
from tautflex.solvers.transient.equation import combine, hermite
from tautflex.solvers.transient.free_hub.momentum import (
    Body,
    Momenta,
    RigidState,
    add_frame_forces,
    add_hub_forces,
    advance,
    inertial,
    momenta_of,
    motion_at,
    rigid_coupling,
    rigid_mass,
    with_rates,
)
from tautflex.solvers.transient.probes import ProbeSet

_NONE = np.zeros(0)


@dataclass
class HubMotion(MotionState):
    """State of the structure and of the hub at one instant.

    Parameters
    ----------
    rigid
        The hub.
    balanced
        Elastic acceleration that balances all forces, shape (size,), where it is not ``a``.
    power, work
        Power of all external forces [W], and their work since the start [J].
    """

    rigid: RigidState = field(kw_only=True)
    balanced: Array = field(default_factory=lambda: _NONE, kw_only=True)
    power: float = field(default=0.0, kw_only=True)
    work: float = field(default=0.0, kw_only=True)

    @property
    def true(self) -> Array:
        """Elastic acceleration that balances all forces, shape (size,)."""
        return self.balanced if self.balanced.size else self.a

    @property
    def velocity(self) -> Array:
        """Velocity of the floating frame's origin, inertial axes [m/s], shape (3,)."""
        velocity: Array = rotations.matrix(self.rigid.attitude) @ self.rigid.twist[:3]
        return velocity


@dataclass
class HubEquation(EquationOfMotion):
    """Forces of a structure on a free hub for one run.

    Parameters
    ----------
    hub
        The hub.
    probes
        Measuring points that feedback laws may read.
    """

    hub: FreeHub = field(kw_only=True)
    probes: ProbeSet = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.body = Body.of(self.inertia, self.hub)
        self._still = np.zeros(self.system.size)
        self._at_rest = MotionTerms((), np.zeros((3, 3)), np.zeros((3, 3)), self._still)
        self._mobile = LowRankUpdate(self._mass_factor)

    @cached_property
    def _constant_wrench(self) -> Array:
        return self.hub.wrench(None)

    def wrench(self, time: float, rigid: RigidState, q: Array, v: Array) -> Array:
        """Force, and torque about O, on the hub at an instant, hub axes, shape (6,)."""
        if not self.hub.feedback:
            return self._constant_wrench
        attitude, position, twist = rigid.attitude, rigid.position, rigid.twist
        velocity = rotations.matrix(attitude) @ twist[:3]
        reading = self.probes.read(q), self.probes.read(v)
        return self.hub.wrench(HubState(time, attitude, twist[3:], position, velocity, *reading))

    def momenta(self, q: Array, v: Array | None = None, a: Array | None = None) -> Momenta:
        """Momenta of the structure; velocities and accelerations that are left out are zero."""
        momenta: Momenta = momenta_of(self.body, q, self._still if v is None else v, self._still if a is None else a)
        return momenta

    def rigid_blocks(self, q: Array) -> tuple[Array, Array]:
        """R(q), shape (6, 6), and B(q), shape (6, size)."""
        momenta = self.momenta(q)
        return rigid_mass(self.body.mass, momenta), rigid_coupling(self.body, momenta, q.size)

    def start(self, time: float, q: Array, v: Array, motion: RigidMotion) -> HubMotion:
        """State at the start of a run with the hub's given attitude and velocities; ``motion`` is not looked at."""
        hub = self.hub
        attitude = np.asarray(hub.attitude, dtype=float) / np.linalg.norm(hub.attitude)
        velocity = rotations.matrix(attitude).T @ np.asarray(hub.velocity, dtype=float)
        twist = np.concatenate([velocity, hub.angular_velocity])
        mass, lever = self.rigid_blocks(q)
        momentum = inertial(attitude, np.zeros(3), mass @ twist + lever @ v)
        rigid = RigidState(attitude, np.zeros(3), twist, momentum, np.zeros(6), np.zeros(6))
        self.set_time(time)
        return self._balanced(HubMotion(time, q, v, self._still, rigid=rigid), self.wrench(time, rigid, q, v))

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion) -> MotionState:
        """Same positions and velocities under another wrench or other inputs; only the change is solved for."""
        assert isinstance(at, HubMotion)
        self.set_time(at.time, at.time)
        old = self._balanced(at, at.rigid.wrench)
        self.set_time(at.time)
        new = self._balanced(at, self.wrench(at.time, at.rigid, at.q, at.v))
        if np.array_equal(old.rigid.wrench, new.rigid.wrench) and np.array_equal(old.a, new.a):
            return at
        change = new.a - old.a
        rates = at.rigid.rates + new.rigid.rates - old.rigid.rates
        forces = None if at.forces is None else at.forces - self.products.mass_product(change)
        return HubMotion(
            at.time, at.q, at.v, at.a + change, forces, rigid=new.rigid._replace(rates=rates),
            balanced=at.balanced + change if at.balanced.size else _NONE, power=new.power, work=at.work,
        )  # fmt: skip

    def _balanced(self, at: HubMotion, wrench: Array) -> HubMotion:
        """The state under this wrench with the accelerations that balance all forces of the instant that is set."""
        momenta, rigid = self.momenta(at.q, at.v), at.rigid._replace(wrench=wrench)
        free = with_rates(self.body, momenta, rigid)
        forces = self.force(at.q) - self.input_load
        if self.products.damped:
            forces += self.products.damping_product(at.v)
        add_frame_forces(self.body, momenta, free.twist[3:], free.rates, 1.0, forces)
        if not self._mass_factor.ready:
            self._mass_factor.factorize(self.inertia.mass_entries)
        mass = rigid_mass(self.body.mass, momenta)
        self._mobile.correct(rigid_coupling(self.body, momenta, at.q.size), -np.linalg.inv(mass))
        a = self._mobile.solve(-forces)
        rigid = with_rates(self.body, self.momenta(at.q, at.v, a), rigid)
        forces = -self.products.mass_product(a)
        return HubMotion(at.time, at.q, at.v, a, forces, rigid=rigid, power=self.power(rigid, at.v))

    def power(self, rigid: RigidState, v: Array) -> float:
        """Power of all external forces [W]."""
        return float(rigid.wrench @ rigid.twist + self.input_load @ v)

    def step_forces(
        self, numbers: StepNumbers, at: MotionState, size: float, segment: Segment, diagonal: Array
    ) -> StepForces:
        """Forces of a step of this size [s] inside one smooth segment, see `HubForces`."""
        assert isinstance(at, HubMotion)
        self.set_time(at.time + numbers.scheme.evaluation * size, segment.end)
        return HubForces(self, numbers, self._at_rest, at, size, diagonal, segment.end)

    def correction(self, q: Array, numbers: StepNumbers) -> tuple[Array, Array]:
        """What the free hub takes from the effective stiffness, ``-c B' R^-1 B``."""
        mass, lever = self.rigid_blocks(q)
        return lever, -numbers.scheme.inertia.d * np.linalg.inv(mass)

    def motion(self, at: MotionState, segment: Segment) -> RigidMotion:
        """Motion of the floating frame."""
        assert isinstance(at, HubMotion)
        return RigidMotion(at.rigid.twist[3:], at.rigid.rates[3:], at.rigid.rates[:3])

    def kinetic_energy(self, at: MotionState) -> float:
        """Energy of hub and structure in the inertial frame [J]."""
        assert isinstance(at, HubMotion)
        momenta, twist = self.momenta(at.q, at.v), at.rigid.twist
        rigid = 0.5 * twist @ rigid_mass(self.body.mass, momenta) @ twist + twist @ momenta.relative
        return float(rigid) + super().kinetic_energy(at)

    def between(self, start: MotionState, end: MotionState, time: float) -> MotionState:
        """State at an instant between two states; all that the equation gives the rates of follows cubics."""
        assert isinstance(start, HubMotion) and isinstance(end, HubMotion)
        elastic = super().between(start, end, time)
        values, _ = hermite(
            start.time, end.time, time,
            (np.concatenate([*start.rigid[:4], [start.work]]), np.concatenate([*end.rigid[:4], [end.work]])),
            (_slopes(start), _slopes(end)),
        )  # fmt: skip
        attitude, position, twist, momentum = np.split(values[:-1], [4, 7, 13])
        share = (time - start.time) / (end.time - start.time)
        wrench, rates = (one + share * (two - one) for one, two in zip(start.rigid[4:], end.rigid[4:], strict=True))
        rigid = RigidState(attitude / np.linalg.norm(attitude), position, twist, momentum, wrench, rates)
        return HubMotion(time, elastic.q, elastic.v, elastic.a, rigid=rigid, work=float(values[-1]))

    def mobile_mass(self, at: MotionState, vector: Array) -> Array:
        """Mass that elastic motion alone moves, ``M - B' R^-1 B``, times a vector of shape (size,)."""
        mass, lever = self.rigid_blocks(at.q)
        product: Array = self.products.mass_product(vector) - lever.T @ np.linalg.solve(mass, lever @ vector)
        return product

    def speeds(self, at: MotionState, since: MotionState) -> Array:
        """Norms that adaptive steps control each error against.

        Kinetic energy splits into that of the elastic motion about the momenta and that of the momenta. Errors of the
        former are measured by itself, as under a prescribed motion, those of the latter by what the run has changed.
        """
        assert isinstance(at, HubMotion) and isinstance(since, HubMotion)
        gained = rotations.matrix(at.rigid.attitude).T @ (at.velocity - since.velocity)
        elastic, rigid = self._norms(at.q, np.concatenate([gained, at.rigid.twist[3:] - since.rigid.twist[3:]]), at.v)
        return np.array([elastic, max(elastic, rigid)])

    def pushes(self, at: MotionState) -> Array:
        """The same norms of the accelerations."""
        assert isinstance(at, HubMotion)
        elastic, rigid = self._norms(at.q, at.rigid.rates, at.true)
        return np.array([elastic, max(elastic, rigid)])

    def errors(self, at: MotionState, end: MotionState, share: float, smoothed: Callable[[Array], Array]) -> Array:
        """The same norms of the errors; those of the momenta are left as they are."""
        assert isinstance(at, HubMotion) and isinstance(end, HubMotion)
        error = share * (end.a - at.a)
        rigid = self._norms(end.q, share * (end.rigid.rates - at.rigid.rates), share * (end.true - at.true))[1]
        return np.array([self._norms(end.q, np.zeros(6), smoothed(error))[0], rigid])

    def _norms(self, q: Array, rigid: Array, elastic: Array) -> tuple[float, float]:
        """Norms of an elastic motion about the momenta, and of the momenta of both, in the metric of kinetic energy."""
        momenta = self.momenta(q, elastic)
        mass = rigid_mass(self.body.mass, momenta)
        carried = np.linalg.solve(mass, momenta.relative)
        square = self.products.mass_norm(elastic) - float(carried @ momenta.relative)
        whole = rigid + carried
        return float(np.sqrt(max(square, 0.0))), float(np.sqrt(whole @ mass @ whole))


def _slopes(at: HubMotion) -> Array:
    """Rates of attitude, position, twist, momentum and work, shape (20,)."""
    rigid = at.rigid
    spin = rigid.twist[3:]
    twist = rigid.rates.copy()
    twist[:3] -= np.cross(spin, rigid.twist[:3])
    attitude = 0.5 * rotations.product(rigid.attitude, np.concatenate([[0.0], spin]))
    push = inertial(rigid.attitude, rigid.position, rigid.wrench)
    return np.concatenate([attitude, at.velocity, twist, push, [at.power]])


class HubForces(StepForces):
    """Forces of one step on a free hub as a function of its elastic increment.

    Parameters
    ----------
    equation, numbers, terms, at, size, diagonal
        As of `StepForces`, with the terms of a frame at rest: those of the hub follow from the increment.
    before
        Jump that is not met yet [s].
    """

    equation: HubEquation
    at: HubMotion

    def __init__(
        self, equation: HubEquation, numbers: StepNumbers, terms: MotionTerms, at: HubMotion, size: float,
        diagonal: Array, before: float,
    ) -> None:  # fmt: skip
        super().__init__(equation, numbers, terms, at, size, diagonal)
        scheme = numbers.scheme
        turning = cross_matrix(at.rigid.twist[3:])
        self.displacement = turning @ turning
        self._before, self._reach = before, scheme.evaluation * size
        velocity, inertia, weight = scheme.velocity, scheme.inertia, scheme.weight
        factors = (velocity.d, velocity.v, velocity.a, inertia.d / weight, inertia.v / weight, inertia.a / weight)
        self._factors = np.array([*factors, 1.0 - 1.0 / weight])
        self._start = at.q, at.v, at.a, at.true if weight < 1.0 else _NONE
        self._rigid = self._guess(self._reach)
        self._point: Array | None = None

    def _guess(self, reach: float) -> RigidState:
        rigid = self.at.rigid
        return rigid._replace(twist=rigid.twist + reach * rigid.rates)

    def residual(self, x: Array) -> tuple[Array, float, float, float]:
        """As of `StepForces`, with the forces of the hub's motion that balances the momenta of the iterate."""
        residual, _, scale, inertia = super().residual(x)
        body, weight = self.equation.body, self._scheme.weight
        if self.equation.hub.feedback:
            q, v, a = motion_at(self._factors, x, *self._start)
            momenta, self._rigid = self._balance(self._reach, q, v, a, self._rigid)
            spin, rates = self._rigid.twist[3:], self._rigid.rates
            load, norm = add_frame_forces(body, momenta, spin, rates, weight, residual)
        else:
            self._rigid, load, norm = add_hub_forces(
                body, self._factors, x, *self._start, self.at.rigid, self._reach, self.equation.wrench(0.0, self._rigid, x, x),
                self._rigid.twist, weight, residual,
            )  # fmt: skip
        self._point = x
        return residual, norm, max(scale, load), inertia

    def _balance(self, reach: float, q: Array, v: Array, a: Array, guess: RigidState) -> tuple[Momenta, RigidState]:
        """Momenta, and the hub that they and the impulse of its wrench leave at ``reach`` [s] after the start."""
        equation, time = self.equation, min(self.at.time + reach, float(np.nextafter(self._before, -np.inf)))
        momenta, rigid, last = equation.momenta(q, v, a), guess, np.inf
        while True:
            wrench = equation.wrench(time, rigid, q, v)
            before, rigid = rigid, advance(equation.body, momenta, self.at.rigid, reach, wrench, rigid.twist)
            change = float(np.abs(rigid.twist - before.twist).max())
            # A wrench that feels the motion moves the end; down to round-off, where the changes stop falling.
            if not equation.hub.feedback or not 1e-16 * float(np.abs(rigid.twist).max()) < change < last:
                return momenta, with_rates(equation.body, momenta, rigid)
            last = change

    def end(self, x: Array, residual: Array) -> HubMotion:
        """State at the end of the step whose increment leaves this residual."""
        equation, at, scheme, size = self.equation, self.at, self._scheme, self.size
        elastic = super().end(x, residual)
        rigid, balanced = self._rigid, _NONE
        if scheme.weight < 1.0:
            balanced = motion_at(self._factors, x, *self._start)[2]
        if scheme.evaluation != 1.0 or x is not self._point:
            a = balanced if scheme.weight < 1.0 else elastic.a
            _, rigid = self._balance(size, elastic.q, elastic.v, a, self._guess(size))
        power = equation.power(rigid, elastic.v)
        return HubMotion(
            elastic.time, elastic.q, elastic.v, elastic.a, elastic.forces, elastic.jerk, rigid=rigid,
            balanced=balanced, power=power, work=at.work + 0.5 * size * (at.power + power),
        )  # fmt: skip
