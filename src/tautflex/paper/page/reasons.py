"""Why ours and the paper's differ: fixed explanations, every result in them taken from the rows."""

from __future__ import annotations

import math

from tautflex.paper.page.agreement import CONSISTENT, Rows, both, responses
from tautflex.paper.page.markdown import quantity_text, symbols
from tautflex.paper.page.words import Words
from tautflex.paper.tables import published
from tautflex.paper.tables.rows import Row, mean_difference


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
        ("Dominant shape (Table 3).", _shape(rows)),
        ("Where the rise in frequency comes from.", _hardening(rows)),
        ("How far the tables reach.", _REACH),
    ]


_LAYOUT = (
    "The published reading is not in static equilibrium. Every cable carries the tension of Table 4, about ten "
    "times what the film's own tension can balance, and the rest is taken as carried by the reference state: "
    "pretension acts through the geometric stiffness alone, as in a code with independent inputs for cables and "
    "film. Tensions in balance (the consistent variant) fit the natural frequencies less well and give much larger "
    "amplitudes in the linear runs. Few cables on straight edges are no way out: between them the free edge is "
    "compressed and no taut equilibrium exists."
)
_POINT_A = (
    "At the printed coordinates of point A, interpolated in the film, every configuration tried gives about twice "
    "the published amplitude in the runs that are nearly linear. The published reading takes the nearest node of "
    "its mesh, which lies on the long edge at (0.8, 0.5) m; which of the two the paper means is not known, and the "
    "choice was made after seeing which fits. On a finer mesh the nearest node is another point, so this reading "
    "holds on the coarse mesh only."
)
_HARDENING = (
    "The paper ascribes it to the rotation, which adds stiffness in proportion to the square of the angular "
    "velocity and to the angular acceleration. Those terms are small against the squares of the natural circular "
    "frequencies, and they vanish with the rotation, while the frequency is that of the motion after the stop. A "
    "stop as strong as the paper's deflects the film by many times its thickness, and it is this deflection that "
    "stretches and stiffens it: geometric hardening."
)
_ROUND_OFF = 5e-3  # [Hz], less than an interpolated peak is worth
_OTHER_MODE = (
    "We do not read this as softening: a stop about as long as a whole number of periods of the dominant mode "
    "hardly excites that mode, so that in the linear response another one leads, and the difference compares two "
    "modes."
)
_REACH = (
    "A single Duffing oscillator with a few fitted constants already follows all numbers of Tables 6 to 9 more "
    "closely than any configuration here. The tables hold too little to tell configurations apart finely: the "
    "published reading is a consistent one, not a proof."
)


def _mesh(rows: Rows) -> str:
    text = (
        "Table 2 can only be met with a mesh about as coarse as 10 x 5 cells, whose triangles of constant strain "
        "are too stiff for the higher modes; refined meshes with the same physical parameters give lower "
        "frequencies, and more so the higher the mode."
    )
    other = rows.get("2" + CONSISTENT)
    if rows.get("2") and other:
        text += (
            f" Here the coarse mesh differs from Table 2 by {100 * mean_difference(rows['2']):.2f} % on average, "
            f"the converged consistent variant by {100 * mean_difference(other):.2f} %."
        )
    return text + " If this reading is right, the paper's results are not converged in the mesh."


def _wrinkling(rows: Rows) -> str:
    text = (
        "The film has next to no bending stiffness: where a principal stress turns negative it wrinkles, and the "
        "elastic law of the paper no longer describes it."
    )
    tensions = [(row.ours, row) for row in rows.get("compression", ()) if row.unit == "N/m" and row.ours is not None]
    pressed = [(tension, row) for tension, row in tensions if tension < 0.0]
    if tensions:
        soft = [sum(row.case.startswith("M1") for _, row in some) for some in (pressed, tensions)]
        text += f" The smallest principal resultant turns negative in {len(pressed)} of {len(tensions)} runs, in "
        text += f"{soft[0]} of the {soft[1]} of M1"
        if pressed:
            tension, worst = min(pressed, key=lambda one: one[0])
            text += f", down to {quantity_text(tension, worst.unit)} N/m ({symbols(worst.case)})"
        text += "; the table of compression says in which, and when."
    return text + " Read the strongly driven cases, M1's above all, with that in mind."


def _bins() -> str:
    by_width: dict[float, list[str]] = {}
    for number in published.RESPONSE_TABLES:
        by_width.setdefault(1.0 / published.about(number)["padded_duration"], []).append(str(number))
    words = "; ".join(f"{width:.7f} Hz in Table{'s' * (len(of) > 1)} {', '.join(of)}" for width, of in by_width.items())
    return (
        "The published frequencies are whole multiples of the distance between the lines of a padded Fourier "
        f"transform: {words}. "
        "They are known to half of that at best. Ours are read on the same lines, from the motion after the stop: "
        "during the stop the film vibrates about a deflected position, whose offset would outweigh the vibration."
    )


def _hardening(rows: Rows) -> str:
    rise, geometric, rotation = (
        {row.case: row for row in rows.get("ablation", ()) if row.quantity == quantity and row.ours is not None}
        for quantity in ("rise over the dominant mode", "rise from geometric nonlinearity", "rise from G and K_T")
    )
    text = _HARDENING
    known = [case for case in rise if case in geometric]
    if known:
        case = max(known, key=lambda name: rise[name].ours or 0.0)
        text += f" The largest rise, {symbols(case)}: the response lies {_hertz(rise[case])} above the dominant mode; "
        text += f"geometric nonlinearity switched off lowers it by {_hertz(geometric[case])}"
        text += f", the terms of the rotation by {_hertz(rotation[case])}." if case in rotation else "."
    other = [name for name in known if (geometric[name].ours or 0.0) < -_ROUND_OFF]
    if other:
        text += f" In {len(other)} of the {len(known)} cases ({'; '.join(map(symbols, other))}) the response at small "
        text += "amplitude peaks higher than at full amplitude. " + _OTHER_MODE
    return text


def _hertz(row: Row) -> str:
    return f"{quantity_text(row.ours, row.unit)} {row.unit}"


def _dominant(rows: Rows) -> str:
    printed = {entry["model"]: entry for entry in published.table(4)}
    first, second = printed["M1"], printed["M2"]
    scale = math.sqrt(first["pretension_y"] / second["pretension_y"])
    text = (
        f"The paper gives {first['dominant_frequency']:g} Hz for M1 and {second['dominant_frequency']:g} Hz for M2, "
        f"but M1's tensions are a quarter of M2's, and frequencies go with the root of the tension: {scale:g} times "
        f"{second['dominant_frequency']:g} Hz is {scale * second['dominant_frequency']:.3f} Hz."
    )
    for suffix, words in (("", "Ours is"), (CONSISTENT, "The converged consistent variant has")):
        for row in rows.get("4" + suffix, ()):
            if row.case == "M1" and row.quantity.endswith("dominant mode"):
                text += f" {words} {_hertz(row)}."
    return text + " The printed value is a misprint or comes from a finer mesh than Table 2."


def _fastest(rows: Rows) -> str:
    found = responses(rows, "response frequency", tables=("8",))
    text = (
        "The response of this, the softest antenna in the strongest maneuver, has several spectral peaks of similar "
        "height; which is the largest changes with mesh, time step and point. We know of no reading that gives the "
        "published frequency."
    )
    if not found:
        return text
    worst = max(found, key=lambda row: row.paper or 0.0)
    for row in rows.get("compression", ()):
        if row.case == worst.case and row.quantity == "time compressed" and row.ours:
            text += f" The film is in compression for {row.ours:.0f} % of the run."
    return f"Response frequency {both(worst)}. {text}"


def _durations(rows: Rows) -> str:
    found = responses(rows, "response frequency", tables=("7",))
    mode = {entry["model"]: entry["dominant_frequency"] for entry in published.table(4)}["M3"]
    text = "The paper says that the response approaches the dominant mode as the stop gets longer."
    below = [row for row in found if (row.paper or mode) < mode]
    if below:
        values = " and ".join(f"{row.paper:g}" for row in below)
        text += f" Its own values for the longer stops, {values} Hz, lie below that mode, printed as {mode:g} Hz;"
        text += " no hardening system does that."
    if found:
        values = ", ".join(quantity_text(row.ours, "Hz") for row in found)
        text += f" Ours, {values} Hz, come down to the natural frequency of our mode and stay there."
    return text


def _shape(rows: Rows) -> str:
    text = ""
    found = [row for row in rows.get("3", ()) if row.quantity == "MAC"]
    if found:
        text = f"Its similarity with the mode it resembles most is {both(found[0])}. "
    return text + (
        "That the mode with four half waves along x comes second, in the paper as here, speaks for a mesh whose "
        "diagonals all run one way: on a mesh with mirror symmetry it could not appear at all."
    )
