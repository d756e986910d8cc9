"""Kills commands at random instants and looks at what they leave: ``python tests/regression/campaigns/kills.py 200``.

A seed, the most seconds and names of commands may follow; kills are counted, by command, signal and exit code.
Children are forked from a process that has imported everything, so that signals meet the work and not the imports.
Commands that must not be forked are killed by `processes.py`.
"""

from __future__ import annotations

import json
import math
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1])]

import matplotlib.pyplot  # noqa: E402
import xarray as xr  # noqa: E402

import tautflex as tf  # noqa: E402
from tautflex.cli import main  # noqa: E402
from unit.study_cases import FILM as REDUCED_FILM  # noqa: E402
from verification.builders import STOPPED_FILM as FILM  # noqa: E402

STUDY = """schema = 1
base = "reduced.toml"
[axes]
"maneuver.rate" = { from = 0.05, to = 0.2, count = 6 }
"damping.beta" = [0.0, 2e-3]
[design]
minimize = ["probes.A.amplitude"]
trials = 10
[design.variables]
"maneuver.rate" = { from = 0.05, to = 0.2 }
"damping.beta" = { from = 0.0, to = 2e-3 }
"""
SIGNALS = signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT
LONG = "solver.time_step=2e-4", "solver.end_time=0.4"


def started(log: Path, *arguments: str) -> int:
    """Process number of a child that performs a command."""
    child = os.fork()
    if child == 0:
        code = 70
        try:
            with log.open("ab", buffering=0) as file:
                os.dup2(file.fileno(), 1)
                os.dup2(file.fileno(), 2)
            code = main(list(arguments))
        finally:
            os._exit(code)
    return child


def ended(child: int) -> int:
    """Exit code of a child; minus the signal that killed it."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def look(folder: Path) -> None:
    """Every file that has a result's name is whole, and says what belongs together."""
    for path in folder.rglob("*"):
        if any(part.startswith(".") for part in path.relative_to(folder).parts):
            continue
        if path.suffix == ".nc":
            (tf.load_run if path.name == "run.nc" else tf.load)(path)
        elif path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix == ".png":
            assert path.read_bytes().endswith(b"IEND\xaeB`\x82"), path
        elif path.suffix == ".toml":
            tf.load_case(path)
        elif path.suffix in (".csv", ".pvd", ".vtu"):
            assert path.read_bytes().rstrip().endswith(b">") or path.suffix == ".csv", path


# The text of a reduced model says how long it took to make; Datasets are compared without that part.
_CLOCK = "seconds", "files", "resumed_from", "reduced_model"


def without_times(path: Path) -> xr.Dataset:
    """A stored result without what the clock said, and how often it was begun."""
    data = tf.load(path).drop_attrs(deep=False)
    attributes = tf.load(path).attrs
    statistics = json.dumps(json.loads(attributes.get("statistics", "{}")) | {"seconds": 0.0})
    made = re.sub(r", made in [\d.e+-]+ s", "", attributes.get("reduced_model", ""))
    own = {"seconds": 0.0, "resumed": 0, "statistics": statistics, "reduced_model": made}
    return data.assign_attrs(attributes | own)


def numbers(path: Path) -> dict[str, object]:
    """A summary or a point without what the clock said, and where."""
    found = json.loads(path.read_text(encoding="utf-8"))
    return {name: value for name, value in found.items() if name not in _CLOCK}


def compare(cut: Path, whole: Path) -> None:
    """What was killed and went on equals what was not: the same files, to the bit but for the times in them."""
    names = [sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()) for folder in (cut, whole)]
    assert names[0] == names[1], set(names[0]) ^ set(names[1])
    for name in names[0]:
        one, other = cut / name, whole / name
        if one.suffix == ".nc":
            xr.testing.assert_identical(without_times(one), without_times(other))
        elif one.suffix == ".json":
            assert numbers(one) == numbers(other), name
        elif one.suffix != ".log":  # a journal tells of its processes
            assert one.read_bytes() == other.read_bytes(), name


@dataclass
class Command:
    """A command, its arguments but for the folder, and what repeats it after an end before its time."""

    arguments: tuple[str, ...]
    weight: float
    again: tuple[str, ...] = ()
    anew: tuple[str, ...] = ()
    length: float = 0.0

    def perform(self, folder: Path, log: Path, *more: str) -> int:
        """Process number of a child."""
        return started(log, *self.arguments, "-o", str(folder), *more)


def commands(folder: Path) -> dict[str, Command]:
    """What is killed."""
    case, study = folder / "film.toml", folder / "study.toml"
    case.write_text(FILM, encoding="utf-8")
    (folder / "reduced.toml").write_text(REDUCED_FILM, encoding="utf-8")
    study.write_text(STUDY, encoding="utf-8")
    keys = [part for key in LONG for part in ("--set", key)]
    result = str(folder / "whole" / "run" / "run.nc")
    return {
        "run": Command(("run", str(case), *keys, "--checkpoint", "0.02"), 0.35, ("--resume",), ("--force",)),
        "export vtu": Command(("export", result, "--to", "vtu"), 0.15),
        "export csv": Command(("export", result, "--to", "csv"), 0.15),
        "sweep": Command(("sweep", str(study), "--workers", "1"), 0.15),
        "design": Command(("design", str(study), "--workers", "1"), 0.1),
        "reproduce": Command(("reproduce", "--table", "7", "--quick", "--workers", "1"), 0.07),
    }


def campaign(
    count: int, seed: int = 0, most: float = math.inf, *only: str, tell: Callable[[str], None] = print
) -> dict[str, int]:
    """Kill commands, which are repeated until they end; how often each came to what end.

    No kill follows after ``most`` seconds from the start.
    """
    last = time.monotonic() + most
    chance, seen = random.Random(seed), dict[str, int]()
    with tempfile.TemporaryDirectory() as name:
        folder, loaded = Path(name), set[tuple[str, ...]]()
        log, known = folder / "log", commands(folder)
        known = {kind: known[kind] for kind in only or known}
        for kind, command in known.items():
            # Children find here what they would load and compile: it is the work that is to be killed.
            if command.arguments[:2] not in loaded:
                assert main([*command.arguments, "-o", str(folder / "first" / kind)]) == 0
            loaded.add(command.arguments[:2])
            begun = time.perf_counter()
            assert ended(command.perform(folder / "whole" / kind, log)) == 0, log.read_text()
            command.length = time.perf_counter() - begun
        shutil.rmtree(folder / "first")
        more = dict.fromkeys(known, ())
        for number in range(count):
            if time.monotonic() > last:
                break
            which = SIGNALS[number % len(SIGNALS)]
            kind = chance.choices(list(known), [each.weight for each in known.values()])[0]
            command, cut, whole = known[kind], folder / "cut" / kind, folder / "whole" / kind
            child = command.perform(cut, log, *more[kind])
            time.sleep(chance.uniform(0.0, command.length))
            os.kill(child, which)
            code = ended(child)
            expected = {0, 128 + which} if which != signal.SIGKILL else {0, -which}
            # A signal that comes before the command listens ends the process as it does any other.
            assert code in expected | {-which}, (kind, which, code, log.read_text()[-2000:])
            look(cut)
            more[kind] = command.again
            seen[f"{kind} {which.name} {code}"] = seen.get(f"{kind} {which.name} {code}", 0) + 1
            tell(f"{time.strftime('%H:%M:%S')} {number + 1}: {kind} {which.name} {code}")
            if code == 0:
                compare(cut, whole)
                more[kind] = command.anew
                if not command.anew:
                    shutil.rmtree(cut)
        for kind, command in known.items():
            cut = folder / "cut" / kind
            assert ended(command.perform(cut, log, *more[kind])) == 0, log.read_text()[-2000:]
            compare(cut, folder / "whole" / kind)
        assert "Traceback" not in log.read_text(), log.read_text()
    return seen


if __name__ == "__main__":
    matplotlib.pyplot.close("all")
    asked = [kind(text) for kind, text in zip((int, int, float), sys.argv[1:], strict=False)]
    found = campaign(*asked or [200], *sys.argv[4:])
    print(json.dumps(found, indent=1))  # noqa: T201
