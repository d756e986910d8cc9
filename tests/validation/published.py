"""Numbers printed in the paper, each once: Aerospace 2022, 9(12), 794 (CC BY 4.0)."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

# Table 2: natural frequencies of M2 [Hz]
NATURAL_FREQUENCIES = (1.0005, 1.2498, 1.6040, 1.9923, 2.0101, 2.1286, 2.4265, 2.4586, 2.7534, 2.9362)

# Table 3: normal modes nearest to the dominant shape (M2, pi/5, T = 1 s, alpha = beta = 0.01), MAC [%]
DOMINANT_SHAPE_MAC = {4: 76.28, 5: 3.75, 23: 2.74, 7: 1.69, 51: 1.12}

# Table 4: cable tension along x and y [N]
PRETENSION = {"M1": (0.147, 0.25), "M2": (0.59, 1.0), "M3": (3.1, 3.7)}

# Table 6, first column: fundamental frequency [Hz]
FUNDAMENTAL_FREQUENCY = {"M1": 0.5003, "M2": 1.0005, "M3": 2.0000}

# Damping of section 4 was not printed; 0.001 is the smaller of the two values of section 3.
DAMPING = 0.001

# Records of 10 s were zero-padded before the transform: the printed frequencies are whole multiples of a bin.
PADDED_TO_SIX = 10.48576  # Tables 6, 8, 9 [s], bins 0.0953674 Hz apart
PADDED_TO_SEVEN = 16.384  # Table 7 [s], bins 0.0610352 Hz apart


class Response(NamedTuple):
    """One row of Tables 6 to 9: response of point A to a stop."""

    table: int
    model: str
    rate: float  # [rad/s]
    duration: float  # [s]
    frequency: float  # [Hz]
    amplitude: float  # [m]


RESPONSES = (
    Response(6, "M1", pi / 100, 0.1, 0.9537, 0.4441e-3),
    Response(6, "M2", pi / 100, 0.1, 2.0027, 0.2101e-3),
    Response(6, "M3", pi / 100, 0.1, 3.9101, 0.0871e-3),
    Response(7, "M3", pi / 5, 0.1, 4.1504, 1.412e-3),
    Response(7, "M3", pi / 5, 1.0, 3.7231, 0.1549e-3),
    Response(7, "M3", pi / 5, 2.0, 3.6621, 0.0773e-3),
    Response(8, "M1", pi / 2, 0.1, 2.3842, 6.3172e-3),
    Response(8, "M1", pi / 5, 0.1, 1.7166, 3.9360e-3),
    Response(9, "M1", pi / 5, 1.0, 1.2398, 1.4542e-3),
    Response(9, "M1", pi / 50, 0.1, 1.0490, 0.7831e-3),
)
