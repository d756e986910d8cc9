"""Maneuvers of a case: built, and described in words."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tautflex.case.motion_tables import read_table
from tautflex.errors import CaseError, InputError
from tautflex.motion.fixed_axis import Slew, SpinUp, Stop
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.motion.sequence import Sequence
from tautflex.motion.tabulated import Tabulated
from tautflex.motion.translation import BaseAcceleration

if TYPE_CHECKING:
    from tautflex.case.sections.maneuver import Maneuver as ManeuverSection
    from tautflex.case.sections.maneuver import Motion

KINDS: dict[str, Any] = {
    "none": AtRest,
    "stop": Stop,
    "spin-up": SpinUp,
    "slew": Slew,
    "tabulated": Tabulated,
    "base-acceleration": BaseAcceleration,
}


def maneuver_of(given: ManeuverSection) -> Maneuver:
    """Build the maneuver that a [maneuver] section describes.

    Parameters
    ----------
    given
        Validated section.

    Returns
    -------
    Maneuver

    Raises
    ------
    CaseError
        If its values do not go together, or its table cannot be read.
    """
    if given.steps is None:
        return _single(given, "maneuver")
    steps = tuple(_single(step, f"maneuver.steps.{number}") for number, step in enumerate(given.steps))
    try:
        return Sequence(steps, tuple(step.hold or 0.0 for step in given.steps[:-1]))
    except InputError as error:
        raise CaseError(f"maneuver.{error}") from None


def _single(given: Motion, name: str) -> Maneuver:
    values = given.model_dump(exclude_none=True, exclude={"kind", "hold", "steps", "file"})
    if given.kind in ("none", "base-acceleration"):
        values.pop("origin")
    if given.kind == "none":
        values.pop("axis")
    try:
        table: dict[str, Any] = {} if given.file is None else read_table(given.file)
        return KINDS[given.kind](**values, **table)
    except InputError as error:
        raise CaseError(f"{name}.{error}") from None


def describe_maneuver(given: Motion) -> str:
    """Describe a [maneuver] section in a few words, for cards and summaries."""
    steps = getattr(given, "steps", None)
    if steps:
        return ", then ".join(map(describe_maneuver, steps))
    if given.kind == "stop":
        return f"stop from {given.rate:.4g} rad/s in {given.duration:g} s"
    if given.kind == "spin-up":
        return f"spin-up from {given.initial_rate or 0.0:.4g} to {given.rate:.4g} rad/s in {given.duration:g} s"
    if given.kind == "slew":
        return f"{given.profile or 'versine'} slew by {given.angle:.4g} rad in {given.duration:g} s"
    if given.kind == "tabulated":
        rows = f"{len(given.times)} rows" if given.times is not None else Path(given.file or "").name
        return f"tabulated motion ({rows})"
    if given.kind == "base-acceleration":
        span = "" if given.duration is None else f" for {given.duration:g} s"
        return f"{given.profile or 'constant'} base acceleration of {given.acceleration:.4g} m/s^2{span}"
    return "no maneuver"
