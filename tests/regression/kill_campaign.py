"""Kills commands at random instants and looks at what they leave: ``python tests/regression/kill_campaign.py 200``.

A seed and the most seconds may follow; the kills that came about are counted.
Children are forked from a process that has imported everything, so that signals meet the work and not the imports.
"""

from __future__ import annotations

import json
import math
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent)]

import matplotlib.pyplot  # noqa: E402
import xarray as xr  # noqa: E402

import tautflex as tf  # noqa: E402
from tautflex.cli import main  # noqa: E402
from verification.builders import FILM_CASE  # noqa: E402

FILM = f"""{FILM_CASE}[maneuver]
kind = "stop"
rate = 0.5
duration = 0.1
[output]
fields = [0.1, 0.5, 2.0]
"""
SIGNALS = signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT
LONG = "solver.time_step=2e-4", "solver.end_time=2.0"


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
            tf.load_run(path)
        elif path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix == ".png":
            assert path.read_bytes().endswith(b"IEND\xaeB`\x82"), path
        elif path.suffix in (".csv", ".pvd", ".vtu"):
            assert path.read_bytes().rstrip().endswith(b">") or path.suffix == ".csv", path


def without_times(path: Path) -> xr.Dataset:
    """A stored run without what the clock said."""
    data = tf.load(path)
    statistics = json.loads(data.attrs["statistics"]) | {"seconds": 0.0}
    return data.assign_attrs(statistics=json.dumps(statistics))


def numbers(path: Path) -> dict[str, object]:
    """A summary without what the clock said, and where."""
    found = json.loads(path.read_text(encoding="utf-8"))
    return {name: value for name, value in found.items() if name not in ("seconds", "files", "resumed_from")}


def campaign(count: int, seed: int = 0, most: float = math.inf, work: Path | None = None) -> dict[str, int]:
    """Kill runs, which are resumed until they end, and exports between them; how often each came to what end.

    No kill follows after ``most`` seconds.
    """
    last = time.monotonic() + most
    chance, seen = random.Random(seed), dict[str, int]()
    with tempfile.TemporaryDirectory(dir=work) as name:
        folder = Path(name)
        case, log = folder / "film.toml", folder / "log"
        case.write_text(FILM, encoding="utf-8")
        asked = [str(case), *(part for key in LONG for part in ("--set", key)), "--checkpoint", "0.02"]
        begun = time.perf_counter()
        assert ended(started(log, "run", *asked, "-o", str(folder / "whole"))) == 0, log.read_text()
        length = time.perf_counter() - begun
        cut, export, resume = folder / "cut", folder / "export", False
        for number in range(count):
            if time.monotonic() > last:
                break
            which = SIGNALS[number % len(SIGNALS)]
            exporting = chance.random() < 0.25
            to = chance.choice(("vtu", "csv"))
            command = ("export", str(folder / "whole" / "run.nc"), "--to", to, "-o", str(export))
            child = started(log, *(command if exporting else ("run", *asked, "-o", str(cut), *["--resume"] * resume)))
            time.sleep(chance.uniform(0.0, (0.1 if exporting else 1.0) * length))
            os.kill(child, which)
            code = ended(child)
            expected = {0, 128 + which} if which != signal.SIGKILL else {0, -which}
            # A signal that comes before the command listens ends the process as it does any other.
            assert code in expected | {-which}, (which, code, log.read_text()[-2000:])
            look(folder)
            resume = resume or not exporting
            seen[f"{which.name} {code}"] = seen.get(f"{which.name} {code}", 0) + 1
            if (cut / "summary.json").exists() and not (cut / ".tautflex-checkpoint").exists():
                compare(cut, folder / "whole")
                assert ended(started(log, "run", *asked, "-o", str(cut), "--force")) == 0, log.read_text()[-2000:]
                for path in cut.iterdir():
                    path.unlink()
                resume = False
        assert ended(started(log, "run", *asked, "-o", str(cut), "--resume")) == 0, log.read_text()[-2000:]
        compare(cut, folder / "whole")
        assert "Traceback" not in log.read_text(), log.read_text()
        assert not [path for path in cut.rglob(".*") if "lock" not in path.name], list(cut.iterdir())
    return seen


def compare(cut: Path, whole: Path) -> None:
    """A run that was killed equals the one that was not."""
    xr.testing.assert_identical(without_times(cut / "run.nc"), without_times(whole / "run.nc"))
    assert numbers(cut / "summary.json") == numbers(whole / "summary.json")


if __name__ == "__main__":
    matplotlib.pyplot.close("all")
    asked = [kind(text) for kind, text in zip((int, int, float), sys.argv[1:], strict=False)]
    found = campaign(*asked or [200])
    print(json.dumps(found, indent=1))  # noqa: T201
