"""Average stress of laws over a step: the work is the change of energy, whatever the step and the states.

The energies are written down here once more, in extended precision: what is compared would else be their round-off.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from tautflex import LawFunction, Material
from tautflex.elements.laws import Slack, TensionField
from tautflex.mechanics.average import integrate

YOUNG, POISSON, RESIDUAL = 3.5e9, 0.34, 1e-7
MATERIAL = Material(YOUNG, 1500.0, POISSON)
PLANE = YOUNG / (1 - POISSON**2) * np.array([[1, POISSON, 0], [POISSON, 1, 0], [0, 0, 0.5 * (1 - POISSON)]])
STIFFNESS = {Slack: np.array([[YOUNG]]), TensionField: PLANE}
SIZE = 1e-4  # of the strains
Long = np.longdouble


def energy(strain):
    """Stored energy [J/m^3] of cable or film, relaxed but for the residual share."""
    strain, young, nu = strain.astype(Long), Long(YOUNG), Long(POISSON)
    if len(strain) == 1:
        return young * (strain[0] ** 2 if strain[0] > 0 else Long(RESIDUAL) * strain[0] ** 2) / 2
    ex, ey, shear = strain
    elastic = young / (1 - nu**2) * (ex**2 + ey**2 + 2 * nu * ex * ey + (1 - nu) / 2 * shear**2) / 2
    mean, radius = (ex + ey) / 2, np.sqrt(((ex - ey) / 2) ** 2 + (shear / 2) ** 2)
    major, minor = mean + radius, mean - radius
    if minor + nu * major >= 0 and major >= 0:
        return elastic
    return Long(RESIDUAL) * elastic + (1 - Long(RESIDUAL)) * young * max(major, Long(0)) ** 2 / 2


def film_strain(major, minor, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([major * c * c + minor * s * s, major * s * s + minor * c * c, 2 * (major - minor) * c * s])


def pairs(law, step, count=400):
    """Ends of steps of a size (over the strains): anywhere, across a border between two states, past or at zero."""
    rng, strains = np.random.default_rng(0), len(STIFFNESS[law])
    for number in range(count):
        move, start = step * SIZE * rng.standard_normal((2, strains))
        start /= step
        if number % 4 == 1:
            # The borders: e_2 = -nu e_1 and e_1 = 0 of a film, e = 0 of a cable.
            size = SIZE * rng.uniform()
            on_border = film_strain(
                *((size, -POISSON * size) if rng.uniform() < 0.5 else (0.0, -size)), rng.uniform(0, 4)
            )
            start = (on_border if strains == 3 else np.zeros(1)) - rng.uniform() * move
        elif number % 4 == 2:
            start = -rng.uniform() * move + 1e-3 * step * start
        elif number % 4 == 3:
            start, move = (start, -start) if rng.uniform() < 0.5 else (0.0 * start, start)
        yield start, start + move


def means(law, start, end):
    """The law's own mean stress and the one by integration."""
    stiffness, parameters = STIFFNESS[law], law().parameters(MATERIAL)
    trial, trial_end, size = stiffness @ start, stiffness @ end, len(start)
    own = law.average.at(np.concatenate([trial, trial_end]), parameters)
    mean, slope = np.empty(size), np.empty((size, size))
    integrate(law.function.address, np.array(parameters), trial, trial_end, end - start, mean, slope)
    return (own.stress[:size], own.tangent[:size, :size]), (mean, slope)


@pytest.mark.parametrize("step", [1e-12, 1e-8, 1e-4, 1e-2, 1.0, 10.0])
@pytest.mark.parametrize("law", [Slack, TensionField])
def test_work_of_the_average_is_the_change_of_energy(law, step, verification_row):
    """Also symmetric, and the same by integration: to the round-off of the trial stresses, however small the step."""
    worst = np.zeros(3)
    for start, end in pairs(law, step):
        size = float(max(np.abs(STIFFNESS[law] @ start).max(), np.abs(STIFFNESS[law] @ end).max()))
        (own, _), (mean, _) = means(law, start, end)
        (back, _), _ = means(law, end, start)
        move, change = end.astype(Long) - start, energy(end) - energy(start)
        # What the reference itself loses in the difference of its energies.
        lost = 4 * float(np.finfo(Long).eps) * size * float(np.abs([start, end]).sum())
        work = [max(abs(float(stress @ move - change)) - lost, 0.0) for stress in (own, mean)]
        worst = np.maximum(
            worst, [*(np.array(work) / (size * float(np.linalg.norm(move)))), np.abs(own - back).max() / size]
        )
        # Past zero strain all directions meet, and the direction of the mean is worth less than its work.
        assert np.abs(own - mean).max() < (1e-11 if len(start) == 3 else 1e-14) * size
    assert worst.max() < 1e-14
    case = f"{law.name}, average stress of steps of {step:g} strains: work less change of energy / stress"
    verification_row(case, 0.0, worst[:2].max(), "extended precision")


@pytest.mark.parametrize("law", [Slack, TensionField])
def test_average_stress_becomes_the_stress(law):
    """At a step of zero it is the law's stress; the error of a smooth step is of second order in its size."""
    rng, parameters = np.random.default_rng(1), law().parameters(MATERIAL)
    for _ in range(200):
        strain, direction = SIZE * rng.standard_normal((2, len(STIFFNESS[law])))
        stress = law.function.at(STIFFNESS[law] @ strain, parameters).stress
        for mean, _ in means(law, strain, strain):
            np.testing.assert_allclose(mean, stress, rtol=0.0, atol=1e-15 * YOUNG * SIZE * 10)
        errors = [
            np.abs(means(law, strain - h * direction, strain + h * direction)[0][0] - stress).max()
            for h in (2e-3, 1e-3)
        ]
        assert errors[1] < max(0.26 * errors[0], 1e-15 * YOUNG * SIZE * 10) or errors[0] > 1e-5 * YOUNG * SIZE


@pytest.mark.parametrize("law", [Slack, TensionField])
def test_slope_for_newton_is_twice_the_derivative_by_the_end(law):
    """About: a bend may stand on an end of the integration; symmetric and never indefinite."""
    rng, h = np.random.default_rng(2), 1e-6 * SIZE
    for _ in range(50):
        start, move = SIZE * rng.standard_normal((2, len(STIFFNESS[law])))
        end = start + 0.1 * move
        for which in (0, 1):
            slope = means(law, start, end)[which][1]
            columns = [
                (means(law, start, end + h * unit)[which][0] - means(law, start, end - h * unit)[which][0]) / h
                for unit in np.eye(len(start))
            ]
            assert np.abs(slope - np.array(columns).T).max() < 0.06 * YOUNG
            assert np.linalg.eigvalsh(slope).min() > -1e-9 * YOUNG
            np.testing.assert_allclose(slope, slope.T, rtol=0.0, atol=1e-12 * YOUNG)


@LawFunction
def stepped(stress, tangent, energy, parameters, count):
    """Cable with two bends and a curved rise in between: nothing about it is known to the integration."""
    (young,) = parameters
    for e in range(count):
        trial = stress[0, e]
        x = min(max(trial, 0.0), young)
        stress[0, e] = trial - 0.5 * x * x * x / (young * young)
        tangent[0, 0, e] = young - (1.5 * trial * trial / young if x == trial else 0.0)
        energy[e] = (0.5 * trial * trial - 0.125 * x**4 / young**2 - 0.5 * young * max(trial - young, 0.0)) / young


def test_integration_of_a_law_from_outside():
    """Energy written down by the law, stress by integration, over any way through its bends."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        start, end = 2.0 * rng.standard_normal((2, 1))
        mean, slope = np.empty(1), np.empty((1, 1))
        integrate(stepped.address, np.array([1.0]), start, end, end - start, mean, slope)
        change = stepped.at(end, (1.0,)).energy - stepped.at(start, (1.0,)).energy
        size, move = float(np.abs([start, end]).max()), float((end - start)[0])
        assert mean[0] * move == pytest.approx(change, rel=0.0, abs=1e-14 * size * abs(move) + 1e-15 * size**2)


def test_a_function_of_its_own_takes_no_average_of_its_base():
    class Rubber(Slack):
        function: ClassVar[LawFunction | None] = stepped

    assert Rubber.average is None
    assert Slack.average is not None
