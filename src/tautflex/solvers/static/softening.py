"""The way from the elastic law to laws that give way instead of carrying compression."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tautflex.elements import ElementBlock

# Shares of the elastic law left in wrinkled and slack states.
_SHARES = 10.0 ** -np.arange(0.0, 13.0)


def softened(blocks: tuple[ElementBlock, ...]) -> Iterator[tuple[ElementBlock, ...]]:
    """Blocks whose compressive stiffness goes away in steps of ten; the last ones are the given.

    The solution with each is close to that of the next, while a direct attempt meets a nearly singular tangent, and
    film that pulls one way only is taut and wrinkled at once.
    """
    last = max(block.law.share for block in blocks)
    for share in _SHARES[last < _SHARES] if last > 0.0 else ():
        yield tuple(replace(block, law=block.law.with_share(share)) for block in blocks)
    yield blocks
