"""Which figures the commands write, and under which names."""

from __future__ import annotations

import gc
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

if TYPE_CHECKING:
    import xarray as xr

# Screens want PNG; writing PDF as well costs another 50 MB of memory.
FORMATS = ("png",)
Formats = Annotated[
    list[Literal["png", "pdf", "svg"]] | None,
    Parameter(name="--format", help="Format of figures, png if not given; may be repeated."),
]


def mode_figures(
    modes: xr.Dataset, directory: Path, campbell: xr.Dataset | None = None, formats: Sequence[str] = FORMATS
) -> list[Path]:
    """Write the mode shapes, and a Campbell table, into an existing directory; return the files."""
    from tautflex import plot
    from tautflex.plot.campbell import save_campbell

    written = list(plot.save_modes(modes, directory / "modes", formats=formats))
    return written if campbell is None else written + save_campbell(campbell, directory / "campbell", formats=formats)


def run_figures(run: xr.Dataset, modes: xr.Dataset, directory: Path, formats: Sequence[str] = FORMATS) -> list[Path]:
    """Write every figure the data of a run allow into an existing directory; return the files.

    Shapes need stored fields; time history and spectrum need probes and a handful of steps.
    """
    from tautflex import plot

    written = mode_figures(modes, directory, formats=formats)
    gc.collect()  # figures hold cycles and tens of megabytes of pixels
    if run.sizes.get("field_time", 0) > 0:
        written += plot.save_shapes(run, directory / "shapes", formats=formats)
        gc.collect()
    if run.sizes.get("probe", 0) > 0 and run.sizes["time"] >= 8:
        natural = modes["frequency"].values
        written += plot.save_time_history(run, directory / "time_history", formats=formats)
        written += plot.save_spectrum(run, directory / "spectrum", natural_frequencies=natural, formats=formats)
    if "command" in run:
        written += plot.save_loop(run, directory / "loop", formats=formats)
    if run["surface_rms"].notnull().any():
        written += plot.save_surface(run, directory / "surface", formats=formats)
    return written


def study_figures(study: xr.Dataset, directory: Path, formats: Sequence[str] = FORMATS) -> list[Path]:
    """Write the figure of a study into an existing directory; return the files."""
    from tautflex import plot

    return plot.save_study(study, directory / "sweep", formats=formats)


def design_figures(design: xr.Dataset, directory: Path, formats: Sequence[str] = FORMATS) -> list[Path]:
    """Write the history of a design into an existing directory; return the files."""
    from tautflex import plot

    return plot.save_design(design, directory / "history", formats=formats)
