r"""Lowest eigenvalues of ``lambda^2 M + lambda (C + G) + K`` with M, C, K symmetric and G skew.

The companion pencil of twice the size is never formed. With a real shift s its inverse needs one sparse
factorization of the real matrix ``Q(s) = s^2 M + s (C + G) + K`` [Tisseur & Meerbergen 2001, SIAM Review 43, sec. 5]:

    (a, b) -> (x, a + s x),   Q(s) x = -(M (b + s a) + (C + G) a),   eigenvalues 1/(lambda - s),

and Arnoldi's method finds the largest of these. The spectrum of an undamped gyroscopic system is symmetric about
both axes. Arnoldi does not know that, the Rayleigh functional does: the root of ``m l^2 + (c + i g) l + k`` with the
Hermitian forms of the found shape is exactly imaginary where the motion is stable, and its error is the square of
the shape's [Duffin 1955, J. Rational Mech. Anal. 4].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import ArpackError, LinearOperator, SuperLU, eigs, splu

from tautflex.errors import NotConvergedError
from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array, Complex
from tautflex.solvers.linear.low_rank import LowRankUpdate

_SPARE = 6  # eigenvalues asked for beyond the wanted pairs, so that none is cut in two
_ROUNDOFF = 8.0 * np.finfo(float).eps


@dataclass(frozen=True)
class QuadraticPencil:
    """Matrices of a damped gyroscopic system by their values in one pattern, shapes (entries,).

    Mass, damping and stiffness are symmetric, the mass positive definite, ``gyroscopic`` is skew; ``beside`` has
    vectors that are added to the damping in the pattern.
    """

    pattern: SparsityPattern
    mass: Array
    damping: Array
    gyroscopic: Array
    stiffness: Array
    beside: DampingMatrix = field(default_factory=DampingMatrix)

    @property
    def undamped(self) -> bool:
        """Whether there is no damping at all."""
        return not (self.damping.any() or self.beside.coefficients.any())

    @cached_property
    def matrices(self) -> tuple[csr_array, csr_array, csr_array]:
        """M, C + G without the vectors beside it, and K in compressed rows."""
        pattern = self.pattern
        velocity = self.damping + self.gyroscopic
        return (
            pattern.symmetric_matrix(self.mass),
            csr_array(pattern.matrix(velocity)),
            pattern.symmetric_matrix(self.stiffness),
        )

    def velocity_product(self, vectors: Any) -> Any:
        """``(C + G) vectors``, shape (size,) or (size, columns)."""
        result = self.matrices[1] @ vectors
        return result + self.beside.low_rank_force(vectors) if self.beside.rank else result


def quadratic_forms(matrix: Any, vectors: Complex) -> Complex:
    """``phi^H A phi`` of each row phi, shape (mode,)."""
    return np.sum(vectors.conj() * (matrix @ vectors.T).T, axis=1)


def lowest_eigenpairs(pencil: QuadraticPencil, n: int, shift: float) -> tuple[Complex, Complex]:
    """The ``n`` eigenvalues of smallest modulus, one of each conjugate pair, and their vectors.

    Eigenvalues come in order of modulus, imaginary part >= 0 [rad/s], shape (n,): of the real pairs of an undamped
    system the growing one, of a double zero one; real eigenvalues of a damped system one by one. Vectors have ``phi^H M
    phi = 1``, shape (n, size). ``shift`` [1/s] is real, > 0 and not much larger than the wanted eigenvalues.
    NotConvergedError if the factorization or Arnoldi's method fails.
    """
    raw, vectors = _nearest_to_shift(pencil, n, shift)
    values, noise = _rayleigh_functional(pencil, raw, vectors)
    oscillating = values.imag > noise
    still = np.abs(values.imag) <= noise
    if pencil.undamped:
        zeros = np.flatnonzero(still & (np.abs(values.real) <= noise))
        values[zeros] = 0.0
        still &= values.real > noise
        still[zeros[: (len(zeros) + 1) // 2]] = True
    kept = np.flatnonzero(oscillating | still)
    if len(kept) < n:
        raise NotConvergedError(f"spinning modes: only {len(kept)} of {n} were found; ask for fewer")
    kept = kept[np.argsort(np.abs(values[kept]), kind="stable")[:n]]
    return values[kept], vectors[kept]


def fastest_growing(pencil: QuadraticPencil, shift: float) -> tuple[complex, Array]:
    """Eigenvalue of largest real part near a real shift [1/s] beyond it, and its vector, shape (size,)."""
    raw, vectors = _nearest_to_shift(pencil, 1, shift)
    values, _ = _rayleigh_functional(pencil, raw, vectors)
    found = int(np.argmax(values.real))
    return complex(values[found]), vectors[found]


def _nearest_to_shift(pencil: QuadraticPencil, n: int, shift: float) -> tuple[Complex, Complex]:
    size = pencil.pattern.size
    inverse = _shifted_inverse(pencil, shift)
    if size <= 3 * n + 20:
        inverted, states = np.linalg.eig(inverse @ np.eye(2 * size))
    else:
        start = np.random.default_rng(0).standard_normal(2 * size)
        try:
            inverted, states = eigs(inverse, 2 * n + _SPARE, v0=start, which="LM")
        except ArpackError as error:
            raise NotConvergedError(f"spinning modes: the eigensolver failed ({error}); ask for fewer modes") from error
    vectors: Complex = states[:size].T.astype(np.complex128)
    norms = np.sqrt(quadratic_forms(pencil.matrices[0], vectors).real)
    values = np.asarray(shift + 1.0 / inverted, dtype=np.complex128)
    return values, np.asarray(vectors / norms[:, None], dtype=np.complex128)


def _shifted_inverse(pencil: QuadraticPencil, shift: float) -> LinearOperator:
    """Inverse of the companion pencil at a real shift, on (q, velocity / scale) with both halves alike in size."""
    mass = pencil.matrices[0]
    values = shift * shift * pencil.mass + shift * (pencil.damping + pencil.gyroscopic) + pencil.stiffness
    factor, size = LowRankUpdate(_factorize(pencil.pattern, values)), pencil.pattern.size
    if pencil.beside.rank:
        factor.correct(pencil.beside.vectors, shift * pencil.beside.coefficients)
    scale = _lowest_scale(pencil, factor, shift)

    def solve(right: Array) -> Array:
        a, b = right[:size], scale * right[size:]
        x = -factor.solve(mass @ (b + shift * a) + pencil.velocity_product(a))
        return np.concatenate([x, (a + shift * x) / scale])

    return LinearOperator((2 * size, 2 * size), matvec=solve, matmat=solve, dtype=float)


def _lowest_scale(pencil: QuadraticPencil, factor: LowRankUpdate, shift: float) -> float:
    """Rough size of the lowest eigenvalues [rad/s] by inverse iteration, at least the shift.

    Halves of unequal size would cost the shapes their ratio in digits.
    """
    mass, _, stiffness = pencil.matrices
    x = np.random.default_rng(1).standard_normal(pencil.pattern.size)
    for _ in range(3):
        x = factor.solve(mass @ x)
        x /= np.sqrt(x @ (mass @ x))
    return max(shift, float(np.sqrt(abs(x @ (stiffness @ x)))))


def _factorize(pattern: SparsityPattern, values: Array) -> SuperLU:
    # The pattern is symmetric and the matrix nearly so: diagonal pivots where they serve keep the factors sparse.
    try:
        return splu(
            pattern.matrix(values),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.01,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise NotConvergedError(
            f"spinning modes: the dynamic stiffness is singular ({error}); check supports and prestress"
        ) from error


def _rayleigh_functional(pencil: QuadraticPencil, raw: Complex, vectors: Complex) -> tuple[Complex, Array]:
    """Root of ``l^2 + (c + i g) l + k`` nearest to each raw value, and its resolution [rad/s] near a double root.

    ``k`` is a small difference of large numbers where stiff directions are at rest; its round-off limits how well a
    double root (zero, or the onset of instability) can be told from a pair.
    """
    stiffness = pencil.matrices[2]
    both = np.sum(vectors.conj() * pencil.velocity_product(vectors.T).T, axis=1)
    c, g = (np.zeros_like(both.real) if pencil.undamped else both.real), both.imag
    k = quadratic_forms(stiffness, vectors).real
    noise = np.sqrt(_ROUNDOFF * quadratic_forms(abs(stiffness), np.abs(vectors).astype(complex)).real)
    middle = -0.5 * (c + 1j * g)
    half = np.sqrt(middle**2 - k)
    if pencil.undamped:
        # Growth, or a split of frequencies, within round-off of a double root is none.
        half = np.where(np.abs(half) <= noise, 0.0, half)
    roots = np.stack([middle + half, middle - half])
    nearest = np.abs(roots - raw).argmin(axis=0)
    return roots[nearest, np.arange(len(raw))], noise
