"""Structures under maneuvers: spin-up of a beam, shaped slews, other frames, tables, sequences, base acceleration."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tautflex import (
    BaseAcceleration,
    BeamSection,
    Coupling,
    GeneralizedAlpha,
    Material,
    Newmark,
    Rayleigh,
    Sequence,
    Slew,
    SpinUp,
    Stop,
    Tabulated,
    WilsonTheta,
    simulate,
    solve_modes,
    solve_prestress,
)
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.model import Support
from verification.builders import beam_line, observed_order, rotation, unstressed
from verification.dynamic_cases import moved, oscillator, small_antenna, soft_film, string

KANE = "Kane, Ryan & Banerjee 1987; Simo & Vu-Quoc 1988"
LENGTH, EXTENSION = 10.0, 5.143e-4
# EA = 2.8e7 N, EI = 1.4e4 N m^2, rho A = 1.2 kg/m
BEAM = BeamSection(Material(2.8e7, 1.2, 0.3), 1.0, 5e-4, 5e-4, 1e-3)


def spun_beam(state: PrestressedState, end: float):
    run = simulate(
        state,
        SpinUp(6.0, 15.0, axis=(0.0, 0.0, 1.0)),
        method=GeneralizedAlpha(rho_inf=0.8),
        time_step=0.02,
        end_time=end,
        probes={"tip": (LENGTH, 0.0, 0.0)},
    )
    tip = run.data.sel(probe="tip")
    return tip.time.values, tip.u.values, tip.v.values


def test_spin_up_of_a_cantilever(verification_row):
    """The tip lags by 0.57 m near 6.8 s, returns, and the beam stays stretched by w^2 rho A L^3/(3 EA)."""
    lags = []
    for elements, end in ((4, 8.0), (8, 20.0)):
        time, extension, lag = spun_beam(unstressed(beam_line(BEAM, LENGTH, elements, (Support.clamped(0),))), end)
        lags.append(lag.min())
    assert lags[1] == pytest.approx(-0.57, abs=0.01)
    assert lags[1] == pytest.approx(lags[0], rel=0.01)
    assert time[lag.argmin()] == pytest.approx(6.8, abs=0.1)
    steady = extension[time > 15.0]
    # What is left of the bending shortens the chord by some micrometres.
    assert steady.mean() == pytest.approx(EXTENSION, rel=2e-3)
    assert np.abs(lag[time > 15.0]).max() < 0.01
    verification_row("spin-up of a cantilever: largest tip lag [m]", -0.57, lags[1], KANE)
    verification_row("spin-up of a cantilever: time of the largest lag [s]", 6.8, time[lag.argmin()], KANE)
    verification_row("spin-up of a cantilever: mean extension after 15 s [m]", EXTENSION, steady.mean(), KANE)


def test_without_geometric_stiffening_the_spun_up_cantilever_diverges(verification_row):
    """Linear strains leave centrifugal softening alone: 6 rad/s is beyond 3.516 sqrt(EI/(rho A L^4)) = 3.80 rad/s."""
    state = unstressed(beam_line(BEAM, LENGTH, 8, (Support.clamped(0),)))
    blocks = tuple(replace(block, quadratic=np.zeros_like(block.quadratic)) for block in state.system.blocks)
    linear = state.system.with_initial_stress(state.system.initial_stress, blocks)
    time, _, lag = spun_beam(PrestressedState(linear, np.zeros(linear.size), 0.0, 0.0, 0), 10.0)
    assert np.all(np.diff(lag[time > 0.1]) < 0.0)
    assert lag[-1] < -2.0 * LENGTH
    at = lag[np.searchsorted(time, 6.8)]
    verification_row("the same with linear strains: tip lag at 10 s [m]", "diverges", float(lag[-1]), KANE)
    assert at < 1.5 * -0.57


def tuned(period: int) -> tuple[PrestressedState, float]:
    """Oscillator whose trapezoidal vibration repeats after exactly ``period`` steps of 10 ms, and that frequency.

    The rule gives w_h = (2/h) arctan(w h/2); in its own terms the shaper's delays are whole steps.
    """
    step = 0.01
    return oscillator(2.0 / step * np.tan(np.pi / period) / (2.0 * np.pi)), 1.0 / (period * step)


@pytest.mark.parametrize("base", ["bang-bang", "versine"])
@pytest.mark.parametrize("shaper", ["ZV", "ZVD"])
def test_a_shaped_slew_leaves_an_oscillator_at_rest(shaper, base, verification_row):
    """One mode on an arm, slewed about y: nothing is left at the design frequency, unlike without the shaper."""
    state, frequency = tuned(40)
    duration = 0.3 + {"ZV": 0.5, "ZVD": 1.0}[shaper] / frequency
    options = {"frequency": frequency, "shaper": shaper, "base": base}
    left = []
    for slew in (
        Slew(1e-4, 0.3, base, axis=(0.0, 1.0, 0.0)),
        Slew(1e-4, duration, "input-shaped", axis=(0.0, 1.0, 0.0), **options),
    ):
        run = simulate(
            state,
            slew,
            method=Newmark(),
            time_step=0.01,
            end_time=2.0,
            # Centrifugal softening would let the frequency vary during the slew.
            coupling=Coupling(centrifugal=False),
            probes={"B": (0.5, 0.0, 0.0)},
            tolerance=1e-11,
        )
        after = run.data.w.values[run.data.time.values > duration + 0.005, 0]
        left.append(np.abs(after).max())
    assert left[0] > 2e-5
    assert left[1] < 1e-6 * left[0]
    verification_row(f"{shaper} on {base}, oscillator: vibration left, of unshaped", 0.0, left[1] / left[0], "none")


def test_a_shaped_slew_quiets_the_antenna(verification_row):
    """Several modes take part; the ZVD shaper of the strongest one still leaves less than a quarter."""
    state = solve_prestress(small_antenna())
    modes = solve_modes(state, n=8)
    frequency = float(modes.frequencies[modes.effective_mass[:, 3].argmax()])
    duration, left = 2.7 / frequency, {}
    for name, options in (
        ("bang-bang", {"profile": "bang-bang"}),
        ("ZVD", {"profile": "input-shaped", "frequency": frequency}),
    ):
        run = simulate(
            state,
            Slew(0.01, duration, **options),
            method=GeneralizedAlpha(rho_inf=0.9),
            time_step=0.01 / frequency,
            end_time=duration + 3.0 / frequency,
            probes={"A": (0.5, 0.5)},
        )
        left[name] = np.abs(run.data.w.values[run.data.time.values > duration]).max()
    assert left["ZVD"] < 0.25 * left["bang-bang"]
    verification_row(
        "slew of the small antenna, vibration left: ZVD of bang-bang",
        "< 0.25",
        left["ZVD"] / left["bang-bang"],
        "shaping",
    )


def antenna_motion(model, maneuver) -> np.ndarray:
    run = simulate(
        solve_prestress(model),
        maneuver,
        method=GeneralizedAlpha(rho_inf=0.8),
        time_step=5e-3,
        end_time=0.2,
        damping=Rayleigh(0.01, 1e-3),
        fields="all",
        tolerance=1e-10,
    )
    return run.data.displacement.values


def test_slewing_about_three_axes_is_the_same_in_any_frame(verification_row):
    """Antenna, rates and origin turned and shifted together: the same motion, turned."""
    model, turn, shift = small_antenna(), rotation(11), np.array([0.4, -1.0, 2.0])
    times, origin = np.linspace(0.0, 0.15, 16), np.array([0.1, 0.2, -0.3])
    phase = np.sin(np.pi * times / 0.15) ** 2
    rates = np.column_stack([0.5 * phase, -0.3 * phase**2, 0.4 * np.sin(2.0 * np.pi * times / 0.15) * phase])
    push = np.column_stack([phase, 0.0 * phase, -0.5 * phase])
    here = antenna_motion(model, Tabulated(times, rates, accelerations=push, origin=tuple(origin)))
    there = antenna_motion(
        moved(model, turn, shift),
        Tabulated(times, rates @ turn.T, accelerations=push @ turn.T, origin=tuple(turn @ origin + shift)),
    )
    error = np.abs(there @ turn - here).max() / np.abs(here).max()
    assert error < 1e-9
    verification_row("three-axis slew of a turned, shifted antenna", 0.0, error, "the same in its own frame")
    # All three axes, the origin and the push matter.
    for options in ({"rates": rates * [1, 1, 0]}, {"origin": (0.0, 0.0, 0.0)}, {"accelerations": None}):
        other = {"rates": rates, "origin": tuple(origin), "accelerations": push} | options
        assert np.abs(antenna_motion(model, Tabulated(times, **other)) - here).max() > 1e-4 * np.abs(here).max()


def film_motion(maneuver, time_step: float = 4e-3) -> np.ndarray:
    run = simulate(
        soft_film(),
        maneuver,
        method=GeneralizedAlpha(rho_inf=0.8),
        time_step=time_step,
        end_time=0.3,
        probes={"A": (0.12, 0.1)},
        tolerance=1e-11,
    )
    return run.data.w.values[:, 0]


def test_a_table_of_two_rows_is_the_stop():
    stop = Stop(3.0, 0.1, origin=(0.0, 0.5, 0.0))
    exact = film_motion(stop)
    table = film_motion(Tabulated([0.0, 0.1], [3.0, 0.0], origin=stop.origin))
    np.testing.assert_allclose(table, exact, atol=1e-9 * np.abs(exact).max())


def test_a_table_with_doubled_rows_is_the_bang_bang_slew():
    slew = Slew(0.2, 0.2, "bang-bang", origin=(0.0, 0.5, 0.0))
    exact = film_motion(slew)
    table = film_motion(Tabulated([0.0, 0.1, 0.1, 0.2], [0.0, 2.0, 2.0, 0.0], origin=slew.origin))
    np.testing.assert_allclose(table, exact, atol=1e-9 * np.abs(exact).max())


@pytest.mark.slow
def test_a_table_reproduces_a_slew(verification_row):
    """The error of the response falls with the fourth power of the rows' distance, as that of the rates does."""
    slew, step, errors = Slew(0.2, 0.24, origin=(0.0, 0.5, 0.0)), 1e-3, []
    exact, way = film_motion(slew, step), slew.formula(slew.numbers).step.around(0.12)

    def error(table: Tabulated) -> float:
        return float(np.sqrt(np.mean((film_motion(table, step) - exact) ** 2)) / np.abs(exact).max())

    for rows in (7, 13, 25):
        times = np.linspace(0.0, 0.24, rows)
        angle, rates, _ = 0.2 * np.array([way(time) for time in times]).T
        errors.append(error(Tabulated(times, rates, origin=slew.origin)))
    order = float(observed_order(errors)[-1])
    assert order > 3.8
    assert errors[-1] < 1e-5
    verification_row("slew as a table of 25 rates: error of the response", 0.0, errors[-1], "the slew itself")
    verification_row("slew as a table of rates: observed order", 4.0, order, "cubic spline")
    turned = np.column_stack([np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0 * angle, 0.0 * angle])
    by_attitude = error(Tabulated(times, quaternions=turned, ends="rest", origin=slew.origin))
    assert by_attitude < 5e-5
    verification_row("slew as a table of 25 quaternions: error of the response", 0.0, by_attitude, "the slew itself")


def test_a_sequence_is_the_table_of_its_rates():
    """Spin up, wait, stop: piecewise linear rates with limits between grid steps."""
    origin = (0.0, 0.5, 0.0)
    sequence = Sequence((SpinUp(2.0, 0.0737, "linear", origin=origin), Stop(2.0, 0.0511, origin=origin)), (0.0313,))
    limits = np.cumsum([0.0, 0.0737, 0.0313, 0.0511])
    twice = np.repeat(limits, [1, 2, 2, 1])
    table = Tabulated(twice, [0.0, 2.0, 2.0, 2.0, 2.0, 0.0], origin=origin)
    np.testing.assert_allclose(film_motion(table), film_motion(sequence), atol=1e-9)


@pytest.mark.parametrize("method", [WilsonTheta(), GeneralizedAlpha(rho_inf=0.8)])
def test_a_sequence_is_stepped_onto_all_its_limits(method, verification_row):
    """Four limits inside steps: one extra step each, and second order as if the motion were smooth."""
    origin = (0.0, 0.5, 0.0)
    sequence = Sequence(
        (Slew(0.1, 0.0937, "bang-bang", origin=origin), BaseAcceleration(2.0, 0.0412, axis=(0.0, 0.0, 1.0))), (0.0217,)
    )
    assert len(sequence.segments()) == 5
    records = []
    for level in range(4):
        step = 0.004 / 2**level
        run = simulate(
            soft_film(),
            sequence,
            method=method,
            time_step=step,
            end_time=0.2,
            probes={"A": (0.12, 0.1)},
            every=2**level,
            tolerance=1e-9,
        )
        assert run.stats.steps == round(0.2 / step) + 4
        np.testing.assert_allclose(run.data.time.values, 0.004 * np.arange(51), atol=1e-14)
        records.append(run.data.w.values[:, 0])
    differences = [np.sqrt(np.mean((a - b) ** 2)) for a, b in pairwise(records)]
    order = float(np.log2(differences[-2] / differences[-1]))
    assert order == pytest.approx(2.0, abs=0.1)
    verification_row(
        f"{method.name}, sequence with four limits inside steps: observed order", 2.0, order, "second order"
    )


def test_base_acceleration_bends_a_string_like_a_uniform_load(verification_row):
    """w(L/2) = -rho A a L^2/(8 T), exact at the nodes of linear elements; then free vibration about zero."""
    tension, acceleration, length = 3.0, 1e-5, 2.0
    state = string(16, length=length, tension=tension, modulus=1.0, free_directions="z")
    exact = -acceleration * length**2 / (8.0 * tension)
    push = BaseAcceleration(acceleration, profile="cut-off", axis=(0.0, 0.0, 1.0))
    held = state.system.translations(spinning_equilibrium(state, push.start(), Coupling()))[8, 2]
    assert held == pytest.approx(exact, rel=1e-8)
    period = 2.0 * length / np.sqrt(tension)
    run = simulate(
        state,
        push,
        method=GeneralizedAlpha(rho_inf=1.0),
        time_step=period / 400,
        end_time=period,
        probes={"B": (1.0, 0.0, 0.0)},
    )
    w = run.data.w.values[:, 0]
    # Half a period later the plucked string is the mirror image of itself.
    assert w[0] == pytest.approx(exact, rel=1e-8)
    assert w[200] == pytest.approx(-exact, rel=0.01)
    assert w[400] == pytest.approx(exact, rel=0.02)
    verification_row("string under steady base acceleration, mid deflection [m]", exact, held, "-rho A a L^2/(8 T)")


def test_base_acceleration_that_is_switched_on_swings_to_twice_its_deflection(verification_row):
    """w = -(a_e/w0^2) (1 - cos w0 t); the oscillator's share a_e of the acceleration is 1/2 by 1/3."""
    frequency, acceleration = 1.0, 1e-4
    options = {"method": Newmark(), "time_step": 1e-3, "end_time": 1.5, "probes": {"B": (0.5, 0.0, 0.0)}}
    run = simulate(
        oscillator(frequency), BaseAcceleration(acceleration, axis=(0.0, 0.0, 1.0)), tolerance=1e-9, **options
    )
    swing = 1.5 * acceleration / (2.0 * np.pi * frequency) ** 2
    exact = -swing * (1.0 - np.cos(2.0 * np.pi * frequency * run.data.time.values))
    np.testing.assert_allclose(run.data.w.values[:, 0], exact, atol=1e-4 * swing)
    verification_row(
        "base acceleration switched on, largest deflection [m]", -2.0 * swing, run.data.w.values.min(), "step"
    )


@pytest.mark.parametrize("cycles", [0.31, 0.8])
def test_half_sine_pulse_leaves_the_vibration_of_the_shock_spectrum(cycles, verification_row):
    """Residual amplitude (a_e/w0^2) |2 r cos(pi/(2 r))/(1 - r^2)|, r = frequency of the pulse over that of the mode."""
    frequency, acceleration = 1.0, 1e-4
    run = simulate(
        oscillator(frequency),
        BaseAcceleration(acceleration, cycles / frequency, "half-sine", axis=(0.0, 0.0, 1.0)),
        method=Newmark(),
        time_step=2e-3,
        end_time=2.5,
        probes={"B": (0.5, 0.0, 0.0)},
        tolerance=1e-9,
    )
    ratio = 0.5 / cycles
    static = 1.5 * acceleration / (2.0 * np.pi * frequency) ** 2
    exact = static * abs(2.0 * ratio * np.cos(0.5 * np.pi / ratio) / (1.0 - ratio**2))
    got = np.abs(run.data.w.values[run.data.time.values > 1.0]).max()
    assert got == pytest.approx(exact, rel=1e-4)
    verification_row(f"half-sine pulse of {cycles:g} cycles, residual [m]", exact, got, "shock response spectrum")
