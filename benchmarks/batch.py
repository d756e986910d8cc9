"""Throughput of batches of a reduced model against a loop over single runs: same method, step, length and record.

Run ``python benchmarks/batch.py`` (extra ``batch``; about five minutes on two idle cores). Prints one JSON line and a
table: simulated seconds per second, for the 20 x 10 antenna with few coordinates and the 40 x 20 one with seventeen, by
Newmark at 1 ms and by central differences at 5 ms, runs of 2 s and 10 s; on the processor and, if JAX sees one, on the
GPU, whose results must equal the processor's to 1e-9. The loop is timed before and after each row at its best: the
same reduced model, warm, probes only, again and again the run that costs least. In the batch every run has its own
rate, duration, tension and damping. The first run of every batch is that of the loop: central differences must agree
to 1e-9, an implicit method to its tolerance, and to 1e-9 in a run with a tight one.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from typing import Any

import jax
import numpy as np
import xarray as xr
from reduced import prestressed
from step_cost import antenna

import tautflex as tf

PROBE = {"A": (0.7036, 0.4267)}
STOP, DAMPING = tf.Stop(0.2, 0.5), tf.Rayleigh(1e-3, 1e-3)
# Batches that take longer [s] are timed once.
_LONG = 5.0
METHODS = {"newmark": (tf.Newmark(), 1e-3), "central-difference": (tf.CentralDifference(), 5e-3)}


def model(name: str) -> tf.ReducedModel:
    """Reduced models of the two antennas."""
    if name == "20x10":
        return tf.reduce(tf.solve_prestress(antenna("M2", (20, 10))), tf.ModalBasis(directions=("rx",)))
    _, state = prestressed("40x20, equilibrium", "M2")
    return tf.reduce(state, tf.ModalBasis(("rx",), count=16, candidates=130))


def parameters(runs: int) -> dict[str, Any]:
    """Rates, durations, tensions and damping of the runs; the first is the run of the loop."""
    share = np.arange(runs) / runs
    return {
        "maneuver.rate": STOP.rate + 0.4 * share,
        "maneuver.duration": STOP.duration + 0.5 * share,
        "tension_x": 1.0 + 0.2 * share,
        # Less than that of the loop: more would be too much for central differences in the hardest of these stops.
        "damping.beta": DAMPING.beta * (1.0 - 0.5 * share),
    }


def single(rom: tf.ReducedModel, options: dict[str, Any], repeats: int = 5) -> tuple[float, Any]:
    """Time of one single run [s], the best of a few, and its record at the probe."""
    best, run = np.inf, None
    for _ in range(repeats):
        began = time.perf_counter()
        run = tf.simulate(rom, STOP, damping=DAMPING, **options)
        best = min(best, time.perf_counter() - began)
    return best, run.data.w.values


def together(batch: tf.Batch, runs: int, options: dict[str, Any]) -> tuple[float, xr.Dataset, float]:
    """Time of a batch [s], the best of two unless one is long, its result, and the time of the first call [s]."""
    elapsed = list[float]()
    while len(elapsed) < 2 or (len(elapsed) < 3 and elapsed[-1] < _LONG):
        began = time.perf_counter()
        data = batch.simulate(parameters(runs), STOP, damping=DAMPING, store=("displacement",), **options)
        elapsed.append(time.perf_counter() - began)
    return min(elapsed[1:]), data, elapsed[0]


def difference(one: Any, other: Any) -> float:
    """Largest difference over the largest value."""
    return float(np.abs(one - other).max() / np.abs(other).max())


def check_tight(batch: tf.Batch, rom: tf.ReducedModel, options: dict[str, Any]) -> float:
    """Difference of batch and single run with a tight tolerance; SystemExit above 1e-9."""
    tight = {**options, "end_time": 1.0, "tolerance": 1e-12}
    data = batch.simulate(parameters(2), STOP, damping=DAMPING, store=("displacement",), **tight)
    found = difference(data.w.values[0], single(rom, tight, 1)[1])
    if not found < 1e-9:
        raise SystemExit(f"batch and single run differ by {found:.1e}")
    return found


def measure(
    name: str, rom: tf.ReducedModel, method: str, step: float, seconds: float, sizes: list[int]
) -> list[dict[str, Any]]:
    """One row per device and batch size."""
    options = {"method": METHODS[method][0], "time_step": step, "end_time": seconds, "probes": PROBE}
    devices = [jax.devices("cpu")[0], *[d for d in jax.devices() if d.platform != "cpu"][:1]]
    rows, reference = [], dict[int, Any]()
    single(rom, options, 1)
    for device in devices:
        with jax.default_device(device):
            batch = tf.Batch(rom)
            tight = check_tight(batch, rom, options) if method == "newmark" else None
            for size in sizes:
                before, _ = single(rom, options)
                elapsed, data, first = together(batch, size, options)
                after, record = single(rom, options)
                loop, w = min(before, after), data.w.values
                agreed = difference(w[0], record)
                if method == "central-difference" and not agreed < 1e-9:
                    raise SystemExit(f"batch and single run differ by {agreed:.1e}")
                off = difference(w, reference.setdefault(size, w))
                rows.append(
                    {
                        "model": name,
                        "coordinates": rom.size,
                        "method": method,
                        "step": step,
                        "seconds": seconds,
                        "device": device.platform,
                        "runs": size,
                        "batch_simulated_seconds_per_second": size * seconds / elapsed,
                        "loop_simulated_seconds_per_second": seconds / loop,
                        "ratio": size * loop / elapsed,
                        "difference": agreed,
                        "difference_tight": tight,
                        "difference_to_cpu": off,
                        "first_call_seconds": first,
                    }
                )
                print(json.dumps(rows[-1]), file=sys.stderr, flush=True)  # long runs show how far they are
                if off > 1e-9:
                    raise SystemExit(f"results of {device.platform} differ by {off:.1e}")
    return rows


def main() -> None:
    """Print one JSON line and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[256], help="batch sizes")
    parser.add_argument("--seconds", type=float, nargs="+", default=[2.0, 10.0], help="simulated times [s]")
    parser.add_argument("--method", choices=list(METHODS), nargs="+", default=list(METHODS))
    parser.add_argument("--step", type=float, help="time step [s]; default: 1e-3 and 5e-3")
    parser.add_argument("--model", choices=("20x10", "40x20"), nargs="+", default=["20x10", "40x20"])
    arguments = parser.parse_args()
    found = []
    for name in arguments.model:
        rom = model(name)
        for method in arguments.method:
            for seconds in arguments.seconds:
                step = arguments.step or METHODS[method][1]
                found += measure(name, rom, method, step, seconds, arguments.sizes)
    about = {"machine": platform.machine(), "cores": os.cpu_count(), "jax": jax.__version__}
    print(json.dumps({**about, "rows": found}))
    print(
        "\n| antenna | coordinates | method | length [s] | device | runs | batch, sim s/s | loop, sim s/s | ratio |",
        end="",
    )
    print(" difference | first call [s] |\n|" + "---|" * 11)
    for row in found:
        print(
            f"| {row['model']} | {row['coordinates']} | {row['method']}, {1e3 * row['step']:g} ms | "
            f"{row['seconds']:g} | {row['device']} | {row['runs']} | {row['batch_simulated_seconds_per_second']:.0f} | "
            f"{row['loop_simulated_seconds_per_second']:.0f} | {row['ratio']:.1f} | {row['difference']:.0e} | "
            f"{row['first_call_seconds']:.0f} |"
        )


if __name__ == "__main__":
    main()
