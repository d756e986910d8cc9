"""What time stepping asks of a plant: the equation of motion (49) of one run, its numbers possibly traced."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from tautflex.batch.course import Course, Spin
from tautflex.batch.library import jax
from tautflex.motion.coupling import Coupling
from tautflex.solvers.prestress import PrestressedState

Array = jax.Array


class Forces(NamedTuple):
    """All forces but inertia, and the norms that residuals are measured against.

    Parameters
    ----------
    total
        Shape (n,).
    internal
        Norm of the internal force.
    load
        Norm of the load of the moving frame.
    """

    total: Array
    internal: Array
    load: Array


Sample = dict[str, Array]
"""What is stored of an instant: any of the names in `STORED`."""

STORED = ("displacement", "velocity", "energy")


class Equation(Protocol):
    """``M a + P(q, v, t) = 0`` of one run."""

    size: int

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


class Plant(Protocol):
    """A structure that a batch can run."""

    state: PrestressedState
    size: int
    kinds: tuple[str, ...]
    secants: int
    """Number of secants that its iterations keep."""

    def equation(self, numbers: dict[str, Any], course: Course, coupling: Coupling, probes: Any) -> Equation:
        """Equation of one run."""
        ...
