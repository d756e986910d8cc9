"""Every run that the reproduction knows, by name; each is an ordinary case that a user can write to a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np

from tautflex.case import Case, parse_case, template
from tautflex.errors import InputError
from tautflex.paper.cases.run_names import DURATIONS, MODELS, RATES, SECTION_3, run_name
from tautflex.paper.tables import published

Variant = Literal["published", "nearest-node", "consistent"]
VARIANTS: tuple[Variant, ...] = ("published", "nearest-node", "consistent")
READINGS: dict[str, str] = {"published": "m2-paper", "nearest-node": "m2-nearest-node", "consistent": "m2"}
"""Template of each variant: the reading that follows the published tables best, the first one, and a structure that
could be built."""

QUICK_TIME_STEP = 5e-3  # [s]; amplitudes within 0.5 % of those at 1 ms
_SNAPSHOT_INTERVAL = 0.01  # [s], of the fields for the proper orthogonal decomposition

COARSE_MESHES = ((10, 5), (20, 10))
"""Meshes [cells] beside the consistent case's own, for its convergence."""
FITTED_MESHES: dict[tuple[int, int], tuple[float, float]] = {
    (8, 4): (0.648, 0.577),
    (16, 8): (0.809, 0.576),
    (20, 10): (0.830, 0.580),
}
"""Meshes beside the published reading's own -> film tension per pretension [1/m], fitted to Table 2 there as well."""
OTHER_STEPS: dict[str, dict[str, Any]] = {
    "steps of 2.5 ms": {"time_step": 2.5e-3},
    "generalized-alpha": {"method": "generalized-alpha", "theta": None},
    "generalized-alpha, steps of 2.5 ms": {"method": "generalized-alpha", "theta": None, "time_step": 2.5e-3},
}
"""Solvers beside the published reading's own, by the last part of a run's name."""
STEP_CHECK = (("M1", "pi_5", 0.1), ("M2", "pi_100", 0.1), ("M3", "pi_5", 1.0))
"""Runs of the consistent variant that are repeated with half the time step."""
ABLATION_MANEUVERS = (("pi_5", 0.1), ("pi_5", 1.0))
"""Maneuvers of the ablation: the strongest excitation the three models share, and the paper's section 3."""
LINEAR_FACTORS = {"M1": 2e-3, "M2": 5e-3, "M3": 1e-2}
"""Angular velocity of the small-amplitude limit, relative to the maneuver's own: the softer the antenna, the sooner it
hardens; the stiffer, the sooner the start's tiny centrifugal load drowns in the round-off of the pretension."""
ABLATIONS: dict[str, tuple[str, ...]] = {
    "no-gyroscopic": ("gyroscopic",),
    "no-euler": ("euler",),
    "no-centrifugal": ("centrifugal",),
    "no-rotation": ("gyroscopic", "euler", "centrifugal"),
    "no-load": ("inertial_load",),
    "linear": (),
}
"""Suffix of a run's name: terms of the rotating frame that are switched off."""


@dataclass(frozen=True)
class RunSpec:
    """One run: an ordinary case under a name.

    Attributes
    ----------
    name
        E.g. ``published/M1/pi_2/T0.1``; suffixes tell what is unusual.
    case
        What `tautflex run` would run.
    variant
        One of `VARIANTS`.
    model
        ``"M1"``, ``"M2"`` or ``"M3"``.
    rate, duration
        Angular velocity before the stop [rad/s], of the small-amplitude limit the scaled one, and its duration [s].
    """

    name: str
    case: Case
    variant: Variant
    model: str
    rate: float
    duration: float


def catalogue(variant: Variant = "published", quick: bool = False) -> dict[str, RunSpec]:
    """List the runs of a variant by name.

    Parameters
    ----------
    variant
        ``"published"``: section 3, section 4, the ablation, and the runs of Tables 6 to 9 on four meshes and with other
        solvers. ``"nearest-node"``: section 3 and the runs of Tables 6 to 9. ``"consistent"``: the same, on three
        meshes, some with half the time step.
    quick
        A time step of 5 ms, on one mesh, of the published reading; the others have no quick form.

    Raises
    ------
    InputError
        If ``variant`` is unknown.
    """
    if variant not in VARIANTS:
        raise InputError(f"variant: expected one of {', '.join(map(repr, VARIANTS))}, got {variant!r}")
    if variant == "published":
        specs = _published_runs(quick)
    else:
        specs = _nearest_node_runs() if variant == "nearest-node" else _consistent_runs()
    return {spec.name: spec for spec in specs}


def model_case(model: str, variant: str = "published", divisions: tuple[int, int] | None = None) -> Case:
    """Return the case of an antenna, M2's with the tensions of M1 or M3 [paper, Table 4].

    Parameters
    ----------
    model
        ``"M1"``, ``"M2"`` or ``"M3"``.
    variant
        One of `VARIANTS`.
    divisions
        Another mesh: cables stay at every edge node. In the published reading, one of `FITTED_MESHES`, each has the
        same tension and area; in the others those per length of edge are kept, and the cells must keep their shape,
        since all cables have one area.

    Raises
    ------
    InputError
        If ``divisions`` stretch the cells.
    """
    base = _base(variant)
    assert base.cables is not None
    tension = {row["model"]: (row["pretension_x"], row["pretension_y"]) for row in published.table(4)}
    ratio_x, ratio_y = (wanted / own for wanted, own in zip(tension[model], tension["M2"], strict=True))
    pull_x, pull_y = base.cables.pretensions
    cells = base.mesh.divisions if divisions is None else divisions
    cables: dict[str, Any]
    if variant == "published":
        cables = {
            "pretension_x": _rounded(pull_x * ratio_x),
            "pretension_y": _rounded(pull_y * ratio_y),
        }
        if divisions is None:
            return base.replaced(cables=cables)
        cables |= {"per_long_edge": cells[0] + 1, "per_short_edge": cells[1] + 1}
        fitted = {"resultant_per_pretension": FITTED_MESHES[cells]}
        return base.replaced(cables=cables, mesh={"divisions": cells}, prestress=fitted)
    if cells[0] * base.mesh.divisions[1] != cells[1] * base.mesh.divisions[0]:
        text = f"divisions: expected cells shaped like those of {base.mesh.divisions}, got {cells}"
        raise InputError(f"{text}; refine both directions alike")
    spacing = base.mesh.divisions[0] / cells[0]
    assert base.cables.area is not None
    cables = {
        "pretension_x": _rounded(pull_x * ratio_x * spacing),
        "pretension_y": _rounded(pull_y * ratio_y * spacing),
    }
    if divisions is None:
        return base.replaced(cables=cables)
    cables |= {
        "per_long_edge": cells[0] + 1,
        "per_short_edge": cells[1] + 1,
        "area": _rounded(base.cables.area * spacing),
    }
    return base.replaced(cables=cables, mesh={"divisions": cells})


def response_runs(variant: str = "published", tables: Iterable[int] = published.RESPONSE_TABLES) -> list[str]:
    """List the names of the runs behind Tables 6 to 9, each once."""
    rows = (row for number in tables for row in published.table(number))
    return list(dict.fromkeys(run_name(row["model"], row["rate_name"], row["duration"], variant) for row in rows))


def ablation_runs(model: str, rate: str, duration: float) -> dict[str, str]:
    """Return what is switched off -> name of the run; ``"full"`` has everything."""
    full = run_name(model, rate, duration)
    return {"full": full} | {suffix: f"{full}/{suffix}" for suffix in ABLATIONS}


def mesh_name(name: str, divisions: tuple[int, int]) -> str:
    """Return the name of a run or an antenna on another mesh."""
    return f"{name}/mesh{divisions[0]}x{divisions[1]}"


def case_text(variant: str) -> str:
    """Return the commented case file of M2 in a variant."""
    return template(READINGS[variant])


def half_step_name(name: str) -> str:
    """Return the name of a run with half the time step."""
    return f"{name}/half-step"


def _published_runs(quick: bool) -> Iterator[RunSpec]:
    step = {"time_step": QUICK_TIME_STEP} if quick else {}
    maneuvers: dict[tuple[str, float], tuple[str, ...]] = {(rate, 0.1): MODELS for rate in RATES if rate != "pi_50"}
    maneuvers |= {("pi_50", 0.1): ("M1",), ("pi_2", 1.0): ("M2",)}
    maneuvers |= {("pi_5", duration): MODELS for duration in DURATIONS}
    for (rate, duration), models in maneuvers.items():
        for model in models:
            yield _spec(run_name(model, rate, duration), "published", model, rate, duration, solver=step)
    yield _section_3_run("published", step)
    for rate, duration in ABLATION_MANEUVERS:
        for model in MODELS:
            for suffix, name in ablation_runs(model, rate, duration).items():
                if suffix != "full":
                    factor = LINEAR_FACTORS[model] if suffix == "linear" else 1.0
                    off = dict.fromkeys(ABLATIONS[suffix], False)
                    yield _spec(name, "published", model, rate, duration, factor, solver=step, coupling=off)
    if not quick:
        for run in _response_maneuvers():
            name = run_name(*run)
            for cells in FITTED_MESHES:
                yield _spec(mesh_name(name, cells), "published", *run, divisions=cells)
            for words, solver in OTHER_STEPS.items():
                yield _spec(f"{name}/{words}", "published", *run, solver=solver)


def _nearest_node_runs() -> Iterator[RunSpec]:
    yield _section_3_run("nearest-node", {})
    for run in _response_maneuvers():
        yield _spec(run_name(*run, variant="nearest-node"), "nearest-node", *run)


def _response_maneuvers() -> list[tuple[str, str, float]]:
    """Antenna and maneuver of every run of Tables 6 to 9, each once."""
    rows = [row for number in published.RESPONSE_TABLES for row in published.table(number) if "repeats" not in row]
    return [(row["model"], row["rate_name"], row["duration"]) for row in rows]


def _consistent_runs() -> Iterator[RunSpec]:
    half = {"time_step": _base("consistent").solver.time_step / 2}
    yield _section_3_run("consistent", {})
    for run in _response_maneuvers():
        name = run_name(*run, variant="consistent")
        yield _spec(name, "consistent", *run)
        for cells in COARSE_MESHES:
            yield _spec(mesh_name(name, cells), "consistent", *run, divisions=cells)
        if run in STEP_CHECK:
            yield _spec(half_step_name(name), "consistent", *run, solver=half)


def _section_3_run(variant: Variant, step: dict[str, Any]) -> RunSpec:
    """Return the run of Table 3 and Figures 4 to 7, with fields for the proper orthogonal decomposition."""
    return _spec(
        run_name("M2", "pi_5", 1.0, variant, SECTION_3), variant, "M2", "pi_5", 1.0,
        solver=step, damping=_damping(variant, 0.01), output={"fields": _snapshots(_base(variant))},
    )  # fmt: skip


def _damping(variant: str, factor: float) -> dict[str, Any]:
    """Alpha and beta of a size, of the kinds of element that a variant damps."""
    beta = _base(variant).damping.beta
    by_kind = isinstance(beta, dict)
    return {"alpha": factor, "beta": {kind: factor * (own > 0.0) for kind, own in beta.items()} if by_kind else factor}


def _spec(
    name: str,
    variant: Variant,
    model: str,
    rate: str,
    duration: float,
    factor: float = 1.0,
    divisions: tuple[int, int] | None = None,
    **sections: dict[str, Any],
) -> RunSpec:
    velocity = RATES[rate] * factor
    maneuver = {"rate": velocity, "duration": duration}
    output = {"fields": "none", "frames": 0, **sections.pop("output", {})}
    case = model_case(model, variant, divisions).replaced(maneuver=maneuver, output=output, **sections)
    return RunSpec(name, case, variant, model, velocity, duration)


def _snapshots(case: Case) -> tuple[float, ...]:
    count = round(case.solver.end_time / _SNAPSHOT_INTERVAL)
    return tuple(_rounded(instant) for instant in np.arange(count + 1) * _SNAPSHOT_INTERVAL)


def _rounded(value: float) -> float:
    """Drop the round-off of a product, so that a case shows 0.147 and not 0.14700000000000002."""
    return float(f"{value:.12g}")


@cache
def _base(variant: str) -> Case:
    # Every reading is stepped by the paper's method.
    return parse_case(case_text(variant), ["solver.method=wilson-theta"], source=f"{READINGS[variant]}.toml")
