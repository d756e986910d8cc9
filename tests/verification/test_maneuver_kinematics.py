"""Maneuvers as functions of time: derivatives that belong together, angles reached, attitudes, input shapers."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tautflex import AtRest, BaseAcceleration, Sequence, Slew, SpinUp, Stop, Stretch, Tabulated, attitude
from tautflex.motion.fixed_axis import FixedAxis
from tautflex.motion.rotations import matrix
from tautflex.motion.shaping import shaper_impulses
from tautflex.numeric import cross_matrix
from verification.builders import observed_order

SHAPING = "Singer & Seering 1990"
AXIS, ORIGIN = (2.0, -1.0, 0.5), (0.3, -0.2, 0.7)
ABOUT = {"axis": AXIS, "origin": ORIGIN}
SLEWS = {
    "versine": {"profile": "versine"},
    "bang-bang": {"profile": "bang-bang"},
    "minimum-jerk": {"profile": "minimum-jerk"},
    "ZV on bang-bang": {"profile": "input-shaped", "frequency": 1.3, "shaper": "ZV"},
    "ZVD on bang-bang": {"profile": "input-shaped", "frequency": 1.3, "damping_ratio": 0.07},
    "ZVD on versine": {"profile": "input-shaped", "frequency": 1.3, "base": "versine"},
    "ZV on minimum-jerk": {"profile": "input-shaped", "frequency": 1.3, "shaper": "ZV", "base": "minimum-jerk"},
}
TIMES = np.linspace(0.0, 2.0, 21)
RATES = np.column_stack([np.sin(TIMES), 0.4 * TIMES**2, np.cos(2.0 * TIMES) - 1.0])


def tumble(time: np.ndarray | float) -> np.ndarray:
    """Attitude Rz(a) Rx(b), a = 0.8 sin t, b = 0.3 t^2 as quaternions, scalar first, with changing signs."""
    turned = Rotation.from_euler("ZX", np.column_stack([0.8 * np.sin(time), 0.3 * np.square(time)]))
    return np.roll(turned.as_quat(), 1, axis=-1)


def tumble_rates(time: float) -> tuple[np.ndarray, np.ndarray]:
    """w = b' x + Rx(-b) z a' in the turned axes, and its derivative."""
    b, b1, b2 = 0.3 * time**2, 0.6 * time, 0.6
    a1, a2 = 0.8 * np.cos(time), -0.8 * np.sin(time)
    sine, cosine = np.sin(b), np.cos(b)
    velocity = np.array([b1, a1 * sine, a1 * cosine])
    change = np.array([b2, a2 * sine + a1 * b1 * cosine, a2 * cosine - a1 * b1 * sine])
    return velocity, change


MANEUVERS = {
    "stop": Stop(0.9, 1.5, **ABOUT),
    **{f"slew, {name}": Slew(0.7, 2.0, **options, **ABOUT) for name, options in SLEWS.items()},
    "spin-up, linear": SpinUp(1.2, 1.5, "linear", **ABOUT),
    "spin-up, versine": SpinUp(1.2, 1.5, initial_rate=-0.4, **ABOUT),
    "spin-up, minimum-jerk": SpinUp(1.2, 1.5, "minimum-jerk", **ABOUT),
    "table of rates": Tabulated(TIMES, np.sin(3.0 * TIMES), **ABOUT),
    "table of three rates": Tabulated(TIMES, RATES, **ABOUT),
    "table of quaternions": Tabulated(TIMES, quaternions=tumble(TIMES), **ABOUT),
    "table, piecewise linear": Tabulated([0.0, 0.6, 0.6, 2.0], [0.0, 0.9, 0.9, 0.2], **ABOUT),
    "sequence": Sequence((SpinUp(0.6, 1.0, **ABOUT), Stop(0.6, 0.5, **ABOUT), Slew(-0.2, 1.0)), (0.3, 0.2)),
}


def inner_limits(segment, end: float = 3.0) -> tuple[float, float]:
    return segment.start, min(segment.end, max(end, segment.start + 1.0))


def stretches(slew: Slew) -> list[Stretch]:
    """Angle over the whole angle, and its derivatives, between the instants where they jump."""
    step = slew.formula(slew.numbers).step
    return [Stretch(start, end, step.around(0.5 * (start + end))) for start, end in pairwise(step.edges)]


def turned_angle(maneuver, order: int = 24) -> float:
    """Integral of the rate about the axis over all moving segments, by Gauss's rule on each."""
    axis = np.asarray(maneuver.axis) / np.linalg.norm(maneuver.axis)
    points, weights = np.polynomial.legendre.leggauss(order)
    total = 0.0
    for segment in maneuver.segments()[:-1]:
        half = 0.5 * (segment.end - segment.start)
        rates = [segment.motion(segment.start + half * (1.0 + point)).angular_velocity @ axis for point in points]
        total += half * float(weights @ rates)
    return total


@pytest.mark.parametrize("name", MANEUVERS)
def test_acceleration_is_the_derivative_of_velocity(name):
    """Central differences extrapolated to fourth order, at random instants of every segment."""
    random, worst = np.random.default_rng(5), 0.0
    for segment in MANEUVERS[name].segments():
        start, end = inner_limits(segment)
        h = 1e-3 * (end - start)
        for time in random.uniform(start + 2 * h, end - 2 * h, 20):
            spin = [segment.motion(time + k * h).angular_velocity for k in (-2, -1, 1, 2)]
            slope = (spin[0] - 8.0 * spin[1] + 8.0 * spin[2] - spin[3]) / (12.0 * h)
            worst = max(worst, np.abs(segment.motion(time).angular_acceleration - slope).max())
    # The third derivative of a spline jumps at its knots, where the differences err by h^2.
    limit = 1e-4 if name.startswith("table") else 1e-8
    assert worst < limit


@pytest.mark.parametrize("name", MANEUVERS)
def test_segments_cover_all_time_and_velocity_never_jumps(name):
    maneuver = MANEUVERS[name]
    segments = maneuver.segments()
    assert segments[0].start == 0.0
    assert segments[-1].end == np.inf
    before = maneuver.start()
    assert not before.angular_acceleration.any()
    np.testing.assert_allclose(segments[0].motion(0.0).angular_velocity, before.angular_velocity, atol=1e-15)
    for first, second in pairwise(segments):
        assert first.start < first.end == second.start
        at = second.start
        np.testing.assert_allclose(
            second.motion(at).angular_velocity, first.motion(at).angular_velocity, rtol=1e-12, atol=1e-14
        )


@pytest.mark.parametrize("name", ["slew, versine", "slew, minimum-jerk", "slew, ZVD on versine", "spin-up, versine"])
def test_smooth_profiles_have_continuous_acceleration(name):
    segments = MANEUVERS[name].segments()
    assert not np.abs(segments[0].motion(0.0).angular_acceleration).max() > 1e-14
    for first, second in pairwise(segments):
        jump = second.motion(second.start).angular_acceleration - first.motion(second.start).angular_acceleration
        assert np.abs(jump).max() < 1e-13


@pytest.mark.parametrize("name", MANEUVERS)
def test_a_shifted_axis_gives_the_acceleration_of_the_origin(name):
    """The frame's origin is at -A(t) o: its second difference in space equals A a0."""
    maneuver, h = MANEUVERS[name], 5e-3
    segments = maneuver.segments()
    for segment in {segments[0].start: segments[0], segments[-2].start: segments[-2], np.inf: segments[-1]}.values():
        start, end = inner_limits(segment)
        if end - start < 5 * h:
            continue
        time = start + 0.37 * (end - start)
        time = min(max(time, start + 2 * h), end - 2 * h)
        instants = time + h * np.arange(-2, 3)
        origin = np.asarray(getattr(maneuver, "origin", ORIGIN if time < 1.8 else (0.0, 0.0, 0.0)))
        path = np.array([-matrix(q) @ origin for q in attitude(maneuver, instants)])
        second = (-path[0] + 16.0 * path[1] - 30.0 * path[2] + 16.0 * path[3] - path[4]) / (12.0 * h**2)
        here = matrix(attitude(maneuver, [time])[0]) @ segment.motion(time).origin_acceleration
        np.testing.assert_allclose(here, second, atol=2e-5)


@pytest.mark.parametrize("name", SLEWS)
@pytest.mark.parametrize("angle", [0.7, -2.5])
def test_a_slew_turns_by_its_angle_and_rests(name, angle, verification_row):
    slew = Slew(angle, 2.0, **SLEWS[name], **ABOUT)
    assert turned_angle(slew) == pytest.approx(angle, abs=1e-12)
    assert stretches(slew)[-1].values(2.0)[0] == pytest.approx(1.0, abs=1e-14)
    last = slew.segments()[-1]
    # The delays of a shaper are part of the duration.
    assert last.start == pytest.approx(2.0, abs=1e-14)
    rest = last.motion(5.0)
    assert not rest.angular_velocity.any()
    assert not rest.angular_acceleration.any()
    assert not rest.origin_acceleration.any()
    final = slew.segments()[-2].motion(2.0).angular_velocity
    assert np.abs(final).max() < 1e-14
    if angle > 0.0 and name in ("versine", "ZVD on bang-bang"):
        verification_row(f"{name} slew: integral of the rate [rad]", angle, turned_angle(slew), "its angle")


def test_versine_slew_and_spin_up_are_the_published_functions(verification_row):
    """theta = angle (t/T - sin(2 pi t/T)/(2 pi)); Kane: theta' = 6/15 (t - 15/(2 pi) sin(2 pi t/15))."""
    slew, time = Slew(0.7, 2.0, axis=(0.0, 0.0, 1.0)), 0.83
    exact = 0.7 * (time / 2.0 - np.sin(np.pi * time) / (2.0 * np.pi))
    assert stretches(slew)[0].values(time)[0] * 0.7 == pytest.approx(exact, rel=1e-14)
    kane = SpinUp(6.0, 15.0, axis=(0.0, 0.0, 1.0))
    moving = kane.segments()[0].motion(4.7)
    rate = 6.0 / 15.0 * (4.7 - 15.0 / (2.0 * np.pi) * np.sin(2.0 * np.pi * 4.7 / 15.0))
    assert moving.angular_velocity[2] == pytest.approx(rate, rel=1e-14)
    assert moving.angular_acceleration[2] == pytest.approx(0.4 * (1.0 - np.cos(2.0 * np.pi * 4.7 / 15.0)), rel=1e-14)
    # theta(15) = 6/15 15^2/2 = 45, and from there on 6 t - 45.
    assert turned_angle(kane) == pytest.approx(45.0, rel=1e-13)
    assert kane.segments()[-1].motion(99.0).angular_velocity[2] == 6.0
    verification_row("Kane's spin-up: angle at 15 s [rad]", 45.0, turned_angle(kane), "Kane; Simo & Vu-Quoc 1988")


@pytest.mark.parametrize("name", SLEWS)
def test_attitude_of_a_slew_is_its_angle_about_its_axis(name):
    slew, times = Slew(2.5, 2.0, **SLEWS[name], **ABOUT), np.linspace(0.0, 3.0, 13)
    axis = np.asarray(AXIS) / np.linalg.norm(AXIS)
    angle = np.full(len(times), 2.5)
    for piece in stretches(slew):
        inside = (times >= piece.start) & (times <= piece.end)
        angle[inside] = [2.5 * piece.values(time)[0] for time in times[inside]]
    exact = np.column_stack([np.cos(angle / 2.0), np.outer(np.sin(angle / 2.0), axis)])
    np.testing.assert_allclose(attitude(slew, times), exact, atol=1e-11)


def test_attitude_follows_any_course_and_start(verification_row):
    """Through the exact rates of a tumble, and on from a given attitude; pauses are no trouble."""
    rows, initial = np.linspace(0.0, 3.0, 61), [2, 0, 0, 2]
    maneuver, times = Tabulated(rows, quaternions=tumble(rows)), rows[::4]
    turned = attitude(maneuver, times)
    # A spline of quaternions passes through them: its own rates lead back exactly, whatever it does in between.
    cosines = np.sum(turned * tumble(times), axis=1)
    apart = np.abs(turned - np.sign(cosines)[:, None] * tumble(times)).max()
    assert apart < 1e-10
    start = Rotation.from_quat([0, 0, 1, 1])
    both = (start * Rotation.from_quat(np.roll(turned, -1, axis=1))).as_matrix()
    np.testing.assert_allclose([matrix(q) for q in attitude(maneuver, times, initial)], both, atol=1e-10)
    waited = Sequence((AtRest(), Slew(0.5, 0.01)), (100.0,))
    assert 2.0 * np.arccos(attitude(waited, [200.0])[0, 0]) == pytest.approx(0.5, abs=1e-9)
    verification_row("attitude along the rates of a table of quaternions", 0.0, apart, "the table itself")


@pytest.mark.parametrize(
    ("kind", "orders"), [("rates", (4.0, 3.0)), ("quaternions", (3.0, 2.0))], ids=["rates", "quaternions"]
)
def test_tables_converge_with_the_order_of_their_spline(kind, orders, verification_row):
    """Cubic splines: the table's quantity errs by h^4, each derivative by one order more."""
    errors = []
    for count in (11, 21, 41, 81):
        times = np.linspace(0.0, 2.0, count)
        # The same places between the rows of every table.
        sample = (times[:-1, None] + (times[1] - times[0]) * np.array([0.1, 0.5, 0.8])).ravel()
        exact = [tumble_rates(time) for time in sample]
        values = tumble(times) if kind == "quaternions" else np.array([tumble_rates(time)[0] for time in times])
        motions = [Tabulated(times, **{kind: values}).segments()[0].motion(time) for time in sample]
        spin = max(np.abs(m.angular_velocity - e[0]).max() for m, e in zip(motions, exact, strict=True))
        change = max(np.abs(m.angular_acceleration - e[1]).max() for m, e in zip(motions, exact, strict=True))
        errors.append((spin, change))
    found = observed_order(np.array(errors).T[0]), observed_order(np.array(errors).T[1])
    for got, order, name in zip(found, orders, ("velocity", "acceleration"), strict=True):
        assert got[-1] == pytest.approx(order, abs=0.25)
        verification_row(f"table of {kind}: order of the angular {name}", order, float(got[-1]), "cubic spline")


def test_signs_and_lengths_of_quaternions_do_not_matter():
    times = np.linspace(0.0, 3.0, 40)
    plain = tumble(times)
    scaled = plain * np.random.default_rng(1).choice([-1.0, 1.0, 3.0, -0.2], size=(40, 1))
    for time in (0.4, 1.7, 2.9):
        one = Tabulated(times, quaternions=plain).segments()[0].motion(time)
        other = Tabulated(times, quaternions=scaled).segments()[0].motion(time)
        np.testing.assert_allclose(other.angular_velocity, one.angular_velocity, atol=1e-13)
        np.testing.assert_allclose(other.angular_acceleration, one.angular_acceleration, atol=1e-12)


def test_tables_of_quaternions_can_begin_and_end_at_rest():
    times = np.linspace(0.0, 2.0, 15)
    slew = Slew(0.7, 2.0, axis=AXIS)
    turned = attitude(slew, times)
    free, rest = (Tabulated(times, quaternions=turned, ends=ends) for ends in ("free", "rest"))
    assert not np.abs(rest.start().angular_velocity).max() > 1e-15
    assert not np.abs(rest.segments()[-1].motion(9.0).angular_velocity).max() > 1e-14
    # Left free, the spline drifts on by the error of its slope.
    assert np.abs(free.segments()[-1].motion(9.0).angular_velocity).max() > 1e-5


def test_a_table_coasts_before_and_after():
    table = Tabulated(TIMES, 0.5 + np.sin(TIMES), accelerations=np.cos(TIMES), **ABOUT)
    axis, spin = np.asarray(AXIS) / np.linalg.norm(AXIS), cross_matrix(AXIS) / np.linalg.norm(AXIS)
    for motion, rate in ((table.start(), 0.5), (table.segments()[-1].motion(7.0), 0.5 + np.sin(2.0))):
        np.testing.assert_allclose(motion.angular_velocity, rate * axis, rtol=1e-14)
        assert not motion.angular_acceleration.any()
        np.testing.assert_allclose(motion.origin_acceleration, -(rate**2) * spin @ spin @ ORIGIN, rtol=1e-13)
    # Within the table the point `origin` accelerates on its own.
    without = Tabulated(TIMES, 0.5 + np.sin(TIMES), **ABOUT).segments()[0].motion(1.0)
    push = table.segments()[0].motion(1.0).origin_acceleration - without.origin_acceleration
    np.testing.assert_allclose(push, np.cos(1.0) * axis, rtol=1e-12)


def test_base_acceleration_is_switched_pulsed_and_cut_off():
    def push(maneuver, time):
        part = next(part for part in maneuver.segments() if part.start <= time < part.end)
        motion = part.motion(time)
        assert not motion.angular_velocity.any()
        return motion.origin_acceleration

    direction = np.array([0.0, 0.6, 0.8])
    options = {"axis": (0.0, 3.0, 4.0)}
    np.testing.assert_allclose(push(BaseAcceleration(2.0, **options), 1e6), 2.0 * direction)
    switched = BaseAcceleration(2.0, 0.5, **options)
    np.testing.assert_allclose(push(switched, 0.49), 2.0 * direction)
    assert not push(switched, 0.5).any()
    pulse = BaseAcceleration(2.0, 0.5, "half-sine", **options)
    np.testing.assert_allclose(push(pulse, 0.25), 2.0 * direction)
    np.testing.assert_allclose(push(pulse, 0.05), 2.0 * np.sin(0.1 * np.pi) * direction)
    assert not push(pulse, 0.7).any()
    cut = BaseAcceleration(2.0, profile="cut-off", **options)
    np.testing.assert_allclose(cut.start().origin_acceleration, 2.0 * direction)
    assert not push(cut, 0.0).any()


def test_sequence_has_the_limits_and_motions_of_its_steps():
    slew, stop = Slew(0.4, 1.0, "bang-bang"), Stop(0.6, 0.5)
    whole = Sequence((slew, SpinUp(0.6, 2.0), stop), (0.25, 1.5))
    limits = [(part.start, part.end) for part in whole.segments()]
    expected = [(0, 0.5), (0.5, 1), (1, 1.25), (1.25, 3.25), (3.25, 4.75), (4.75, 5.25), (5.25, np.inf)]
    np.testing.assert_allclose(limits, expected, rtol=1e-14)
    for part, source, time in ((0, slew.segments()[0], 0.2), (1, slew.segments()[1], 0.7)):
        assert whole.segments()[part].motion(time).angular_velocity[0] == source.motion(time).angular_velocity[0]
    braking = whole.segments()[5].motion(4.75 + 0.2)
    assert braking.angular_velocity[0] == pytest.approx(0.6 * 0.6, rel=1e-12)
    assert whole.segments()[4].motion(4.0).angular_velocity[0] == 0.6
    nested = Sequence((Sequence((slew,)), SpinUp(0.6, 2.0)), (0.25,))
    assert [part.start for part in nested.segments()] == [0.0, 0.5, 1.0, 1.25, 3.25]


def residual_vibration(slew, frequency: float, ratio: float) -> float:
    """Amplitude |int exp(s (T - t)) theta'' dt| that a mode with pole s keeps after a slew, by Gauss's rule."""
    root = 2.0 * np.pi * frequency
    pole = root * complex(-ratio, np.sqrt(1.0 - ratio**2))
    points, weights = np.polynomial.legendre.leggauss(48)
    total = 0.0j
    for piece in stretches(slew):
        half = 0.5 * (piece.end - piece.start)
        for point, weight in zip(points, weights, strict=True):
            time = piece.start + half * (1.0 + point)
            total += half * weight * piece.values(time)[2] * np.exp(pole * (slew.duration - time))
    return abs(total)


@pytest.mark.parametrize("ratio", [0.0, 0.05])
@pytest.mark.parametrize("base", ["bang-bang", "versine", "minimum-jerk"])
@pytest.mark.parametrize(("shaper", "order"), [("ZV", 1), ("ZVD", 2)])
def test_shaped_slews_leave_their_mode_at_rest(shaper, order, base, ratio, verification_row):
    """Zero at the design frequency; nearby it grows with the first (ZV) or second (ZVD) power of the distance."""
    design, duration = 1.3, 1.7
    options = {"frequency": design, "damping_ratio": ratio, "shaper": shaper, "base": base}
    shaped = Slew(0.5, duration, "input-shaped", **options)
    plain = residual_vibration(Slew(0.5, duration - shaper_impulses(shaper, design, ratio)[-1][1], base), design, ratio)
    left = residual_vibration(shaped, design, ratio)
    assert plain > 0.05
    assert left < 1e-12 * plain
    near = [residual_vibration(shaped, design * (1.0 + off), ratio) for off in (4e-3, 2e-3, 1e-3)]
    assert observed_order(near)[-1] == pytest.approx(order, abs=0.03)
    if base == "bang-bang" and ratio > 0.0:
        words = f"{shaper} on bang-bang, damping {ratio:g}"
        verification_row(f"{words}: vibration left at the design frequency, of unshaped", 0.0, left / plain, "none")
        verification_row(f"{words}: order of what is left beside it", order, observed_order(near)[-1], SHAPING)


def test_shaper_impulses_are_the_published_ones():
    """Undamped ZV: (1/2, 1/2) half a period apart; ZVD: (1, 2, 1)/4; damped: K = exp(-pi z/sqrt(1 - z^2))."""
    np.testing.assert_allclose(shaper_impulses("ZV", 2.0), [(0.5, 0.0), (0.5, 0.25)])
    np.testing.assert_allclose(shaper_impulses("ZVD", 2.0), [(0.25, 0.0), (0.5, 0.25), (0.25, 0.5)])
    decay, half = np.exp(-np.pi * 0.1 / np.sqrt(0.99)), 0.25 / np.sqrt(0.99)
    np.testing.assert_allclose(
        shaper_impulses("ZV", 2.0, 0.1), [(1.0 / (1.0 + decay), 0.0), (decay / (1.0 + decay), half)], rtol=1e-14
    )


def test_coinciding_limits_of_a_shaped_slew_are_one():
    """Bang-bang of one period under ZV at the same frequency: its middle and the second copy's start coincide."""
    slew = Slew(0.3, 1.5, "input-shaped", frequency=1.0, shaper="ZV")
    starts = [part.start for part in slew.segments()]
    np.testing.assert_allclose(starts, [0.0, 0.5, 1.0, 1.5], atol=1e-12)
    assert turned_angle(slew) == pytest.approx(0.3, abs=1e-12)


@pytest.mark.parametrize("name", MANEUVERS)
@pytest.mark.parametrize("origin", [ORIGIN, (0.0, 0.0, 0.0)])
def test_many_instants_are_what_each_is_alone(name, origin):
    maneuver = MANEUVERS[name]
    if isinstance(maneuver, FixedAxis):
        maneuver = replace(maneuver, origin=origin)
    for segment in maneuver.segments():
        times = segment.start + np.linspace(0.0, 1.1, 67) * (min(segment.end, 3.0) - segment.start)
        np.testing.assert_array_equal(segment.rows(times), [segment.motion(time).row for time in times.tolist()])
