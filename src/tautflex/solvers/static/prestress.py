"""The prestressed reference state: where it comes from, how well it balances, and whether it is taut [theory.md 5]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tautflex import checks
from tautflex.errors import PrestressError
from tautflex.mechanics.dampings.damping import LinearStructure
from tautflex.mechanics.membrane import (
    MembraneSurvey,
    membrane_states,
    principal_resultants,
    principal_values,
    survey_at,
)
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, within_arithmetic
from tautflex.solvers.linear.eigenpairs import NaturalModes, count_below
from tautflex.solvers.nonlinear.newton import relative_error
from tautflex.solvers.plausibility import (
    IMBALANCE,
    STILL,
    TURN,
    doubts_about_links,
    doubts_about_prestress,
    doubts_about_structure,
    imbalance_text,
)
from tautflex.solvers.static.diagnosis import (
    Problem,
    film_without_tension,
    find_problems,
    instability_text,
    loose_text,
    soft_text,
)
from tautflex.solvers.static.pivots import count_falling, slack_limit
from tautflex.solvers.static.residual import largest_force
from tautflex.solvers.static.tensioning import respond
from tautflex.structure.model import Model
from tautflex.text import card, count, span

# Imbalance that is not worth a note, relative to the largest force of an element.
_BALANCED = 1e-6


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
    notes
        What was chosen on purpose and has consequences, in words.
    """

    system: StructuralSystem
    reference_force: Array
    residual: float
    relative_residual: float
    unstable_modes: int
    warnings: tuple[str, ...] = field(default=())
    notes: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        film = self.min_principal_resultant
        lines = {
            "model": in_short(self),
            "film": "" if np.isnan(film) else f"smallest principal resultant {film:.4g} N/m",
            "cables": span(self.cable_tension, "N"),
            "imbalance": f"{self.residual:.3g} N, {self.relative_residual:.3g} of the largest element force",
            "stability": count(self.unstable_modes, "unstable mode") if self.unstable_modes else "stable",
            **{f"warning {number}": text for number, text in enumerate(self.warnings, start=1)},
        }
        return card(self, lines)

    @property
    def model(self) -> Model:
        """The structure."""
        return self.system.model

    @cached_property
    def stress(self) -> list[Array]:
        """Stresses of the reference, shapes (element, strain).

        They are the system's initial stresses, or what nonlinear laws make of those trial stresses.
        """
        if all(block.is_elastic for block in self.system.blocks):
            return list(self.system.initial_stress)
        return self.system.stress(np.zeros(self.system.size))

    @cached_property
    def membrane_states(self) -> NDArray[np.int8]:
        """0 taut, 1 wrinkled, 2 slack, per film element, shape (t,)."""
        return membrane_states(self.system)

    @property
    def wrinkled_fraction(self) -> float:
        """Part of the film's area that is wrinkled [-]; NaN without a film."""
        return self._survey.wrinkled

    @property
    def slack_fraction(self) -> float:
        """Part of the film's area that is slack [-]; NaN without a film."""
        return self._survey.slack

    @cached_property
    def _survey(self) -> MembraneSurvey:
        return survey_at(self.system, np.zeros(self.system.size)).membrane()

    @property
    def membrane_stress(self) -> Array:
        """Film stress (sx, sy, txy) in local axes at every integration point [Pa], shape (row, 3)."""
        return self.system.stress_of("membrane", self.stress)

    @property
    def cable_tension(self) -> Array:
        """Cable tension [N], shape (c,)."""
        pieces = [
            block.size * stress[:, 0]
            for block, stress in zip(self.system.blocks, self.stress, strict=True)
            if block.kind == "cable"
        ]
        return np.concatenate(pieces) if pieces else np.zeros(0)

    @property
    def beam_axial_force(self) -> Array:
        """Axial force of the frame, tension positive [N], shape (b,)."""
        found = [self.stress[index][:, 0] for index in self.system.block_index("beam")]
        return np.concatenate([np.zeros(0), *found])

    @property
    def min_principal_stress(self) -> float:
        """Smallest principal film stress [Pa]; NaN without a film."""
        stress = self.membrane_stress
        return float(principal_values(stress)[:, 0].min()) if stress.shape[1] == 3 else float("nan")

    @property
    def min_principal_resultant(self) -> float:
        """Smallest principal film resultant [N/m]; NaN without a film."""
        values = principal_resultants(self.system, self.stress)
        return float(values[:, 0].min()) if len(values) else float("nan")

    @cached_property
    def tangent_entries(self) -> Array:
        """Tangent stiffness of the reference in the pattern, shape (entries,)."""
        return self.system.tangent(np.zeros(self.system.size))

    @cached_property
    def linear(self) -> LinearStructure:
        """Mass, stiffness and natural modes of small motion, for dampings."""
        modes = NaturalModes(self.system.pattern, self.tangent_entries, self.system.inertia.mass_entries)
        return LinearStructure(self.system, self.tangent_entries, modes)


def in_short(state: PrestressedState) -> str:
    """Return what a card of something else says of a state, on one line."""
    model = state.model
    return f"{len(model.nodes)} nodes, {len(model.free_dofs)} unknowns, {model.mass:.4g} kg"


def require_state(state: object) -> None:
    """Raise InputError unless ``state`` is a prestressed state."""
    checks.instance("state", state, PrestressedState, "a prestressed state", remedy="solve_prestress(model) gives one")


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

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> f"{state.min_principal_resultant:.2f} N/m"
    '0.42 N/m'
    """
    checks.instance("model", model, Model, "a Model", remedy="build_model(case) and Model.from_mesh(...) give one")
    checks.flag("check", check)
    return prestressed(model, check, doubts_about_structure(model))


@within_arithmetic()
def prestressed(model: Model, check: bool, doubts: Sequence[str]) -> PrestressedState:
    """`solve_prestress` of a model whose doubts (`doubts_about_structure`) are known, as those of a tuned one are."""
    if not len(model.free_dofs):
        raise PrestressError(
            "prestress: expected nodes that can move, got supports that hold all of them; refine mesh.divisions, or "
            "hold fewer nodes"
        )
    given = StructuralSystem.from_model(model)
    needs_tension = any(group.section.kind != "beam" for group in model.groups)
    if check and needs_tension and not any(np.any(stress) for stress in given.initial_stress):
        raise PrestressError(
            "prestress: expected some tension, got none; a film or cable without tension has no transverse stiffness "
            "(singular): give cable pretension or a membrane stress"
        )
    system = given if model.prestress_mode == "uniform" else respond(given)
    workspace = system.workspace()
    rest = np.zeros(system.size)
    reference, _ = workspace.force(rest)
    residual = float(np.abs(reference).max(initial=0.0))
    relative = relative_error(residual, largest_force(system, workspace.stress))
    state = PrestressedState(system, reference, residual, relative, 0)
    resultants = principal_resultants(system, state.stress)
    fractions = state.wrinkled_fraction, state.slack_fraction
    problems = find_problems(system, state.cable_tension, resultants, state.membrane_states, fractions)
    unstable = count_falling(system, state.tangent_entries, rest)
    if unstable:
        problems.append(Problem(instability_text(model, unstable), True))
    elif soft := _count_soft(state):
        problems.append(Problem(soft_text(soft, np.sqrt(slack_limit(system, rest)) / (2.0 * np.pi)), False))
    elif (loose := film_without_tension(system, resultants)).size and (moving := _count_loose(state)):
        problems.append(Problem(loose_text(model, loose, moving), False))
    warnings = tuple(problem.text for problem in problems)
    if check and any(problem.fatal for problem in problems):
        raise PrestressError("prestress: " + "; ".join(warnings))
    found, notes = [*warnings, *doubts, *doubts_about_prestress(system)], list[str]()
    if state.relative_residual > (_BALANCED if model.prestress_stated else IMBALANCE):
        told = notes if model.prestress_stated else found
        told.append(imbalance_text(residual, state.relative_residual))
    else:
        found += doubts_about_links(system, state.tangent_entries)
    # The new state has caches of its own.
    return replace(state, unstable_modes=unstable, warnings=tuple(found), notes=tuple(notes))


def _count_loose(state: PrestressedState) -> int:
    """Number of motions, beside rigid ones, whose frequency is about 0 Hz."""
    system, limit = state.system, (TURN * STILL) ** 2
    count = count_below(system.pattern, state.tangent_entries, system.inertia.mass_entries, limit)
    return max(0, count - state.model.rigid_freedom)


def _count_soft(state: PrestressedState) -> int:
    """Number of motions, beside rigid ones, that wrinkled or slack film leaves almost without stiffness."""
    if not state.membrane_states.any() or all(block.is_elastic for block in state.system.blocks):
        return 0
    system = state.system
    limit = slack_limit(system, np.zeros(system.size))
    count = count_below(system.pattern, state.tangent_entries, system.inertia.mass_entries, limit)
    return max(0, count - state.model.rigid_freedom)
