"""A run of a million steps, killed three times and resumed, some minutes.

``python tests/regression/campaigns/long_run.py``, of a reduced model; ``full`` and a number of steps may follow. It has
to equal the run that was not killed; memory is printed along the way, and the largest of its report.
"""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from kills import compare, ended, started  # noqa: E402

from unit.study_cases import FILM, film  # noqa: E402

STEP = {"reduced": 5e-3, "full": 2e-5}
CASES = {
    "reduced": FILM,
    "full": film(0.1, 'method = "central-difference"\ntime_step = 2e-5\nend_time = 1.0') + "every = 10\n",
}
PARTS = "RssAnon", "RssFile", "VmHWM"


def tell(*words: object) -> None:
    """Print at once."""
    print(*words, flush=True)  # noqa: T201


def memory(child: int) -> list[int]:
    """Anonymous memory, that of mapped files, and the largest sum of both so far [MB]; nothing of one that ended."""
    lines = Path(f"/proc/{child}/status").read_text(encoding="ascii").splitlines()
    found = {
        name: int(rest.split()[0]) // 1000 for name, _, rest in (line.partition(":") for line in lines) if name in PARTS
    }
    return [found[name] for name in PARTS if name in found]


def watched(child: int, seconds: float) -> list[list[int]]:
    """Memory of a child every half second, for some seconds or until it ends."""
    until, seen = time.monotonic() + seconds, list[list[int]]()
    while time.monotonic() < until and len(now := memory(child)) == len(PARTS):
        seen.append(now)
        time.sleep(0.5)
    return seen


def main(kind: str = "reduced", steps: int = 10**6) -> None:
    """Run, kill and compare."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case, log = folder / "film.toml", folder / "log"
        case.write_text(CASES[kind], encoding="utf-8")
        asked = "run", str(case), "--set", f"solver.end_time={STEP[kind] * steps}", "--checkpoint", "1"
        begun = time.perf_counter()
        child = started(log, *asked, "-o", str(folder / "whole"))
        seen = watched(child, 1e6)
        length = time.perf_counter() - begun
        assert ended(child) == 0, log.read_text(encoding="utf-8")
        tell(f"{length:.0f} s; anonymous, mapped and largest memory [MB]:", *seen[:: max(1, len(seen) // 20)])
        tell(f"run.nc: {(folder / 'whole' / 'run.nc').stat().st_size // 10**6} MB")
        seen = watched(reporting := started(log, "report", str(folder / "whole"), "-o", str(folder / "page.html")), 1e6)
        assert ended(reporting) == 0, log.read_text(encoding="utf-8")
        tell("report, largest memory [MB]:", max(each[-1] for each in seen))
        for number in range(3):
            child = started(log, *asked, "-o", str(folder / "cut"), *["--resume"] * (number > 0))
            watched(child, length / 5)
            os.kill(child, signal.SIGKILL)
            tell(f"killed: {ended(child)}", *(p.name for p in (folder / "cut").rglob("state.npz")))
        assert ended(started(log, *asked, "-o", str(folder / "cut"), "--resume")) == 0, log.read_text(encoding="utf-8")
        compare(folder / "cut", folder / "whole")
        tell("identical")


if __name__ == "__main__":
    main(*[each(text) for each, text in zip((str, int), sys.argv[1:], strict=False)])
