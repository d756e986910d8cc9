"""What a first command, a second one, a reduced model and a batch cost before they compute, in processor seconds.

Run ``python benchmarks/start_up.py`` (minutes; ``--only commands|reduced|batch``). Every measurement is a process of
its own. Compiled code goes to a new folder, so that the first process finds none and the second all of it. Commands
have others compile beside them, one on each other core: "processor" counts these too, "compiling" and "functions" the
command alone. With ``TAUTFLEX_COMPILERS=0`` in the environment commands compile alone.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from itertools import product
from pathlib import Path

STRUCTURE = """
import tautflex as tf
from tautflex.case import parse_case, template
case = parse_case(template("m2"), {case!r})
state = tf.solve_prestress(tf.build_model(case))
"""
REDUCED = """
import pickle, time
from pathlib import Path
from tautflex.reduction.polynomial.model import ReducedModel
began = time.process_time()
def lap(name):
    global began
    laps[name] = round(time.process_time() - began, 2)
    began = time.process_time()
place = Path("model.pickle")
if place.exists():
    model = pickle.loads(place.read_bytes())
    lap("load")
else:
    model = tf.reduce(state, basis=tf.ModalBasis(count={count}))
    lap("assembly")
    place.write_bytes(pickle.dumps(model))
    lap("save")
stop = tf.Stop(rate=0.1, duration=1.0)
tf.simulate(model, stop, time_step=2e-3, end_time=2e-3, damping=tf.Rayleigh(1e-3, 1e-3))
lap("first step")
tf.simulate(model, stop, time_step=2e-3, end_time=2e-3, damping=tf.Rayleigh(1e-3, 1e-3))
lap("again")
"""
BATCH = """
import time
model = tf.reduce(state, basis=tf.ModalBasis(count=8))
batch = tf.Batch(model)
for name in ("first call", "second call"):
    began = time.process_time()
    batch.simulate({"maneuver.rate": [0.1, 0.2]}, tf.Stop(rate=0.1, duration=1.0), time_step=2e-3, end_time=0.2)
    laps[name] = round(time.process_time() - began, 2)
"""


def cells(columns: int, rows: int) -> list[str]:
    """What the template of M2 has otherwise, on a mesh of its own."""
    edges = f"cables.per_long_edge={columns + 1}", f"cables.per_short_edge={rows + 1}"
    return [f"mesh.divisions=[{columns},{rows}]", *edges, "solver.end_time=2.2"]


def compiled(program: str) -> None:
    """Run a program in this process and print what it compiled; the figures stand in the last line of stderr."""
    from numba.core import event

    laps: dict[str, float] = {}
    functions, depth, spent = 0, 0, 0.0

    class Watch(event.Listener):
        def on_start(self, event: event.Event) -> None:
            nonlocal depth, spent
            spent -= time.process_time() if depth == 0 else 0.0
            depth += 1

        def on_end(self, event: event.Event) -> None:
            nonlocal depth, spent, functions
            depth, functions = depth - 1, functions + 1
            spent += time.process_time() if depth == 0 else 0.0

    event.register("numba:compile", Watch())
    try:
        exec(program, {"laps": laps})
    finally:
        print("\n" + json.dumps({"compiling": round(spent, 2), "functions": functions, **laps}), file=sys.stderr)


def measured(name: str, arguments: list[str], folder: Path, quiet: bool = True) -> None:
    """Processor and wall seconds of one process, with what it says of itself."""
    began, before = time.perf_counter(), os.times()
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "code"), "OMP_NUM_THREADS": "1"}
    environment["XDG_CACHE_HOME"] = str(folder / "cache")
    done = subprocess.run(
        [sys.executable, *arguments], cwd=folder, env=environment, capture_output=quiet, text=True, check=False
    )
    now = os.times()
    processor = now.children_user + now.children_system - before.children_user - before.children_system
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr}")
    said = done.stderr.strip().splitlines()[-1:] if "--inside" in arguments else []
    row = {"what": name, "processor": round(processor, 2), "wall": round(time.perf_counter() - began, 2)}
    print(json.dumps(row | (json.loads(said[0]) if said else {})), flush=True)


def command(*words: str) -> list[str]:
    """Words of a process that runs one command."""
    return [__file__, "--inside", f"from tautflex.cli import main; assert main({list(words)!r}) == 0"]


def main() -> None:
    """Print one JSON object per process."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=["commands", "reduced", "batch"], help="one of the three parts")
    parser.add_argument("--inside", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inside:
        compiled(arguments.inside)
        return
    __import__("tautflex")  # an error here is told at once
    with tempfile.TemporaryDirectory() as place:
        folder, part = Path(place), arguments.only
        coarse = [word for one in cells(10, 5) for word in ("--set", one)]
        if part in (None, "commands"):
            measured("import tautflex", ["-c", "import tautflex"], folder)
            measured("tautflex --help", ["-m", "tautflex", "--help"], folder)
            measured("tautflex init", ["-m", "tautflex", "init", "m2.toml"], folder)
            for turn in ("first", "second"):
                measured(f"{turn} check", command("check", "m2.toml", *coarse), folder)
                measured(f"{turn} run", command("run", "m2.toml", "-o", "m2", "--force", *coarse), folder)
                measured(f"{turn} report", command("report", "m2", "--force"), folder)
        for count, size in product((8, 17), ((20, 10), (40, 20))) if part in (None, "reduced") else ():
            name, steps = f"{size[0]} x {size[1]} cells, {count} modes", REDUCED.format(count=count)
            (folder / "model.pickle").unlink(missing_ok=True)
            program = STRUCTURE.format(case=cells(*size)) + steps
            measured(f"{name}: first process", [__file__, "--inside", program], folder)
            measured(f"{name}: kept model", [__file__, "--inside", f"import tautflex as tf\n{steps}"], folder)
        for turn in ("first", "second") if part in (None, "batch") else ():
            program = STRUCTURE.format(case=cells(10, 5)) + BATCH
            measured(f"{turn} process with a batch", [__file__, "--inside", program], folder)


if __name__ == "__main__":
    main()
