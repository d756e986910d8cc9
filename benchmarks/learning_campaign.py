"""Five policies and four tuned laws before the judge of tautflex/Slew-v0: the table of docs/learning.md.

Run ``python benchmarks/learning_campaign.py``. Laws are tuned with the same budget, policies are trained as
``tautflex train --iterations`` does, and all of them meet the same scenarios on the full model. Everything that is
finished is kept in the folder, and a campaign that was interrupted goes on there. ``--write`` puts the table into
docs/learning.md. On two quiet cores training takes 5 minutes a policy, and an episode of the full model
about 8 s of processor time (more on a busy machine).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import tautflex as tf
from tautflex.learning.arena import Arena
from tautflex.learning.cases import task_case
from tautflex.learning.judging.baselines import baseline
from tautflex.learning.judging.evaluate import summary
from tautflex.learning.judging.scenarios import Scenario, scenarios_of
from tautflex.learning.judging.tune import numbers_of, with_numbers
from tautflex.learning.train import train

LAWS = ("pd", "zvd+pd", "lqg", "zvd+lqg")
PAGE = Path(__file__).parent.parent / "docs" / "learning.md"
MARKS = "<!-- campaign -->\n", "<!-- end of campaign -->\n"


def tuned(name: str, arena: Arena, folder: Path, budget: float) -> tf.ControlLaw:
    """A law by its name with the numbers that were found for it."""
    law, place = baseline(name, arena), folder / f"{name}.json"
    if not place.exists():
        found = tf.tune_law(law, arena, budget)
        place.write_text(json.dumps({"numbers": list(numbers_of(found.law)), "cost": found.cost}))
        print(f"{name}: {found!r}", flush=True)
    return with_numbers(law, iter(json.loads(place.read_text())["numbers"]))


def trained(seed: int, folder: Path, iterations: int) -> tf.PolicyLaw:
    """A policy of a seed."""
    place = folder / f"seed-{seed}.npz"
    if not place.exists():
        found = train("slew", iterations=iterations, seed=seed, checkpoint=folder / f"training-{seed}.npz")
        found.policy.save(place)
        print(f"seed {seed}: cost {found.cost:.4g}, law alone {found.start_cost:.4g}", flush=True)
    return tf.PolicyLaw(str(place))


def rows(found: xr.Dataset, title: str) -> list[str]:
    """The table, and how the policies compare with the best law."""
    told = summary(found)
    lines = [
        f"| {title} | cost | 95 % interval | worst | settling [s] | rms [µm] | rms, full over reduced | failures |",
        "|---|---|---|---|---|---|---|---|",
    ]
    gaps = dict[str, float]()
    for name, own in told.items():
        rms = found["surface_rms"].sel(law=name)
        gaps[name] = float((rms.sel(plant="full") / rms.sel(plant="reduced")).median())
        low, high = own["interval"]
        settling = "-" if own["settling_time"] is None else f"{own['settling_time']:.2f}"
        micro = "-" if own["surface_rms"] is None else f"{1e6 * own['surface_rms']:.2f}"
        lines.append(
            f"| {name} | {own['cost']:.3f} | {low:.2f} to {high:.2f} | {own['worst_cost']:.2f} | {settling} | "
            f"{micro} | {gaps[name]:.2f} | {own['failures']} |"
        )
    laws, policies = ([name for name in told if (name in LAWS) is own] for own in (True, False))
    if not laws or not policies:
        return lines
    best = min(laws, key=lambda name: told[name]["cost"])
    full = found.sel(plant="full")

    def ratio(key: str) -> float:
        values = [np.inf if told[name][key] is None else told[name][key] for name in policies]
        return float(np.mean(values) / min(told[name][key] or np.inf for name in laws))

    own, strong = full["cost"].sel(law=policies), full["cost"].sel(law="zvd+pd")
    lines += [
        "",
        f"Mean of the policies over the best law, each quantity by itself: cost {ratio('cost'):.2f} ({best}), settling "
        f"{ratio('settling_time'):.2f}, rms {ratio('surface_rms'):.2f}. Of {own.size} episodes "
        f"{int((own > strong).sum())} cost more than under zvd+pd.",
    ]
    return lines


def main() -> None:
    """Tune, train, judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("campaign"), help="folder (default %(default)s)")
    parser.add_argument("--policies", type=int, default=5, help="how many seeds (default %(default)s)")
    parser.add_argument("--iterations", type=int, default=2000, help="of a training (default %(default)s)")
    parser.add_argument("--budget", type=float, default=1500.0, help="plant time to tune a law [s]")
    parser.add_argument("--angles", type=int, default=4, help="angles of the scenarios (default %(default)s)")
    parser.add_argument("--seeds", type=int, default=2, help="seeds of their noise (default %(default)s)")
    parser.add_argument("--laws", nargs="+", default=LAWS, choices=LAWS, help="beside the policies (default: all)")
    parser.add_argument("--workers", type=int, default=None, help="processes (default: one per core)")
    parser.add_argument(
        "--write",
        type=Path,
        nargs="?",
        const=PAGE,
        help="write the table into this page (its default: docs/learning.md)",
    )
    asked = parser.parse_args()
    folder: Path = asked.output
    folder.mkdir(parents=True, exist_ok=True)
    case = task_case("slew")
    arena = Arena(case)
    laws: dict[str, Any] = {name: tuned(name, arena, folder, asked.budget) for name in asked.laws}
    laws |= {f"policy {seed}": trained(seed, folder, asked.iterations) for seed in range(asked.policies)}
    kept: Any = {"directory": folder / "episodes", "workers": asked.workers}
    grid = scenarios_of(arena.task, asked.angles, seeds=asked.seeds)
    lines = rows(tf.evaluate(laws, case, scenarios=grid, **kept), "as judged")
    weak = {"torque": 0.8}
    harder = [Scenario(each.parameters, each.tension_error, each.seed, weak) for each in grid if each.tension_error > 0]
    lines += ["", *rows(tf.evaluate(laws, case, scenarios=harder, **kept), "tension + 5 %, wheel at 80 %")]
    text = "\n".join(lines) + "\n"
    (folder / "table.md").write_text(text, encoding="utf-8")
    print(text)
    if asked.write:
        before, _, rest = asked.write.read_text(encoding="utf-8").partition(MARKS[0])
        asked.write.write_text(f"{before}{MARKS[0]}{text}{MARKS[1]}{rest.partition(MARKS[1])[2]}", encoding="utf-8")


if __name__ == "__main__":
    main()
