"""Reduced models on stops of the paper's M2 and M3, in equilibrium on a 20 x 10 mesh, against the full model."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case, template

# Cable tensions of the consistent antenna [N per 0.1 m of edge]: those of the template m2, twice the spacing.
TENSIONS = {"M2": (0.058941, 0.11), "M3": (0.30969, 0.407)}
RUN = {
    "time_step": 1e-3,
    "end_time": 4.0,
    "damping": tf.Rayleigh(0.001, 0.001),
    "probes": {"A": (0.7036, 0.4267)},
    "every": 10,
}


def antenna(model):
    case = parse_case(template("m2"))
    tension_x, tension_y = TENSIONS[model]
    cables = {"pretension_x": tension_x, "pretension_y": tension_y, "per_long_edge": 21, "per_short_edge": 11}
    return tf.solve_prestress(
        tf.build_model(case.replaced(mesh={"divisions": (20, 10)}, cables={**cables, "area": 1.57e-6}))
    )


@pytest.mark.slow
@pytest.mark.parametrize(("model", "rate", "duration"), [("M2", np.pi / 100, 0.1), ("M3", np.pi / 5, 0.1)])
def test_sixteen_modes_follow_the_full_model(model, rate, duration, verification_row):
    state = antenna(model)
    maneuver = tf.Stop(rate=rate, duration=duration)
    full = tf.simulate(state, maneuver, **RUN).data.w.sel(probe="A")
    rom = tf.reduce(state, tf.ModalBasis(("rx",), count=16, candidates=100))
    ours = tf.simulate(rom, maneuver, **RUN).data.w.sel(probe="A")
    amplitude = float(np.abs(ours).max() / np.abs(full).max())
    rms = float(np.sqrt(np.mean(ours**2) / np.mean(full**2)))
    peak, expected = (tf.dominant_frequency(record, after=duration) for record in (ours, full))
    name = f"{model}, {rate:.4g} rad/s, T = {duration:g} s, {rom.size} coordinates for {state.system.size} unknowns"
    verification_row(f"{name}: amplitude at A, reduced over full", 1.0, amplitude, "full model")
    verification_row(f"{name}: rms at A, reduced over full", 1.0, rms, "full model")
    assert amplitude == pytest.approx(1.0, abs=0.02)
    assert rms == pytest.approx(1.0, abs=0.05)
    assert abs(peak.frequency - expected.frequency) <= 0.5 * expected.bin_width
