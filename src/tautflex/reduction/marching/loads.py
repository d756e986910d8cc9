"""Forces in time on a reduced model."""

from __future__ import annotations

import numpy as np

from tautflex.errors import UnsupportedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.numeric import Array
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import FrameTerms


def require_forces(inputs: InputSet) -> None:
    """Raise UnsupportedError if an input changes stresses: the polynomial holds for one prestress."""
    if inputs.changes_stress():
        text = "inputs: expected forces on a reduced model, got a change of tension or temperature"
        raise UnsupportedError(f"{text}; simulate the full state")


class InputLoads:
    """Projects the forces of inputs, bound to the structure of a reduced model, on coordinates and monomials."""

    def __init__(self, rom: OnBasis, inputs: InputSet) -> None:
        self._inputs, self.breaks = inputs, inputs.breaks
        if not inputs:
            return
        require_forces(inputs)
        self._vectors, self._count = np.concatenate([rom.basis.kept, rom.monomial_vectors]), rom.size

    def full_load(self, time: float) -> Array | float:
        """Load on all unknowns at an instant [s], shape (size,)."""
        return self._inputs.load(time) if self._inputs else 0.0

    def added(self, frame: FrameTerms, times: Array, before: float) -> FrameTerms:
        """FrameTerms terms less the inputs at the given instants; a jump at ``before`` is not met yet."""
        if not self._inputs:
            return frame
        last = float(np.nextafter(before, -np.inf))
        loads = np.array([self._inputs.load(min(float(time), last)) for time in times]) @ self._vectors.T
        load, stress = loads[:, : self._count], loads[:, self._count :]
        return frame._replace(load=frame.load - load, stress=frame.stress - stress)
