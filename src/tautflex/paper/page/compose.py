"""The page of the reproduction: tables, figures and words, as Markdown and as one self-contained HTML file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tautflex.errors import InputError
from tautflex.paper.figures.index import FIGURES
from tautflex.paper.page import reasons, words
from tautflex.paper.page.agreement import CONSISTENT, NEAREST_NODE, Rows, comparison, listing, sorted_rows
from tautflex.paper.page.html import to_html
from tautflex.paper.page.markdown import bullets, picture, symbols
from tautflex.paper.tables import published
from tautflex.paper.tables.rows import Row
from tautflex.writing import write_text

TITLE = "The paper, computed again and compared"
NAME = "reproduction"
_EXTRA = {  # tables that the paper does not have: key -> title and words
    "ablation": (
        "What each term does",
        "Runs repeated with terms of the rotating frame switched off: gyroscopic (G), Euler and centrifugal (K_T), "
        "inertial load (Q_T); and at an angular velocity so low that the antenna responds linearly.",
    ),
    "compression": (
        "Compression of the film",
        "Smallest principal resultant of the film over each run, when it first turns negative, and for how much of the "
        "run. Where it is negative a real film would wrinkle.",
    ),
    "convergence": (
        "Convergence in mesh and time step",
        "Of the published reading, the agreement with Tables 2 and 6 to 9 on each mesh (the film's two tensions "
        "fitted to Table 2 there) and with other solvers; of the consistent variant the runs on coarser meshes and "
        "with half the time step. In strongly nonlinear runs of M1 several spectral peaks are almost equal, so that "
        "the largest may change with mesh, step and solver.",
    ),
}
_VARIANTS = {"Published reading": "", "First reading": NEAREST_NODE, "Consistent variant": CONSISTENT}
_SYMBOLS = "Filled: ours; open: printed in Tables 6 to 9"
_CAPTIONS = {
    "4": "Displacements times 1000. Panel (a) is the steady rotation that the run starts from; in it centrifugal "
    "forces act in the plane only, so that it equals panel (b).",
    "5c": "The paper finds no obvious decay within ten seconds; this run does decay.",
    "6": "Complex Morlet scalogram of the motion about the mean during the stop and about the mean after it; "
    "hatched where the ends of the record matter; dotted: natural frequency of the mode (1,2).",
    "7": "Proper orthogonal modes, each with its participation factor, that together reach 99 %.",
    "9b": "The shortest stop runs out of the picture and is drawn faintly.",
    **dict.fromkeys(("12a", "12b"), f"{_SYMBOLS}; dotted: natural frequency of the mode (1,2)."),
    **dict.fromkeys(("13a", "13b"), f"{_SYMBOLS}."),
}


def build_page(
    rows_by_table: Mapping[Any, Sequence[Row]],
    figure_files: Mapping[str, Sequence[Path]],
    summary: Mapping[str, Any],
    directory: str | os.PathLike[str],
    docs: str | os.PathLike[str] | None = None,
) -> list[Path]:
    """Write ``reproduction.html``, which needs no other file, and ``reproduction.md``.

    Parameters
    ----------
    rows_by_table
        Rows of both variants in any grouping: ``Row.table`` and ``Row.variant`` tell where they belong; besides the
        paper's tables ``"ablation"``, ``"compression"`` and ``"convergence"``. What is missing is left out.
    figure_files
        Files of each figure by number; a PNG among them is shown.
    summary
        Shown if present: ``quick`` (bool), ``seconds`` (time that the runs took) and ``versions`` (name -> version).
    directory
        Folder of the HTML file, made if missing.
    docs
        Folder of the Markdown file; ``directory`` by default.

    Returns
    -------
    list of pathlib.Path
        The HTML file and the Markdown file.

    Raises
    ------
    InputError
        If a picture cannot be read.
    NotWrittenError
        If a file cannot be written; what stood there is whole.
    """
    rows = sorted_rows(row for group in rows_by_table.values() for row in group)
    page, text = Path(directory) / f"{NAME}.html", Path(docs or directory) / f"{NAME}.md"
    parts = [*_overview(rows, summary), *_tables(rows), *_figures(figure_files, text.parent), *_end(summary)]
    content = "\n\n".join([f"# {TITLE}", *parts]) + "\n"
    try:
        html = to_html(content, text.parent)
    except OSError as error:
        raise InputError(f"directory: expected figures that can be read, got {error}; choose another") from error
    return [write_text(page, html), write_text(text, content)]


def _overview(rows: Rows, summary: Mapping[str, Any]) -> list[str]:
    parts = [words.INTRODUCTION]
    if summary.get("quick"):
        text = "Coarse time steps and the published reading alone; run without --quick for the full page."
        parts.append(f"**This is the quick form.** {text}")
    for title, items, before in (
        ("How close it is", words.scores(rows), ""),
        ("The paper's trends", words.trends(rows), "Do the computed responses follow the paper's orderings?"),
        ("What does not match", words.largest_gaps(rows), "Responses more than 20 % away, the worst first."),
        ("Why", reasons.explanations(rows), ""),
    ):
        if items:
            parts += [f"## {title}", *[before] * bool(before), bullets(items)]
    return parts


def _tables(rows: Rows) -> list[str]:
    text = "Differences are relative to the paper: unmarked up to 5 %, *(!)* up to 20 %, **(!!)** beyond."
    parts = ["## Tables", text]
    for number in map(str, published.NUMBERS):
        if rows.get(number):
            title = published.about(int(number))["title"]
            parts.append(f"### Table {number}: {symbols(title)}")
            beside = {name.lower(): rows.get(number + suffix) for name, suffix in _VARIANTS.items() if suffix}
            others = {name: found for name, found in beside.items() if found}
            parts.append(comparison(rows[number], others))
    for key, (title, text) in _EXTRA.items():
        variants = [(name, rows[key + suffix]) for name, suffix in _VARIANTS.items() if rows.get(key + suffix)]
        if variants:
            parts += [f"### {title}", text]
        for name, found in variants:
            parts += [f"**{name}**"] if len(variants) > 1 else []
            parts += listing(found)
    return parts


def _figures(files: Mapping[str, Sequence[Path]], folder: Path) -> list[str]:
    pictures = []
    for number, figure in FIGURES.items():
        file = next((path for path in files.get(number, ()) if Path(path).suffix == ".png"), None)
        if file is not None:
            title = f"Figure {number}: {figure.title}."
            pictures.append(picture(Path(file), title, _CAPTIONS.get(number, ""), folder))
    return ["## Figures", *pictures] if pictures else []


def _end(summary: Mapping[str, Any]) -> list[str]:
    mark = "<!-- test: skip (a minute of all cores; test_reproduce_command.py runs it) -->"  # read by test_docs.py
    parts = ["## Compute it yourself", f"{mark}\n```console\ntautflex reproduce -o reproduction\n```"]
    if summary.get("seconds"):
        parts.append(f"The runs of this page took {float(summary['seconds']):.0f} s of computing.")
    if summary.get("versions"):
        versions = ", ".join(f"{name} {version}" for name, version in dict(summary["versions"]).items() if version)
        parts.append(f"**Made with** {versions}.")
    return parts
