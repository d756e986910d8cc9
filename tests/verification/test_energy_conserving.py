"""Energy and momentum of the energy-conserving method, and cases that break the trapezoidal rule.

[KC] Kuhl & Crisfield, Int. J. Numer. Methods Eng. 45 (1999) 569: the stiff pendulum thrown at 7.72 m/s.
[ST] Simo & Tarnow, Z. angew. Math. Phys. 43 (1992) 757: energy-momentum method.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from tautflex import (
    CableSection,
    EnergyConserving,
    GeneralizedAlpha,
    LawFunction,
    Material,
    MembraneSection,
    Model,
    Newmark,
    NodalForce,
    Rayleigh,
    Stop,
    run_case,
    simulate,
    solve_prestress,
)
from tautflex.case import parse_case, template
from tautflex.elements.laws import Law, TensionField
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.simulate import Run
from tautflex.solvers.transient.status import Status
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from tautflex.structure.model import Support
from verification.builders import line_elements
from verification.dynamic_cases import small_antenna


def film(modulus: float = 2e5, law: str | Law = "elastic", stress: float = 4e3) -> PrestressedState:
    """Fixed-edge film with 12 unknowns."""
    section = MembraneSection(Material(modulus, 1000.0, 0.3), 1e-3, "von-karman", law)
    return solve_prestress(build_fixed_film(AntennaLayout(1.0, 0.8, (3, 3)), section, (stress, 0.75 * stress, 0.0)))


def throw(x, y):
    return 4.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x + 0.5 * y)


def total_energy(run: Run) -> np.ndarray:
    return (run.data.kinetic_energy + run.data.strain_energy).values


def drift(run: Run) -> float:
    energy = total_energy(run)
    return float(np.abs(energy / energy[0] - 1.0).max())


@pytest.mark.slow
def test_energy_over_ten_thousand_nonlinear_steps(verification_row):
    """Deflections of a hundred film thicknesses; the linear film would rise more than twice as high."""
    options = {"time_step": 1e-3, "initial_velocity": throw, "probes": {"A": (1 / 6, 0.8 / 6)}}
    run = simulate(film(), method=EnergyConserving(), end_time=10.0, every=10, **options)
    assert run.stats.steps == 10_000
    linear = simulate(
        film(), method=Newmark(), end_time=1.0, **(options | {"initial_velocity": lambda x, y: 1e-4 * throw(x, y)})
    )
    assert np.abs(run.data.w).max() < 0.5e4 * np.abs(linear.data.w).max()
    assert run.data.strain_energy.max() > 0.9 * total_energy(run)[0]
    assert drift(run) < 1e-10
    verification_row("energy-conserving, 10 000 nonlinear steps: energy drift", 0.0, drift(run), "conservation [ST]")
    # The trapezoidal rule at the same step shows that the motion is not trivial.
    trapezoidal = simulate(film(), method=Newmark(), end_time=1.0, **options)
    assert drift(trapezoidal) > 1e-4
    verification_row("trapezoidal rule, first 1000 of these steps: energy drift", "O(h^2)", drift(trapezoidal), "")


def test_film_that_blows_up_the_trapezoidal_rule(verification_row):
    """A film a hundred times stiffer, few steps per period of its deflection: in-plane waves are not resolved."""
    runs = [
        simulate(film(2e7), method=method, time_step=0.015, end_time=4.5, initial_velocity=throw, throw=False)
        for method in (Newmark(), EnergyConserving())
    ]
    grown = float(total_energy(runs[0]).max() / total_energy(runs[0])[0])
    assert grown > 100.0
    assert runs[1].status is Status.COMPLETED
    assert drift(runs[1]) < 1e-10
    verification_row("stiff film, 300 long steps, trapezoidal rule: largest energy over the first", "> 100", grown, "")
    verification_row("the same, energy-conserving: energy drift", 0.0, drift(runs[1]), "conservation [ST]")


def pendulum(stiffness: float) -> PrestressedState:
    """[KC]: 3.0443 m, 10 kg at the tip (a third of the bar's consistent mass), in the x-z plane."""
    length = 3.0443
    model = Model.from_mesh(
        np.array([[0.0, 0.0, 0.0], [length, 0.0, 0.0]]),
        cables=np.array([[0, 1]]),
        cable=CableSection(Material(stiffness, 30.0 / length), 1.0, "green-lagrange"),
        cable_tension=1e-9,
        supports=(Support.pinned([0]), Support((1,), ("y",))),
    )
    return solve_prestress(model)


def swing(stiffness: float, method, step: float, end: float) -> Run:
    return simulate(
        pendulum(stiffness),
        method=method,
        time_step=step,
        end_time=end,
        initial_velocity=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 7.72]]),
        max_halvings=0,
        probes={"tip": (3.0443, 0.0, 0.0)},
        throw=False,
    )


def test_pendulum_on_which_the_trapezoidal_rule_fails(verification_row):
    """[KC]'s pendulum, softened to 1e6 N: energy swings by a quarter until Newton finds no solution."""
    failed = swing(1e6, Newmark(), 0.1, 20.0)
    assert failed.status is Status.NOT_CONVERGED
    assert failed.data.time.values[-1] < 10.0
    assert drift(failed) > 0.1
    kept = swing(1e6, EnergyConserving(), 0.1, 20.0)
    assert kept.status is Status.COMPLETED
    assert drift(kept) < 1e-10
    radius = np.hypot(3.0443 + kept.data.u.values, kept.data.w.values)
    np.testing.assert_allclose(radius, 3.0443, rtol=1e-3)
    verification_row(
        "stiff pendulum, trapezoidal rule: time of failure [s]", "< 10", failed.data.time.values[-1], "[KC]"
    )
    verification_row("stiff pendulum, energy-conserving, 20 s: energy drift", 0.0, drift(kept), "conservation [ST]")


def test_pendulum_with_the_published_stiffness_runs_to_its_round_off():
    """EA = 1e10 N: the round-off of a position makes forces of 1e-6 N, which Newton must not try to beat."""
    kept = swing(1e10, EnergyConserving(), 0.01, 1.0)
    assert kept.status is Status.COMPLETED
    assert drift(kept) < 1e-6


def free_film(strain: str) -> PrestressedState:
    nodes = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.8, 0.0], [0.0, 0.8, 0.0], [0.45, 0.35, 0.0]])
    model = Model.from_mesh(
        nodes,
        triangles=np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]),
        membrane=MembraneSection(Material(2e5, 1000.0, 0.3), 1e-3, strain),
        membrane_stress=(1e-9, 1e-9, 0.0),
        supports=(),
    )
    return solve_prestress(model)


def momenta(state: PrestressedState, run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Linear and angular momentum with the consistent mass, shapes (time, 3)."""
    data, mass = run.data, state.system.inertia.mass_matrix.toarray()[::3, ::3]
    position = np.stack([data[name].values for name in "uvw"], axis=-1) + state.model.nodes
    velocity = np.stack([data[f"{name}_velocity"].values for name in "uvw"], axis=-1)
    angular = np.cross(position[:, :, None], velocity[:, None])
    return np.einsum("ij,tjk->tk", mass, velocity), np.einsum("ij,tijk->tk", mass, angular)


def change(values: np.ndarray) -> float:
    return float(np.abs(values - values[0]).max() / np.abs(values[0]).max())


@pytest.mark.parametrize("strain", ["green-lagrange", "von-karman"])
def test_momenta_of_a_tumbling_film(strain, verification_row):
    """Free flight through several turns: angular momentum stays where strains do not feel rotations."""
    state = free_film(strain)
    velocity = 3.0 * np.random.default_rng(0).standard_normal((5, 3))
    probes = {str(number): tuple(place) for number, place in enumerate(state.model.nodes)}
    run = simulate(
        state, method=EnergyConserving(), time_step=0.01, end_time=2.0, initial_velocity=velocity, probes=probes
    )
    linear, angular = momenta(state, run)
    assert drift(run) < 1e-10
    assert change(linear) < 1e-12
    objective = strain == "green-lagrange"
    assert (change(angular) < 1e-10) == objective
    if objective:
        verification_row("energy-conserving, free film: change of linear momentum", 0.0, change(linear), "[ST]")
        verification_row("energy-conserving, free film: change of angular momentum", 0.0, change(angular), "[ST]")
        other = simulate(
            state, method=Newmark(), time_step=0.01, end_time=2.0, initial_velocity=velocity, probes=probes
        )
        assert change(momenta(state, other)[1]) > 1e-4


def line(elements: int, slack: bool, tension: float, modulus: float, area: float, length: float = 2.0):
    nodes = np.column_stack([np.linspace(0.0, length, elements + 1), np.zeros((elements + 1, 2))])
    model = Model.from_mesh(
        nodes,
        cables=line_elements(elements),
        cable=CableSection(Material(modulus, 1500.0), area, "green-lagrange", slack),
        cable_tension=tension,
        supports=(Support.pinned([0, elements]),),
    )
    return solve_prestress(model)


@pytest.mark.parametrize("ratio", [2e5, 200.0, 0.2])
@pytest.mark.parametrize("elements", [6, 24])
def test_a_taut_line_does_not_notice_that_it_could_go_slack(elements, ratio, verification_row):
    """Pushed in its middle, with EA / T from stiff wire to rubber: no step is halved."""
    runs = [
        simulate(
            line(elements, slack, 1e3 / ratio, 1e9, 1e-6),
            method=EnergyConserving(),
            time_step=1e-4,
            end_time=1e-2,
            inputs=[NodalForce(nodes=[elements // 2], force=lambda t: (0.0, 0.0, 1e-3))],
            probes={"middle": (1.0, 0.0, 0.0)},
        )
        for slack in (False, True)
    ]
    for run in runs:
        assert (run.stats.steps, run.stats.halvings) == (100, 0)
    elastic, slack = (run.data.w.values for run in runs)
    assert runs[1].stats.iterations < 1.1 * runs[0].stats.iterations
    np.testing.assert_allclose(slack, elastic, rtol=0.0, atol=1e-10 * np.abs(elastic).max())
    energy = [(run.data.strain_energy + run.data.kinetic_energy).values for run in runs]
    np.testing.assert_allclose(energy[1], energy[0], rtol=0.0, atol=1e-10 * energy[0].max())
    if (elements, ratio) == (6, 200.0):
        assert np.abs(slack).max() == pytest.approx(5.661216e-05, rel=1e-6)
        verification_row(
            "taut line of slack cables, energy-conserving / elastic - 1",
            0.0,
            abs(slack - elastic).max() / abs(elastic).max(),
            "",
        )


@dataclass(frozen=True)
class FieldFromOutside(TensionField):
    """Tension field whose average the kernel does not know."""

    average: ClassVar[LawFunction | None] = None


@pytest.mark.parametrize("law", ["slack", "tension-field", FieldFromOutside()], ids=["slack", "film", "film outside"])
def test_nonlinear_laws_keep_their_energy_too(law, verification_row):
    """Cables go slack and films wrinkle, for a second: the mean of the stress takes up their energy exactly."""
    random = np.random.default_rng(0)
    if law == "slack":
        state, velocity = line(6, True, 1.0, 1e3, 1e-2, 1.0), 0.4 * random.standard_normal((7, 3))
    else:
        state, velocity = film(law=law, stress=4e2), 0.5 * random.standard_normal((16, 3))
    run = simulate(
        state, method=EnergyConserving(), time_step=2e-3, end_time=1.0, initial_velocity=velocity, fields="all"
    )
    assert drift(run) < 1e-10
    smallest = [
        min(float(stress.min()) for stress in _trial_stress(state, field)) for field in run.data.displacement.values
    ]
    assert min(smallest) < -100.0  # the elastic law would be in compression: the other one was at work
    if isinstance(law, str):
        verification_row(f"energy-conserving, {law} law, 500 steps: energy drift", 0.0, drift(run), "mean stress")


def test_a_law_from_outside_moves_as_the_same_one_from_inside():
    records = [
        simulate(
            film(law=law, stress=4e2),
            method=EnergyConserving(),
            time_step=2e-3,
            end_time=0.1,
            initial_velocity=0.5 * np.random.default_rng(0).standard_normal((16, 3)),
            probes={"A": (1 / 6, 0.8 / 6)},
        ).data.w.values
        for law in ("tension-field", FieldFromOutside())
    ]
    np.testing.assert_allclose(records[1], records[0], rtol=0.0, atol=1e-9 * np.abs(records[0]).max())


@pytest.mark.parametrize(
    "laws", [["cables.slack=true"], ["membrane.law=tension-field", "prestress.mode=equilibrium", "cables.slack=true"]]
)
def test_antenna_whose_laws_give_way_only_in_compression(laws):
    """The package's own antenna stops as with a dissipative method that asks for far less of its steps."""
    runs = [
        run_case(
            parse_case(template("m2-nearest-node"), [*laws, *method, "solver.end_time=0.05", "output.fields=none"])
        )
        for method in (["solver.method=generalized-alpha", "solver.rho_inf=1.0"], ["solver.method=energy-conserving"])
    ]
    assert runs[1].stats.halvings == 0
    reference = runs[0].data.w.values
    assert np.abs(runs[1].data.w.values - reference).max() < 1e-3 * np.abs(reference).max()


def _trial_stress(state: PrestressedState, field: np.ndarray) -> list[np.ndarray]:
    """Stresses that the elastic law would give to a displacement field (node, 3)."""
    full = np.zeros(state.model.dof_count)
    full[state.model.translation_dofs] = field
    stresses = []
    for block, initial in zip(state.system.blocks, state.system.initial_stress, strict=True):
        g = np.einsum("nij,nj->ni", block.gradient, full[block.dofs])
        strain = g @ block.linear.T + 0.5 * np.einsum("sij,ni,nj->ns", block.quadratic, g, g)
        stresses.append(initial + np.einsum("nst,nt->ns", block.elasticity, strain))
    return stresses


def test_a_maneuver_with_damping_converges_to_the_other_methods():
    """Gyroscopic, Euler and centrifugal terms, damping and load of a stop that ends inside a step."""
    state, stop = solve_prestress(small_antenna()), Stop(0.6, 0.0737, axis=(1.0, 0.2, -0.1), origin=(0.05, 0.1, 0.0))
    records = []
    for method, step, every in (
        (GeneralizedAlpha(1.0), 2.5e-4, 16),
        (EnergyConserving(), 4e-3, 1),
        (EnergyConserving(), 2e-3, 2),
    ):
        run = simulate(
            state,
            stop,
            method=method,
            time_step=step,
            end_time=0.2,
            damping=Rayleigh(0.5, 1e-3),
            probes={"A": (0.6, 0.3)},
            every=every,
        )
        records.append(run.data.w.values[:, 0])
    errors = [np.abs(record - records[0]).max() / np.abs(records[0]).max() for record in records[1:]]
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] > 3.0
