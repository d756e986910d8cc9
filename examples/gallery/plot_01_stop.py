r"""
The stop of the antenna M2
==========================

A spacecraft that turns at :math:`\pi/5` rad/s stops within a second. The film goes on moving: the record at point A,
its spectrum beside the natural frequencies, and the deflected antenna.
"""

import math

import tautflex as tf
from tautflex.case import parse_case, template

case = parse_case(template("m2-nearest-node"))
state = tf.solve_prestress(tf.build_model(case))
modes = tf.solve_modes(state, n=10)
print(modes)

# %%
# The run, with fields at a few instants, and the record at A.
run = tf.simulate(
    state,
    tf.Stop(rate=math.pi / 5, duration=1.0),
    method=tf.GeneralizedAlpha(),
    time_step=4e-3,
    end_time=8.0,
    damping=tf.Rayleigh(0.001, 0.001),
    probes={"A": (0.7036, 0.4267)},
    fields=(0.1, 0.5, 1.0, 1.25),
)
print(f"amplitude {1e3 * tf.amplitude(run.data.w.sel(probe='A')):.3f} mm")
record = tf.plot.plot_time_history(run)

# %%
# After the stop it rings at the frequencies of a few modes.
spectrum = tf.plot.plot_spectrum(run, natural_frequencies=modes)

# %%
shapes = tf.plot.plot_shapes(run, columns=2)
