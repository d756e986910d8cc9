"""What an element is to the rest of the code: constant arrays.

With nodal unknowns ``q`` of one element, its gradients are ``g = gradient @ q``, its strains are quadratic,
``strain = linear @ g + 1/2 g . quadratic . g``, and its energy is
``measure * (initial_stress . strain + 1/2 strain . elasticity . strain)`` [theory.md 2].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InertiaPoints:
    """Mass as weighted points, exact for the products of interpolations that inertia needs.

    Parameters
    ----------
    mass
        Mass of each point [kg], shape (element, point).
    interpolation
        Displacement of each point from the element's unknowns, global axes, shape (element or 1, point, 3, dof).
    position
        Reference position of each point [m], shape (element, point, 3).
    """

    mass: Array
    interpolation: Array
    position: Array


@dataclass(frozen=True)
class ElementBlock:
    """All elements of one group as data.

    Parameters
    ----------
    kind
        Name of the declaration.
    dofs
        Unknowns of each element, shape (element, dof).
    gradient
        Gradient matrix of each element, global axes, shape (element, gradient, dof).
    linear
        Linear strain coefficients, shape (strain, gradient).
    quadratic
        Quadratic strain coefficients, symmetric in the last two axes, shape (strain, gradient, gradient).
    elasticity
        Elastic matrix, shape (element, strain, strain); SI units that make measure * stress * strain an energy.
    initial_stress
        Stress at zero unknowns, shape (element, strain).
    measure
        Volume or length of each element, shape (element,).
    inertia
        Mass points.
    axes
        Local axes as rows, shape (element, 3, 3).
    law
        ``"elastic"`` or a name of :mod:`tautflex.elements.laws`, which then acts on the elastic trial stress.
    law_parameters
        Young's modulus [Pa], Poisson ratio, and the share of the elastic law left where it would compress.
    """

    kind: str
    dofs: NDArray[np.int64]
    gradient: Array
    linear: Array
    quadratic: Array
    elasticity: Array
    initial_stress: Array
    measure: Array
    inertia: InertiaPoints
    axes: Array
    law: str = "elastic"
    law_parameters: tuple[float, float, float] = (0.0, 0.0, 0.0)


def symmetric_terms(strains: int, gradients: int, terms: list[tuple[int, int, int, float]]) -> Array:
    """Quadratic coefficients such that ``strain[s] += c * g[i] * g[j]`` for every term (s, i, j, c)."""
    quadratic = np.zeros((strains, gradients, gradients))
    for strain, i, j, coefficient in terms:
        quadratic[strain, i, j] += coefficient
        quadratic[strain, j, i] += coefficient
    return quadratic
