"""Where a step of a large antenna goes, and what two threads could save of it.

Run ``python benchmarks/step_parts.py`` (some minutes): M2 of the paper on 320 x 160 cells, step by step, processor time
of every part less what other parts in it took. ``--mesh 160 80`` is quicker. The last lines say what two threads could
gain at best: kernels share elements, and take half their time; substitution and factorization share the subtrees of the
elimination tree, of which the most even choice is found, and what is above them is done by one. Nothing is said of
memory, which both threads read.
"""

from __future__ import annotations

import argparse
import heapq
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from step_cost import antenna

import tautflex as tf
from tautflex.mechanics.workspace import Workspace
from tautflex.numeric import Array, Indices
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.nonlinear.anderson import AndersonAcceleration
from tautflex.solvers.transient.corotation import Corotation
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.equation import EquationOfMotion, StepForces
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.probes import place_probes
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.simulate import begin

# What each part is called, and whether it is compiled work that could be shared by threads.
PARTS = {
    (StepForces, "residual"): "residual",
    (SymmetricFactorization, "solve"): "back-substitution",
    (SymmetricFactorization, "factorize_upper"): "factorization",
    (Workspace, "upper_tangent"): "tangent",
    (EquationOfMotion, "step_forces"): "forces before the increment",
    (StepForces, "end"): "end of the step",
    (AndersonAcceleration, "propose"): "Anderson acceleration and turned axes",
    (Corotation, "follow"): "rotations of the axes",
    (Recorder, "store"): "sample",
}
KERNELS = ("residual", "tangent")


class Clock:
    """Processor seconds of this thread by part; time inside an inner part counts for that one alone."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PARTS.values(), 0.0)
        self.calls = dict.fromkeys(PARTS.values(), 0)
        self._inner = [0.0]

    def wrapped(self, function: Callable[..., Any], part: str) -> Callable[..., Any]:
        """The function, timed."""

        def timed(*args: Any, **named: Any) -> Any:
            self._inner.append(0.0)
            began = time.thread_time()
            try:
                return function(*args, **named)
            finally:
                spent = time.thread_time() - began
                self.seconds[part] += spent - self._inner.pop()
                self.calls[part] += 1
                self._inner[-1] += spent

        return timed


def measure(divisions: tuple[int, int], steps: int) -> dict[str, Any]:
    """Milliseconds per step of every part, over the steps after the first three."""
    state = tf.solve_prestress(antenna("M2", divisions))
    equation = EquationOfMotion(state, tf.Rayleigh(0.001, 0.001), tf.Coupling())
    maneuver, step = tf.Stop(np.pi / 5, 1.0), 1e-3
    stepper = Stepper(equation, tf.WilsonTheta(), 1e-6)
    driver = GridDriver(stepper, maneuver.segments(), step, 8)
    recorder = Recorder(equation, place_probes(state.system, {"A": (0.7036, 0.4267)}), steps + 4, set(), set())
    at, _ = begin(equation, maneuver, np.zeros(state.system.size))
    clock = Clock()

    def walk(first: int, last: int) -> float:
        nonlocal at
        began = time.thread_time()
        for number in range(first, last + 1):
            at = driver.advance(at, number * step)
            recorder.store(at, driver.segment_at(at.time))
        return time.thread_time() - began

    walk(1, 3)  # compiles, orders and factorizes for the first time
    kept = {place: getattr(*place) for place in PARTS}
    for (owner, name), part in PARTS.items():
        setattr(owner, name, clock.wrapped(kept[owner, name], part))
    whole = walk(4, 3 + steps)
    for (owner, name), function in kept.items():
        setattr(owner, name, function)
    trees = dict(zip(("back-substitution", "factorization"), subtree_times(stepper.factor.parts[0]), strict=True))
    share = {part: seconds / whole for part, seconds in clock.seconds.items()}
    share["the rest, in Python"] = 1.0 - sum(share.values())
    return {
        "mesh": f"{divisions[0]}x{divisions[1]}",
        "unknowns": state.system.size,
        "steps": steps,
        "milliseconds_per_step": round(1e3 * whole / steps, 2),
        "shares": {part: round(value, 3) for part, value in share.items()},
        "calls_per_step": {part: round(count / steps, 2) for part, count in clock.calls.items()},
        "time_by_subtrees": {part: round(value, 3) for part, value in trees.items()},
        "gain_of_two_threads": {
            "kernels": gain(share, dict.fromkeys(KERNELS, 0.5)),
            "and substitution": gain(
                share, dict.fromkeys(KERNELS, 0.5) | {"back-substitution": trees["back-substitution"]}
            ),
            "and factorization": gain(share, dict.fromkeys(KERNELS, 0.5) | trees),
        },
    }


def gain(share: dict[str, float], left: dict[str, float]) -> float:
    """Gain of a step whose parts take only what is left of their time."""
    return round(1.0 / (1.0 - sum((1.0 - rest) * share[part] for part, rest in left.items())), 2)


def subtree_times(pattern: Any) -> tuple[float, float]:
    """Shares of their time in which two threads substitute and factorize, at best, by subtrees of panels."""
    _, start, rows, panels, member, _, _ = pattern
    width, last = np.diff(panels), panels[1:] - 1
    below = np.diff(start)[last]
    parent = np.where(below > 0, member[rows[np.minimum(start[last], len(rows) - 1)]].astype(int), -1)
    entries = (start[panels[1:]] - start[panels[:-1]]).astype(float)
    products = 1.0 * width * below * (below + width) + width**3 / 3.0
    return _evenly(entries, parent), _evenly(products, parent)


def _evenly(work: Array, parent: Indices, most: int = 64) -> float:
    """Least share of the work in which two threads do it: subtrees side by side, what is above them after."""
    below, children = work.copy(), [[] for _ in work]
    for panel, above in enumerate(parent):
        if above >= 0:
            below[above] += below[panel]
            children[above].append(panel)
    waiting, top, least = [(-below[root], int(root)) for root in np.flatnonzero(parent < 0)], 0.0, work.sum()
    heapq.heapify(waiting)
    while waiting and len(waiting) < most:
        loads = [0.0, 0.0]
        for size, _ in sorted(waiting):
            loads[loads.index(min(loads))] -= size
        least = min(least, top + max(loads))
        _, panel = heapq.heappop(waiting)
        top += work[panel]
        for child in children[panel]:
            heapq.heappush(waiting, (-below[child], child))
    return float(least / work.sum())


def main() -> None:
    """Print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", type=int, nargs=2, default=(320, 160), help="cells (default 320 160)")
    parser.add_argument("--steps", type=int, default=60, help="steps that are measured (default %(default)s)")
    chosen = parser.parse_args()
    print(json.dumps(measure(tuple(chosen.mesh), chosen.steps), indent=1))


if __name__ == "__main__":
    main()
