"""Cost of one step of an antenna on a free hub beside one under the same motion prescribed.

Run ``python benchmarks/hub_cost.py``. Both runs slow the spin down with the same torque history: on a heavy hub the
motions agree, so that steps do. Pairs alternate, processor times of whole runs (recording included) are divided by
their steps, and the medians of the ratios are what counts.
"""

from __future__ import annotations

import argparse
import json
import time

import numpy as np
from step_cost import antenna

import tautflex as tf

RATE, DURATION, INERTIA = 0.2, 0.1, 1e4


def seconds_per_step(state, motion, method, tolerance: float, steps: int) -> tuple[float, dict[str, int]]:
    """Processor time of a step [s], and what the run did."""
    began = time.process_time()
    run = tf.simulate(
        state,
        motion,
        method=method,
        time_step=1e-3,
        end_time=steps * 1e-3,
        damping=tf.Rayleigh(0.001, 0.001),
        tolerance=tolerance,
    )
    spent = time.process_time() - began
    stats = run.stats
    return spent / steps, {"iterations": stats.iterations, "factorizations": stats.factorizations}


def measure(divisions: tuple[int, int], method, tolerance: float, pairs: int, steps: int) -> dict[str, object]:
    """Pairs of runs, the first of which only compiles."""
    state = tf.solve_prestress(antenna("M2", divisions))
    hub = tf.FreeHub(
        1e4,
        (INERTIA, INERTIA, INERTIA),
        angular_velocity=(RATE, 0.0, 0.0),
        torque=(-RATE / DURATION * INERTIA, 0.0, 0.0),
    )
    motions = {"prescribed": tf.Stop(RATE, DURATION), "hub": hub}
    times: dict[str, list[float]] = {name: [] for name in motions}
    work: dict[str, dict[str, int]] = {}
    for pair in range(pairs + 1):
        for name, motion in motions.items():
            spent, work[name] = seconds_per_step(state, motion, method, tolerance, steps)
            if pair:
                times[name].append(spent)
    ratio = np.array(times["hub"]) / np.array(times["prescribed"])
    return {
        "unknowns": state.system.size,
        "method": method.name,
        "tolerance": tolerance,
        "milliseconds": {name: round(1e3 * float(np.median(values)), 3) for name, values in times.items()},
        "ratio": round(float(np.median(ratio)), 2),
        "ratio_quartiles": [round(float(x), 2) for x in np.percentile(ratio, (25, 75))],
        "work": work,
    }


def main() -> None:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--pairs", type=int, default=9, help="pairs of runs (9)")
    parser.add_argument("--steps", type=int, default=100, help="steps of a run (100)")
    asked = parser.parse_args()
    methods = (tf.Newmark(), 1e-9), (tf.WilsonTheta(), 1e-6), (tf.GeneralizedAlpha(), 1e-6)
    results = [
        measure(divisions, method, tolerance, asked.pairs, asked.steps)
        for divisions in ((10, 5), (20, 10))
        for method, tolerance in methods
    ]
    if asked.json:
        print(json.dumps(results, indent=2))
        return
    print("unknowns  method                            tolerance  prescribed  free hub  ratio  (quartiles)")
    for row in results:
        low, high = row["ratio_quartiles"]
        took = row["milliseconds"]
        print(
            f"{row['unknowns']:8d}  {row['method']:32s}  {row['tolerance']:9.0e}  {took['prescribed']:7.3f} ms  "
            f"{took['hub']:5.3f} ms  {row['ratio']:5.2f}  ({low:.2f} to {high:.2f})"
        )


if __name__ == "__main__":
    main()
