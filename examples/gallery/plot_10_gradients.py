"""
Gradients of a batch
====================

How long should a stop take, so that nothing is left when it is over? A batch answers for many durations at once, and
gives the slope of what is left at each: enough for any optimiser. Needs the extra ``batch`` (JAX).
"""

import jax
import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.batch import residual_energy
from tautflex.case import parse_case, template
from tautflex.plot.style import styled

state = tf.solve_prestress(tf.build_model(parse_case(template("m2-nearest-node"))))
batch = tf.Batch(tf.reduce(state, tf.ModalBasis(directions=("rx",))))
respond = batch.response(
    tf.Stop(rate=0.1, duration=1.0),
    method=tf.CentralDifference(),
    time_step=5e-3,
    end_time=3.0,
    damping=tf.Rayleigh(0.001, 0.001),
    store=("energy",),
)


@jax.jit
@jax.vmap
@jax.value_and_grad
def left(duration):
    """Energy that is left after the stop [J], and its slope over the duration."""
    return residual_energy(respond({"maneuver.duration": duration}))


durations = np.linspace(0.5, 2.5, 61)
energy, slope = left(durations)

# %%
# Short strokes are tangents, from the gradient, not from neighbours.
with styled:
    figure, axes = plt.subplots(figsize=(6.0, 3.4), layout="constrained")
    axes.semilogy(durations, energy, color="#0072B2")
    for k in range(0, len(durations), 5):
        ends = durations[k] + np.array([-0.06, 0.06])
        axes.semilogy(
            ends, energy[k] * np.exp(slope[k] / energy[k] * (ends - durations[k])), color="#D55E00", linewidth=2
        )
    axes.set(xlabel="duration of the stop [s]", ylabel="energy left [J]")
