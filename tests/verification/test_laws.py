"""Tension-field film and slack cables: closed forms, derivatives, and states reached with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tautflex import (
    BeamSection,
    CableSection,
    Material,
    MembraneSection,
    Model,
    PrestressError,
    Rayleigh,
    Stop,
    build_model,
    membrane_states,
    simulate,
    solve_modes,
    solve_prestress,
    solve_static,
)
from tautflex.case import parse_case, template
from tautflex.elements.laws import TensionField
from tautflex.elements.laws.tension_field import tension_field
from tautflex.mechanics.membrane import membrane_state, principal_resultants
from tautflex.mechanics.system import StructuralSystem
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.model import Support
from verification.builders import CABLE, FILM, FRAME, THICKNESS, antenna

M2_TEMPLATE = template("m2-nearest-node")

Array = NDArray[np.float64]

YOUNG, POISSON = FILM.youngs_modulus, FILM.poisson_ratio
ELASTIC = YOUNG / (1 - POISSON**2) * np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, 0.5 * (1 - POISSON)]])


def respond(strain: Array) -> tuple[Array, Array, float]:
    """Stress, tangent and energy density of the tension-field film at a strain."""
    stress, tangent = np.empty(3), np.empty((3, 3))
    energy = tension_field(*(ELASTIC @ strain), YOUNG, POISSON, TensionField().residual, stress, tangent)
    return stress, tangent, energy


def principal(stress: Array) -> Array:
    return np.linalg.eigvalsh([[stress[0], stress[2]], [stress[2], stress[1]]])


def with_laws(model: Model, law: str = "tension-field", slack: bool = True) -> Model:
    """The same model with nonlinear laws."""
    groups = []
    for group in model.groups:
        section = group.section
        if isinstance(section, MembraneSection):
            section = replace(section, law=law)
        elif isinstance(section, CableSection):
            section = replace(section, slack=slack)
        groups.append(replace(group, section=section))
    return replace(model, groups=tuple(groups))


@pytest.mark.parametrize(
    ("name", "strain", "expected"),
    [
        ("taut, equal stretch e = 1e-4", [1e-4, 1e-4, 0.0], YOUNG * 1e-4 / (1 - POISSON) * np.array([1, 1, 0])),
        ("wrinkled, stretch 1e-4 and shortening 2e-4", [1e-4, -2e-4, 0.0], YOUNG * 1e-4 * np.array([1, 0, 0])),
        ("wrinkled, pure shear 2e-4", [0.0, 0.0, 2e-4], YOUNG * 2e-4 / 4 * np.array([1, 1, 1])),
        ("slack, equal shortening 1e-4", [-1e-4, -1e-4, 0.0], np.zeros(3)),
    ],
)
def test_tension_field_has_its_closed_forms(name, strain, expected, verification_row):
    stress, _, _ = respond(np.array(strain))
    error = float(np.abs(stress - expected).max()) / (YOUNG * 1e-4)
    assert error < 2 * TensionField().residual
    verification_row(f"tension field, {name}: stress error / E e", 0.0, error, "E e_1 along the major direction")


def test_stress_and_tangent_are_the_derivatives_of_the_energy(verification_row):
    """Also: the tangent is never indefinite, and no stress is compressive beyond the residual stiffness."""
    rng, step, worst, seen = np.random.default_rng(0), 1e-9, np.zeros(2), np.zeros(3, dtype=int)
    for _ in range(300):
        strain = 1e-4 * rng.standard_normal(3)
        stress, tangent, _ = respond(strain)
        moved = [(respond(strain + step * unit), respond(strain - step * unit)) for unit in np.eye(3)]
        gradient = np.array([(a[2] - b[2]) / (2 * step) for a, b in moved])
        slope = np.array([(a[0] - b[0]) / (2 * step) for a, b in moved])
        worst = np.maximum(
            worst, [np.abs(gradient - stress).max() / (YOUNG * 1e-4), np.abs(slope - tangent).max() / YOUNG]
        )
        assert np.linalg.eigvalsh(tangent).min() > -1e-9 * YOUNG
        assert principal(stress)[0] > -10 * TensionField().residual * np.abs(ELASTIC @ strain).max()
        # The map reads the same state from the stress as from the trial stress.
        state = membrane_state(*stress, POISSON)
        assert state == membrane_state(*(ELASTIC @ strain), POISSON)
        seen[state] += 1
    assert seen.min() > 30
    assert worst.max() < 1e-5
    for name, error in zip(("stress - energy gradient", "tangent - stress gradient"), worst, strict=True):
        verification_row(f"tension field, {name}, relative", 0.0, error, "central differences at 300 random strains")


def test_the_relaxed_energy_is_convex():
    """Monotone stress: no pair of strains does negative work, across the borders of the three states too."""
    rng = np.random.default_rng(1)
    for _ in range(500):
        first, second = 1e-4 * rng.standard_normal((2, 3))
        assert (respond(first)[0] - respond(second)[0]) @ (first - second) >= 0.0


def test_kernel_has_the_tangent_of_the_laws(verification_row):
    model = with_laws(antenna((0.59, 1.0), (4, 2), strain="green-lagrange", mode="uniform"))
    tension = [group.initial if group.section.kind == "membrane" else -0.3 * group.initial for group in model.groups]
    groups = [replace(group, initial=value) for group, value in zip(model.groups, tension, strict=True)]
    system = StructuralSystem.from_model(replace(model, groups=tuple(groups)))
    rng = np.random.default_rng(2)
    q = 2e-4 * rng.standard_normal(system.size)
    states = membrane_states(system, q)
    assert set(states) == {0, 1, 2}
    step, direction = 1e-9, rng.standard_normal(system.size)
    ahead, behind = (system.force(q + sign * step * direction) for sign in (1, -1))
    force, _ = system.force(q)
    work = (ahead[1] - behind[1]) / (2 * step)
    assert work == pytest.approx(force @ direction, rel=1e-6)
    product = system.matrix(system.tangent(q)) @ direction
    error = float(np.abs((ahead[0] - behind[0]) / (2 * step) - product).max() / np.abs(product).max())
    assert error < 1e-6
    verification_row(
        "antenna with wrinkled, slack film and cables: tangent - force gradient", 0.0, error, "differences"
    )


def test_cable_goes_slack(verification_row):
    """Two cables pull a point both ways; beyond P = 2 T one of them is slack and the other carries all."""
    tension, load, stiffness = 2.0, 7.0, 1e9 * 1e-6 / 0.5
    model = Model.from_mesh(
        [[0.0, 0, 0], [0.5, 0, 0], [1.0, 0, 0]],
        cables=[[0, 1], [1, 2]],
        cable=CableSection(Material(1e9, 1000.0), 1e-6, slack=True),
        cable_tension=tension,
        supports=[Support.pinned([0, 2]), Support((1,), ("y", "z"))],
    )
    state = solve_prestress(model)
    for pull, expected in ((3.0, 3.0 / (2 * stiffness)), (load, (load - tension) / stiffness)):
        q = solve_static(state, forces=[[0, 0, 0], [pull, 0, 0], [0, 0, 0]])
        assert q[0] == pytest.approx(expected, rel=1e-5)
    found = 1e-6 * state.system.stress(q)[0][:, 0]
    np.testing.assert_allclose(found, [load, 0.0], atol=1e-5)
    verification_row("slack cable: displacement at P = 3.5 T [m]", expected, float(q[0]), "(P - T) L/EA")


def test_sheared_strip_carries_its_tension_field(verification_row):
    """Long edges held, sheared by 1e-3: diagonal tension, shear stress E gamma / 4 (elastic: E gamma / 2(1 + nu))."""
    shear = 1e-3
    section = MembraneSection(FILM, THICKNESS, law="tension-field")
    film = build_fixed_film(AntennaLayout(2.0, 0.4, (40, 8)), section, (0.0, 0.0, float(ELASTIC[2, 2]) * shear))
    edge = np.flatnonzero(np.abs(film.nodes[:, 1]) > 0.2 - 1e-9)
    everywhere = Support(tuple(range(len(film.nodes))), ("z",))
    model = replace(film, supports=(Support.pinned(edge), everywhere))
    system = StructuralSystem.from_model(model)
    # The short edges are free: what the trial stress does there is a load.
    state = PrestressedState(system, np.zeros(system.size), 0.0, 0.0, 0)
    q = solve_static(state, tolerance=1e-9)
    centre = np.abs(model.nodes[model.triangles].mean(axis=1)[:, 0]) < 0.2
    mean = system.stress(q)[0][centre].mean(axis=0) / (YOUNG * shear / 4)
    np.testing.assert_allclose(mean, 1.0, rtol=2e-3)
    values = principal_resultants(system, system.stress(q))
    assert values[:, 0].min() > -1e-3 * values[:, 1].max()
    assert np.all(membrane_states(system, q)[centre] == 1)
    verification_row("sheared strip 5:1, shear stress at its centre / (E gamma/4)", 1.0, float(mean[2]), "Wagner 1929")


def test_few_cables_have_a_wrinkled_equilibrium(verification_row):
    """What the elastic law refuses (5 + 3 cables a side) is a state in equilibrium with the tension field."""
    model = antenna((0.59, 1.0), (20, 10), cables=(5, 3))
    with pytest.raises(PrestressError, match=r"let the film wrinkle \(membrane.law = 'tension-field'\)"):
        solve_prestress(model)
    for mode in ("equilibrium", "initial-strain"):
        state = solve_prestress(with_laws(replace(model, prestress_mode=mode)))
        values = principal_resultants(state.system, state.stress)
        assert state.relative_residual < 1e-9
        assert values[:, 0].min() > -1e-3 * values[:, 1].max()
        assert 0.05 < state.wrinkled_fraction < 0.5
        assert any("wrinkled" in text for text in state.warnings)
        # Shortened cables that the film does not pull back from are slack, and said to be.
        slack = int((state.cable_tension < 0.0).sum())
        assert any(f"is slack ({slack} of 16 cables)" in text for text in state.warnings) == (slack > 0)
        assert np.mean(state.membrane_states == 1) == pytest.approx(state.wrinkled_fraction)
        film = np.unique(model.triangles)
        transverse = state.system.place[model.translation_dofs[film, 2]]
        stiffness = state.system.matrix(state.tangent_entries).toarray()[np.ix_(transverse, transverse)]
        least = float(np.linalg.eigvalsh(stiffness)[0]) / float(np.abs(stiffness).max())
        assert least > -1e-9
        case = f"5 + 3 cables, tension field, {mode}: "
        verification_row(case + "residual / largest force", 0.0, state.relative_residual, "statics")
        least_stress = float(min(values[:, 0].min() / values[:, 1].max(), 0.0))
        verification_row(case + "least / largest principal resultant", "> -1e-3", f"{least_stress:.1e}", "required", "")
        verification_row(
            case + "least transverse eigenvalue / largest entry", "> -1e-9", f"{least:.1e}", "stability", ""
        )
    assert solve_modes(state, 3).frequencies[0] > 0.0


def test_corner_cables_leave_slack_film_that_is_reported():
    state = solve_prestress(with_laws(antenna((0.59, 1.0), (24, 12), cables=(2, 2))))
    assert state.slack_fraction > 0.02
    assert state.wrinkled_fraction > 0.5
    assert any("slack" in text and "%" in text for text in state.warnings)
    assert any("almost no stiffness" in text for text in state.warnings)


def test_a_taut_film_does_not_notice_the_law(verification_row):
    model = antenna((0.59, 1.0), (10, 5))
    elastic, field = (solve_modes(solve_prestress(each), 6).frequencies for each in (model, with_laws(model)))
    np.testing.assert_allclose(field, elastic, rtol=1e-9)
    error = float(np.abs(field / elastic - 1.0).max())
    verification_row("taut antenna, tension-field / elastic frequencies - 1", 0.0, error, "the laws agree where taut")


def test_a_case_file_switches_the_laws_on():
    case = parse_case(M2_TEMPLATE, ["membrane.law=tension-field", "cables.slack=true"])
    film, cables, _ = (group.section for group in build_model(case).groups)
    assert isinstance(film, MembraneSection)
    assert isinstance(cables, CableSection)
    assert (film.law, cables.slack) == ("tension-field", True)
    film, cables, _ = (group.section for group in build_model(parse_case(M2_TEMPLATE)).groups)
    assert (film.law, cables.slack) == ("elastic", False)  # type: ignore[union-attr]


def papers_m1() -> Model:
    """M1 in the identified reading: tensions and film resultants given, one diagonal, corners clamped."""
    pull = np.array([0.147, 0.25])
    stress = np.array([0.707, 0.547]) * pull / THICKNESS
    return build_antenna(
        AntennaLayout(2.0, 1.0, (10, 5), "regular", 2.5, 1.5, 11, 6, "equal", "corners"),
        MembraneSection(FILM, THICKNESS),
        CableSection(CABLE, 3.14e-6),
        BeamSection(FRAME, 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=pull[0],
        pretension_y=pull[1],
        membrane_stress=(*stress, 0.0),
        prestress_mode="uniform",
    )


@pytest.mark.parametrize(("rate", "name"), [(np.pi / 100, "pi/100"), (np.pi / 2, "pi/2")])
def test_m1_stopped_with_both_laws(rate, name, verification_row):
    """The film of M1 is compressed by the stop; with the tension field nothing is, and every step converges."""
    amplitude = {}
    for law in ("elastic", "tension-field"):
        model = with_laws(papers_m1(), law, law != "elastic")
        run = simulate(
            solve_prestress(model),
            Stop(rate, 0.1),
            time_step=2.5e-3,
            end_time=0.5,
            damping=Rayleigh(0.001, 0.001),
            probes={"A": (0.8, 0.5)},
            fields=[0.2],
        )
        data = run.data
        amplitude[law] = 1e3 * float(np.abs(data.w).max())
        least = float(data.min_principal_resultant.min())
        source = "required" if law != "elastic" else "counter-example"
        ratio = float((data.min_principal_resultant / data.max_principal_resultant).min())
        case = f"M1 stopped from {name}, {law}: least / largest principal resultant, worst instant"
        verification_row(case, "> -1e-3" if law != "elastic" else "< 0", f"{ratio:.1e}", source, "")
        states = data.film_state.sel(field_time=0.2, method="nearest")
        assert str(states.attrs["flag_meanings"]).split() == ["taut", "wrinkled", "slack"]
        assert states.max() > 0
        assert float(data.wrinkled_fraction.max()) > 0.3
        if law == "elastic":
            assert ratio < -0.1
            assert "membrane.law = 'tension-field'" in data.attrs["warnings"][0]
            assert f"{least:.3g} N/m" in data.attrs["warnings"][0]
            assert any("cables.slack = true" in text for text in data.attrs["warnings"]) == (name == "pi/2")
        else:
            assert ratio > -1e-3
            assert data.attrs["warnings"] == []
            assert run.stats.halvings == 0
    elastic, field = (f"{amplitude[law]:.4g}" for law in ("elastic", "tension-field"))
    case = f"M1 stopped from {name}, amplitude at A [mm]: tension field beside elastic"
    verification_row(case, f"{elastic} (elastic)", f"{field} (tension field)", "comparison", "")
