"""Sparse direct solution of symmetric systems in the fixed pattern, behind one small interface.

Which solver serves was decided by measurement (`benchmarks/linear_solvers.py`, docs/performance.md): panel L D L' at
every size, SuperLU with pivoting wherever that fails. QDLDL and PARDISO (extra ``pardiso``) can be asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from hashlib import blake2b
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array, Mask
from tautflex.solvers.linear.backend import Backend
from tautflex.solvers.linear.ldl import PanelLDL
from tautflex.solvers.linear.lu import PivotedLU
from tautflex.solvers.linear.pardiso import Pardiso
from tautflex.solvers.linear.qdldl import PlainLDL
from tautflex.solvers.remembering import Memory, Remembering

BACKENDS: dict[str, type[Backend]] = {"ldl": PanelLDL, "qdldl": PlainLDL, "superlu": PivotedLU, "pardiso": Pardiso}
# Fastest at every size measured, 400 to 160 000 unknowns on one core.
_DEFAULT = PanelLDL
_chosen: ContextVar[str] = ContextVar("linear_solver", default="auto")

# Residual of a solution, relative to its right-hand side and the growth in it, that unpivoted factors may leave.
_TRUSTED = 1e-8
# Orders kept with a pattern: whole, reference state, mass, prestress.
_REMEMBERED = 4


@contextmanager
def linear_solver(name: str) -> Iterator[None]:
    """Use one direct solver inside a ``with`` block.

    Parameters
    ----------
    name
        ``"auto"`` (the default outside), ``"ldl"``, ``"qdldl"``, ``"superlu"`` or ``"pardiso"``.

    Raises
    ------
    InputError
        If the name is unknown.
    MissingExtraError
        At the first factorization, if ``"pardiso"`` is not installed.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> with tf.linear_solver("superlu"):
    ...     modes = tf.solve_modes(state, n=1)
    >>> modes.labels
    [(1, 1)]
    """
    checks.one_of("linear_solver", name, ("auto", *BACKENDS))
    token = _chosen.set(name)
    try:
        yield
    finally:
        _chosen.reset(token)


class SymmetricFactorization(Remembering):
    """Factors of a symmetric matrix given by its values in a pattern; the ordering is found once.

    Parameters
    ----------
    pattern
        Sparsity pattern of the matrix.

    Notes
    -----
    Entries that are exactly zero in the first matrix are left out of pattern and ordering: at the flat reference state
    transverse and in-plane unknowns do not meet. A later matrix that needs them gets the whole pattern.

    Most factors do not pivot. Should such a solver meet a zero pivot, or leave a residual in an indefinite matrix, LU
    with pivoting takes over for that matrix. ``factorizations`` and ``solves`` count the work done,
    ``ready`` tells whether there are factors.
    """

    def __init__(self, pattern: SparsityPattern) -> None:
        self.pattern = pattern
        self.factorizations = 0
        self.solves = 0
        self._direct: Backend | None = None
        self._fallback: PivotedLU | None = None
        self._kept: Mask | None = None
        self._upper = np.zeros(0)
        self._start, self._rows = np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int32)
        self.ready = False

    def factorize(self, values: Array) -> None:
        """Factorize the symmetric matrix with these values in the pattern, shape (entries,).

        Raises
        ------
        numpy.linalg.LinAlgError
            If the matrix is singular or not finite.
        """
        self.factorize_upper(values[self.pattern.upper[0]])

    def factorize_upper(self, upper: Array) -> None:
        """Factorize the symmetric matrix with this upper triangle, shape (upper entries,); errors of `factorize`."""
        # The sum alone is finite unless an entry is not, or (hardly ever) it overflows.
        if not np.isfinite(upper.sum()) and not np.all(np.isfinite(upper)):
            raise np.linalg.LinAlgError("matrix has entries that are not finite")
        self.factorizations += 1
        self.ready, self._fallback, self._upper = False, None, upper
        kept = self._reduce(upper)
        assert self._direct is not None
        try:
            self._direct.factorize(kept)
            trusted = not self._direct.negative_pivots() or self._leaves_no_residual(upper)
        except np.linalg.LinAlgError:
            trusted = False
        if not trusted:
            self._fallback = PivotedLU(self.pattern.size, self._start, self._rows, {})
            self._fallback.factorize(kept)
        self.ready = True

    def memory(self) -> Memory:
        """Matrix that was factorized last, and the entries that are left out."""
        if not self.ready:
            return {}
        kept = np.zeros(0, dtype=np.int8) if self._kept is None else self._kept.astype(np.int8)
        return {"upper": self._upper.copy(), "kept": kept}

    def recall(self, memory: Memory) -> None:
        """Factorize the matrix of another one anew, in its pattern."""
        if memory:
            upper, kept = memory["upper"], memory["kept"].astype(bool)
            self._keep(kept if kept.size else np.ones(len(upper), dtype=bool))
            self.factorize_upper(upper.copy())

    def _reduce(self, upper: Array) -> Array:
        """Values without the entries that are left out; the pattern is widened if it must be."""
        _, start, rows = self.pattern.upper
        if self._direct is None:
            present = (upper != 0.0) | (rows == np.repeat(np.arange(self.pattern.size), np.diff(start)))
        elif self._kept is not None and np.any(upper[~self._kept]):
            self._direct, present = None, np.ones(len(upper), dtype=bool)
        if self._direct is None:
            self._keep(present)
        return upper if self._kept is None else upper[self._kept]

    def _keep(self, present: Mask) -> None:
        """Begin anew with these entries of the pattern."""
        _, start, rows = self.pattern.upper
        self._kept = None if present.all() else present
        before = np.concatenate([[0], np.cumsum(present)])
        self._start, self._rows = before[start].astype(np.int32), rows[present]
        kind = BACKENDS.get(_chosen.get(), _DEFAULT)
        self._direct = kind(self.pattern.size, self._start, self._rows, self._memo())

    def _memo(self) -> dict[str, Any]:
        """What is known about the part of the pattern that is used; kept for a few parts."""
        part = b"" if self._kept is None else blake2b(np.packbits(self._kept).data).digest()
        memo = self.pattern.memo
        if part not in memo and len(memo) >= _REMEMBERED:
            del memo[next(iter(memo))]
        return memo.setdefault(part, {})

    def _leaves_no_residual(self, upper: Array) -> bool:
        """Whether the factors of an indefinite matrix reproduce it: without pivoting their entries may grow."""
        assert self._direct is not None
        expected = np.random.default_rng(0).standard_normal(self.pattern.size)
        matrix = self.pattern.symmetric_matrix(upper[self.pattern.from_upper])
        right = matrix @ expected
        left = right - matrix @ self._direct.solve(right)
        return bool(np.linalg.norm(left) <= _TRUSTED * np.linalg.norm(right))

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        self.solves += 1
        return self._factors.solve(right)

    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the factorized matrix (Sylvester's law of inertia).

        Where pivoting had to take over they are not known; such a matrix is not positive definite, so one is given.
        """
        count = self._factors.negative_pivots()
        return 1 if count is None else count

    @property
    def parts(self) -> tuple[Any, ...] | None:
        """Factors as `substitute` reads them; None where there are none, or others."""
        return self._factors.parts if self.ready else None

    @property
    def fill(self) -> int:
        """Stored entries of the factors."""
        return self._factors.fill

    @property
    def _factors(self) -> Backend:
        backend = self._fallback or self._direct
        assert backend is not None, "factorize first"
        return backend
