"""
Damping by tension
==================

Cables that a drive pulls do not push a flat film; they change its stiffness. A law that tightens while the film moves
out and eases while it moves back takes energy from every mode that it knows. The antenna stops; then it is on its own,
or under the law.
"""

import math

import tautflex as tf
from tautflex.case import parse_case, template

bare = tf.solve_prestress(tf.build_model(parse_case(template("m2-nearest-node"))))
pull = tf.TensionGroup("y", None, command="tension")
state = tf.equip(bare, [pull])
rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))
actuators = {"pull": tf.Actuator(pull, limit=0.3)}
sensors = {"modes": tf.ModalCoordinates(4)}
stop = tf.Stop(rate=math.pi / 50, duration=0.5)
damping = tf.Rayleigh(0.001, 0.001)

runs = {}
for name, law in (("at rest", lambda time, y: [0.0]), ("tension damping", tf.TensionDamping(commands=("pull",), limit=0.3, modes=4))):
    plant = tf.Plant(rom, None, actuators, sensors, interval=0.01, damping=damping, maneuver=stop)
    runs[name] = tf.close_loop(plant, law, end_time=6.0)

# %%
record = tf.plot.plot_surface(runs["tension damping"])

# %%
loop = tf.plot.plot_loop(runs["tension damping"])
