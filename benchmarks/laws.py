"""The paper's M1 runs with the elastic law and with wrinkling film and slack cables, side by side.

Run ``python benchmarks/laws.py``. M1 is the softest antenna; its elastic film carries up to two hundred times its
pretension in compression, which no film can. Amplitude is max |w| at A over the whole record, frequency the bin of
largest energy of the motion after the maneuver, both as in the comparison with Tables 6, 8 and 9.
"""

from __future__ import annotations

import argparse
import math

from tautflex import Case, Run, amplitude, build_model, dominant_frequency, maneuver_end, simulate, solve_prestress
from tautflex.case import parse_case, template
from tautflex.case.build import build_maneuver

M2_TEMPLATE = template("m2-nearest-node")

M1 = ("cables.pretension_x=0.147", "cables.pretension_y=0.25")
LAWS = {
    "elastic": (),
    "tension field": ("membrane.law=tension-field",),
    "tension field, slack cables": ("membrane.law=tension-field", "cables.slack=true"),
}
# Table, rate [rad/s], duration of the stop [s], the paper's frequency [Hz] and amplitude [mm].
ROWS = (
    (6, math.pi / 100, 0.1, 0.9537, 0.4441),
    (8, math.pi / 2, 0.1, 2.3842, 6.317),
    (8, math.pi / 5, 0.1, 1.7166, 3.936),
    (9, math.pi / 5, 1.0, 1.2398, 1.4542),
    (9, math.pi / 50, 0.1, 1.0490, 0.7831),
)
PADDED = 10.48576  # [s], record length that gives the bins of these tables


def perform(case: Case, step: float) -> Run:
    """One run of ten seconds, read at the paper's point A."""
    return simulate(
        solve_prestress(build_model(case)),
        build_maneuver(case),
        time_step=step,
        end_time=10.0,
        damping=case.damping.build(),
        probes=case.output.probes,
        probe_reading=case.output.probe_reading,
        throw=False,
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--step", type=float, default=2.5e-3, help="time step [s] (default %(default)s)")
    parser.add_argument("--divisions", default="[10,5]", help="cells of the film (default %(default)s)")
    options = parser.parse_args()
    print("| table | rate, stop | law | f [Hz] (paper) | amplitude [mm] (paper) | least resultant [N/m] | seconds |")
    print("|---|---|---|---|---|---|---|")
    for table, rate, duration, paper_f, paper_a in ROWS:
        for name, law in LAWS.items():
            maneuver = (f"maneuver.rate={rate}", f"maneuver.duration={duration}")
            case = parse_case(M2_TEMPLATE, (*M1, *maneuver, *law, f"mesh.divisions={options.divisions}"))
            run = perform(case, options.step)
            record = run.data["w"].sel(probe="A")
            peak = dominant_frequency(record, after=maneuver_end(run.data), length=PADDED)
            print(
                f"| {table} | {rate:.4f} rad/s, {duration:g} s | {name} | {peak.frequency:.3f} ({paper_f:.3f}) | "
                f"{1e3 * float(amplitude(record)):.4f} ({paper_a:.4f}) | "
                f"{float(run.data['min_principal_resultant'].min()):.1e} | {run.stats.seconds:.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
