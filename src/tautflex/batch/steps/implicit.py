"""Implicit methods on a batch: the stages of any method of the NumPy model that takes no average stress."""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import jax.numpy as jnp
import numpy as np

from tautflex.batch.equations.equation import Equation, Sample, jump_of
from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.library import jax
from tautflex.batch.steps.grid import Instants
from tautflex.batch.steps.products import norm
from tautflex.batch.steps.roots import Memory, empty_memory, find_root
from tautflex.solvers.transient.methods.scheme import Combination, Method, Stage

Array = jax.Array

# As in the single run: the force scale never falls below this part of the largest one met.
_SCALE_FLOOR = 1e-3
_ROUND_OFF = 100.0


class ImplicitState(NamedTuple):
    """State between steps."""

    q: Array
    v: Array
    a: Array
    jerk: Array
    forces: Array
    largest: Array
    alive: Array
    iterations: Array
    memory: tuple[Memory, ...]


class ImplicitMarch:
    """Steps of a run, or of many: nominal size [s], residual norm over force scale, pairs that acceleration keeps."""

    block = 64

    def __init__(self, equation: Equation, method: Method, time_step: float, tolerance: float, depth: int) -> None:
        self.equation, self._method = equation, method
        self._time_step, self._tolerance, self._depth = time_step, tolerance, depth
        self._tangents = method.tangents
        shares = [stage.share for stage in method.stages(time_step)]
        starts = np.cumsum([0.0, *shares[:-1]])
        stages = zip(starts, method.stages(time_step), strict=True)
        self.evaluations = tuple(float(start + stage.share * stage.scheme.evaluation) for start, stage in stages)

    def start(self, q: Array, v: Array, spin: Spin) -> ImplicitState:
        """Acceleration that balances all forces at t = 0."""
        e = self.equation
        forces = e.forces(q, v, spin, e.predicted(q, v, spin))
        zero = jnp.zeros(q.shape[1:], q.dtype)
        memory = tuple(empty_memory(self._depth, q) for _ in range(max(self._tangents) + 1))
        a = e.mass_solve(-forces.total)
        return ImplicitState(q, v, a, jnp.zeros_like(q), forces.total, zero, jnp.ones(q.shape[1:], bool), zero, memory)

    def motion(self, at: ImplicitState, spin: Spin) -> Spin:
        """It is prescribed."""
        return spin

    def beside(self, at: ImplicitState) -> Sample:
        """Nothing."""
        return {}

    def check(self, at: ImplicitState, first: Instants) -> ImplicitState:
        """Nothing has to be checked now and then."""
        return at

    def step(self, at: ImplicitState, step: Instants) -> ImplicitState:
        """One step; a step without length only lets the motion jump."""
        # The coefficients are plain arithmetic of the step, which may be traced.
        stages = self._method.stages(cast(float, jnp.where(step.real, step.size, self._time_step)))
        passed = [at]
        for stage, tangent, spin in zip(stages, self._tangents, step.spins, strict=True):
            passed.append(self._solve(passed, stage, tangent, spin, step))
        end, h0, real = passed[-1], step.size, step.real
        passing = at._replace(q=at.q + h0 * at.v, v=at.v + h0 * at.a, a=at.a + h0 * at.jerk)
        parts: Any = zip(at._fields[:6], end, passing, strict=False)  # all but whether it goes on, counts and memory
        chosen: dict[str, Any] = {name: jnp.where(real, new, old) for name, new, old in parts}
        moved = end._replace(**chosen)
        jump = jump_of(self.equation, moved.q, moved.v, step)
        return moved._replace(
            a=moved.a + jump.acceleration,
            jerk=jnp.where(jump.there, 0.0, moved.jerk),
            forces=moved.forces + jump.forces,
        )

    def _solve(
        self, passed: list[ImplicitState], stage: Stage, tangent: int, spin: Spin, step: Instants
    ) -> ImplicitState:
        """State at the end of a stage; of a step without length only memory and counts are of use."""
        e, at, scheme = self.equation, passed[-1], stage.scheme
        h = stage.share * jnp.where(step.real, step.size, self._time_step)
        start_v, start_a = stage.recalled(passed)
        v_known = scheme.velocity.v * start_v + scheme.velocity.a * start_a
        known = e.mass(scheme.inertia.v * start_v + scheme.inertia.a * start_a) + (1.0 - scheme.weight) * at.forces
        known_norm = norm(known)
        reach = scheme.evaluation * h
        guess = reach * at.v + 0.5 * reach**2 * at.a + reach**3 / 6.0 * at.jerk
        predicted = e.predicted(at.q + guess, scheme.velocity.d * guess + v_known, spin)

        def residual(d: Array) -> tuple[Array, Array]:
            forces = e.forces(at.q + d, scheme.velocity.d * d + v_known, spin, predicted)
            inertia = scheme.inertia.d * e.mass(d)
            scale = scheme.weight * jnp.maximum(forces.internal, forces.load)
            # Inertia forces of a tiny step cancel each other; nothing below their round-off can be asked for.
            lost = _ROUND_OFF * float(np.finfo(d.dtype).eps) / self._tolerance * (known_norm + norm(inertia))
            scale = jnp.maximum(jnp.maximum(scale, lost), _SCALE_FLOOR * at.largest)
            return inertia + known + scheme.weight * forces.total, jax.lax.stop_gradient(scale)

        inverse = e.inverse(scheme.inertia.d, scheme.weight * scheme.velocity.d, scheme.weight)
        root = find_root(residual, guess, inverse, at.memory[tangent], self._tolerance, at.alive & step.real)
        d = root.x

        def combined(c: Combination) -> Array:
            return c.d * d + c.v * start_v + c.a * start_a

        forces = at.forces
        if scheme.weight < 1.0:
            # At a root the residual has no derivative; its value keeps errors from adding up over the steps.
            inertia = e.mass(combined(scheme.inertia))
            forces = (root.residual - inertia - (1.0 - scheme.weight) * at.forces) / scheme.weight
        a = combined(scheme.end_acceleration)
        return ImplicitState(
            at.q + combined(scheme.end_displacement),
            combined(scheme.end_velocity),
            a,
            (a - at.a) / h,
            forces,
            jnp.maximum(at.largest, root.scale),
            at.alive & (root.converged | ~step.real),
            at.iterations + root.iterations,
            tuple(root.memory if n == tangent else memory for n, memory in enumerate(at.memory)),
        )


def static_start(equation: Equation, spin: Any, tolerance: float, depth: int, shape: tuple[int, ...]) -> Any:
    """Steady equilibrium under a constant spin, and whether it was found; ``shape`` is that of the unknowns."""
    still = jnp.zeros(shape)

    def residual(q: Array) -> tuple[Array, Array]:
        forces = equation.forces(q, still, spin, equation.predicted(q, still, spin))
        scale = jnp.maximum(forces.internal, forces.load)
        return forces.total, jax.lax.stop_gradient(jnp.where(scale > 0.0, scale, 1.0))

    inverse = equation.inverse(0.0, 0.0, 1.0)
    root = find_root(residual, still, inverse, empty_memory(depth, still), tolerance, jnp.ones(shape[1:], bool))
    return root.x, root.converged
