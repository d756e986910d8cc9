"""The paper's numbers as these tests read them; they stand once, in ``tautflex/data/published``."""

from __future__ import annotations

from typing import NamedTuple

from tautflex.paper.tables.published import RESPONSE_TABLES, about, table

NATURAL_FREQUENCIES = tuple(row["frequency"] for row in table(2))  # M2 [Hz]
DOMINANT_SHAPE_MAC = {row["mode"]: row["mac"] for row in table(3)}  # [%]
PRETENSION = {row["model"]: (row["pretension_x"], row["pretension_y"]) for row in table(4)}  # [N]
FUNDAMENTAL_FREQUENCY = {row["model"]: row["fundamental_frequency"] for row in table(6)}  # [Hz]
PADDED_TO_SIX, PADDED_TO_SEVEN = about(6)["padded_duration"], about(7)["padded_duration"]  # [s]

# Damping of section 4 was not printed; 0.001 is the smaller of the two values of section 3.
DAMPING = 0.001


class Response(NamedTuple):
    """One row of Tables 6 to 9: response of point A to a stop."""

    table: int
    model: str
    rate: float  # [rad/s]
    duration: float  # [s]
    frequency: float  # [Hz]
    amplitude: float  # [m]


RESPONSES = tuple(
    Response(
        number,
        row["model"],
        row["rate"],
        row["duration"],
        row["response_frequency"],
        round(1e-3 * row["amplitude"], 12),
    )
    for number in RESPONSE_TABLES
    for row in table(number)
    if "repeats" not in row
)
