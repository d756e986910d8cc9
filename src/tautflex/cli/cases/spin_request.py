"""Options of `tautflex modes` about a spinning structure, read and checked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tautflex.errors import CaseError

if TYPE_CHECKING:
    from tautflex.case import Case

Vector = tuple[float, float, float]
_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class SpinRequest:
    """Options of the command line, checked.

    Parameters
    ----------
    rate
        Single rate [rad/s], or None.
    rates
        Rates of the Campbell table as start, stop [rad/s] and count, or None.
    axis
        Direction of the spin axis.
    origin
        A point on it [m].
    """

    rate: float | None
    rates: tuple[float, float, int] | None
    axis: Vector
    origin: Vector


def read_request(rate: float | None, campbell: str | None, axis: str | None, case: Case) -> SpinRequest:
    """Check the options; axis and origin default to those of the maneuver, if it has any."""
    if axis is not None and rate is None and campbell is None:
        raise CaseError(f"--axis: expected --campbell or --rate beside it, got --axis {axis} alone; add one of them")
    if rate is not None and not math.isfinite(rate):
        raise CaseError(f"--rate: expected an angular rate [rad/s], got {rate}; give for example --rate 0.6")
    given: Vector = getattr(case.maneuver, "axis", (1.0, 0.0, 0.0))
    direction = given if axis is None else _read_axis(axis)
    rates = None if campbell is None else _read_rates(campbell)
    return SpinRequest(rate, rates, direction, getattr(case.maneuver, "origin", (0.0, 0.0, 0.0)))


def read_place(point: str | None, participation: Path | None) -> Vector:
    """Check --point and that --participation can be written."""
    if participation is None:
        if point is not None:
            raise CaseError(f"--point: expected --participation beside it, got --point {point} alone; add it")
        return 0.0, 0.0, 0.0
    from tautflex.cli.options import require_new_file
    from tautflex.files.appendage import appendage_path

    require_new_file(appendage_path(participation), force=True)
    return (0.0, 0.0, 0.0) if point is None else read_vector("--point", point, "0,0,0.1")


def read_vector(option: str, text: str, example: str) -> Vector:
    """Three numbers from "x,y,z"."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise CaseError(
            f"{option}: expected three numbers, got {text!r}; give for example {option} {example}"
        ) from None
    if not all(map(math.isfinite, (x, y, z))):
        raise CaseError(f"{option}: expected finite numbers, got {text!r}; give for example {option} {example}")
    return x, y, z


def _read_axis(text: str) -> Vector:
    if text in _AXES:
        return _AXES[text]
    if "," not in text:
        raise CaseError(f"--axis: expected x, y, z or three numbers, got {text!r}; give for example --axis 1,0,0.5")
    axis = read_vector("--axis", text, "1,0,0.5")
    if not any(axis):
        raise CaseError(f"--axis: expected a direction of non-zero length, got {text!r}; give for example --axis z")
    return axis


def _read_rates(text: str) -> tuple[float, float, int]:
    try:
        start, stop, count = text.split(":")
        found = float(start), float(stop), int(count)
    except ValueError:
        found = math.nan, math.nan, 0
    if not (math.isfinite(found[0]) and math.isfinite(found[1]) and found[0] != found[1] and 2 <= found[2] <= 10_000):
        raise CaseError(
            f"--campbell: expected start:stop:count with two rates [rad/s] and at least 2 of them, got {text!r}; "
            "give for example --campbell 0:2:9"
        )
    return found
