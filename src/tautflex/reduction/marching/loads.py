"""Forces in time on a reduced model."""

from __future__ import annotations

import numpy as np

from tautflex.errors import UnsupportedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.numeric import Array, Indices
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import FrameTerms


class InputLoads:
    """Projects the forces of inputs, bound to the structure of a reduced model, on coordinates and monomials.

    Raises UnsupportedError if an input changes stresses: the polynomial holds for one prestress.
    """

    def __init__(self, rom: OnBasis, inputs: InputSet) -> None:
        self._inputs, self.breaks = inputs, inputs.breaks
        if not inputs:
            return
        if inputs.changes_stress():
            raise UnsupportedError(
                "inputs: expected forces on a reduced model, got a change of tension or temperature; simulate the full "
                "state"
            )
        self._vectors, self._count = np.concatenate([rom.basis.kept, rom.monomial_vectors]), rom.size

    def full_load(self, time: float) -> Array | float:
        """Load on all unknowns at an instant [s], shape (size,)."""
        return self._inputs.load(time) if self._inputs else 0.0

    def added(self, frame: FrameTerms, times: Array, before: float) -> FrameTerms:
        """FrameTerms terms less the inputs at the given instants; a jump at ``before`` is not met yet."""
        if not self._inputs:
            return frame
        load, stress = self._projected(times, before)
        return frame._replace(load=frame.load - load, stress=frame.stress - stress)

    def __bool__(self) -> bool:
        return bool(self._inputs)

    def on_coordinates(self, times: Array, before: float, places: Array, pairs: tuple[Indices, Indices]) -> Array:
        """Forces of the inputs on the left-hand side at instants and coordinates there, shape (time, r).

        ``pairs`` are the indices of the monomials' coordinates.
        """
        load, stress = self._projected(times, before)
        result, (first, second) = -load.T, pairs
        np.subtract.at(result, first, (stress * places[:, second]).T)
        np.subtract.at(result, second, (stress * places[:, first]).T)
        return result.T

    def _projected(self, times: Array, before: float) -> tuple[Array, Array]:
        """Forces on coordinates and monomials at instants; a jump at ``before`` is not met yet."""
        last = float(np.nextafter(before, -np.inf))
        loads = np.array([self._inputs.load(min(float(time), last)) for time in times]) @ self._vectors.T
        return loads[:, : self._count], loads[:, self._count :]
