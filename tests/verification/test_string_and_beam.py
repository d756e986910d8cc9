"""Strings and beams against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from tautflex import (
    BeamSection,
    CableSection,
    Material,
    Model,
    PrestressError,
    solve_modes,
    solve_prestress,
    solve_static,
)
from tautflex.structure.model import Support
from verification.builders import (
    beam_line,
    line_elements,
    line_nodes,
    observed_order,
    rotation,
    unstressed,
)

LENGTH = 1.7
STEEL = Material(2.1e11, 7800.0, 0.3)
SECTION = BeamSection(STEEL, 3e-4, 4e-8, 9e-9, 1.1e-8)
RHO_A = STEEL.density * SECTION.area
EI_Y, EI_Z = STEEL.youngs_modulus * SECTION.inertia_y, STEEL.youngs_modulus * SECTION.inertia_z
CANTILEVER = np.array([1.87510407, 4.69409113, 7.85475744])
FREE_FREE = np.array([4.73004074, 7.85320462, 10.9956078])


def bending(roots: NDArray[np.float64], stiffness: float) -> NDArray[np.float64]:
    return (roots / LENGTH) ** 2 * np.sqrt(stiffness / RHO_A) / (2.0 * np.pi)


def split_by_plane(model: Model, count: int, turn: NDArray[np.float64] | None = None) -> dict[str, NDArray]:
    """Frequencies of the beam's axial (u), in-plane (v), out-of-plane (w) and torsion (t) modes."""
    modes = solve_modes(unstressed(model), count)
    full = modes.state.system.full(modes.vectors).reshape(count, -1, 2, 3)
    if turn is not None:
        full = full @ turn
    mass_like = np.abs(full[:, :, 0]).max(axis=1)
    kinds = np.array(["uvw"[k] for k in mass_like.argmax(axis=1)])
    kinds[mass_like.max(axis=1) < 1e-6 * np.abs(full[:, :, 1, 0]).max(axis=1)] = "t"
    return {kind: modes.frequencies[kinds == kind] for kind in "uvwt"}


def string_frequencies(elements: int, count: int, turn: NDArray[np.float64]) -> NDArray[np.float64]:
    cable = CableSection(Material(133e9, 1440.0), 3.14e-6)
    model = Model.from_mesh(
        line_nodes(LENGTH, elements) @ turn.T,
        cables=line_elements(elements),
        cable=cable,
        cable_tension=0.8,
        supports=[Support.pinned([0, elements])],
    )
    return solve_modes(solve_prestress(model), count).frequencies


def test_taut_string(verification_row):
    rho_a, tension, n = 1440.0 * 3.14e-6, 0.8, np.arange(1, 5)
    exact = n / (2.0 * LENGTH) * np.sqrt(tension / rho_a)
    found = []
    for elements in (16, 32, 64):
        pairs = string_frequencies(elements, 8, rotation(elements)).reshape(4, 2)
        np.testing.assert_allclose(pairs[:, 0], pairs[:, 1], rtol=1e-7)  # two polarisations
        step = n * np.pi / elements
        # Linear elements with consistent mass have their own closed form.
        lattice = np.sqrt(6.0 * (1.0 - np.cos(step)) / (2.0 + np.cos(step))) * elements / (n * np.pi)
        np.testing.assert_allclose(pairs[:, 0], exact * lattice, rtol=1e-7)
        found.append(pairs[:, 0])
    order = observed_order(np.array(found) - exact)
    assert np.all((order > 1.9) & (order < 2.1)), order
    np.testing.assert_allclose(found[2] + (found[2] - found[1]) / 3.0, exact, rtol=2e-5)
    for k in range(4):
        verification_row(f"taut string, f{k + 1} [Hz], 64 elements", exact[k], found[2][k], "n/(2L) sqrt(T/(rho A))")
    verification_row("taut string, observed order of f1", 2.0, order[-1, 0], "n/(2L) sqrt(T/(rho A))")


@pytest.mark.parametrize(
    ("name", "roots", "held"), [("cantilever", CANTILEVER, True), ("free-free beam", FREE_FREE, False)]
)
def test_beam_bending_in_both_planes(name, roots, held, verification_row):
    supports = (Support.clamped(0),) if held else ()
    errors: dict[str, list] = {"v": [], "w": []}
    for elements in (10, 20, 40):
        found = split_by_plane(beam_line(SECTION, LENGTH, elements, supports), 16)
        for plane, stiffness in (("v", EI_Z), ("w", EI_Y)):
            exact = bending(roots, stiffness)
            errors[plane].append(found[plane][found[plane] > 1.0][:3] / exact - 1.0)
    for plane, stiffness in (("v", EI_Z), ("w", EI_Y)):
        order = observed_order(np.array(errors[plane])[:, 1:])
        assert np.all((order > 3.85) & (order < 4.15)), (plane, order)
        np.testing.assert_allclose(errors[plane][-1], 0.0, atol=5e-6)
        exact = bending(roots, stiffness)
        for k in range(3):
            verification_row(
                f"{name}, bending mode {k + 1} along local {plane} [Hz], 40 elements",
                exact[k],
                exact[k] * (1.0 + errors[plane][-1][k]),
                f"βL = {roots[k]:.4f}",
            )


def test_axial_and_torsional_modes_of_a_clamped_bar(verification_row):
    # A stocky section brings these modes below the higher bending modes.
    section = BeamSection(STEEL, 3e-4, 4e-5, 9e-5, 4e-5)
    number = 2.0 * np.arange(1, 3) - 1.0
    polar = STEEL.density * (section.inertia_y + section.inertia_z)
    exact = {
        "u": number / (4.0 * LENGTH) * np.sqrt(STEEL.youngs_modulus / STEEL.density),
        "t": number / (4.0 * LENGTH) * np.sqrt(STEEL.shear_modulus * section.torsion_constant / polar),
    }
    errors: dict[str, list] = {"u": [], "t": []}
    for elements in (8, 16, 32):
        found = split_by_plane(beam_line(section, LENGTH, elements, (Support.clamped(0),)), 20)
        for kind in "ut":
            errors[kind].append(found[kind][:2] / exact[kind] - 1.0)
    for kind, name, source in (
        ("u", "clamped bar, axial", "(2n-1)/(4L) sqrt(E/rho)"),
        ("t", "clamped bar, torsion", "(2n-1)/(4L) sqrt(GJ/(rho(Iy+Iz)))"),
    ):
        order = observed_order(np.array(errors[kind]))
        assert np.all((order > 1.9) & (order < 2.1)), (kind, order)
        np.testing.assert_allclose(errors[kind][-1], 0.0, atol=1e-3)
        for k in range(2):
            value = exact[kind][k] * (1.0 + errors[kind][-1][k])
            verification_row(f"{name} mode {k + 1} [Hz], 32 elements", exact[kind][k], value, source)


def test_turned_beams_have_the_same_frequencies(verification_row):
    straight = solve_modes(unstressed(beam_line(SECTION, LENGTH, 8, (Support.clamped(0),))), 12)
    worst = 0.0
    for seed in range(4):
        turned = beam_line(SECTION, LENGTH, 8, (Support.clamped(0),), turn=rotation(seed))
        found = solve_modes(unstressed(turned), 12).frequencies
        worst = max(worst, float(np.abs(found / straight.frequencies - 1.0).max()))
    assert worst < 1e-8
    verification_row("cantilever turned in space, change of 12 frequencies", 0.0, worst, "invariance")


@pytest.mark.parametrize("elements", [1, 5])
@pytest.mark.parametrize(("direction", "stiffness"), [(1, EI_Z), (2, EI_Y)])
def test_tip_deflection_of_a_cantilever(elements, direction, stiffness, verification_row):
    model = beam_line(SECTION, LENGTH, elements, (Support.clamped(0),))
    state = unstressed(model)
    tip, force = model.translation_dofs[-1], 37.0
    load = np.zeros(model.dof_count)
    load[tip[direction]] = -force
    solution = state.system.full(solve_static(state, load[model.free_dofs], tolerance=1e-12))
    exact = force * LENGTH**3 / (3.0 * stiffness)
    assert solution[tip[direction]] == pytest.approx(exact, rel=1e-9)
    # The mean axial strain vanishes, so the tip moves in by half the integral of the slope squared.
    shortening = -(force**2) * LENGTH**5 / (15.0 * stiffness**2)
    assert solution[tip[0]] == pytest.approx(shortening, rel=1e-7)
    verification_row(
        f"cantilever, tip deflection along local {'xyz'[direction]} [m], {elements} element(s)",
        exact,
        solution[tip[direction]],
        "PL³/3EI",
    )


def pinned_beam(elements: int, axial_force: float = 0.0) -> Model:
    supports = (Support.pinned([0, elements]), Support((0,), ("rx",)))
    return beam_line(SECTION, LENGTH, elements, supports, axial_force=axial_force)


def test_pinned_beam_with_axial_force(verification_row):
    critical = np.pi**2 * EI_Z / LENGTH**2
    for ratio in (-0.9, 0.5, 20.0):
        state = solve_prestress(pinned_beam(24, ratio * critical))
        found = solve_modes(state, 1).frequencies[0]
        exact = np.pi / (2.0 * LENGTH**2) * np.sqrt(EI_Z / RHO_A * (1.0 + ratio))
        assert found == pytest.approx(exact, rel=3e-5)
        verification_row(
            f"pinned beam, f1 [Hz] under N = {ratio:g} of the buckling load",
            exact,
            found,
            "π/(2L²) sqrt(EI/(rho A)) sqrt(1 + NL²/π²EI)",
        )


def test_pinned_beam_buckles_at_eulers_load():
    critical = np.pi**2 * EI_Z / LENGTH**2
    assert solve_prestress(pinned_beam(24, -0.9999 * critical)).unstable_modes == 0
    with pytest.raises(PrestressError, match="unstable, 1 negative eigenvalue"):
        solve_prestress(pinned_beam(24, -1.0001 * critical))


def sine_load(model: Model, elements: int, peak: float) -> NDArray[np.float64]:
    """Consistent nodal load of ``peak sin(pi x/L)`` along local y, eight Gauss points per element."""
    load, h = np.zeros(model.dof_count), LENGTH / elements
    points, weights = np.polynomial.legendre.leggauss(8)
    e = 0.5 * (points + 1.0)
    shapes = [1 - 3 * e**2 + 2 * e**3, h * (e - 2 * e**2 + e**3), 3 * e**2 - 2 * e**3, h * (e**3 - e**2)]
    for k in range(elements):
        density = 0.5 * h * weights * peak * np.sin(np.pi * (k + e) * h / LENGTH)
        for shape, node, step in zip(shapes, (k, k, k + 1, k + 1), (1, 5, 1, 5), strict=True):
            load[model.dof_offset[node] + step] += density @ shape
    return load


def test_large_deflection_of_a_pinned_beam(verification_row):
    # EI (pi/L)^4 A + EA pi^4/(4 L^4) A^3 = p; ten radii of gyration: 96 % of p by stretching.
    linear = EI_Z * (np.pi / LENGTH) ** 4
    cubic = STEEL.youngs_modulus * SECTION.area * np.pi**4 / (4.0 * LENGTH**4)
    amplitude = 10.0 * np.sqrt(SECTION.inertia_z / SECTION.area)
    peak = linear * amplitude + cubic * amplitude**3
    assert cubic * amplitude**3 / peak > 0.96
    found = []
    for elements in (2, 4, 8, 16):
        model = pinned_beam(elements)
        state = unstressed(model)
        load = sine_load(model, elements, peak)
        solution = state.system.full(solve_static(state, -load[model.free_dofs], tolerance=1e-12))
        found.append(solution[model.translation_dofs[elements // 2, 1]])
    # Two elements serve already: the mean axial strain does not lock.
    assert found[0] == pytest.approx(amplitude, rel=6e-3)
    assert found[-1] == pytest.approx(amplitude, rel=3e-6)
    order = observed_order(np.array(found) - amplitude)
    assert np.all((order[1:] > 3.85) & (order[1:] < 4.15)), order
    source = "EI(π/L)⁴A + EAπ⁴A³/(4L⁴) = p"
    verification_row("pinned beam, large deflection [m], 2 elements", amplitude, found[0], source)
    verification_row("pinned beam, large deflection [m], 16 elements", amplitude, found[-1], source)
    verification_row("pinned beam, large deflection, observed order", 4.0, order[-1], source)


def test_roots_solve_the_frequency_equations():
    for root in CANTILEVER:
        exact = brentq(lambda x: np.cos(x) + 1.0 / np.cosh(x), root - 0.1, root + 0.1, xtol=1e-14)
        assert root == pytest.approx(exact, abs=5e-8)
    for root in FREE_FREE:
        exact = brentq(lambda x: np.cos(x) - 1.0 / np.cosh(x), root - 0.1, root + 0.1, xtol=1e-14)
        assert root == pytest.approx(exact, abs=5e-8)
