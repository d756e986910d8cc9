"""What `tautflex modes` adds on request: spinning modes, the Campbell table, participation for attitude control."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tautflex.errors import CaseError

if TYPE_CHECKING:
    import xarray as xr

    from tautflex.case import Case
    from tautflex.solvers.modal.natural import Modes
    from tautflex.solvers.static.prestress import PrestressedState

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
    """Check the options; axis and origin default to those of the case's maneuver."""
    if axis is not None and rate is None and campbell is None:
        raise CaseError(f"--axis: expected --campbell or --rate beside it, got --axis {axis} alone; add one of them")
    if rate is not None and not math.isfinite(rate):
        raise CaseError(f"--rate: expected an angular rate [rad/s], got {rate}; give for example --rate 0.6")
    direction = case.maneuver.axis if axis is None else _read_axis(axis)
    rates = None if campbell is None else _read_rates(campbell)
    return SpinRequest(rate, rates, direction, case.maneuver.origin)


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


def solve_single(case: Case, state: PrestressedState, request: SpinRequest, count: int) -> dict[str, Any]:
    """Spinning modes at one rate as numbers."""
    import numpy as np

    from tautflex.case.build import build_coupling, build_damping
    from tautflex.motion.kinematics import unit_axis
    from tautflex.solvers.modal.spinning import solve_spinning_modes

    assert request.rate is not None
    spin = request.rate * np.asarray(unit_axis(request.axis))
    found = solve_spinning_modes(state, spin, request.origin, count, build_coupling(case), build_damping(case))
    return {
        "rate": request.rate,
        "axis": list(request.axis),
        "frequencies": found.frequencies.tolist(),
        "damping_ratios": found.damping_ratios.tolist(),
        "growth_rates": found.growth_rates.tolist(),
        "whirl": found.whirl.tolist(),
        "labels": [None if label is None else list(map(int, label)) for label in found.labels],
        "stable": found.stable,
        "min_principal_resultant": found.min_principal_resultant,
    }


def solve_table(case: Case, state: PrestressedState, request: SpinRequest, count: int) -> xr.Dataset:
    """Campbell table with a progress bar."""
    import numpy as np

    from tautflex.case.build import build_coupling, build_damping
    from tautflex.cli.runs.run import progress_bar
    from tautflex.solvers.modal.campbell import campbell

    assert request.rates is not None
    with progress_bar() as progress:
        return campbell(
            state,
            np.linspace(*request.rates),
            request.axis,
            count,
            request.origin,
            build_coupling(case),
            build_damping(case),
            progress,
        )


def table_numbers(table: xr.Dataset) -> dict[str, Any]:
    """Campbell table as lists, rates by branches."""
    return {
        "rates": table["rate"].values.tolist(),
        "axis": list(map(float, table.attrs["axis"])),
        "frequencies": table["frequency"].values.tolist(),
        "damping_ratios": table["damping_ratio"].values.tolist(),
        "growth_rates": table["growth_rate"].values.tolist(),
        "stable": table["stable"].values.tolist(),
        "min_principal_resultant": table["min_principal_resultant"].values.tolist(),
    }


def campbell_figure(table: xr.Dataset, directory: Path) -> list[Path]:
    """Write the figure into an existing directory; return the files."""
    from tautflex.cli.figures import FORMATS
    from tautflex.plot.campbell import save_campbell

    return save_campbell(table, directory / "campbell", formats=FORMATS)


def write_participation(case: Case, modes: Modes, point: Vector, path: Path) -> dict[str, Any]:
    """Write the file for attitude control; return what to say about it."""
    from tautflex.case.build import build_damping
    from tautflex.files.appendage import save_appendage
    from tautflex.solvers.modal.participation import appendage_data

    data = appendage_data(modes, point, build_damping(case))
    save_appendage(data, path)
    return {
        "point": list(point),
        "rigid_mass": data["rigid_mass"].values.tolist(),
        "completeness": data["completeness"].values.tolist(),
    }


def show_spinning(answer: Mapping[str, Any]) -> None:
    """Print what was asked for beside the modes at rest."""
    from rich.console import Console

    from tautflex.cli.cards import say

    at_rest = answer["prestress"]["min_principal_resultant"]
    if "spinning" in answer:
        one = answer["spinning"]
        Console().print(_modes_table(one))
        _warn([one["rate"]], [one["stable"]], [one["min_principal_resultant"]], at_rest)
    if "campbell" in answer:
        many = answer["campbell"]
        console = Console()
        for table in _campbell_tables(many, console.width):
            console.print(table)
        _warn(many["rates"], many["stable"], many["min_principal_resultant"], at_rest)
    if "participation" in answer:
        parts = ", ".join(
            "-" if math.isnan(part) else f"{part:.3f}" for part in answer["participation"]["completeness"]
        )
        say(f"These modes hold of the free mass (x, y, z, rx, ry, rz): {parts}")


def _warn(rates: list[float], stable: list[bool], resultants: list[float], at_rest: float) -> None:
    """Say where motions grow and where the film is compressed by more than a wrinkled one is."""
    from tautflex.cli.cards import say

    unstable = [f"{rate:.4g}" for rate, holds in zip(rates, stable, strict=True) if not holds]
    pressed = [f"{rate:.4g}" for rate, value in zip(rates, resultants, strict=True) if value < -1e-3 * abs(at_rest)]
    if unstable:
        say(f"warning: unstable at {', '.join(unstable)} rad/s, some motion grows")
    if pressed:
        text = f"warning: compressed film at {', '.join(pressed)} rad/s, smallest principal resultant"
        say(f"{text} {min(resultants):.3g} N/m; membrane.law = 'tension-field' lets it wrinkle instead")


def _modes_table(one: Mapping[str, Any]) -> Any:
    from rich.table import Table

    axis = ", ".join(f"{part:g}" for part in one["axis"])
    table = Table(title=f"spinning at {one['rate']:g} rad/s about ({axis})", title_style="bold")
    for name in ("mode", "frequency [Hz]", "damping ratio", "whirl", "half waves (m,n)"):
        table.add_column(name, justify="right")
    columns = one["frequencies"], one["damping_ratios"], one["whirl"], one["labels"]
    for number, (frequency, ratio, whirl, label) in enumerate(zip(*columns, strict=True), start=1):
        sense = "forward" if whirl > 0.1 else "backward" if whirl < -0.1 else "-"
        half_waves = "-" if label is None else f"({label[0]},{label[1]})"
        table.add_row(f"{number}", f"{frequency:.4f}", f"{ratio:.2e}", sense, half_waves)
    return table


def _campbell_tables(many: Mapping[str, Any], width: int) -> list[Any]:
    """As many branches side by side as the terminal has room for."""
    from rich.table import Table

    rows = [
        [
            "grows" if growth > 0.0 and frequency == 0.0 else f"{frequency:.3f}"
            for frequency, growth in zip(*row, strict=True)
        ]
        for row in zip(many["frequencies"], many["growth_rates"], strict=True)
    ]
    rates = [f"{rate:.4g}" for rate in many["rates"]]
    cell = max(len(text) for row in rows for text in row) + 2
    room = max(1, (width - 2 - max(5, *map(len, rates))) // cell)
    axis = ", ".join(f"{part:g}" for part in many["axis"])
    tables = []
    for first in range(0, len(rows[0]), room):
        names = [f"{branch + 1}" for branch in range(first, min(first + room, len(rows[0])))]
        title = f"frequencies [Hz] of branches {names[0]} to {names[-1]}, spinning about ({axis})"
        table = Table(title=title, title_style="bold", box=None, padding=(0, 1))
        for name in ("rad/s", *names):
            table.add_column(name, justify="right", no_wrap=True)
        for rate, row in zip(rates, rows, strict=True):
            table.add_row(rate, *row[first : first + room])
        tables.append(table)
    return tables
