"""How film, cables and frame respond to given tensions on the reference shape [theory.md 5].

The geometry stays the reference one: the quadratic strain terms are left out, so what is solved is linear but for the
material laws, and a minimum of a convex energy with them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tautflex.elements import ElementBlock
from tautflex.elements.laws import Elastic
from tautflex.errors import PrestressError
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.nonlinear.minimum import find_minimum
from tautflex.solvers.nonlinear.newton import relative_error
from tautflex.solvers.static.softening import softened

_TOLERANCE, _ON_THE_WAY = 1e-10, 1e-6
# Of the largest diagonal entry: makes the transverse unknowns, which nothing moves, definite.
_SHIFT = 1e-12


def respond(given: StructuralSystem) -> StructuralSystem:
    """Initial stresses in equilibrium on the reference shape, from given ones.

    Parameters
    ----------
    given
        System with the given initial stresses; ``model.prestress_mode`` says whether cables respond.

    Returns
    -------
    StructuralSystem
        With the responded stresses; for nonlinear laws these are the elastic trial stresses, which keep the length
        of material taken up by wrinkles.

    Raises
    ------
    PrestressError
        If no equilibrium is found.
    """
    keep_cables = given.model.prestress_mode == "initial-strain"
    blocks = tuple(_flat(block, keep_cables) for block in given.blocks)
    start = [np.zeros_like(stress) for stress in given.initial_stress]
    linear = given.with_initial_stress(start, tuple(replace(block, law=Elastic()) for block in blocks))
    load, _ = given.force(np.zeros(given.size))
    if all(block.is_elastic for block in given.blocks):
        displacement = _solve_singular(linear, linear.tangent(np.zeros(given.size)), -load)
    else:
        displacement = _minimum(given, blocks)
    stress = [
        initial + np.einsum("nst,nt->ns", block.elasticity, strain)
        for initial, block, strain in zip(given.initial_stress, blocks, linear.linear_strain(displacement), strict=True)
    ]
    system = given.with_initial_stress(stress)
    workspace = system.workspace()
    left = float(np.abs(workspace.force(np.zeros(given.size))[0]).max(initial=0.0))
    if left > 1e-6 * largest_force(system, workspace.stress):
        raise PrestressError(
            f"prestress: expected a self-equilibrated state on the given shape, got an imbalance of {left:.3g} N; the "
            "cables pull where neither film, frame nor supports can answer: add supports or change their directions"
        )
    return system


def _flat(block: ElementBlock, keep_cables: bool) -> ElementBlock:
    """Block without its quadratic strain; cables whose tension is final do not respond."""
    flat = replace(block, quadratic=np.zeros_like(block.quadratic))
    if block.kind == "cable" and not keep_cables:
        return replace(flat, elasticity=np.zeros_like(block.elasticity), law=Elastic())
    return flat


class _FlatEnergy:
    """Energy of a system whose initial stresses include those of the cables."""

    def __init__(self, system: StructuralSystem, scale: float) -> None:
        self._workspace, self._scale = system.workspace(), scale

    def residual(self, x: Array) -> tuple[Array, float]:
        force, _ = self._workspace.force(x)
        return force, relative_error(float(np.linalg.norm(force)), self._scale)

    def tangent(self, x: Array) -> Array:
        return self._workspace.tangent(x)


def _minimum(given: StructuralSystem, blocks: tuple[ElementBlock, ...]) -> Array:
    """Minimum of the energy of nonlinear laws on the flat geometry, on the way that `softened` makes."""
    x = np.zeros(given.size)
    scale = float(np.linalg.norm(given.force(x)[0])) or largest_force(given, given.initial_stress)
    for stage in softened(blocks):
        system = given.with_initial_stress(given.initial_stress, stage)
        tolerance = _TOLERANCE if stage is blocks else _ON_THE_WAY
        x = find_minimum(_FlatEnergy(system, scale), given.pattern, x, tolerance, floor=_SHIFT).x
    return x


def _solve_singular(system: StructuralSystem, stiffness: Array, load: Array) -> Array:
    """Solve K u = load where K may lack transverse and rigid stiffness that the load does not ask for.

    A small shift makes K definite; iterative refinement removes its effect from the stiff directions.
    """
    pattern = system.pattern
    diagonal = pattern.diagonal
    shifted = stiffness.copy()
    shifted[diagonal] += 1e-10 * float(np.abs(stiffness[diagonal]).max())
    factor = SymmetricFactorization(pattern)
    factor.factorize(shifted)
    matrix, solution = pattern.matrix(stiffness), np.zeros(pattern.size)
    target = 1e-13 * float(np.linalg.norm(load))
    for _ in range(30):
        left = load - matrix @ solution
        if float(np.linalg.norm(left)) <= target:
            break
        solution = solution + factor.solve(left)
    return solution


def largest_force(system: StructuralSystem, stress: Iterable[Array]) -> float:
    """Largest force that one element's stress exerts on a node of the reference shape [N]."""
    largest = 0.0
    for block, values in zip(system.blocks, stress, strict=True):
        nodal = np.einsum("nid,n,ni->nd", block.gradient, block.measure, values @ block.linear)
        largest = max(largest, float(np.abs(nodal).max(initial=0.0)))
    return largest
