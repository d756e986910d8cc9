"""Lowest eigenpairs of a symmetric pencil by sparse shift-invert Lanczos."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from tautflex.errors import InputError, NotConvergedError
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization, linear_solver
from tautflex.solvers.linear.low_rank import LowRankUpdate


def resolution(pattern: SparsityPattern, stiffness: Array, mass: Array) -> float:
    """Eigenvalues nearer to zero than this are zero but for round-off [rad^2/s^2], as those of rigid motions are.

    A few units in the last place of the largest eigenvalue, which the diagonals tell roughly.
    """
    diagonal = pattern.diagonal
    return 4.0 * float(np.finfo(float).eps * np.max(np.abs(stiffness[diagonal]) / mass[diagonal]))


def below_zero(pattern: SparsityPattern, stiffness: Array, mass: Array) -> float:
    """Shift s [rad^2/s^2] just beyond the round-off of rigid motions: K + s M is definite for free structures too."""
    return 256.0 * resolution(pattern, stiffness, mass)


def count_below(pattern: SparsityPattern, stiffness: Array, mass: Array, eigenvalue: float) -> int:
    """Number of eigenvalues of (K, M) below a value [rad^2/s^2] (Sylvester's law of inertia)."""
    return _counted(pattern, stiffness - eigenvalue * mass)[1]


def _counted(pattern: SparsityPattern, values: Array) -> tuple[SymmetricFactorization, int]:
    """Factors that tell the number of negative eigenvalues, whatever solver was asked for, and that number."""
    factor = SymmetricFactorization(pattern)
    with linear_solver("auto"):
        try:
            factor.factorize(values)
        except np.linalg.LinAlgError:
            return factor, 1
    return factor, factor.negative_pivots()


def lowest_eigenpairs(
    pattern: SparsityPattern, stiffness: Array, mass: Array, n: int, carried: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """The ``n`` lowest eigenpairs, 1 to size, of ``K phi = l M phi`` with a positive definite M.

    Matrices are values in a pattern, shape (entries,). Of M the product ``L' A L`` is taken away where the rows L,
    shape (r, size), and the matrix A, shape (r, r), are given: what a base that gives way spares. Eigenvalues
    [rad^2/s^2] in rising order, shape (n,), and vectors, ``phi' M phi = 1``, shape (n, size). NotConvergedError if the
    eigensolver fails.
    """
    size, own = pattern.size, pattern.symmetric_matrix(mass)
    rows, core = (np.zeros((0, size)), np.zeros((0, 0))) if carried is None else carried
    if size <= 3 * n + 20:
        from scipy.linalg import eigh

        dense = eigh(pattern.matrix(stiffness).toarray(), own.toarray() - rows.T @ core @ rows)
        return dense[0][:n], dense[1][:, :n].T
    factor, shift = _factorize_below(pattern, stiffness, mass)
    update = LowRankUpdate(factor)
    update.correct(rows, -shift * core)
    inverse = LinearOperator((size, size), matvec=update.solve, dtype=float)
    masses: Any = own
    if len(rows):
        masses = LinearOperator((size, size), matvec=lambda x: own @ x - rows.T @ (core @ (rows @ x)), dtype=float)
    start = np.random.default_rng(0).standard_normal(size)
    try:
        values, vectors = eigsh(pattern.matrix(stiffness), n, masses, sigma=-shift, OPinv=inverse, v0=start)
    except RuntimeError as error:
        raise NotConvergedError(f"modes: the eigensolver failed ({error}); ask for fewer modes") from error
    order = np.argsort(values)
    vectors = vectors[:, order]
    spared = rows @ vectors
    norms = np.sqrt(np.einsum("in,in->n", vectors, own @ vectors) - np.einsum("rn,rn->n", spared, core @ spared))
    return values[order], (vectors / norms).T


def _factorize_below(pattern: SparsityPattern, stiffness: Array, mass: Array) -> tuple[SymmetricFactorization, float]:
    """Factors of K + shift M with the shift raised until no eigenvalue lies below it (unstable states have some)."""
    shift = below_zero(pattern, stiffness, mass)
    for _ in range(60):
        factor, negative = _counted(pattern, stiffness + shift * mass)
        if not negative:
            return factor, shift
        shift *= 4.0
    raise NotConvergedError("modes: no shift makes the stiffness definite; check the mass and the prestress")


@dataclass(frozen=True)
class NaturalModes:
    """Natural modes of one state as dampings ask for them; found once, then remembered."""

    pattern: SparsityPattern
    stiffness: Array
    mass: Array
    _known: dict[int, tuple[Array, Array]] = field(default_factory=dict, repr=False)

    def __call__(self, n: int) -> tuple[Array, Array]:
        """Angular frequencies [rad/s], 0 where nothing vibrates, shape (n,), and vectors, shape (n, size).

        Raises
        ------
        InputError
            If the structure has fewer modes.
        NotConvergedError
            If the eigensolver fails.
        """
        if not 1 <= n <= self.pattern.size:
            raise InputError(f"modes: expected 1 to {self.pattern.size} modes, got {n}; refine the mesh for more")
        if n not in self._known:
            values, vectors = lowest_eigenpairs(self.pattern, self.stiffness, self.mass, n)
            still = resolution(self.pattern, self.stiffness, self.mass)
            self._known[n] = np.sqrt(np.where(values > still, values, 0.0)), vectors
        return self._known[n]
