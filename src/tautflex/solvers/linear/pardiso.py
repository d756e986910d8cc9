"""MKL's PARDISO through ``pypardiso`` (extra ``pardiso``): symmetric indefinite factors with 1x1 and 2x2 pivots."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tautflex.errors import MissingExtraError
from tautflex.numeric import Array
from tautflex.solvers.linear.backend import Backend

_SYMMETRIC_INDEFINITE = -2
_ANALYSE, _FACTORIZE, _SOLVE, _RELEASE = 11, 22, 33, -1
# Numbers of PARDISO's parameters: entries of the factors, negative eigenvalues.
_FILL, _NEGATIVE = 18, 23


def available() -> bool:
    """Whether ``pypardiso`` is installed."""
    return find_spec("pypardiso") is not None


class Pardiso(Backend):
    """L D L' with pivoting, ordered once.

    Raises
    ------
    MissingExtraError
        If ``pypardiso`` is not installed.
    """

    def __init__(
        self, size: int, column_start: NDArray[np.int32], rows: NDArray[np.int32], memo: dict[str, Any]
    ) -> None:
        try:
            from pypardiso import PyPardisoSolver
        except ImportError as error:
            raise MissingExtraError(
                "linear solver 'pardiso': expected the package pypardiso, which is not installed; "
                "pip install 'tautflex[pardiso]', or use 'ldl'"
            ) from error
        self._solver: Any = PyPardisoSolver(mtype=_SYMMETRIC_INDEFINITE)
        # PARDISO wants the upper triangle by rows: the transpose's order.
        places = csr_array((np.arange(1.0, len(rows) + 1.0), rows, column_start), shape=(size, size)).tocsc()
        self._order = places.data.astype(np.int64) - 1
        self._matrix = csr_array((np.zeros(len(rows)), places.indices, places.indptr), shape=(size, size))
        self._empty = np.zeros(size)
        self._matrix.data[:] = self._matrix.indices == np.repeat(np.arange(size), np.diff(self._matrix.indptr))
        self._call(_ANALYSE, self._empty)

    def _call(self, phase: int, right: Array) -> Array:
        self._solver.set_phase(phase)
        try:
            return np.asarray(self._solver._call_pardiso(self._matrix, right))
        except Exception as error:  # the wrapper's own class, known only where it is installed
            raise np.linalg.LinAlgError(f"PARDISO: {error}") from error

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if it is singular."""
        self._matrix.data[:] = values[self._order]
        self._call(_FACTORIZE, self._empty)

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        return self._call(_SOLVE, np.ascontiguousarray(right, dtype=float))

    def negative_pivots(self) -> int:
        """Number of negative eigenvalues."""
        return int(self._solver.get_iparm(_NEGATIVE))

    @property
    def fill(self) -> int:
        """Stored entries of the factors."""
        return int(self._solver.get_iparm(_FILL))

    def __del__(self) -> None:
        """Give MKL's memory back; its handle knows nothing of Python's."""
        if hasattr(self, "_empty"):
            self._call(_RELEASE, self._empty)
