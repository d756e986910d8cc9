"""The spin-up with tautflex: ``spinup_tautflex.py PROBLEM.npz RESULT.npz [STRAIN]`` (files: see spinup_problem.py)."""

from __future__ import annotations

import json
import sys
import time

import numpy as np
from spinup_problem import median_of_three

import tautflex as tf

WARM = 50


def beam(problem: dict[str, np.ndarray], strain: str) -> tf.PrestressedState:
    """Beam in equilibrium, clamped at its first node, free to move in the plane z = 0."""
    length, elements = float(problem["length"]), int(problem["elements"])
    # Unit area, so that Young's modulus and density are EA and rho A.
    inertia = float(problem["bending_stiffness"] / problem["axial_stiffness"])
    section = tf.BeamSection(
        tf.Material(float(problem["axial_stiffness"]), float(problem["mass_per_length"]), 0.3),
        1.0,
        inertia,
        inertia,
        2.0 * inertia,
        strain,
    )
    nodes = np.zeros((elements + 1, 3))
    nodes[:, 0] = np.linspace(0.0, length, elements + 1)
    model = tf.Model.from_mesh(
        nodes,
        beams=np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        beam=section,
        # The motion is plane, as the other code's beam.
        supports=[tf.Support.clamped(0), tf.Support(tuple(range(elements + 1)), ("z", "rx", "ry"))],
    )
    return tf.solve_prestress(model)


def march(
    problem: dict[str, np.ndarray], motion: object, strain: str, began: float
) -> tuple[tf.Run, dict[str, np.ndarray]]:
    """Run, record of the tip in the hub's frame and what it cost; set-up counts from ``began`` [s]."""
    step = float(problem["step"])
    state = beam(problem, strain)
    options = {
        "method": tf.GeneralizedAlpha(float(problem["spectral_radius"])),
        "time_step": step,
        "tolerance": 1e-6,  # Exudyn's; on a free hub ours would be 1e-9
        "probes": {"tip": (float(problem["length"]), 0.0, 0.0)},
    }
    # The first steps compile or load the kernels, those of single steps and those of many.
    tf.simulate(state, motion, end_time=WARM * step, **options)
    ready = time.process_time()
    results = []

    def timed() -> float:
        start = time.process_time()
        results.append(tf.simulate(state, motion, end_time=float(problem["end"]), **options))
        return time.process_time() - start

    seconds, result = median_of_three(timed), results[0]
    tip = result.data.sel(probe="tip")
    details = {
        "version": tf.__version__,
        "element": f"{strain} beam in the hub's frame",
        "iterations": result.stats.iterations,
    }
    return result, {
        "time": tip.time.values,
        "extension": tip.u.values,
        "lag": tip.v.values,
        "seconds": np.array(seconds),
        "set_up_seconds": np.array(ready - began),
        "details": np.array(json.dumps(details)),
    }


def run(problem: dict[str, np.ndarray], strain: str = "von-karman") -> dict[str, np.ndarray]:
    """Record of the tip and what it cost."""
    began = time.process_time()
    maneuver = tf.SpinUp(float(problem["rate"]), float(problem["duration"]), axis=(0.0, 0.0, 1.0))
    return march(problem, maneuver, strain, began)[1]


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1])), *sys.argv[3:]))
