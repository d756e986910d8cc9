"""What compiled steps know from their size."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.store import ELASTIC, block_data
from tautflex.numeric import Array
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.implicit import Stepper


class Sized:
    """Stages of steps of one size, and what `take_steps` reads of them.

    Parameters
    ----------
    equation, stepper
        Those of the run.
    size
        Step [s].

    Attributes
    ----------
    numbers
        `StepNumbers` of every stage.
    parts
        Sizes of the stages [s], shape (stage,).
    weighed
        Whether steps weigh the forces of two instants.
    matrices, elements, scheme
        See `take_steps`.
    """

    def __init__(self, equation: EquationOfMotion, stepper: Stepper, size: float) -> None:
        self.size, count = size, len(stepper.method.stages(size))
        self.numbers = [stepper.numbers(size, place) for place in range(count)]
        self._reach = np.array([one.scheme.evaluation * (one.share * size) for one in self.numbers])
        self.parts = np.array([one.share * size for one in self.numbers])
        self.weighed = self.numbers[0].scheme.weight < 1.0
        products, workspace = equation.products, equation.workspace
        losses = [products.coefficients * (one.scheme.weight * one.scheme.velocity.d) for one in self.numbers]
        self.matrices: Any = (
            products.start, products.column, products.mass, products.damping, products.spread,
            np.array([one.linear for one in self.numbers]), equation.inertia.pairs, equation.state.reference_force,
            products.vectors, products.coefficients, np.array(losses),
        )  # fmt: skip
        self.elements: Any = workspace.store, workspace.stresses, workspace.held
        last = self.numbers[-1]
        # Of other laws than the elastic one energies cost more than forces: once per sample, not per evaluation.
        elastic = all(block_data.py_func(workspace.store, n).law == ELASTIC for n in range(len(workspace.store[3])))
        there = elastic and self._reach[-1] == self.parts[-1] and bool(np.array_equal(last.end[0], (1.0, 0.0, 0.0)))
        recalled = np.zeros((count, 2, count, 3))
        for place, one in enumerate(self.numbers):
            recalled[place, :, : one.recalled.shape[1]] = one.recalled
        turns = [(one.scheme.weight, one.turning_share, one.part) for one in self.numbers]
        sizes = np.array([(w, r, h, t, p) for (w, t, p), r, h in zip(turns, self._reach, self.parts, strict=True)])
        self.scheme: Any = (
            np.array([one.known for one in self.numbers]), np.array([one.end for one in self.numbers]), recalled,
            np.array([one.recalled.size > 0 for one in self.numbers]), sizes, there,
        )  # fmt: skip

    def instants(self, times: Array) -> Array:
        """Evaluation instant and end of every stage of steps between instants, one after the other, (stages, 2)."""
        found, begins = np.empty((len(times) - 1, len(self.parts), 2)), times[:-1]
        for place, (reach, part) in enumerate(zip(self._reach, self.parts, strict=True)):
            found[:, place, 0], found[:, place, 1] = begins + reach, begins + part
            begins = begins + part
        return found.reshape(-1, 2)

    def times(self, begin: float, count: int) -> Array:
        """Instants that steps from one instant on end at, as they sum them up, from that one, shape (count + 1,)."""
        sums: Array = np.cumsum(np.concatenate([[begin], np.tile(self.parts, count)]))[:: len(self.parts)]
        return sums
