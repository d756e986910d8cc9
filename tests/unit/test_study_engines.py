"""Engines give the same files; a kill at any moment loses nothing that was finished, and nothing is computed twice."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from tautflex.study.engines.processes import Processes, WorkerLostError
from tautflex.study.engines.serial import Pool
from tautflex.study.sweep import make_plan
from unit.study_cases import FILM, film_study

STUDY = """base = "film.toml"
[axes]
"maneuver.rate" = {{ from = 0.05, to = 0.2, count = {count} }}
"membrane.stress_x" = [4000.0, 4400.0]
[measures]
names = ["probes.A.amplitude", "energy_balance.strain"]
"""


def write_study(folder: Path, count: int, end_time: float = 0.4) -> Path:
    film = FILM.replace("end_time = 0.4", f"end_time = {end_time}")
    (folder / "film.toml").write_text(film, encoding="utf-8")
    (folder / "s.toml").write_text(STUDY.format(count=count), encoding="utf-8")
    return folder / "s.toml"


def finished(folder: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in folder.glob("points/*/*.json")}


def wait_for(folder: Path, count: int, process: subprocess.Popen[bytes]) -> dict[Path, int]:
    deadline = time.monotonic() + 120
    while len(finished(folder)) < count and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    return finished(folder)


@pytest.mark.slow
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGTERM])
def test_a_kill_at_any_moment_loses_nothing_that_was_finished(tmp_path, sign):
    study = write_study(tmp_path, 10, 2.0)
    command = [sys.executable, "-m", "tautflex", "sweep", str(study), "--workers", "2", "-o", str(tmp_path / "out")]
    process = subprocess.Popen(command, start_new_session=True, stderr=subprocess.PIPE)
    wait_for(tmp_path / "out", 3, process)
    (os.killpg if sign == signal.SIGKILL else os.kill)(process.pid, sign)
    _, said = process.communicate()
    assert process.returncode != 0
    assert b"Traceback" not in said
    kept = finished(tmp_path / "out")
    assert 3 <= len(kept) < 20
    data = tf.sweep(study, tmp_path / "out", workers=1)
    assert data.attrs["resumed"] == len(kept)
    after = finished(tmp_path / "out")
    assert {path: after[path] for path in kept} == kept  # not performed again
    if sign == signal.SIGKILL:
        assert data.drop_attrs().equals(tf.sweep(study, tmp_path / "fresh", workers=1).drop_attrs())
    assert not list((tmp_path / "out").glob("points/*/.*.part"))


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for its children in /proc")
@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGHUP])
def test_a_terminal_ends_workers_that_are_just_starting_without_a_word(tmp_path, sign):
    command = [sys.executable, "-m", "tautflex", "sweep", str(write_study(tmp_path, 10)), "--workers", "2"]
    # Where tests run in the background of a shell, processes are told to let Ctrl-C pass.
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    process = subprocess.Popen(command, stderr=subprocess.PIPE, cwd=tmp_path, start_new_session=True)
    signal.signal(signal.SIGINT, before)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    while len(children.read_text(encoding="ascii").split()) < 2:  # one tracks what they share, the first worker
        time.sleep(0.01)
    time.sleep(0.3)
    os.killpg(process.pid, sign)
    said = process.communicate()[1].decode()
    assert process.returncode == 128 + sign
    assert said.splitlines() == [line for line in said.splitlines() if line.startswith("tautflex: interrupted")], said


@pytest.mark.slow
def test_workers_have_one_thread_of_linear_algebra_each(monkeypatch):
    names = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"
    for name in names:
        monkeypatch.delenv(name, raising=False)
    with Processes(2) as processes:
        assert dict(processes.each(os.getenv, names)) == dict.fromkeys(names, "1")
    assert not set(names) & set(os.environ)


@pytest.mark.slow
def test_a_worker_that_dies_is_one_line_and_finished_points_are_kept(tmp_path):
    plan = make_plan(write_study(tmp_path, 10, 2.0), tmp_path / "out")
    with Pool(2) as pool:
        performed = pool.perform(plan.task, plan.chunks(2))
        next(performed)
        next(performed)
        os.kill(next(iter(pool._processes._pool._processes)), signal.SIGKILL)
        with pytest.raises(WorkerLostError, match="finished runs are kept"):
            list(performed)
    assert len(finished(tmp_path / "out")) >= 2


STRUCK = """
import signal
from concurrent.futures import wait
from tautflex.study.engines import processes

class Kept:  # as a lock stays when an exception comes inside of wait
    def __init__(self, lock):
        self.lock = lock
    def __enter__(self):
        return self.lock.__enter__()
    def __exit__(self, kind, *rest):
        return None if kind is not None else self.lock.__exit__(kind, *rest)

def striking(pending, *more, **named):
    with Kept(next(iter(pending))._condition._lock):
        signal.raise_signal(signal.SIGINT)
    return wait(pending, *more, **named)

if __name__ == "__main__":
    processes.wait = striking
    try:
        with processes.Processes(1) as pool:
            list(pool.each(abs, range(-3, 0)))
    except KeyboardInterrupt:
        print("interrupted")
"""


@pytest.mark.slow
def test_a_signal_while_the_pool_holds_its_locks_ends_it(tmp_path):
    """An exception there would leave one of them held, and the pool's thread wait for it for ever."""
    (tmp_path / "struck.py").write_text(STRUCK, encoding="utf-8")
    done = subprocess.run([sys.executable, "struck.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.stdout == "interrupted\n", done.stderr


@pytest.mark.slow
@pytest.mark.jax
def test_a_batch_is_its_single_runs(tmp_path):
    """Central differences to round-off."""
    pytest.importorskip("jax")
    single, batch = (tf.sweep(film_study((0.05, 0.2), kind=kind), tmp_path / kind) for kind in ("serial", "batch"))
    for name in ("probes.A.amplitude", "probes.A.dominant_frequency"):
        np.testing.assert_allclose(batch[name], single[name], rtol=1e-12)
    assert batch["status"].equals(single["status"])
    assert batch["probes.A.amplitude"].attrs == single["probes.A.amplitude"].attrs


def dask(*words: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


@pytest.mark.slow
def test_a_cluster_whose_workers_come_and_go(tmp_path):
    """Two workers as processes of their own; one is killed in the middle and one added: nothing is computed twice."""
    pytest.importorskip("distributed")
    study = write_study(tmp_path, 20, 2.0)
    place = tmp_path / "scheduler.json"
    away = ("--no-dashboard", "--scheduler-file", str(place))
    worker = ("worker", "--scheduler-file", str(place), "--nthreads", "1", "--no-dashboard", "--no-nanny")
    worker += ("--death-timeout", "60", "--local-directory", str(tmp_path / "scratch"))
    here = str(Path(__file__).parents[2] / "src")
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [here, before]))
    processes = [dask("scheduler", "--port", "0", "--host", "127.0.0.1", *away)]
    try:
        processes += [dask(*worker), dask(*worker)]
        while not place.exists() or not place.read_text(encoding="utf-8"):
            time.sleep(0.05)
        address = json.loads(place.read_text(encoding="utf-8"))["address"]
        seen: dict[Path, int] = {}

        def look(fraction: float, message: str) -> None:
            for path, written in finished(tmp_path / "out").items():
                seen.setdefault(path, written)
            if len(processes) == 3 and fraction > 0.3:
                os.killpg(processes[1].pid, signal.SIGKILL)
                processes.append(dask(*worker))

        data = tf.sweep(study, tmp_path / "out", scheduler=address, progress=look)
    finally:
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before
        for process in processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    assert len(processes) == 4
    assert (data["status"] == "completed").all()
    after = finished(tmp_path / "out")
    assert len(after) == 40
    assert {path: after[path] for path in seen} == seen
    alone = tf.sweep(study, tmp_path / "alone", workers=1)
    assert data.drop_attrs().equals(alone.drop_attrs())
