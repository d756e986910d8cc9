"""
Thermal snap
============

A spacecraft leaves the shadow. One side of the frame is lit first: its sunlit face warms within a second, it bends, and
the hub feels it.
"""

import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.plot.style import styled

case = parse_case(template("control")).replaced(frame={"support": "axis"})
state = tf.solve_prestress(tf.build_model(case))
lit = np.flatnonzero(state.model.nodes[state.model.beams].mean(axis=1)[:, 1] > 0.1)


def warming(time: float) -> tuple[float, float, float]:
    """Mean temperature [K], and gradients across the beams along y and z [K/m]."""
    share = 1.0 - np.exp(-time / 0.2)
    return 20.0 * share, 0.0, 200.0 * share


run = tf.simulate(
    state,
    tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0)),
    inputs=[tf.FrameTemperature(warming, expansion=2e-6, beams=lit)],
    method=tf.GeneralizedAlpha(),
    time_step=0.01,
    end_time=4.0,
    damping=tf.Rayleigh(0.01, 0.002),
    probes={"A": (0.7, 0.4)},
)

# %%
# What bends pushes the hub to the other side.
data = run.data
with styled:
    figure, axes = plt.subplots(2, 1, figsize=(6.0, 4.0), sharex=True, layout="constrained")
    axes[0].plot(data.time, 1e6 * data.w.sel(probe="A"), color="#D55E00")
    axes[0].set_ylabel("w at A [µm]")
    for axis, colour in zip("xyz", ("#0072B2", "#009E73", "#CC79A7"), strict=True):
        axes[1].plot(data.time, 1e6 * data.angular_velocity.sel(component=axis), color=colour, label=axis)
    axes[1].set(xlabel="time [s]", ylabel="rate of the hub [µrad/s]")
    axes[1].legend(title="about", ncols=3)
