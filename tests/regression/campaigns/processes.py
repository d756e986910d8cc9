"""Kills commands that start threads and processes: ``python tests/regression/campaigns/processes.py 100``.

A seed, the most seconds of kills and names of commands may follow. Every command runs in a fresh process with a
session of its own, in which nobody may be left ten seconds after it ended. Ctrl-C goes to all of the session as from a
terminal, SIGTERM and SIGHUP to all or to the first process, SIGKILL to the first process or to one of its workers.
"""

from __future__ import annotations

import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from kills import SIGNALS, compare, look  # noqa: E402

from tautflex.files.checkpoints import FOLDER  # noqa: E402
from unit.learning_cases import coarse  # noqa: E402
from unit.study_cases import FILM  # noqa: E402

STUDY = """schema = 1
base = "{base}"
[axes]
"maneuver.rate" = {{ from = 0.05, to = 0.2, count = {count} }}
"{other}" = {values}
[measures]
names = ["probes.A.amplitude"]
[engine]
kind = "{kind}"
"""
ALONE = 10.0  # seconds after which nobody may be left of a session
LOST = 1  # code of a command that lost a worker


@dataclass
class Asked:
    """A command whose output is a file or a folder, what it gets from the first run, and whether it repeats to go on.

    Parameters
    ----------
    arguments
        But for the output.
    output
        Its name.
    start
        File that stands there when the command begins; it is whole until the new one is.
    beside
        Option for a file that the command keeps beside its output.
    """

    arguments: tuple[str, ...]
    output: str
    start: Path | None = None
    beside: tuple[str, str] | None = None
    length: float = 0.0

    def begun(self, place: Path, log: Path, *, start: bool = True) -> subprocess.Popen[bytes]:
        """Start it with its output in a folder, where there is an earlier one to ``start`` with if it has one."""
        place.mkdir(parents=True, exist_ok=True)
        target, first = place / self.output, self.start if start else None
        if first is not None and not target.exists():
            shutil.copy(first, target)
        more = [] if self.beside is None else [self.beside[0], str(place / self.beside[1])]
        more += ["--force"] * (first is not None)
        if self.arguments[0] == "control" and target.exists():  # what was ended left a result, and a checkpoint if late
            more += ["--resume" if (target / FOLDER).exists() else "--force"]
        command = [sys.executable, "-m", "tautflex", *self.arguments, "-o", str(target), *more]

        def listen() -> None:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # where this runs in the background, children would not

        with log.open("ab") as file:
            return subprocess.Popen(command, stdout=file, stderr=file, start_new_session=True, preexec_fn=listen)


def session(leader: int) -> list[int]:
    """Living processes of a session."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, _, _, owner = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
            except (OSError, ValueError):
                continue
            if int(owner) == leader and state != "Z":
                found.append(int(entry.name))
    return found


def struck(process: subprocess.Popen[bytes], which: signal.Signals, chance: random.Random) -> str:
    """Send a signal to a command; what was hit."""
    if process.poll() is not None:
        return "nobody"
    others = [each for each in session(process.pid) if each != process.pid]
    hit = {
        signal.SIGINT: "all",
        signal.SIGKILL: "a worker" if others and chance.random() < 0.3 else "the first",
    }.get(which, chance.choice(["all", "the first"]))
    with suppress(ProcessLookupError):
        if hit == "all":
            os.killpg(process.pid, which)
        else:
            os.kill(process.pid if hit == "the first" else chance.choice(others), which)
    return hit


def left_alone(leader: int) -> None:
    """Raise if anybody is left of a session."""
    until = time.monotonic() + ALONE
    while (left := session(leader)) and time.monotonic() < until:
        time.sleep(0.05)
    words = [Path(f"/proc/{each}/cmdline").read_bytes().replace(b"\0", b" ").decode()[:200] for each in left]
    for each in left:
        os.kill(each, signal.SIGKILL)
    assert not left, words


def points(folder: Path) -> dict[Path, tuple[int, int]]:
    """What was finished: files of points and episodes, by when and where they were written."""
    found = {}
    for path in (*folder.glob("*/points/*/*.json"), *folder.glob("*/episodes/*.json")):
        about = path.stat()
        found[path] = about.st_mtime_ns, about.st_ino
    return found


def commands(folder: Path) -> dict[str, Asked]:
    """What is killed."""
    slew, film = folder / "slew.toml", folder / "film.toml"
    slew.write_text(coarse("slew").to_toml(), encoding="utf-8")
    film.write_text(FILM.replace("[output]", "[output]\nfields = [0.1, 0.2]"), encoding="utf-8")
    for name, kind, count, other, values in (
        ("two", "serial", 24, "membrane.stress_x", "[4000.0, 4400.0]"),
        ("batch", "batch", 1200, "damping.beta", "[0.0, 2e-3]"),
        ("dask", "dask", 12, "membrane.stress_x", "[4000.0, 4400.0]"),
    ):
        text = STUDY.format(base=film.name, count=count, kind=kind, other=other, values=values)
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    for name, rate in (("old", "0.05"), ("new", "0.1")):
        made = ["run", str(film), "-o", str(folder / name), "--set", f"maneuver.rate={rate}"]
        subprocess.run([sys.executable, "-m", "tautflex", *made], check=True, capture_output=True)
    old = folder / "old"
    for words in (["report", str(old), "-o", "page.html"], ["animate", str(old), "-o", "film.gif", "--frames", "20"]):
        subprocess.run([sys.executable, "-m", "tautflex", *words], check=True, capture_output=True, cwd=old)
    judged = "--law", "pd", "--law", "none", "--budget", "0", "--plant", "reduced", "--angles", "2", "--seeds", "1"
    return {
        "train": Asked(("train", str(slew), "--iterations", "150"), "p.npz", None, ("--checkpoint", "kept.npz")),
        "evaluate": Asked(("evaluate", str(slew), *judged, "--workers", "2"), "judged"),
        "sweep on two": Asked(("sweep", str(folder / "two.toml"), "--workers", "2"), "study"),
        "sweep batch": Asked(("sweep", str(folder / "batch.toml")), "study"),
        "sweep dask": Asked(("sweep", str(folder / "dask.toml"), "--workers", "2"), "study"),
        "design on two": Asked(("design", str(design_of(folder)), "--workers", "2"), "best"),
        "control": Asked(("control", str(slew), "--checkpoint", "0.1"), "loop"),
        "report": Asked(("report", str(folder / "new")), "page.html", old / "page.html"),
        "animate": Asked(("animate", str(folder / "new"), "--frames", "20"), "film.gif", old / "film.gif"),
    }


def design_of(folder: Path) -> Path:
    """Study of a search whose trials run two at a time."""
    path = folder / "design.toml"
    path.write_text(
        'schema = 1\nbase = "film.toml"\n[design]\nminimize = ["probes.A.amplitude"]\ntrials = 12\ntogether = 2\n'
        '[design.variables]\n"maneuver.rate" = { from = 0.05, to = 0.2 }\n',
        encoding="utf-8",
    )
    return path


def checked(asked: Asked, place: Path, whole: Path) -> None:
    """What a kill left is whole: old or new, or not there."""
    target = place / asked.output
    if target.suffix:
        known = [path.read_bytes() for path in (whole / asked.output, asked.start) if path is not None]
        assert not target.exists() or target.read_bytes() in known, target
        assert target.exists() or asked.start is None, target
    else:
        look(target)


def equal(asked: Asked, place: Path, whole: Path) -> None:
    """Results of a command that was killed and repeated are those of one that was not, to the bit."""
    if (place / asked.output).suffix:
        names = sorted(path.name for path in place.iterdir())
        assert names == sorted(path.name for path in whole.iterdir()), names
        assert (place / asked.output).read_bytes() == (whole / asked.output).read_bytes()
    else:
        compare(place / asked.output, whole / asked.output)


def campaign(count: int, seed: int = 0, most: float = math.inf, *only: str) -> dict[str, int]:
    """Kill commands, which are repeated until they end; how often each came to what end."""
    chance, seen = random.Random(seed), dict[str, int]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        log, known = folder / "log", commands(folder)
        known = {kind: known[kind] for kind in only or known}
        for kind, asked in known.items():
            begun = time.perf_counter()
            assert asked.begun(folder / "whole" / kind, log).wait() == 0, log.read_text()
            asked.length = time.perf_counter() - begun
            print(f"{time.strftime('%H:%M:%S')} {kind}: {asked.length:.1f} s", flush=True)  # noqa: T201
        last = time.monotonic() + most
        for number in range(count):
            if time.monotonic() > last:
                break
            kind = list(known)[number % len(known)]
            which = SIGNALS[chance.randrange(len(SIGNALS))]
            ended = killed(known[kind], kind, folder, log, which, chance)
            seen[ended] = seen.get(ended, 0) + 1
            print(f"{time.strftime('%H:%M:%S')} {number + 1}: {ended}", flush=True)  # noqa: T201
        for kind, asked in known.items():
            place = folder / "cut" / kind
            assert asked.begun(place, log).wait() == 0, log.read_text()[-2000:]
            equal(asked, place, folder / "whole" / kind)
    return seen


def killed(asked: Asked, kind: str, folder: Path, log: Path, which: signal.Signals, chance: random.Random) -> str:
    """Kill one command and look at what it left; how it ended."""
    place, whole = folder / "cut" / kind, folder / "whole" / kind
    before = points(place)
    log.write_bytes(b"")
    process = asked.begun(place, log)
    with suppress(subprocess.TimeoutExpired):
        process.wait(chance.uniform(0.0, asked.length))
    hit = struck(process, which, chance)
    code = process.wait()
    said = log.read_text(errors="replace")
    expected = {0, 128 + which, -which} if which != signal.SIGKILL else {0, -which, LOST}
    assert code in expected, (kind, which, hit, code, said[-2000:])
    assert code != LOST or hit == "a worker", (kind, which, hit, said[-2000:])
    assert "Traceback" not in said, (kind, which, hit, said[-6000:])
    left_alone(process.pid)
    checked(asked, place, whole)
    after = points(place)
    assert before.items() <= after.items(), f"{kind}: computed twice or lost {before.items() - after.items()}"
    if code == 0:
        equal(asked, place, whole)
    if code == 0 or (asked.start is None and (place / asked.output).is_file()):  # which was hit on its way out
        shutil.rmtree(place)
    return f"{kind}, {which.name} to {hit}: {code}"


if __name__ == "__main__":
    given = [each(text) for each, text in zip((int, int, float), sys.argv[1:], strict=False)]
    print(json.dumps(campaign(*given or [100], *sys.argv[4:]), indent=1))  # noqa: T201
