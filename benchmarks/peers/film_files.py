"""What the scripts of the film share, in any program's environment: numbers of nodes, and the result file."""

from __future__ import annotations

import json

import numpy as np


def corners(problem):
    """Positions (corner, 2) and triangles (triangle, 3) of the corners alone."""
    used, triangles = np.unique(problem["triangles"][:, :3], return_inverse=True)
    return problem["nodes"][used, :2], triangles.reshape(-1, 3).astype(np.int64)


def matched(points, nodes):
    """Place among points of each node, both (node, 2) [m]; RuntimeError if they are not the same places."""
    theirs, ours = (np.lexsort(np.round(place, 9).T) for place in (points, nodes))
    if len(theirs) != len(ours) or not np.allclose(points[theirs], nodes[ours]):
        raise RuntimeError("the unknowns were not matched to the nodes")
    place = np.empty(len(ours), dtype=np.int64)
    place[ours] = theirs
    return place


def film_result(record, clock, set_up_seconds, **details):
    """Arrays of a result file; ``details`` are version, solver, iterations and factorizations."""
    clock = np.array(clock)
    return {
        "displacement": record,
        "seconds": clock[-1, 1],
        "set_up_seconds": np.array(set_up_seconds),
        "clock": clock,
        "details": np.array(json.dumps(details)),
    }
