"""
The antenna in python-control
=============================

``tf.linearize`` gives labelled matrices of small motion; ``to_control()`` hands them to python-control: torque of the
wheels to attitude and to a point of the film. Needs the extra ``control``.
"""

import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.plot.style import styled

state = tf.solve_prestress(tf.build_model(parse_case(template("m2-nearest-node"))))
plant = tf.linearize(
    tf.reduce(state, tf.ModalBasis(directions=("rx",))),
    {"torque": np.eye(6)[:, 3:4]},  # the wrench of one wheel about x: force, then torque
    {"attitude": tf.Attitude(), "film": tf.Displacement((0.7, 0.4))},
    hub=tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), axes="x"),
    damping=tf.Rayleigh(1e-3, 1e-3),
)
system = plant.to_control()
print(f"{system.nstates} states, inputs {system.input_labels}, outputs {system.output_labels}")

# %%
# Frequency response by python-control.
frequency = np.geomspace(0.05, 20.0, 600)
response = system(2j * np.pi * frequency)
with styled:
    figure, axes = plt.subplots(2, 1, figsize=(6.0, 4.6), sharex=True, layout="constrained")
    for row, (axis, unit) in enumerate(zip(axes, ("attitude [rad/(N m)]", "film at A [m/(N m)]"), strict=True)):
        axis.loglog(frequency, np.abs(response[row, 0]), color=("#0072B2", "#D55E00")[row])
        axis.set_ylabel(unit)
    axes[1].set_xlabel("frequency [Hz]")
