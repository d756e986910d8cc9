"""What matches, what does not, and why: fixed explanations, every result in them taken from the rows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tautflex.reproduce import published
from tautflex.reproduce.page_blocks import FAIR, GOOD, percent, quantity_text
from tautflex.reproduce.page_tables import (
    CONSISTENT,
    Rows,
    difference,
    mean_difference,
    mean_log_ratio,
    responses,
)

if TYPE_CHECKING:
    from tautflex.reproduce.tables import Row

Words = tuple[str, str]

INTRODUCTION = (
    "The paper (Aerospace 2022, 9(12), 794) leaves out the number and the places of the cables, the "
    "supports of the frame, "
    "the mesh and how point A was read. Two readings stand here side by side. The published reading is the one "
    "configuration that comes closest to all tables together; two of its numbers, the film's tension per "
    "newton of cable "
    "along x and along y, are fitted to Tables 2 and 4, its other choices were made by comparing "
    "candidates on these same "
    "tables, and nothing is tuned case by case. The consistent variant is a structure that could be built: "
    "cables and film in static "
    "equilibrium, results converged in mesh and time step. It is further from the tables, and that is a "
    "finding, not a "
    "fault of it."
)


def scores(rows: Rows) -> list[Words]:
    """Agreement in numbers, and the entries that disagree most."""
    items = []
    if rows.get("2"):
        worst = max(rows["2"], key=_size)
        text = (
            f"mean difference {100 * mean_difference(rows['2']):.2f} %, the largest {percent(difference(worst) or 0.0)}"
        )
        items.append(("Table 2:", f"{text} ({worst.case}, {worst.quantity})."))
    for unit, name in (("Hz", "Response frequencies"), ("mm", "Amplitudes")):
        ours, other = responses(rows, unit), responses(rows, unit, CONSISTENT)
        if not ours:
            continue
        good, fair = _within(ours, GOOD), _within(ours, FAIR)
        text = f"mean |log ratio| {mean_log_ratio(ours):.3f} over {len(ours)} entries of Tables 6 to 9; "
        text += f"{good} of them within {100 * GOOD:.0f} %, {fair} within {100 * FAIR:.0f} %."
        if other:
            text += f" The consistent variant: {mean_log_ratio(other):.3f}."
        items.append((f"{name}:", text))
    return items


def largest_gaps(rows: Rows) -> list[Words]:
    """Name every response that is further off than a fair difference, worst first."""
    far = [row for unit in ("Hz", "mm") for row in responses(rows, unit) if _size(row) > FAIR]
    return [
        (f"Table {row.table}, {row.case}, {row.quantity}:", f"{_pair(row)} ({percent(difference(row) or 0.0)}).")
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
        verdicts = [
            f"{name} {_ordering(responses({number: rows.get(number, ())}, unit), unit)}"
            for unit, name in (("Hz", "frequency"), ("mm", "amplitude"))
            if len(responses({number: rows.get(number, ())}, unit)) > 1
        ]
        if verdicts:
            items.append((f"Table {number}:", f"{words}. Ours: {'; '.join(verdicts)}."))
    return items


def explanations(rows: Rows) -> list[Words]:
    """Reasons for the differences, each with the numbers it explains."""
    return [
        ("Mesh.", _mesh(rows)),
        ("Layout.", _LAYOUT),
        ("Point A.", _POINT_A),
        ("Wrinkling.", _wrinkling(rows)),
        ("FFT bins.", _bins()),
        ("M1's dominant mode.", _dominant(rows)),
        ("M1 stopped from π/2 rad/s.", _fastest(rows)),
        ("Duration of the stop (Table 7).", _durations(rows)),
        ("Where the rise in frequency comes from.", _HARDENING),
        ("How far the tables reach.", _REACH),
    ]


_LAYOUT = (
    "The published reading is not in static equilibrium. Every cable carries the tension of Table 4, about "
    "ten times what "
    "the film's own tension can balance, and the rest is taken as carried by the reference state: "
    "pretension acts through the "
    "geometric stiffness alone, as in a code with independent inputs for cables and film. Tensions in "
    "balance (the "
    "consistent variant) fit the natural frequencies nearly as well, but give much larger amplitudes in "
    "the linear runs. Few cables "
    "on straight edges are no way out: between them the free edge is compressed and no taut equilibrium exists."
)
_POINT_A = (
    "At the printed coordinates of point A, interpolated in the film, every configuration tried gives "
    "about twice the "
    "published amplitude in the runs that are nearly linear. The published reading takes the nearest node "
    "of its mesh, "
    "which lies on the long edge at (0.8, 0.5) m; which of the two the paper means is not known, and the "
    "choice was made "
    "after seeing which fits. On a finer mesh the nearest node is another point, so this reading holds on "
    "the coarse mesh only."
)
_HARDENING = (
    "The paper ascribes it to the rotation, which adds stiffness in proportion to the square of the "
    "angular velocity and to "
    "the angular acceleration. Those terms are small against the square of the natural circular "
    "frequencies, as the table of "
    "switched-off terms shows: without them the response hardly changes. A stop as short and strong as the "
    "paper's "
    "deflects the film by many times its thickness, and it is this deflection that stretches and stiffens "
    "it: geometric "
    "hardening. At a thousandth of the angular velocity, where there is no hardening, the frequency is the "
    "natural one."
)
_REACH = (
    "A single Duffing oscillator with four fitted constants already follows all numbers of Tables 6 to 9 "
    "more closely than any "
    "configuration here. The tables hold too little to tell configurations apart finely: the published "
    "reading is a "
    "consistent one, not a proof."
)


def _mesh(rows: Rows) -> str:
    text = (
        "Table 2 can only be met with a mesh about as coarse as 10 x 5 cells, whose triangles of constant "
        "strain are too "
        "stiff for the higher modes; refined meshes with the same physical parameters give lower "
        "frequencies, and more so "
        "the higher the mode."
    )
    other = rows.get("2" + CONSISTENT)
    if rows.get("2") and other:
        text += (
            f" Here the coarse mesh differs from Table 2 by {100 * mean_difference(rows['2']):.2f} % on "
            "average, "
            f"the converged consistent variant by {100 * mean_difference(other):.2f} %."
        )
    return text + " If this reading is right, the paper's results are not converged in the mesh."


def _wrinkling(rows: Rows) -> str:
    text = (
        "The film has next to no bending stiffness: where a principal stress turns negative it wrinkles, "
        "and the elastic law "
        "of the paper no longer describes it."
    )
    tensions = [row for row in rows.get("compression", ()) if row.unit == "N/m" and row.ours is not None]
    pressed = [row for row in tensions if row.ours < 0.0]
    if tensions:
        text += f" The smallest principal resultant turns negative in {len(pressed)} of {len(tensions)} runs"
        if pressed:
            worst = min(pressed, key=lambda row: row.ours)
            text += f", down to {quantity_text(worst.ours, worst.unit)} N/m ({worst.case})"
        text += "; the table of compression says in which, and when."
    return text + " Read the strongly driven cases, M1's above all, with that in mind."


def _bins() -> str:
    widths = {number: 1.0 / float(published.about(number)["padded_duration"]) for number in published.RESPONSE_TABLES}
    by_width: dict[float, list[str]] = {}
    for number, width in widths.items():
        by_width.setdefault(width, []).append(str(number))
    words = "; ".join(f"{width:.7f} Hz in Table{'s' * (len(of) > 1)} {', '.join(of)}" for width, of in by_width.items())
    return (
        f"The published frequencies are whole multiples of the distance between the lines of a padded "
        f"Fourier transform: {words}. "
        "They are known to half of that at best. Ours are read on the same lines, from the motion after "
        "the stop: during the "
        "stop the film vibrates about a deflected position, whose offset would outweigh the vibration."
    )


def _dominant(rows: Rows) -> str:
    printed = {entry["model"]: entry for entry in published.table(4)}
    first, second = printed["M1"], printed["M2"]
    scale = math.sqrt(first["pretension_y"] / second["pretension_y"])
    text = (
        f"The paper gives {first['dominant_frequency']:g} Hz for M1 and {second['dominant_frequency']:g} "
        "Hz for M2, but M1's "
        f"tensions are a quarter of M2's, and frequencies go with the root of the tension: {scale:g} times "
        f"{second['dominant_frequency']:g} Hz is {scale * second['dominant_frequency']:.3f} Hz."
    )
    ours = next(
        (row for row in rows.get("4", ()) if "M1" in row.case and row.paper == first["dominant_frequency"]), None
    )
    if ours is not None:
        text += f" Ours is {quantity_text(ours.ours, ours.unit)} Hz."
    return text + " The printed value is a misprint or comes from another mesh."


def _fastest(rows: Rows) -> str:
    found = responses({"8": rows.get("8", ())}, "Hz")
    text = ""
    if found:
        text = f"Response frequency {_pair(max(found, key=lambda row: row.paper or 0.0))}. "
    return text + (
        "The response of this, the softest antenna in the strongest maneuver, has several spectral peaks "
        "of similar height; "
        "which is the largest changes with mesh, time step and point. The film is in compression for much "
        "of the run. We know of "
        "no reading that gives the published frequency."
    )


def _durations(rows: Rows) -> str:
    found = responses({"7": rows.get("7", ())}, "Hz")
    mode = {entry["model"]: entry["dominant_frequency"] for entry in published.table(4)}["M3"]
    text = "The paper says that the response approaches the dominant mode as the stop gets longer."
    below = [row for row in found if (row.paper or mode) < mode]
    if below:
        values = " and ".join(f"{row.paper:g}" for row in below)
        text += f" Its own values for the longer stops, {values} Hz, lie below that mode, printed as {mode:g} Hz;"
        text += " no hardening system does that."
    if found:
        values = ", ".join(f"{row.ours:.3f}" for row in found)
        text += f" Ours, {values} Hz, come down to the natural frequency of our mode and stay there."
    return text


def _ordering(rows: Sequence[Row], unit: str) -> str:
    """Whether ours rises and falls where the paper's does, from row to row."""
    agree, ties = True, False
    for before, after in itertools.pairwise(rows):
        step = (after.ours - before.ours) * ((after.paper or 0.0) - (before.paper or 0.0))
        agree &= step >= 0.0
        ties |= step == 0.0
    values = ", ".join(f"{row.ours:.3f}" for row in rows)
    verdict = "yes, with ties" if agree and ties else "yes" if agree else "no"
    return f"{verdict} ({values} {unit})"


def _pair(row: Row) -> str:
    return f"ours {quantity_text(row.ours, row.unit)} {row.unit}, paper {quantity_text(row.paper, row.unit)} {row.unit}"


def _size(row: Row) -> float:
    return abs(difference(row) or 0.0)


def _within(rows: Sequence[Row], limit: float) -> int:
    return sum(_size(row) <= limit for row in rows)
