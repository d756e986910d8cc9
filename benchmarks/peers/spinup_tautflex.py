"""The spin-up with tautflex: ``spinup_tautflex.py PROBLEM.npz RESULT.npz [STRAIN]`` (files: see spinup_problem.py)."""

from __future__ import annotations

import json
import sys
import time

import numpy as np

import tautflex as tf


def run(problem: dict[str, np.ndarray], strain: str = "von-karman") -> dict[str, np.ndarray]:
    """Record of the tip and what it cost."""
    began = time.process_time()
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
    state = tf.solve_prestress(model)
    step = float(problem["step"])
    maneuver = tf.SpinUp(float(problem["rate"]), float(problem["duration"]), axis=(0.0, 0.0, 1.0))
    options = {
        "method": tf.GeneralizedAlpha(float(problem["spectral_radius"])),
        "time_step": step,
        "probes": {"tip": (length, 0.0, 0.0)},
    }
    # The first steps compile or load the kernels.
    tf.simulate(state, maneuver, end_time=2 * step, **options)
    ready = time.process_time()
    result = tf.simulate(state, maneuver, end_time=float(problem["end"]), **options)
    seconds = time.process_time() - ready
    tip = result.data.sel(probe="tip")
    details = {
        "version": tf.__version__,
        "element": f"{strain} beam in the hub's frame",
        "iterations": result.stats.iterations,
    }
    return {
        "time": tip.time.values,
        "extension": tip.u.values,
        "lag": tip.v.values,
        "seconds": np.array(seconds),
        "set_up_seconds": np.array(ready - began),
        "details": np.array(json.dumps(details)),
    }


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1])), *sys.argv[3:]))
