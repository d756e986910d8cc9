r"""Exact polynomial of the internal force on a basis, from the element data [theory.md 10].

With ``q = V eta`` an element's strains are ``eps = A eta + B y / 2``: ``A = L G V``, columns of ``B`` are the packed
coefficients of ``g Q g``, and ``y`` are the monomials ``eta_i eta_j`` (i <= j). Its energy

    U = V_e (s0 . eps + eps D eps / 2) = V_e [ s0 A eta + (s0 B y + eta A'DA eta) / 2 + eta A'DB y / 2 + y B'DB y / 8 ]

is a polynomial of degree four. Its first two degrees are the tangent of the reference; the others, which depend on no
prestress, are collected here once, kind by kind of element, because they are proportional to its elastic matrix.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.reduction.polynomial.monomials import packed

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


class _Part(NamedTuple):
    """Rows of a block: gradients of the vectors, their slopes ``Q g``, and rows of B, shape (row, strain, m)."""

    number: int
    rows: slice
    gradient: Array
    slope: Array
    quadratic: Array


def _parts(system: StructuralSystem, vectors: Array, blocks: Iterable[int]) -> Iterator[_Part]:
    """Quadratic strains of some blocks on the basis, in parts that fit in memory."""
    extended = np.concatenate([vectors, np.zeros((len(vectors), 1))], axis=1)
    for number in blocks:
        block, places = system.blocks[number], system.row_places[number]
        strains, gradients = block.linear.shape
        each = strains * max(len(vectors) ** 2, gradients * len(vectors))
        step = max(1, _CHUNK_NUMBERS // each)
        for start in range(0, len(places), step):
            rows = slice(start, start + step)
            gamma = np.matmul(block.gradient[rows], extended[:, places[rows]].transpose(1, 2, 0))
            slope = np.einsum("sgh,ehr->esgr", block.quadratic, gamma)
            yield _Part(number, rows, gamma, slope, packed(np.einsum("egi,esgj->esij", gamma, slope)))


def _chunks(system: StructuralSystem, vectors: Array) -> Iterator[tuple[str, Array, Array, Array]]:
    """Forces of all elements on the basis, in parts that fit in memory.

    Yields the kind of the elements, their second-degree force on the unknowns per monomial, shape (size, m), and rows
    of B and of DB, weighed with the measure, shapes (row, m).
    """
    for number, rows, gamma, slope, quadratic in _parts(system, vectors, range(len(system.blocks))):
        block = system.blocks[number]
        weighed = block.measure[rows, None, None] * block.elasticity[rows]
        elastic = weighed @ quadratic
        conjugate = 0.5 * np.einsum("sg,esm->egm", block.linear, elastic)
        linear = weighed @ np.einsum("sg,egr->esr", block.linear, gamma)
        conjugate += packed(np.einsum("esgi,esj->egij", slope, linear))
        forces = np.einsum("egd,egm->edm", block.gradient[rows], conjugate)
        flat, count = system.row_places[number][rows].ravel(), quadratic.shape[-1]
        selection = csr_array((np.ones(flat.size), (flat, np.arange(flat.size))), shape=(system.size + 1, flat.size))
        summed = np.asarray(selection @ forces.reshape(flat.size, -1))[:-1]
        yield block.kind, summed, quadratic.reshape(-1, count), elastic.reshape(-1, count)


def higher_degrees(system: StructuralSystem, vectors: Array, forces_on: Array) -> dict[str, HigherDegrees]:
    """Second- and third-degree forces of every kind of element for the coordinates of a basis (R, size).

    Second-degree forces are projected on the vectors ``forces_on`` (P, size).
    """
    found: dict[str, HigherDegrees] = {}
    for kind, forces, strains, stresses in _chunks(system, vectors):
        quadratic, cubic = forces_on @ forces, strains.T @ stresses
        known = found.get(kind)
        if known is not None:
            quadratic, cubic = known.quadratic + quadratic, known.cubic + cubic
        found[kind] = HigherDegrees(quadratic, cubic)
    return found


def quadratic_forces(system: StructuralSystem, vectors: Array) -> Array:
    """Second-degree internal force per monomial of the basis' coordinates on all unknowns, shape (m, size).

    ``f(V eta) = f(0) + K V eta + y(eta) @ result + third degree``.
    """
    return np.asarray(sum(forces for _, forces, _, _ in _chunks(system, vectors))).T


def stress_energies(system: StructuralSystem, vectors: Array, columns: Mapping[int, Array]) -> Array:
    """Energy ``V s . B y / 2`` of stresses per monomial of the basis' coordinates, shape (n, m).

    ``columns`` gives n stresses by block number, shapes (row, strain, n).
    """
    return np.asarray(
        sum(
            0.5
            * np.tensordot(system.blocks[at].measure[rows, None, None] * columns[at][rows], quadratic, ((0, 1),) * 2)
            for at, rows, _, _, quadratic in _parts(system, vectors, columns)
        )
    )


def stress_loads(system: StructuralSystem, columns: Mapping[int, Array]) -> Array:
    """Internal force ``b = G' V L' s`` of stresses at rest, shape (n, size); ``columns`` as in `stress_energies`."""
    result = np.zeros((system.size + 1, next(iter(columns.values())).shape[-1]))
    for number, column in columns.items():
        block, places = system.blocks[number], system.row_places[number]
        conjugate = block.linear.T @ (block.measure[:, None, None] * column)
        np.add.at(result, places, np.einsum("egd,egn->edn", block.gradient, conjugate))
    return result[:-1].T
