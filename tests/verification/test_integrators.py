"""Integrators against their amplification matrices, derived here from the textbooks and not from the code.

An oscillator x'' + 2 xi w x' + w^2 x = 0 makes a step X1 = A X0 with X = (x, h x', h^2 x''). With O = h w:

[B]  Bathe, Finite Element Procedures, section 9.4.2: A of Wilson's method (for (h^2 x'', h x', x)).
[CH] Chung & Hulbert, J. Appl. Mech. 60 (1993) 371: equations and parameters of generalized-alpha.
[HHT] Hilber, Hughes & Taylor, Earthq. Eng. Struct. Dyn. 5 (1977) 283.
[B7] Bathe, Computers & Structures 85 (2007) 437: the composite method of two stages.
[NB] Noh & Bathe, Computers & Structures 198 (2018) 34: its split, 2 - sqrt(2) of the shortest period error.
[GT] Goudreau & Taylor, Comput. Methods Appl. Mech. Eng. 2 (1973) 69: overshoot of Wilson's method.
[HH] Hilber & Hughes, Earthq. Eng. Struct. Dyn. 6 (1978) 99: collocation methods, overshoot at h/T = 10.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tautflex import (
    HHT,
    Bathe,
    EnergyConserving,
    GeneralizedAlpha,
    InputError,
    Newmark,
    WilsonTheta,
    simulate,
    solve_modes,
)
from tautflex.solvers.transient.methods.scheme import amplification
from verification.dynamic_cases import (
    TINY_VELOCITY,
    Release,
    oscillator,
    soft_film,
    string,
    transverse_spin,
    two_term_root,
)

METHODS = [
    WilsonTheta(),
    WilsonTheta(theta=2.0),
    GeneralizedAlpha(rho_inf=1.0),
    GeneralizedAlpha(rho_inf=0.8),
    GeneralizedAlpha(rho_inf=0.5),
    GeneralizedAlpha(rho_inf=0.0),
    Newmark(),
    Newmark(gamma=0.6, beta=0.3025),
    HHT(),
    HHT(alpha=0.3),
    EnergyConserving(),
    Bathe(),
    Bathe(split=0.5),
]
SOURCES = {
    WilsonTheta: "amplification matrix, Bathe, Finite Element Procedures, 9.4.2",
    GeneralizedAlpha: "amplification matrix, Chung & Hulbert 1993",
    Newmark: "amplification matrix, Chung & Hulbert 1993, alpha_m = alpha_f = 0",
    HHT: "amplification matrix, Hilber, Hughes & Taylor 1977",
    EnergyConserving: "amplification matrix of the mid-point rule",
    Bathe: "trapezoidal rule, then three-point backward difference, Bathe 2007",
}
STEPS_PER_PERIOD = [1e3, 100.0, 30.0, 10.0, 3.0, 1.0, 0.3, 0.1, 1e-3]


def wilson_textbook(theta: float, phase: float, damping: float) -> np.ndarray:
    """A of [B] reordered to (x, h x', h^2 x'')."""
    beta = 1.0 / (theta / phase**2 + damping * theta**2 / phase + theta**3 / 6.0)
    kappa = damping * beta / phase
    rows = [
        [1 - beta * theta**2 / 3 - 1 / theta - kappa * theta, -beta * theta - 2 * kappa, -beta],
        [
            1 - 1 / (2 * theta) - beta * theta**2 / 6 - kappa * theta / 2,
            1 - beta * theta / 2 - kappa,
            -beta / 2,
        ],
        [
            0.5 - 1 / (6 * theta) - beta * theta**2 / 18 - kappa * theta / 6,
            1 - beta * theta / 6 - kappa / 3,
            1 - beta / 6,
        ],
    ]
    return np.array(rows)[::-1, ::-1]


def alpha_textbook(method: GeneralizedAlpha | Newmark | HHT, phase: float, damping: float) -> np.ndarray:
    """A from the three equations of [CH]; HHT with alpha_f = alpha and alpha_m = 0, Newmark with neither."""
    if isinstance(method, GeneralizedAlpha):
        rho = method.rho_inf
        alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
        beta, gamma = (1 - alpha_m + alpha_f) ** 2 / 4, 0.5 - alpha_m + alpha_f
    elif isinstance(method, HHT):
        alpha_m, alpha_f = 0.0, method.alpha
        beta, gamma = (1 + method.alpha) ** 2 / 4, 0.5 + method.alpha
    else:
        alpha_m, alpha_f, beta, gamma = 0.0, 0.0, method.beta, method.gamma
    spring, dashpot = phase**2, 2 * damping * phase
    new = [
        [1.0, 0.0, -beta],
        [0.0, 1.0, -gamma],
        [(1 - alpha_f) * spring, (1 - alpha_f) * dashpot, 1 - alpha_m],
    ]
    old = [[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1 - gamma], [-alpha_f * spring, -alpha_f * dashpot, -alpha_m]]
    return np.linalg.solve(new, old)


def midpoint_textbook(phase: float, damping: float) -> np.ndarray:
    """A of x1 - x0 = h (v0 + v1)/2, v1 - v0 = h a, a = -w^2 (x0 + x1)/2 - 2 xi w (v0 + v1)/2."""
    spring, dashpot = 0.5 * phase**2, damping * phase
    new = [[1.0, -0.5, 0.0], [0.0, 1.0, -1.0], [spring, dashpot, 1.0]]
    old = [[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [-spring, -dashpot, 0.0]]
    return np.linalg.solve(new, old)


def bathe_textbook(split: float, phase: float, damping: float) -> np.ndarray:
    """A of [B7] from its own equations, all unknowns of both stages at once: x, h x', h^2 x'' at g, then at 1.

    x_g = x_0 + g (x'_0 + x'_g)/2 and the same of x''; x'_1 = c1 x_0 + c2 x_g + c3 x_1 and the same of x''; equilibrium.
    """
    c1, c2, c3 = (1 - split) / split, -1 / ((1 - split) * split), (2 - split) / (1 - split)
    spring, dashpot, half = phase**2, 2 * damping * phase, 0.5 * split
    new, old = np.zeros((6, 6)), np.zeros((6, 3))
    new[0, :2], old[0] = (1.0, -half), (1.0, half, 0.0)
    new[1, 1:3], old[1] = (1.0, -half), (0.0, 1.0, half)
    new[2, :3] = new[5, 3:] = spring, dashpot, 1.0
    new[3, [0, 3, 4]], old[3, 0] = (c2, c3, -1.0), -c1
    new[4, [1, 4, 5]], old[4, 1] = (c2, c3, -1.0), -c1
    return np.linalg.solve(new, old)[3:]


def textbook(method, phase: float, damping: float = 0.0) -> np.ndarray:
    if isinstance(method, WilsonTheta):
        return wilson_textbook(method.theta, phase, damping)
    if isinstance(method, EnergyConserving):
        return midpoint_textbook(phase, damping)
    if isinstance(method, Bathe):
        return bathe_textbook(method.split, phase, damping)
    return alpha_textbook(method, phase, damping)


def spectral_radius(matrix: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def oscillating_root(matrix: np.ndarray) -> complex:
    roots = np.linalg.eigvals(matrix)
    return complex(roots[np.argmax(roots.imag)])


@pytest.mark.parametrize("damping", [0.0, 0.03])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_scheme_has_the_textbook_amplification_matrix(method, damping):
    for steps in STEPS_PER_PERIOD:
        phase = 2.0 * np.pi / steps
        expected = textbook(method, phase, damping)
        np.testing.assert_allclose(
            amplification(method, phase, damping), expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max()
        )


@pytest.mark.parametrize("rho_inf", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_generalized_alpha_reaches_its_spectral_radius_and_never_grows(rho_inf, verification_row):
    method = GeneralizedAlpha(rho_inf=rho_inf)
    radii = [spectral_radius(amplification(method, 2.0 * np.pi / steps)) for steps in STEPS_PER_PERIOD]
    assert max(radii) <= 1.0 + 1e-7
    # The limit is a triple root, approached only like (h w)^(-2/3).
    limit = spectral_radius(amplification(method, 1e8))
    assert limit == pytest.approx(rho_inf, abs=1e-5)
    verification_row(
        f"generalized-alpha, spectral radius at infinity, rho_inf = {rho_inf:g}",
        rho_inf,
        limit,
        "Chung & Hulbert 1993",
    )


def test_newmark_and_hht_limits_are_the_published_ones(verification_row):
    assert spectral_radius(amplification(Newmark(), 1e6)) == pytest.approx(1.0, abs=1e-6)
    for alpha in (0.05, 0.2, 1.0 / 3.0):
        expected = (1.0 - alpha) / (1.0 + alpha)  # [CH], HHT row; 1/2 at alpha = 1/3
        got = spectral_radius(amplification(HHT(alpha=alpha), 1e5))
        assert got == pytest.approx(expected, abs=2e-3 if alpha > 0.3 else 1e-6)  # a double root at 1/3
        verification_row(
            f"HHT, spectral radius at infinity, alpha = {alpha:.3g}",
            expected,
            got,
            "Chung & Hulbert 1993: (1 - alpha)/(1 + alpha)",
        )


@pytest.mark.parametrize("split", [0.1, 0.5, 2.0 - np.sqrt(2.0), 0.9])
def test_bathe_never_grows_and_kills_what_it_does_not_resolve(split, verification_row):
    method = Bathe(split=split)
    radii = [
        spectral_radius(amplification(method, phase, xi)) for phase in np.geomspace(1e-3, 1e8, 60) for xi in (0, 0.1)
    ]
    assert max(radii) <= 1.0 + 1e-12
    limit = spectral_radius(amplification(method, 1e8))
    assert limit < 1e-6
    verification_row(f"Bathe, spectral radius at infinity, split = {split:.4g}", 0.0, limit, "Bathe 2007")


def test_bathe_splits_so_that_one_factorization_serves_both_stages(verification_row):
    """Effective stiffness 4/(g h)^2 M + 2/(g h) C + K of the first stage, c3^2 M + c3 C + K of the second."""
    first, second = (stage.scheme for stage in Bathe().stages(0.02))
    assert first.inertia.d == pytest.approx(second.inertia.d, rel=1e-14)
    assert first.velocity.d == pytest.approx(second.velocity.d, rel=1e-14)
    assert (Bathe().tangents, Bathe(split=0.5).tangents) == ((0, 0), (0, 1))
    # [NB]: of all splits it has the shortest period error.
    phase = 0.1
    errors = {
        split: abs(np.angle(oscillating_root(amplification(Bathe(split), phase))) / phase - 1.0)
        for split in (0.4, 0.5, 2.0 - np.sqrt(2.0), 0.7, 0.8)
    }
    assert min(errors, key=errors.get) == 2.0 - np.sqrt(2.0)
    runs = [
        simulate(
            soft_film(),
            method=Bathe(split),
            time_step=2e-3,
            end_time=0.02,
            initial_velocity=lambda x, y: 1e-6 + 0.0 * x,
        )
        for split in (2.0 - np.sqrt(2.0), 0.5)
    ]
    # One of the mass matrix besides.
    assert [run.stats.factorizations for run in runs] == [2, 3]


def test_trapezoidal_rule_is_the_common_special_case():
    for steps in STEPS_PER_PERIOD:
        phase = 2.0 * np.pi / steps
        exact = (1.0 + 0.5j * phase) / (1.0 - 0.5j * phase)  # the rule applied to x' = i w x
        for method in (Newmark(), HHT(alpha=0.0), GeneralizedAlpha(rho_inf=1.0)):
            roots = np.linalg.eigvals(amplification(method, phase))
            assert np.abs(roots - exact).min() < 1e-7


def test_wilson_is_stable_at_theta_1_4_and_unstable_at_1_2_for_long_steps(verification_row):
    phases = np.geomspace(1e-2, 1e5, 200)
    stable = max(spectral_radius(amplification(WilsonTheta(theta=1.4), phase)) for phase in phases)
    assert stable <= 1.0 + 1e-9
    assert spectral_radius(amplification(WilsonTheta(theta=1.2), 2.0 * np.pi * 10.0)) > 1.2
    # Unconditional stability begins at (1 + sqrt 3)/2: bisect the spectral radius at infinity.
    low, high = 1.2, 1.5
    for _ in range(40):
        middle = 0.5 * (low + high)
        unstable = spectral_radius(amplification(WilsonTheta(theta=middle), 1e7)) > 1.0 + 1e-10
        low, high = (middle, high) if unstable else (low, middle)
    expected = 0.5 * (1.0 + np.sqrt(3.0))
    assert high == pytest.approx(expected, abs=1e-6)
    verification_row(
        "Wilson-theta, limit of unconditional stability",
        expected,
        high,
        "Hilber & Hughes 1978: (1 + sqrt 3)/2",
    )


def test_wilson_below_its_limit_blows_up_in_a_run_and_the_default_does_not():
    state, step = oscillator(), 10.0
    peaks = []
    for theta in (1.4, 1.2):
        run = simulate(
            state,
            method=WilsonTheta(theta=theta),
            time_step=step,
            end_time=20 * step,
            initial_velocity=lambda x, y: TINY_VELOCITY + 0.0 * x,
            probes={"middle": (0.5, 0.0, 0.0)},
            tolerance=1e-11,
        )
        peaks.append(np.abs(run.data.w.values[:, 0]))
    assert peaks[0][-5:].max() < 1.2 * peaks[0].max()
    growth = (peaks[1][-1] / peaks[1][5]) ** (1.0 / 15.0)
    expected = spectral_radius(textbook(WilsonTheta(theta=1.2), 2.0 * np.pi * step))
    assert growth == pytest.approx(expected, rel=0.02)
    assert expected > 1.2


@pytest.mark.parametrize("steps", [20.0, 8.0])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_decay_and_period_of_a_run_follow_the_amplification_matrix(method, steps, verification_row):
    """A string released in its second mode: the whole record, then its decay and period."""
    state = string(8, tension=1.0, modulus=1.0, free_directions="z")
    modes = solve_modes(state, n=2)
    frequency = float(modes.frequencies[1])
    step = 1.0 / (steps * frequency)
    shape = modes.shapes[1] / np.abs(modes.shapes[1]).max()
    run = simulate(
        state,
        method=method,
        time_step=step,
        end_time=120 * step,
        initial_velocity=TINY_VELOCITY * shape,
        probes={"quarter": (0.25, 0.0, 0.0)},
        tolerance=1e-11,
    )
    record = run.data.w.values[:, 0] / (shape[2, 2] * TINY_VELOCITY * step)
    matrix, phase = textbook(method, 2.0 * np.pi / steps), 2.0 * np.pi / steps
    vector, expected = np.array([0.0, 1.0, 0.0]), [0.0]
    for _ in range(120):
        vector = matrix @ vector
        expected.append(vector[0])
    np.testing.assert_allclose(record, expected, atol=1e-9 * np.abs(expected).max())
    root, predicted = two_term_root(record[40:]), oscillating_root(matrix)
    damping_got, damping = -np.log(abs(root)) / np.angle(root), -np.log(abs(predicted)) / np.angle(predicted)
    longer_got, longer = phase / np.angle(root) - 1.0, phase / np.angle(predicted) - 1.0
    assert damping_got == pytest.approx(damping, abs=1e-9)
    assert longer_got == pytest.approx(longer, abs=1e-9)
    if steps == 20.0:
        text, source = f"{method.name}, string mode, h/T = 1/20", SOURCES[type(method)]
        damping = damping if damping > 1e-12 else 0.0
        verification_row(f"{text}: algorithmic damping ratio", damping, damping_got, source)
        verification_row(f"{text}: period elongation", longer, longer_got, source)


SECOND_ORDER = [
    WilsonTheta(),
    GeneralizedAlpha(rho_inf=1.0),
    GeneralizedAlpha(rho_inf=0.5),
    Newmark(),
    HHT(alpha=0.2),
    EnergyConserving(),
    Bathe(),
    Bathe(split=0.5),
]


@pytest.mark.parametrize("method", SECOND_ORDER, ids=lambda method: method.name)
def test_second_order_on_a_film_at_large_amplitude(method, verification_row):
    """Four step sizes, each half of the one before: the differences fall by four."""
    state = soft_film()
    records = [large_motion(state, method, 0.0025 / 2**level, 2**level) for level in range(4)]
    differences = [np.sqrt(np.mean((a - b) ** 2)) for a, b in itertools.pairwise(records)]
    orders = np.log2(np.array(differences[:-1]) / differences[1:])
    assert orders[-1] == pytest.approx(2.0, abs=0.05)
    verification_row(
        f"{method.name}, nonlinear film: observed order",
        2.0,
        float(orders[-1]),
        "second order [Chung & Hulbert 1993; Bathe 9.4]",
    )


def large_motion(state, method, step: float, every: int, speed: float = 4.0) -> np.ndarray:
    run = simulate(
        state,
        method=method,
        time_step=step,
        end_time=0.25,
        initial_velocity=lambda x, y: speed * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x + 0.5 * y),
        probes={"A": (0.12, 0.1)},
        tolerance=1e-9,
        every=every,
    )
    return run.data.w.values[:, 0]


def test_the_amplitude_of_the_order_tests_is_large():
    """Hardening more than halves the peak that a linear film of the same speed would reach."""
    state = soft_film()
    linear = 4.0 / 1e-4 * large_motion(state, Newmark(), 0.0025, 1, speed=1e-4)
    assert np.abs(large_motion(state, Newmark(), 0.0025, 1)).max() < 0.5 * np.abs(linear).max()


def test_newmark_with_gamma_above_one_half_is_first_order():
    """Shows that the order test can tell orders apart."""
    state = soft_film()
    method = Newmark(gamma=0.6, beta=0.3025)
    records = [large_motion(state, method, 0.0025 / 2**level, 2**level) for level in range(4)]
    differences = [np.sqrt(np.mean((a - b) ** 2)) for a, b in itertools.pairwise(records)]
    assert np.log2(differences[1] / differences[2]) == pytest.approx(1.0, abs=0.15)


def test_wilson_overshoots_where_the_trapezoidal_rule_does_not(verification_row):
    """Initial displacement of a mode with h/T = 10: the first step tends to -(1 - 1/theta)/2 (h w)^2 x0.

    The factor follows from A of [B] for h w -> infinity, x'' (0) = -w^2 x0.
    """
    state, step = oscillator(), 10.0
    peaks, first = {}, {}
    for method in (WilsonTheta(), Newmark()):
        run = simulate(
            state,
            Release(transverse_spin(-1e-6)),
            method=method,
            time_step=step,
            end_time=20 * step,
            probes={"middle": (0.5, 0.0, 0.0)},
            tolerance=1e-11,
        )
        record = run.data.w.values[:, 0] / run.data.w.values[0, 0]
        peaks[method.name], first[method.name] = np.abs(record).max(), record[1]
        matrix, vector = (
            textbook(method, 2.0 * np.pi * step),
            np.array([1.0, 0.0, -((2.0 * np.pi * step) ** 2)]),
        )
        expected = [1.0, *((np.linalg.matrix_power(matrix, n) @ vector)[0] for n in range(1, 21))]
        np.testing.assert_allclose(record, expected, atol=1e-8 * np.abs(expected).max())
    asymptote = -0.5 * (1.0 - 1.0 / 1.4) * (2.0 * np.pi * step) ** 2
    assert first[WilsonTheta().name] == pytest.approx(asymptote, rel=0.01)
    assert peaks[WilsonTheta().name] > 500.0
    assert peaks[Newmark().name] <= 1.0 + 1e-9
    verification_row(
        "Wilson-theta, overshoot x1/x0 at h/T = 10",
        asymptote,
        first[WilsonTheta().name],
        "Goudreau & Taylor 1973; limit of Bathe's matrix",
    )
    verification_row("trapezoidal rule, peak |x|/x0 at h/T = 10", 1.0, peaks[Newmark().name], "energy is kept")


@pytest.mark.parametrize(
    ("method", "option", "value"),
    [
        (WilsonTheta, "theta", 0.9),
        (WilsonTheta, "theta", float("nan")),
        (GeneralizedAlpha, "rho_inf", 1.2),
        (GeneralizedAlpha, "rho_inf", -0.1),
        (Newmark, "gamma", 0.4),
        (Newmark, "beta", 0.0),
        (HHT, "alpha", 0.5),
        (HHT, "alpha", float("inf")),
    ],
)
def test_options_out_of_range_are_refused(method, option, value):
    with pytest.raises(InputError, match=option):
        method(**{option: value})
