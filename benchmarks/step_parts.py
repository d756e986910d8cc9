"""Where a step of a large antenna goes, and what two threads could save of it.

Run ``python benchmarks/step_parts.py`` (some minutes): M2 of the paper on 320 x 160 cells, step by step, processor time
of every part less what other parts in it took. ``--mesh 160 80`` is quicker. The last lines say how long a step would
take if the named parts took half their time, which is what two threads can do at best.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from step_cost import antenna

import tautflex as tf
from tautflex.mechanics.workspace import Workspace
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
ROOM = {
    "kernels": ("residual", "tangent"),
    "kernels and back-substitution": ("residual", "tangent", "back-substitution"),
}
ROOM["those and the factorization"] = (*ROOM["kernels and back-substitution"], "factorization")


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
    driver = GridDriver(Stepper(equation, tf.WilsonTheta(), 1e-6), maneuver.segments(), step, 8)
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
    share = {part: seconds / whole for part, seconds in clock.seconds.items()}
    share["the rest, in Python"] = 1.0 - sum(share.values())
    return {
        "mesh": f"{divisions[0]}x{divisions[1]}",
        "unknowns": state.system.size,
        "steps": steps,
        "milliseconds_per_step": round(1e3 * whole / steps, 2),
        "shares": {part: round(value, 3) for part, value in share.items()},
        "calls_per_step": {part: round(count / steps, 2) for part, count in clock.calls.items()},
        "gain_of_two_perfect_threads": {
            name: round(1.0 / (1.0 - 0.5 * sum(share[part] for part in parts)), 2) for name, parts in ROOM.items()
        },
    }


def main() -> None:
    """Print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", type=int, nargs=2, default=(320, 160), help="cells (default 320 160)")
    parser.add_argument("--steps", type=int, default=60, help="steps that are measured (default %(default)s)")
    chosen = parser.parse_args()
    print(json.dumps(measure(tuple(chosen.mesh), chosen.steps), indent=1))


if __name__ == "__main__":
    main()
