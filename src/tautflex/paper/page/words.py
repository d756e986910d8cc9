"""What matches and what does not, in words; every number in them is taken from the rows."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from tautflex.paper.page.agreement import CONSISTENT, NEAREST_NODE, Rows, both, responses
from tautflex.paper.page.markdown import FAIR, GOOD, percent, symbols
from tautflex.paper.tables.rows import Row, mean_difference, mean_log_ratio

Words = tuple[str, str]

QUANTITIES = {"response frequency": "Response frequencies", "amplitude": "Amplitudes"}

INTRODUCTION = (
    "The paper (Aerospace 2022, 9(12), 794) leaves out the number and the places of the cables, the supports of the "
    "frame, the mesh and how point A was read. Three answers stand here side by side, each a template of `tautflex "
    "init`. The published reading, m2-paper, is the configuration that comes closest to all tables together: half the "
    "inertial load, damping in proportion to the stiffness of film and frame but not of the cables, point A where it "
    "is printed. The first reading, m2-nearest-node, has the whole load and one damping for all, and takes point A at "
    "the nearest node of its mesh. The consistent variant, m2, is a structure that could be built: cables and film in "
    "static equilibrium, the whole load, results converged in mesh and time step. It is further from the tables, and "
    "that is a finding, not a fault of it."
)


def scores(rows: Rows) -> list[Words]:
    """Agreement in numbers, and the entries that disagree most."""
    items = []
    if rows.get("2"):
        worst = max(rows["2"], key=_size)
        text = f"mean difference {100 * mean_difference(rows['2']):.2f} %, the largest "
        text += f"{percent(worst.difference or 0.0)} ({worst.case}, {worst.quantity})."
        items.append(("Table 2:", text))
    for quantity, name in QUANTITIES.items():
        ours = [row for row in responses(rows, quantity) if not row.repeats]
        others = {"first reading": NEAREST_NODE, "consistent variant": CONSISTENT}
        if not ours:
            continue
        good, fair = (sum(_size(row) <= limit for row in ours) for limit in (GOOD, FAIR))
        text = f"mean |log ratio| {mean_log_ratio(ours, quantity):.3f} over {len(ours)} entries of Tables 6 to 9; "
        text += f"{good} of them within {100 * GOOD:.0f} %, {fair} within {100 * FAIR:.0f} %."
        for words, suffix in others.items():
            if other := responses(rows, quantity, suffix):
                text += f" The {words}: {mean_log_ratio(other, quantity):.3f}."
        items.append((f"{name}:", text))
    return items


def largest_gaps(rows: Rows) -> list[Words]:
    """Name every response that is further off than a fair difference, worst first."""
    listed = [row for quantity in QUANTITIES for row in responses(rows, quantity)]
    far = [row for row in listed if _size(row) > FAIR and not row.repeats]
    return [
        (f"Table {row.table}, {symbols(row.case)}, {row.quantity}:", f"{both(row)} ({percent(row.difference or 0.0)}).")
        for row in sorted(far, key=_size, reverse=True)
    ]


def trends(rows: Rows) -> list[Words]:
    """Say which of the paper's orderings the computed responses follow."""
    items = []
    for number, words in (
        ("6", "the softer the antenna, the lower the frequency and the larger the amplitude"),
        ("7", "the longer the stop, the lower the frequency and the smaller the amplitude"),
        ("8", "the faster the rotation before, the higher the frequency and the larger the amplitude"),
        ("9", "at equal deceleration the faster rotation gives the higher frequency and the larger amplitude"),
    ):
        found = {name: responses(rows, quantity, tables=(number,)) for quantity, name in QUANTITIES.items()}
        verdicts = [f"{name.lower()} {_ordering(among)}" for name, among in found.items() if len(among) > 1]
        if verdicts:
            items.append((f"Table {number}:", f"{words}. Ours: {'; '.join(verdicts)}."))
    return items


def _ordering(rows: Sequence[Row]) -> str:
    """Say whether ours rises and falls where the paper's does, from row to row."""
    pairs = [((row.paper or 0.0), (row.ours or 0.0)) for row in rows]
    steps = [(q - p) * (b - a) for (a, p), (b, q) in itertools.pairwise(pairs)]
    verdict = "no" if min(steps) < 0.0 else "yes, with a tie" if min(steps) == 0.0 else "yes"
    return f"{verdict} ({', '.join(f'{ours:.3f}' for _, ours in pairs)} {rows[0].unit})"


def _size(row: Row) -> float:
    return abs(row.difference or 0.0)
