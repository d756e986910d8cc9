"""Names in mesh files, and the part of the structure they stand for."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from tautflex import checks
from tautflex.files.mesh.raw import shorten

ROLES = ("membrane", "cable", "beam", "clamped", "pinned", "ignore")
SUPPORTS = ("clamped", "pinned")
CHOICES = {"triangles": ("membrane",), "quads": ("membrane",), "lines": ("cable", "beam")}
"""Roles that elements of a kind can have."""
_CHOSEN = ("membrane", "cable", "beam")

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


def stated_roles(names: Mapping[str, str] | None, present: Sequence[str]) -> tuple[dict[str, str], list[str]]:
    """Roles a user states for groups of a file, by the name in small letters, and what is wrong with them.

    A group whose stated role there is not has the role ``""``: what it is meant to be is not asked again.
    """
    stated, problems, there = dict[str, str](), list[str](), {name.strip().casefold() for name in present}
    for name, role in (names or {}).items():
        known = WORDS.get(role, role)
        if known not in ROLES:
            choices = ", ".join(ROLES)
            remedy = checks.pick(role, ROLES)
            problems.append(f"names: expected for group {name!r} one of {choices}, got {role!r}; {remedy}")
            known = ""
        if name.strip().casefold() not in there:
            listed = ", ".join(shorten(group) for group in present[:20]) or "none"
            remedy = checks.meant(name, present) or "correct the name"
            problems.append(f"names: expected groups of the file ({listed}), got {name!r}; {remedy}")
            stated |= {group.strip().casefold(): known for group in present if repr(group) in remedy}
        stated[name.strip().casefold()] = known
    return stated, problems


def no_role(name: str, kinds: Collection[str]) -> str:
    """What is wrong with a group of elements of some kinds whose name says nothing."""
    words = ", ".join(word for word, role in WORDS.items() if role not in _CHOSEN or role in _fitting(kinds))
    return f"group {shorten(name)}: expected a name that begins with one of {words}; {_remedy(name, kinds)}"


def wrong_role(name: str, kind: str, role: str, kinds: Collection[str]) -> str | None:
    """What is wrong with a role of a group for its elements of a kind; None if they can have it."""
    if role in CHOICES[kind]:
        return None
    choices = " or ".join(CHOICES[kind])
    return f"group {shorten(name)}: expected {kind} to be {choices}, got {role}; {_remedy(name, kinds)}"


def _fitting(kinds: Collection[str]) -> list[str]:
    """Roles that elements of all these kinds can have."""
    return [role for role in _CHOSEN if all(role in CHOICES[kind] for kind in kinds)]


def _remedy(name: str, kinds: Collection[str]) -> str:
    first, *others = [repr(role) for role in (*_fitting(kinds), *SUPPORTS, "ignore")]
    separate = "" if _fitting(kinds) else "separate its surfaces from its lines, or "
    shown = shorten(name)
    return f"{separate}rename it, or state its role with names={{{shown}: {first}}} (or {', '.join(others)})"
