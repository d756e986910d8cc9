"""Three masses with one very stiff spring [BN]: what a method does with a frequency that no step resolves.

[BN] Bathe & Noh, Computers & Structures 98-99 (2012) 1: k1 = 1e7, k2 = 1, m1 = 0, m2 = m3 = 1, the first point moves
as sin(1.2 t), step 0.2618 (a twentieth of the excitation's period), start from rest. The trapezoidal rule answers with
a wild acceleration of mass 2 that never dies; methods that damp high frequencies follow the slow solution after a few
steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from tautflex import HHT, Bathe, Combination, EnergyConserving, GeneralizedAlpha, Newmark, WilsonTheta

STIFF, SOFT, RATE, STEP = 1e7, 1.0, 1.2, 0.2618
MATRIX = np.array([[STIFF + SOFT, -SOFT], [-SOFT, SOFT]])


def load(time: float) -> np.ndarray:
    """External force on the left-hand side."""
    return np.array([-STIFF * np.sin(RATE * time), 0.0])


@dataclass(frozen=True)
class Masses:
    """State of the two moving masses."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    forces: np.ndarray


def integrate(method, steps: int) -> np.ndarray:
    """History (step, quantity, mass) of displacement, velocity and acceleration through the stages' coefficients."""
    at = Masses(*np.zeros((3, 2)), load(0.0))
    history = [(at.q, at.v, at.a)]
    for n in range(steps):
        passed, begin = [at], n * STEP
        for stage in method.stages(STEP):
            start, scheme = passed[-1], stage.scheme
            v, a = stage.recalled(passed)

            def value(part: Combination, d, v=v, a=a) -> np.ndarray:
                return part.d * d + part.v * v + part.a * a

            evaluated = load(begin + scheme.evaluation * stage.share * STEP)
            known = value(scheme.inertia, 0.0) + scheme.weight * (MATRIX @ start.q + evaluated)
            known = known + (1.0 - scheme.weight) * start.forces
            d = -np.linalg.solve(scheme.inertia.d * np.eye(2) + scheme.weight * MATRIX, known)
            forces = MATRIX @ (start.q + d) + evaluated
            parts = (scheme.end_displacement, scheme.end_velocity, scheme.end_acceleration)
            move, speed, change = (value(part, d) for part in parts)
            passed.append(Masses(start.q + move, speed, change, forces))
            begin += stage.share * STEP
        at = passed[-1]
        history.append((at.q, at.v, at.a))
    return np.array(history)


def slow_solution(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass 2 follows the first point but for 1e-7: displacement, velocity, acceleration."""
    return np.sin(RATE * time), RATE * np.cos(RATE * time), -(RATE**2) * np.sin(RATE * time)


def late_error(method, quantity: int) -> float:
    """Largest error of mass 2 over steps 100 to 200, over the slow solution's largest value.

    The acceleration variable of generalized-alpha belongs to t + (alpha_m - alpha_f) h
    [Erlicher et al., Computational Mechanics 28 (2002) 83], that of the energy-conserving method to t - h/2.
    """
    history, time = integrate(method, 200), STEP * np.arange(201)
    if quantity == 2 and isinstance(method, GeneralizedAlpha):
        time = time + STEP * (method.rho_inf - 1.0) / (method.rho_inf + 1.0)
    if quantity == 2 and isinstance(method, EnergyConserving):
        time = time - 0.5 * STEP
    exact = slow_solution(time)[quantity]
    return float(np.abs(history[100:, quantity, 0] - exact[100:]).max() / np.abs(exact).max())


@pytest.mark.parametrize("method", [Newmark(), GeneralizedAlpha(rho_inf=1.0), HHT(alpha=0.0)], ids=lambda m: m.name)
def test_trapezoidal_rule_keeps_a_spurious_response(method, verification_row):
    assert late_error(method, 0) < 1e-3  # displacements hide it
    assert late_error(method, 1) > 0.5
    assert late_error(method, 2) > 5.0
    verification_row(
        f"Bathe-Noh three masses, {method.name}: error of the stiff mass's acceleration after 100 steps",
        "spurious, > 5",
        late_error(method, 2),
        "Bathe & Noh 2012",
    )


def test_energy_conserving_keeps_it_too():
    """Conserving the energy of an unresolved frequency is what the method promises."""
    assert late_error(EnergyConserving(), 1) > 0.5


@pytest.mark.parametrize(
    "method",
    [
        GeneralizedAlpha(rho_inf=0.0),
        GeneralizedAlpha(rho_inf=0.5),
        GeneralizedAlpha(rho_inf=0.8),
        WilsonTheta(),
    ],
    ids=lambda m: m.name,
)
def test_methods_that_damp_high_frequencies_lose_it(method, verification_row):
    assert late_error(method, 0) < 0.05
    assert late_error(method, 1) < 0.05
    assert late_error(method, 2) < 0.1
    verification_row(
        f"Bathe-Noh three masses, {method.name}: error of the stiff mass's acceleration after 100 steps",
        "none but phase, < 0.1",
        late_error(method, 2),
        "Bathe & Noh 2012",
    )


@pytest.mark.parametrize("split", [0.5, 2.0 - np.sqrt(2.0)])
def test_bathe_loses_it_at_once_and_its_acceleration_is_of_first_order(split, verification_row):
    """Where displacements q are imposed, both stages differentiate them, with errors e of the velocity at g and 1.

    Backward difference: e_1 = -(1 - g) h^2 q3/6 with the third derivative q3; trapezoidal rule: e_g = -e_0 - g^2 h^2
    q3/6. The acceleration takes up c2 (e_g - e_1) with c2 = -1/((1 - g) g h).
    """
    method = Bathe(split)
    assert late_error(method, 0) < 0.05
    assert late_error(method, 1) < 0.05
    expected = RATE * STEP / 6.0 * (2.0 * (1.0 - split) - split**2) / ((1.0 - split) * split)
    got = late_error(method, 2)
    assert got == pytest.approx(expected, rel=0.1)
    # From the third step on there is nothing else.
    time = STEP * np.arange(3, 9)
    early = np.abs(integrate(method, 8)[3:, 2, 0] - slow_solution(time)[2]).max() / RATE**2
    assert early < 1.5 * expected
    text = f"Bathe-Noh three masses, {method.name}: error of the stiff mass's acceleration after 100 steps"
    verification_row(text, expected, got, "leading error of both differences")
