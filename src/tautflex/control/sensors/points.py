"""Points that sensors look at: of the film, or nodes of frame and cables."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, vstack

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import StructuralSystem
from tautflex.solvers.transient.probes import read_at

Points = tuple[float, ...] | tuple[tuple[float, ...], ...]
COMPONENTS = ("u", "v", "w")


def check_points(points: ArrayLike, component: str) -> None:
    """Raise InputError unless there is a point (x, y) or (x, y, z), or several of them."""
    given = np.atleast_2d(checks.numbers("points", points))
    if given.ndim != 2 or not given.size or given.shape[1] not in (2, 3) or not np.all(np.isfinite(given)):
        raise InputError(
            f"points: expected a point (x, y) or (x, y, z) [m], or a list of them, got shape {np.shape(points)}; "
            "write for example [[0.7, 0.4]]"
        )
    checks.one_of("component", component, COMPONENTS)


def point_rows(system: StructuralSystem, points: ArrayLike, component: str) -> csr_array:
    """Rows on the free unknowns for one displacement component of each point, shape (point, size).

    A point where a node is, of the frame for one, is that node; any other must lie on the film, seen along z, and is
    interpolated as its element does.
    """
    model, rows, axis = system.model, [], COMPONENTS.index(component)
    for number, point in enumerate(np.atleast_2d(np.asarray(points, dtype=float))):
        nodes, weights = read_at(model, f"points.{number}", point)
        rows.append(csr_array(weights[None]) @ model.expansion[model.translation_dofs[nodes, axis]])
    return csr_array(vstack(rows))
