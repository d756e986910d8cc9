"""The film with tautflex: ``film_tautflex.py PROBLEM.npz RESULT.npz [METHOD [ACCURACY]]`` (files: see film_problem.py).

Steps are the problem's, or chosen for this tolerance of `tf.Adaptive`; METHOD is a name in `METHODS`.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from film_files import film_result

import tautflex as tf

METHODS = {
    "newmark": tf.Newmark,
    "wilson": tf.WilsonTheta,
    "generalized-alpha": tf.GeneralizedAlpha,
    "bathe": tf.Bathe,
    "condensed-difference": tf.CondensedDifference,
}


def run(problem: dict[str, np.ndarray], method: str = "newmark", accuracy: str | None = None) -> dict[str, np.ndarray]:
    """Record of the probe and what it cost."""
    began = time.process_time()
    section = tf.MembraneSection(
        tf.Material(float(problem["young"]), float(problem["density"]), float(problem["poisson"])),
        float(problem["thickness"]),
        "green-lagrange",
    )
    model = tf.Model.from_mesh(
        problem["nodes"],
        triangles=problem["triangles"],
        membrane=section,
        membrane_stress=problem["stress"],
        supports=[tf.Support.pinned(problem["fixed"])],
    )
    state = tf.solve_prestress(model)
    step, count = float(problem["step"]), int(problem["count"])
    options = {
        "method": METHODS[method](),
        "adaptive": accuracy and tf.Adaptive(float(accuracy)),
        "time_step": step,
        "initial_velocity": problem["velocity"],
        "tolerance": float(problem["tolerance"]),
        "every": int(problem["every"]),
        "probes": {"probe": problem["nodes"][int(problem["probe"])]},
        "probe_reading": "nearest-node",
    }
    # The first steps compile or load the kernels, those of single steps and those of many.
    tf.simulate(state, end_time=min(50, count) * step, **options)
    ready = time.process_time()
    clock = [(0.0, 0.0)]
    result = tf.simulate(
        state,
        end_time=count * step,
        progress=lambda done, _: clock.append((round(done * count), time.process_time() - ready)),
        **options,
    )
    seconds = time.process_time() - ready
    at = result.data.sel(probe="probe")
    stats = result.stats
    clock[-1] = count, seconds
    return film_result(
        np.stack([at.u.values, at.v.values, at.w.values], axis=1),
        clock,
        ready - began,
        version=tf.__version__,
        solver="its default direct solver, factors kept while they serve",
        iterations=stats.iterations,
        factorizations=stats.factorizations,
    )


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1])), *sys.argv[3:]))
