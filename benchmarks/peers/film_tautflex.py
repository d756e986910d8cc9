"""The film with tautflex: ``film_tautflex.py PROBLEM.npz RESULT.npz`` (files: see film_problem.py)."""

from __future__ import annotations

import json
import sys
import time

import numpy as np

import tautflex as tf


def run(problem: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
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
        "method": tf.Newmark(),
        "time_step": step,
        "initial_velocity": problem["velocity"],
        "tolerance": float(problem["tolerance"]),
        "probes": {"probe": problem["nodes"][int(problem["probe"])]},
        "probe_reading": "nearest-node",
    }
    # The first steps compile or load the kernels.
    tf.simulate(state, end_time=2 * step, **options)
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
    details = {
        "version": tf.__version__,
        "solver": "its default direct solver, factors kept while they serve",
        "iterations": stats.iterations,
        "factorizations": stats.factorizations,
    }
    return {
        "displacement": np.stack([at.u.values, at.v.values, at.w.values], axis=1),
        "seconds": np.array(seconds),
        "set_up_seconds": np.array(ready - began),
        "clock": np.array(clock),
        "details": np.array(json.dumps(details)),
    }


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1]))))
