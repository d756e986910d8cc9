"""Frequencies of taut membranes against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from scipy.special import jn_zeros

from tautflex import MembraneSection, Model, solve_modes, solve_prestress
from tautflex.solvers.modal.natural import Modes
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.model import Support
from verification.builders import AREAL_DENSITY, FILM, THICKNESS, antenna, disc_mesh, observed_order

A, B = 2.0, 1.0
RESULTANT = np.array([0.59, 1.0])
STRESS = (RESULTANT[0] / THICKNESS, RESULTANT[1] / THICKNESS, 0.0)
MESHES = ((12, 6), (24, 12), (48, 24))
SECTION = MembraneSection(FILM, THICKNESS)
CLOSED_FORM = "f_mn = sqrt((Nx m²/a² + Ny n²/b²)/(rho h))/2"


def fixed_frequency(m: int, n: int) -> float:
    return 0.5 * np.sqrt((RESULTANT[0] * m**2 / A**2 + RESULTANT[1] * n**2 / B**2) / AREAL_DENSITY)


def first_labels(count: int) -> list[tuple[int, int]]:
    pairs = [(m, n) for m in range(1, 12) for n in range(1, 6)]
    return sorted(pairs, key=lambda pair: fixed_frequency(*pair))[:count]


def by_label(modes: Modes) -> dict[tuple[int, int], float]:
    return {label: f for label, f in zip(modes.labels, modes.frequencies, strict=True) if label is not None}


@pytest.fixture(scope="module")
def fixed_films() -> list[Modes]:
    models = [build_fixed_film(AntennaLayout(A, B, mesh), SECTION, STRESS) for mesh in MESHES]
    return [solve_modes(solve_prestress(model), 10) for model in models]


def test_first_ten_frequencies_of_the_fixed_membrane(fixed_films, verification_row):
    finest = fixed_films[-1]
    labels = first_labels(10)
    assert finest.labels == labels
    expected = np.array([fixed_frequency(m, n) for m, n in labels])
    # Leading error of linear triangles: (k h)^2/24 to (k h)^2/8; the shortest wave here spans 16 cells.
    np.testing.assert_allclose(finest.frequencies, expected, rtol=0.012)
    assert np.all(finest.frequencies > expected)  # a conforming element with consistent mass bounds from above
    for (m, n), f, got in zip(labels, expected, finest.frequencies, strict=True):
        verification_row(f"fixed membrane 2x1 m, f{m}{n} [Hz], 48x24 cells", f, got, CLOSED_FORM)


def test_fixed_membrane_converges_with_order_two(fixed_films, verification_row):
    tables = [by_label(modes) for modes in fixed_films]
    for label in first_labels(8):
        exact = fixed_frequency(*label)
        values = np.array([table[label] for table in tables])
        order = observed_order(values - exact)
        assert np.all((order > 1.8) & (order < 2.2)), (label, order)
        extrapolated = values[2] + (values[2] - values[1]) / 3.0
        assert extrapolated == pytest.approx(exact, rel=1e-3)
        if label in ((1, 1), (2, 1), (1, 2)):
            m, n = label
            verification_row(f"fixed membrane, observed order of f{m}{n}", 2.0, order[-1], CLOSED_FORM)
            verification_row(f"fixed membrane, f{m}{n} [Hz] extrapolated", exact, extrapolated, CLOSED_FORM)
    first = np.array([table[1, 1] for table in tables])
    assert first[2] + (first[2] - first[1]) / 3.0 == pytest.approx(fixed_frequency(1, 1), rel=2e-6)


def test_antenna_layout_and_from_mesh_give_the_same_membrane(fixed_films):
    nodes, triangles = rectangle_mesh(np.linspace(-A / 2, A / 2, 25), np.linspace(-B / 2, B / 2, 13))
    rim = np.flatnonzero((np.abs(nodes[:, 0]) > 0.999) | (np.abs(nodes[:, 1]) > 0.499))
    # Same film listed in another order and with triangles turned over.
    shuffle = np.random.default_rng(1).permutation(len(triangles))
    model = Model.from_mesh(
        nodes,
        triangles=triangles[shuffle][:, [0, 2, 1]],
        membrane=SECTION,
        membrane_stress=STRESS,
        supports=[Support.pinned(rim)],
    )
    modes = solve_modes(solve_prestress(model), 10)
    np.testing.assert_allclose(modes.frequencies, fixed_films[1].frequencies, rtol=1e-9)
    assert modes.labels == fixed_films[1].labels


def test_modes_are_mass_normalised_and_orthogonal(fixed_films):
    for modes in fixed_films:
        system = modes.state.system
        gram = modes.vectors @ (system.inertia.mass_matrix @ modes.vectors.T)
        np.testing.assert_allclose(gram, np.eye(10), atol=1e-9)
        rayleigh = modes.vectors @ (system.matrix(modes.state.tangent_entries) @ modes.vectors.T)
        circular = (2.0 * np.pi * modes.frequencies) ** 2
        np.testing.assert_allclose(rayleigh, np.diag(circular), atol=1e-8 * circular[-1])
        flat = modes.shapes.reshape(10, -1)
        assert np.all(flat.max(axis=1) >= -flat.min(axis=1))


def test_effective_mass_of_the_fundamental_mode(fixed_films, verification_row):
    # Sine half-waves: (int rho h phi)^2 = (8/pi^2)^2 of the film's mass; zero for modes with an even number.
    mass = AREAL_DENSITY * A * B
    values = [modes.effective_mass[0, 2] / mass for modes in fixed_films]
    exact = (8.0 / np.pi**2) ** 2
    assert values[-1] == pytest.approx(exact, rel=1e-6)
    verification_row("fixed membrane, effective mass of f11 / film mass", exact, values[-1], "(8/π²)²")
    # Mode (2,1) turns about y: (int rho h phi x)^2 = 4 m a^2/pi^4.
    inertia = fixed_films[-1].effective_mass[1, 4]
    assert inertia == pytest.approx(4.0 * mass * A**2 / np.pi**4, rel=2e-5)
    verification_row(
        "fixed membrane, effective inertia of f21 [kg m²]", 4.0 * mass * A**2 / np.pi**4, inertia, "4ma²/π⁴"
    )
    np.testing.assert_allclose(fixed_films[-1].effective_mass[1, :3] / mass, 0.0, atol=1e-12)


def cable_edge_wave_number(length: float, gap: float, number: int) -> float:
    """Root of k tan(k a/2) = 1/g (odd number, even shape) or -k cot(k a/2) = 1/g (even number, odd shape)."""
    low, high = (number - 1) * np.pi / length, number * np.pi / length
    if number % 2:
        return brentq(lambda k: k * np.sin(k * length / 2) - np.cos(k * length / 2) / gap, low, high)
    return brentq(lambda k: k * np.cos(k * length / 2) + np.sin(k * length / 2) / gap, low, high)


def test_membrane_on_cable_edges(verification_row):
    gap = 0.25
    meshes = ((10, 5), (20, 10), (40, 20))
    tables = []
    for mesh in meshes:
        state = solve_prestress(antenna(tuple(RESULTANT), mesh, support="all", cable_density=1e-6))
        tables.append(by_label(solve_modes(state, 4)))
    published = {(1, 1): 0.961, (2, 1): 1.189, (3, 1): 1.510}
    for (m, n), rounded in published.items():
        k = np.array([cable_edge_wave_number(A, gap, m), cable_edge_wave_number(B, gap, n)])
        exact = np.sqrt(RESULTANT @ k**2 / AREAL_DENSITY) / (2.0 * np.pi)
        assert exact == pytest.approx(rounded, abs=5.5e-4)
        values = np.array([table[m, n] for table in tables])
        order = observed_order(values - exact)
        assert np.all((order > 1.8) & (order < 2.2)), (m, n, order)
        assert values[-1] == pytest.approx(exact, rel=3e-3)
        extrapolated = values[2] + (values[2] - values[1]) / 3.0
        assert extrapolated == pytest.approx(exact, rel=2e-4)
        source = "roots of k tan(ka/2) = 1/g, -k cot(ka/2) = 1/g"
        verification_row(f"membrane on cable edges, f{m}{n} [Hz], 40x20 cells", exact, values[-1], source)
        verification_row(f"membrane on cable edges, f{m}{n} [Hz] extrapolated", exact, extrapolated, source)
        verification_row(f"membrane on cable edges, observed order of f{m}{n}", 2.0, order[-1], source)


def independent_frequencies(state: PrestressedState, count: int) -> NDArray[np.float64]:
    """SciPy's eigensolver with its own factorization; it also spares labels, which a disc has not."""
    stiffness = state.system.matrix(state.tangent_entries)
    values = eigsh(stiffness, count, state.system.inertia.mass_matrix, sigma=0.0, return_eigenvectors=False)
    return np.sqrt(np.sort(values)) / (2.0 * np.pi)


def test_circular_membrane(verification_row):
    radius, resultant = 0.7, 2.5
    # j01, j11 (twice), j21 (twice), j02
    zeros = [jn_zeros(order, 2) for order in range(3)]
    roots = np.array([zeros[0][0], zeros[1][0], zeros[1][0], zeros[2][0], zeros[2][0], zeros[0][1]])
    np.testing.assert_allclose(roots[[0, 1, 3, 5]], [2.4048, 3.8317, 5.1356, 5.5201], atol=5e-5)
    exact = roots / (2.0 * np.pi * radius) * np.sqrt(resultant / AREAL_DENSITY)
    found = []
    for rings in (6, 12, 24):
        nodes, triangles = disc_mesh(radius, rings)
        model = Model.from_mesh(
            nodes,
            triangles=triangles,
            membrane=SECTION,
            membrane_stress=(resultant / THICKNESS, resultant / THICKNESS, 0.0),
            supports=[Support.pinned(np.arange(len(nodes) - 6 * rings, len(nodes)))],
        )
        state = solve_prestress(model)
        found.append(independent_frequencies(state, 6))
        if rings == 6:
            np.testing.assert_allclose(solve_modes(state, 6).frequencies, found[0], rtol=1e-8)
    order = observed_order(np.array(found) - exact)
    assert np.all((order > 1.8) & (order < 2.2)), order
    np.testing.assert_allclose(found[-1], exact, rtol=8e-3)
    extrapolated = found[2] + (found[2] - found[1]) / 3.0
    np.testing.assert_allclose(extrapolated, exact, rtol=5e-4)
    for k, name in ((0, "j01"), (1, "j11"), (3, "j21"), (5, "j02")):
        case = f"circular membrane, {name} frequency [Hz]"
        verification_row(f"{case}, 24 rings", exact[k], found[-1][k], "f = j/(2πa) sqrt(N/(rho h))")
        verification_row(f"{case} extrapolated", exact[k], extrapolated[k], "f = j/(2πa) sqrt(N/(rho h))")
    verification_row("circular membrane, observed order of f01", 2.0, order[-1, 0], "f = j/(2πa) sqrt(N/(rho h))")
