"""Damping of a batch: the numbers of its matrix, and how parameters change them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tautflex.batch.library import jax
from tautflex.batch.parameters import each_row
from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping, LinearStructure
from tautflex.mechanics.dampings.matrix import DampingMatrix

PREFIX = "damping."
# The part of a `DampingMatrix` that is the same for all runs; its `weights` may differ.
VECTORS = "vectors"


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
        self.matrix = damping.of(structure)
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
            # Made again: the damping itself refuses numbers that are out of range.
            checked = replace(self._damping.with_numbers(row))  # type: ignore[type-var]
            matrices.append(checked.of(self._structure))
            if not np.array_equal(matrices[-1].vectors, self.matrix.vectors):
                names = ", ".join(sorted(name for name in arrays if name in self.defaults))
                raise UnsupportedError(
                    f"parameters: expected numbers that weigh the damping's vectors, got {names}, "
                    "which changes them; run simulate one by one"
                )
        if len(matrices) <= 1:
            return _numbers(matrices[0] if matrices else self.matrix), frozenset()
        numbers = [_numbers(matrix) for matrix in matrices]
        stacked = {PREFIX + name: np.stack([one[PREFIX + name] for one in numbers]) for name in self.matrix.weights}
        return {**numbers[0], **stacked}, frozenset(stacked)

    def of_traced(self, numbers: dict[str, Any], differ: frozenset[str]) -> tuple[dict[str, Any], frozenset[str]]:
        """All numbers with those of the matrix in place of the damping's own, which may be traced; and their rows."""
        own = {name: numbers[name] for name in numbers if name in self.defaults}
        rest = {name: value for name, value in numbers.items() if name not in own}
        rows = differ & frozenset(own)

        def weights(own: dict[str, Any]) -> dict[str, Any]:
            changed = self._damping.with_numbers({name.removeprefix(PREFIX): value for name, value in own.items()})
            found = changed.of(self._structure).weights
            return {PREFIX + name: jax.numpy.asarray(value, dtype=float) for name, value in found.items()}

        if rows:
            axes = {name: 0 if name in rows else None for name in own}
            return {**rest, **_numbers(self.matrix), **jax.vmap(weights, (axes,))(own)}, (differ - rows) | {
                PREFIX + name for name in self.matrix.weights
            }
        return {**rest, **_numbers(self.matrix), **weights(own)}, differ


def _numbers(matrix: DampingMatrix) -> dict[str, Any]:
    parts = matrix.weights | {VECTORS: matrix.vectors}
    return {PREFIX + name: np.asarray(value, dtype=float) for name, value in parts.items()}
