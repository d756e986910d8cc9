"""What `tautflex modes` adds on request: spinning modes, the Campbell table, participation for attitude control."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tautflex.errors import CaseError

if TYPE_CHECKING:
    import xarray as xr

    from tautflex.case import Case
    from tautflex.solvers.modal.natural import Modes
    from tautflex.solvers.static.prestress import PrestressedState

Vector = tuple[float, float, float]
_ZERO: Vector = (0.0, 0.0, 0.0)
_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class SpinRequest(NamedTuple):
    """Options about spinning, checked: a rate [rad/s], start, stop and count of a table, direction and point [m]."""

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
    direction: Vector = getattr(case.maneuver, "axis", _AXES["x"]) if axis is None else _read_axis(axis)
    rates = None if campbell is None else _read_rates(campbell)
    return SpinRequest(rate, rates, direction, getattr(case.maneuver, "origin", _ZERO))


def read_place(point: str | None, participation: Path | None) -> Vector:
    """Check --point and that --participation can be written."""
    if participation is None:
        if point is not None:
            raise CaseError(f"--point: expected --participation beside it, got --point {point} alone; add it")
        return _ZERO
    from tautflex.cli.options import require_new_file
    from tautflex.files.appendage import appendage_path

    require_new_file(appendage_path(participation), force=True)
    return _ZERO if point is None else _read_vector("--point", point, "0,0,0.1")


def _read_vector(option: str, text: str, example: str) -> Vector:
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
    if text not in _AXES and "," not in text:
        raise CaseError(f"--axis: expected x, y, z or three numbers, got {text!r}; give for example --axis 1,0,0.5")
    axis = _AXES.get(text) or _read_vector("--axis", text, "1,0,0.5")
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


def solve_single(case: Case, state: PrestressedState, request: SpinRequest, count: int) -> dict[str, Any]:
    """Spinning modes at one rate as numbers."""
    import numpy as np

    from tautflex.motion.kinematics import unit_axis
    from tautflex.solvers.modal.spinning import solve_spinning_modes

    assert request.rate is not None
    spin = request.rate * np.asarray(unit_axis(request.axis))
    found = solve_spinning_modes(state, spin, request.origin, count, case.coupling.build(), case.damping.build())
    names = ("frequencies", "damping_ratios", "growth_rates", "whirl", "labels", "stable", "min_principal_resultant")
    return {"rate": request.rate, "axis": request.axis, **{name: getattr(found, name) for name in names}}


def solve_table(case: Case, state: PrestressedState, request: SpinRequest, count: int) -> xr.Dataset:
    """Campbell table with a progress bar."""
    import numpy as np

    from tautflex.cli.runs.run import progress_bar
    from tautflex.solvers.modal.campbell import campbell

    assert request.rates is not None
    rates, terms = np.linspace(*request.rates), (case.coupling.build(), case.damping.build())
    with progress_bar() as progress:
        return campbell(state, rates, request.axis, count, request.origin, *terms, progress)


def table_numbers(table: xr.Dataset) -> dict[str, Any]:
    """Campbell table as lists, rates by branches."""
    names = {"frequencies": "frequency", "damping_ratios": "damping_ratio", "growth_rates": "growth_rate"}
    names |= {"rates": "rate", "stable": "stable", "min_principal_resultant": "min_principal_resultant"}
    return {"axis": table.attrs["axis"], **{plural: table[name].values for plural, name in names.items()}}


def write_participation(case: Case, modes: Modes, point: Vector, path: Path) -> dict[str, Any]:
    """Write the file for attitude control; return what to say about it."""
    from tautflex.files.appendage import save_appendage
    from tautflex.solvers.modal.participation import appendage_data

    data = appendage_data(modes, point, case.damping.build())
    save_appendage(data, path)
    return {"point": point, **{name: data[name].values for name in ("rigid_mass", "completeness")}}
