"""What is wrong with a prestressed state, where, and what to do about it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.plausibility import place_of
from tautflex.structure.model import Model

# Compression, relative to the largest resultant, that is warned of but not refused.
_COMPRESSION_ALLOWED = 1e-3
# Strain below which film has no tension worth the name.
_NO_STRAIN = 1e-9


class Problem(NamedTuple):
    """One finding: a sentence, and whether the state is refused for it."""

    text: str
    fatal: bool


def find_problems(
    system: StructuralSystem,
    tension: Array,
    resultants: Array,
    states: NDArray[np.int8],
    fractions: tuple[float, float],
) -> list[Problem]:
    """Slack cables and film that is compressed, wrinkled or slack.

    Parameters
    ----------
    system
        The structure.
    tension
        Tension of each cable [N], shape (c,).
    resultants
        Smaller and larger principal resultant of each film element [N/m], shape (t, 2).
    states
        0 taut, 1 wrinkled, 2 slack, per film element, shape (t,).
    fractions
        Parts of the film's area that are wrinkled and slack.
    """
    if film_wrinkles(system):
        return _slack_cables(system, tension) + _wrinkled_film(system.model, states, fractions)
    return _slack_cables(system, tension) + _compressed_film(system.model, resultants)


def film_wrinkles(system: StructuralSystem) -> bool:
    """Whether a law lets film wrinkle instead of carrying compression."""
    return any(block.kind == "membrane" and block.law.tension_only for block in system.blocks)


def _slack_cables(system: StructuralSystem, tension: Array) -> list[Problem]:
    slack = np.flatnonzero(tension < 0.0)
    if not slack.size:
        return []
    cables = [block for block in system.blocks if block.kind == "cable"]
    may_be_slack = np.repeat([block.law.tension_only for block in cables], [len(block.dofs) for block in cables])
    worst = int(slack[np.argmin(tension[slack])])
    place = place_of(system.model, "cable", worst)
    count = f"{slack.size} of {tension.size} cables"
    if may_be_slack[slack].all():
        nothing = f"cable {worst} at {place} is slack ({count}) and carries nothing"
        return [Problem(nothing, bool(slack.size == tension.size))]
    text = f"cable {worst} at {place} is slack, tension {tension[worst]:.3g} N ({count})"
    return [Problem(f"{text}; raise its pretension, stiffen the frame, or let it go slack (cables.slack = true)", True)]


def _compressed_film(model: Model, values: Array) -> list[Problem]:
    if not len(values):
        return []
    largest = max(float(values[:, 1].max()), 0.0)
    compressed = np.flatnonzero(values[:, 0] < -1e-9 * largest)
    if not compressed.size:
        return []
    worst = int(np.argmin(values[:, 0]))
    place = place_of(model, "membrane", worst)
    given = model.prestress_mode == "uniform"
    remedy = (
        "give tensile stresses (positive stress_x, stress_y)"
        if given
        else "add cables along that edge, with tension = film resultant x spacing, or use the 'tributary' "
        "distribution, or let the film wrinkle (membrane.law = 'tension-field')"
    )
    text = (
        f"film element {worst} at {place} is compressed, smallest principal resultant {values[worst, 0]:.3g} N/m "
        f"({compressed.size} of {len(values)} elements); {remedy}"
    )
    # Whether a slightly compressed film buckles depends on the mesh; that no taut state exists does not.
    return [Problem(text, bool(given or values[worst, 0] < -_COMPRESSION_ALLOWED * largest))]


def _wrinkled_film(model: Model, states: NDArray[np.int8], fractions: tuple[float, float]) -> list[Problem]:
    index = np.flatnonzero(states)
    if not index.size:
        return []
    wrinkled, slack = fractions
    place = place_of(model, "membrane", int(index[np.argmax(states[index])]))
    text = f"part of the film is not taut: {wrinkled:.1%} of its area is wrinkled, {slack:.1%} slack, e.g. at {place}"
    if (states == 2).all():
        return [Problem("the whole film is slack; give it tension", True)]
    return [Problem(f"{text}; more cables, or tension = film resultant x spacing, pull it flat", False)]


def film_without_tension(system: StructuralSystem, values: Array) -> NDArray[np.int64]:
    """Film elements that next to no stress pulls at, by their principal resultants [N/m], shape (t, 2)."""
    stiffness = [np.abs(b.elasticity).max() * float(b.size.max()) for b in system.blocks if b.kind == "membrane"]
    if not stiffness or film_wrinkles(system):
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(values[:, 1] <= _NO_STRAIN * min(stiffness))


def loose_text(model: Model, elements: NDArray[np.int64], motions: int) -> str:
    """Sentence about film elements without tension and the motions that nothing resists."""
    count = sum(len(group.connectivity) for group in model.surfaces)
    place = place_of(model, "membrane", int(elements[0]))
    return (
        f"{elements.size} of {count} film elements have no tension, e.g. element {elements[0]} at {place}, and "
        f"{motions} motion(s) across them no stiffness: natural frequencies of about 0 Hz are theirs; give the film a "
        "stress (membrane_stress, or stress_x and stress_y of [membrane] or of the film's [mesh.sections.NAME]), or "
        "cables whose tension reaches it in 'equilibrium' mode"
    )


def instability_text(model: Model, unstable: int) -> str:
    """Sentence about negative eigenvalues of the tangent."""
    text = f"the state is unstable, {unstable} negative eigenvalue(s) of the tangent"
    if model.rigid_freedom and {group.section.strain for group in model.groups} != {"green-lagrange"}:
        return (
            f"{text}; a free structure needs strain = 'green-lagrange' for film, cables and frame, or its prestress "
            "resists rigid rotations"
        )
    return f"{text}: no taut equilibrium exists here; use more cables or a stress field that is tensile everywhere"


def soft_text(count: int, frequency: float) -> str:
    """Sentence about motions without stiffness."""
    return (
        f"{count} motion(s) of wrinkled or slack film have almost no stiffness and natural frequencies below "
        f"{frequency:.2g} Hz; "
        "do not read them as modes of the structure"
    )
