"""
A free spacecraft
=================

The antenna is clamped to a hub that nobody holds. Wheels push it one way and then the other; the film pulls back, and
momentum and energy are accounted for.
"""

import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.plot.style import styled

state = tf.solve_prestress(tf.build_model(parse_case(template("m2-nearest-node"))))
hub = tf.FreeHub(
    mass=50.0,
    inertia=(5.0, 5.0, 8.0),
    torque=lambda time, _: (2.0 * (time < 0.5) - 2.0 * (0.5 <= time < 1.0), 0.0, 0.0),
    breaks=(0.5, 1.0),
    axes="x",
)
run = tf.simulate(
    state,
    hub,
    method=tf.GeneralizedAlpha(),
    time_step=0.01,
    end_time=3.0,
    damping=tf.Rayleigh(0.001, 0.001),
    probes={"A": (0.7, 0.4)},
)
for name, value in run.energy_balance.items():
    print(f"{name:<10} {value:10.3e} J")

# %%
data = run.data
with styled:
    figure, axes = plt.subplots(3, 1, figsize=(6.0, 5.0), sharex=True, layout="constrained")
    axes[0].plot(data.time, 2.0 * np.degrees(np.arctan2(data.attitude[:, 1], data.attitude[:, 0])))
    axes[0].set_ylabel("angle [deg]")
    axes[1].plot(data.time, data.angular_velocity.sel(component="x"), color="#D55E00")
    axes[1].set_ylabel("rate [rad/s]")
    axes[2].plot(data.time, 1e3 * data.w.sel(probe="A"), color="#009E73")
    axes[2].set(xlabel="time [s]", ylabel="w at A [mm]")
