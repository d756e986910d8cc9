"""Arrays without owners: the same memory, whatever tuples they come in."""

import sys

import numpy as np

from tautflex.lending import lent
from tautflex.numeric import jit


@jit
def _scaled(parts, factor):
    (first, (second, number)), nothing = lent(parts)
    for i in range(first.size):
        first[i] = factor * second[i, 0]
    return first.sum() + number, nothing is None


def test_lent_arrays_are_the_same_memory_and_stay_with_their_owners():
    first, second = np.zeros(3), np.arange(6.0).reshape(3, 2)
    before = sys.getrefcount(first), sys.getrefcount(second)
    found = [_scaled(((first, (second, 5)), None), factor) for factor in (2.0, 3.0)]
    assert found == [(17.0, True), (23.0, True)]
    np.testing.assert_array_equal(first, [0.0, 6.0, 12.0])
    assert (sys.getrefcount(first), sys.getrefcount(second)) == before
