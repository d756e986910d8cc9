"""Direct solvers of one sparse symmetric matrix: one small file each, all with the interface of `Backend`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tautflex.numeric import Array
from tautflex.solvers.linear.ldl import PanelLDL
from tautflex.solvers.linear.lu import PivotedLU
from tautflex.solvers.linear.pardiso import Pardiso
from tautflex.solvers.linear.qdldl import PlainLDL


class Backend(Protocol):
    """Factors of a symmetric matrix whose upper triangle has a fixed pattern.

    Parameters
    ----------
    size
        Number of unknowns.
    column_start, rows
        Compressed columns of the upper triangle.
    memo
        Where what it finds out about the pattern is kept for other matrices of the same one.
    """

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if a pivot is zero."""
        ...

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        ...

    def negative_pivots(self) -> int | None:
        """Number of negative eigenvalues, None if these factors do not tell."""
        ...

    @property
    def fill(self) -> int:
        """Stored entries of the factors."""
        ...


Maker = Callable[[int, NDArray[np.int32], NDArray[np.int32], dict[str, Any]], Backend]

BACKENDS: dict[str, Maker] = {"ldl": PanelLDL, "qdldl": PlainLDL, "superlu": PivotedLU, "pardiso": Pardiso}

__all__ = ["BACKENDS", "Backend", "Maker", "PanelLDL", "Pardiso", "PivotedLU", "PlainLDL"]
