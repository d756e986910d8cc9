"""What a study costs beside its runs: ``python benchmarks/studies.py`` (minutes), ``--points 1000`` for a look.

Film of 6 x 4 cells, four modes, 200 central differences. Times [ms] are those of processors, of all processes together;
points per second are those of the clock on the wall. Engines take turns, and medians are told.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import re
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any
from unittest.mock import patch

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests")]

import tautflex as tf  # noqa: E402
from tautflex.case import parse_case  # noqa: E402
from tautflex.study import work  # noqa: E402
from tautflex.study.results import study_dataset, write_table  # noqa: E402
from tautflex.study.sweep import Plan, make_plan  # noqa: E402
from unit.study_cases import FILM, PROBE  # noqa: E402

_SETTLED = 0.1  # part of the points after which all workers have started
CASE = FILM.replace("end_time = 0.4", "end_time = 1.0")


def study(points: int, kind: str = "serial", **measures: Any) -> tf.Study:
    """Rates times dampings, as many as there are points or nearly."""
    side = math.isqrt(points)
    axes = {
        "maneuver.rate": {"from": 0.05, "to": 0.2, "count": points // side},
        "damping.beta": {"from": 0.0, "to": 2e-3, "count": side},
    }
    return tf.Study(base=parse_case(CASE), axes=axes, engine={"kind": kind}, measures=measures)


def spent() -> float:
    """Processor time of this process and of those that it waited for [s]."""
    return sum(each.ru_utime + each.ru_stime for each in map(resource.getrusage, (0, resource.RUSAGE_CHILDREN)))


def each(count: int, call: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of a call for each of so many points [ms], and what it gave."""
    begun = spent()
    found = call()
    return 1e3 * (spent() - begun) / count, found


def overhead(points: int, folder: Path) -> dict[str, float]:
    """What the engine does for a point beside its run and measures [ms]."""
    asked = study(points)
    planned, plan = each(points, lambda: make_plan(asked, folder))
    case = plan.points.case(0)
    ready = work.prepared(case)
    run = work.simulated(case, ready, lambda fraction, message: None)
    measures = work.measures_of(case, ready, run[0], plan.task.names)
    with (
        patch.object(work, "simulated", return_value=run),
        patch.object(work, "measures_of", return_value=measures),
    ):
        done, _ = each(points, lambda: work.work(plan.task, range(points)))
    put_together(plan, folder)  # imports what it needs
    ended, _ = each(points, lambda: put_together(plan, folder))
    ran, _ = each(50, lambda: [whole_run(plan, number) for number in range(50)])
    return {"planned": planned, "in workers": done, "put together": ended, "engine": planned + done + ended, "run": ran}


def put_together(plan: Plan, folder: Path) -> None:
    """Dataset and table of a study."""
    write_table(study_dataset(plan.study, plan.points, plan.task.store, plan.keys, {}), folder / "table.csv")


def whole_run(plan: Plan, number: int) -> dict[str, float | None]:
    """Run of a point and all its measures, without its engine."""
    case = plan.points.case(number)
    ready = work.prepared(case)
    run, _ = work.simulated(case, ready, lambda fraction, message: None)
    return work.measures_of(case, ready, run, plan.task.names)


class Watch:
    """Cost and rate of points, and memory of worker processes [MB], when workers have started and in the end."""

    def __init__(self) -> None:
        self.seen = list[tuple[float, float, float]]()
        self.memory = list[list[int]]()

    def __call__(self, fraction: float, message: str) -> None:
        """Take note of a word."""
        if fraction < (1.0 if self.seen else _SETTLED):
            return
        workers = [Path(f"/proc/{one.pid}") for one in multiprocessing.active_children()]
        spent = [sum(map(int, (one / "stat").read_text().rpartition(")")[2].split()[11:13])) for one in workers]
        self.seen.append((fraction, time.perf_counter(), time.process_time() + sum(spent) / os.sysconf("SC_CLK_TCK")))
        found = (re.search(r"VmRSS:\s*(\d+)", (one / "status").read_text()) for one in workers)
        self.memory.append([int(line[1]) // 1000 for line in found if line])


def processes(points: int, workers: int, folder: Path) -> dict[str, Any]:
    """Numbers of a sweep in processes, their start and its end left out."""
    watch = Watch()
    tf.sweep(study(points, names=PROBE), folder, workers=workers, progress=watch)
    parts, seconds, cost = (last - first for first, last in zip(*watch.seen, strict=True))
    count = points * parts
    told = {"per_point": 1e3 * cost / count, "points_per_second": count / seconds}
    return {"workers": workers, **told, "megabytes": watch.memory}


def batch(points: int, folder: Path) -> float:
    """Processor time of a point in a batch [ms], compilation among it."""
    asked = study(points, "batch", names=PROBE)
    return each(points, lambda: tf.sweep(asked, folder))[0]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=10_000, help="points of a batch; a tenth is run one by one")
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args()
    few = math.isqrt(asked.points // 10) ** 2

    def tell(**numbers: Any) -> None:
        print(json.dumps(numbers), flush=True)

    with tempfile.TemporaryDirectory() as name:
        folders = (Path(name) / str(number) for number in range(10**6))
        tell(points=few, **overhead(few, next(folders)))
        single, double, many = [], [], []
        for _ in range(asked.rounds):
            single.append(processes(few, 1, next(folders)))
            double.append(processes(few, 2, next(folders)))
            many.append(batch(math.isqrt(asked.points) ** 2, next(folders)))
            tell(**single[-1])
            tell(**double[-1])
            tell(engine="batch", points=asked.points, per_point=many[-1])
        one, two = (median(one["per_point"] for one in rounds) for rounds in (single, double))
        faster = median(b["points_per_second"] / a["points_per_second"] for a, b in zip(single, double, strict=True))
        ratio = median(a["per_point"] / b for a, b in zip(single, many, strict=True))
        tell(one_process=one, two_processes=two, faster_on_two=faster, batch_over_serial=ratio)


if __name__ == "__main__":
    main()
