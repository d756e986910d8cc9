"""Factor and solve times, fill and memory of every direct solver against size: what the choice of solver rests on.

Run ``python benchmarks/linear_solvers.py`` (``--largest 320x160`` takes a few minutes). The matrix is the effective
stiffness of a 1 ms step of the paper's antenna in motion (all couplings present). Each solver runs in a process of its
own on one core, so that peak memory can be told apart; times are the least of several, memory is what the process
grew by above the assembled matrix. Solvers that are not installed are left out.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import resource
import time

import numpy as np

from tautflex.solvers.linear.factorization import BACKENDS
from tautflex.solvers.linear.pardiso import available

MESHES = ("10x5", "20x10", "40x20", "80x40", "160x80", "320x160")


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _matrix(divisions: tuple[int, int]):
    from step_cost import antenna

    import tautflex as tf

    state = tf.solve_prestress(antenna("M2", divisions))
    system, rng = state.system, np.random.default_rng(0)
    values = system.tangent(1e-5 * rng.standard_normal(system.size)) + 6.0 / 1.4e-3**2 * system.inertia.mass_entries
    kept, start, rows = system.pattern.upper
    return system.pattern, values, values[kept], start, rows


def _measure(name: str, divisions: tuple[int, int], queue) -> None:
    """One solver at one size; the result goes into the queue."""
    from step_cost import antenna

    import tautflex as tf

    # Compiled before it is timed.
    small = tf.solve_prestress(antenna("M2", (4, 2))).system
    kept, start, rows = small.pattern.upper
    first = BACKENDS[name](small.size, start, rows, {})
    first.factorize((small.tangent(np.zeros(small.size)) + small.inertia.mass_entries)[kept])
    first.solve(np.ones(small.size))
    pattern, values, upper, start, rows = _matrix(divisions)
    before = _peak()
    began = time.perf_counter()
    backend = BACKENDS[name](pattern.size, start, rows, {})
    backend.factorize(upper)
    setup = time.perf_counter() - began
    expected = np.random.default_rng(1).standard_normal(pattern.size)
    right = pattern.symmetric_matrix(values) @ expected
    again, solve, repeats = np.inf, np.inf, max(3, min(200, 400_000 // pattern.size))
    for _ in range(max(2, repeats // 10)):
        began = time.perf_counter()
        backend.factorize(upper)
        again = min(again, time.perf_counter() - began)
    for _ in range(repeats):
        began = time.perf_counter()
        solution = backend.solve(right)
        solve = min(solve, time.perf_counter() - began)
    left = pattern.symmetric_matrix(values) @ solution - right
    queue.put(
        {
            "mesh": "x".join(map(str, divisions)),
            "unknowns": pattern.size,
            "solver": name,
            "order_and_factorize_ms": 1e3 * setup,
            "factorize_ms": 1e3 * again,
            "solve_ms": 1e3 * solve,
            "fill": backend.fill,
            "megabytes": _peak() - before,
            "residual": float(np.linalg.norm(left) / np.linalg.norm(right)),
        }
    )


def main() -> None:
    """Print a Markdown table, or JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--largest", default="160x80", choices=MESHES, help="last mesh (default %(default)s)")
    parser.add_argument("--json", action="store_true", help="one JSON object per line")
    arguments = parser.parse_args()
    for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[variable] = "1"
    context = multiprocessing.get_context("spawn")
    if not arguments.json:
        print("| mesh | unknowns | solver | order + factorize ms | factorize ms | solve ms | fill | MB | residual |")
        print("|---|---|---|---|---|---|---|---|---|")
    for mesh in MESHES[: MESHES.index(arguments.largest) + 1]:
        columns, rows = (int(number) for number in mesh.split("x"))
        for name in BACKENDS:
            if name == "pardiso" and not available():
                continue
            queue = context.Queue()
            process = context.Process(target=_measure, args=(name, (columns, rows), queue))
            process.start()
            row = queue.get(timeout=1200)
            process.join()
            if arguments.json:
                print(json.dumps(row), flush=True)
            else:
                print(
                    f"| {row['mesh']} | {row['unknowns']} | {name} | {row['order_and_factorize_ms']:.1f} | "
                    f"{row['factorize_ms']:.2f} | {row['solve_ms']:.3f} | {row['fill']} | {row['megabytes']:.0f} | "
                    f"{row['residual']:.0e} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
