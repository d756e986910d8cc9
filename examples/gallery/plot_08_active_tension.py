"""
Damping by tension
==================

Cables that a drive pulls do not push a flat film; they change its stiffness. A law that tightens while the film moves
out and eases while it moves back takes energy from every mode that it knows. The antenna stops, and is on its own or
under the law.
"""

import math

import matplotlib.pyplot as plt

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.plot.style import styled

# %%
# All cables along y hang on drives that change their tension, 1.1 N, by 0.3 N either way.
bare = tf.solve_prestress(tf.build_model(parse_case(template("control"))))
pull = tf.TensionGroup("y", None, command="tension")
rom = tf.reduce(tf.equip(bare, [pull]), tf.ModalBasis(directions=("rx",)))
laws = {
    "on its own": lambda time, measurement: [0.0],
    "tension damping": tf.TensionDamping(commands=("pull",), limit=0.3, modes=6),
}
runs = {}
for name, law in laws.items():
    plant = tf.Plant(
        rom,
        actuators={"pull": tf.Actuator(pull, limit=0.3, lag=0.02)},
        sensors={"modes": tf.ModalCoordinates(6)},
        interval=0.01,
        time_step=2.5e-3,
        method=tf.Bathe(),
        damping=tf.Rayleigh(0.001, 0.001),
        maneuver=tf.Stop(rate=math.pi / 5, duration=1.0),
    )
    runs[name] = tf.close_loop(plant, law, end_time=6.0)

# %%
with styled:
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(6.0, 4.2), sharex=True, layout="constrained")
    for name, run in runs.items():
        top.semilogy(run.data.time, 1e6 * run.data.surface_rms, label=name)
    top.set(ylabel="rms of the film [µm]", ylim=(1.0, None))
    top.legend()
    bottom.step(run.data.sample_time, run.data.command[:, 0], where="post", color="#D55E00")
    bottom.set(xlabel="time [s]", ylabel="change of tension [N]", xlim=(0.0, 6.0))
    for axes in (top, bottom):
        axes.axvspan(0.0, 1.0, color="#eeeeee", zorder=0)

# %%
for name, run in runs.items():
    print(f"{name}: {1e6 * float(run.data.surface_rms.sel(time=slice(5.0, 6.0)).mean()):.1f} µm in the last second")
