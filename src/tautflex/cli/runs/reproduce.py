"""`tautflex reproduce`: the paper's tables and figures, computed again and compared."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from tautflex.cli.options import Answer, command, require_output_directory
from tautflex.cli.runs.reproduce_cards import show_comparison
from tautflex.cli.runs.run import progress_bar
from tautflex.errors import CaseError
from tautflex.files.transaction import publish, result_folder
from tautflex.writing import write_text

if TYPE_CHECKING:
    from tautflex.paper.comparison import Plan
    from tautflex.paper.figures.index import PaperFigure
    from tautflex.paper.tables.rows import Row

INTERRUPTED = 130
_QUICK_FORMATS = ("png",)  # vector graphics would cost a third of the quick minute


@command
def reproduce(
    *,
    table: Annotated[
        list[str] | None,
        Parameter(name="--table", help="Table of the paper, or ablation, compression, convergence; may be repeated."),
    ] = None,
    figure: Annotated[
        list[str] | None,
        Parameter(name="--figure", help="Figure of the paper, e.g. 5a, or 5 for all its parts; may be repeated."),
    ] = None,
    output: Annotated[Path, Parameter(name=["-o", "--output"], help="Directory for results.")] = Path("reproduction"),
    quick: Annotated[
        bool, Parameter(name="--quick", help="Published reading only, coarse time step, no ablation: under a minute.")
    ] = False,
    workers: Annotated[
        int | None, Parameter(name="--workers", help="Number of processes; default: one per core.")
    ] = None,
    docs: Annotated[
        Path | None, Parameter(name="--docs", help="Directory for the Markdown page, if not that for results.")
    ] = None,
) -> Answer | int:
    """Compute the paper's tables and figures again; compare with the printed numbers.

    Without --table and --figure everything is made, and a page that explains it. Finished runs are kept in the
    directory for results and used again; an interrupted command goes on where it stopped when it is repeated.

    Example: tautflex reproduce --table 6 --table 7 -o reproduction
    """
    whole = not table and not figure
    tables, figures = _tables(table, whole, quick), _figures(figure, whole)
    if workers is not None and workers < 1:
        raise CaseError(f"--workers: expected a number >= 1, got {workers}; leave it out for one per core")
    require_output_directory(output)

    from tautflex.paper.comparison import make_plan

    needs = [run for figure in figures.values() for run in figure.needs]
    plan = make_plan(tables, needs, quick, figures=bool(figures))
    try:
        with result_folder(output):
            made = _make(plan, list(figures), output, workers, _QUICK_FORMATS if quick else None)
            if whole:
                made.files |= _write_page(made, output, docs, quick)
    except KeyboardInterrupt:
        return _tell(f"interrupted; finished runs are kept in {output}: repeat the command to go on", INTERRUPTED)
    return Answer(_answer(made), partial(show_comparison, made.rows, made.summary, made.files))


@dataclass
class _Made:
    """What one call has made so far."""

    rows: dict[tuple[str, str], list[Row]]
    summary: list[Row]
    figures: dict[str, list[Path]]
    seconds: float
    files: dict[str, Path] = field(default_factory=dict)


def _tables(asked: Sequence[str] | None, whole: bool, quick: bool) -> tuple[str, ...]:
    from tautflex.paper.comparison import QUICK_TABLES, TABLE_NAMES

    for name in asked or ():
        if name not in TABLE_NAMES:
            raise CaseError(f"--table: expected one of {', '.join(TABLE_NAMES)}, got {name!r}")
    if quick and "convergence" in (asked or ()):
        raise CaseError("--table: convergence takes several meshes and steps, got --quick; leave out --quick")
    everything = QUICK_TABLES if quick else TABLE_NAMES
    return everything if whole else tuple(asked or ())


def _figures(asked: Sequence[str] | None, whole: bool) -> dict[str, PaperFigure]:
    if not asked and not whole:
        return {}
    from tautflex.paper.figures.index import FIGURES

    chosen: dict[str, PaperFigure] = {}
    for name in asked or ():
        found = {number: figure for number, figure in FIGURES.items() if name in (number, number.rstrip("abc"))}
        if not found:
            raise CaseError(f"--figure: expected one of {', '.join(FIGURES)}, got {name!r}")
        chosen |= found
    return FIGURES if whole else chosen


def _make(
    plan: Plan, figures: Sequence[str], output: Path, workers: int | None, formats: tuple[str, ...] | None
) -> _Made:
    """Perform the runs and turn them into rows, figures and comparison.csv."""
    from tautflex.paper.cases.normal_modes import antenna_modes, antenna_name
    from tautflex.paper.cases.run_names import MODELS
    from tautflex.paper.comparison import build_rows, summarize
    from tautflex.paper.engine import results
    from tautflex.paper.figures.index import FORMATS, save_figures
    from tautflex.paper.tables.rows import write_csv

    with progress_bar() as progress:
        runs = results(plan.specs, output / "runs", workers, progress)
        modes = antenna_modes(plan.antennas)
        rows = build_rows(plan, runs, modes)
        summary = summarize(rows)

        def write(place: Path, final: Path) -> dict[str, list[Path]]:
            drawn: dict[str, list[Path]] = {}
            if figures:
                shapes = {name: modes[antenna_name(name)] for name in MODELS}
                many = 1 if formats else workers  # pictures alone are written before processes have started
                drawn = save_figures(figures, runs, shapes, place / "figures", formats or FORMATS, many)
            if rows:
                write_csv([row for table in (*rows.values(), summary) for row in table], place / "comparison.csv")
            return {number: [final / path.relative_to(place) for path in paths] for number, paths in drawn.items()}

        drawn = publish(output, write)
    seconds = sum(float(json.loads(run.attrs["statistics"])["seconds"]) for run in runs.values())
    files = {"comparison": output / "comparison.csv"} if rows else {}
    return _Made(rows, summary, drawn, seconds, files | {path.name: path for paths in drawn.values() for path in paths})


def _write_page(made: _Made, output: Path, docs: Path | None, quick: bool) -> dict[str, Path]:
    """Write the page, and the case files that a reader will want to run."""
    from tautflex.files.netcdf import versions
    from tautflex.paper.cases.catalogue import READINGS, case_text
    from tautflex.paper.page.compose import build_page

    summary = {"quick": quick, "seconds": made.seconds, "versions": versions()}
    files = {path.name: path for path in build_page(made.rows, made.figures, summary, output, docs)}
    for variant, name in READINGS.items():
        files[f"{name}.toml"] = path = output / f"{name}.toml"
        write_text(path, case_text(variant))
    return files


def _answer(made: _Made) -> dict[str, Any]:
    """Return the content of --json: SI units, every published number once; ``readings`` has those of all variants."""
    from tautflex.paper.cases.catalogue import READINGS

    answer: dict[str, Any] = {"tables": {}, "extra": {}}
    readings: dict[tuple[str, str, str], dict[str, Any]] = {}
    for (variant, number), rows in made.rows.items():
        for row in (row for row in rows if not row.repeats):
            values = {"reading": READINGS[variant], **row.to_si()}
            if not number.isdigit():
                answer["extra"].setdefault(number, []).append(values)
                continue
            of_all = readings.setdefault((number, row.case, row.quantity), {})
            of_all[READINGS[variant]] = values["ours"]
            if variant == "published":
                answer["tables"].setdefault(number, []).append(row.to_si() | {"readings": of_all})
    answer["summary"] = [{"reading": READINGS[row.variant], **row.to_si()} for row in made.summary]
    answer["figures"] = made.figures
    answer["files"] = made.files
    return answer


def _tell(text: str, code: int) -> int:
    print(f"tautflex: {text}", file=sys.stderr)  # noqa: T201 - the command line's one line about a broken end
    return code
