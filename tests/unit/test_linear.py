"""Direct solvers: each backend against dense algebra, pivoting where it is needed, and what is shared."""

import sys

import numpy as np
import pytest
from scipy.sparse import csc_array, random_array

from tautflex import InputError, MissingExtraError, linear_solver
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.solvers.linear.factorization import BACKENDS, SymmetricFactorization
from tautflex.solvers.linear.ordering import order_and_fill
from tautflex.solvers.linear.pardiso import available

NAMES = [
    pytest.param(name, marks=pytest.mark.skipif(name == "pardiso" and not available(), reason="pypardiso is missing"))
    for name in BACKENDS
]


def grid_matrix(columns, rows, width, seed):
    """Random symmetric matrix on a grid of nodes with ``width`` unknowns each, coupled to their neighbours."""
    rng = np.random.default_rng(seed)
    number = np.arange(columns * rows).reshape(columns, rows)
    pairs = np.concatenate(
        [
            np.stack([number[1:].ravel(), number[:-1].ravel()]),
            np.stack([number[:, 1:].ravel(), number[:, :-1].ravel()]),
        ],
        axis=1,
    )
    matrix = np.zeros((columns * rows * width,) * 2)
    for a, b in pairs.T:
        block = rng.standard_normal((2 * width, 2 * width))
        places = np.concatenate([a * width + np.arange(width), b * width + np.arange(width)])
        matrix[np.ix_(places, places)] += block + block.T
    return matrix


def pattern_of(matrix):
    stored = csc_array(np.abs(matrix) + np.eye(len(matrix)))
    stored.sort_indices()
    return SparsityPattern(len(matrix), stored.indptr.astype(np.int32), stored.indices.astype(np.int32))


def values_of(pattern, matrix):
    return matrix[pattern.rows, pattern.columns]


def backend(name, matrix):
    """A backend with the upper triangle of a matrix factorized."""
    pattern = pattern_of(matrix)
    kept, start, rows = pattern.upper
    made = BACKENDS[name](pattern.size, start, rows, {})
    made.factorize(values_of(pattern, matrix)[kept])
    return made


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("columns", "rows", "width"), [(1, 2, 1), (5, 1, 2), (9, 7, 3), (20, 11, 1)])
def test_every_solver_solves_and_counts_as_dense_algebra_does(name, columns, rows, width):
    matrix = grid_matrix(columns, rows, width, seed=columns)
    # Definite, and indefinite but with dominant diagonal, so that no pivoting is needed.
    for diagonal in (np.ones(len(matrix)), np.where(np.arange(len(matrix)) % 3 == 0, -1.0, 1.0)):
        full = matrix + np.diag(diagonal * 2.0 * np.abs(matrix).sum(axis=1))
        factors = backend(name, full)
        right = np.random.default_rng(1).standard_normal(len(full))
        np.testing.assert_allclose(factors.solve(right), np.linalg.solve(full, right), rtol=1e-9, atol=1e-12)
        count = factors.negative_pivots()
        assert count is None or count == np.sum(np.linalg.eigvalsh(full) < 0.0)
        assert factors.fill >= len(full)


def test_panels_give_the_factors_of_qdldl():
    matrix = grid_matrix(13, 9, 3, seed=2)
    matrix += np.diag(2.0 * np.abs(matrix).sum(axis=1))
    panels, plain = backend("ldl", matrix), backend("qdldl", matrix)
    assert panels.fill == plain.fill
    right = np.arange(float(len(matrix)))
    np.testing.assert_allclose(panels.solve(right), plain.solve(right), rtol=1e-12, atol=1e-12 * right.max())


def test_order_is_a_permutation_and_the_pattern_holds_the_whole_factor():
    sparse = random_array((60, 60), density=0.05, rng=np.random.default_rng(3)).toarray()
    matrix = sparse + sparse.T + 10.0 * np.eye(60)
    pattern = pattern_of(matrix)
    order, start, rows = order_and_fill(60, *pattern.upper[1:])
    assert sorted(order) == list(range(60))
    lower = np.linalg.cholesky(matrix[np.ix_(order, order)])
    stored = np.eye(60, dtype=bool)
    for column in range(60):
        own = rows[start[column] : start[column + 1]]
        assert np.all(np.diff(own.astype(int)) > 0)
        stored[own, column] = True
    assert not np.any(lower[~stored])


@pytest.mark.parametrize("name", ["ldl", "qdldl"])
def test_zero_pivot_is_left_to_pivoting(name):
    # [[0, 1], [1, 0]] blocks: indefinite, well conditioned, without any L D L' in natural pivots.
    size = 30
    matrix = np.kron(np.eye(size), np.array([[0.0, 1.0], [1.0, 0.0]]))
    pattern = pattern_of(matrix)
    with linear_solver(name):
        factor = SymmetricFactorization(pattern)
        factor.factorize(values_of(pattern, matrix))
    right = np.arange(2.0 * size)
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(matrix, right))
    assert factor.negative_pivots() == 1  # not known, but not none
    definite = np.eye(2 * size) * 3.0 + matrix
    factor.factorize(values_of(pattern, definite))
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(definite, right))
    assert factor.negative_pivots() == 0


def test_growing_factors_are_left_to_pivoting():
    """Tiny pivots make entries of L huge; the residual of a solution gives it away."""
    matrix = grid_matrix(8, 6, 1, seed=4)
    np.fill_diagonal(matrix, 1e-10 * np.random.default_rng(0).standard_normal(48))
    pattern, right = pattern_of(matrix), np.arange(48.0)
    exact = np.linalg.solve(matrix, right)
    wrong = backend("ldl", matrix).solve(right)
    assert np.abs(wrong - exact).max() > 1e-6 * np.abs(exact).max()
    factor = SymmetricFactorization(pattern)
    factor.factorize(values_of(pattern, matrix))
    np.testing.assert_allclose(factor.solve(right), exact, rtol=1e-9)


def test_singular_and_not_finite_matrices_are_refused():
    pattern = pattern_of(np.ones((4, 4)))
    factor = SymmetricFactorization(pattern)
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        factor.factorize(np.ones(16))
    assert not factor.ready
    with pytest.raises(np.linalg.LinAlgError, match="finite"):
        factor.factorize(np.full(16, np.nan))
    factor.factorize(np.eye(4).ravel())
    assert factor.ready


def test_zeros_are_left_out_until_a_matrix_needs_them():
    coupled = grid_matrix(8, 6, 2, seed=5)
    coupled += np.diag(2.0 * np.abs(coupled).sum(axis=1))
    apart = coupled * (np.add.outer(np.arange(96), np.arange(96)) % 2 == 0)
    pattern, right = pattern_of(coupled), np.ones(96)
    factor = SymmetricFactorization(pattern)
    factor.factorize(values_of(pattern, apart))
    sparse = factor.fill
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(apart, right), rtol=1e-11)
    factor.factorize(values_of(pattern, coupled))
    assert factor.fill > 1.5 * sparse
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(coupled, right), rtol=1e-11)
    factor.factorize(values_of(pattern, apart))
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(apart, right), rtol=1e-11)


def test_order_is_found_once_for_all_that_share_a_pattern(monkeypatch):
    from tautflex.solvers.linear import ldl

    calls = []
    original = ldl.analyse
    monkeypatch.setattr(ldl, "analyse", lambda *arguments: calls.append(1) or original(*arguments))
    matrix = grid_matrix(5, 4, 1, seed=7)
    matrix += np.diag(2.0 * np.abs(matrix).sum(axis=1))
    pattern = pattern_of(matrix)
    for scale in (1.0, 2.0, 3.0):
        factor = SymmetricFactorization(pattern)
        factor.factorize(scale * values_of(pattern, matrix))
        np.testing.assert_allclose(scale * matrix @ factor.solve(np.ones(20)), np.ones(20))
    assert len(calls) == 1


def test_chosen_solver_is_used_inside_the_block_only(monkeypatch):
    pattern = pattern_of(np.eye(3))
    with pytest.raises(InputError, match="linear_solver"), linear_solver("cholesky"):
        pass
    monkeypatch.setitem(sys.modules, "pypardiso", None)
    with linear_solver("pardiso"):
        inside = SymmetricFactorization(pattern)
        with pytest.raises(MissingExtraError, match=r"pip install 'tautflex\[pardiso\]'"):
            inside.factorize(np.ones(3))
    outside = SymmetricFactorization(pattern)
    outside.factorize(2.0 * np.ones(3))
    np.testing.assert_allclose(outside.solve(np.ones(3)), 0.5)
