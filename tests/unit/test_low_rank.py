"""Solutions with a low-rank correction against dense ones."""

import numpy as np
import pytest

from tautflex.mechanics.pattern import SparsityPattern
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.low_rank import LowRankUpdate

SIZE, RANK = 60, 6


@pytest.fixture
def chain():
    """Factors of a chain of springs, and its dense matrix."""
    links = np.stack([np.arange(SIZE - 1), np.arange(1, SIZE)], axis=1)
    pattern = SparsityPattern.from_elements(SIZE, [links])
    values = np.where(pattern.rows == pattern.columns, 2.5, -1.0)
    factors = SymmetricFactorization(pattern)
    factors.factorize(values)
    return factors, pattern.matrix(values).toarray()


def _corrections():
    rng = np.random.default_rng(1)
    vectors = rng.standard_normal((RANK, SIZE))
    core = rng.standard_normal((RANK, RANK))
    singular = core.copy()
    singular[-1] = singular[0]
    return {
        "diagonal core": (vectors, rng.uniform(0.5, 2.0, RANK)),
        "full core": (vectors, core),
        "singular core": (vectors, singular),
        "nothing": (vectors[:0], np.zeros(0)),
    }


@pytest.mark.parametrize("name", list(_corrections()))
def test_solution_equals_the_dense_one(chain, name):
    factors, matrix = chain
    vectors, core = _corrections()[name]
    full = matrix + vectors.T @ (np.diag(core) if core.ndim == 1 else core) @ vectors
    update, expected = LowRankUpdate(factors), np.random.default_rng(2).standard_normal(SIZE)
    update.correct(vectors, core)
    found = update.solve(full @ expected)
    assert np.abs(found - expected).max() <= 1e-14 * np.linalg.cond(full) * np.abs(expected).max()


def test_a_second_correction_replaces_the_first(chain):
    factors, matrix = chain
    vectors, core = _corrections()["diagonal core"]
    update, right = LowRankUpdate(factors), np.ones(SIZE)
    update.correct(vectors, core)
    update.correct(vectors[:1], core[:1])
    assert update.solve(right) == pytest.approx(
        np.linalg.solve(matrix + core[0] * np.outer(vectors[0], vectors[0]), right), rel=1e-12
    )


def test_a_singular_correction_is_an_error(chain):
    factors, _ = chain
    pattern = factors.pattern
    factors.factorize(np.where(pattern.rows == pattern.columns, 1.0, 0.0))
    first = np.eye(1, SIZE)
    with pytest.raises(np.linalg.LinAlgError):
        LowRankUpdate(factors).correct(first, np.array([-1.0]))
