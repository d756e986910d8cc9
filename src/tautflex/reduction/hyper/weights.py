r"""Element weights of hyper-reduction: energy-conserving sampling and weighting (ECSW).

A few elements with weights ``xi_e >= 0`` stand for all: the reduced force ``sum V_e' f_e(V eta)`` is a sum over
elements like an integral over points, and ``sum xi_e V_e' f_e(V eta)`` its quadrature. Weights reproduce the forces of
training snapshots in the sense of non-negative least squares, whose solutions have few non-zeros. Because they multiply
element energies, the reduced force stays the gradient of an energy, convex where the elements' are
[Farhat, Avery, Chapman & Cortial, Int. J. Numer. Meth. Engng 98 (2014) 625].
What is weighed is a row of a block, an integration point: the whole element where it has one, and each point of its own
where it has several. A row is what costs time and what has an energy, so that points that are not needed are left out
and stability stays; that an element's rule integrates its rigid motions exactly plays no part on a basis.
Own least squares, because scipy's nnls cannot stop at an error: it goes on to ever more elements.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from tautflex.elements.block import ElementBlock
from tautflex.mechanics.kernel import add_forces
from tautflex.numeric import Array
from tautflex.reduction.hyper.blocks import blocks_store


@dataclass(frozen=True)
class ElementWeights:
    """Trained weights.

    Parameters
    ----------
    values
        Weight of every row (integration point), block after block, >= 0, shape (row,).
    residual
        Error of the training forces relative to their norm.
    """

    values: Array
    residual: float

    @property
    def chosen(self) -> int:
        """Number of rows with a weight."""
        return int(np.count_nonzero(self.values))


def element_forces(blocks: list[ElementBlock], states: Array) -> Array:
    """Forces ``V_e' (f_e(V eta) - f_e(0))`` of every row at states (n, r), shape (n, row, r)."""
    store = blocks_store(blocks, apart=True)
    count, r = sum(len(block.measure) for block in blocks), states.shape[1]
    stresses = np.empty(sum(block.initial_stress.size for block in blocks))

    def forces(eta: Array) -> Array:
        result = np.zeros(count * r + 1)
        add_forces(store, np.append(np.tile(eta, count), 0.0), result, stresses, True, False, False)
        return result[:-1].reshape(count, r)

    rest = forces(np.zeros(r))
    return np.array([forces(eta) - rest for eta in states])


def stress_forces(blocks: list[ElementBlock], states: Array, columns: Mapping[int, Array]) -> Iterator[Array]:
    """What each of n stresses, by block (row, strain, n), adds to forces of rows at states, shapes (state, row, r)."""
    plain = element_forces(blocks, states)
    for k in range(next(iter(columns.values())).shape[2] if columns else 0):
        changed = [
            replace(block, initial_stress=block.initial_stress + columns[number][..., k])
            if number in columns
            else block
            for number, block in enumerate(blocks)
        ]
        yield element_forces(changed, states) - plain


def train_weights(forces: Array, scale: Array, tolerance: float) -> ElementWeights:
    """Few non-negative weights that reproduce sums of element forces in training states, shape (n, row, r).

    ``scale`` is the natural frequency of each coordinate [rad/s], shape (r,): forces over it are measured by the root
    of the strain energy of the motion that they cause. No more elements are added at the relative error ``tolerance``.
    """
    count = forces.shape[1]
    rows = (forces / scale).transpose(0, 2, 1)
    # Every state counts alike, so that small motions are as right as large ones.
    size = np.linalg.norm(rows.sum(axis=2), axis=1)
    rows = (rows / np.maximum(size, 1e-9 * size.max())[:, None, None]).reshape(-1, count)
    target = rows.sum(axis=1)
    compressed, goal = _compress(rows, target, 0.1 * tolerance)
    values = _sparse_weights(compressed, goal, tolerance * float(np.linalg.norm(target)))
    return ElementWeights(values, float(np.linalg.norm(rows @ values - target) / np.linalg.norm(target)))


def _compress(rows: Array, target: Array, tolerance: float) -> tuple[Array, Array]:
    """Fewer rows with the same least-squares problem up to a tolerance, by the smaller of the two Gram matrices."""
    if rows.shape[0] <= rows.shape[1]:
        values, vectors = np.linalg.eigh(rows @ rows.T)
        keep = values > (1e-8 + tolerance / len(rows)) ** 2 * values[-1]
        left = vectors[:, keep].T
        return left @ rows, left @ target
    values, vectors = np.linalg.eigh(rows.T @ rows)
    keep = values > (1e-8 + tolerance / len(values)) ** 2 * values[-1]
    left = np.sqrt(values[keep])[:, None] * vectors[:, keep].T
    return left, left.sum(axis=1)


def _sparse_weights(matrix: Array, target: Array, error: float) -> Array:
    """Active-set non-negative least squares, stopped at an error [Lawson & Hanson, Solving Least Squares Problems, 23].

    Elements enter by their correlation with what is missing.
    """
    norms = np.linalg.norm(matrix, axis=0)
    usable = norms > 1e-12 * norms.max()
    gram, right = matrix.T @ matrix, matrix.T @ target
    x, active = np.zeros(matrix.shape[1]), np.zeros(matrix.shape[1], dtype=bool)
    while True:
        missing = target - matrix[:, active] @ x[active]
        if np.linalg.norm(missing) <= error or active.sum() >= min(usable.sum(), matrix.shape[0]):
            return x
        gain = np.where(usable & ~active, matrix.T @ missing / np.maximum(norms, 1e-300), -np.inf)
        best = int(np.argmax(gain))
        if gain[best] <= 1e-12 * np.linalg.norm(target):
            return x
        active[best] = True
        while True:
            places = np.flatnonzero(active)
            part = gram[np.ix_(places, places)]
            ridge = 1e-14 * np.trace(part) * np.eye(len(places))
            trial = cho_solve(cho_factor(part + ridge), right[places])
            if np.all(trial > 0.0):
                x[:] = 0.0
                x[places] = trial
                break
            old = x[places]
            fall = trial <= 0.0
            step = float(np.min(old[fall] / np.maximum(old[fall] - trial[fall], 1e-300)))
            x[places] = old + step * (trial - old)
            x[x <= 1e-14 * x.max(initial=0.0)] = 0.0
            # What was just taken in may leave at once only if round-off made it seem useful.
            active &= x > 0.0
            if not active.any():
                return x
