"""Supports that move in time: drives of finite stiffness against the closed form of a string with a moved end."""

from __future__ import annotations

from typing import Any

import numpy as np

import tautflex as tf
from tautflex import Spring, Support

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
