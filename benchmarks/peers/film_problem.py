"""The fixed-edge film that every code computes, as one file of arrays.

A problem file (``.npz``) holds ``nodes`` (node, 3) [m], ``triangles`` (triangle, 3), or (triangle, 6) with the corners
first where they are quadratic, ``fixed`` (node numbers held in all three directions), ``velocity`` (node, 3) at the
start [m/s], ``stress`` (sx, sy, sxy) at the start [Pa], ``young`` [Pa], ``poisson``, ``density`` [kg/m^3],
``thickness`` [m], ``step`` [s], ``count`` of steps, ``probe`` (a node number), ``tolerance`` (residual norm over norm
of the internal forces at which an iteration may stop) and ``every`` (steps between two that tautflex stores; others
store each). Strains of quadratic triangles are taken at the three points that integrate second powers exactly; masses
are exact.

A result file (``.npz``) holds ``displacement`` (stored, 3) of the probe [m] from the start on, ``seconds`` of processor
time of the time stepping, ``set_up_seconds`` before it, ``clock`` (sample, 2): steps done and processor seconds since
the start, and ``details``, a JSON object (version, solver, iterations, factorizations).
"""

from __future__ import annotations

import numpy as np

from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.shapes import SHAPES

# Film of the paper's antenna; the tension is chosen for a first natural frequency of 1.4 Hz.
LENGTH, WIDTH, THICKNESS = 2.0, 1.0, 1e-4
YOUNG, POISSON, DENSITY = 3.5e9, 0.34, 1530.0
STRESS = (1e4, 1e4, 0.0)
# Transverse velocity of the (1, 1) and the (2, 1) shape [m/s]: a blow, and a gentle one.
BLOW, GENTLE = (0.15, 0.05), (0.02, 0.02 / 3.0)
PROBE = (0.4, 0.2)


def film_problem(
    divisions: tuple[int, int],
    step: float,
    count: int,
    tolerance: float,
    element: str = "triangle3",
    speeds: tuple[float, float] = BLOW,
    every: int = 1,
) -> dict[str, np.ndarray]:
    """Fixed-edge film of 2 m x 1 m set in motion by a blow.

    Parameters
    ----------
    divisions
        Cells along x and y; each is two triangles.
    step, count
        Step [s] and number of steps.
    tolerance
        Residual norm over norm of the internal forces at which an iteration may stop.
    element
        ``"triangle3"`` or ``"triangle6"``.
    speeds
        Transverse velocity of the (1, 1) and the (2, 1) shape at the start [m/s].
    every
        Steps between two that tautflex stores; others store each.

    Returns
    -------
    dict
        The arrays of a problem file.
    """
    lines = (np.linspace(-0.5, 0.5, n + 1) * size for n, size in zip(divisions, (LENGTH, WIDTH), strict=True))
    nodes, triangles = rectangle_mesh(*lines, shape=SHAPES[element])
    x, y = nodes[:, 0] / LENGTH, nodes[:, 1] / WIDTH
    edge = np.isclose(np.abs(x), 0.5) | np.isclose(np.abs(y), 0.5)
    velocity = np.zeros_like(nodes)
    across = np.cos(np.pi * y)
    velocity[:, 2] = speeds[0] * np.cos(np.pi * x) * across + speeds[1] * np.sin(2.0 * np.pi * x) * across
    velocity[edge] = 0.0
    inside = np.flatnonzero(~edge)
    offset = nodes[inside, :2] - PROBE
    return {
        "nodes": nodes,
        "triangles": triangles,
        "fixed": np.flatnonzero(edge),
        "velocity": velocity,
        "stress": np.array(STRESS),
        "young": np.array(YOUNG),
        "poisson": np.array(POISSON),
        "density": np.array(DENSITY),
        "thickness": np.array(THICKNESS),
        "step": np.array(step),
        "count": np.array(count),
        "probe": np.array(inside[np.argmin(np.sum(offset**2, axis=1))]),
        "tolerance": np.array(tolerance),
        "every": np.array(every),
    }
