"""What `tautflex modes` adds on request: spinning modes, the Campbell table, participation for attitude control."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tautflex.cli.cases.spin_request import SpinRequest, Vector

if TYPE_CHECKING:
    import xarray as xr

    from tautflex.case import Case
    from tautflex.solvers.modal.natural import Modes
    from tautflex.solvers.static.prestress import PrestressedState


def solve_single(case: Case, state: PrestressedState, request: SpinRequest, count: int) -> dict[str, Any]:
    """Spinning modes at one rate as numbers."""
    import numpy as np

    from tautflex.motion.kinematics import unit_axis
    from tautflex.solvers.modal.spinning import solve_spinning_modes

    assert request.rate is not None
    spin = request.rate * np.asarray(unit_axis(request.axis))
    found = solve_spinning_modes(state, spin, request.origin, count, case.coupling.build(), case.damping.build())
    return {
        "rate": request.rate,
        "axis": request.axis,
        "frequencies": found.frequencies,
        "damping_ratios": found.damping_ratios,
        "growth_rates": found.growth_rates,
        "whirl": found.whirl,
        "labels": found.labels,
        "stable": found.stable,
        "min_principal_resultant": found.min_principal_resultant,
    }


def solve_table(case: Case, state: PrestressedState, request: SpinRequest, count: int) -> xr.Dataset:
    """Campbell table with a progress bar."""
    import numpy as np

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
            case.coupling.build(),
            case.damping.build(),
            progress,
        )


def table_numbers(table: xr.Dataset) -> dict[str, Any]:
    """Campbell table as lists, rates by branches."""
    return {
        "rates": table["rate"].values,
        "axis": table.attrs["axis"],
        "frequencies": table["frequency"].values,
        "damping_ratios": table["damping_ratio"].values,
        "growth_rates": table["growth_rate"].values,
        "stable": table["stable"].values,
        "min_principal_resultant": table["min_principal_resultant"].values,
    }


def campbell_figure(table: xr.Dataset, directory: Path) -> list[Path]:
    """Write the figure into an existing directory; return the files."""
    from tautflex.cli.figures import FORMATS
    from tautflex.plot.campbell import save_campbell

    return save_campbell(table, directory / "campbell", formats=FORMATS)


def write_participation(case: Case, modes: Modes, point: Vector, path: Path) -> dict[str, Any]:
    """Write the file for attitude control; return what to say about it."""
    from tautflex.files.appendage import save_appendage
    from tautflex.solvers.modal.participation import appendage_data

    data = appendage_data(modes, point, case.damping.build())
    save_appendage(data, path)
    return {
        "point": point,
        "rigid_mass": data["rigid_mass"].values,
        "completeness": data["completeness"].values,
    }
