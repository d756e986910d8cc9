"""The free hub with tautflex: ``hub_tautflex.py PROBLEM.npz RESULT.npz [STRAIN]`` (files: see hub_problem.py)."""

from __future__ import annotations

import math
import sys
import time

import numpy as np
from spinup_tautflex import march

import tautflex as tf


def run(problem: dict[str, np.ndarray], strain: str = "corotational") -> dict[str, np.ndarray]:
    """Record of the tip and of the hub, and what they cost."""
    began = time.process_time()
    inertia, duration, size = (float(problem[name]) for name in ("inertia", "duration", "torque"))

    def torque(now: float, state: tf.HubState) -> tuple[float, float, float]:
        return 0.0, 0.0, size * (1.0 - math.cos(2.0 * math.pi * now / duration)) if now < duration else 0.0

    hub = tf.FreeHub(1.0, (inertia, inertia, inertia), torque=torque, breaks=(duration,), axes="z")
    result, record = march(problem, hub, strain, began)
    scalar, *_, axial = result.data.attitude.values.T
    return record | {"angle": 2.0 * np.unwrap(np.arctan2(axial, scalar))}


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1])), *sys.argv[3:]))
