"""What time stepping asks of a plant: the equation of motion (49) of a run, its numbers possibly traced.

Shapes are those of one run. A plant whose equation is that of many runs side by side has them as one more, last axis;
whatever works on states is written for both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
from jax import lax

from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.library import jax
from tautflex.batch.steps.grid import Instants

Array = jax.Array


class Forces(NamedTuple):
    """All forces but inertia (n,), and the norms of the internal force and of the load of the moving frame.

    Residuals are measured against the norms.
    """

    total: Array
    internal: Array
    load: Array


Sample = dict[str, Array]
"""What is stored of an instant: any of the names in `STORED`."""

STORED = ("displacement", "velocity", "energy")


class Equation(Protocol):
    """``M a + P(q, v, t) = 0``."""

    def predicted(self, q: Array, v: Array, spin: Spin) -> Any:
        """What a step takes at its predicted state, because it is small and smooth; handed to `forces`."""
        ...

    def forces(self, q: Array, v: Array, spin: Spin, predicted: Any) -> Forces:
        """All forces but inertia."""
        ...

    def frame(self, q: Array, v: Array, spin: Spin) -> Array:
        """Part of the forces that jumps with the motion, shape (n,)."""
        ...

    def mass(self, a: Array) -> Array:
        """Mass times acceleration, shape (n,)."""
        ...

    def mass_solve(self, force: Array) -> Array:
        """Acceleration of a force, shape (n,)."""
        ...

    def inverse(self, mass: Any, damping: Any, stiffness: Any) -> Callable[[Array], Array]:
        """Symmetric approximate inverse of ``mass M + damping C + stiffness K`` at the reference."""
        ...

    def sample(self, q: Array, v: Array, spin: Spin, store: tuple[str, ...]) -> Sample:
        """Displacement and velocity of the probes, shape (probe, 3), kinetic and strain energy, shape (2,)."""
        ...


class Jump(NamedTuple):
    """What a jump of the motion does to acceleration and forces, and whether there is one."""

    acceleration: Array
    forces: Array
    there: Array


def as_kind(kind: Any, parts: Any) -> Any:
    """The same with all real arrays, in whatever tuples, in a floating-point type such as ``jax.numpy.float32``."""

    def leaf(part: Any) -> Any:
        return jnp.asarray(part, kind) if jnp.issubdtype(getattr(part, "dtype", bool), jnp.floating) else part

    return jax.tree.map(leaf, parts)


def jump_of(equation: Equation, q: Array, v: Array, step: Instants) -> Jump:
    """Jump at the end of a step, where the acceleration takes up that of the forces."""

    def jump(q: Array, v: Array) -> Jump:
        change = equation.frame(q, v, step.change)
        there = step.jump & jnp.any(change != 0.0, axis=0)
        change = jnp.where(there, change, 0.0)
        return Jump(equation.mass_solve(-change), change, there)

    def none(q: Array, v: Array) -> Jump:
        return Jump(jnp.zeros_like(q), jnp.zeros_like(q), jnp.zeros(q.shape[1:], bool))

    return lax.cond(jnp.any(step.jump), jump, none, q, v)


@dataclass(frozen=True)
class EachRun:
    """How a function of one run's numbers is applied to all runs.

    These are the last axis of every array, and the axis ``results`` of what comes out; with None there is one run and
    no such axis. The numbers that ``differ`` have one row per run.
    """

    runs: int | None = None
    differ: frozenset[str] = frozenset()
    results: int = -1

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """``function(numbers, *arrays)`` for all runs: numbers by the first axis, arrays by the last."""
        if self.runs is None:
            return function
        places = jnp.arange(self.runs)

        def of_all(numbers: dict[str, Any], *arrays: Any) -> Any:
            axes = {name: 0 if name in self.differ else None for name in numbers}
            mapped = jax.vmap(
                lambda numbers, _, *arrays: function(numbers, *arrays),
                in_axes=(axes, 0, *(-1 for _ in arrays)),
                out_axes=self.results,
            )
            return mapped(numbers, places, *arrays)  # type: ignore[no-untyped-call]

        return of_all


def damping_kinds(numbers: Mapping[str, Any], kinds: Iterable[str]) -> dict[str, tuple[Any, Any]]:
    """Factors of a damping by kind of element, as `DampingMatrix.kinds` has them."""
    names = {kind: (f"damping.mass.{kind}", f"damping.stiffness.{kind}") for kind in kinds}
    return {kind: (numbers[mass], numbers[stiff]) for kind, (mass, stiff) in names.items() if mass in numbers}
