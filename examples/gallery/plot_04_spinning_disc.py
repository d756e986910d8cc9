r"""
A spinning disc of film
=======================

Film without any stiffness but what its spin gives it: the frequencies of a free disc are fixed multiples of the spin
rate, :math:`(\omega/\Omega)^2 = [s(s+2)(3+\nu) - m^2(1+3\nu)]/8` with m nodal diameters and n circles, s = m + 2n
[Lamb & Southwell 1921].
"""

import matplotlib.pyplot as plt
import numpy as np

import tautflex as tf
from tautflex.plot.style import styled

RINGS, DENSITY, THICKNESS, POISSON = 12, 1000.0, 1e-3, 0.3
points = [(0.0, 0.0)]
triangles = [(0, 1 + k, 1 + (k + 1) % 6) for k in range(6)]
for ring in range(1, RINGS + 1):
    points += [(ring / RINGS * np.cos(a), ring / RINGS * np.sin(a)) for a in np.pi / 3 * np.arange(6 * ring) / ring]
for ring in range(2, RINGS + 1):
    inner, outer = 1 + 3 * (ring - 1) * (ring - 2), 1 + 3 * ring * (ring - 1)
    for k in range(6 * ring):
        side, place = divmod(k, ring)
        below = inner + (side * (ring - 1) + place) % (6 * (ring - 1))
        triangles.append((outer + k, outer + (k + 1) % (6 * ring), below))
        if place:
            before = inner + (side * (ring - 1) + place - 1) % (6 * (ring - 1))
            triangles.append((outer + k, below, before))
nodes = np.pad(np.array(points), ((0, 0), (0, 1)))

# %%
# The centre is held in the plane, one node of the rim against turning; a spring far softer than the spin holds it.
rim = int(np.argmax(nodes[:, 0]))
mass = DENSITY * THICKNESS * np.pi
model = tf.Model.from_mesh(
    nodes,
    triangles=triangles,
    membrane=tf.MembraneSection(tf.Material(1e9, DENSITY, POISSON), THICKNESS, "green-lagrange"),
    membrane_stress=(4e-5, 4e-5, 0.0),
    springs=(tf.Spring((0,), (0.0, 0.0, 1e-6 * mass)),),
    supports=(tf.Support((0,), ("x", "y")), tf.Support((rim,), ("y",))),
)
state = tf.solve_prestress(model)
rates = np.array([0.5, 1.0, 1.5])
table = tf.campbell(state, rates, axis=(0.0, 0.0, 1.0), n=8)


# %%
# Against the closed form: in the frame of the disc, where a pair of equal frequencies belongs to each m > 0.
def factor(m: int, n: int) -> float:
    """Frequency over spin rate with m nodal diameters and n circles."""
    s = m + 2 * n
    return float(np.sqrt((s * (s + 2) * (3 + POISSON) - m**2 * (1 + 3 * POISSON)) / 8))


with styled:
    figure, axes = plt.subplots(figsize=(6.0, 3.4), layout="constrained")
    for m, n in ((1, 0), (2, 0), (0, 1), (3, 0)):
        line = factor(m, n) * rates / (2 * np.pi)
        axes.plot(rates, line, color="0.6", linewidth=1)
        axes.annotate(f"m = {m}, n = {n}", (rates[-1], line[-1]), (6, 0), textcoords="offset points", va="center")
    axes.plot(rates, table.frequency, "o", markersize=4, color="#0072B2")
    axes.set(xlabel="spin rate [rad/s]", ylabel="frequency in the disc's frame [Hz]", xlim=(0.4, 1.85), ylim=(0, None))
