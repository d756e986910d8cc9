"""Laws on a slew by 0.5 rad: how long attitude and film take to settle on the full nonlinear model.

Run ``python benchmarks/slews.py``; it prints the table of docs/control.md. The plant is the template `slew` (20 x 10
cells on a hub of one axis, tension drives at rest unless a law commands them), the same for all laws. A coarser one
with as much cable per length is ``--divisions 10,5``.
"""

from __future__ import annotations

import argparse
import json

import numpy as np

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.case.build import build_state
from tautflex.case.loop import build_plant

PD = {"stiffness": 30.0, "damping": 22.0, "inertia": 7.46}
END = 10.0


def laws(frequency: float) -> dict[str, tf.ControlLaw]:
    """The laws by name; the shaper is made for a frequency [Hz]."""
    case = parse_case(template("slew"))
    (shaped,) = case.controller
    lqg = shaped.law.build()
    tension = tf.TensionDamping(
        ("pull_x", "pull_y"), limit=0.1, modes=16, floor=1e-7, coordinate_noise=0.1, hub_noise=1.0
    )
    return {
        "PD": tf.PD(**PD),
        "LQG": lqg,
        "ZVD + PD": tf.PD(**PD, shaper="ZVD", frequencies=[frequency]),
        "ZVD + LQG": tf.ShapedReference(lqg, "ZVD", [frequency]),
        "ZVD + LQG + tension damping": tf.ShapedReference(lqg, "ZVD", [frequency]) + tension,
    }


def measured(plant: tf.Plant, law: tf.ControlLaw, slew: tf.Maneuver) -> dict[str, float | None]:
    """Settling times [s] from the end of the slew on (None: not settled), rms [m] over the last second, peak torque."""
    data = tf.close_loop(plant, law, slew, END).data
    rms = data["surface_rms"]
    attitude = data["attitude_error"].rename(sample_time="time")
    settled = {
        "attitude": tf.settling_time(attitude, 1e-3, after=slew.end),
        "surface": tf.settling_time(rms, 2e-5, after=slew.end),
    }
    late = rms.values[rms["time"].values >= END - 1.0]
    return {name: float(value) if np.isfinite(value) else None for name, value in settled.items()} | {
        "residual": float(np.sqrt(np.mean(late**2))),
        "torque": float(np.nanmax(np.abs(data["command"].values[:, 0]))),
    }


def main() -> None:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--divisions", default="20,10", help="cells of the film (default %(default)s)")
    parser.add_argument("--frequency", type=float, default=4.43, help="that of the shaper [Hz] (default %(default)s)")
    asked = parser.parse_args()
    coarse = 20 // int(asked.divisions.partition(",")[0])
    case = parse_case(
        template("slew"),
        [
            f"mesh.divisions=[{asked.divisions}]",
            f"cables.per_long_edge={20 // coarse + 1}",
            f"cables.per_short_edge={10 // coarse + 1}",
            *(f"cables.{name}={coarse * value}" for name, value in (("pretension_x", 0.295), ("pretension_y", 0.55))),
            f"cables.area={coarse * 1.57e-6}",
            "solver.method=bathe",
        ],
    )
    plant, slew = build_plant(case, build_state(case)), case.maneuver.build()
    found = {name: measured(plant, law, slew) for name, law in laws(asked.frequency).items()}
    if asked.json:
        print(json.dumps(found, indent=2))
        return
    print("| law | attitude [s] | surface [s] | residual rms [µm] | peak torque [N m] |")
    print("|---|---|---|---|---|")
    for name, row in found.items():
        times = ("does not settle" if row[key] is None else f"{row[key]:.2f}" for key in ("attitude", "surface"))
        print(f"| {name} | {' | '.join(times)} | {1e6 * row['residual']:.2f} | {row['torque']:.2f} |", flush=True)


if __name__ == "__main__":
    main()
