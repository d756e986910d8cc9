"""Error against time of the struck film: elements, meshes, methods and steps of ours beside DOLFINx's.

Ours are two programs: the whole equation of motion, which DOLFINx solves too, and `tf.CondensedDifference`, where the
film follows statically in its plane.

``python benchmarks/peers/accuracy_for_time.py`` runs settings from the cheapest to the dearest until its budget of
processor time is spent, and writes the section "Error against time" of ``docs/benchmarks.md``, its numbers and its
figure. Every run is written down when it is done; the next call goes on there. ``--fresh`` begins anew.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from figure import accuracy_figure
from film_problem import film_problem
from pairs import compare, run_once
from programs import FILM, ROOT, Program, ProgramFailedError
from run import output, provenance, report, stored, write

END, GRID, TOLERANCE = 2.0, 4e-3, 1e-5
# Mean-square error over that of the record, and what else is paired.
TARGETS = (0.01, 0.05)
# Settings that are foretold to take this many times as long as the first within the target are not tried.
BEYOND = 3.0
MESHES = {
    "triangle3": ((20, 10), (40, 20), (80, 40), (160, 80)),
    "triangle6": ((10, 5), (20, 10), (30, 15), (40, 20), (50, 25)),
}
STEPS = (4e-3, 2e-3, 1e-3, 5e-4)
METHODS = ("newmark", "wilson", "generalized-alpha", "bathe")
# Tolerances of adaptive steps, by the trapezoidal rule; a run of one takes about this many steps.
ADAPTIVE = {3e-3: 700, 1e-3: 1200, 3e-4: 2200, 1e-4: 4000}
WHOLE, CONDENSED = FILM[0].name, f"{FILM[0].name}, static in the plane"
# Explicit steps beyond the stable one are halved, so that longer ones cost no less.
EXPLICIT, EXPLICIT_STEPS = "condensed-difference", (2e-3, 1e-3, 5e-4, 2.5e-4)


@dataclass(frozen=True)
class Setting:
    """One way to compute the film; ``step`` [s] is the grid of results where ``adaptive`` is a tolerance."""

    program: str
    element: str
    divisions: tuple[int, int]
    method: str
    step: float
    adaptive: float | None = None

    @property
    def foretold(self) -> float:
        """Cost in arbitrary units: nodes to the power of 1.15, by steps, by stages."""
        cells = self.divisions[0] * self.divisions[1] * (4 if self.element == "triangle6" else 1)
        steps = END / self.step if self.adaptive is None else ADAPTIVE[self.adaptive]
        return cells**1.15 * steps * {"bathe": 1.7, EXPLICIT: 0.3}.get(self.method, 1.0)

    @property
    def problem(self) -> dict[str, np.ndarray]:
        """Arrays of the problem file."""
        count, every = round(END / self.step), round(GRID / self.step)
        return film_problem(self.divisions, self.step, count, TOLERANCE, self.element, every=every)

    @property
    def solver(self) -> Program:
        """The program with the options of this setting."""
        if self.program not in (WHOLE, CONDENSED):
            return next(program for program in FILM if program.name == self.program)
        accuracy = () if self.adaptive is None else (str(self.adaptive),)
        return replace(FILM[0], options=(self.method, *accuracy))

    def __str__(self) -> str:
        size = f"tolerance {self.adaptive:g}" if self.adaptive else f"{1e3 * self.step:g} ms"
        return f"{self.element} {self.divisions[0]} x {self.divisions[1]}, {self.method}, {size}"


REFERENCE = Setting("tautflex", "triangle6", (60, 30), "newmark", 2.5e-4)
OTHER = Setting(CONDENSED, "triangle6", (60, 30), EXPLICIT, 2.5e-4)
NEXT_FINEST = Setting("tautflex", "triangle6", (40, 20), "newmark", 2.5e-4)


def settings(quick: bool) -> list[Setting]:
    """Everything that may be tried, cheapest first."""
    tried = []
    for element, meshes in MESHES.items():
        for divisions in meshes[: 1 if quick else None]:
            for step in STEPS[: 2 if quick else None]:
                tried += [
                    Setting("tautflex", element, divisions, method, step) for method in METHODS[: 1 if quick else None]
                ]
                tried += [Setting("DOLFINx, factors kept", element, divisions, "newmark", step)]
            explicit = EXPLICIT_STEPS[: 2 if quick else None]
            tried += [Setting(CONDENSED, element, divisions, EXPLICIT, step) for step in explicit]
            for tolerance in tuple(ADAPTIVE)[: 1 if quick else None]:
                tried += [Setting("tautflex", element, divisions, "newmark", GRID, tolerance)]
    return sorted(tried, key=lambda setting: setting.foretold)


class Runs:
    """What has been run, kept in a file that the next call reads."""

    def __init__(self, path: Path, fresh: bool) -> None:
        self._path = path
        self.known: dict[str, Any] = {}
        if path.exists() and not fresh:
            self.known = json.loads(path.read_text(encoding="utf-8"))

    def __call__(self, setting: Setting) -> dict[str, Any]:
        """Deflection on the grid and processor seconds of a setting, computed once."""
        name = f"{setting.program}: {setting}"
        if name not in self.known:
            try:
                result = run_once(setting.solver, setting.problem)
                deflection = result["displacement"][:, 2]
                record = deflection[:: (len(deflection) - 1) // round(END / GRID)].tolist()
                self.known[name] = {"seconds": float(result["seconds"]), "record": record}
            except ProgramFailedError as failure:
                self.known[name] = {"seconds": None, "record": None, "why": str(failure)}
            report(f"  {name}: {self.known[name]['seconds']} s")
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._path.write_text(json.dumps(self.known), encoding="utf-8")
        return self.known[name]


def error(record: list[float], reference: list[float]) -> float:
    """Mean-square difference over the mean square of the reference."""
    return float(np.linalg.norm(np.subtract(record, reference)) / np.linalg.norm(reference))


def search(runs: Runs, reference: Setting, budget: float, quick: bool) -> list[dict[str, Any]]:
    """Rows of all settings within the budget [s of processor time] and within `BEYOND` of the first on target."""
    exact, spent, reached = runs(reference)["record"], 0.0, {}
    rows = []
    for setting in settings(quick):
        if setting.foretold > BEYOND * reached.get(setting.program, np.inf) or spent > budget:
            continue
        done = runs(setting)
        spent += done["seconds"] or 0.0
        if done["record"] is None:
            continue
        row = asdict(setting) | {"seconds": done["seconds"], "error": error(done["record"], exact)}
        rows.append(row)
        if row["error"] <= TARGETS[0]:
            reached.setdefault(setting.program, setting.foretold)
    for row in rows:
        rivals = [other for other in rows if other["program"] == row["program"] and other is not row]
        row["best"] = not any(other["seconds"] <= row["seconds"] and other["error"] <= row["error"] for other in rivals)
    return rows


def paired(rows: list[dict[str, Any]], own: str, target: float, rounds: int) -> dict[str, Any] | None:
    """Pairs of the cheapest settings of a program of ours and of DOLFINx within an error, or None if one has none."""
    fit = {}
    for row in sorted(rows, key=lambda row: -row["seconds"]):
        if row["error"] <= target:
            names = Setting.__dataclass_fields__
            fit[row["program"]] = Setting(**{name: row[name] for name in names})
    if own not in fit or FILM[1].name not in fit:
        return None
    ours, theirs = fit[own], fit[FILM[1].name]
    _, entry = compare(ours.solver, (theirs.solver,), ours.problem, rounds, report, peers_problem=theirs.problem)
    return {
        "target": target,
        "program": own,
        "ours": str(ours),
        "theirs": str(theirs),
        "ratio": entry.ratio,
        "ratios": entry.ratios,
    }


def main() -> None:
    """Search, pair, write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--budget", type=float, default=1500.0, help="seconds of processor time (default %(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="pairs of the best settings (default %(default)s)")
    parser.add_argument("--fresh", action="store_true", help="forget what was run")
    parser.add_argument("--quick", action="store_true", help="the coarsest meshes and steps, to see that it works")
    output(parser)
    chosen = parser.parse_args()
    kept = ROOT / ".peers" / ("accuracy_quick.json" if chosen.quick else "accuracy.json")
    runs = Runs(kept, chosen.fresh)
    reference, finest, other = REFERENCE, NEXT_FINEST, OTHER
    if chosen.quick:
        reference, finest = (Setting("tautflex", "triangle6", cells, "newmark", 1e-3) for cells in ((20, 10), (14, 7)))
        other = replace(other, divisions=(20, 10), step=1e-3)
    rows = search(runs, reference, chosen.budget, chosen.quick)
    doubt, differs = (error(runs(each)["record"], runs(reference)["record"]) for each in (finest, other))
    found = [paired(rows, own, target, chosen.rounds) for target in TARGETS for own in (WHOLE, CONDENSED)]
    results = stored(chosen.output)
    results["accuracy"] = {
        "end": END,
        "target": TARGETS[0],
        "beyond": BEYOND,
        "reference": asdict(reference),
        "next_finest": asdict(finest) | {"error": doubt},
        "other": asdict(other) | {"error": differs},
        "rows": rows,
        "pairs": [pair for pair in found if pair],
    } | provenance("accuracy_for_time.py")
    accuracy_figure(rows, TARGETS[0], chosen.output / "figures" / "accuracy_for_time.png")
    print(write(results, chosen.output))


if __name__ == "__main__":
    main()
