"""The prestressed reference state: where it comes from, how well it balances, and whether it is taut [theory.md 5]."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import PrestressError
from tautflex.mechanics.system import StructuralSystem, principal_values
from tautflex.solvers.linear import SymmetricFactorization
from tautflex.structure.model import Model

Array = NDArray[np.float64]

# Eigenvalues below this are called negative [rad^2/s^2]; rigid motions of a free structure are 0 +- round-off.
_STABILITY_SHIFT = (2.0 * np.pi * 1e-3) ** 2
# Compression, relative to the largest resultant, that is warned of but not refused.
_COMPRESSION_ALLOWED = 1e-3


@dataclass(frozen=True)
class PrestressedState:
    """Reference state about which modes and motion are computed.

    Parameters
    ----------
    system
        Structure with the initial stresses of this state.
    reference_force
        ``f_int(0)`` [N, N m], shape (size,); the equations use ``f_int(q) - reference_force``.
    residual
        Largest entry of ``reference_force`` [N]: the imbalance that the reference is assumed to carry.
    relative_residual
        Its ratio to the largest force of a cable or film element.
    unstable_modes
        Number of negative eigenvalues of the tangent.
    warnings
        What the user should know, in words.
    """

    system: StructuralSystem
    reference_force: Array
    residual: float
    relative_residual: float
    unstable_modes: int
    warnings: tuple[str, ...] = field(default=())

    @property
    def model(self) -> Model:
        """The structure."""
        return self.system.model

    @property
    def membrane_stress(self) -> Array:
        """Initial film stress (sx, sy, txy) in local axes [Pa], shape (t, 3)."""
        return self.system.stress_of("membrane", self.system.initial_stress)

    @property
    def cable_tension(self) -> Array:
        """Initial cable tension [N], shape (c,)."""
        pieces = [
            group.section.area * stress[:, 0]  # type: ignore[union-attr]
            for group, stress in zip(self.model.groups, self.system.initial_stress, strict=True)
            if group.section.kind == "cable"
        ]
        return np.concatenate(pieces) if pieces else np.zeros(0)

    @property
    def beam_axial_force(self) -> Array:
        """Initial axial force of the frame, tension positive [N], shape (b,)."""
        return self.system.stress_of("beam", self.system.initial_stress)[:, 0]

    @property
    def min_principal_stress(self) -> float:
        """Smallest principal film stress [Pa]; NaN without a film."""
        stress = self.membrane_stress
        return float(principal_values(stress)[:, 0].min()) if stress.shape[1] == 3 else float("nan")

    @property
    def min_principal_resultant(self) -> float:
        """Smallest principal film resultant [N/m]; NaN without a film."""
        values = self.system.principal_resultants(self.system.initial_stress)
        return float(values[:, 0].min()) if len(values) else float("nan")

    @cached_property
    def tangent_entries(self) -> Array:
        """Tangent stiffness of the reference in the pattern, shape (entries,)."""
        return self.system.tangent(np.zeros(self.system.size))


def solve_prestress(model: Model, check: bool = True) -> PrestressedState:
    """Find the prestressed reference state of a model.

    Parameters
    ----------
    model
        Structure with its given tensions and stresses; ``model.prestress_mode`` chooses how they are read.
    check
        Refuse states that are slack, compressed or unstable; False returns them for study, with warnings.

    Returns
    -------
    PrestressedState

    Raises
    ------
    PrestressError
        If there is no prestress, a cable is slack, a given film stress is compressive, or the state is unstable.
    """
    given = StructuralSystem(model)
    needs_tension = any(group.section.kind != "beam" for group in model.groups)
    if needs_tension and not any(np.any(stress) for stress in given.initial_stress):
        raise PrestressError(
            "prestress: expected some tension, got none; a film or cable without tension has no transverse stiffness "
            "(singular): give cable pretension or a membrane stress"
        )
    system = given if model.prestress_mode == "uniform" else _respond(given)
    reference, _ = system.force(np.zeros(system.size))
    residual = float(np.abs(reference).max(initial=0.0))
    state = PrestressedState(system, reference, residual, residual / _largest_force(system), 0)
    problems = _slack_cables(state) + _compressed_film(state, given_stress=model.prestress_mode == "uniform")
    unstable = count_unstable(state)
    warnings = [text for text, _ in problems]
    if unstable:
        warnings.append(_instability_text(state, unstable))
    state = replace(state, unstable_modes=unstable, warnings=tuple(warnings))
    if check and (unstable or any(fatal for _, fatal in problems)):
        raise PrestressError("prestress: " + "; ".join(warnings))
    return state


def _respond(given: StructuralSystem) -> StructuralSystem:
    """Initial stresses after the linear response to the given ones, in equilibrium on the reference shape."""
    keep_cables = given.model.prestress_mode == "initial-strain"
    blocks = tuple(
        block if keep_cables or block.kind != "cable" else replace(block, elasticity=np.zeros_like(block.elasticity))
        for block in given.blocks
    )
    slack = given.with_initial_stress([np.zeros_like(stress) for stress in given.initial_stress], blocks)
    stiffness = slack.tangent(np.zeros(given.size))
    load, _ = given.force(np.zeros(given.size))
    displacement = _solve_singular(slack, stiffness, -load)
    stress = [
        initial + np.einsum("nst,nt->ns", block.elasticity, strain)
        for initial, block, strain in zip(given.initial_stress, blocks, slack.linear_strain(displacement), strict=True)
    ]
    system = given.with_initial_stress(stress)
    left = float(np.abs(system.force(np.zeros(given.size))[0]).max(initial=0.0))
    if left > 1e-6 * _largest_force(system):
        raise PrestressError(
            f"prestress: expected a self-equilibrated state on the given shape, got an imbalance of {left:.3g} N; the "
            "cables pull where neither film, frame nor supports can answer: add supports or change their directions"
        )
    return system


def _solve_singular(system: StructuralSystem, stiffness: Array, load: Array) -> Array:
    """Solve K u = load where K may lack transverse and rigid stiffness that the load does not ask for.

    A small shift makes K definite; iterative refinement removes its effect from the stiff directions.
    """
    pattern = system.pattern
    diagonal = pattern.slots(np.arange(pattern.size), np.arange(pattern.size))
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


def _largest_force(system: StructuralSystem) -> float:
    """Largest force that one element's initial stress exerts on a node [N]."""
    largest = 0.0
    for block, stress in zip(system.blocks, system.initial_stress, strict=True):
        nodal = np.einsum("nid,n,ni->nd", block.gradient, block.measure, stress @ block.linear)
        largest = max(largest, float(np.abs(nodal).max(initial=0.0)))
    return largest or 1.0


def count_unstable(state: PrestressedState) -> int:
    """Number of negative eigenvalues of (K, M), counted by the pivots of K + shift M."""
    factor = SymmetricFactorization(state.system.pattern)
    try:
        factor.factorize(state.tangent_entries + _STABILITY_SHIFT * state.system.inertia.mass_entries)
    except np.linalg.LinAlgError:
        return 1
    return factor.negative_pivots()


def _slack_cables(state: PrestressedState) -> list[tuple[str, bool]]:
    tension = state.cable_tension
    slack = np.flatnonzero(tension < 0.0)
    if not slack.size:
        return []
    worst = int(np.argmin(tension))
    place = _point(state.model.nodes[state.model.cables[worst]].mean(axis=0))
    return [
        (
            f"cable {worst} at {place} is slack, tension {tension[worst]:.3g} N ({slack.size} of {tension.size} "
            "cables); raise its pretension or stiffen the frame",
            True,
        )
    ]


def _compressed_film(state: PrestressedState, given_stress: bool) -> list[tuple[str, bool]]:
    values = state.system.principal_resultants(state.system.initial_stress)
    if not len(values):
        return []
    largest = max(float(values[:, 1].max()), 0.0)
    compressed = np.flatnonzero(values[:, 0] < -1e-9 * largest)
    if not compressed.size:
        return []
    worst = int(np.argmin(values[:, 0]))
    place = _point(state.model.nodes[state.model.triangles[worst]].mean(axis=0))
    remedy = (
        "give tensile stresses (positive stress_x, stress_y)"
        if given_stress
        else "add cables along that edge, with tension = film resultant x spacing, or use the 'tributary' distribution"
    )
    text = (
        f"film element {worst} at {place} is compressed, smallest principal resultant {values[worst, 0]:.3g} N/m "
        f"({compressed.size} of {len(values)} elements); {remedy}"
    )
    # Whether a slightly compressed film buckles depends on the mesh; that no taut state exists does not.
    return [(text, bool(given_stress or values[worst, 0] < -_COMPRESSION_ALLOWED * largest))]


def _instability_text(state: PrestressedState, unstable: int) -> str:
    text = f"the state is unstable, {unstable} negative eigenvalue(s) of the tangent"
    strains = {group.section.strain for group in state.model.groups}
    if state.model.rigid_freedom and strains != {"green-lagrange"}:
        return (
            f"{text}; a free structure needs strain = 'green-lagrange' for film, cables and frame, or its prestress "
            "resists rigid rotations"
        )
    return f"{text}: no taut equilibrium exists here; use more cables or a stress field that is tensile everywhere"


def _point(position: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in position) + ") m"
