r"""Implicit steps of a structure on a free hub [theory.md 9].

The elastic unknowns are those of any run. The hub's velocities are not integrated but follow from the momenta, which
external forces alone change, so that free flight keeps linear and angular momentum to round-off whatever the step.
The rigid accelerations enter the elastic equation as ``B' (a0, dw)``; since they depend on the elastic acceleration,
the effective stiffness loses ``c B' R^-1 B``, a correction of rank six that the Sherman-Morrison-Woodbury formula
brings to the factors of the structure alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import InputError
from tautflex.mechanics.inertia import cross_matrix
from tautflex.motion import rotations
from tautflex.motion.hub import FreeHub, HubState
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.nonlinear.anderson import AndersonAcceleration
from tautflex.solvers.nonlinear.newton import NewtonOutcome, relative_error, solve_newton
from tautflex.solvers.transient.equation import EquationOfMotion, MotionState
from tautflex.solvers.transient.free_hub.momentum import MomentumBalance, RigidBlocks
from tautflex.solvers.transient.methods.scheme import Combination, ImplicitMethod, StepScheme
from tautflex.solvers.transient.probes import ProbeSet

Array = NDArray[np.float64]


@dataclass
class HubMotion(MotionState):
    """State of the structure and of the hub at one instant.

    Parameters
    ----------
    attitude
        Unit quaternion, shape (4,).
    position
        Origin of the floating frame, inertial axes [m], shape (3,).
    twist
        Velocity of the origin and angular velocity, hub axes [m/s], [rad/s], shape (6,).
    momentum
        Linear momentum, and angular momentum about the inertial origin, inertial axes, shape (6,).
    wrench
        Force and torque in hub axes [N], [N m], shape (6,).
    rates
        Acceleration of the origin and angular acceleration, hub axes, shape (6,).
    work
        Work of force and torque since the start [J].
    """

    attitude: Array = field(default_factory=lambda: rotations.IDENTITY.copy())
    position: Array = field(default_factory=lambda: np.zeros(3))
    twist: Array = field(default_factory=lambda: np.zeros(6))
    momentum: Array = field(default_factory=lambda: np.zeros(6))
    wrench: Array = field(default_factory=lambda: np.zeros(6))
    rates: Array = field(default_factory=lambda: np.zeros(6))
    work: float = 0.0


def _inertial(attitude: Array, position: Array, wrench: Array) -> Array:
    """Force, and torque about the inertial origin, in inertial axes from a wrench in hub axes, shape (6,)."""
    turn = rotations.matrix(attitude)
    force = turn @ wrench[:3]
    return np.concatenate([force, turn @ wrench[3:] + rotations.cross(position, force)])


class HubStepper:
    """Implicit steps of one run on a free hub.

    Parameters
    ----------
    equation
        Forces of the structure.
    hub
        The hub.
    method
        Implicit method that evaluates all forces at one instant (Wilson-theta, Newmark, energy-conserving).
    tolerance
        Newton tolerance.
    probes
        Measuring points that feedback laws may read.

    Raises
    ------
    InputError
        If the method weighs forces of two instants.
    """

    def __init__(
        self, equation: EquationOfMotion, hub: FreeHub, method: ImplicitMethod, tolerance: float, probes: ProbeSet
    ) -> None:
        if method.scheme(1.0).weight != 1.0:
            raise InputError(
                f"method: expected one that balances forces at one instant on a free hub, got {method.name}; use "
                "Newmark(), WilsonTheta() or EnergyConserving()"
            )
        self.equation, self._hub, self._method, self._tolerance = equation, hub, method, tolerance
        self._probes = probes
        self._balance = MomentumBalance(equation.inertia, hub)
        self._factor = SymmetricFactorization(equation.system.pattern)
        self._memory = AndersonAcceleration()
        self._factor_size, self._scale = 0.0, 0.0
        self._columns: Array = np.zeros((0, 6))
        self._core: Array = np.zeros((6, 6))
        self._coupling: Array = np.zeros((6, 0))

    def start(self, time: float, q: Array, v: Array) -> HubMotion:
        """State at the start of a run with the hub's given attitude and velocities."""
        hub = self._hub
        attitude = np.asarray(hub.attitude, dtype=float) / np.linalg.norm(hub.attitude)
        turn = rotations.matrix(attitude)
        twist = np.concatenate([turn.T @ np.asarray(hub.velocity, dtype=float), hub.angular_velocity])
        blocks = self._balance.blocks(q)
        own: Array = blocks.mass @ twist + blocks.coupling @ v
        at = HubMotion(time, q, v, np.zeros_like(q), attitude=attitude, twist=twist)
        at.momentum = np.concatenate([turn @ own[:3], turn @ own[3:]])
        at.wrench = self._wrench(at)
        self.equation.set_time(time)
        at.a, at.rates = self._accelerations(at, blocks)
        return at

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion) -> MotionState:
        """Same positions and velocities under another wrench or input."""
        assert isinstance(at, HubMotion)
        self.equation.set_time(at.time, at.time)
        old = at.wrench, self.equation.force(at.q) - self.equation.input_load
        self.equation.set_time(at.time)
        at.wrench = self._wrench(at)
        change = self.equation.force(at.q) - self.equation.input_load - old[1]
        blocks = self._balance.blocks(at.q)
        rigid = np.linalg.solve(blocks.mass, at.wrench - old[0])
        step = self._reduced_mass_solve(blocks, -change - blocks.coupling.T @ rigid)
        at.a = at.a + step
        at.rates = at.rates + rigid - np.linalg.solve(blocks.mass, blocks.coupling @ step)
        at.jerk = None
        return at

    def step(self, at: MotionState, size: float, segment: Segment) -> tuple[MotionState, NewtonOutcome]:
        """Advance by ``size`` [s]; the outcome says whether the end is meaningful."""
        assert isinstance(at, HubMotion)
        scheme = self._method.scheme(size)
        self.equation.set_time(at.time + scheme.evaluation * size, segment.end)
        problem = _HubProblem(self, scheme, at, size, segment.end)
        reach = scheme.evaluation * size
        guess = reach * at.v + 0.5 * reach**2 * at.a
        if at.jerk is not None:
            guess += reach**3 / 6.0 * at.jerk
        outcome = solve_newton(problem, guess, self._tolerance, memory=self._memory)
        self.equation.statistics.iterations += outcome.iterations
        if outcome.converged:
            self._scale = max(self._scale, problem.scale)
        return self._end(scheme, outcome.x, at, size, segment.end), outcome

    def _end(self, scheme: StepScheme, d: Array, at: HubMotion, size: float, before: float) -> HubMotion:
        q = at.q + combine(scheme.end_displacement, d, at)
        v, a = combine(scheme.end_velocity, d, at), combine(scheme.end_acceleration, d, at)
        blocks = self._balance.blocks(q)
        end = self.rigid(at, size, blocks, q, v, before)
        end.a, end.jerk = a, (a - at.a) / size
        end.rates = self._balance.rates(blocks, end.wrench, end.twist[3:], v, a)
        end.work = at.work + 0.5 * size * float(at.wrench @ at.twist + end.wrench @ end.twist)
        return end

    def rigid(self, at: HubMotion, reach: float, blocks: RigidBlocks, q: Array, v: Array, before: float) -> HubMotion:
        """Hub at ``reach`` after ``at`` from the balance of momenta; attitude by the mean angular velocity.

        A fixed-point iteration over attitude and velocities; it contracts by (reach times spin).
        """
        time = at.time + reach
        end = HubMotion(time, q, v, at.a, twist=at.twist + reach * at.rates)
        applied = _inertial(at.attitude, at.position, at.wrench)
        velocity = rotations.matrix(at.attitude) @ at.twist[:3]
        last = np.inf
        for _ in range(50):
            turn = rotations.exponential(0.5 * reach * (at.twist[3:] + end.twist[3:]))
            end.attitude = rotations.product(at.attitude, turn)
            axes = rotations.matrix(end.attitude)
            end.position = at.position + 0.5 * reach * (velocity + axes @ end.twist[:3])
            end.wrench = self._wrench(end, min(time, float(np.nextafter(before, -np.inf))))
            end.momentum = at.momentum + 0.5 * reach * (applied + _inertial(end.attitude, end.position, end.wrench))
            linear, angular = end.momentum[:3], end.momentum[3:]
            own = np.concatenate([axes.T @ linear, axes.T @ (angular - rotations.cross(end.position, linear))])
            twist = np.asarray(np.linalg.solve(blocks.mass, own - blocks.coupling @ v), dtype=float)
            change = float(np.abs(twist - end.twist).max())
            end.twist = twist
            # Down to round-off, where the changes stop falling.
            if change >= last or change <= 1e-16 * float(np.abs(twist).max()):
                break
            last = change
        end.attitude = end.attitude / np.linalg.norm(end.attitude)
        return end

    def _wrench(self, at: HubMotion, time: float | None = None) -> Array:
        state = HubState(
            at.time if time is None else time,
            at.attitude,
            at.twist[3:],
            at.position,
            rotations.matrix(at.attitude) @ at.twist[:3],
            self._probes.read(at.q),
            self._probes.read(at.v),
        )
        return self._hub.wrench(state)

    def forces(self, q: Array, v: Array, spin: Array, internal: Array) -> Array:
        """All forces but those of accelerations: internal, damping, gyroscopic, centrifugal, inputs; shape (size,)."""
        equation, turning = self.equation, cross_matrix(spin)
        total = internal - equation.input_load + equation.inertia.load(turning @ turning)
        if equation.products.damped:
            total += equation.products.damping_product(v)
        if spin.any():
            total += equation.inertia.apply(2.0 * turning, v) + equation.inertia.apply(turning @ turning, q)
        return total

    def rates(self, blocks: RigidBlocks, end: HubMotion, v: Array, a: Array) -> Array:
        """Rigid accelerations at a state with elastic velocity and acceleration, shape (6,)."""
        return self._balance.rates(blocks, end.wrench, end.twist[3:], v, a)

    def blocks(self, q: Array) -> RigidBlocks:
        """Momentum blocks at elastic unknowns."""
        return self._balance.blocks(q)

    def _accelerations(self, at: HubMotion, blocks: RigidBlocks) -> tuple[Array, Array]:
        """Elastic and rigid accelerations that balance all forces."""
        free = self._balance.rates(blocks, at.wrench, at.twist[3:], at.v, np.zeros_like(at.q))
        forces = self.forces(at.q, at.v, at.twist[3:], self.equation.force(at.q))
        a = self._reduced_mass_solve(blocks, -forces - blocks.coupling.T @ free)
        return a, self._balance.rates(blocks, at.wrench, at.twist[3:], at.v, a)

    def _reduced_mass_solve(self, blocks: RigidBlocks, right: Array) -> Array:
        """Solve with ``M - B' R^-1 B``, the mass that a free hub leaves to the structure."""
        columns = np.array([self.equation.mass_solve(row) for row in blocks.coupling]).T
        first = self.equation.mass_solve(right)
        core = blocks.mass - blocks.coupling @ columns
        return first + columns @ np.linalg.solve(core, blocks.coupling @ first)

    def refresh(self, q: Array, scheme: StepScheme, size: float) -> None:
        """Factorize the structure's effective stiffness and prepare the hub's correction of rank six."""
        values = self.equation.system.tangent(q) + scheme.inertia.d * self.equation.inertia.mass_entries
        values += scheme.velocity.d * self.equation.damping_entries
        self._factor.factorize(values)
        blocks = self._balance.blocks(q)
        self._columns = np.array([self._factor.solve(row) for row in blocks.coupling]).T
        self._core[:] = np.linalg.inv(blocks.mass / scheme.inertia.d - blocks.coupling @ self._columns)
        self._coupling = blocks.coupling
        self._factor_size = size

    def usable_factor(self, size: float) -> bool:
        """Whether the last factors belong to this step size."""
        return self._factor.ready and self._factor_size == size

    def solve(self, right: Array) -> Array:
        """Apply the inverse of the effective stiffness, the hub's correction included."""
        first = self._factor.solve(right)
        return first + self._columns @ (self._core @ (self._coupling @ first))

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(self._factor)

    def energy(self, at: HubMotion) -> float:
        """Kinetic energy of hub and structure in the inertial frame [J]."""
        blocks = self._balance.blocks(at.q)
        rigid = 0.5 * float(at.twist @ blocks.mass @ at.twist) + float(at.twist @ (blocks.coupling @ at.v))
        return rigid + 0.5 * self.equation.products.mass_norm(at.v)


class _HubProblem:
    """Residual of one step as a function of the elastic increment."""

    def __init__(self, stepper: HubStepper, scheme: StepScheme, at: HubMotion, size: float, before: float) -> None:
        self._stepper, self._scheme, self._at, self._size, self._before = stepper, scheme, at, size, before
        self.scale = 0.0

    def residual(self, x: Array) -> tuple[Array, float]:
        stepper, scheme, at = self._stepper, self._scheme, self._at
        q, v, a = at.q + x, combine(scheme.velocity, x, at), combine(scheme.inertia, x, at)
        blocks = stepper.blocks(q)
        end = stepper.rigid(at, scheme.evaluation * self._size, blocks, q, v, self._before)
        if scheme.average_stress:
            internal = stepper.equation.average_force(at.q, at.q + x / scheme.evaluation)
        else:
            internal = stepper.equation.force(q)
        rigid = blocks.coupling.T @ stepper.rates(blocks, end, v, a)
        forces = stepper.forces(q, v, end.twist[3:], internal)
        inertia = stepper.equation.products.mass_product(a)
        norms = [float(np.linalg.norm(part)) for part in (internal, rigid, inertia)]
        self.scale = max(norms[0], norms[1])
        lost = 100.0 * float(np.finfo(float).eps) / stepper._tolerance * sum(norms)
        total = forces + rigid + inertia
        return total, relative_error(float(np.linalg.norm(total)), max(self.scale, lost, 1e-3 * stepper._scale))

    def refresh(self, x: Array) -> None:
        self._stepper.refresh(self._at.q + x, self._scheme, self._size)

    def ready(self) -> bool:
        return self._stepper.usable_factor(self._size)

    def solve(self, right: Array) -> Array:
        return self._stepper.solve(right)


def combine(c: Combination, d: Array, at: MotionState) -> Array:
    """Linear combination of increment, velocity and acceleration at the start of a step."""
    return c.d * d + c.v * at.v + c.a * at.a
