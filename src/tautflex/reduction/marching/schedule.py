"""Time grid of a reduced run: stretches of equal steps that end at the limits of segments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices

# Steps of the first blocks of a segment, and most of one: they bound the memory of sampled frame terms.
_SHORTEST, LONGEST = 512, 4096


class Stretch(NamedTuple):
    """Steps of equal size inside one segment.

    Frame terms are sampled over a whole block of steps, wherever a run begins and ends in it: so one that is cut takes
    the same steps to the last bit.

    Parameters
    ----------
    segment
        Number of the segment.
    size
        Of each step [s].
    span
        Start of the block's first and of its last step [s], and the number of its steps.
    starts
        Start of each step [s].
    grid
        Number of the grid instant at the end of each step, -1 between two.
    """

    segment: int
    size: float
    span: tuple[float, float, int]
    starts: Array
    grid: Indices


def segment_numbers(segments: tuple[Segment, ...], times: Array) -> Indices:
    """Number of the segment of each instant [s]; a limit belongs to the segment after it."""
    slack = 1e-9 * np.maximum(1.0, times)
    return np.searchsorted([segment.start for segment in segments], times + slack, side="right") - 1


def stretches(
    segments: tuple[Segment, ...], step: float, begin: int, count: int, shift: float = 0.0
) -> Iterator[Stretch]:
    """Steps from grid instant ``begin`` to ``count`` in order; instant n is at ``shift + n step`` [s]."""
    slack = 1e-9 * step
    for number, segment in enumerate(segments):
        # Last grid instants at the segment's limits; a limit on an instant belongs to the segment before it.
        first = _last_until(segment.start, step, shift)
        last = _last_until(segment.end, step, shift)
        if first >= count:
            return
        if last < begin or segment.end <= shift + begin * step + slack:
            continue
        start, done = segment.start, first
        if abs(start - (shift + first * step)) < slack:
            start = shift + first * step
        elif last > first:  # up to the grid
            done = first + 1
            if done > begin:
                yield _single(number, start, shift + done * step, done)
        yield from _blocks(number, step, shift, (done, last), (begin, count))
        if last < count and segment.end > shift + last * step + slack:
            yield _single(number, max(start, shift + last * step), segment.end, -1)


def _last_until(time: float, step: float, shift: float) -> float:
    """Number of the last grid instant until a time [s]."""
    return float(np.floor((time - shift) / step + 1e-9))


def _single(number: int, start: float, end: float, grid: float) -> Stretch:
    """One step off the grid."""
    return Stretch(number, end - start, (start, start, 1), np.array([start]), np.array([int(grid)]))


def _blocks(
    number: int, step: float, shift: float, whole: tuple[float, float], asked: tuple[int, int]
) -> Iterator[Stretch]:
    """Whole steps of a segment between two grid instants, as many as are asked for, in blocks of fixed limits."""
    first, size = whole[0], _SHORTEST
    while first < min(whole[1], asked[1]):
        end = min(first + size, whole[1])
        grid = np.arange(max(first, asked[0]), min(end, asked[1]), dtype=np.int64)
        if grid.size:
            span = shift + first * step, shift + (end - 1) * step, int(end - first)
            starts = np.asarray(shift + grid * step, dtype=np.float64)
            yield Stretch(number, step, span, starts, grid + 1)
        first, size = end, min(int(end - whole[0]), LONGEST)
