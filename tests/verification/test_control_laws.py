"""Control laws on linear plants: textbook equations, closed forms, python-control, limits of stability."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.io import loadmat
from scipy.linalg import solve_continuous_are

from tautflex.control.actuators.drive import Drive
from tautflex.control.estimate import steady_reference
from tautflex.control.law import FunctionLaw, added, law_of
from tautflex.control.laws.imsc import IndependentModalControl
from tautflex.control.laws.lqg import LQG
from tautflex.control.laws.lqr import LQR
from tautflex.control.laws.mpc import MPC
from tautflex.control.laws.pd import PD
from tautflex.control.laws.ppf import PositivePositionFeedback
from tautflex.control.laws.shaped_reference import ShapedReference
from tautflex.control.laws.stiffness_switching import StiffnessSwitching
from tautflex.control.laws.tension_damping import TensionDamping
from tautflex.control.riccati import bryson_weights, kalman_filter, regulator
from tautflex.control.sampled import Lateness
from tautflex.control.sensors.sensor import Sensor
from tautflex.control.signals import Channel, LoopSpec, Reference
from tautflex.control.spillover import loop_matrix
from tautflex.errors import InputError
from tautflex.motion.shaping import sampled_shaper, shaper_impulses
from verification.linear_plants import modal_plant, radius, run_bilinear, spec_of

INTERVAL = 0.01
THREE = (
    [1.3, 2.1, 4.7],
    [0.002, 0.004, 0.01],
    [[1.0, 0.2], [0.5, -0.7], [-0.3, 0.4]],
    [[0.8, 0.6, -0.4], [0.1, -0.5, 0.9]],
)
TOLERANCES, EFFORTS = {"y0": 1e-3, "y1": 2e-3}, {"u0": 0.5, "u1": 0.2}
HUB = {"attitude": 1e-3, "rate": 1e-2, "y0": 1e-3}


def on_hub(**options):
    return modal_plant([1.3, 2.1], [0.002, 0.004], [[0.4], [0.3]], [[0.8, 0.6]], axes=1, inertia=5.0, **options)


@pytest.mark.parametrize("interval", [None, INTERVAL])
def test_riccati_equation_and_gains_are_those_of_python_control(interval, verification_row):
    control = pytest.importorskip("control")
    plant = modal_plant(*THREE)
    plant = plant if interval is None else plant.discretize(interval)
    q, r, n = bryson_weights(plant, TOLERANCES, EFFORTS)
    gain, x = regulator(plant, bryson_weights(plant, TOLERANCES, EFFORTS))
    a, b = plant.A, plant.B
    if interval is None:
        middle = x @ b + n
        terms = [a.T @ x, x @ a, -middle @ np.linalg.solve(r, middle.T), q]
        ours, _, _ = control.lqr(a, b, q, r, n)
    else:
        middle = a.T @ x @ b + n
        terms = [a.T @ x @ a, -x, -middle @ np.linalg.solve(r + b.T @ x @ b, middle.T), q]
        ours, _, _ = control.dlqr(a, b, q, r, n)
    residual = np.abs(np.sum(terms, axis=0)).max() / max(np.abs(term).max() for term in terms)
    verification_row(
        f"Riccati residual, {'continuous' if interval is None else 'discrete'} regulator", 0.0, residual, "relative"
    )
    assert residual < 1e-10
    np.testing.assert_allclose(gain, ours, rtol=1e-9, atol=1e-9 * np.abs(ours).max())


@pytest.mark.parametrize("interval", [None, INTERVAL])
def test_filter_is_that_of_python_control(interval):
    control = pytest.importorskip("control")
    plant = modal_plant(*THREE)
    plant = plant if interval is None else plant.discretize(interval)
    process, noise = np.diag([0.0] * 3 + [1.0, 2.0, 3.0]), np.diag([1.0, 4.0])
    gain, p = kalman_filter(plant, process, noise)
    given = control.lqe if interval is None else control.dlqe
    theirs, q, _ = given(plant.A, np.eye(6), plant.C, process, noise)
    theirs = theirs if interval is None else np.linalg.solve(noise + plant.C @ q @ plant.C.T, plant.C @ q).T
    np.testing.assert_allclose(p, q, rtol=1e-9, atol=1e-9 * np.abs(q).max())
    np.testing.assert_allclose(gain, theirs, rtol=1e-9, atol=1e-9 * np.abs(theirs).max())


def test_tiny_noise_has_its_filter():
    """Standard deviations of nanometres on slow modes, whose equation is not solved without scaling."""
    plant = modal_plant([0.9, 1.3, 1.31, 2.1], [1e-4] * 4, np.eye(4), [[0.8, 0.6, -0.4, 0.2], [0.1, -0.5, 0.9, 0.3]])
    plant = plant.discretize(INTERVAL)
    a, c, process, noise = plant.A, plant.C, np.diag([0.0] * 4 + [1e-18] * 4), np.diag([1e-18, 1e-16])
    gain, p = kalman_filter(plant, process, noise)
    residual = a @ (p - gain @ c @ p) @ a.T + process - p
    assert np.abs(residual).max() < 1e-10 * np.abs(p).max()
    assert radius(a - a @ gain @ c) < 1.0


def test_discrete_plant_is_the_simulated_one(verification_row):
    plant = on_hub()
    discrete = plant.discretize(INTERVAL)
    commands = np.random.default_rng(0).standard_normal((20, 2))
    x, y = np.zeros(6), np.zeros(6)
    for u in commands:
        found = solve_ivp(
            lambda t, z, u=u: plant.A @ z + plant.B @ u, (0.0, INTERVAL), y, method="DOP853", rtol=1e-12, atol=1e-15
        )
        x, y = discrete.A @ x + discrete.B @ u, found.y[:, -1]
    error = np.abs(x - y).max() / np.abs(y).max()
    verification_row("Zero-order hold by one matrix exponential, 20 samples", 0.0, error, "DOP853, relative")
    assert error < 1e-9


LATE = Lateness(lag=(0.03, 0.0), delay=(0.0, 2 * INTERVAL), age=(INTERVAL, 0.0, 1.6 * INTERVAL))


def test_late_plants_are_their_drives_and_sensors(verification_row):
    """Sampled matrices against drives, held commands, and sensors, one after the other."""
    plant = replace(on_hub(), D=np.array([[0.0, 0.0], [0.0, 0.0], [1e-3, 2e-3]]), late=LATE)
    sampled, bare = plant.discretize(INTERVAL), replace(plant, late=None).discretize(INTERVAL)
    assert sampled.states[6:] == (
        "torque lag 1", "torque acting 1", "u0 waiting 1", "u0 waiting 2", "u0 acting 1", "attitude past 1",
        "y0 past 1", "y0 past 2",
    )  # fmt: skip
    drives = [Drive(lag=lag, delay=delay) for lag, delay in zip(LATE.lag, LATE.delay, strict=True)]
    sensors = [Age(delay=age) for age in LATE.age]
    memories = [drive.start(1, INTERVAL) for drive in drives]
    seen = [one.start(np.zeros(1), INTERVAL, np.random.default_rng(0)) for one in sensors]
    z, x, acting, random, errors = np.zeros(len(sampled.A)), np.zeros(6), np.zeros(2), np.random.default_rng(1), []
    last = np.zeros(2)
    for _ in range(40):
        exact, readings = bare.C @ x + bare.D @ acting, np.zeros(3)
        for k, one in enumerate(sensors):
            seen[k], reading = one.observe(seen[k], exact[[k]], INTERVAL)
            readings[k] = reading[0]
        errors.append(np.abs(sampled.C @ z + sampled.D @ last - readings).max() / (1e-9 + np.abs(readings).max()))
        command = last = random.standard_normal(2)
        for k, drive in enumerate(drives):
            memories[k], value = drive.act(memories[k], command[[k]], INTERVAL)
            acting[k] = value[0]
        x, z = bare.A @ x + bare.B @ acting, sampled.A @ z + sampled.B @ command
    verification_row("Sampled plant behind drives, before late sensors", 0.0, max(errors), "drive and sensor, relative")
    assert max(errors) < 1e-9


@dataclass(frozen=True)
class Age(Sensor):
    """Sensor that is late and nothing else."""

    def prepare(self, state, hub=None):
        raise NotImplementedError


def test_filter_and_regulator_know_what_is_under_way():
    """Separation principle behind drives and late sensors; without them the same law makes the loop unstable."""
    late = Lateness((0.03, 0.03), (8 * INTERVAL,) * 2, (2 * INTERVAL,) * 3)
    plant, cost = replace(on_hub(), late=late), (HUB, {"torque": 20.0, "u0": 2.0})
    known, law = plant.discretize(INTERVAL), LQG(*cost, coordinate_noise=10.0, hub_noise=10.0)
    spec = spec_of(plant, INTERVAL, noise=1e-4)
    poles = np.abs(np.linalg.eigvals(loop_matrix(known, law.matrices(spec))))
    gain = regulator(known, bryson_weights(known, *cost)).gain
    assert poles.max() < 1.0
    expected = np.abs(np.linalg.eigvals(known.A - known.B @ gain)).max()
    assert np.min(np.abs(poles - expected)) < 1e-7
    prompt = law.matrices(replace(spec, model=replace(plant, late=None)))
    assert radius(loop_matrix(known, prompt)) > 1.0
    with pytest.raises(InputError, match=r"^interval: .*the delay of 'torque', 0\.08 s, is a multiple, got 0\.03"):
        plant.discretize(0.03)


def test_late_plants_follow_a_steady_acceleration():
    """What waits in drives and sensors has its place in the reference: the error of attitude stays zero."""
    late = Lateness((0.03, 0.0), (INTERVAL, 0.0), (0.0, 1.5 * INTERVAL, INTERVAL))
    plant, rate = replace(on_hub(), late=late), 0.02
    known, law = plant.discretize(INTERVAL), LQG(HUB, {"torque": 1.0})
    spec = spec_of(plant, INTERVAL, noise=1e-5)
    used = plant.selected(["torque"], plant.outputs)
    state, command = steady_reference(used, used.discretize(INTERVAL), True)
    numbers = np.array([0.0, 0.0, rate])
    memory, x = law.start(spec), np.zeros(len(known.A))
    x[[list(known.states).index(name) for name in used.discretize(INTERVAL).states]] = state @ numbers
    inner = memory.x.copy()
    inner[: len(state)], inner[len(state) :] = state @ numbers, command @ numbers
    memory, errors = memory._replace(x=inner), []
    last = np.array([*(command @ numbers), 0.0])
    for step in range(200):
        t = step * INTERVAL
        wanted = Reference(t, *np.array([[0.5 * rate * t**2], [rate * t], [rate]]))
        memory, u = law.act(memory, known.C @ x + known.D @ last, wanted)
        errors.append(x[0] - 0.5 * rate * t**2)
        x, last = known.A @ x + known.B @ u, u
    assert np.abs(errors).max() < 1e-9 * x[0]


def test_poles_of_the_loop_are_those_of_regulator_and_filter():
    """Separation principle, with feedthrough of the last command and a static part of modes that are left out."""
    plant = replace(on_hub(), D=np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 2e-3]]))
    spec, law = spec_of(plant, INTERVAL, noise=1e-4), LQG(HUB, {"torque": 1.0, "u0": 0.1})
    discrete = plant.discretize(INTERVAL)
    matrices = law.matrices(spec)
    gain = regulator(discrete, bryson_weights(discrete, HUB, {"torque": 1.0, "u0": 0.1})).gain
    process = np.diag([0.0] * 3 + [1e-12] * 3)
    noise = kalman_filter(discrete, process, 1e-8 * np.eye(3)).gain
    expected = [
        *np.linalg.eigvals(discrete.A - discrete.B @ gain),
        *np.linalg.eigvals(discrete.A @ (np.eye(6) - noise @ discrete.C)),
        *[0.0] * 4,  # the last command, of the plant and of the law
    ]
    poles = np.linalg.eigvals(loop_matrix(discrete, matrices))
    left = list(poles)
    for pole in expected:
        near = int(np.argmin(np.abs(np.array(left) - pole)))
        # Four of them in one place are apart by the fourth root of round-off.
        assert abs(left.pop(near) - pole) < (1e-7 if pole else 1e-3)
    assert radius(loop_matrix(discrete, matrices)) < 1.0


def test_a_law_that_does_not_know_a_mode_must_leave_it_stable():
    """A strong law of one mode drives the second one up; its loop with the plant of all modes does grow."""
    plant, efforts = on_hub(), {"torque": 1.0, "u0": 1e-2}
    spec = spec_of(plant, INTERVAL, noise=1e-6)
    growing = []
    for tolerance in (1.0, 1e-2, 1e-4, 1e-6):
        law = LQG({"attitude": tolerance, "y0": tolerance}, efforts, modes=1, coordinate_noise=1e-2)
        growing.append(radius(loop_matrix(plant.discretize(INTERVAL), law.matrices(spec))) >= 1.0)
        if growing[-1]:
            with pytest.raises(
                InputError, match=r"^modes: .*all 2 coordinates, up to 2\.1 Hz, grows .*spillover.*raise modes"
            ):
                law.start(spec)
        else:
            law.start(spec)
    assert growing[0] is False
    assert growing[-1] is True


@pytest.mark.parametrize("kind", [LQG, MPC])
def test_modes_beyond_the_whole_model_must_be_left_stable_too(kind):
    """A law that knows all of its model is tried on one with more modes, which here are driven up."""
    if kind is MPC:
        pytest.importorskip("osqp")
    plant = modal_plant([1.3, 2.1], [0.002, 0.004], [[0.4], [0.3]], [[0.8, -0.6]], axes=1, inertia=5.0)
    known = plant.truncated(1)
    cost = {"attitude": 1e-6, "y0": 1e-6}, {"torque": 1.0, "u0": 1e-2}
    law = kind(*cost, coordinate_noise=1e-2, **({"limits": {"torque": 1.0, "u0": 1.0}} if kind is MPC else {}))
    spec = spec_of(known, INTERVAL, noise=1e-6)
    law.start(spec)
    with pytest.raises(InputError, match=r"^modes: .*all 2 coordinates, up to 2\.1 Hz, grows .*spillover"):
        law.start(replace(spec, beyond=plant))


def test_modal_control_must_leave_other_modes_stable():
    """One mode of two by a sensor and an actuator apart: what the second sees of it has the wrong sign."""
    one = [[0.8], [-0.5]]
    plant = modal_plant([1.3, 2.1], [0.002, 0.004], one, [[0.8, 0.5]], velocities=True)
    for effort, unstable, told in ((0.1, True, False), (50.0, False, True), (1e6, False, False)):
        spec = spec_of(plant, INTERVAL)
        law = IndependentModalControl("y0", "y1", 1, effort)
        largest = radius(loop_matrix(plant.discretize(INTERVAL), law.matrices(spec)))
        assert (largest > 1.0) == unstable
        if unstable:
            with pytest.raises(InputError, match=r"^modes: .*IndependentModalControl whose .*spillover.*raise effort"):
                law.start(spec)
            continue
        law.start(spec)
        assert bool(spec.remarks) == told
    apart = PositivePositionFeedback(-0.3 / (0.8**2 / (2.6 * np.pi) ** 2), 1.4, "y0", "u0")
    with pytest.raises(InputError, match=r"^gain: .*spillover.*give it the sign of G\(0\)"):
        apart.start(spec_of(plant, INTERVAL))


def test_regulator_of_a_measured_state_is_the_gain():
    plant = modal_plant(*THREE[:3], np.eye(3), velocities=True)
    spec, discrete = spec_of(plant, INTERVAL), plant.discretize(INTERVAL)
    law = LQR({"eta1": 1e-3, "eta2": 1e-3, "d_eta3": 1e-2}, EFFORTS)
    gain = regulator(discrete, bryson_weights(discrete, law.tolerances, EFFORTS)).gain
    memory = law.start(spec)
    x = np.random.default_rng(1).standard_normal(6)
    _, command = law.act(memory, plant.C @ x, Reference.rest(0.0, 0))
    np.testing.assert_allclose(command, -gain @ x, rtol=1e-9)


def test_feedforward_follows_a_steady_acceleration():
    """The structure leans back as the hub accelerates, and nothing vibrates: the error of attitude stays zero."""
    plant = on_hub()
    spec = spec_of(plant, INTERVAL, noise=1e-5)
    law, discrete, rate = LQG(HUB, {"torque": 1.0}), plant.discretize(INTERVAL), 0.02
    estimate = law.start(spec)
    _, command = law.act(estimate, np.zeros(3), Reference(0.0, *np.array([[0.0], [0.0], [rate]])))
    without = LQG(HUB, {"torque": 1.0}, feedforward=False)
    _, none = without.act(without.start(spec), np.zeros(3), Reference(0.0, *np.array([[0.0], [0.0], [rate]])))
    # Rigid inertia of hub and structure is 5 kg m^2 here: what the modes carry is part of it.
    lean = np.linalg.solve(plant.A[4:, 1:3], -plant.B[4:, 0])
    torque = rate / float(plant.B[3, 0] + plant.A[3, 1:3] @ lean)
    assert torque == pytest.approx(5.0 * rate, rel=1e-9)
    assert not none.any()
    states, count, x, memory = [], 400, np.zeros(6), law.start(spec)
    x[1:3] = lean * torque
    # A filter that knows where it starts.
    inner = memory.x.copy()
    inner[:6] = x
    memory = memory._replace(x=inner)
    for step in range(count):
        t = step * INTERVAL
        wanted = Reference(t, *np.array([[0.5 * rate * t**2], [rate * t], [rate]]))
        memory, u = law.act(memory, plant.C @ x, wanted)
        states.append(x)
        x = discrete.A @ x + discrete.B @ u
    states = np.array(states)
    error = states[:, 0] - 0.5 * rate * (INTERVAL * np.arange(count)) ** 2
    assert np.abs(error).max() < 1e-9 * states[-1, 0]
    assert command[0] > torque  # from rest the lean is still to come


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.1])
def test_positive_position_feedback_at_its_limit(ratio, verification_row):
    """The limit is the inverse of the static displacement of all modes, static correction included."""
    plant = modal_plant([1.3, 2.1, 4.7], [0.002] * 3, [[0.8], [0.5], [0.3]], [[0.8, 0.5, 0.3]], through=1e-3)
    static = 1e-3 + np.sum(np.array([0.8, 0.5, 0.3]) ** 2 / np.diag(plant.stiffness))
    law = PositivePositionFeedback(ratio / static, 1.4, "y0", "u0")
    assert law.limit(plant) == pytest.approx(1.0 / static, rel=1e-12)
    blind = replace(spec_of(plant, 0.002), model=None)
    discrete = plant.discretize(0.002)
    largest = radius(loop_matrix(discrete, law.matrices(blind)))
    verification_row(
        f"PPF at {ratio} of its static limit", "stable" if ratio < 1.0 else "unstable", largest, "spectral radius"
    )
    assert (largest < 1.0) == (ratio < 1.0)
    with pytest.raises(InputError, match=r"^model: expected the plant's linear model for PositivePosition"):
        law.start(blind)
    if ratio < 1.0:
        np.testing.assert_array_equal(law.matrices(spec_of(plant, 0.002)).A, law.matrices(blind).A)
        if ratio == 0.5:
            slowest = np.abs(np.linalg.eigvals(discrete.A)).max()
            assert 1.0 - largest > 3.0 * (1.0 - slowest)  # all modes are damped more
    else:
        with pytest.raises(InputError, match=r"^gain: expected less than the static limit .*half of the limit"):
            law.start(spec_of(plant, 0.002))


@pytest.mark.parametrize(("shaper", "order"), [("ZV", 1), ("ZVD", 2)])
@pytest.mark.parametrize("interval", [0.01, 0.0137])
def test_shaped_reference_leaves_modes_at_rest(shaper, order, interval, verification_row):
    modes, ratios = [1.3, 2.17, 3.9], [0.01, 0.0, 0.03]
    taps = sampled_shaper(shaper, modes, ratios, interval)
    assert taps.sum() == pytest.approx(1.0, abs=1e-13)
    plant = modal_plant(modes, ratios, [[1.0], [0.7], [0.5]], [[1.0, 1.0, 1.0]])
    discrete, x = plant.discretize(interval), np.zeros(6)
    command, peak = np.cumsum(taps), 0.0
    for u in command:
        x = discrete.A @ x + discrete.B[:, 0] * u
        peak = max(peak, float(np.abs(plant.C @ x)[0]))
    still = np.concatenate([np.array([1.0, 0.7, 0.5]) / np.diag(plant.stiffness), np.zeros(3)])
    residual = np.abs(x - still).max() / peak
    verification_row(f"Residual of three modes behind {shaper}, {interval} s", 0.0, residual, "relative to the peak")
    assert residual < 1e-11
    # A mode that is 3 % off: the residual is of the order of the shaper's zero.
    off = np.abs(np.polyval(taps[::-1], np.exp(-2j * np.pi * 1.3 * 1.03 * interval)))
    assert off < 2.0 * (np.pi * 0.03) ** order


def test_shaper_of_whole_samples_is_the_known_one():
    frequency = 1.25  # half a period is 40 samples
    taps = sampled_shaper("ZVD", [frequency], [0.0], 0.01)
    expected = np.zeros(81)
    for amplitude, delay in shaper_impulses("ZVD", frequency):
        expected[round(delay / 0.01)] = amplitude
    np.testing.assert_allclose(taps, expected, atol=1e-12)


@pytest.mark.parametrize("law", [PD(3.0, 2.0, 5.0), LQG(HUB, {"torque": 1.0})], ids=["pd", "lqg"])
def test_matrices_of_a_shaped_law_are_the_law(law):
    spec = spec_of(on_hub(), INTERVAL, noise=1e-4)
    shaped = ShapedReference(law, "ZVD", [1.3, 2.1], [0.002, 0.004])
    total = added(shaped, PD(1.0, 0.5))
    matrices, memory = total.matrices(spec), total.start(spec)
    x, random = np.zeros(len(matrices.A)), np.random.default_rng(3)
    for step in range(60):
        y, reference = random.standard_normal(3), Reference(step * INTERVAL, *random.standard_normal((3, 1)))
        memory, command = total.act(memory, y, reference)
        z = np.concatenate([y, reference.numbers])
        np.testing.assert_allclose(matrices.C @ x + matrices.D @ z + matrices.d, command, rtol=1e-9, atol=1e-9)
        x = matrices.A @ x + matrices.B @ z + matrices.b
    if isinstance(law, PD):
        own = PD(3.0, 2.0, 5.0, "ZVD", (1.3, 2.1), (0.002, 0.004)).matrices(spec)
        for one, other in zip(own, shaped.matrices(spec), strict=True):
            np.testing.assert_array_equal(one, other)


def test_pd_on_a_rigid_hub_is_an_oscillator():
    plant = on_hub()
    law = PD(5.0, 2.0)
    matrices = law.matrices(spec_of(plant, 1e-3))
    np.testing.assert_array_equal(matrices.D, [[-5.0, -2.0, 0.0, 5.0, 2.0, 0.0], [0.0] * 6])
    three = LoopSpec((Channel("attitude", "rad", 3), Channel("rate", "rad/s", 3)), (Channel("torque", "N m"),), 1e-3, 3)
    about_y = PD(5.0, 2.0, attitude="attitude[1]", rate="rate[1]").matrices(three).D[0]
    assert {k: value for k, value in enumerate(about_y) if value} == {1: -5.0, 4: -2.0, 7: 5.0, 10: 2.0}
    with pytest.raises(InputError, match=r"^torque: expected 3, as many numbers as of attitude 'attitude', got 1"):
        law.matrices(three)
    assert radius(loop_matrix(plant.discretize(1e-3), matrices)) < 1.0


def test_modal_gains_solve_their_riccati_equations():
    plant = modal_plant([1.3, 2.1], [0.0, 0.0], [[1.0, 0.3], [0.2, -0.8]], [[0.8, 0.6], [0.5, -0.4]], velocities=True)
    spec = spec_of(plant, 1e-4)
    spec = replace(
        spec,
        measurements=(
            replace(spec.measurements[0], name="w", size=2),
            replace(spec.measurements[0], name="dw", size=2),
        ),
    )
    model = replace(plant, outputs=("w[0]", "w[1]", "dw[0]", "dw[1]"))
    law = IndependentModalControl("w", "dw", 2, effort=0.05)
    gain = law.matrices(replace(spec, model=model)).D @ plant.C
    for mode, w2 in enumerate(np.diag(plant.stiffness)):
        a, b = np.array([[0.0, 1.0], [-w2, 0.0]]), np.array([[0.0], [1.0]])
        p = solve_continuous_are(a, b, np.diag([w2, 1.0]), np.array([[0.05]]))
        row = (plant.B @ gain)[2 + mode]
        np.testing.assert_allclose(row[[mode, 2 + mode]], -(b.T @ p / 0.05)[0], rtol=1e-9)
        assert abs(row[1 - mode]) + abs(row[3 - mode]) < 1e-9 * np.abs(row).max()
    same = replace(model, C=np.concatenate([model.C[[0, 0]], model.C[2:]]))
    with pytest.raises(InputError, match=r"^displacement: expected at least 2 sensor points .*got 2 that do not"):
        law.matrices(replace(spec, model=same))


@pytest.mark.parametrize("d", [0.05, 0.1])
def test_stiffness_switching_damps_by_d_over_pi(d, verification_row):
    w2 = (2.0 * np.pi * 1.3) ** 2
    plant = modal_plant([1.3], [0.0], [[0.0]], [[1.0]], velocities=True, bilinear=[[[0.4 * w2]]])
    law = StiffnessSwitching(("u0",), d / 0.4)
    states, commands = run_bilinear(plant, law, [1e-3, 0.0], 1e-3, 6000)
    assert np.abs(commands).max() == d / 0.4
    eta = np.abs(states[:, 0])
    peaks = np.flatnonzero((eta[1:-1] > eta[:-2]) & (eta[1:-1] >= eta[2:])) + 1
    slope = np.polyfit(np.arange(len(peaks)), np.log(eta[peaks]), 1)[0]
    ratio = -slope / np.pi  # half a period from peak to peak
    verification_row(f"Damping ratio of a stiffness switched by {d}", d / np.pi, ratio, "control.md 1")
    assert ratio == pytest.approx(d / np.pi, rel=0.05)


@pytest.mark.slow
def test_tension_takes_energy_from_every_mode():
    random = np.random.default_rng(5)
    change = random.standard_normal((3, 3))
    plant = modal_plant(
        [1.3, 2.1, 4.7], [0.0] * 3, np.zeros((3, 1)), np.eye(3), velocities=True, bilinear=[10.0 * (change + change.T)]
    )
    law = TensionDamping(("u0",), 0.3, gain=2.0)
    states, commands = run_bilinear(plant, law, [1e-3, 5e-4, 2e-4, 0.0, 0.0, 0.0], 5e-4, 8000)
    energy = 0.5 * np.sum(states[:, 3:] ** 2, axis=1) + 0.5 * np.einsum(
        "ti,ij,tj->t", states[:, :3], plant.stiffness, states[:, :3]
    )
    power = np.einsum("ti,ij,tj->t", states[:, 3:], plant.bilinear[0], states[:, :3])
    assert np.all(commands[:, 0] * power >= 0.0)
    assert np.abs(commands).max() <= 0.3
    # A held command may feed a little in where the power changes its sign inside an interval.
    assert np.max(np.diff(energy)) < 1e-3 * np.max(-np.diff(energy))
    assert energy[-1] < 0.5 * energy[0]
    quiet = replace(law, floor=1e3 * energy[0])
    _, faded = run_bilinear(plant, quiet, [1e-3, 5e-4, 2e-4, 0.0, 0.0, 0.0], 5e-4, 800)
    assert np.abs(faded).max() < 5e-3 * np.abs(commands).max()


def test_predictive_control_is_the_regulator_within_limits():
    pytest.importorskip("osqp")
    plant = on_hub()
    spec, efforts = spec_of(plant, 0.02, noise=1e-4), {"torque": 1.0, "u0": 0.1}
    discrete = plant.discretize(0.02)
    free = MPC(HUB, efforts, limits={"torque": 50.0, "u0": 50.0}, horizon=15)
    tight = replace(free, limits={"torque": 0.05, "u0": 50.0})
    plain = LQG(HUB, efforts)
    memories, x = [law.start(spec) for law in (free, plain, tight)], np.zeros((3, 6))
    x[:, 0], largest = 0.01, 0.0
    for step in range(120):
        for k, law in enumerate((free, plain, tight)):
            reference = Reference(0.02 * step, *np.array([[0.02], [0.0], [0.0]]))
            memories[k], u = law.act(memories[k], plant.C @ x[k], reference)
            x[k] = discrete.A @ x[k] + discrete.B @ u
            if k == 2:
                largest = max(largest, abs(u[0]))
        np.testing.assert_allclose(x[0], x[1], atol=1e-6 * np.abs(x[1]).max())
    assert largest == pytest.approx(0.05, rel=1e-12)
    assert abs(x[2, 0] - 0.01) > 1e-3
    # The same again from the same memory.
    law, memory = tight, tight.start(spec)
    first = law.act(memory, plant.C @ x[2], reference)[1]
    law.act(first_memory := law.act(memory, plant.C @ x[2], reference)[0], plant.C @ x[2], reference)
    assert first_memory is not memory
    np.testing.assert_allclose(law.act(memory, plant.C @ x[2], reference)[1], first, atol=1e-12)


def test_truncation_keeps_the_static_answer():
    plant = on_hub()
    small = plant.truncated(1)
    assert small.states == ("theta_x", "eta1", "d_theta_x", "d_eta1")
    s = 1e-4j
    answers = [one.D + one.C @ np.linalg.solve(s * np.eye(len(one.A)) - one.A, one.B) for one in (plant, small)]
    np.testing.assert_allclose(answers[1][2], answers[0][2], rtol=1e-6)


def test_exports(tmp_path):
    control = pytest.importorskip("control")
    plant = on_hub()
    for one in (plant, plant.discretize(INTERVAL)):
        system = one.to_control()
        assert system.isctime(strict=True) == (one.interval is None)
        assert (system.input_labels, system.output_labels) == (list(one.inputs), list(one.outputs))
        np.testing.assert_array_equal(system.A, one.A)
        content = loadmat(one.to_mat(tmp_path / "plant.mat"), simplify_cells=True)
        for name in ("A", "B", "C", "D", "stiffness"):
            np.testing.assert_array_equal(content[name], getattr(one, name))
        assert content["interval"] == (one.interval or 0.0)
        assert tuple(content["outputs"]) == one.outputs
    assert isinstance(control.ss2tf(system), control.TransferFunction)
    with pytest.raises(InputError, match="path: expected a file that can be written"):
        plant.to_mat(tmp_path / "no" / "plant.mat")


def test_functions_are_laws():
    spec = spec_of(modal_plant(*THREE), INTERVAL)
    law = law_of("law", lambda time, y: time + y[0])
    _, command = law.act(law.start(spec), np.array([2.0, 0.0]), Reference.rest(1.0, 0))
    np.testing.assert_array_equal(command, [3.0, 3.0])
    both = law + (lambda time, y: [1.0, -1.0])
    np.testing.assert_array_equal(
        both.act(both.start(spec), np.array([2.0, 0.0]), Reference.rest(1.0, 0))[1], [4.0, 2.0]
    )
    assert both.matrices(spec) is None
    wrong = FunctionLaw(lambda time, y: [1.0, 2.0, 3.0])
    with pytest.raises(InputError, match=r"^command: expected shape \(2\), got \(3,\)"):
        wrong.act(wrong.start(spec), np.zeros(2), Reference.rest(0.0, 0))


def refusals():
    plain, hub = modal_plant(*THREE), on_hub()
    mute = replace(plain, B=plain.B * [1.0, 0.0], remarks={"u1": "no linear column: it changes the stiffness instead"})
    bare = replace(spec_of(plain, INTERVAL), model=None)
    yield LQG(TOLERANCES, EFFORTS), spec_of(mute, INTERVAL, 1e-4), r"^commands: .*'u1': no linear column.*leave it out"
    yield (
        LQG(TOLERANCES, EFFORTS),
        bare,
        r"^model: expected the plant's linear model for LQG, got none; give plant\.lin",
    )
    yield LQG(TOLERANCES, EFFORTS), spec_of(plain, INTERVAL), r"^measurement_noise: .*'y0'; give measurement_noise"
    blind = replace(hub, C=hub.C * [[1.0], [1.0], [0.0]])
    yield LQG({"y0": 1.0}, {"torque": 1.0}), spec_of(blind, INTERVAL, 1e-4), r"^tolerances: .*'y0', whose row .*is zero"
    seen = replace(hub, C=hub.C * [[0.0], [1.0], [1.0]])
    yield (
        LQG({"eta1": 1.0, "theta_x": 1.0}, {"torque": 1.0}),
        spec_of(seen, INTERVAL, 1e-4),
        r"^observer: expected measurements that tell .*unstable observer, perhaps for 'theta_x'; add a sensor",
    )
    yield (
        LQG({"y0": 1.0}, {"torque": 1.0}),
        spec_of(hub, INTERVAL, 1e-4),
        r"^regulator: expected tolerances that see .*'theta_x'",
    )
    yield LQG({"y9": 1.0}, EFFORTS), spec_of(plain, INTERVAL, 1e-4), r"^tolerances: expected names among 'y0'.*'y9'"
    yield LQG(TOLERANCES, {"u9": 1.0}), spec_of(plain, INTERVAL, 1e-4), r"^efforts: expected names among 'u0', 'u1'"
    yield LQR(TOLERANCES, EFFORTS), spec_of(plain, INTERVAL), r"^measurements: .*all 6 states for LQR, got 2 numbers"
    yield PD(1.0, 1.0, attitude="star"), spec_of(hub, INTERVAL), r"^attitude: expected the name of a sensor.*'star'"
    yield PD(1.0, 1.0, attitude="rate"), spec_of(hub, INTERVAL), r"^attitude: expected .* in rad, got 'rate' in rad/s"
    yield PD(1.0, 1.0, torque="u0"), spec_of(hub, INTERVAL), r"^torque: expected .* in N m, got 'u0' in N; choose"
    yield LQR({"y9": 1.0}, EFFORTS), spec_of(plain, INTERVAL, 1e-4), r"^tolerances: expected names among 'y0'.*'y9'"
    yield (
        PD(1.0, 1.0, attitude="y0", rate="y1", torque="u0"),
        spec_of(plain, INTERVAL),
        r"^attitude: .*0 axes of the hub",
    )
    yield TensionDamping(("u0",), 1.0), spec_of(plain, INTERVAL, 1e-4), r"^commands: .*change the stiffness, got 'u0'"
    yield IndependentModalControl("y0", "y1", 2), spec_of(plain, INTERVAL), r"^displacement: expected at least 2 sensor"
    yield IndependentModalControl("y0", "y0"), spec_of(hub, INTERVAL), r"^hub: .*take LQG"
    yield ShapedReference(LQG(TOLERANCES, EFFORTS), "ZV", [1.0]), spec_of(plain, INTERVAL, 1e-4), r"^shaper: .*free hub"
    yield (
        ShapedReference(PD(1.0, 1.0, torque="wheel"), "ZV", [1.0]),
        spec_of(hub, INTERVAL),
        r"^law\.torque: .*got 'wheel'",
    )
    yield MPC(TOLERANCES, EFFORTS, limits={"u0": 1.0}), spec_of(plain, INTERVAL, 1e-4), r"^limits: .*none of 'u1'"


@pytest.mark.parametrize(("law", "spec", "words"), list(refusals()))
def test_all_that_a_loop_lacks_is_told_a_line_each(law, spec, words):
    with pytest.raises(InputError, match=words) as caught:
        law.start(spec)
    assert not [problem for problem in caught.value.problems if "\n" in problem]


def test_wrong_numbers_are_refused():
    spec = spec_of(on_hub(), INTERVAL)
    law = PD(1.0, 1.0)
    with pytest.raises(InputError, match=r"^measurement: expected 6 numbers with those of the reference, got 5"):
        law.act(law.start(spec), np.zeros(2), Reference.rest(0.0, 1))
    for each in (law, law + law, law + (lambda time, y: 0.0)):
        with pytest.raises(InputError, match=r"^memory: expected what start\(spec\) of this law gave, got None"):
            each.act(None, np.zeros(3), Reference.rest(0.0, 1))
    for make, words in (
        (lambda: PD(-1.0, 1.0), "stiffness: expected a number >= 0"),
        (lambda: PD(1.0, 1.0, frequencies=(1.0,)), "frequencies: expected none with shaper = 'none'"),
        (lambda: PD(1.0, 1.0, shaper="ZV"), "frequencies: expected at least one natural frequency"),
        (lambda: ShapedReference(3.0, "ZV", [1.0]), "law: expected a control law"),
        (lambda: ShapedReference(TensionDamping(("u0",), 1.0), "ZV", [1.0]), "law: expected one that follows the ref"),
        (lambda: sampled_shaper("ZV", [80.0], [0.0], 0.01), "interval: expected less than half a period"),
        (lambda: LQG({"y0": -1.0}, EFFORTS), "tolerances.y0: expected a number > 0"),
        (lambda: StiffnessSwitching((), 1.0), "commands: expected at least one name"),
        (lambda: replace(spec, model=3), r"model: expected plant\.linearize\(\), or None, got 3"),
    ):
        with pytest.raises(InputError, match=words):
            make()
