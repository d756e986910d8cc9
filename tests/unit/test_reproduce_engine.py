"""The engine of the reproduction: finished runs are kept, found again, and never trusted blindly."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tautflex import InputError, NotConvergedError
from tautflex.case import parse_case
from tautflex.files.netcdf import load
from tautflex.paper.cases.catalogue import RunSpec
from tautflex.paper.comparison import make_plan
from tautflex.paper.engine import perform
from tautflex.solvers.nonlinear.newton import NewtonOutcome
from tautflex.solvers.transient import implicit
from tautflex.study import work
from unit.study_cases import film


def spec(number: int, end: float = 0.2) -> RunSpec:
    rate = 0.01 * (number + 1)
    text = film(rate, f"time_step = 2e-3\nend_time = {end}")
    case = parse_case(text, source="film.toml")
    return RunSpec(f"film/{number}", case, "published", "M2", rate, 0.05)


def values(paths: dict[str, Path]) -> dict[str, np.ndarray]:
    return {name: load(path)["w"].values for name, path in paths.items()}


SCRIPT = """
import sys
sys.path.insert(0, {here!r})
from unit.test_reproduce_engine import spec
from tautflex.paper.engine import perform
if __name__ == "__main__":
    perform([spec(k, 4.0) for k in range(4)], {place!r}, workers={workers})
"""


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_kill_at_any_moment_loses_nothing_that_was_finished(tmp_path, workers):
    """Every command in a process of its own, as users give them."""
    place, fresh, here = tmp_path / "runs", tmp_path / "fresh", str(Path(__file__).parent.parent)
    scripts = []
    for folder in (place, fresh):
        scripts.append(tmp_path / f"{folder.name}.py")
        scripts[-1].write_text(SCRIPT.format(here=here, place=str(folder), workers=workers), encoding="utf-8")
    process = subprocess.Popen([sys.executable, str(scripts[0])], start_new_session=True)
    deadline = time.monotonic() + 120
    while not list(place.glob("*/*.nc")) and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path: path.stat().st_mtime_ns for path in place.glob("*/*.nc")}
    assert kept
    for script in scripts:
        subprocess.run([sys.executable, str(script)], check=True)
    specs = [spec(k, 4.0) for k in range(4)]
    resumed, whole = (values(perform(specs, folder, workers=1)) for folder in (place, fresh))
    assert {path: path.stat().st_mtime_ns for path in kept} == kept  # not performed again
    assert list(resumed) == list(whole)
    for name in whole:
        np.testing.assert_array_equal(resumed[name], whole[name])


@pytest.mark.slow
def test_damaged_results_are_performed_again(tmp_path):
    paths = perform([spec(0)], tmp_path, workers=1)
    before = values(paths)
    path = paths["film/0"]
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(bytes(content))
    again = values(perform([spec(0)], tmp_path, workers=1))
    np.testing.assert_array_equal(again["film/0"], before["film/0"])
    path.write_bytes(b"")
    np.testing.assert_array_equal(values(perform([spec(0)], tmp_path, workers=1))["film/0"], before["film/0"])


def test_another_case_is_another_result_and_equal_cases_are_performed_once(tmp_path):
    told = []
    first, second = spec(0), spec(1)
    twin = RunSpec("film/twin", first.case, "published", "M2", first.rate, first.duration)
    paths = perform([first, second, twin], tmp_path, 1, lambda fraction, name: told.append((fraction, name)))
    assert paths["film/0"] == paths["film/twin"] != paths["film/1"]
    assert len(list(tmp_path.glob("*/*.nc"))) == 2
    fractions = [fraction for fraction, _ in told]
    assert fractions == sorted(fractions)
    assert fractions[-1] <= 1.0


def test_a_failed_run_is_named_and_the_others_are_kept(tmp_path, monkeypatch):
    """Steps that are not allowed a single iteration fail; that is forced for one of two runs."""
    simulated = work.simulated

    def without_iterations(given, *rest):
        with monkeypatch.context() as patch:
            if given == spec(1).case:
                patch.setattr(
                    implicit, "solve_newton", lambda problem, start, *rest: NewtonOutcome(start, history=[1.0])
                )
            return simulated(given, *rest)

    monkeypatch.setattr(work, "simulated", without_iterations)
    with pytest.raises(NotConvergedError, match="film/1"):
        perform([spec(1), spec(0)], tmp_path, workers=1)
    assert len(list(tmp_path.glob("*/*.nc"))) == 1


def test_interruption_keeps_what_is_finished(tmp_path):
    def stop(fraction: float, name: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        perform([spec(0), spec(1)], tmp_path, 1, stop)
    assert len(list(tmp_path.glob("*/*.nc"))) == 1


def test_bad_arguments(tmp_path):
    with pytest.raises(InputError, match="workers"):
        perform([spec(0)], tmp_path, workers=0)
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="directory"):
        perform([spec(0)], blocked / "below", workers=1)


def test_only_what_is_asked_for_is_planned():
    names = {run.name for run in make_plan(("7",), quick=True).specs}
    assert names == {"published/M3/pi_5/T0.1", "published/M3/pi_5/T1", "published/M3/pi_5/T2"}
    assert make_plan(("2",), quick=True).specs == ()
    assert {run.variant for run in make_plan(("6",)).specs} == {"published", "nearest-node", "consistent"}
    with pytest.raises(InputError, match="expected one of"):
        make_plan(("5",))
