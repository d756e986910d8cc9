"""How film, cables and frame respond to given tensions on the reference shape [theory.md 5].

The geometry stays the reference one: the quadratic strain terms are left out, so what is solved is linear but for the
material laws, and a minimum of a convex energy with them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tautflex.elements import ElementBlock
from tautflex.elements.laws import Elastic
from tautflex.errors import PrestressError
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.nonlinear.minimum import find_minimum
from tautflex.solvers.static.residual import StaticResidual, largest_force
from tautflex.solvers.static.softening import softened

_TOLERANCE, _ON_THE_WAY = 1e-12, 1e-6
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
    """Block without its quadratic strain and the turning of its frame; cables whose tension is final do not respond."""
    flat = replace(block, quadratic=np.zeros_like(block.quadratic), turns=False)
    if block.kind == "cable" and not keep_cables:
        return replace(flat, elasticity=np.zeros_like(block.elasticity), law=Elastic())
    return flat


def _minimum(given: StructuralSystem, blocks: tuple[ElementBlock, ...]) -> Array:
    """Minimum of the energy on the flat geometry, on the way that `softened` makes."""
    problem, x = StaticResidual(given, np.zeros(given.size), _TOLERANCE), np.zeros(given.size)
    for stage in softened(blocks):
        problem.use(stage)
        tolerance = _TOLERANCE if stage is blocks else _ON_THE_WAY
        x = find_minimum(problem, given.pattern, x, tolerance, floor=_SHIFT).x
    return x
