"""Hyper-reduced models of wrinkling film against the full model: error and time by number of vectors and elements.

Run ``python benchmarks/hyper_reduced.py``. The paper's antenna M1 with the tension-field law is stopped hard, and the
fields of that run train the models; they are then compared with the full model on this maneuver and on others. Times
are processor times of one process; set OPENBLAS_NUM_THREADS=1, or idle threads of the linear algebra are counted too.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import time

import numpy as np
import xarray as xr

import tautflex as tf
from tautflex import Case, HyperReducedModel, Run, build_model
from tautflex.case import parse_case, template
from tautflex.case.build import build_maneuver
from tautflex.solvers.static.prestress import PrestressedState

# Film tension of M1 along x and y [N/m], and cable stiffness per metre of edge, as in the consistent case.
TENSION = (0.999 * 0.147, 1.10 * 0.25)
CABLE_AREA = 3.14e-6 / 0.2  # [m^2 per m of edge]
# Rate [rad/s] and duration [s] of the stops; the first one trains.
MANEUVERS = ((math.pi / 2, 0.1), (math.pi / 5, 0.1), (math.pi / 5, 1.0))
PADDED = 10.48576  # [s], record length that gives the bins of the paper's tables
# Vectors across, vectors in the plane, tolerance of the element weights.
MODELS = ((10, 8, 1e-2), (20, 15, 1e-2), (30, 30, 1e-1), (30, 30, 1e-2), (30, 30, 1e-3), (40, 60, 1e-2))


def wrinkling_antenna(divisions: tuple[int, int], rate: float, duration: float) -> Case:
    """M1 in static equilibrium with a film that cannot be compressed."""
    nx, ny = divisions
    return parse_case(
        template("m2"),
        (
            f"mesh.divisions=[{nx},{ny}]",
            f"cables.per_long_edge={nx + 1}",
            f"cables.per_short_edge={ny + 1}",
            f"cables.pretension_x={TENSION[0] * 1.0 / ny}",
            f"cables.pretension_y={TENSION[1] * 2.0 / nx}",
            f"cables.area={CABLE_AREA * 2.0 / nx}",
            "membrane.law=tension-field",
            f"maneuver.rate={rate}",
            f"maneuver.duration={duration}",
        ),
    )


def timed(
    plant: PrestressedState | HyperReducedModel, case: Case, step: float, end: float, fields: str | None = None
) -> tuple[Run, float, float]:
    """A run, and processor times [s] of the whole call and of its stepping."""
    began, clock = time.process_time(), time.perf_counter()
    run = tf.simulate(
        plant,
        build_maneuver(case),
        time_step=step,
        end_time=end,
        damping=case.damping.build(),
        probes=case.output.probes,
        probe_reading=case.output.probe_reading,
        every=5,
        fields=fields,
        throw=False,
    )
    whole = time.process_time() - began
    return run, whole, whole * run.stats.seconds / (time.perf_counter() - clock)


def compare(case: Case, full: xr.Dataset, reduced: xr.Dataset) -> dict[str, float]:
    """Errors of a reduced run."""
    w, other = full.w.sel(probe="A"), reduced.w.sel(probe="A")
    ended = case.maneuver.duration
    checked = np.isfinite(reduced.wrinkled_fraction.values)
    # Where the reduced run was checked; both are looked at at the same instants.
    wrinkled = [float(data.wrinkled_fraction.values[checked].max()) for data in (full, reduced)]
    second = full.time.values <= 1.0
    return {
        "amplitude": float(tf.amplitude(other) / tf.amplitude(w) - 1.0),
        "rms": float(np.sqrt((other**2).mean() / (w**2).mean()) - 1.0),
        "first_second": float(np.sqrt(((other - w)[second] ** 2).mean() / (w[second] ** 2).mean())),
        "frequency_full": tf.dominant_frequency(w, after=ended, length=PADDED).frequency,
        "frequency": tf.dominant_frequency(other, after=ended, length=PADDED).frequency,
        "wrinkled_full": wrinkled[0],
        "wrinkled": wrinkled[1],
        "truncated": float(reduced.truncated_energy.max()),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--divisions", type=int, nargs=2, default=(40, 20), help="cells of the film (default 40 20)")
    parser.add_argument("--step", type=float, default=2e-3, help="time step [s] (default %(default)s)")
    parser.add_argument("--end", type=float, default=10.0, help="duration of the runs [s] (default %(default)s)")
    parser.add_argument("--json", help="write all numbers to this file")
    options = parser.parse_args()
    divisions = tuple(options.divisions)
    cases = [wrinkling_antenna(divisions, *maneuver) for maneuver in MANEUVERS]
    state = tf.solve_prestress(build_model(cases[0]))
    print(f"{platform.machine()}, Python {platform.python_version()}, {state.system.size} unknowns, {divisions} cells")
    timed(state, cases[0], options.step, 10 * options.step)  # compiles
    training, *_ = timed(state, cases[0], options.step, options.end, "all")
    full, rows = [timed(state, case, options.step, options.end) for case in cases], []
    print(
        "| vectors | elements (error) | offline [s], MB | stop | amplitude | rms | w, 1st second | f (full) [Hz] | "
        "wrinkled (full) | truncated | time ratio: stepping, whole call |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for transverse, in_plane, tolerance in MODELS:
        rom = tf.hyper_reduce(state, training.data, transverse=transverse, in_plane=in_plane, tolerance=tolerance)
        timed(rom, cases[0], options.step, 10 * options.step)  # compiles
        for maneuver, case, (reference, full_whole, full_stepping) in zip(MANEUVERS, cases, full, strict=True):
            run, whole, stepping = timed(rom, case, options.step, options.end)
            e = compare(case, reference.data, run.data)
            ratios = full_stepping / stepping, full_whole / whole
            rows.append(
                {
                    "transverse": transverse, "in_plane": in_plane, "elements": rom.weights.chosen,
                    "training_error": rom.weights.residual, "offline_seconds": rom.seconds, "bytes": rom.memory,
                    "rate": maneuver[0], "duration": maneuver[1], "status": run.status.value, **e,
                    "stepping_ratio": ratios[0], "whole_ratio": ratios[1],
                    "iterations_per_step": run.stats.iterations / run.stats.steps,
                }
            )  # fmt: skip
            print(
                f"| {transverse} + {in_plane} | {rom.weights.chosen} of {len(rom.weights.values)} "
                f"({rom.weights.residual:.0e}) | {rom.seconds:.1f}, {rom.memory / 1e6:.1f} | "
                f"{maneuver[0]:.3f} rad/s, {maneuver[1]:g} s | {e['amplitude']:+.1%} | {e['rms']:+.1%} | "
                f"{e['first_second']:.1%} | {e['frequency']:.3f} ({e['frequency_full']:.3f}) | "
                f"{e['wrinkled']:.2f} ({e['wrinkled_full']:.2f}) | {e['truncated']:.0e} | "
                f"{ratios[0]:.1f}, {ratios[1]:.1f} |",
                flush=True,
            )
    if options.json:
        with open(options.json, "w") as stream:
            json.dump({"machine": platform.platform(), "divisions": divisions, "rows": rows}, stream, indent=1)


if __name__ == "__main__":
    main()
