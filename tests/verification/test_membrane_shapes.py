"""Frequencies of taut membranes that are no rectangles, held all around, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import jv, yv

from tautflex import MembraneSection, Model, solve_modes, solve_prestress
from tautflex.structure.model import Support
from verification.builders import AREAL_DENSITY, FILM, THICKNESS

Array = NDArray[np.float64]
SECTION, RESULTANT = MembraneSection(FILM, THICKNESS), 0.8  # N/m, the same in all directions


def eigenvalues(model: Model, count: int) -> Array:
    """omega^2 rho h / N [1/m^2]."""
    return (2.0 * np.pi * solve_modes(solve_prestress(model), count).frequencies) ** 2 * AREAL_DENSITY / RESULTANT


def held(nodes: Array, rim: Array, **elements: Array) -> Model:
    stress = (RESULTANT / THICKNESS, RESULTANT / THICKNESS, 0.0)
    supports = (Support.pinned(np.flatnonzero(rim)),)
    return Model.from_mesh(nodes, membrane=SECTION, membrane_stress=stress, supports=supports, **elements)


def annulus(inner: float, rings: int, count: int) -> Model:
    """Annulus of outer radius 1."""
    radius, angle = np.linspace(inner, 1.0, rings + 1), 2.0 * np.pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    ring, step = np.arange(rings)[:, None] * count, np.arange(count)
    near, far = ring + step, ring + (step + 1) % count
    quads = np.stack([near, near + count, far + count, far], axis=2).reshape(-1, 4)
    rim = np.repeat(np.isin(np.arange(rings + 1), [0, rings]), count)
    return held((radius[:, None, None] * circle).reshape(-1, 3), rim, quads=quads)


@pytest.mark.slow
def test_annulus(verification_row):
    """b/a = 0.3; waves around come in pairs: J_n(k) Y_n(0.3 k) = J_n(0.3 k) Y_n(k)."""
    found = np.sqrt(eigenvalues(annulus(0.3, 32, 128), 7))
    for waves, place in ((0, 0), (1, 1), (2, 3), (3, 5)):
        exact = brentq(lambda k, n=waves: jv(n, k) * yv(n, 0.3 * k) - jv(n, 0.3 * k) * yv(n, k), 4.0, 7.0)
        assert found[place] == pytest.approx(exact, rel=2e-3)
        if waves:
            assert found[place + 1] == pytest.approx(found[place], rel=1e-6)
        verification_row(f"annular membrane, b/a = 0.3, n = {waves}: k a", exact, found[place], "Bessel determinant")


def triangle(corners: Array, cells: int) -> Model:
    """Triangle of ``cells`` six-node triangles along every side."""
    last = 2 * cells
    place = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(last + 1) for j in range(last + 1 - i))}
    i, j = np.array(list(place)).T / last
    nodes = corners[0] + i[:, None] * (corners[1] - corners[0]) + j[:, None] * (corners[2] - corners[0])
    up = np.array([(0, 0), (2, 0), (0, 2), (1, 0), (1, 1), (0, 1)])
    down = np.array([(2, 2), (0, 2), (2, 0), (1, 2), (1, 1), (2, 1)])
    elements = [
        [place[x + a, y + b] for a, b in shape]
        for x in range(0, last, 2)
        for y in range(0, last - x, 2)
        for shape in ((up,) if x + y + 2 == last else (up, down))
    ]
    rim = (i < 1e-9) | (j < 1e-9) | (i + j > 1.0 - 1e-9)
    return held(nodes, rim, triangles=np.array(elements))


@pytest.mark.parametrize(
    ("name", "corners", "exact", "formula"),
    [
        (
            "equilateral triangle",
            [[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]],
            16.0 * np.pi**2 / 9.0 * np.array([3, 7, 7, 12, 13, 13]),
            "16π²/9 (m²+mn+n²)",
        ),
        (
            "right isosceles triangle",
            [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            np.pi**2 * np.array([5, 10, 13, 17, 20, 25]),
            "π²(m²+n²)",
        ),
    ],
    ids=["equilateral", "right isosceles"],
)
def test_triangle(name, corners, exact, formula, verification_row):
    found = eigenvalues(triangle(np.array(corners), 40), len(exact))
    np.testing.assert_allclose(found, exact, rtol=1e-4)
    for number, (wanted, got) in enumerate(zip(exact, found, strict=True), start=1):
        verification_row(f"membrane, {name}: eigenvalue {number}", wanted, got, formula)
