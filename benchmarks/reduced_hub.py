"""Steps per second of reduced models on a free hub, compiled stepping alone; with --bases, how close bases come.

Run ``python benchmarks/reduced_hub.py``. Two antennas (8 coordinates of 20 x 10 cells, 17 of 40 x 20), a hub that turns
about x and one that is free, central differences at 5 ms and Newmark's method at 1 ms. Processor times, medians.

``--bases`` slews M2 on 40 x 20 cells by 0.3 rad (``--turn``) under tensions that switch by half every 0.25 s, full and
reduced: rms of the difference of the records over the rms, attitude over the turn, processor times (minutes).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

import numpy as np
from batch import model
from reduced import prestressed

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


def bases(rich: int, count: int) -> Iterator[tuple[str, tf.Basis | str, float]]:
    """Names, bases (or the name of the run that trains one) and weak_field; runs come before what they train."""
    for modes, candidates, weak in (
        (count - 1, 130, 1e-5),
        (count - 1, 130, 1e-6),
        (count - 1, 130, 1e-8),
        (rich // 2, 130, 1e-8),
        (rich, 260, 1e-8),
    ):
        yield f"{modes} natural modes", tf.ModalBasis(("rx",), count=modes, candidates=candidates), weak
    for trainer, weak in ((f"{rich} natural modes", 1e-5), (f"{rich} natural modes", 1e-6), ("full", 1e-8)):
        yield f"{count} proper orthogonal modes: {trainer}", trainer, weak


def compare_bases(turn: float, rich: int = 60, count: int = 17) -> None:
    """Print a table: reduced slews under switched tension against the full one."""
    case, state = prestressed("40x20, equilibrium", "M2")
    times = 0.25 * np.arange(1, 16)

    def switched(size: float):
        return lambda time: size * (0.0, *[0.5, -0.5] * 8)[int(np.searchsorted(times, time, side="right"))]

    tensions = {"x": case.cables.pretension_x, "y": case.cables.pretension_y}
    pulls = [
        tf.TensionGroup(axis, switched(n), share="pretension", breaks=tuple(times)) for axis, n in tensions.items()
    ]
    torque = 2.23 * turn / 0.3
    hub = tf.FreeHub(
        20.0,
        (5.0, 5.0, 8.0),
        axes="x",
        breaks=(1.0, 2.0),
        torque=lambda time, _: (torque * (time < 1.0) - torque * (1.0 <= time < 2.0), 0.0, 0.0),
    )
    plant = tf.equip(state, pulls)
    question = {"time_step": 2.5e-3, "end_time": 4.0, "method": tf.Bathe(), "damping": tf.Rayleigh(1e-3, 1e-3)}
    question |= {"probes": {"A": (0.7036, 0.4267), "B": (0.3, 0.1)}, "inputs": pulls, "fields": "all", "every": 4}
    runs: dict[str, object] = {}

    def timed(name: str, model: object) -> float:
        began = time.process_time()
        runs[name] = tf.simulate(model, hub, **question).data
        return time.process_time() - began

    print(f"full: {timed('full', plant):.0f} s", flush=True)
    full = runs["full"]
    heads = ("basis", "weak_field", "coordinates", "A", "B", "attitude", "reduce [s]", "run [s]")
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, basis, weak in bases(rich, count):
        began = time.process_time()
        rom = tf.reduce(plant, tf.PodBasis(runs[basis], count=count) if isinstance(basis, str) else basis, weak)
        offline, online = time.process_time() - began, timed(name, rom)
        off = np.sqrt(((full.w - runs[name].w) ** 2).mean("time") / (full.w**2).mean("time")).values
        angle = 2.0 * np.abs(full.attitude - runs[name].attitude).max() / turn
        cells = [name, f"{weak:g}", str(rom.size), *(f"{100 * part:.1f}%" for part in off), f"{float(angle):.0e}"]
        print(f"| {' | '.join(cells)} | {offline:.1f} | {online:.1f} |", flush=True)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bases", action="store_true", help="how close bases come to the full model")
    parser.add_argument("--turn", type=float, default=0.3, help="slew of --bases [rad] (default %(default)s)")
    asked = parser.parse_args()
    if asked.bases:
        compare_bases(asked.turn)
        return
    print("| coordinates | hub | method | steps per second |\n|---|---|---|---|")
    for name in ("20x10", "40x20"):
        rom = model(name)
        for axes in ("x", "free"):
            for method, step in METHODS:
                speed = steps_per_second(rom, axes, method, step)
                print(f"| {rom.size} | {axes} | {method.name}, {1e3 * step:g} ms | {speed:.0f} |", flush=True)


if __name__ == "__main__":
    main()
