"""
Turning so that nothing rings
=============================

Slews by 10 degrees from rest to rest in the same time. Bang-bang needs the least torque and is the loudest; shaped for
the loudest mode (ZVD), each pulse is split so that its parts cancel.
"""

import math

import tautflex as tf
from tautflex.case import parse_case, template

state = tf.solve_prestress(tf.build_model(parse_case(template("control"))))
rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))


def turned(slew: tf.Slew) -> tf.Run:
    """The run of a slew on the reduced model."""
    return tf.simulate(
        rom,
        slew,
        method=tf.CentralDifference(),
        time_step=5e-3,
        end_time=8.0,
        damping=tf.Rayleigh(0.001, 0.001),
        probes={"A": (0.7036, 0.4267)},
    )


# %%
# Listen to the bang-bang turn first, then shape for what was heard.
turn = {"angle": math.radians(10.0), "duration": 3.0, "axis": (1.0, 0.0, 0.0)}
runs = {name: turned(tf.Slew(**turn, profile=name)) for name in ("bang-bang", "versine")}
heard = tf.dominant_frequency(runs["bang-bang"].data.w.sel(probe="A"), after=3.0).frequency
shaped = tf.Slew(**turn, profile="input-shaped", frequency=heard, shaper="ZVD", base="bang-bang")
runs["ZVD"] = turned(shaped)
print(f"shaped for {heard:.2f} Hz")
record = tf.plot.plot_time_history(runs)

# %%
# What is left when the slew is over.
for name, run in runs.items():
    left = run.data.w.sel(probe="A", time=slice(tf.maneuver_end(run), None))
    print(f"{name}: {1e6 * float(abs(left).max()):.1f} µm, over after {tf.maneuver_end(run):.2f} s")
