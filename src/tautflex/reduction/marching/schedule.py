"""Which steps a run takes: on the time grid, and onto the limits of segments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices


class Stretch(NamedTuple):
    """Steps of equal size inside one segment.

    ``starts`` are instants [s], ``grid`` the number of the grid instant at the end of each step, -1 between two.
    """

    segment: int
    size: float
    starts: Array
    grid: Indices


def stretches(segments: tuple[Segment, ...], step: float, count: int, longest: int) -> Iterator[Stretch]:
    """Steps from 0 to ``count * step`` [s] in order, at most ``longest`` in one stretch."""
    slack = 1e-9 * step
    done, time = 0, 0.0
    for number, segment in enumerate(segments):
        if done >= count:
            return
        if segment.end <= time + slack:
            continue
        # Grid instants up to the segment's limit; a limit on an instant belongs to the segment before it.
        last = count if not np.isfinite(segment.end) else min(count, int(np.floor((segment.end + slack) / step)))
        ends = np.arange(done + 1, last + 1) * step
        grid = np.arange(done + 1, last + 1)
        if last < count and segment.end > last * step + slack:
            ends, grid = np.append(ends, segment.end), np.append(grid, -1)
        starts = np.concatenate([[time], ends[:-1]])
        sizes = ends - starts
        sizes[np.abs(sizes - step) < slack] = step
        changes = np.flatnonzero(np.diff(sizes)) + 1
        for part in np.split(np.arange(len(ends)), changes):
            for first in range(0, len(part), longest):
                piece = part[first : first + longest]
                if piece.size:
                    yield Stretch(number, float(sizes[piece[0]]), starts[piece], grid[piece])
        if len(ends):
            time, done = float(ends[-1]), last
