r"""Exact polynomial of the internal force on a basis, from the element data [theory.md 10].

With ``q = V eta`` an element's strains are ``eps = A eta + B y / 2``: ``A = L G V``, columns of ``B`` are the packed
coefficients of ``g Q g``, and ``y`` are the monomials ``eta_i eta_j`` (i <= j). Its energy

    U = V_e (s0 . eps + eps D eps / 2) = V_e [ s0 A eta + (s0 B y + eta A'DA eta) / 2 + eta A'DB y / 2 + y B'DB y / 8 ]

is a polynomial of degree four. Its first two degrees are the tangent of the reference; the others, which depend on no
prestress, are collected here once, kind by kind of element, because they are proportional to its elastic matrix.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.reduction.polynomial.monomials import packed, pairs

_CHUNK_NUMBERS = 4_000_000  # doubles in the largest temporary of one chunk of elements


@dataclass(frozen=True)
class HigherDegrees:
    """Second- and third-degree forces that are proportional to the elastic matrices of one kind of element.

    Parameters
    ----------
    quadratic
        Force on each coordinate per monomial, shape (P, m): the second-degree part of the internal force.
    cubic
        ``B'DB`` summed over elements, shape (m, m); its energy is ``y cubic y / 8``.
    """

    quadratic: Array
    cubic: Array


@dataclass(frozen=True)
class _Chunk:
    """Some elements of a block on a basis; the element is the first axis."""

    index: int
    part: slice
    places: Indices
    gradient: Array
    linear: Array
    slope: Array
    quadratic: Array

    def full_forces(self, elastic_quadratic: Array, elastic_linear: Array, strain_of_gradient: Array) -> Array:
        """Second-degree element forces per monomial, shape (element, dof, m)."""
        conjugate = 0.5 * np.einsum("sg,esm->egm", strain_of_gradient, elastic_quadratic)
        conjugate += packed(np.einsum("esgi,esj->egij", self.slope, elastic_linear))
        return np.einsum("egd,egm->edm", self.gradient, conjugate)


def _chunks(system: StructuralSystem, vectors: Array) -> Iterator[_Chunk]:
    """Strains of all elements on the basis, in parts that fit in memory."""
    extended = np.concatenate([vectors, np.zeros((len(vectors), 1))], axis=1)
    for index, (block, places) in enumerate(zip(system.blocks, system.row_places, strict=True)):
        strains, gradients = block.linear.shape
        each = strains * max(len(vectors) ** 2, gradients * len(vectors))
        step = max(1, _CHUNK_NUMBERS // each)
        for start in range(0, len(places), step):
            part = slice(start, start + step)
            local = extended[:, places[part]].transpose(1, 2, 0)
            gamma = np.matmul(block.gradient[part], local)
            slope = np.einsum("sgh,ehr->esgr", block.quadratic, gamma)
            products = np.einsum("egi,esgj->esij", gamma, slope)
            linear = np.einsum("sg,egr->esr", block.linear, gamma)
            yield _Chunk(index, part, places[part], block.gradient[part], linear, slope, packed(products))


def higher_degrees(system: StructuralSystem, vectors: Array, forces_on: Array) -> dict[str, HigherDegrees]:
    """Second- and third-degree forces of every kind of element for the coordinates of a basis (R, size).

    Second-degree forces are projected on the vectors ``forces_on`` (P, size).
    """
    found: dict[str, HigherDegrees] = {}
    for chunk in _chunks(system, vectors):
        block = system.blocks[chunk.index]
        weighed = block.measure[chunk.part, None, None] * block.elasticity[chunk.part]
        elastic_linear, elastic_quadratic = weighed @ chunk.linear, weighed @ chunk.quadratic
        forces = chunk.full_forces(elastic_quadratic, elastic_linear, block.linear)
        count = chunk.quadratic.shape[-1]
        flat = chunk.quadratic.reshape(-1, count)
        quadratic = forces_on @ _scatter(forces, chunk.places, system.size)
        cubic = flat.T @ elastic_quadratic.reshape(-1, count)
        known = found.get(block.kind)
        if known is not None:
            quadratic, cubic = known.quadratic + quadratic, known.cubic + cubic
        found[block.kind] = HigherDegrees(quadratic, cubic)
    return found


def quadratic_forces(system: StructuralSystem, vectors: Array) -> Array:
    """Second-degree internal force per monomial of the basis' coordinates on all unknowns, shape (m, size).

    ``f(V eta) = f(0) + K V eta + y(eta) @ result + third degree``.
    """
    total = np.zeros((system.size, len(pairs(len(vectors))[0])))
    for chunk in _chunks(system, vectors):
        block = system.blocks[chunk.index]
        weighed = block.measure[chunk.part, None, None] * block.elasticity[chunk.part]
        forces = chunk.full_forces(weighed @ chunk.quadratic, weighed @ chunk.linear, block.linear)
        total += _scatter(forces, chunk.places, system.size)
    return total.T


def _scatter(forces: Array, places: Indices, size: int) -> Array:
    """Sum element forces (element, dof, m) on the free unknowns, shape (size, m)."""
    flat = places.ravel()
    selection = csr_array((np.ones(flat.size), (flat, np.arange(flat.size))), shape=(size + 1, flat.size))
    return np.asarray(selection @ forces.reshape(flat.size, -1))[:-1]
