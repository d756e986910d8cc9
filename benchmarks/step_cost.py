"""Cost of one accepted implicit step of the 40x20 nonlinear antenna, in back-substitutions of its own factors.

Run ``python benchmarks/step_cost.py`` (or ``make benchmark``). Both are processor times of one process: after every
fifth step, recording included, the factorized effective stiffness is applied to a vector. The ratio is what counts;
the milliseconds depend on the machine. ``--growth`` runs fewer steps on meshes from 10x5 to 320x160 instead and prints
how step time and factor entries grow with the number of unknowns. ``--stretches`` measures steps of one compiled call
beside the same steps taken one by one, and beside their own arithmetic: as many residuals and substitutions, each
called over and over by a compiled loop, with warm caches. Parts of both runs and of the arithmetic alternate.
"""

from __future__ import annotations

import argparse
import json
import platform
import time

import numpy as np

import tautflex as tf
from tautflex import BeamSection, CableSection, Coupling, Material, MembraneSection, Rayleigh, Stop
from tautflex.numeric import Array, jit
from tautflex.solvers.linear.substitution import substitute
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.probes import place_probes
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.simulate import FullRun, begin
from tautflex.solvers.transient.step_kernel import step_residual
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
    recorder = Recorder(equation, probes, count + 1, set(), set())
    at, _ = begin(equation, maneuver, np.zeros(state.system.size))
    vector = np.random.default_rng(0).standard_normal(state.system.size)
    stepping, substitution = [], []
    for number in range(1, count + 1):
        began = time.thread_time()
        at = driver.advance(at, number * step)
        recorder.store(at, driver.segment_at(at.time))
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


@jit
def many_residuals(
    times: int, x: Array, q: Array, elements, matrices, turning: Array, weight: float, rows: Array, part: float
):  # fmt: skip
    """The same residual over and over."""
    start, column, _, _, _, linear, pairs, reference, _, _, _ = matrices
    for _ in range(times):
        step_residual(
            x, q, elements[0], elements[1], elements[2], start, column, linear[0], pairs, turning, weight, reference,
            rows, False, part,
        )  # fmt: skip


@jit
def many_substitutions(times: int, pattern, values: Array, inverse: Array, right: Array):
    """The same substitution over and over."""
    for _ in range(times):
        substitute(pattern, values, inverse, right)


def seconds(function, *arguments) -> float:
    """Processor time of a call [s]."""
    began = time.thread_time()
    function(*arguments)
    return time.thread_time() - began


def own_arithmetic(run: FullRun, times: int) -> tuple[float, float]:
    """Processor times of a residual and of a substitution of a run [s]."""
    march, sized, size = run._march, run._march._sized, run.at.q.size
    numbers, motion = sized.numbers[0], run.motion()
    terms = run.equation.motion_terms(motion)
    turning = numbers.scheme.weight * (numbers.scheme.velocity.d * terms.velocity + terms.displacement)
    forces = 1e-3 * run.at.v, run.at.q, sized.elements, sized.matrices, turning, numbers.scheme.weight
    solved = *march._stepper.factor.parts, run.at.v
    both = (many_residuals, *forces, np.zeros((6, size)), numbers.part), (many_substitutions, *solved)
    return tuple(seconds(function, times, *given) / times for function, *given in both)


def measure_stretches(name: str, state, maneuver, steps: int, rounds: int, **question) -> dict[str, object]:
    """Alternate parts of a run in stretches, of one step by step, and of the arithmetic; medians of the rounds."""
    question |= {"time_step": question.get("time_step", 1e-3)}
    question["end_time"] = (rounds + 1) * steps * question["time_step"]
    runs = [FullRun(TransientProblem.asked(state, maneuver, question)) for _ in range(2)]
    runs[1]._march = None
    for run in runs:
        run.start()
    found, counted = [], (0, 0, 0)
    for part in range(1, rounds + 2):
        spent = [seconds(run.advance, part * steps) for run in runs]
        now = runs[0]._statistics()
        count = now.steps, now.force_evaluations, now.back_substitutions
        (taken, *work), counted = np.subtract(count, counted), count
        done = np.divide(work, taken)
        arithmetic = own_arithmetic(runs[0], 200)
        if part > 1:  # the first part compiles
            own = float(done @ arithmetic)
            found.append(
                (*np.divide(spent, taken), own, spent[0] / taken / own, spent[1] / spent[0], *arithmetic, *done)
            )
    assert np.array_equal(runs[0].at.q, runs[1].at.q)
    names = "stretch", "step_by_step", "arithmetic", "over_arithmetic", "gain", "residual", "substitution"
    times = dict(zip((*names, "residuals", "substitutions"), np.median(found, axis=0).tolist(), strict=True))
    microseconds = {key: round(1e6 * times.pop(key), 2) for key in ("stretch", "step_by_step", *names[2:3], *names[5:])}
    ranges = {key: np.percentile(np.array(found)[:, k], (0, 100)).round(2).tolist() for key, k in (("gain", 4),)}
    others = {key: round(value, 3) for key, value in times.items()}
    return {"case": name, "unknowns": state.system.size, "microseconds": microseconds, **others, "ranges": ranges}


def stretch_cases():
    """Name, state, maneuver and question of each case."""
    maneuver, damping = Stop(np.pi / 5, 1.0), Rayleigh(0.001, 0.001)
    asked = {"method": tf.WilsonTheta(), "tolerance": 1e-6, "damping": damping, "probes": {"A": (0.7036, 0.4267)}}
    small = tf.solve_prestress(antenna("M2", (10, 5)))
    push = tf.NodalForce([20], lambda time: [0.0, 0.0, 1e-3 * np.sin(30.0 * time)])
    yield "10x5", small, maneuver, asked
    yield "10x5, every tenth step stored", small, maneuver, asked | {"every": 10}
    yield "10x5, Newmark", small, maneuver, asked | {"method": tf.Newmark()}
    yield "10x5, force in time", small, maneuver, asked | {"inputs": [push]}
    pull = tf.CableTension(lambda time: 0.01 * np.sin(30.0 * time))
    yield "10x5, tension in time", small, maneuver, asked | {"inputs": [pull]}
    yield "10x5, tension that stays", small, maneuver, asked | {"inputs": [tf.CableTension(0.01)]}
    for tolerance in (1e-3, 1e-4):
        adaptive = {"method": tf.GeneralizedAlpha(0.8), "time_step": 5e-3, "adaptive": tf.Adaptive(tolerance)}
        yield f"10x5, adaptive, {tolerance:g}", small, maneuver, asked | adaptive
    yield "10x5, modal damping", small, maneuver, asked | {"damping": tf.Modal(0.01, modes=6)}
    hub = tf.FreeHub(50.0, (20.0, 25.0, 30.0), torque=(2.0, 0.5, 0.0))
    yield "10x5, free hub", small, hub, asked | {"method": tf.GeneralizedAlpha(0.8)}
    turned = tf.FreeHub(50.0, (20.0, 25.0, 30.0), torque=lambda time, state: [2.0 * np.cos(3.0 * time), 0.5, 0.0])
    yield "10x5, free hub, torque in time", small, turned, asked | {"method": tf.GeneralizedAlpha(0.8)}
    both = {"method": tf.GeneralizedAlpha(0.8), "inputs": [push]}
    yield "10x5, free hub, torque and force in time", small, turned, asked | both
    drawn = {"method": tf.GeneralizedAlpha(0.8), "inputs": [pull]}
    yield "10x5, free hub, tension in time", small, hub, asked | drawn
    yield "10x5, Bathe", small, maneuver, asked | {"method": tf.Bathe()}
    yield "10x5, energy-conserving", small, maneuver, asked | {"method": tf.EnergyConserving(), "tolerance": 1e-9}
    yield "20x10", tf.solve_prestress(antenna("M2", (20, 10))), maneuver, asked
    yield "40x20", tf.solve_prestress(antenna("M2", (40, 20))), maneuver, asked
    for elements in (4, 16, 64):
        spin = tf.SpinUp(6.0, 15.0, axis=(0.0, 0.0, 1.0))
        question = {"method": tf.GeneralizedAlpha(0.8), "time_step": 0.02}
        yield f"beam of {elements}", beam(elements), spin, question
        if elements > 4:
            continue
        for method in (tf.Bathe(), tf.EnergyConserving()):
            yield f"beam of {elements}, {method.name}", beam(elements), spin, question | {"method": method}
        turned = tf.FreeHub(100.0, (50.0, 50.0, 50.0), torque=lambda time, state: [0.0, 0.0, 2.0 * np.cos(3.0 * time)])
        yield f"beam of {elements}, free hub, torque in time", beam(elements), turned, question


def beam(elements: int):
    """Cantilever of Kane's spin-up in its plane, as in ``peers/spinup_problem.py``."""
    nodes = np.zeros((elements + 1, 3))
    nodes[:, 0] = np.linspace(0.0, 10.0, elements + 1)
    section = BeamSection(Material(2.8e7, 1.2, 0.3), 1.0, 5e-4, 5e-4, 1e-3)
    supports = [tf.Support.clamped(0), tf.Support(tuple(range(elements + 1)), ("z", "rx", "ry"))]
    lines = np.column_stack([np.arange(elements), np.arange(1, elements + 1)])
    return tf.solve_prestress(tf.Model.from_mesh(nodes, beams=lines, beam=section, supports=supports))


def main() -> None:
    """Print one JSON line per case."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time [s]")
    parser.add_argument("--growth", action="store_true", help="grow the mesh instead")
    parser.add_argument("--stretches", action="store_true", help="measure compiled stretches of steps instead")
    parser.add_argument("--only", default="", help="cases of --stretches whose names begin so")
    parser.add_argument("--rounds", type=int, default=12, help="alternations of --stretches (12)")
    parser.add_argument("--largest", type=int, default=160, help="cells along the short side of the last mesh")
    arguments = parser.parse_args()
    print(json.dumps({"machine": platform.processor() or platform.machine(), "python": platform.python_version()}))
    if arguments.stretches:
        for name, *case, question in stretch_cases():
            if name.startswith(arguments.only):
                steps = 40 if name.startswith("beam") else 150
                print(json.dumps(measure_stretches(name, *case, steps, arguments.rounds, **question)), flush=True)
        return
    if arguments.growth:
        measure_growth(arguments.largest)
        return
    for name, rate, duration in (("M2", np.pi / 5, 1.0), ("M3", np.pi / 5, 0.1), ("M1", np.pi / 2, 0.1)):
        print(json.dumps(measure(name, (40, 20), rate, duration, arguments.seconds, 1e-3)))


if __name__ == "__main__":
    main()
