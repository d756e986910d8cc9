"""Which figures the commands write, and under which names."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


def mode_figures(modes: xr.Dataset, directory: Path) -> list[Path]:
    """Write the mode shapes into an existing directory; return the files."""
    from tautflex import plot

    return list(plot.save_modes(modes, directory / "modes"))


def run_figures(run: xr.Dataset, modes: xr.Dataset, directory: Path) -> list[Path]:
    """Write every figure the data of a run allow into an existing directory; return the files.

    Shapes need stored fields; time history and spectrum need probes and a handful of steps.
    """
    from tautflex import plot

    written = mode_figures(modes, directory)
    if run.sizes.get("field_time", 0) > 0:
        written += plot.save_shapes(run, directory / "shapes")
    if run.sizes.get("probe", 0) > 0 and run.sizes["time"] >= 8:
        written += plot.save_time_history(run, directory / "time_history")
        written += plot.save_spectrum(
            run, directory / "spectrum", natural_frequencies=modes["frequency"].values
        )
    return written
