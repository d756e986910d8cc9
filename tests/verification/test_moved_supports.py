"""Supports that move in time, by a course or by drives of finite stiffness, against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tautflex as tf
from tautflex import Damper, PointMass, Spring, Support, SupportMotion, TimeTable
from tautflex.case import parse_case
from tautflex.case.advice import advise
from verification.builders import FILM_CASE

LENGTH, TENSION, DENSITY, CELLS = 2.0, 50.0, 1000.0, 32
RATE, AMPLITUDE = 90.0, 1e-3


def moved_end(time: np.ndarray) -> np.ndarray:
    return 0.5 * AMPLITUDE * (1.0 - np.cos(RATE * time))


def exact(place: float, time: np.ndarray) -> np.ndarray:
    """String at rest whose end moves by s(t): ``x s/L`` and modes that ``-s'' x/L`` drives."""
    wave, found = np.sqrt(TENSION / (DENSITY * 1e-6)), place / LENGTH * moved_end(time)
    for n in range(1, 400):
        own = n * np.pi * wave / LENGTH
        share = 2.0 * (-1.0) ** (n + 1) / (n * np.pi)
        drive = -share * 0.5 * AMPLITUDE * RATE**2 / (own**2 - RATE**2)
        found = found + drive * (np.cos(RATE * time) - np.cos(own * time)) * np.sin(n * np.pi * place / LENGTH)
    return found


def string(stiffness: float) -> tf.PrestressedState:
    """Taut string along x whose last node a drive holds across it."""
    nodes = np.column_stack([np.linspace(0.0, LENGTH, CELLS + 1), np.zeros((CELLS + 1, 2))])
    rope = tf.CableSection(tf.Material(1e10, DENSITY), 1e-6)
    model = tf.Model.from_mesh(
        nodes,
        cables=[(k, k + 1) for k in range(CELLS)],
        cable=rope,
        cable_tension=TENSION,
        supports=[Support.pinned([0]), Support((CELLS,), ("x", "y"))],
        springs=[Spring((CELLS,), (0.0, 0.0, stiffness))],
        prestress_mode="uniform",
    )
    return tf.solve_prestress(model)


def test_string_with_a_moved_end(verification_row: Any) -> None:
    """A drive of stiffness k lags by what it pulls over k; the rest is the string of the closed form."""
    end, place, lags = 0.04, 1.25, []
    for stiffness in (1e4, 1e5):
        state = string(stiffness)

        def push(time: float, stiffness: float = stiffness) -> float:
            return stiffness * float(moved_end(np.array(time)))

        drive = tf.NodalForce([CELLS], push, direction=(0.0, 0.0, 1.0))
        probes = {"A": (place, 0.0, 0.0), "end": (LENGTH, 0.0, 0.0)}
        run = tf.simulate(
            state, inputs=[drive], time_step=1e-4, end_time=end, probes=probes, method=tf.Newmark(), tolerance=1e-10
        )
        time = run.data.time.values
        lags.append(np.abs(run.data.w.sel(probe="end").values - moved_end(time)).max())
        assert run.status.value == "completed"
        assert abs(run.energy_balance["residual"]) < 1e-8 * run.energy_balance["loads"]
    assert lags[0] / lags[1] > 9.0
    assert lags[1] < 1e-2 * AMPLITUDE
    wanted = exact(place, time)
    found = run.data.w.sel(probe="A").values
    error = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    assert error < 1e-2
    verification_row(
        "string with a moved end, drive of 1e5 N/m: error of the motion", 0, error, "d'Alembert, 400 modes"
    )


def ends_held() -> tf.PrestressedState:
    """The same string with both ends held."""
    nodes = np.column_stack([np.linspace(0.0, LENGTH, CELLS + 1), np.zeros((CELLS + 1, 2))])
    rope = tf.CableSection(tf.Material(1e10, DENSITY), 1e-6)
    links = [(k, k + 1) for k in range(CELLS)]
    supports = [Support.pinned([0, CELLS])]
    given = {"cables": links, "cable": rope, "cable_tension": TENSION, "supports": supports}
    return tf.solve_prestress(tf.Model.from_mesh(nodes, prestress_mode="uniform", **given))


def swing(time: float) -> np.ndarray:
    """`moved_end` with its rates."""
    angle = RATE * time
    return 0.5 * AMPLITUDE * np.array([1.0 - np.cos(angle), RATE * np.sin(angle), RATE**2 * np.cos(angle)])


@pytest.mark.parametrize(
    "method", [tf.Newmark(), tf.EnergyConserving(), tf.Bathe(), tf.GeneralizedAlpha(), tf.CentralDifference()]
)
def test_string_whose_support_moves(method: Any, verification_row: Any) -> None:
    """The support is where it shall be to the last bit, and the string where d'Alembert has it."""
    explicit = isinstance(method, tf.CentralDifference)
    given = {
        "method": method,
        "time_step": 1e-5 if explicit else 1e-4,
        "end_time": 0.04,
        "every": 10 if explicit else 1,
    }
    probes = {"A": (1.25, 0.0, 0.0), "end": (LENGTH, 0.0, 0.0)}
    drive = SupportMotion([CELLS], (0.0, 0.0, 2.0), swing)
    run = tf.simulate(ends_held(), inputs=[drive], probes=probes, fields=[0.04], tolerance=1e-10, **given)
    time, balance = run.data.time.values, run.energy_balance
    assert np.array_equal(run.data.w.sel(probe="end").values, [swing(float(t))[0] for t in time])
    assert np.array_equal(run.data.w_velocity.sel(probe="end").values, [swing(float(t))[1] for t in time])
    assert float(run.data.displacement.values[-1, CELLS, 2]) == swing(float(time[-1]))[0]
    wanted = exact(1.25, time)
    error = float(np.abs(run.data.w.sel(probe="A").values - wanted).max() / np.abs(wanted).max())
    assert error < 1e-3
    assert abs(balance["residual"]) < 1e-8 * balance["loads"]
    assert abs(balance["method"]) < 1e-3 * balance["loads"]
    verification_row(
        f"string whose support moves, {run.data.attrs['method']}: error", 0, error, "d'Alembert, 400 modes"
    )


def test_work_of_a_moved_support() -> None:
    """The force that the closed form of the string puts on its end times the velocity of the end."""
    run = tf.simulate(
        ends_held(), inputs=[SupportMotion([CELLS], (0.0, 0.0, 1.0), swing)], time_step=5e-5, end_time=0.04,
        probes={"A": (1.25, 0.0, 0.0)}, method=tf.Newmark(), tolerance=1e-10,
    )  # fmt: skip
    time, small = np.linspace(0.0, 0.04, 4001), 1e-3
    pull = TENSION * (moved_end(time) - exact(LENGTH - small, time)) / small
    power = pull * np.array([swing(float(t))[1] for t in time])
    work = np.trapezoid(power, time)
    assert run.energy_balance["loads"] + run.energy_balance["maneuver"] == pytest.approx(work, rel=5e-3)


def oscillator(dampers: Any = ()) -> tf.PrestressedState:
    """2 kg at node 1 on a spring of 50 N/m along z from node 0, which a support holds."""
    rope = tf.CableSection(tf.Material(1e-6, 1e-9), 1e-9)
    model = tf.Model.from_mesh(
        [(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)], cables=[(0, 1)], cable=rope, cable_tension=1e-12,
        masses=[PointMass(1, 2.0)], supports=[Support.pinned([0]), Support((1,), ("x", "y"))],
        springs=[Spring((0, 1), (0.0, 0.0, 50.0))],
        dampers=dampers, prestress_mode="uniform",
    )  # fmt: skip
    return tf.solve_prestress(model)


@pytest.mark.parametrize(
    ("damping", "dampers", "relative", "absolute"),
    [
        (None, [Damper((0, 1), (0.0, 0.0, 1.5))], 1.5, 0.0),
        (None, [Damper((1,), (0.0, 0.0, 1.5))], 0.0, 1.5),
        (tf.Rayleigh(0.0, 0.03), [], 1.5, 0.0),
        (tf.Rayleigh(0.75, 0.0), [], 0.0, 1.5),
        (tf.Modal(0.075, modes=1), [], 1.5, 0.0),
    ],
)
def test_oscillator_on_a_moved_base(damping: Any, dampers: Any, relative: float, absolute: float) -> None:
    """``m x'' + c_a x' + c_r (x - s)' + k (x - s) = 0`` from rest, s an acceleration that stays (closed form)."""
    mass, stiffness, base = 2.0, 50.0, 0.8
    run = tf.simulate(
        oscillator(dampers), inputs=[SupportMotion([0], (0.0, 0.0, 1.0), base, "acceleration")], damping=damping,
        time_step=1e-3, end_time=2.0, probes={"A": (0.5, 0.0, 0.0)}, method=tf.Newmark(), tolerance=1e-12,
    )  # fmt: skip
    time, total = run.data.time.values, relative + absolute
    # y = x - s: m y'' + c y' + k y = -m b - c_a b t, whose particular solution is straight in t.
    slope = -absolute * base / stiffness
    level = (-mass * base - total * slope) / stiffness
    decay, natural = total / (2.0 * mass), np.sqrt(stiffness / mass)
    own = np.sqrt(natural**2 - decay**2)
    first = -level
    second = (decay * first - slope) / own
    y = level + slope * time + np.exp(-decay * time) * (first * np.cos(own * time) + second * np.sin(own * time))
    assert run.data.w.values[:, 0] == pytest.approx(y + 0.5 * base * time**2, abs=2e-6)
    speed = np.gradient(y, time, edge_order=2)
    lost = np.trapezoid(relative * speed**2 + absolute * (speed + base * time) ** 2, time)
    balance = run.energy_balance
    assert balance["damping"] == pytest.approx(lost, rel=1e-4)
    assert abs(balance["residual"]) < 1e-9 * balance["kinetic"]
    assert balance["kinetic"] == pytest.approx(0.5 * mass * run.data.w_velocity.values[-1, 0] ** 2, rel=1e-9)


def held_film(**given: Any) -> tf.PrestressedState:
    """Slack film that sags a lot, Green-Lagrange, corners held."""
    film = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4, "green-lagrange")
    places = np.linspace(-0.5, 0.5, 5)
    nodes = np.array([(x, y, 0.0) for y in places for x in places])
    quads = [(k, k + 1, k + 6, k + 5) for j in range(4) for k in range(5 * j, 5 * j + 4)]
    rim = np.flatnonzero(np.abs(nodes).max(axis=1) > 0.49)
    return tf.solve_prestress(
        tf.Model.from_mesh(
            nodes, quads=quads, membrane=film, membrane_stress=(1e5, 1e5, 0.0), supports=[Support.pinned(rim)],
            prestress_mode="uniform", **given,
        )
    )  # fmt: skip


def test_supports_that_move_together_are_a_frame_that_moves(verification_row: Any) -> None:
    """All supports by one course, or the floating frame by its acceleration: one motion, however far it goes."""
    state, direction = held_film(), np.array([0.6, 0.0, 0.8])
    rim = state.model.supports[0].nodes
    push, length = 60.0, 0.03
    pulse = TimeTable([0.0, length, length], [push, push, 0.0])
    given = {
        "time_step": 2e-4, "end_time": 0.05, "probes": {"A": (0.1, 0.2)}, "tolerance": 1e-12, "method": tf.Newmark(),
        "damping": tf.Rayleigh(0.0, 1e-4),
    }  # fmt: skip
    moved = tf.simulate(state, inputs=[SupportMotion(rim, direction, pulse, "acceleration")], **given)
    frame = tf.simulate(state, tf.BaseAcceleration(push, length, axis=tuple(direction)), **given)
    course = SupportMotion(rim, direction, pulse, "acceleration").prepare(state.system).course
    went = np.array([course(float(t))[0] for t in moved.data.time.values])
    found = np.stack([moved.data[name].values[:, 0] for name in "uvw"], axis=1) - went[:, None] * direction
    wanted = np.stack([frame.data[name].values[:, 0] for name in "uvw"], axis=1)
    error = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    assert np.abs(went).max() > 0.02
    assert np.abs(wanted).max() > 2e-3
    assert error < 1e-8
    assert moved.data.min_principal_resultant.values == pytest.approx(
        frame.data.min_principal_resultant.values, rel=1e-6
    )
    for name in ("kinetic", "strain", "damping"):
        assert moved.energy_balance[name] == pytest.approx(frame.energy_balance[name], rel=1e-6)
    assert moved.data.surface_rms.values == pytest.approx(frame.data.surface_rms.values, rel=1e-6, abs=1e-12)
    verification_row("supports that move together: motion against that of a moved frame", 0, error, "change of frame")


@pytest.mark.parametrize(
    ("table", "quantity", "wanted"),
    [
        (TimeTable([0.0, 2.0], [0.0, 6.0]), "velocity", {1.0: (1.5, 3.0, 3.0), 3.0: (12.0, 6.0, 0.0)}),
        (TimeTable([1.0, 2.0], [0.0, 6.0]), "velocity", {0.5: (0.0, 0.0, 0.0), 2.0: (3.0, 6.0, 0.0)}),
        (TimeTable([0.0, 1.0], [0.0, 6.0]), "acceleration", {1.0: (1.0, 3.0, 6.0), 2.0: (7.0, 9.0, 6.0)}),
        (TimeTable([0.0, 1.0, 1.0], [2.0, 2.0, 0.0]), "acceleration", {0.5: (0.25, 1.0, 2.0), 2.0: (3.0, 2.0, 0.0)}),
        # The only cubic that is at rest at both ends.
        (TimeTable([0.0, 2.0], [0.0, 4.0]), "displacement", {1.0: (2.0, 3.0, 0.0), 0.5: (0.625, 2.25, 3.0)}),
        (TimeTable([0.0, 2.0], [0.0, 4.0]), "displacement", {2.5: (4.0, 0.0, 0.0)}),
    ],
)
def test_courses_of_tables(table: TimeTable, quantity: str, wanted: dict[float, tuple[float, ...]]) -> None:
    """Integrals and splines by hand."""
    course = SupportMotion([CELLS], (0.0, 0.0, 1.0), table, quantity).prepare(ends_held().system).course
    for time, numbers in wanted.items():
        assert course(time) == pytest.approx(numbers, abs=1e-12)


def test_moved_supports_of_a_turning_frame(verification_row: Any) -> None:
    """In a frame that turns ever faster, or the supports' own frame, whose origin has all accelerations of theirs."""
    state, end, spin, push = held_film(), 0.05, np.array([150.0, 60.0, 0.0]), np.array([20.0, 0.0, 30.0])
    rim = state.model.supports[0].nodes
    given = {"time_step": 2e-4, "end_time": end, "probes": {"A": (0.1, 0.2)}, "tolerance": 1e-12}
    given |= {"method": tf.Newmark(), "damping": tf.Rayleigh(0.0, 1e-4)}
    strength = float(np.linalg.norm(push))
    drive = SupportMotion(rim, push, strength, "acceleration")
    times = np.linspace(0.0, end, 101)
    moved = tf.simulate(state, tf.Tabulated([0.0, end], [np.zeros(3), spin * end]), inputs=[drive], **given)
    rates, course, speed = times[:, None] * spin, 0.5 * times[:, None] ** 2 * push, times[:, None] * push
    pushed = push + 2.0 * np.cross(rates, speed) + np.cross(spin, course) + np.cross(rates, np.cross(rates, course))
    own = tf.simulate(state, tf.Tabulated(times, rates, accelerations=pushed), **given)
    found = np.stack([moved.data[name].values[:, 0] for name in "uvw"], axis=1)
    found -= 0.5 * moved.data.time.values[:, None] ** 2 * push
    wanted = np.stack([own.data[name].values[:, 0] for name in "uvw"], axis=1)
    error = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    assert error < 1e-6
    assert moved.energy_balance["kinetic"] == pytest.approx(own.energy_balance["kinetic"], rel=1e-6)
    assert abs(moved.energy_balance["residual"]) < 1e-9 * moved.energy_balance["kinetic"]
    verification_row("moved supports of a turning frame: motion against that of their own", 0, error, "change of frame")


def test_course_goes_on_where_a_run_was_cut() -> None:
    drive = SupportMotion([CELLS], (0.0, 0.0, 1.0), TimeTable([0.0, 0.01, 0.03], [0.0, 0.2, -0.1]), "velocity")
    given = {"inputs": [drive], "time_step": 1e-4, "probes": {"A": (1.25, 0.0, 0.0)}, "method": tf.Newmark()}
    state = ends_held()
    whole, half = (tf.simulate(state, end_time=end, **given) for end in (0.04, 0.02))
    rest = tf.simulate(state, end_time=0.04, initial=half, **given)
    assert np.array_equal(rest.data.w.values, whole.data.w.values[201:])
    assert rest.energy_balance == whole.energy_balance


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"motion": 0.1}, "start by a jump"),
        ({"motion": TimeTable([0.0, 1.0], [0.1, 0.0])}, "at rest"),
        ({"motion": TimeTable([0.0, 1.0, 1.0, 2.0], [0.0, 0.1, 0.2, 0.3]), "quantity": "velocity"}, "without jumps"),
        ({"motion": TimeTable([-1.0, 1.0], [0.0, 0.1])}, "from t = 0 on"),
        ({"motion": lambda t: t}, "motion"),
        ({"motion": swing, "quantity": "place"}, "quantity"),
        ({"motion": swing, "direction": (0.0, 0.0, 0.0)}, "direction"),
        ({"motion": swing, "nodes": [5]}, "node 5 free along z"),
    ],
)
def test_impossible_courses_are_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(tf.InputError, match=words):
        SupportMotion(**({"nodes": [CELLS], "direction": (0.0, 0.0, 1.0)} | given)).prepare(ends_held().system)


def test_plants_that_do_not_know_moved_supports_refuse_them() -> None:
    state = held_film()
    drive = SupportMotion(state.model.supports[0].nodes, (0.0, 0.0, 1.0), swing)
    given = {"inputs": [drive], "time_step": 1e-3, "end_time": 0.01}
    with pytest.raises(tf.UnsupportedError, match="stand still on a free hub"):
        tf.simulate(state, tf.FreeHub(1.0, (1.0, 1.0, 1.0)), **given)
    with pytest.raises(tf.UnsupportedError, match="stand still on a reduced model"):
        tf.simulate(tf.reduce(state, tf.ModalBasis()), **given)
    with pytest.raises(tf.UnsupportedError, match="stand still in a plant"):
        tf.Plant(state, inputs=[drive])


def test_case_file_moves_a_side_of_the_film() -> None:
    """The held side goes as far as its velocity says, and the rest of the edge stays."""
    text = """
[inputs.shaker]
kind = "support-motion"
side = "+x"
direction = [0, 0, 1]
quantity = "velocity"
motion = { times = [0.0, 0.1, 0.2], values = [0.0, 0.01, 0.0] }
"""
    case = parse_case(FILM_CASE + text)
    assert parse_case(case.to_toml()) == case
    assert not any("nothing moves" in text for text in advise(case, tf.solve_prestress(tf.build_model(case)))[0])
    run = tf.run_case(case)
    x = run.data.node_position.values[:, 0]
    last = run.data.frame_displacement.values[-1]
    assert last[x == x.max(), 2] == pytest.approx(1e-3)
    assert np.all(last[x == x.min()] == 0.0)
    assert run.status.value == "completed"
    with pytest.raises(tf.CaseError, match="free along z"):
        tf.run_case(parse_case(FILM_CASE + text.replace('side = "+x"', "near = [0.0, 0.0]")))
