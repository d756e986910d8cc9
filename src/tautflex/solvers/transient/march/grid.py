"""Results of adaptive steps: what lies on the grid between the ends of a step, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.restressing import restress_sample
from tautflex.numeric import jit
from tautflex.solvers.transient.recorder import record
from tautflex.solvers.transient.state import hermite


@jit
def record_between(
    grid: Any, k: int, before: Any, after: Any, start: float, end: float, samples: Any, stress: Any
) -> None:
    """Take down what lies on the grid of results in the ``k``-th step of a stretch, between two states.

    ``grid`` holds its instants [s], the first of every step, whether an instant is the end of its step, rows of samples
    and of fields, as in `take_steps`, and room for displacement, velocity and acceleration at the last one; ``stress``
    is that of the stretch.
    """
    (targets, first, ends, rows, places, seen), (recorded, _, fields, _) = grid, samples
    for j in range(first[k], first[k + 1]):
        time = targets[j]
        if ends[j]:
            time = end
            seen[0], seen[1], seen[2] = after[0], after[1], after[2]
        else:
            share = (time - start) / (end - start)
            seen[0], seen[1] = hermite(start, end, time, (before[0], after[0]), (before[1], after[1]))
            seen[2] = before[2] + share * (after[2] - before[2])
        if rows[j] >= 0:
            restress_sample(stress, recorded[0], j)
            record(recorded, seen[0], seen[1], time, rows[j], np.nan, np.nan)
        if places[j] >= 0:
            fields[places[j]] = seen[0]
