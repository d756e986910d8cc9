"""A sweep on a cluster whose workers come and go: ``python tests/regression/campaigns/cluster.py 400``.

The number is that of points: two axes of its root. ``dask scheduler`` and two ``dask worker`` are processes of their
own; one worker is killed when a third of the points is there, and another is started. A plugin writes a line for each
point that is kept, so that those computed twice are counted.
"""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1])]

import tautflex as tf  # noqa: E402
from unit.study_cases import FILM  # noqa: E402

STUDY = """schema = 1
base = "film.toml"
[axes]
"maneuver.rate" = {{ from = 0.05, to = 0.2, count = {side} }}
"damping.beta" = {{ from = 0.0, to = 2e-3, count = {side} }}
[measures]
names = ["probes.A.amplitude", "probes.A.dominant_frequency"]
"""
PLUGIN = """import os
from tautflex.study.store import Store
write = Store.write
def counted(self, key, *more):
    write(self, key, *more)
    with open({log!r}, "a") as file:
        file.write(f"{{key}} {{os.getpid()}}\\n")
Store.write = counted
"""


def begun(*words: str, log: Path) -> subprocess.Popen[bytes]:
    """A module with its arguments as a process in a session of its own."""
    with log.open("ab") as file:
        return subprocess.Popen([sys.executable, "-m", *words], stdout=file, stderr=file, start_new_session=True)


def finished(log: Path) -> Counter[str]:
    """How often each point was computed."""
    lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    return Counter(line.partition(" ")[0] for line in lines)


def memory(process: int) -> float:
    """Resident memory [MB]."""
    found = re.search(r"VmRSS:\s*(\d+)", Path(f"/proc/{process}/status").read_text(encoding="ascii"))
    return int(found[1]) / 1e3 if found else math.nan


def address(place: Path) -> str:
    """Where a scheduler answers."""
    while not place.exists() or not place.read_text(encoding="utf-8").strip():
        time.sleep(0.1)
    found: str = json.loads(place.read_text(encoding="utf-8"))["address"]
    return found


def swept(folder: Path, count: int) -> dict[str, object]:
    """Sweep on a cluster, a worker killed and one added; numbers of it."""
    log, said, place = folder / "log", folder / "said", folder / "scheduler.json"
    scheduler = "distributed.cli.dask_scheduler", "--port", "0", "--host", "127.0.0.1", "--no-dashboard"
    processes = [begun(*scheduler, "--scheduler-file", str(place), log=said)]
    try:
        url = address(place)
        worker = "distributed.cli.dask_worker", url, "--nthreads", "1", "--no-dashboard"
        worker += ("--local-directory", str(folder / "scratch"))
        processes += [begun(*worker, log=said), begun(*worker, log=said)]
        words = "tautflex", "sweep", str(folder / "study.toml"), "-o", str(folder / "cluster"), "--scheduler", url
        begin = time.perf_counter()
        command = begun(*words, "--plugin", str(folder / "counted.py"), log=said)
        processes.append(command)
        seen = list[float]()
        while command.poll() is None:
            time.sleep(0.2)
            done = len(finished(log))
            if done:
                seen.append(memory(command.pid) if command.poll() is None else seen[-1])
            if len(processes) == 4 and 3 * done > count:
                os.killpg(processes[1].pid, signal.SIGKILL)
                processes.append(begun(*worker, log=said))
                print(f"a worker killed, and one added, after {done} points", flush=True)  # noqa: T201
        assert command.returncode == 0, said.read_text(encoding="utf-8")[-3000:]
        assert len(processes) == 5, "no worker was killed"
        return {"seconds": time.perf_counter() - begin, "command [MB]": [seen[0], max(seen)]}
    finally:
        for process in processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def main(count: int) -> None:
    """Sweep, count and compare."""
    side = math.isqrt(count)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        log = folder / "log"
        (folder / "film.toml").write_text(FILM, encoding="utf-8")
        (folder / "study.toml").write_text(STUDY.format(side=side), encoding="utf-8")
        (folder / "counted.py").write_text(PLUGIN.format(log=str(log)), encoding="utf-8")
        told = swept(folder, side**2)
        often = finished(log)
        workers = {line.partition(" ")[2] for line in log.read_text(encoding="utf-8").splitlines()}
        twice = [key for key, times in often.items() if times > 1]
        assert len(often) == side**2, len(often)
        assert not twice, twice
        assert len(workers) == 3, workers
        data = tf.load(folder / "cluster" / "study.nc")
        assert (data["status"] == "completed").all()
        alone = tf.sweep(folder / "study.toml", folder / "serial", workers=2)
        assert data.drop_attrs().identical(alone.drop_attrs())
        told |= {"points": side**2, "computed twice": len(twice), "workers": len(workers), "as serial": True}
        print(json.dumps(told))  # noqa: T201


if __name__ == "__main__":
    main(int((sys.argv[1:] or ["400"])[0]))
