r"""
Which element
=============

The lowest frequency of a film that is held at its edges, against
:math:`f = \frac12\sqrt{(\sigma/\rho)(1/a^2 + 1/b^2)}`: order 2 for the three-node triangle and the four-node
quadrilateral, order 4 for the six-node triangle.
"""

import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.case import parse_case
from tautflex.plot.style import styled

CASE = """schema = 1

[membrane]
length = 2.0
width = 1.0
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 3e4
stress_y = 3e4

[mesh]
element = "{element}"
divisions = [{along}, {across}]
"""
exact = 0.5 * np.sqrt(3e4 / 1530.0 * (1 / 2.0**2 + 1 / 1.0**2))


def error(element: str, cells: int) -> float:
    """Relative error of the lowest frequency with so many cells across."""
    case = parse_case(CASE.format(element=element, along=2 * cells, across=cells))
    modes = tf.solve_modes(tf.solve_prestress(tf.build_model(case)), n=1)
    return abs(float(modes.frequencies[0]) / exact - 1.0)


# %%
# The error over the width of a cell.
cells = np.array([4, 8, 16])
with styled:
    figure, axes = plt.subplots(figsize=(6.0, 3.6), layout="constrained")
    for element, mark in (("triangle3", "^"), ("quad4", "s"), ("triangle6", "o")):
        errors = [error(element, int(count)) for count in cells]
        order = np.log2(errors[-2] / errors[-1])
        axes.loglog(1.0 / cells, errors, f"-{mark}", label=f"{element}, order {order:.1f}")
    axes.set(xlabel="width of a cell / width of the film", ylabel="error of the lowest frequency")
    axes.legend()
