"""Directions in which the potential of a state falls, counted by pivots, and which eigenvalues count as zero."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.mechanics.membrane import membrane_states
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.linear.eigenpairs import count_below, lowest_eigenpairs, resolution
from tautflex.solvers.static.diagnosis import film_wrinkles

# Share of a taut film's lowest eigenvalue below which film is called slack.
_SLACK = 0.01


class Fall(NamedTuple):
    """Directions of falling potential: their number, lowest eigenvalue [rad^2/s^2] and its vector, shape (size,)."""

    directions: int
    eigenvalue: float
    vector: Array


def find_fall(system: StructuralSystem, stiffness: Array, q: Array, known: int | None = None) -> Fall | None:
    """Directions in which the potential falls about free unknowns q [m, rad], shape (size,); None if there is none.

    One factorization of ``stiffness``, values in the pattern, tells by its pivots (Sylvester's law of inertia) whether
    there are any, unless it is ``known``. Only then the lowest eigenpair of (stiffness, M) is sought.
    """
    count = count_falling(system, stiffness, q) if known is None else known
    if not count:
        return None
    values, vectors = lowest_eigenpairs(system.pattern, stiffness, system.inertia.mass_entries, 1)
    # Where pivoting had to take over, the count is a guess.
    return Fall(count, float(values[0]), vectors[0]) if values[0] < -zero_limit(system, stiffness, q) else None


def count_falling(system: StructuralSystem, stiffness: Array, q: Array) -> int:
    """Number of eigenvalues of (stiffness, M) that are negative, not just zero."""
    return count_below(system.pattern, stiffness, system.inertia.mass_entries, -zero_limit(system, stiffness, q))


def zero_limit(system: StructuralSystem, stiffness: Array, q: Array) -> float:
    """Eigenvalues nearer to zero than this count as zero [rad^2/s^2]: round-off, or those of slack film."""
    limit = resolution(system.pattern, stiffness, system.inertia.mass_entries)
    soft = film_wrinkles(system) and membrane_states(system, q).any()
    return max(limit, slack_limit(system, q)) if soft else limit


def slack_limit(system: StructuralSystem, q: Array) -> float:
    """Eigenvalues below this are those of slack film [rad^2/s^2]: a hundredth of a taut film's lowest.

    Slack film has no transverse stiffness: its eigenvalues are 0 -+ what the residual stiffness makes of them. The
    largest film stress s pulls a strip of the structure's length L straight with ``pi^2 s / (rho L^2)``.
    """
    length = float(np.ptp(system.model.nodes, axis=0).max())
    speeds = [
        float(np.abs(stress).max()) / block.material.density
        for block, stress in zip(system.blocks, system.stress(q), strict=True)
        if block.kind == "membrane"
    ]
    return _SLACK * np.pi**2 * max(speeds, default=0.0) / length**2
