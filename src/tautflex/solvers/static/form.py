"""Form finding: node positions in which chosen stresses balance each other [theory.md 5].

Stresses of constant size along lengths and areas that change are linear in the positions: a cable of force density
``T/L`` pulls at its ends by ``T/L`` times their distance [Schek, Comput. Methods Appl. Mech. Eng. 3 (1974) 115], a film
element by the stiffness that its stress gives it, which is taken anew at every new shape until its stress is the chosen
one there [Pauletti & Pimenta, Comput. Methods Appl. Mech. Eng. 197 (2008) 4151]. Nodes that slide within a film cost it
hardly anything, so that shapes settle slowly there; what the last shapes have told is extrapolated [Anderson 1965].
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tautflex import checks
from tautflex.elements.laws import Elastic
from tautflex.errors import InputError, MeshError, NotConvergedError
from tautflex.mechanics.membrane import principal_values
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.residual import largest_force
from tautflex.structure.groups import ElementGroup, Support
from tautflex.structure.model import Model

# Shapes that are extrapolated from.
_DEPTH = 10


def find_form(model: Model, *, tolerance: float = 1e-10, max_iterations: int = 200) -> Model:
    """Move the nodes of film and cables to where the given stresses balance each other.

    Nodes of the frame and supported directions stay. The film keeps its given stress; cables keep their force
    density, tension over length, so that their tensions change with their lengths. Masses weigh nothing, springs are
    without force in every shape.

    Parameters
    ----------
    model
        Structure with the stresses that its film and its cables shall have.
    tolerance
        Allowed imbalance over the largest force of an element, > 0.
    max_iterations
        Shapes that are tried.

    Returns
    -------
    Model
        With new positions and cable tensions; `tautflex.solve_prestress` lets its frame respond.

    Raises
    ------
    InputError
        If there are links, springs alone hold a part, nothing is taut, nothing can move, or a stress pushes.
    NotConvergedError
        If no such shape is found.

    Examples
    --------
    >>> import tautflex as tf
    >>> shape = tf.find_form(tf.build_model(tf.load_case("scalloped.toml")))
    >>> state = tf.solve_prestress(shape)
    >>> f"{state.min_principal_resultant:.3f} N/m"          # 2e5 Pa x 5e-5 m
    '10.000 N/m'
    """
    checks.instance("model", model, Model, "a Model", remedy="Model.from_mesh(...) gives one")
    checks.positive("tolerance", tolerance)
    if model.links:
        raise InputError(
            f"model: expected no links, which moving nodes would bend, got {len(model.links)}; find the form of the "
            "parts before they are linked"
        )
    soft = [group for group in model.groups if group.section.kind != "beam"]
    if not soft:
        raise InputError("model: expected film or cables, whose form can be found, got beams alone")
    _require_taut(soft)
    shape, history, seen = _of_soft_parts(model), [], _Extrapolation()
    place, factor = shape.free_places[shape.translation_dofs], None
    densities = [_density(shape.nodes, group) for group in shape.groups]
    try:
        for _ in range(checks.whole("max_iterations", max_iterations, 1)):
            system = _without_stiffness(shape)
            force, _ = system.force(np.zeros(system.size))
            history.append(float(np.abs(force).max()) / largest_force(system, system.initial_stress))
            if history[-1] <= tolerance:
                return _with_form(model, shape)
            factor = factor or SymmetricFactorization(system.pattern)
            factor.factorize(system.tangent(np.zeros(system.size)))
            moved = np.append(seen.extrapolated(-factor.solve(force)), 0.0)[place]
            shape = _moved(shape, shape.nodes + moved, densities)
    except (MeshError, np.linalg.LinAlgError):
        pass  # an element has lost its area: there is no such shape, or none from here
    raise NotConvergedError(
        f"form: expected a shape in which the given stresses balance to {tolerance:g} of the largest force, got "
        f"{history[-1]:.3g} after {len(history)} shapes; the chosen stresses may have no such shape: change the "
        "tensions of cables against the film's stress",
        shape.nodes,
        tuple(history),
    )


class _Extrapolation:
    """Steps of a fixed-point iteration, corrected by what the last ones have changed."""

    def __init__(self) -> None:
        self._steps: list[Array] = []
        self._answers: list[Array] = []

    def extrapolated(self, answer: Array) -> Array:
        """Step in place of the iteration's own one, shape (size,)."""
        if self._steps:
            self._answers.append(answer)
            changes = np.diff(self._answers, axis=0)[-_DEPTH:]
            weights = np.linalg.lstsq(changes.T, answer, rcond=1e-10)[0]
            step = answer - weights @ (np.array(self._steps[-len(changes) :]) + changes)
        else:
            self._answers, step = [answer], answer
        self._steps.append(step)
        return np.asarray(step)


def _with_form(model: Model, shape: Model) -> Model:
    """The model with a shape's positions and its cables' tensions."""
    groups = zip(model.groups, shape.groups, strict=True)
    kept = tuple(replace(own, initial=found.initial) for own, found in groups)
    return replace(model, nodes=shape.nodes, groups=kept)


def _moved(shape: Model, nodes: Array, densities: list[Array | None]) -> Model:
    """Shape with other positions, its cables at their densities."""
    groups = tuple(
        group if density is None else replace(group, initial=density * _length(nodes, group))
        for group, density in zip(shape.groups, densities, strict=True)
    )
    return replace(shape, nodes=nodes, groups=groups)


def _require_taut(groups: list[ElementGroup]) -> None:
    """Raise InputError if a chosen stress pushes or all are zero."""
    for group in groups:
        pushing = principal_values(group.initial)[:, 0] if group.section.kind == "membrane" else group.initial[:, 0]
        if np.any(pushing < 0.0):
            raise InputError(
                f"model: expected stresses that pull, got {pushing.min():.3g} in a {group.section.kind}; a film or "
                "cable that pushes has no form"
            )
    if not any(np.any(group.initial) for group in groups):
        raise InputError("model: expected stresses to balance, got none; give membrane_stress and cable_tension")


def _of_soft_parts(model: Model) -> Model:
    """Structure whose frame is held, under strains that make stresses linear in the positions."""
    turning = np.flatnonzero(np.diff(model.dof_offset) > 3)
    held = (*model.supports, Support.clamped(turning)) if turning.size else model.supports
    groups = tuple(replace(group, section=replace(group.section, strain="green-lagrange")) for group in model.groups)
    try:
        found = replace(model, groups=groups, supports=held, masses=(), springs=(), prestress_mode="uniform")
    except MeshError as error:
        raise InputError(
            "model: expected film and cables that reach supports or a frame, got a piece that springs alone hold, "
            "which have no force in the shape that is sought; hold it by cables"
        ) from error
    if not len(found.free_dofs):
        raise InputError("model: expected nodes that can move, got supports and a frame that hold all of them")
    return found


def _without_stiffness(shape: Model) -> StructuralSystem:
    """The structure as its given stresses alone make it."""
    system = StructuralSystem.from_model(shape)
    blocks = tuple(replace(block, elasticity=np.zeros_like(block.elasticity), law=Elastic()) for block in system.blocks)
    return system.with_initial_stress(system.initial_stress, blocks)


def _density(nodes: Array, group: ElementGroup) -> Array | None:
    """Tension over length of cables [N/m], shape (cable, 1); None of other elements."""
    return group.initial / _length(nodes, group) if group.section.kind == "cable" else None


def _length(nodes: Array, group: ElementGroup) -> Array:
    """Length of two-node elements [m], shape (element, 1)."""
    return np.asarray(group.shape.measure(nodes[group.connectivity])[:, None])
