"""Panel L D L' factors in QDLDL's ordering: the default for all sizes of our structures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.numeric import Array
from tautflex.solvers.linear.backend import Backend
from tautflex.solvers.linear.panels import PanelPattern, analyse, factorize_panels
from tautflex.solvers.linear.substitution import substitute


class PanelLDL(Backend):
    """L D L' without pivoting, ordered once."""

    def __init__(
        self, size: int, column_start: NDArray[np.int32], rows: NDArray[np.int32], memo: dict[str, Any]
    ) -> None:
        if "panels" not in memo:
            memo["panels"] = analyse(size, column_start, rows)
        pattern: PanelPattern = memo["panels"]
        self._pattern = tuple(pattern)
        self._values, self._pivots = np.empty(len(pattern.rows)), np.empty(size)
        self._inverse = np.empty(size)

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if a pivot is zero."""
        if not factorize_panels(self._pattern, values, self._values, self._pivots):
            raise np.linalg.LinAlgError("a pivot is zero")
        np.divide(1.0, self._pivots, out=self._inverse)

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        right = np.ascontiguousarray(right, dtype=float)
        solution: Array = substitute(self._pattern, self._values, self._inverse, right)
        return solution

    @property
    def parts(self) -> tuple[Any, ...]:
        """Pattern, entries of L and reciprocal pivots."""
        return self._pattern, self._values, self._inverse

    def negative_pivots(self) -> int:
        """Number of negative eigenvalues (Sylvester's law of inertia)."""
        return int(np.count_nonzero(self._pivots < 0.0))

    @property
    def fill(self) -> int:
        """Stored entries of L and D."""
        return len(self._values) + len(self._pivots)
