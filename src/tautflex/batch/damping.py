"""Damping of a batch: the numbers of its matrix, and how parameters change them."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from tautflex.batch.library import jax
from tautflex.batch.parameters import each_row
from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping, LinearStructure
from tautflex.mechanics.dampings.matrix import DampingMatrix

PREFIX = "damping."
# Parts of a `DampingMatrix`; the first three may differ from run to run.
WEIGHTS, VECTORS = ("mass", "stiffness", "coefficients"), "vectors"


class BatchDamping:
    """Damping of the runs of a batch.

    Parameters
    ----------
    damping
        Of runs whose parameters do not change it.
    structure
        The state as it was given; the vectors of a damping (modes) stay those of this state, whatever else differs.
    """

    def __init__(self, damping: Damping, structure: LinearStructure) -> None:
        self._damping, self._structure = damping, structure
        self.matrix = damping.matrix(structure)
        self.defaults = {PREFIX + name: value for name, value in damping.numbers.items()}

    def of_rows(
        self, arrays: Mapping[str, Any], axes: Mapping[str, int | None], runs: int
    ) -> tuple[dict[str, Any], frozenset[str]]:
        """Numbers of the matrix for checked parameters, and which of them have one row per run.

        Raises
        ------
        InputError
            If a number is out of the damping's range.
        UnsupportedError
            If a number changes the vectors.
        """
        matrices = []
        for row in each_row(PREFIX, arrays, axes, runs):
            matrices.append(replace(self._damping, **row).matrix(self._structure))  # type: ignore[type-var]
            if not np.array_equal(matrices[-1].vectors, self.matrix.vectors):
                names = ", ".join(sorted(name for name in arrays if name in self.defaults))
                raise UnsupportedError(
                    f"parameters: expected numbers that weigh the damping's vectors, got {names}, "
                    "which changes them; run simulate one by one"
                )
        if len(matrices) <= 1:
            return _numbers(matrices[0] if matrices else self.matrix), frozenset()
        numbers = [_numbers(matrix) for matrix in matrices]
        stacked = {PREFIX + name: np.stack([one[PREFIX + name] for one in numbers]) for name in WEIGHTS}
        return {**numbers[0], **stacked}, frozenset(stacked)

    def of_traced(self, numbers: dict[str, Any], differ: frozenset[str]) -> tuple[dict[str, Any], frozenset[str]]:
        """All numbers with those of the matrix in place of the damping's own, which may be traced; and their rows."""
        own = {name: numbers[name] for name in numbers if name in self.defaults}
        rest = {name: value for name, value in numbers.items() if name not in own}
        rows = differ & frozenset(own)

        def weights(own: dict[str, Any]) -> dict[str, Any]:
            changed = copy(self._damping)
            for name, value in own.items():
                # Not `replace`: checks cannot look at a traced number.
                object.__setattr__(changed, name.removeprefix(PREFIX), value)
            matrix = changed.matrix(self._structure)
            return {PREFIX + name: jax.numpy.asarray(getattr(matrix, name), dtype=float) for name in WEIGHTS}

        if rows:
            axes = {name: 0 if name in rows else None for name in own}
            return {**rest, **_numbers(self.matrix), **jax.vmap(weights, (axes,))(own)}, (differ - rows) | {
                PREFIX + name for name in WEIGHTS
            }
        return {**rest, **_numbers(self.matrix), **weights(own)}, differ


def _numbers(matrix: DampingMatrix) -> dict[str, Any]:
    return {PREFIX + name: np.asarray(getattr(matrix, name), dtype=float) for name in (*WEIGHTS, VECTORS)}
