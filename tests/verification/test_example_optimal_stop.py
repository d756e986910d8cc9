"""The example of an optimal turn, shortened."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("jax")
pytestmark = pytest.mark.jax
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def _load(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_optimal_turn_beats_bang_bang_and_input_shaping(verification_row):
    example = _load("optimal_stop")
    turn = example.Turn(watched=1.0, time_step=1e-2, knots=11)
    left, runs = example.compare(turn, iterations=15)
    energy = {name: found[0] for name, found in left.items()}
    shaped = energy["optimal spline"] / energy["input-shaped (ZVD)"]
    assert energy["input-shaped (ZVD)"] < 0.5 * energy["bang-bang"]
    assert shaped < 0.2
    spline = runs["optimal spline"].data
    rate = spline.angular_velocity.sel(component="x")
    # The limit is a penalty: half a percent above it is as far as the spline goes; the shaped turn goes further.
    assert (
        float(rate.max()) <= 1.005 * turn.largest_rate < float(runs["input-shaped (ZVD)"].data.angular_velocity.max())
    )
    assert float(np.trapezoid(rate, spline.time)) == pytest.approx(turn.angle, rel=1e-3)
    verification_row(
        "residual energy of an optimal turn over that of ZVD input shaping, full model",
        "< 0.2",
        f"{shaped:.2g}",
        "example",
    )
