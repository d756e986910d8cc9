"""Time and memory from the mesh of a large antenna to its ten lowest modes, stage by stage, as one JSON object.

Run ``taskset -c 0 env OMP_NUM_THREADS=1 python benchmarks/setup_cost.py`` for one core. The default is an antenna of
200 000 unknowns with a cable at every edge node, prestressed in equilibrium.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from step_cost import antenna

import tautflex as tf
from tautflex.mechanics.system import StructuralSystem
from tautflex.solvers.linear.factorization import SymmetricFactorization


def peak_gigabytes() -> float:
    """Largest resident memory of this process so far."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e9


def main() -> None:
    """Print the measurements."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--divisions", default="358x179", help="cells of the film (default %(default)s)")
    parser.add_argument("--modes", type=int, default=10, help="number of modes (default %(default)s)")
    arguments = parser.parse_args()
    columns, rows = (int(number) for number in arguments.divisions.split("x"))
    # Compiling (once per installation) is not part of the set-up.
    tf.solve_modes(tf.solve_prestress(antenna("M2", (10, 5))), n=2)
    stages: dict[str, float] = {}
    started = time.perf_counter()

    def stage(name: str, work: Callable[[], Any]) -> Any:
        began = time.perf_counter()
        result = work()
        stages[name] = round(time.perf_counter() - began, 2)
        return result

    model = stage("mesh", lambda: antenna("M2", (columns, rows)))
    state = stage("prestress", lambda: tf.solve_prestress(model))
    modes = stage("modes", lambda: tf.solve_modes(state, n=arguments.modes))
    total, memory = time.perf_counter() - started, peak_gigabytes()
    # What single operations of these stages cost, measured after them.
    system = stage("(compile the system)", lambda: StructuralSystem.from_model(model))
    stage("(inertia operator)", lambda: system.inertia)
    stage("(tangent)", lambda: system.tangent(np.zeros(system.size)))
    factor = SymmetricFactorization(state.system.pattern)
    values = state.tangent_entries + state.system.inertia.mass_entries
    stage("(order and factorize)", lambda: factor.factorize(values))
    stage("(factorize again)", lambda: factor.factorize(values))
    stage("(back-substitution)", lambda: factor.solve(np.ones(state.system.size)))
    print(
        json.dumps(
            {
                "mesh": arguments.divisions,
                "unknowns": state.system.size,
                "entries": state.system.pattern.entries,
                "fill": factor.fill,
                "seconds": round(total, 2),
                "peak_gigabytes": round(memory, 2),
                "stages": stages,
                "frequencies": [round(float(f), 6) for f in modes.frequencies],
                "relative_residual": state.relative_residual,
                "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
                "machine": platform.machine(),
                "python": platform.python_version(),
            },
            indent=2,
        )
    )


if __name__ == "__main__":
    main()
