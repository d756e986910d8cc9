"""Where a reduced run begins: its steady equilibrium under a constant motion, and an offset from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh

from tautflex.errors import NotConvergedError
from tautflex.mechanics.inertia import LoadMoments
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array
from tautflex.reduction.marching.dispatch import tangent
from tautflex.reduction.marching.frame_terms import frame_at
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import derivative_forces, total_force
from tautflex.solvers.static.stability import growth_text, largest_translation

# Negative eigenvalues smaller than this part of the largest one are zero but for round-off.
_ROUND_OFF = 1e-12


@dataclass
class Beginning:
    """Start of a reduced model, without inputs.

    Parameters
    ----------
    rom, arrays
        Reduced model, and its compiled arrays.
    coupling, moments
        Terms of the moving frame, and those of the load of coordinates and monomials.
    motion
        The constant motion.
    """

    rom: OnBasis
    arrays: Any
    coupling: Coupling
    moments: LoadMoments
    motion: RigidMotion

    def __post_init__(self) -> None:
        self._frame = frame_at(self.coupling, self.moments, self.motion, self.rom.size)

    def equilibrium(self) -> Array:
        """Steady equilibrium of the coordinates, by Newton's method, shape (r,); NotConvergedError if there is none."""
        frame = self._frame
        q, v = np.zeros(self.rom.size), np.zeros(self.rom.size)
        if not (frame.load.any() or frame.turns):
            return q
        force = np.empty(self.rom.size)
        for _ in range(50):
            total_force(self.arrays, frame, 0, q, v, force)
            scale = max(float(np.linalg.norm(frame.load)), 1e-300)
            if float(np.linalg.norm(force)) <= 1e-9 * scale:
                return q
            q = q - np.linalg.solve(self._stiffness(q), force)
        raise NotConvergedError(
            "spinning equilibrium of the reduced model: Newton's method failed; reduce the angular rate or raise the "
            "pretension"
        )

    def _stiffness(self, q: Array) -> Array:
        """``K_tan(q) + K_T`` of the motion on the coordinates, shape (r, r)."""
        frame = self._frame
        stress, other = np.empty(frame.stress.shape[1]), np.empty(self.rom.size)
        derivative_forces(self.arrays, frame, 0, q, np.zeros(self.rom.size), stress, other)
        return tangent(self.arrays, q, stress) + np.einsum("ab,abij->ij", frame.displacement[0], self.arrays.turning)

    def imperfection(self, q: Array, size: float) -> tuple[Array, list[str]]:
        """Offset of a largest displacement [m] from the equilibrium, shape (r,), as `find_instability` gives it.

        And warnings of motion that grows out of the equilibrium.
        """
        stiffness, mass, said = self._stiffness(q), self.arrays.mass, list[str]()
        values, vectors = eigh(0.5 * (stiffness + stiffness.T), mass)
        shape, count = vectors[:, 0], int(np.sum(values < -_ROUND_OFF * np.abs(values).max()))
        if count:
            turning = np.einsum("ab,abij->ij", self._frame.velocity[0], self.arrays.turning)
            down = -np.linalg.solve(mass, np.hstack([stiffness, self.arrays.damping + turning]))
            roots, motions = np.linalg.eig(np.vstack([np.eye(len(q), 2 * len(q), len(q)), down]))
            fastest = int(roots.real.argmax())
            if roots[fastest].real > 1e-6 * np.sqrt(-values[0]):
                shape, rate = motions[: len(q), fastest].real, float(roots[fastest].real)
                grown = self.rom.displacement(shape)
                said.append(growth_text(self.rom.state, count, rate, grown, self.motion))
        largest = largest_translation(self.rom.state, self.rom.displacement(shape))
        return size / largest * shape if largest else np.zeros(len(q)), said
