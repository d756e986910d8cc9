"""From the question (which tables and figures) to the runs it needs, and from runs to rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import xarray as xr

from tautflex.checks import one_of
from tautflex.errors import InputError
from tautflex.paper.cases.catalogue import VARIANTS, RunSpec, Variant, catalogue
from tautflex.paper.cases.normal_modes import antenna_name
from tautflex.paper.cases.run_names import MODELS
from tautflex.paper.tables import published
from tautflex.paper.tables.convergence import CONVERGENCE
from tautflex.paper.tables.extras import ABLATION, COMPRESSION
from tautflex.paper.tables.paper_tables import TABLES
from tautflex.paper.tables.rows import Row, mean_difference, mean_log_ratio

_TABLES = TABLES | {"ablation": ABLATION, "compression": COMPRESSION, "convergence": CONVERGENCE}
TABLE_NAMES = tuple(_TABLES)
"""What ``--table`` accepts."""
QUICK_TABLES = (*TABLES, "compression")
"""What a quick reproduction makes if nothing else is asked: the ablation would double its runs."""
_VARIANTS: dict[str, tuple[Variant, ...]] = {"ablation": ("published",), "convergence": ("published", "consistent")}


class Plan(NamedTuple):
    """What is to be made, in the order of printing; the runs it takes, each once, and the antennas' modes.

    A table stands under (variant, name).
    """

    tables: tuple[tuple[str, str], ...]
    specs: tuple[RunSpec, ...]
    antennas: tuple[str, ...]


def make_plan(
    tables: Iterable[str] = TABLE_NAMES,
    figure_runs: Iterable[str] = (),
    quick: bool = False,
    figures: bool = False,
) -> Plan:
    """Find out what tables and figures need, and no more.

    Parameters
    ----------
    tables
        Some of ``TABLE_NAMES``.
    figure_runs
        Names of runs that figures need besides.
    quick
        Published reading only, with a coarse time step.
    figures
        Whether figures are to be drawn, which need the modes of M1, M2 and M3.

    Raises
    ------
    InputError
        If a table is unknown, the message lists the choices; or if it has no quick form.
    """
    chosen: list[tuple[Variant, str]] = []
    for name in dict.fromkeys(tables):
        one_of("table", name, TABLE_NAMES)
        if quick and name == "convergence":
            raise InputError("table: expected one that takes one mesh and one step, got 'convergence'; leave out quick")
        variants = _VARIANTS.get(name, VARIANTS)
        chosen += [(variant, name) for variant in variants if not (quick and variant != "published")]
    names = [run for variant, table in chosen for run in _TABLES[table].runs(variant)]
    antennas = [antenna for variant, table in chosen for antenna in _TABLES[table].antennas(variant)]
    known = {name: spec for variant in VARIANTS for name, spec in catalogue(variant, quick).items()}
    return Plan(
        tuple(chosen),
        tuple(known[name] for name in dict.fromkeys([*names, *figure_runs])),
        tuple(dict.fromkeys([*antennas, *(antenna_name(model) for model in MODELS if figures)])),
    )


def build_rows(
    plan: Plan, runs: Mapping[str, xr.Dataset], modes: Mapping[str, xr.Dataset]
) -> dict[tuple[str, str], list[Row]]:
    """Rows of every table of a plan, by (variant, table), from the runs and modes that it names."""
    return {(variant, name): list(_TABLES[name].build(variant, runs, modes)) for variant, name in plan.tables}


def summarize(rows: Mapping[tuple[str, str], Sequence[Row]]) -> list[Row]:
    """Score a comparison, each variant that is there: mean |log ratio| of Tables 6 to 9, mean error of Table 2.

    Every published number counts once: the last row of Table 8 is the first of Table 6. Scores stand only where all
    their tables are there.
    """
    scores = []
    for variant in VARIANTS:
        found = [rows.get((variant, str(number))) for number in published.RESPONSE_TABLES]
        if all(found):
            listed = [row for table in found for row in table or ()]
            for quantity in ("response frequency", "amplitude"):
                count = sum(row.quantity == quantity and not row.repeats for row in listed)
                words, note = f"mean |log ratio|, {quantity}", f"Tables 6 to 9, {count} numbers"
                score = mean_log_ratio(listed, quantity)
                scores.append(Row("summary", "Tables 6-9", words, None, score, "1", note, variant))
        if table := rows.get((variant, "2")):
            score = 100.0 * mean_difference(table)
            note = "ten natural frequencies of M2"
            scores.append(Row("summary", "Table 2", "mean |difference|", None, score, "%", note, variant))
    return scores
