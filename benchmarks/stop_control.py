"""The paper's maneuver with and without control of the tension: the figure and the table of docs/learning.md.

The antennas M1, M2 and M3 [paper, Table 4] on the mesh and the soft tendons of tautflex/Stop-v0 stop from pi/5 rad/s
within a second, on the full model with Bathe's method. Run ``python benchmarks/stop_control.py`` (minutes).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tautflex.analysis import settling_time
from tautflex.control.loop import close_loop
from tautflex.learning.arena import Arena
from tautflex.learning.cases import task_case
from tautflex.learning.judging.baselines import baseline
from tautflex.learning.judging.scenarios import Told
from tautflex.paper.tables import published
from tautflex.plot.style import COLORS, DOUBLE_COLUMN, GREY, styled

FIGURE = Path(__file__).parent.parent / "docs" / "figures" / "stop_control.png"
STOP, TOLERANCE = 1.0, 2e-5  # end of the maneuver [s], rms of the film that counts as settled [m]
LAST = 1.0  # over whose end the residual is taken [s]


def arena_of(model: str) -> Arena:
    """Stop-v0 with the tensions of an antenna of the paper; reels reach 30 % of M2's at most, within some intervals.

    Larger or sudden changes send waves through the plane of the film that no step of milliseconds resolves.
    """
    case = task_case("stop")
    rows = {row["model"]: row for row in published.table(4)}
    ratio = {axis: rows[model][f"pretension_{axis}"] / rows["M2"][f"pretension_{axis}"] for axis in "xy"}
    tensions = {f"pretension_{axis}": ratio[axis] * getattr(case.cables, f"pretension_{axis}") for axis in "xy"}
    limits = {f"tension_{axis}": 0.5 * min(ratio[axis], 1.0) * case.actuators[f"tension_{axis}"].limit for axis in "xy"}
    actuators = {
        name: {**case.actuators[name].model_dump(exclude_none=True), "limit": limits[name], "lag": 0.02}
        for name in limits
    }
    return Arena(case.replaced(cables=tensions, actuators=actuators, solver={"method": "bathe", "rho_inf": None}))


def stopped(arena: Arena, law: str) -> Any:
    """Record of a stop."""
    task = arena.task
    plant = arena.plant("full", exact=False)
    return close_loop(plant, Told(baseline(law, arena), arena), task.maneuver(task.nominal()), task.duration).data


@styled
def drawn(records: dict[str, dict[str, Any]]) -> Figure:
    """Deflection at A over time, a panel for each antenna."""
    figure = Figure(figsize=(DOUBLE_COLUMN, 5.2), layout="constrained")
    panels = figure.subplots(len(records), 1, sharex=True)
    for axes, (model, laws) in zip(panels, records.items(), strict=True):
        for color, (law, data) in zip(COLORS, laws.items(), strict=False):
            time, w = data["sample_time"].values, 1e3 * data["measurement"].values[:, 0]
            axes.plot(time, w, color=color, label="without control" if law == "none" else "tension damping")
        axes.axvline(STOP, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)))
        axes.set(ylabel=f"{model}: $w_A$ [mm]", xlim=(0.0, float(time[-1])))
    panels[0].legend(loc="upper right", ncols=2)
    panels[-1].set_xlabel("time $t$ [s]")
    return figure


def main() -> None:
    """Draw the figure, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=FIGURE, help="figure (default %(default)s)")
    parser.add_argument("--models", nargs="+", default=["M1", "M2", "M3"], help="antennas (default: all)")
    asked = parser.parse_args()
    records = dict[str, dict[str, Any]]()
    print(
        "| antenna | law | largest at A after the stop [mm] | residual at A [µm] | residual of the film [µm] | "
        "film within 20 µm after [s] |"
    )
    print("|---|---|---|---|---|---|")
    for model in asked.models:
        arena = arena_of(model)
        records[model] = {law: stopped(arena, law) for law in ("none", "tension")}
        for law, data in records[model].items():
            time, w, rms = data["sample_time"].values, data["measurement"].values[:, 0], data["surface_rms"].values
            late = time >= time[-1] - LAST
            largest = np.abs(w[time >= STOP]).max()
            residual = [np.sqrt((each[late] ** 2).mean()) for each in (w, rms)]
            settled = float(settling_time(data["surface_rms"], TOLERANCE, after=STOP))
            words = f"{settled:.2f}" if np.isfinite(settled) else "does not settle"
            numbers = f"{1e3 * largest:.3f} | {1e6 * residual[0]:.1f} | {1e6 * residual[1]:.1f}"
            print(f"| {model} | {law} | {numbers} | {words} |", flush=True)
    drawn(records).savefig(asked.output, dpi=200)


if __name__ == "__main__":
    main()
