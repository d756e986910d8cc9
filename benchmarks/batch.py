"""Throughput of batches of a reduced model against a loop over single runs: same method, step, length and record.

Run ``python benchmarks/batch.py`` (extra ``batch``). Prints one JSON line and a table: simulated seconds per second for
batch sizes 1 to 4096, on the processor and, if JAX sees one, on the GPU, whose results must equal the processor's to
1e-9. The loop is timed before and after the batches of each row; the ratio is what counts.
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
from step_cost import antenna

import tautflex as tf

PROBE = {"A": (0.7036, 0.4267)}


def parameters(runs: int) -> dict[str, Any]:
    """Rates, durations, tensions and damping of the runs; the first run is the same for every number of runs."""
    share = np.arange(runs) / max(4096, runs)
    return {
        "maneuver.rate": 0.2 + 0.4 * share,
        "maneuver.duration": 0.5 + 0.5 * share,
        "tension_x": 1.0 + 0.2 * share,
        "damping.beta": 1e-3 * (1.0 + share),
    }


def loop_seconds(rom: tf.ReducedModel, options: dict[str, Any], repeats: int = 3) -> float:
    """Time of one single run [s], the best of a few; the loop over runs does nothing else."""
    maneuver, best = tf.Stop(0.2, 0.5), np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        rom.simulate(maneuver, damping=tf.Rayleigh(1e-3, 1e-3), **options)
        best = min(best, time.perf_counter() - began)
    return best


def batch_seconds(batch: tf.Batch, runs: int, options: dict[str, Any]) -> tuple[float, xr.Dataset, float]:
    """Time of a batch [s], its result, and the time of the first call, compilation included [s]."""
    elapsed = []
    for _ in range(2):
        began = time.perf_counter()
        data = batch.simulate(parameters(runs), tf.Stop(0.2, 0.5), damping=tf.Rayleigh(1e-3, 1e-3), **options)
        elapsed.append(time.perf_counter() - began)
    return elapsed[1], data, elapsed[0]


def rows(rom: tf.ReducedModel, sizes: list[int], options: dict[str, Any]) -> list[dict[str, Any]]:
    """One row per device and batch size."""
    devices = [jax.devices("cpu")[0], *[d for d in jax.devices() if d.platform != "cpu"][:1]]
    simulated, found = float(options["end_time"]), []
    loop_seconds(rom, options)
    reference: dict[int, Any] = {}
    for device in devices:
        with jax.default_device(device):
            batch = tf.Batch(rom)
            for size in sizes:
                before = loop_seconds(rom, options)
                seconds, data, first = batch_seconds(batch, size, options)
                single = min(before, loop_seconds(rom, options))
                w = data.w.values
                reference.setdefault(size, w)
                scale = float(np.abs(reference[size]).max())
                found.append(
                    {
                        "device": device.platform,
                        "runs": size,
                        "simulated_seconds_per_second": size * simulated / seconds,
                        "ratio_to_loop": size * single / seconds,
                        "loop_simulated_seconds_per_second": simulated / single,
                        "first_call_seconds": first,
                        "difference_to_smallest_batch": float(np.abs(w[0] - reference[sizes[0]][0]).max() / scale),
                        "difference_to_cpu": float(np.abs(w - reference[size]).max() / scale),
                    }
                )
                print(json.dumps(found[-1]), file=sys.stderr, flush=True)  # long runs show how far they are
                if device.platform != "cpu" and found[-1]["difference_to_cpu"] > 1e-9:
                    raise SystemExit(f"results of {device.platform} differ by {found[-1]['difference_to_cpu']:.1e}")
    return found


def main() -> None:
    """Print one JSON line and a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[1, 16, 64, 256, 1024, 4096], help="batch sizes")
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time [s]")
    parser.add_argument("--divisions", type=int, nargs=2, default=(20, 10), help="mesh")
    arguments = parser.parse_args()
    state = tf.solve_prestress(antenna("M2", tuple(arguments.divisions)))
    rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))
    options = {
        "method": tf.Newmark(),
        "time_step": 1e-3,
        "end_time": arguments.seconds,
        "probes": PROBE,
        "tolerance": 1e-6,
    }
    found = rows(rom, arguments.sizes, options)
    about = {"machine": platform.machine(), "cores": os.cpu_count(), "jax": jax.__version__, "coordinates": rom.size}
    print(json.dumps({**about, "rows": found}))
    print(f"\n{'device':8s}{'runs':>6s}{'sim s/s':>12s}{'to loop':>9s}{'first [s]':>11s}{'to CPU':>10s}")
    for row in found:
        print(
            f"{row['device']:8s}{row['runs']:6d}{row['simulated_seconds_per_second']:12.1f}{row['ratio_to_loop']:9.1f}"
            f"{row['first_call_seconds']:11.1f}{row['difference_to_cpu']:10.1e}"
        )


if __name__ == "__main__":
    main()
