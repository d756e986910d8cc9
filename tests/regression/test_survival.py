"""Results survive full disks, kills, broken links and a second command in their folder."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from tautflex.case import parse_case
from tautflex.cli import main
from tautflex.files.transaction import publish, result_file, result_folder
from tautflex.interrupts import exit_code, listening
from tautflex.writing import finish
from unit.full_disk import files_no_longer_than
from unit.study_cases import FILM as REDUCED_FILM
from verification.builders import FILM_CASE

PEAK = "\nprint(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)"


def wrote(place: Path, final: Path, text: str) -> list[Path]:
    (place / "deep").mkdir()
    for name in ("a.txt", "deep/b.txt"):
        (place / name).write_text(text)
    return [final / name for name in ("a.txt", "deep/b.txt")]


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_files_move_together_or_not_at_all(tmp_path):
    folder = tmp_path / "new" / "results"
    assert publish(folder, lambda place, final: wrote(place, final, "one")) == [folder / "a.txt", folder / "deep/b.txt"]

    def fails(place, final):
        wrote(place, final, "two")
        raise tf.InputError("in the middle")

    with pytest.raises(tf.InputError, match="in the middle"):
        publish(folder, fails)
    assert names(folder) == ["a.txt", "deep/b.txt"]
    assert (folder / "a.txt").read_text() == "one"
    (folder / "mine.txt").write_text("stays")
    publish(folder, lambda place, final: wrote(place, final, "three"))
    assert (folder / "deep" / "b.txt").read_text() == "three"
    assert names(folder) == ["a.txt", "deep/b.txt", "mine.txt"]


def test_what_a_dead_process_had_completed_is_moved_and_the_rest_removed(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, text=True, check=True
    )
    dead = done.stdout.strip()
    for kind in ("part", "commit"):
        place = tmp_path / f".tautflex-{kind}-{dead}-0"
        place.mkdir()
        (place / f"{kind}.txt").write_text(kind)
    alive = tmp_path / f".tautflex-part-{os.getpid()}-0"
    alive.mkdir()
    finish(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [alive.name, "commit.txt"]


def test_a_full_disk_keeps_the_old_result_and_offers_the_new_one(tmp_path, monkeypatch):
    folder = tmp_path / "results"
    publish(folder, lambda place, final: wrote(place, final, "old"))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    tried = []

    def write(place, final):
        tried.append(place)
        with files_no_longer_than(1000 if len(tried) == 1 else 10**9):
            tf.save(xr.Dataset({"long": ("x", np.arange(1e4))}), place / "run.nc")

    with pytest.raises(tf.NotWrittenError, match=r"File too large.*what stood there is whole.*kept in") as told:
        publish(folder, write)
    assert "\n" not in str(told.value)
    assert names(folder) == ["a.txt", "deep/b.txt"]
    kept = Path(str(told.value).rpartition("kept in ")[2])
    assert tf.load(kept / "run.nc").sizes["x"] == 10**4


def test_two_commands_in_one_folder_are_kept_apart(tmp_path):
    code = (
        "import sys, pathlib; from tautflex.files.transaction import result_folder\n"
        "with result_folder(pathlib.Path(sys.argv[1])): print('in', flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "out")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "in\n"
        with pytest.raises(tf.CaseError, match=f"process {other.pid}"), result_folder(tmp_path / "out"):
            pass
        other.kill()
    with result_folder(tmp_path / "out"):
        (tmp_path / "out" / "kept").touch()
    assert names(tmp_path) == ["out/kept"]


@contextmanager
def another_that_writes(path: Path) -> Iterator[subprocess.Popen[str]]:
    """Process that has a file to itself until it is killed."""
    code = (
        "import sys, pathlib; from tautflex.files.transaction import result_file\n"
        "with result_file(pathlib.Path(sys.argv[1])): print('in', flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", code, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout.readline() == "in\n"
        yield other
        other.kill()


@pytest.mark.parametrize(
    "words", [["train", "slew.toml"], ["explore", "m2.toml"], ["report", "run.nc"], ["animate", "run.nc"]]
)
def test_two_commands_for_one_file_are_kept_apart(tmp_path, capsys, words):
    target, run = tmp_path / "made.html", tmp_path / "run.nc"
    run.touch()
    with another_that_writes(target) as other:
        assert main([words[0], str(run) if words[1] == run.name else words[1], "-o", str(target)]) == 2
        assert f"a file that no other command writes to, got that of process {other.pid}" in capsys.readouterr().err
    with result_file(target):
        target.touch()
    assert names(tmp_path) == ["made.html", "run.nc"]


def test_two_runs_are_kept_apart_where_the_folder_of_their_checkpoint_is_not_there_yet(tmp_path):
    place = tmp_path / "new" / "kept"
    with another_that_writes(place) as other:
        asked = parse_case(FILM_CASE + '[maneuver]\nkind = "stop"\nrate = 0.5\nduration = 0.1\n')
        with pytest.raises(tf.CaseError, match=f"a checkpoint that no other .* process {other.pid}"):
            tf.run_case(asked, checkpoint=place)
    with result_file(place):
        pass
    assert names(tmp_path) == []


def test_links_to_nothing_are_refused_before_the_work(tmp_path, capsys):
    case = tmp_path / "film.toml"
    case.write_text(FILM_CASE)
    (tmp_path / "out").symlink_to(tmp_path / "nowhere")
    assert main(["run", str(case), "-o", str(tmp_path / "out")]) == 2
    assert "a link to nothing" in capsys.readouterr().err


def test_a_command_whose_output_was_closed_ends_well(monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    assert main(["keys", "solver", "--json"]) == 0
    assert main(["keys", "solver"]) == 0


def test_ctrl_c_at_the_start_tells_no_traceback(tmp_path):
    (tmp_path / "cyclopts.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\n")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    # Where tests run in the background of a shell, processes are told to let Ctrl-C pass.
    begin = "import runpy, signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    command = [
        sys.executable,
        "-c",
        f"{begin}runpy.run_module('tautflex', run_name='__main__', alter_sys=True)",
        "keys",
    ]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")


def wait():
    for _ in range(500):
        time.sleep(0.01)


@pytest.mark.parametrize("name", ["llvmlite.binding", "jax._src.lib"])
def test_a_signal_waits_until_no_library_can_be_calling_back(name):
    library = {"__name__": name}
    exec("def call(function):\n    function()", library)
    with listening():
        library["call"](lambda: signal.raise_signal(signal.SIGTERM))
        assert exit_code() == 0
        with pytest.raises(KeyboardInterrupt):
            wait()
        assert exit_code() == 128 + signal.SIGTERM


@pytest.mark.slow
def test_existing_results_need_force_or_resume(tmp_path, capsys):
    case, out = tmp_path / "film.toml", str(tmp_path / "out")
    case.write_text(FILM_CASE + '[maneuver]\nkind = "stop"\nrate = 0.5\nduration = 0.1\n')
    assert main(["run", str(case), "-o", out, "--json"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert first["resumed_from"] == 0.0
    assert main(["run", str(case), "-o", out]) == 2
    assert "add --force to replace it or --resume to go on" in capsys.readouterr().err
    (tmp_path / "out" / "loop.png").touch()
    assert main(["run", str(case), "-o", out, "--resume"]) == 0
    assert "nothing is left to do" in capsys.readouterr().out
    assert main(["run", str(case), "-o", out, "--resume", "--set", "maneuver.rate=0.4"]) == 2
    assert "of another case" in capsys.readouterr().err
    assert main(["run", str(case), "-o", out, "--force", "--resume"]) == 2
    capsys.readouterr()
    assert main(["run", str(case), "-o", out, "--force", "--set", "maneuver.rate=0.4", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["maneuver"] != first["maneuver"]
    assert (tmp_path / "out" / "loop.png").exists()  # not one of the earlier run


@pytest.mark.slow
def test_random_kills_leave_whole_files_and_equal_results(tmp_path):
    script = Path(__file__).with_name("campaigns") / "kills.py"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, str(script), "6", "0", "inf", "run", "export csv", "sweep"],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_ten_times_the_record_takes_no_more_memory(tmp_path):
    case, peaks = tmp_path / "film.toml", []
    case.write_text(REDUCED_FILM)
    for steps in (40_000, 400_000):
        code = f"import sys, resource; from tautflex.cli import main\nmain(sys.argv[1:]){PEAK}"
        command = [sys.executable, "-c", code, "run", str(case), "--force", "-o", str(tmp_path / "out")]
        command += ["--set", f"solver.end_time={5e-3 * steps}", "--checkpoint", "1"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        peaks.append(int(done.stderr.split()[-1]) / 1e3)
    assert (tmp_path / "out" / "run.nc").stat().st_size > 80e6
    assert peaks[1] < 1.15 * peaks[0], peaks
