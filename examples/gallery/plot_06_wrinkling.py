r"""
Film that wrinkles
==================

A strip of film of height H is pulled by a force P and bent in its plane by a moment M. For :math:`M/PH > 1/6` a band
of :math:`b/H = 3 M/PH - 1/2` pulls no more [Stein & Hedgepeth, NASA TN D-813]. The tension-field law finds the band.
"""

import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.plot.style import styled

STRESS, THICKNESS = 1e6, 1e-4
x, y = np.meshgrid(np.linspace(0.0, 0.5, 11), np.linspace(0.0, 1.0, 41), indexing="ij")
nodes = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
at = np.arange(x.size).reshape(x.shape)
quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).reshape(-1, 4)
model = tf.Model.from_mesh(
    nodes,
    quads=quads,
    membrane=tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), THICKNESS, law="tension-field"),
    supports=(
        tf.Support((at[0, -1],), ("x", "y")),
        tf.Support((at[-1, -1],), ("y",)),
        tf.Support(tuple(at.ravel()), ("z",)),
    ),
    membrane_stress=(1.0, 1.0, 0.0),
)
state = tf.solve_prestress(model)


def forces(moment: float) -> np.ndarray:
    """Pull on the short ends that is linear above the band, and an even pull across, as forces on the nodes [N]."""
    band = max(3.0 * moment - 0.5, 0.0)
    load = np.zeros_like(nodes)
    height, weight = y[0], np.full(y.shape[1], 1.0 / (y.shape[1] - 1))
    weight[[0, -1]] /= 2.0
    pull = STRESS * THICKNESS * weight * 2.0 * np.maximum(height - band, 0.0) / (1.0 - band) ** 2
    load[at[-1], 0], load[at[0], 0] = pull, -pull
    across = np.full(x.shape[0], STRESS * THICKNESS * 0.05)
    across[[0, -1]] /= 2.0
    load[at[:, -1], 1], load[at[:, 0], 1] = across, -across
    return load


# %%
# The stress along the strip over its height, for three moments; lines are the closed form.
with styled:
    figure, axes = plt.subplots(figsize=(6.0, 3.6), layout="constrained")
    for moment, colour in zip((0.2, 0.3, 0.4), ("#0072B2", "#D55E00", "#009E73"), strict=True):
        q = tf.solve_static(state, forces=forces(moment))
        stress = state.system.stress(q)[0][:, 0].reshape(10, 40, 4)[5].mean(axis=1) / STRESS
        middle, band = 0.5 * (y[0, 1:] + y[0, :-1]), 3.0 * moment - 0.5
        axes.plot(stress, middle, ".", color=colour, label=f"M/PH = {moment}")
        axes.plot(2.0 * np.maximum(middle - band, 0.0) / (1.0 - band) ** 2, middle, color=colour, linewidth=0.8)
    axes.set(xlabel="stress along the strip / mean stress", ylabel="height y / H")
    axes.legend()
