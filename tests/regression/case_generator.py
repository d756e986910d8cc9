"""Random cases, wild values among sensible ones, to be built, prestressed and run; one seed, one case."""

from __future__ import annotations

import copy
import random
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

import tautflex as tf
from tautflex.solvers.transient.status import Status

MOST_STEPS, MOST_CELLS, MOST_SECONDS = 12, 120, 3.0
FILM = {
    "length": 2.0,
    "width": 1.0,
    "thickness": 1e-4,
    "youngs_modulus": 3.5e9,
    "poisson_ratio": 0.34,
    "density": 1530.0,
}
CABLES = {"youngs_modulus": 133e9, "area": 3.14e-6, "density": 1440.0, "pretension_x": 0.59, "pretension_y": 1.0}
FRAME = {
    "length": 2.5,
    "width": 1.5,
    "youngs_modulus": 3e9,
    "poisson_ratio": 0.38,
    "density": 1380.0,
    "area": 5.24e-4,
    "inertia_y": 4.81e-7,
    "inertia_z": 2.69e-7,
    "torsion_constant": 7.5e-7,
}
MANEUVERS: list[dict[str, Any]] = [
    {"kind": "none"},
    {"kind": "stop", "rate": 0.6, "duration": 0.01},
    {"kind": "spin-up", "rate": 0.6, "duration": 0.01},
    {"kind": "slew", "angle": 0.1, "duration": 0.02},
    {"kind": "slew", "angle": 0.1, "duration": 0.02, "profile": "bang-bang"},
    {
        "kind": "slew",
        "angle": 0.1,
        "duration": 0.02,
        "profile": "input-shaped",
        "shaper": "ZV",
        "frequency": 50.0,
        "damping_ratio": 0.01,
    },
    {"kind": "tabulated", "times": [0.0, 0.01, 0.02], "rates": [0.0, 0.3, 0.1]},
    {"kind": "base-acceleration", "acceleration": 1.0, "duration": 0.01},
    {
        "kind": "sequence",
        "steps": [{"kind": "slew", "angle": 0.1, "duration": 0.01}, {"kind": "slew", "angle": -0.1, "duration": 0.01}],
    },
]
METHODS: list[dict[str, Any]] = [
    {"method": "wilson-theta", "theta": 1.4},
    {"method": "generalized-alpha", "rho_inf": 0.8},
    {"method": "newmark"},
    {"method": "hht", "alpha": 0.05},
    {"method": "bathe"},
    {"method": "energy-conserving"},
    {"method": "central-difference"},
    {"method": "newmark", "adaptive_tolerance": 1e-4},
]
INPUTS: list[dict[str, Any]] = [
    {"kind": "nodal-force", "near": [0.1, 0.2], "force": [0.0, 0.0, 0.1]},
    {"kind": "nodal-force", "side": "+x", "force": {"times": [0.0, 0.01], "values": [[0, 0, 0], [0, 0, 1.0]]}},
    {"kind": "edge-force", "nodes": [0, 1], "force": [0.1, 0.0, 0.0]},
    {"kind": "cable-tension", "side": "-x", "change": 0.05},
    {"kind": "membrane-temperature", "change": 1.0, "expansion": 2e-5},
    {"kind": "pressure", "pressure": 0.1},
]
DAMPINGS: list[dict[str, Any]] = [
    {"alpha": 0.01, "beta": 0.01},
    {"kind": "modal", "ratio": 0.01, "modes": 3},
    {"kind": "modal", "ratio": [0.01, 0.02]},
]
WILD: list[Any] = [
    *(0, 1, -1, 2, 10**6, 10**19, -(10**400), 0.0, -0.0, 1.0, 0.5, -0.5, 1e-30, 1e-15, 1e-8, 1e8, 1e15, 1e30, 1e300),
    *(
        5e-324,
        float("nan"),
        float("inf"),
        True,
        "",
        "elastic",
        "none",
        [],
        [0.0],
        [1.0, 2.0],
        [0.0, 0.0, 0.0],
        {},
        {"a": 1},
    ),
]


def generated(seed: int, samples: object = None, *, binary: bool = False) -> bytes:
    """Text of a case."""
    chance = random.Random(seed)
    case = copy.deepcopy(_sensible(chance))
    for _ in range(chance.choice((0, 1, 1, 1, 2, 2, 3, 5))):
        _spoil(chance, case)
    return tomli_w.dumps(case).encode()


def warm_up() -> list[bytes]:
    """Compile what the cases will need, which takes its time once."""
    for seed in range(60):
        with suppress(tf.TautflexError):
            tf.run_case(tf.Case(**_sensible(random.Random(seed))))
    return []


def _sensible(chance: random.Random) -> dict[str, Any]:
    step = 10.0 ** chance.uniform(-5, -2)
    case: dict[str, Any] = {
        "schema": 1,
        "membrane": {**FILM, "strain": chance.choice(("von-karman", "green-lagrange"))},
        "mesh": {
            "divisions": [chance.randint(2, 6), chance.randint(2, 4)],
            "pattern": chance.choice(("alternating", "regular")),
            "element": chance.choice(("triangle3", "triangle3", "triangle6", "quad4")),
        },
        "maneuver": dict(chance.choice(MANEUVERS)),
        "solver": {**chance.choice(METHODS), "time_step": step, "end_time": step * chance.randint(2, MOST_STEPS)},
        "output": {"probes": {"A": [0.3, 0.2]}, "fields": chance.choice(("none", "all", [0.0]))},
        "damping": dict(chance.choice(DAMPINGS)),
    }
    if case["mesh"]["element"] == "quad4":
        del case["mesh"]["pattern"]
    if chance.random() < 0.6:
        along, across = case["mesh"]["divisions"]  # a cable at every node keeps the film taut
        counts = {"per_long_edge": along + 1, "per_short_edge": across + 1}
        slack = {"slack": chance.random() < 0.3, "distribution": chance.choice(("equal", *3 * ("tributary",)))}
        case["cables"] = {**CABLES, **counts, **slack}
        case["frame"] = {**FRAME, "support": chance.choice(("corners", "all", "all", "axis", "short-side", "free"))}
        case["prestress"] = {"mode": chance.choice(("equilibrium", "uniform", "uniform", "initial-strain"))}
        if case["prestress"]["mode"] == "uniform":
            case["prestress"]["resultant_per_pretension"] = [0.707, 0.547]
    else:
        case["membrane"] |= {"edges": "fixed", "stress_x": 4e3, "stress_y": 4e3}
    if chance.random() < 0.3:
        case["membrane"]["law"] = "tension-field"
    if chance.random() < 0.4:
        case["inputs"] = {"one": dict(chance.choice(INPUTS))}
    if chance.random() < 0.15:
        case["reduction"] = {"count": 2, "candidates": 4}
        case["solver"].pop("adaptive_tolerance", None)
        case["membrane"].pop("law", None)
        case.get("cables", {}).pop("slack", None)
    return case


def _spoil(chance: random.Random, case: dict[str, Any]) -> None:
    """Change one value anywhere: scaled, of another sign, wild, or gone; mostly numbers, which get far."""
    leaves = list(_leaves(case))
    weights = [
        8 if isinstance(table[place], int | float) and table[place] is not True else 1 for table, place in leaves
    ]
    table, place = chance.choices(leaves, weights)[0]
    value, way = table[place], chance.random()
    if way < 0.8 and isinstance(value, int | float) and value is not True and abs(value) < 1e300:
        decades = chance.choice((1, 1, 3, 12, 12, 25))
        scaled = value * 10.0 ** chance.uniform(-decades, decades) * chance.choice((1, 1, 1, 1, -1))
        table[place] = type(value)(scaled) if abs(scaled) < 1e18 else scaled
    elif way < 0.95 or isinstance(table, list):
        table[place] = chance.choice(WILD)
    else:
        del table[place]


def _leaves(table: Any) -> Iterator[tuple[Any, Any]]:
    """Tables and lists inside a table, and each place in them."""
    for place, value in table.items() if isinstance(table, dict) else enumerate(table):
        if isinstance(value, dict | list) and value:
            yield from _leaves(value)
        else:
            yield table, place


def run(path: Path) -> None:
    """Build, prestress and run a case, a few steps of it; what ends well has finite numbers."""
    case = tf.load_case(path)
    if case.solver.end_time > MOST_STEPS * case.solver.time_step:
        case = case.replaced(solver={"end_time": MOST_STEPS * case.solver.time_step})
    if case.solver.adaptive_tolerance is not None and case.solver.min_step is None:
        case = case.replaced(solver={"min_step": case.solver.time_step / 4.0})
    if case.mesh.divisions[0] * case.mesh.divisions[1] > MOST_CELLS:
        return  # a big mesh takes its time
    found = tf.run_case(case, _Watch())
    if found.status is Status.COMPLETED:
        for name in ("w", "kinetic_energy", "strain_energy"):
            if name in found.data and not np.isfinite(found.data[name].values).all():
                raise AssertionError(f"completed, but {name} has numbers that are not finite")


class _Watch:
    """Ends a run of many small steps, as a user would."""

    def __init__(self) -> None:
        import time

        self._clock, self._end = time.process_time, time.process_time() + MOST_SECONDS

    def __call__(self, fraction: float, message: str) -> None:
        if self._clock() > self._end:
            raise KeyboardInterrupt
