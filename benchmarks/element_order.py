"""Error against time per step of the membrane elements, on a film thrown far beyond its thickness.

Run ``python benchmarks/element_order.py`` (a minute, docs/elements.md) or with ``--full`` (ten).
Meshes with the same nodes stand together: 40 x 20 cells of three-node triangles or quadrilaterals have the nodes of
20 x 10 cells of six-node triangles. All runs take the same steps, so that what differs is the mesh alone;
``--reference-step 5e-4`` adds what steps do.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from peers.film_problem import DENSITY, LENGTH, POISSON, THICKNESS, WIDTH, YOUNG

import tautflex as tf
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.shapes import SHAPES

RESULTANT = (0.59, 0.5)
# Transverse velocity of the (1, 1) and the (2, 1) shape; the ratio breaks the symmetry.
RATIO = (1.0, 1.0 / 3.0)
PROBE = (0.4, 0.2)


def film(element: str, divisions: tuple[int, int]) -> tf.Model:
    """Green-Lagrange film of 2 m x 1 m held all around."""
    lines = (np.linspace(-0.5, 0.5, n + 1) * size for n, size in zip(divisions, (LENGTH, WIDTH), strict=True))
    nodes, elements = rectangle_mesh(*lines, "alternating", SHAPES[element])
    edge = np.isclose(np.abs(nodes[:, 0]), LENGTH / 2) | np.isclose(np.abs(nodes[:, 1]), WIDTH / 2)
    return tf.Model.from_mesh(
        nodes,
        membrane=tf.MembraneSection(tf.Material(YOUNG, DENSITY, POISSON), THICKNESS, "green-lagrange"),
        membrane_stress=(RESULTANT[0] / THICKNESS, RESULTANT[1] / THICKNESS, 0.0),
        supports=[tf.Support.pinned(np.flatnonzero(edge))],
        **{"quads" if element == "quad4" else "triangles": elements},
    )


def thrown(element: str, divisions: tuple[int, int], speed: float, step: float, end: float) -> tuple[np.ndarray, ...]:
    """Record of the probe [m], seconds of processor time per step, back-substitutions and factorizations per step."""
    model = film(element, divisions)
    state = tf.solve_prestress(model)
    x, y = model.nodes[:, 0] / LENGTH, model.nodes[:, 1] / WIDTH
    shape = RATIO[0] * np.cos(np.pi * x) + RATIO[1] * np.sin(2.0 * np.pi * x)
    velocity = np.zeros_like(model.nodes)
    velocity[:, 2] = speed * shape * np.cos(np.pi * y)
    options = {
        "method": tf.Newmark(),
        "time_step": step,
        "initial_velocity": velocity,
        "probes": {"probe": PROBE},
    }
    tf.simulate(state, end_time=2 * step, **options)  # compiles or loads the kernels
    began = time.process_time()
    run = tf.simulate(state, end_time=end, **options)
    seconds = (time.process_time() - began) / run.stats.steps
    counts = np.array([run.stats.iterations, run.stats.factorizations]) / run.stats.steps
    return run.data.w.sel(probe="probe").values, seconds, counts


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--speed", type=float, default=0.15, help="velocity of the (1, 1) shape [m/s] (default %(default)s)"
    )
    parser.add_argument("--step", type=float, default=1e-3, help="time step [s] (default %(default)s)")
    parser.add_argument("--reference-step", type=float, help="time step of the reference [s] (default: --step)")
    parser.add_argument("--end", type=float, default=2.0, help="length of the record [s] (default %(default)s)")
    parser.add_argument("--full", action="store_true", help="meshes up to 80 x 40, reference triangle6 on 60 x 30")
    options = parser.parse_args()
    sizes = (20, 40, 80) if options.full else (20, 40)
    reference = ("triangle6", (60, 30) if options.full else (40, 20))
    rest = (options.speed, options.step, options.end)
    finer = max(round(options.step / (options.reference_step or options.step)), 1)
    converged = thrown(*reference, options.speed, options.step / finer, options.end)[0][::finer]
    print(f"largest |w| {1e3 * np.abs(converged).max():.3g} mm, {np.abs(converged).max() / THICKNESS:.3g} thicknesses")
    print(
        "| nodes | element | cells | mean error [%] | largest error [%] | ms per step | iterations | factorizations |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for n in sizes:
        for element in ("triangle3", "quad4", "triangle6"):
            cells = (n // 2, n // 4) if element == "triangle6" else (n, n // 2)
            record, seconds, counts = thrown(element, cells, *rest)
            mean = np.linalg.norm(record - converged) / np.linalg.norm(converged)
            largest = np.abs(record - converged).max() / np.abs(converged).max()
            print(
                f"| {(n + 1) * (n // 2 + 1)} | {element} | {cells[0]} x {cells[1]} | "
                f"{100 * mean:.2f} | {100 * largest:.2f} | {1e3 * seconds:.2f} | {counts[0]:.2f} | {counts[1]:.3f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
