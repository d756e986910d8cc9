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
    """Factors of a symmetric matrix whose upper triangle has a fixed pattern."""

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

# Name -> class, made from size, column starts and rows of the upper triangle, and a place for what it finds out.
BACKENDS: dict[str, Maker] = {"ldl": PanelLDL, "qdldl": PlainLDL, "superlu": PivotedLU, "pardiso": Pardiso}

__all__ = ["BACKENDS", "Backend", "Maker", "PanelLDL", "Pardiso", "PivotedLU", "PlainLDL"]
