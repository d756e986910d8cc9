"""Words for the large gaps, each a sentence; what is known about their causes [identification of the paper's model]."""

from __future__ import annotations

_COMPRESSED = "the film is compressed in this run, a real one would wrinkle"
_STIFFER = "our M1 stiffens at smaller amplitudes than the paper's"
_FACTOR_TWO = "at the printed coordinates every model under the whole load moves about twice as much as the paper's"

_MISPRINT = {
    ("4", "M1", "natural frequency of the dominant mode"): (
        "the printed 0.94 Hz contradicts the paper's tensions: those of M1 are a quarter of those of M2, hence 0.996 Hz"
    )
}
_FIRST = _MISPRINT | {
    ("6", "M1, pi/100 rad/s, T = 0.1 s", "response frequency"): _STIFFER,
    ("6", "M1, pi/100 rad/s, T = 0.1 s", "amplitude"): _COMPRESSED,
    ("8", "M1, pi/2 rad/s, T = 0.1 s", "response frequency"): (
        "cables with stiffness damping hold the film's edge; " + _COMPRESSED
    ),
    ("8", "M1, pi/2 rad/s, T = 0.1 s", "amplitude"): _COMPRESSED,
    ("9", "M1, pi/50 rad/s, T = 0.1 s", "response frequency"): _STIFFER,
    ("9", "M1, pi/50 rad/s, T = 0.1 s", "amplitude"): _COMPRESSED,
}
_PUBLISHED = _MISPRINT | {
    ("8", "M1, pi/5 rad/s, T = 0.1 s", "response frequency"): (
        "a weaker, steady vibration near 1.14 Hz has a line almost as high; " + _COMPRESSED
    ),
    ("8", "M1, pi/2 rad/s, T = 0.1 s", "response frequency"): "several lines of the spectrum are almost as high",
    ("9", "M1, pi/5 rad/s, T = 1 s", "amplitude"): _COMPRESSED,
}


def note_for(variant: str, table: str, case: str, quantity: str) -> str:
    """Return what is known about a gap, "" where there is nothing to say."""
    if variant == "consistent":
        return _FACTOR_TWO if quantity == "amplitude" and "M1, pi/2" not in case else ""
    return (_PUBLISHED if variant == "published" else _FIRST).get((table, case, quantity), "")
