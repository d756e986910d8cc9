"""Lowest eigenpairs of a symmetric pencil by sparse shift-invert Lanczos."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from tautflex.errors import InputError, NotConvergedError
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization

# Shift-invert just below zero: K + shift M is definite for supported and for free structures alike [rad^2/s^2].
_SHIFT = (2.0 * np.pi * 0.02) ** 2
# Rigid motions of a free structure are 0 +- round-off; slower than this there is no vibration [rad^2/s^2].
_RIGID = (2.0 * np.pi * 1e-3) ** 2


def lowest_eigenpairs(pattern: SparsityPattern, stiffness: Array, mass: Array, n: int) -> tuple[Array, Array]:
    """The ``n`` lowest eigenpairs, 1 to size, of ``K phi = l M phi`` with a positive definite M.

    Matrices are values in a pattern, shape (entries,). Eigenvalues [rad^2/s^2] in rising order, shape (n,), and
    vectors, ``phi' M phi = 1``, shape (n, size). NotConvergedError if the eigensolver fails.
    """
    size, masses = pattern.size, pattern.symmetric_matrix(mass)
    if size <= 3 * n + 20:
        from scipy.linalg import eigh

        dense = eigh(pattern.matrix(stiffness).toarray(), masses.toarray())
        return dense[0][:n], dense[1][:, :n].T
    factor, shift = _factorize_below(pattern, stiffness, mass)
    inverse = LinearOperator((size, size), matvec=factor.solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(size)
    try:
        values, vectors = eigsh(pattern.matrix(stiffness), n, masses, sigma=-shift, OPinv=inverse, v0=start)
    except RuntimeError as error:
        raise NotConvergedError(f"modes: the eigensolver failed ({error}); ask for fewer modes") from error
    order = np.argsort(values)
    vectors = vectors[:, order]
    norms = np.sqrt(np.einsum("in,in->n", vectors, masses @ vectors))
    return values[order], (vectors / norms).T


def _factorize_below(pattern: SparsityPattern, stiffness: Array, mass: Array) -> tuple[SymmetricFactorization, float]:
    """Factors of K + shift M with the shift raised until no eigenvalue lies below it (unstable states have some)."""
    factor, shift = SymmetricFactorization(pattern), _SHIFT
    for _ in range(40):
        try:
            factor.factorize(stiffness + shift * mass)
            if factor.negative_pivots() == 0:
                return factor, shift
        except np.linalg.LinAlgError:
            pass
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
            self._known[n] = np.sqrt(np.where(values > _RIGID, values, 0.0)), vectors
        return self._known[n]
