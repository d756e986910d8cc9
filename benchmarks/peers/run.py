"""Run tautflex beside its peers and write the comparison.

``python benchmarks/peers/run.py`` (``make benchmark-peers``) writes ``benchmarks.md``, ``benchmarks.json`` and
``figures/cost_against_size.png`` into the output folder. A peer that is not installed is reported in one line and left
out. All of it takes about an hour, ``--quick`` a few minutes.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import sys
from pathlib import Path
from typing import Any

from figure import cost_figure
from film import SIZES, compare_film, size_study
from film_problem import BLOW, GENTLE
from hub_problem import hub_problem
from programs import FILM, FILM_QUADRATIC, HUB, ROOT, SPINUP, Program
from spinup import compare_beams
from spinup_problem import spinup_problem
from table import page

FILMS = {
    "film": (FILM, "triangle3", (40, 20), BLOW),
    "film_gentle": (FILM[:3], "triangle3", (40, 20), GENTLE),
    "film_quadratic": (FILM_QUADRATIC, "triangle6", (20, 10), BLOW),
}
BEAMS = {"spinup": (SPINUP, spinup_problem), "hub": (HUB, hub_problem)}
BENCHMARKS = (*FILMS, *BEAMS, "size")


def report(line: str) -> None:
    """Say what is going on."""
    print(line, file=sys.stderr, flush=True)


def present(programs: tuple[Program, ...], missing: list[str]) -> tuple[Program, ...]:
    """Programs that can run; what is missing is reported and collected."""
    found = []
    for program in programs:
        reason = program.missing()
        if reason is None:
            found.append(program)
        elif reason not in missing:
            missing.append(reason)
            report(f"{reason}; going on without it")
    return tuple(found)


def machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    processor = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        processor = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "processor": processor,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
    }


def provenance(script: str) -> dict[str, Any]:
    """When, on what and by which command a part was measured."""
    return {
        "machine": machine(),
        "command": " ".join([f"python benchmarks/peers/{script}", *sys.argv[1:]]),
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
    }


def stored(folder: Path) -> dict[str, Any]:
    """Numbers that were written before."""
    file = folder / "benchmarks.json"
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def output(parser: argparse.ArgumentParser) -> None:
    """Let the command line choose where to write."""
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs", help="folder to write to (default docs)")


def arguments() -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=BENCHMARKS, nargs="+", default=BENCHMARKS, help="benchmarks to run")
    parser.add_argument("--rounds", type=int, default=3, help="pairs of runs per peer (default 3)")
    parser.add_argument("--steps", type=int, default=2000, help="steps of the film (default 2000)")
    parser.add_argument("--timeout", type=float, default=1800.0, help="allowed seconds of one run (default 1800)")
    parser.add_argument("--page", action="store_true", help="run nothing, write the page again from benchmarks.json")
    parser.add_argument("--quick", action="store_true", help="one round, 200 steps, few beams, small meshes")
    output(parser)
    chosen = parser.parse_args()
    if chosen.quick:
        chosen.rounds, chosen.steps = 1, 200
    return chosen


def run_part(name: str, chosen: argparse.Namespace, missing: list[str]) -> dict[str, Any]:
    """Numbers of one benchmark."""
    report(name)
    if name in FILMS:
        programs, element, divisions, speeds = FILMS[name]
        return compare_film(present(programs, missing), divisions, chosen.steps, chosen.rounds, report, element, speeds)
    if name in BEAMS:
        programs, build = BEAMS[name]
        quick = {"elements": (4, 8), "steps": (0.02,), "finest": (16, 0.01)} if chosen.quick else {}
        return compare_beams(present(programs, missing), build, chosen.rounds, report, **quick)
    sizes = {mesh: count for mesh, count in SIZES.items() if not chosen.quick or mesh[0] <= 80}
    return size_study(present(FILM, missing), sizes, chosen.timeout, report)


def write(results: dict[str, Any], folder: Path) -> str:
    """Write numbers, figure and page; the page."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "benchmarks.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    if "size" in results:
        cost_figure(results["size"]["rows"], folder / "figures" / "cost_against_size.png")
    text = page(results)
    (folder / "benchmarks.md").write_text(text, encoding="utf-8")
    return text


def main() -> None:
    """Run, write after every part, print the page."""
    chosen = arguments()
    # A part that is not run again keeps its numbers.
    results = stored(chosen.output)
    missing: list[str] = []
    for name in () if chosen.page else chosen.only:
        results[name] = run_part(name, chosen, missing) | provenance("run.py")
        results |= {"missing": missing}
        write(results, chosen.output)
    if not results:
        sys.exit(f"{chosen.output / 'benchmarks.json'}: no numbers yet; run without --page first")
    print(write(results, chosen.output))


if __name__ == "__main__":
    main()
