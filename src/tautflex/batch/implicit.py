"""Implicit one-step methods on a batch: any method of the NumPy model that gives a `StepScheme`."""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import jax.numpy as jnp
import numpy as np

from tautflex.batch.course import Course, Numbers
from tautflex.batch.equation import Equation
from tautflex.batch.grid import SLACK, Steps
from tautflex.batch.library import jax
from tautflex.batch.roots import Memory, empty_memory, find_root
from tautflex.solvers.integrator import Combination, ImplicitMethod

Array = jax.Array

# As in the single run: the force scale never falls below this part of the largest one met.
_SCALE_FLOOR = 1e-3
_ROUND_OFF = 100.0 * float(np.finfo(float).eps)


class Walker(NamedTuple):
    """State between steps."""

    q: Array
    v: Array
    a: Array
    jerk: Array
    forces: Array
    largest: Array
    alive: Array
    iterations: Array
    memory: Memory


def combine(c: Combination, d: Array, v: Array, a: Array) -> Array:
    """Linear combination of increment, velocity and acceleration."""
    return c.d * d + c.v * v + c.a * a


class ImplicitWalk:
    """Steps of one run.

    Parameters
    ----------
    equation
        Of the run.
    method
        Integrator.
    course, numbers
        Maneuver and its numbers.
    time_step
        Nominal step [s].
    tolerance
        Residual norm over force scale.
    depth
        Secants kept.
    """

    def __init__(
        self,
        equation: Equation,
        method: ImplicitMethod,
        course: Course,
        numbers: Numbers,
        time_step: float,
        tolerance: float,
        depth: int,
    ) -> None:
        self._equation, self._method, self._course, self._numbers = equation, method, course, numbers
        self._time_step, self._tolerance, self._depth = time_step, tolerance, depth

    def start(self, q: Array, v: Array) -> Walker:
        """Acceleration that balances all forces at t = 0."""
        e = self._equation
        spin = self._course.spin(self._numbers, 0.0, SLACK * self._time_step)
        forces = e.forces(q, v, spin, e.predicted(q, v, spin))
        zero = jnp.zeros(())
        return Walker(
            q,
            v,
            e.mass_solve(-forces.total),
            jnp.zeros_like(q),
            forces.total,
            zero,
            jnp.ones((), bool),
            zero,
            empty_memory(e.size, self._depth),
        )

    def step(self, at: Walker, step: Steps) -> Walker:
        """One step; a step without length only lets the motion jump."""
        e = self._equation
        real = step.size > SLACK * self._time_step
        h = jnp.where(real, step.size, self._time_step)
        # The coefficients are plain arithmetic of the step, which may be traced.
        scheme = self._method.scheme(cast(float, h))
        edge = step.start + step.size
        middle = jnp.minimum(step.start + 0.5 * step.size, edge - SLACK * self._time_step)
        spin = self._course.spin(self._numbers, step.start + scheme.evaluation * h, middle)
        v_known = scheme.velocity.v * at.v + scheme.velocity.a * at.a
        known = e.mass(scheme.inertia.v * at.v + scheme.inertia.a * at.a) + (1.0 - scheme.weight) * at.forces
        known_norm = jnp.linalg.norm(known)
        reach = scheme.evaluation * h
        guess = reach * at.v + 0.5 * reach**2 * at.a + reach**3 / 6.0 * at.jerk
        predicted = e.predicted(at.q + guess, scheme.velocity.d * guess + v_known, spin)

        def residual(d: Array) -> tuple[Array, Array]:
            forces = e.forces(at.q + d, scheme.velocity.d * d + v_known, spin, predicted)
            inertia = scheme.inertia.d * e.mass(d)
            scale = scheme.weight * jnp.maximum(forces.internal, forces.load)
            # Inertia forces of a tiny step cancel each other; nothing below their round-off can be asked for.
            lost = _ROUND_OFF / self._tolerance * (known_norm + jnp.linalg.norm(inertia))
            scale = jnp.maximum(jnp.maximum(scale, lost), _SCALE_FLOOR * at.largest)
            return inertia + known + scheme.weight * forces.total, jax.lax.stop_gradient(scale)

        inverse = e.inverse(scheme.inertia.d, scheme.weight * scheme.velocity.d, scheme.weight)
        active = at.alive & real
        root = find_root(residual, guess, inverse, at.memory, self._tolerance, active)
        d = root.x
        forces = at.forces
        if scheme.weight < 1.0:
            # At a root the residual has no derivative; its value keeps errors from adding up over the steps.
            inertia_force = e.mass(combine(scheme.inertia, d, at.v, at.a))
            forces = (root.residual - inertia_force - (1.0 - scheme.weight) * at.forces) / scheme.weight
        a = combine(scheme.end_acceleration, d, at.v, at.a)
        h0 = step.size
        moved = Walker(
            jnp.where(real, at.q + combine(scheme.end_displacement, d, at.v, at.a), at.q + h0 * at.v),
            jnp.where(real, combine(scheme.end_velocity, d, at.v, at.a), at.v + h0 * at.a),
            jnp.where(real, a, at.a + h0 * at.jerk),
            jnp.where(real, (a - at.a) / h, at.jerk),
            jnp.where(real, forces, at.forces),
            jnp.where(real, jnp.maximum(at.largest, root.scale), at.largest),
            at.alive & (root.converged | ~real),
            at.iterations + root.iterations,
            root.memory,
        )
        return self._jump(moved, edge, middle, step.jump)

    def _jump(self, at: Walker, edge: Array, before: Array, jumps: Array) -> Walker:
        """Let the acceleration take up the jump of the forces; the jerk starts anew."""
        e = self._equation
        after = edge + SLACK * self._time_step
        old = self._course.spin(self._numbers, edge, before)
        change = e.frame(at.q, at.v, self._course.spin(self._numbers, edge, after).minus(old))
        jumps = jumps & jnp.any(change != 0.0)
        change = jnp.where(jumps, change, 0.0)
        return at._replace(
            a=at.a + e.mass_solve(-change),
            jerk=jnp.where(jumps, 0.0, at.jerk),
            forces=at.forces + change,
        )


def static_start(equation: Equation, spin: Any, tolerance: float, depth: int) -> tuple[Array, Array]:
    """Steady equilibrium under a constant spin, and whether it was found."""
    still = jnp.zeros(equation.size)

    def residual(q: Array) -> tuple[Array, Array]:
        forces = equation.forces(q, still, spin, equation.predicted(q, still, spin))
        scale = jnp.maximum(forces.internal, forces.load)
        return forces.total, jax.lax.stop_gradient(jnp.where(scale > 0.0, scale, 1.0))

    root = find_root(
        residual,
        jnp.zeros(equation.size),
        equation.inverse(0.0, 0.0, 1.0),
        empty_memory(equation.size, depth),
        tolerance,
        jnp.ones((), bool),
    )
    return root.x, root.converged
