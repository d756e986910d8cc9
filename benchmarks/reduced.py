"""Error and cost of reduced models against the full one: the paper's M2 and M3 stops, two meshes, several bases.

Run ``python benchmarks/reduced.py -o FOLDER`` (about ten minutes on an idle machine; ``--quick`` two). It writes
reduced.json and reduced.md: per mesh and basis the worst of all cases, then every case. Full and reduced runs take the
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
import time
from pathlib import Path

import numpy as np

import tautflex as tf
from tautflex.case import parse_case, template

# Maneuvers of Tables 6 and 7 and of section 3: model, rate [rad/s], duration [s].
CASES = (
    ("M2", np.pi / 100, 0.1),
    ("M2", np.pi / 5, 1.0),
    ("M3", np.pi / 100, 0.1),
    ("M3", np.pi / 5, 0.1),
    ("M3", np.pi / 5, 1.0),
    ("M3", np.pi / 5, 2.0),
)
# Template, and its cable tensions of M2 and M3 [N].
MESHES = {
    "40x20, equilibrium": ("m2", {"M2": (0.0294705, 0.055), "M3": (0.154845, 0.2035)}),
    "10x5, nearest-node reading": ("m2-nearest-node", {"M2": (0.59, 1.0), "M3": (3.1, 3.7)}),
}
MODES = {"40x20, equilibrium": (4, 6, 10, 16, 24), "10x5, nearest-node reading": (6, 10, 16, 24, 32)}
PROPER = {"40x20, equilibrium": (4, 6, 10, 16), "10x5, nearest-node reading": (8, 12, 16, 20)}
# Run whose fields train the proper orthogonal modes; the other cases are foreign to them.
TRAINING = {"M2": CASES[1], "M3": CASES[3]}


def prestressed(mesh: str, model: str) -> tuple[tf.Case, object]:
    """Case and prestressed state."""
    name, tensions = MESHES[mesh]
    case = parse_case(template(name))
    tension_x, tension_y = tensions[model]
    case = case.replaced(cables={"pretension_x": tension_x, "pretension_y": tension_y})
    return case, tf.solve_prestress(tf.build_model(case))


def run(
    plant: object, case: tf.Case, rate: float, duration: float, step: float, seconds: float, fields="none", method=None
):
    """One run and its whole time [s]."""
    began = time.perf_counter()
    result = tf.simulate(
        plant,
        tf.Stop(rate=rate, duration=duration),
        method=method,
        time_step=step,
        end_time=seconds,
        damping=tf.Rayleigh(1e-3, 1e-3),
        probes={"A": (0.7036, 0.4267)},
        probe_reading=case.output.probe_reading,
        every=round(0.01 / step),
        fields=fields,
    )
    return result, time.perf_counter() - began


def compare(full, reduced, duration: float) -> dict[str, float]:
    """Relative errors of the record at A; the frequency's in bins."""
    w, ours = full.data.w.sel(probe="A"), reduced.data.w.sel(probe="A")
    peak, our_peak = (tf.dominant_frequency(record, after=duration) for record in (w, ours))
    rms = float(np.sqrt(np.mean(w**2)))
    return {
        "amplitude": float(np.abs(ours).max() / np.abs(w).max()) - 1.0,
        "rms": float(np.sqrt(np.mean(ours**2))) / rms - 1.0,
        "difference": float(np.sqrt(np.mean((ours.values - w.values) ** 2))) / rms,
        "bins": (our_peak.frequency - peak.frequency) / peak.bin_width,
        "truncated": float(reduced.data.truncated_energy.max()),
    }


def measure(mesh: str, seconds: float, step: float, quick: bool, method: object) -> list[dict]:
    """All rows of one mesh."""
    rows = []
    for model in ("M2", "M3"):
        case, state = prestressed(mesh, model)
        cases = [entry for entry in CASES if entry[0] == model][: 1 if quick else None]
        run(state, case, 0.01, 0.1, 1e-3, 0.05)  # compiles
        training, _ = run(state, case, *TRAINING[model][1:], 1e-3, min(2.0, seconds), "all")
        bases = [(f"{n} natural modes", tf.ModalBasis(("rx",), count=n, candidates=130)) for n in MODES[mesh]]
        bases += [(f"{n} proper orthogonal modes", tf.PodBasis(training.data, count=n)) for n in PROPER[mesh]]
        roms = [(name, tf.reduce(state, basis)) for name, basis in bases]
        for _, rate, duration in cases:
            full, whole = run(state, case, rate, duration, 1e-3, seconds)
            for name, rom in roms:
                try:
                    run(rom, case, rate, duration, step, 0.1, method=method)  # compiles
                except tf.InputError as error:
                    print(f"{mesh}, {model}, {name}: left out, {error}", file=sys.stderr, flush=True)
                    continue
                reduced, ours = run(rom, case, rate, duration, step, seconds, method=method)
                rows.append(
                    {
                        "mesh": mesh,
                        "unknowns": state.system.size,
                        "model": model,
                        "rate": rate,
                        "duration": duration,
                        "basis": name,
                        "coordinates": rom.size,
                        "static_derivatives": len(rom.basis.derivatives),
                        "offline_seconds": rom.seconds,
                        "megabytes": rom.memory / 1e6,
                        **compare(full, reduced, duration),
                        "full_seconds": full.stats.seconds,
                        "reduced_seconds": reduced.stats.seconds,
                        "ratio": full.stats.seconds / reduced.stats.seconds,
                        "whole_ratio": whole / ours,
                    }
                )
                print(json.dumps(rows[-1]), flush=True)
    return rows


def worst_table(rows: list[dict]) -> list[str]:
    """Markdown: one row per mesh and basis, the worst of all cases."""
    lines = [
        "| mesh | basis | coordinates | amplitude | rms | difference | frequency [bins] | offline [s] | memory [MB] "
        "| faster, stepping | faster, whole call |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for mesh in MESHES:
        for basis in dict.fromkeys(row["basis"] for row in rows if row["mesh"] == mesh):
            same = [row for row in rows if row["mesh"] == mesh and row["basis"] == basis]
            most = {key: max(abs(row[key]) for row in same) for key in ("amplitude", "rms", "difference", "bins")}
            sizes = sorted({row["coordinates"] for row in same})
            lines.append(
                f"| {mesh} | {basis} | {' to '.join(map(str, (sizes if len(sizes) == 1 else (sizes[0], sizes[-1]))))} "
                f"| {most['amplitude']:.1%} | {most['rms']:.1%} | {most['difference']:.1%} | {most['bins']:.1f} "
                f"| {max(row['offline_seconds'] for row in same):.1f} | {max(row['megabytes'] for row in same):.1f} "
                f"| {np.median([row['ratio'] for row in same]):.0f} "
                f"| {np.median([row['whole_ratio'] for row in same]):.0f} |"
            )
    return lines


def main() -> None:
    """Write both files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("reduced"))
    parser.add_argument("--seconds", type=float, default=10.0, help="simulated time [s]")
    parser.add_argument("--step", type=float, default=1e-3, help="step of the reduced runs [s]")
    parser.add_argument("--explicit", action="store_true", help="reduced runs by central differences")
    parser.add_argument("--quick", action="store_true", help="one case per model")
    parser.add_argument("--mesh", choices=list(MESHES), help="this mesh only")
    arguments = parser.parse_args()
    chosen = [arguments.mesh] if arguments.mesh else list(MESHES)
    method = tf.CentralDifference() if arguments.explicit else None
    rows = []
    for mesh in chosen:
        rows += measure(mesh, arguments.seconds, arguments.step, arguments.quick, method)
    arguments.output.mkdir(parents=True, exist_ok=True)
    about = {"machine": platform.processor() or platform.machine(), "python": platform.python_version()}
    text = json.dumps({**about, "tautflex": tf.__version__, "step": arguments.step, "rows": rows}, indent=1)
    (arguments.output / "reduced.json").write_text(text + "\n", encoding="utf-8")
    lines = "\n".join(worst_table(rows))
    (arguments.output / "reduced.md").write_text(lines + "\n", encoding="utf-8")
    print(lines)


if __name__ == "__main__":
    main()
