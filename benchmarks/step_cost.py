"""Cost of one accepted implicit step of the 40x20 nonlinear antenna, in back-substitutions of its own factors.

Run ``python benchmarks/step_cost.py`` (or ``make benchmark``). Both are processor times of one process: after every
fifth step, recording included, the factorized effective stiffness is applied to a vector. The ratio is what counts;
the milliseconds depend on the machine. ``--growth`` runs fewer steps on meshes from 10x5 to 320x160 instead and prints
how step time and factor entries grow with the number of unknowns.
"""

from __future__ import annotations

import argparse
import json
import platform
import time

import numpy as np

import tautflex as tf
from tautflex import BeamSection, CableSection, Coupling, Material, MembraneSection, Rayleigh, Stop
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.probes import place_probes
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.simulate import begin
from tautflex.structure.antenna import AntennaLayout, build_antenna

# Tension per metre of edge [N/m] and film resultants [N/m] of the paper's three models (identified reading).
PRETENSION = {"M1": (0.147, 0.25), "M2": (0.59, 1.0), "M3": (3.1, 3.7)}


def antenna(name: str, divisions: tuple[int, int]) -> tf.Model:
    """Paper's antenna with a cable at every edge node and the same tension per metre of edge on every mesh."""
    tension_x, tension_y = PRETENSION[name]
    layout = AntennaLayout(
        2.0,
        1.0,
        divisions,
        "alternating",
        2.5,
        1.5,
        divisions[0] + 1,
        divisions[1] + 1,
        "tributary",
        "corners",
    )
    return build_antenna(
        layout,
        MembraneSection(Material(3.5e9, 1530.0, 0.34), 1e-4),
        CableSection(Material(133e9, 1440.0, 0.36), 3.14e-6),
        BeamSection(Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=tension_x / divisions[1] * 1.0,
        pretension_y=tension_y / divisions[0] * 2.0,
    )


def measure(name: str, divisions: tuple[int, int], rate: float, duration: float, seconds: float, step: float):
    """Time a run slice by slice beside back-substitutions with its own factors."""
    state = tf.solve_prestress(antenna(name, divisions))
    equation = EquationOfMotion(state, Rayleigh(0.001, 0.001), Coupling())
    stepper = Stepper(equation, tf.WilsonTheta(), 1e-6)
    maneuver = Stop(rate, duration)
    driver = GridDriver(stepper, maneuver.segments(), step, 8)
    count = round(seconds / step)
    probes = place_probes(state.system, {"A": (0.7036, 0.4267)})
    recorder = Recorder(equation, probes, count + 1, set())
    at = begin(equation, maneuver, np.zeros(state.system.size))
    vector = np.random.default_rng(0).standard_normal(state.system.size)
    stepping, substitution = [], []
    for number in range(1, count + 1):
        began = time.thread_time()
        at = driver.advance(at, number * step)
        recorder.store(at, driver.segment)
        stepping.append(time.thread_time() - began)
        if number % 5 == 0:
            began = time.thread_time()
            stepper.factor.solve(vector)
            substitution.append(time.thread_time() - began)
    # The first steps compile, order and factorize for the first time.
    stepping, substitution = stepping[3:], substitution[1:]
    stepper.collect_counts()
    return {
        "model": name,
        "mesh": f"{divisions[0]}x{divisions[1]}",
        "unknowns": state.system.size,
        "rate": rate,
        "steps": count,
        "iterations_per_step": equation.statistics.iterations / count,
        "factorizations": equation.statistics.factorizations,
        "fill": stepper.factor.fill,
        "milliseconds_per_step": 1e3 * float(np.mean(stepping)),
        "milliseconds_per_back_substitution": 1e3 * float(np.mean(substitution)),
        "back_substitutions_per_step": float(np.mean(stepping) / np.mean(substitution)),
        "ratio_of_medians": float(np.median(stepping) / np.median(substitution)),
    }


def measure_growth(largest: int) -> None:
    """Print one line per mesh, then the exponents between neighbouring meshes and over all."""
    rows = []
    for cells in (5, 10, 20, 40, 80, 160):
        if cells <= largest:
            rows.append(measure("M2", (2 * cells, cells), np.pi / 5, 1.0, 0.1, 1e-3))
            print(json.dumps(rows[-1]), flush=True)
    size, time_, fill, solve = (
        np.log([row[key] for row in rows])
        for key in ("unknowns", "milliseconds_per_step", "fill", "milliseconds_per_back_substitution")
    )
    for name, values in (("step time", time_), ("back-substitution", solve), ("factor entries", fill)):
        slopes = np.diff(values) / np.diff(size)
        overall = (values[-1] - values[0]) / (size[-1] - size[0])
        print(json.dumps({"exponent": name, "between": slopes.round(2).tolist(), "overall": round(float(overall), 2)}))


def main() -> None:
    """Print one JSON line per case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time [s]")
    parser.add_argument("--growth", action="store_true", help="grow the mesh instead")
    parser.add_argument("--largest", type=int, default=160, help="cells along the short side of the last mesh")
    arguments = parser.parse_args()
    print(json.dumps({"machine": platform.processor() or platform.machine(), "python": platform.python_version()}))
    if arguments.growth:
        measure_growth(arguments.largest)
        return
    for name, rate, duration in (("M2", np.pi / 5, 1.0), ("M3", np.pi / 5, 0.1), ("M1", np.pi / 2, 0.1)):
        print(json.dumps(measure(name, (40, 20), rate, duration, arguments.seconds, 1e-3)))


if __name__ == "__main__":
    main()
