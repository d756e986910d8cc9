"""Names in mesh files, and the part of the structure they stand for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import shorten

ROLES = ("membrane", "cable", "beam", "clamped", "pinned", "ignore")
SUPPORTS = ("clamped", "pinned")

# A name beginning with one of these words, in any case, has that role: "Cables_x" is a cable.
WORDS = {
    "membrane": "membrane",
    "film": "membrane",
    "cable": "cable",
    "beam": "beam",
    "frame": "beam",
    "support": "clamped",
    "clamped": "clamped",
    "fixed": "clamped",
    "pinned": "pinned",
    "ignore": "ignore",
}


def role_of_name(name: str) -> str | None:
    """Role that a name stands for by convention, None if it follows none."""
    lowered = name.strip().casefold()
    return next((role for word, role in WORDS.items() if lowered.startswith(word)), None)


def stated_roles(names: Mapping[str, str] | None, present: Sequence[str]) -> dict[str, str]:
    """Check the roles a user states for groups of a file; keys are compared in any case.

    Raises
    ------
    MeshError
        If a role is unknown, or the file has no such group.
    """
    stated, there = {}, {name.strip().casefold() for name in present}
    for name, role in (names or {}).items():
        known = WORDS.get(role, role)
        if known not in ROLES:
            choices = ", ".join(ROLES)
            raise MeshError(f"names: expected for group {name!r} one of {choices}, got {role!r}; choose one of them")
        if name.strip().casefold() not in there:
            listed = ", ".join(shorten(group) for group in present[:20]) or "none"
            raise MeshError(f"names: expected groups of the file ({listed}), got {name!r}; correct the name")
        stated[name.strip().casefold()] = known
    return stated


def unknown_role(name: str) -> MeshError:
    """Error for a group of elements whose name says nothing."""
    words = ", ".join(WORDS)
    return MeshError(
        f"group {shorten(name)}: expected a name that begins with one of {words}; rename it, or state its role with "
        f"names={{{shorten(name)}: 'membrane'}} ('ignore' leaves it out)"
    )
