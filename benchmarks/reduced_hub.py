"""Steps per second of reduced models on a free hub, compiled stepping alone.

Run ``python benchmarks/reduced_hub.py``. Two antennas (8 coordinates of 20 x 10 cells, 17 of 40 x 20), a hub that turns
about x and one that is free, central differences at 5 ms and Newmark's method at 1 ms. Processor times, medians.
"""

from __future__ import annotations

import time

import numpy as np
from batch import model

import tautflex as tf
from tautflex.reduction.marching.free_hub import hub_implicit, hub_steps
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.marching.work import stage_numbers
from tautflex.solvers.transient.problem import TransientProblem

METHODS = ((tf.CentralDifference(), 5e-3), (tf.Newmark(), 1e-3))


def steps_per_second(
    rom: tf.ReducedModel, axes: str, method, step: float, steps: int = 2000, repeats: int = 5
) -> float:
    """Median over the repeats; one more before them compiles."""
    hub = tf.FreeHub(20.0, (5.0, 5.0, 8.0), axes=axes, torque=(0.02, 0.0, 0.0))
    question = {"time_step": step, "end_time": 1.0, "method": method, "damping": tf.Rayleigh(1e-3, 1e-3)}
    run = HubRun(rom, TransientProblem.asked(rom, hub, question))
    run.start()
    stages, inputs = stage_numbers(run._method, step), run.inputs_at(np.zeros(1), np.inf)
    nowhere, none = np.full(steps, -1), np.empty((0, 3, rom.size))
    kept = run.eta, run.rate, run.rigid, run.outside
    times = []
    for _ in range(repeats + 1):
        began = time.process_time()
        if isinstance(method, tf.CentralDifference):
            hub_steps.march_explicit(run.arrays, run.hub, inputs, step, run._work, run.ride, nowhere, kept, none)
        else:
            parts = run._work, run.ride, nowhere, kept, 1e-9, none
            hub_implicit.march(run.arrays, run.hub, inputs, inputs, stages, *parts)
        times.append(time.process_time() - began)
    return steps / float(np.median(times[1:]))


def main() -> None:
    """Print a table."""
    print("| coordinates | hub | method | steps per second |\n|---|---|---|---|")
    for name in ("20x10", "40x20"):
        rom = model(name)
        for axes in ("x", "free"):
            for method, step in METHODS:
                speed = steps_per_second(rom, axes, method, step)
                print(f"| {rom.size} | {axes} | {method.name}, {1e3 * step:g} ms | {speed:.0f} |", flush=True)


if __name__ == "__main__":
    main()
