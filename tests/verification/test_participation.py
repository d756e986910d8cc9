"""Rigid-elastic coupling of a held structure against closed forms and the unreduced equations."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tautflex import (
    BeamSection,
    InputError,
    Material,
    MembraneSection,
    Model,
    PointMass,
    Rayleigh,
    UnsupportedError,
    appendage_data,
    dynamic_mass,
    save_appendage,
    solve_modes,
    solve_prestress,
)
from tautflex.numeric import cross_matrix
from tautflex.solvers.modal.natural import Modes
from tautflex.solvers.modal.rigid import mass_center, rigid_loads, rigid_mass
from tautflex.structure.model import Support
from verification.builders import beam_line, unstressed
from verification.dynamic_cases import small_antenna, string

POINT = np.array([0.3, -0.2, 0.5])


@pytest.fixture(scope="module")
def antenna_modes() -> Modes:
    """All modes but the highest of the coarse antenna."""
    state = solve_prestress(small_antenna())
    return solve_modes(state, state.system.size - 1)


def transfer(point: np.ndarray) -> np.ndarray:
    """Velocity of a point and angular velocity from those of the origin, shape (6, 6)."""
    return np.block([[np.eye(3), -cross_matrix(point)], [np.zeros((3, 3)), np.eye(3)]])


def test_effective_masses_of_a_taut_string(verification_row):
    """m = 1 kg: 8/(n pi)^2 for odd n across, 2 L^2/(n pi)^2 about one end; the sums are m and m L^2/3."""
    data = appendage_data(solve_modes(string(80, tension=4.0, modulus=1.0, free_directions="z"), n=40))
    across, about_end = (data["effective_mass"].sel(direction=name).values for name in ("z", "ry"))
    for n in (1, 3):
        expected = 8.0 / (n * np.pi) ** 2
        assert across[n - 1] == pytest.approx(expected, rel=2e-3)
        verification_row(f"taut string, effective mass of mode {n} / mass", expected, across[n - 1], "8/(n pi)²")
    assert np.abs(across[1::2]).max() < 1e-12
    for n in (1, 2, 3):
        assert about_end[n - 1] == pytest.approx(2.0 / (n * np.pi) ** 2, rel=2e-3)
    # What moves with the ends themselves, a third of the last element's mass or so, no mode holds.
    free = data["free_mass"].sel(direction="z", other_direction="z").item()
    assert 1.0 - free == pytest.approx(1.0 / 80.0, rel=0.5)
    assert np.all(np.diff(np.cumsum(across)) >= 0.0)
    assert across.sum() == pytest.approx(free, rel=0.02)


def test_first_effective_mass_of_a_cantilever(verification_row):
    """0.6131 of the mass in bending mode 1, 0.1883 in mode 2 [Blevins 1979: (2 sigma_n / beta_n L)^2]."""
    section = BeamSection(Material(1e9, 1e4, 0.3), 1e-4, 1e-9, 4e-9, 1e-9)
    state = unstressed(beam_line(section, 1.0, 16, (Support.clamped(0),)))
    data = appendage_data(solve_modes(state, n=12))
    across = data["effective_mass"].sel(direction="z").values
    bending = np.sort(across)[::-1]
    exact = [(2.0 * sigma / beta) ** 2 for sigma, beta in ((0.734096, 1.875104), (1.018467, 4.694091))]
    np.testing.assert_allclose(bending[:2], exact, rtol=1e-4)
    verification_row("cantilever, effective mass of bending mode 1 / mass", exact[0], bending[0], "(2 sigma/(beta L))²")


def test_rigid_mass_matrix_of_a_beam():
    """1 kg uniform bar of length 1 along x about its end: centre of mass at 1/2, inertia 1/3 across."""
    section = BeamSection(Material(1e9, 1e4, 0.3), 1e-4, 1e-9, 4e-9, 1e-9)
    inertia = unstressed(beam_line(section, 1.0, 3, (Support.clamped(0),))).system.inertia
    matrix = rigid_mass(inertia, np.zeros(3))
    polar = 1e4 * 5e-9  # rho (I_y + I_z) L
    np.testing.assert_allclose(np.diag(matrix), [1, 1, 1, polar, 1 / 3 + 1e-5, 1 / 3 + 4e-5], rtol=1e-9)
    # A rotation about y lowers the centre of mass, one about z moves it along y.
    assert matrix[2, 4] == pytest.approx(-0.5)
    assert matrix[1, 5] == pytest.approx(0.5)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-15)


def test_center_and_inertia_of_a_film_in_a_frame_with_a_body(verification_row):
    """Film a x b in a frame of its own size, a body at one corner: Steiner's theorem, away from the origin."""
    a, b, at = 2.0, 1.0, np.array([0.3, -0.7, 0.5])
    film, tube = 0.4, Material(1e9, 1e3, 0.3)
    area, second = 2e-4, 3e-9
    corners = np.array([[-a, -b, 0.0], [a, -b, 0.0], [a, b, 0.0], [-a, b, 0.0]]) / 2.0
    own = np.diag([0.01, 0.02, 0.03])
    model = Model.from_mesh(
        corners + at,
        triangles=[(0, 1, 2), (0, 2, 3)],
        membrane=MembraneSection(Material(1e9, film / (a * b * 1e-4), 0.3), 1e-4),
        beams=[(0, 1), (1, 2), (2, 3), (3, 0)],
        beam=BeamSection(tube, area, second, second, 2 * second),
        masses=(PointMass(2, 0.25, own),),
        supports=(Support.clamped(0),),
    )
    center, inertia = mass_center(unstressed(model).system.inertia)
    line = 1e3 * area
    mass = film + 2.0 * line * (a + b) + 0.25
    middle = 0.25 * corners[2] / mass  # the rest has its centre at the film's
    np.testing.assert_allclose(center, at + middle, rtol=1e-12)
    turning = 1e3 * second  # of a section, per length
    about_x = film * b**2 / 12 + 2 * line * a * (b / 2) ** 2 + 2 * line * b**3 / 12 + 2 * turning * (2 * a + b)
    about_y = film * a**2 / 12 + 2 * line * b * (a / 2) ** 2 + 2 * line * a**3 / 12 + 2 * turning * (2 * b + a)
    about_z = about_x + about_y - 4 * turning * (a + b)
    steiner = 0.25 * (corners[2] @ corners[2] * np.eye(3) - np.outer(corners[2], corners[2]))
    expected = np.diag([about_x, about_y, about_z]) + own + steiner
    expected -= mass * (middle @ middle * np.eye(3) - np.outer(middle, middle))
    np.testing.assert_allclose(inertia, expected, rtol=1e-9, atol=1e-12)
    verification_row(
        "film in a frame with a body, product of inertia [kg m²]", expected[0, 1], inertia[0, 1], "Steiner"
    )


def test_masses_of_all_modes_sum_up(antenna_modes, verification_row):
    data = appendage_data(antenna_modes, POINT)
    shared = data["participation"].values.T @ data["participation"].values
    free, rigid = data["free_mass"].values, data["rigid_mass"].values
    np.testing.assert_allclose(np.diag(rigid)[:3], antenna_modes.state.model.mass, rtol=1e-12)
    # One mode is missing, the highest.
    gap = np.linalg.eigvalsh(free - shared)
    assert gap.min() > -1e-9 * np.trace(free)
    assert gap.max() < 1e-3 * np.trace(free)
    assert np.sum(gap > 1e-9 * np.trace(free)) <= 1
    np.testing.assert_allclose(data["residual_mass"].values, rigid - shared, atol=1e-12)
    assert np.linalg.eigvalsh(data["residual_mass"].values).min() > 0.0
    complete = data["completeness"].values
    assert np.all((complete > 0.999) & (complete < 1.0 + 1e-9))
    verification_row("antenna, sum of effective masses along z / free mass", 1.0, complete[2], "all modes but one")


def test_another_point_sees_the_same_motion(antenna_modes, verification_row):
    """P_0 = P_P T and M_0 = T' M_P T with the velocity transfer T from origin to point."""
    here, there = appendage_data(antenna_modes), appendage_data(antenna_modes, POINT)
    turn = transfer(POINT)
    np.testing.assert_allclose(there["participation"].values @ turn, here["participation"].values, atol=1e-12)
    for name in ("rigid_mass", "free_mass", "residual_mass"):
        moved = turn.T @ there[name].values @ turn
        np.testing.assert_allclose(moved, here[name].values, atol=1e-9, err_msg=name)
    error = np.abs(turn.T @ there["rigid_mass"].values @ turn - here["rigid_mass"].values).max()
    verification_row("antenna, rigid mass matrix moved between two points", 0.0, error, "velocity transfer")
    np.testing.assert_allclose(here["effective_mass"].values, antenna_modes.effective_mass, atol=1e-12)


def test_dynamic_mass_is_that_of_the_unreduced_structure(antenna_modes, verification_row):
    """M_rigid - s^2 L (s^2 M + s C + K)^-1 L' of the full matrices, Rayleigh damping; resonances included."""
    state, damping = antenna_modes.state, Rayleigh(0.05, 2e-3)
    system = state.system
    inertia = system.inertia
    data = appendage_data(antenna_modes, POINT, damping)
    loads, mass = rigid_loads(inertia, POINT), inertia.mass_matrix.toarray()
    stiffness = system.matrix(state.tangent_entries).toarray()
    frequencies = np.array([0.0, 0.4, 1.0, 1.37, 4.0, 30.0])
    found = dynamic_mass(data, frequencies)
    worst = 0.0
    for frequency, matrix in zip(frequencies, found, strict=True):
        s = 2j * np.pi * frequency
        impedance = s**2 * mass + s * (damping.alpha * mass + damping.beta * stiffness) + stiffness
        full = rigid_mass(inertia, POINT) - s**2 * loads @ np.linalg.solve(impedance, loads.T)
        worst = max(worst, float(np.abs(matrix - full).max() / np.abs(full).max()))
    assert worst < 1e-6
    np.testing.assert_allclose(found[0], data["rigid_mass"].values, atol=1e-12)
    verification_row("antenna, dynamic mass matrix at 6 frequencies from modes", 0.0, worst, "full matrices")


def test_files_hold_the_numbers(antenna_modes, tmp_path):
    data = appendage_data(antenna_modes, POINT, 0.02)
    told = json.loads(save_appendage(data, tmp_path / "a.json").read_text(encoding="utf-8"))
    for name in ("frequency", "participation", "residual_mass", "damping_ratio", "point"):
        np.testing.assert_array_equal(told[name], data[name].values)
        assert told["units"][name] == data[name].attrs["units"]
    assert told["directions"] == ["x", "y", "z", "rx", "ry", "rz"]
    with np.load(save_appendage(data, tmp_path / "a.npz")) as stored:
        np.testing.assert_array_equal(stored["rigid_mass"], data["rigid_mass"].values)
        assert set(stored) == set(map(str, data.variables))
    path = save_appendage(data, tmp_path / "a.csv")
    rows = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert rows[0].startswith("mode,frequency,damping_ratio,P_x")
    numbers = np.array([[float(part) for part in row.split(",")] for row in rows[1:]])
    np.testing.assert_array_equal(numbers[:, 1], data["frequency"].values)
    np.testing.assert_array_equal(numbers[:, 2], 0.02)
    np.testing.assert_array_equal(numbers[:, 3:9], data["participation"].values)


def test_directions_that_nothing_can_move_in_are_not_a_number(tmp_path):
    data = appendage_data(solve_modes(string(10, tension=4.0, modulus=1.0, free_directions="z"), n=3))
    assert np.isnan(data["completeness"].sel(direction="x"))
    told = json.loads(save_appendage(data, tmp_path / "a.json").read_text(encoding="utf-8"))
    assert told["completeness"][0] is None
    assert told["completeness"][2] > 0.8


def test_bad_input_is_named(antenna_modes, tmp_path):
    with pytest.raises(InputError, match="point"):
        appendage_data(antenna_modes, (0.0, 1.0))
    with pytest.raises(InputError, match="damping"):
        appendage_data(antenna_modes, damping=[0.1, 0.2])
    with pytest.raises(InputError, match="damping"):
        appendage_data(antenna_modes, damping=-0.1)
    with pytest.raises(InputError, match=r"\.json"):
        save_appendage(appendage_data(antenna_modes), tmp_path / "a.txt")
    with pytest.raises(InputError, match="participation"):
        save_appendage(antenna_modes.to_dataset(), tmp_path / "a.json")
    assert list(tmp_path.iterdir()) == []
    section = BeamSection(Material(1e9, 1e4, 0.3), 1e-4, 1e-9, 4e-9, 1e-9)
    free: Model = beam_line(section, 1.0, 4)
    with pytest.raises(UnsupportedError, match="supports"):
        appendage_data(solve_modes(unstressed(free), 8))
