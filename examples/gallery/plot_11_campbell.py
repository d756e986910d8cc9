"""
Frequencies of the spinning antenna
===================================

The antenna spins about z: centrifugal stress raises its frequencies, Coriolis forces split and turn the shapes. Where a
branch meets a multiple of the spin, anything that is fixed in space excites it.
"""

import numpy as np

import tautflex as tf
from tautflex.case import parse_case, template

state = tf.solve_prestress(tf.build_model(parse_case(template("m2-nearest-node"))))
table = tf.campbell(state, np.linspace(0.0, 6.0, 13), axis=(0.0, 0.0, 1.0), n=6)
figure = tf.plot.plot_campbell(table)
