"""Modes of steadily spinning structures against closed forms, published numbers and dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eig
from scipy.special import eval_legendre

from tautflex import (
    Coupling,
    InputError,
    NotConvergedError,
    Rayleigh,
    campbell,
    solve_modes,
    solve_prestress,
    solve_spinning_modes,
)
from tautflex.motion.kinematics import fixed_axis_motion
from tautflex.solvers.modal.spinning import SpinningModes, spinning_pencil
from tautflex.solvers.static.prestress import PrestressedState
from verification.builders import antenna as antenna_model
from verification.builders import observed_order, rotation
from verification.dynamic_cases import moved, small_antenna, string
from verification.spinning_cases import disc_ratio, held_particle, rotating_cantilever, spinning_disc

TILTED = np.array([0.5, 0.6, 0.7])


@pytest.fixture(scope="module")
def antenna() -> PrestressedState:
    """Coarse antenna with 141 unknowns: small enough for dense algebra, large enough for the sparse solver."""
    return solve_prestress(small_antenna())


def pencil_of(modes: SpinningModes, damping: Rayleigh | None = None):
    motion = fixed_axis_motion(1.0, 0.0, modes.angular_velocity, modes.origin)
    return spinning_pencil(modes.state, modes.equilibrium, motion, Coupling(), damping or Rayleigh())


def dense_eigenvalues(modes: SpinningModes, damping: Rayleigh | None = None) -> np.ndarray:
    """All eigenvalues with imaginary part > 0 from the companion pencil of full matrices."""
    mass, velocity, stiffness = (matrix.toarray() for matrix in pencil_of(modes, damping).matrices)
    size = len(mass)
    zero, one = np.zeros((size, size)), np.eye(size)
    values = eig(np.block([[zero, one], [-stiffness, -velocity]]), np.block([[one, zero], [zero, mass]]), right=False)
    values = values[values.imag > 0.0]
    return values[np.argsort(np.abs(values))]


def test_spinning_membrane_disc(verification_row):
    """A film disc held by nothing but its spin [Lamb & Southwell 1921]: second order in the size of the cells."""
    pairs = [(1, 0), (1, 0), (2, 0), (2, 0), (0, 1), (3, 0), (3, 0), (1, 1), (1, 1), (4, 0), (4, 0)]
    exact = np.array([disc_ratio(*pair) for pair in pairs])
    found = []
    for rings in (4, 8, 16):
        modes = solve_spinning_modes(spinning_disc(rings), (0.0, 0.0, 1.0), n=12)
        assert modes.stable
        # All are transverse, along the spin: G has no part in them, and pairs stand still in the rotating frame.
        assert np.abs(modes.whirl).max() < 1e-9
        ratios = (2.0 * np.pi * modes.frequencies[1:]) ** 2  # the first is the heave on its soft cable
        order = np.argsort([disc_ratio(*pair) for pair in pairs], kind="stable")
        found.append(np.sort(ratios)[np.argsort(order)])
    np.testing.assert_allclose(found[-1][:2], 1.0, rtol=1e-5)  # a tilt is rigid: exact on any mesh
    errors = [got[2:] - exact[2:] for got in found]
    assert np.all(errors[-1] > 0.0)
    np.testing.assert_allclose(observed_order(errors)[-1], 2.0, atol=0.15)
    extrapolated = found[-1] + (found[-1] - found[-2]) / 3.0
    np.testing.assert_allclose(extrapolated[2:], exact[2:], rtol=1e-3)
    for k in (0, 2, 4, 5, 7, 9):
        name = f"spinning membrane disc, {pairs[k][0]} diameters, {pairs[k][1]} circles: w/W, 16 rings"
        verification_row(name, np.sqrt(exact[k]), np.sqrt(found[-1][k]), "Lamb & Southwell 1921, nu = 0.3")
    verification_row("spinning membrane disc, 2 diameters: observed order", 2.0, observed_order(errors)[-1][0], "O(h²)")


def test_rotating_string_out_of_plane_and_in_plane(verification_row):
    """(w/W)^2 = n(2n-1) and one less: the odd Legendre polynomials."""
    rate, exact = 2.0, np.array([0.0, 1.0, 5.0, 6.0, 14.0, 15.0])
    found, shapes = [], None
    for elements in (20, 40):
        modes = solve_spinning_modes(string(elements, tension=1e-7, modulus=1e8, free_end=True), (0.0, 0.0, rate), n=6)
        assert modes.stable
        found.append((2.0 * np.pi * modes.frequencies / rate) ** 2)
        shapes = modes.shapes
    np.testing.assert_allclose(found[-1][:2], exact[:2], atol=3e-6)
    errors = [got[2:] - exact[2:] for got in found]
    np.testing.assert_allclose(observed_order(errors)[-1], 2.0, atol=0.1)
    np.testing.assert_allclose(found[1] + (found[1] - found[0]) / 3.0, exact, rtol=2e-4, atol=1e-5)
    place = np.linspace(0.0, 1.0, 41)
    for mode, component, degree in ((1, 2, 1), (2, 1, 3), (3, 2, 3), (5, 2, 5)):
        shape = shapes[mode][:, component].real
        np.testing.assert_allclose(shape / shape[-1], eval_legendre(degree, place), atol=0.03)
    for k, name in ((2, "in plane, n = 2"), (3, "out of plane, n = 2"), (4, "in plane, n = 3")):
        source = "sqrt(n(2n-1))" if "out" in name else "sqrt(n(2n-1)-1)"
        title = f"spinning modes of a rotating string, {name}: w/W, 40 elements"
        verification_row(title, np.sqrt(exact[k]), np.sqrt(found[-1][k]), source)


@pytest.mark.parametrize(("rate", "published"), [(2.0, 4.1373), (6.0, 7.3603), (10.0, 11.2023)])
def test_rotating_cantilever_flaps_as_published(rate, published, verification_row):
    """First flapwise frequency at hub radius 0, all dimensionless by sqrt(EI / rho A L^4)."""
    found = []
    for elements in (4, 8, 16, 32):
        modes = solve_spinning_modes(rotating_cantilever(elements), (0.0, 0.0, rate), n=1)
        assert np.abs(modes.shapes[0, -1, 2]) > 0.99 * np.abs(modes.shapes[0]).max()
        found.append(2.0 * np.pi * modes.frequencies[0])
    # The tension of an element is constant over it, a parabola in truth.
    np.testing.assert_allclose(observed_order(np.diff(found)), 2.0, atol=0.1)
    assert found[-1] == pytest.approx(published, rel=3e-4)
    extrapolated = found[-1] + (found[-1] - found[-2]) / 3.0
    assert extrapolated == pytest.approx(published, abs=1.5e-4)  # the last digit of the table
    name = f"rotating cantilever, flapwise, hub radius 0, rate {rate:g}: lambda_1, 32 elements"
    verification_row(name, published, found[-1], "Hamza Cherif & Houmat, ICAS")


def test_foucault_particle_splits_by_the_spin_rate(verification_row):
    """Isotropic springs in the spin plane: w = |sqrt(k/m) -+ W|, forward and backward; none along the axis."""
    natural = 1.5
    state = held_particle(natural)
    for share in (0.1, 0.7, 1.8, -0.7):
        rate = 2.0 * np.pi * natural * share
        modes = solve_spinning_modes(state, (0.0, 0.0, rate), n=3)
        expected = natural * np.array([abs(1.0 - abs(share)), 1.0, 1.0 + abs(share)])
        np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-8)
        # Above the critical rate the slow orbit, forward in space, falls behind the frame.
        forward = 1.0 if abs(share) < 1.0 else -1.0
        np.testing.assert_allclose(modes.whirl, [forward, 0.0, -1.0], atol=1e-9)
        assert modes.stable
    verification_row(
        "particle on isotropic springs, spin 1.8 sqrt(k/m): backward w/sqrt(k/m)",
        2.8,
        solve_spinning_modes(state, (0.0, 0.0, 3.6 * np.pi * natural), n=3).frequencies[2] / natural,
        "sqrt(k/m) + W",
    )


def test_unequal_springs_are_unstable_between_their_frequencies(verification_row):
    """l^4 + l^2 (a^2 + b^2 + 2 W^2) + (a^2 - W^2)(b^2 - W^2) = 0: one real pair for a < W < b [Jeffcott rotor]."""
    natural, ratio = 1.0, 1.2
    state = held_particle(natural, ratio)
    a, b = 2.0 * np.pi * natural * np.array([1.0, ratio])
    for share, stable in ((0.6, True), (1.1, False), (1.4, True)):
        rate = share * a
        roots = np.roots([1.0, a**2 + b**2 + 2.0 * rate**2, (a**2 - rate**2) * (b**2 - rate**2)])
        slow, fast = np.sort(np.abs(roots))
        modes = solve_spinning_modes(state, (0.0, 0.0, rate), n=3)
        assert modes.stable is stable
        values = modes.eigenvalues[np.abs(modes.shapes[:, 0, 2]) < 1e-6]  # the spin plane alone
        expected = [np.sqrt(slow) if not stable else 1j * np.sqrt(slow), 1j * np.sqrt(fast)]
        np.testing.assert_allclose(values, expected, rtol=1e-7, atol=1e-7)
        if not stable:
            name = "particle on unequal springs, spin between the two: growth rate [1/s]"
            verification_row(name, np.sqrt(slow), values[0].real, "characteristic equation")


def test_eigenvalues_agree_with_dense_algebra(antenna, verification_row):
    """Undamped and damped, with the load bulging the film out of its plane."""
    for damping in (None, Rayleigh(0.05, 1e-3)):
        modes = solve_spinning_modes(antenna, TILTED, origin=(0.2, -0.1, 0.3), n=12, damping=damping)
        assert np.abs(antenna.system.translations(modes.equilibrium)[:, 2]).max() > 1e-4
        error = np.abs(modes.eigenvalues / dense_eigenvalues(modes, damping)[:12] - 1.0).max()
        assert error < 1e-8
        kind = "undamped" if damping is None else "damped"
        verification_row(f"{kind} antenna spinning about a tilted axis, 12 eigenvalues", 0.0, error, "scipy.linalg.eig")


def backward_error(pencil, eigenvalues, vectors):
    """Residual over ``|l|^2 |M| |phi| + |l| |C + G| |phi| + |K| |phi|`` of each mode: 1e-16 at best."""
    residual, scale = np.zeros(vectors.T.shape, dtype=complex), np.zeros(vectors.T.shape)
    for power, matrix in zip((2, 1, 0), pencil.matrices, strict=True):
        residual += eigenvalues**power * (matrix @ vectors.T)
        scale += np.abs(eigenvalues) ** power * (abs(matrix) @ np.abs(vectors.T))
    return np.linalg.norm(residual, axis=0) / np.linalg.norm(scale, axis=0)


def test_undamped_eigenvalues_are_imaginary(antenna, verification_row):
    worst = 0.0
    for spin in ((0.0, 0.0, 1.0), (0.9, 0.0, 0.0), TILTED, (0.0, 0.0, 0.0)):
        modes = solve_spinning_modes(antenna, spin, n=12)
        assert modes.stable
        worst = max(worst, float(np.abs(modes.eigenvalues.real / modes.eigenvalues.imag).max()))
        # They are not only imaginary, they solve the problem.
        assert backward_error(pencil_of(modes), modes.eigenvalues, modes.vectors).max() < 1e-10
    assert worst < 1e-9
    verification_row("undamped stable gyroscopic antenna, |Re l| / |Im l|", 0.0, worst, "conservation of energy")


def test_modes_at_rest_are_the_normal_modes(antenna):
    at_rest, normal = solve_spinning_modes(antenna, np.zeros(3), n=8), solve_modes(antenna, 8)
    np.testing.assert_allclose(at_rest.frequencies, normal.frequencies, rtol=1e-9)
    assert at_rest.labels == normal.labels
    alike = at_rest.vectors.conj() @ (antenna.system.inertia.mass_matrix @ normal.vectors.T)
    np.testing.assert_allclose(np.abs(alike), np.eye(8), atol=1e-6)


def test_shapes_are_normalised_as_stated(antenna):
    modes = solve_spinning_modes(antenna, TILTED, n=6)
    mass = antenna.system.inertia.mass_matrix
    norms = np.sum(modes.vectors.conj() * (mass @ modes.vectors.T).T, axis=1)
    np.testing.assert_allclose(norms, 1.0, atol=1e-12)
    flat = modes.shapes.reshape(6, -1)
    largest = flat[np.arange(6), np.abs(flat).argmax(axis=1)]
    assert np.all(largest.real > 0.0)
    assert np.abs(largest.imag).max() < 1e-12 * np.abs(largest).max()


def test_rayleigh_damping_of_a_particle():
    """Damping of the mass alone in the rotating frame: l = -alpha/2 + i (...) along the axis."""
    natural, alpha, beta = 2.0 * np.pi, 0.3, 0.01
    modes = solve_spinning_modes(held_particle(1.0), (0.0, 0.0, 1.0), n=3, damping=Rayleigh(alpha, beta))
    along = np.abs(modes.shapes[:, 0, 2]).argmax()
    assert modes.damping_ratios[along] == pytest.approx(0.5 * alpha / natural + 0.5 * beta * natural, rel=1e-8)
    # Circular coordinates in the plane: l^2 + (c + 2 i W) l + k - W^2 = 0, and with the other sign of W.
    c, k = alpha + beta * natural**2, natural**2
    roots = [np.roots([1.0, c + 2j * sign, k - 1.0]) for sign in (1.0, -1.0)]
    expected = sorted((root for pair in roots for root in pair if root.imag > 0.0), key=abs)
    got = sorted(np.delete(modes.eigenvalues, along), key=abs)
    np.testing.assert_allclose(got, expected, rtol=1e-8)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), tuple(TILTED)])
def test_campbell_is_symmetric_in_the_sense_of_spin(axis, antenna, verification_row):
    """Time reversal turns G into -G and leaves the rest: the same frequencies, whirl reversed."""
    rates = np.linspace(-1.0, 1.0, 5)
    table = campbell(antenna, rates, axis, n=6)
    frequency = np.sort(table["frequency"].values, axis=1)
    error = np.abs(frequency / frequency[::-1] - 1.0).max()
    assert error < 1e-8
    assert np.ptp(frequency[:, 0]) > 0.1
    name = "z" if axis[0] == 0.0 else "a tilted axis"
    verification_row(f"Campbell table about {name}: frequencies at -W and W", 0.0, error, "time reversal")


def test_branches_run_through_a_crossing(verification_row):
    """A particle's forward and backward orbits and its motion along the axis cross at 0.5, 1 and 2 sqrt(k/m) of spin.

    Springs along z at 1, in the plane at 1 Hz: |1 - s|, 1 and 1 + s; forward falls, is reflected at 0, and crosses 1
    at s = 2. Tracking must not swap it with the motion along the axis.
    """
    state = held_particle(1.0)
    shares = np.array([0.1, 0.6, 1.3, 1.8, 2.2, 2.7])
    table = campbell(state, 2.0 * np.pi * shares, (0.0, 0.0, 1.0), n=3)
    expected = np.column_stack([np.abs(1.0 - shares), np.ones(6), 1.0 + shares])
    np.testing.assert_allclose(table["frequency"].values, expected, rtol=1e-8)
    assert table["mac"].values[:, 1].min() > 0.999
    np.testing.assert_array_equal(np.argsort(expected[3]), [0, 1, 2])
    np.testing.assert_array_equal(np.argsort(expected[5]), [1, 0, 2])
    verification_row(
        "Campbell branch that crosses another at W = 2 sqrt(k/m): w/sqrt(k/m) at 2.7",
        1.7,
        float(table["frequency"][5, 0]),
        "W/sqrt(k/m) - 1",
    )


def test_a_turned_antenna_spins_alike(antenna):
    turned, shift = rotation(3), np.array([0.4, -0.2, 0.1])
    there = solve_prestress(moved(antenna.model, turned, shift))
    here = solve_spinning_modes(antenna, TILTED, origin=(0.1, 0.2, 0.0), n=6)
    other = solve_spinning_modes(there, turned @ TILTED, origin=turned @ (0.1, 0.2, 0.0) + shift, n=6)
    np.testing.assert_allclose(other.eigenvalues, here.eigenvalues, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(other.whirl, here.whirl, atol=1e-6)


def test_free_antenna_drifts_and_wobbles_as_a_rigid_body(verification_row):
    """Seen from the frame, straight motion in space circles at W; a flat body wobbles at W spun about its normal.

    Spun about x, Euler's equations give W sqrt((J_z - J_x)(J_y - J_x)/(J_y J_z)) with J_z = J_x + J_y.
    """
    model = antenna_model((0.06, 0.2), support="free", strain="green-lagrange")
    state, rate = solve_prestress(model), 0.05
    about_z = solve_spinning_modes(state, (0.0, 0.0, rate), n=8).frequencies * 2.0 * np.pi / rate
    np.testing.assert_allclose(np.sort(about_z)[:2], 0.0, atol=0.01)  # along and about the spin
    drift = np.sort(np.abs(about_z - 1.0))[:2]
    assert drift.max() < 1e-6
    np.testing.assert_allclose(np.sort(about_z)[2:6], 1.0, atol=2e-3)
    verification_row(
        "free antenna spinning about its normal, straight drift: w/W - 1", 0.0, drift.max(), "Newton's law"
    )
    second = state.system.inertia.second_moment
    jx, jy, jz = np.trace(second) - np.diag(second)
    exact = np.sqrt((jz - jx) * (jy - jx) / (jy * jz))
    about_x = solve_spinning_modes(state, (rate, 0.0, 0.0), n=8).frequencies * 2.0 * np.pi / rate
    wobble = about_x[np.abs(about_x - exact).argmin()]
    assert wobble == pytest.approx(exact, rel=5e-3)  # bending of the frame has no rotary inertia
    verification_row("free antenna spinning slowly about x, wobble w/W", exact, wobble, "Euler's equations")


def test_each_switch_changes_its_term(antenna):
    spin = np.array([0.0, 0.0, 1.0])
    base = solve_spinning_modes(antenna, spin, n=4)
    soft = solve_spinning_modes(antenna, spin, n=4, coupling=Coupling(inertial_load=False))
    # Without the centrifugal load nothing stretches the film, and S(w)^2 does nothing along the spin.
    np.testing.assert_allclose(soft.frequencies, solve_modes(antenna, 4).frequencies, rtol=1e-6)
    assert base.frequencies[0] > 1.2 * soft.frequencies[0]
    # Film and frame move along the spin in these modes, where G does nothing.
    no_gyro = solve_spinning_modes(antenna, spin, n=4, coupling=Coupling(gyroscopic=False))
    np.testing.assert_allclose(no_gyro.frequencies, base.frequencies, rtol=1e-6)
    particle = held_particle(1.0)
    held = solve_spinning_modes(particle, spin, n=3, coupling=Coupling(gyroscopic=False))
    np.testing.assert_allclose(held.frequencies[:2] * 2 * np.pi, np.sqrt((2 * np.pi) ** 2 - 1.0), rtol=1e-8)
    free = solve_spinning_modes(particle, spin, n=3, coupling=Coupling(centrifugal=False))
    root = np.sqrt((2 * np.pi) ** 2 + 1.0)
    np.testing.assert_allclose(free.frequencies[[0, 2]] * 2 * np.pi, [root - 1.0, root + 1.0], rtol=1e-8)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda state: solve_spinning_modes(state, (1.0, 0.0)), "angular_velocity"),
        (lambda state: solve_spinning_modes(state, (np.nan, 0.0, 0.0)), "finite"),
        (lambda state: solve_spinning_modes(state, TILTED, n=0), "n: expected"),
        (lambda state: solve_spinning_modes(state, TILTED, n=10_000), "refine"),
        (lambda state: campbell(state, [0.0, 1.0, 0.5]), "sort them"),
        (lambda state: campbell(state, []), "rates"),
        (lambda state: campbell(state, [0.0, 1.0], axis=(0.0, 0.0, 0.0)), "axis"),
        (lambda state: campbell(state, [0.0, 1.0], n=0), "n: expected"),
    ],
)
def test_bad_input_is_named(call, words, antenna):
    with pytest.raises(InputError, match=words):
        call(antenna)


def test_a_table_that_breaks_off_keeps_what_it_has(antenna, monkeypatch):
    from tautflex.solvers.modal import campbell as module

    def failing(state, spin, *options):
        if np.linalg.norm(spin) > 0.6:
            raise NotConvergedError("static equilibrium: failed")
        return solve_spinning_modes(state, spin, *options)

    monkeypatch.setattr(module, "solve_spinning_modes", failing)
    with pytest.raises(NotConvergedError, match="at 1 rad/s") as caught:
        campbell(antenna, [0.0, 0.5, 1.0], n=3)
    assert caught.value.result["rate"].values.tolist() == [0.0, 0.5]
    assert caught.value.result.sizes["branch"] == 3
