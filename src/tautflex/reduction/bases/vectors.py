r"""Vectors of reduced models: what the structure may do [theory.md 10].

A basis has two parts. *Kept* vectors carry the unknowns ``eta``. *Static derivatives* are displacements that follow at
once, ``p = E y(eta)``, see :mod:`tautflex.reduction.bases.static_derivatives`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import brief


@dataclass(frozen=True)
class BasisVectors:
    """Vectors of a reduced model, as free unknowns of the structure.

    Parameters
    ----------
    kept
        Mass-normalised Ritz vectors, shape (r, size).
    derivatives
        Statically condensed vectors, stiffness-orthogonal to the kept ones, shape (p, size).
    amplitude
        Typical size of each coordinate, shape (r,): it weighs what may be left out.
    description
        One line for reports.
    fast
        Frequency from which on what is not kept answers at once [rad/s]; 0: four times that of the fastest coordinate
        that moves notably.
    """

    kept: Array
    derivatives: Array
    amplitude: Array
    description: str
    fast: float = 0.0
    __repr__ = brief


class Basis(ABC):
    """What finds the vectors of a reduced model."""

    @abstractmethod
    def vectors(self, state: PrestressedState) -> BasisVectors:
        """Find the vectors for a prestressed state."""


class ReferenceSolver:
    """Solutions with the tangent stiffness of the reference."""

    def __init__(self, state: PrestressedState) -> None:
        self._matrix = state.system.pattern.symmetric_matrix(state.tangent_entries)
        self._factor = SymmetricFactorization(state.system.pattern)
        try:
            self._factor.factorize(state.tangent_entries)
        except np.linalg.LinAlgError:
            raise InputError(
                "state: expected a structure held against rigid motion, got a singular stiffness"
            ) from None

    def solve(self, right: Array) -> Array:
        """Static response to one load, shape (size,)."""
        return self._factor.solve(right)

    def multiply(self, vectors: Array) -> Array:
        """Stiffness times each of the vectors (n, size)."""
        return (self._matrix @ vectors.T).T

    def energies(self, vectors: Array) -> Array:
        """Twice the strain energies; of mass-normalised vectors the squared frequencies [rad^2/s^2], shape (n,)."""
        return np.einsum("ri,ri->r", vectors, self.multiply(vectors))


def ritz(state: PrestressedState, vectors: Array) -> Array:
    """Mass-normalised Ritz vectors of a span, in order of frequency; dependent directions are dropped, (r, size)."""
    system = state.system
    mass, stiffness = system.inertia.mass_matrix, system.pattern.symmetric_matrix(state.tangent_entries)
    norms = np.sqrt(np.einsum("ri,ri->r", vectors, (mass @ vectors.T).T))
    unit = vectors / norms[:, None]
    values, turn = np.linalg.eigh(unit @ (mass @ unit.T))
    keep = values > 1e-10 * values[-1]
    orthonormal = (turn[:, keep] / np.sqrt(values[keep])).T @ unit
    _, turn = np.linalg.eigh(orthonormal @ (stiffness @ orthonormal.T))
    return turn.T @ orthonormal
