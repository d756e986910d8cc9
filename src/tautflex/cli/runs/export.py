"""`tautflex export`: results for other programs."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from tautflex.cli.cards import say
from tautflex.cli.options import Answer, about, command, require_output_directory, stored_run
from tautflex.files.transaction import publish, result_folder


@command
def export(
    run: Annotated[Path, Parameter(help="Folder of a run, or its run.nc.")],
    /,
    *,
    to: Annotated[
        Literal["vtu", "csv"], Parameter(name="--to", help="vtu: fields for ParaView; csv: histories of the probes.")
    ],
    output: Annotated[
        Path | None, Parameter(name=["-o", "--output"], help="Directory to write to; default: beside the result.")
    ] = None,
) -> Answer:
    """Write the results of a run as VTU series with PVD (ParaView) or as CSV.

    Example: tautflex export m2 --to vtu -o m2/paraview
    """
    run = stored_run(run)
    directory = output if output is not None else run.parent
    require_output_directory(directory)

    from tautflex.files import netcdf
    from tautflex.files.csv import write_csv
    from tautflex.files.vtu import write_vtu

    def write(place: Path, final: Path) -> list[Path]:
        made = [write_csv(data, place / f"{run.stem}.csv")] if to == "csv" else write_vtu(data, place, run.stem)
        return [final / file.relative_to(place) for file in made]

    with netcdf.opened(run) as data, result_folder(directory), about(run):
        files = publish(directory, write)
    more = f" and {len(files) - 1} files in {files[1].parent}" if len(files) > 1 else ""
    return Answer({"files": files}, partial(say, f"Wrote {files[0]}{more}."))
