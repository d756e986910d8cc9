"""Cost and error of every integrator on the paper's M2 antenna, stopped in 0.1 s: the table of docs/integrators.md."""

from __future__ import annotations

import math

import numpy as np

import tautflex as tf
from tautflex import Run
from tautflex.case import parse_case, template

END, GRID = 2.0, 5e-3


def main() -> None:
    """Run all methods and print a Markdown table; errors are against the trapezoidal rule at 0.125 ms."""
    case = parse_case(template("m2-nearest-node"))
    state = tf.solve_prestress(tf.build_model(case))
    damping = case.damping.build()

    def run(method: object, step: float, adaptive: tf.Adaptive | None = None) -> Run:
        return tf.simulate(
            state,
            tf.Stop(math.pi / 5, 0.1),
            method=method,
            time_step=step,
            end_time=END,
            every=max(1, round(GRID / step)),
            adaptive=adaptive,
            damping=damping,
            probes=case.output.probes,
        )

    reference = run(tf.Newmark(), 1.25e-4).data.w.values[:, 0]
    print("| method | step | error | steps | factorizations | back-substitutions | seconds |")
    print("|---|---|---|---|---|---|---|")
    cases = [
        *((method, step, None) for method in
          (tf.WilsonTheta(), tf.GeneralizedAlpha(0.8), tf.Newmark(), tf.HHT(), tf.EnergyConserving())
          for step in (2.5e-3, 1e-3)),
        *((tf.GeneralizedAlpha(0.8), GRID, tf.Adaptive(tolerance)) for tolerance in (1e-3, 1e-4)),
        (tf.CentralDifference(), 3.125e-5, None),
    ]  # fmt: skip
    for method, step, adaptive in cases:
        result = run(method, step, adaptive)
        error = np.abs(result.data.w.values[:, 0] - reference).max() / np.abs(reference).max()
        size = f"adaptive {adaptive.tolerance:g}" if adaptive else f"{1e3 * step:g} ms"
        stats = result.stats
        print(
            f"| {method.name} | {size} | {error:.1e} | {stats.steps} | {stats.factorizations} | "
            f"{stats.back_substitutions} | {stats.seconds:.1f} |"
        )


if __name__ == "__main__":
    main()
