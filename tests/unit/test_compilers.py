"""Processes that compile beside a command: what they compile is found, and nobody is left."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from numba import types

import tautflex
from tautflex import compilers
from tautflex.cli import main
from tautflex.linking import _File

pytestmark = pytest.mark.skipif(compilers.fcntl is None, reason="commands compile alone there")

KERNELS = """
from tautflex.numeric import jit
@jit
def first(x):
    return x[0] + 1
@jit
def second(x, pair):
    return x[0] + pair[1]
@jit
def endless(x):
    return x.no_such_thing
"""
LISTED = """[1,"fresh_kernels","endless",["float64:1"]]
[1,"fresh_kernels","gone",["float64:1"]]
[0,"fresh_kernels","second",["float64:1",["int64","float64"]]]
[0,"fresh_kernels","first",["float64:1"]]
"""
PROGRAM = """
import sys, time
from pathlib import Path
import numpy
import fresh_kernels
from tautflex import compilers
compilers.LIST = Path("listed.jsonl")
{before}
with compilers.helped():
    print(fresh_kernels.first(numpy.ones(1)))
    print(*(each.pid for each in compilers._crew.others) if compilers._crew else (), flush=True)
    {then}
"""


@pytest.fixture
def program(tmp_path):
    """A command's process in a folder of its own, with one process beside it where that is wanted."""
    (tmp_path / "fresh_kernels.py").write_text(KERNELS, encoding="utf-8")
    (tmp_path / "listed.jsonl").write_text(LISTED, encoding="utf-8")
    home = str(Path(tautflex.__file__).parents[1])
    started = []

    def start(then: str, beside: str = "1", before: str = "") -> subprocess.Popen[str]:
        environment = os.environ | {compilers.SWITCH: beside, "PYTHONPATH": os.pathsep.join([str(tmp_path), home])}
        command = [sys.executable, "-c", PROGRAM.format(then=then, before=before)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        started.append(subprocess.Popen(command, cwd=tmp_path, env=environment, text=True, **pipes))
        return started[-1]

    yield start
    for each in started:
        each.kill()
        each.communicate()


def code(folder: Path) -> list[str]:
    return sorted(path.name.split("-")[0] for path in folder.rglob("*.nbc"))


def runs(number: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{number}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()[0]
    except OSError:
        return False


def wait_until(done, seconds: float) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end
        time.sleep(0.05)


WAIT = "while len(list(Path('__pycache__').glob('*.nbc'))) < 2: time.sleep(0.05)"


@pytest.mark.slow
def test_what_another_process_compiled_is_found_and_it_ends_with_the_command(program, tmp_path):
    done = program(WAIT)
    said, told = done.communicate(timeout=120)
    assert (done.returncode, told) == (0, "")
    answer, beside = said.split()
    assert answer == "2.0"
    assert not runs(int(beside))
    assert code(tmp_path) == ["fresh_kernels.first", "fresh_kernels.second"]
    check = "assert fresh_kernels.second(numpy.ones(1), (1, 2.0)) == 3.0; assert fresh_kernels.second.stats.cache_hits"
    done = program(check)
    said, told = done.communicate(timeout=120)
    assert (said, told) == ("2.0\n\n", "")  # all of it is found: nobody is started


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_no_process_is_left_when_the_command_is_killed(program, tmp_path, number):
    killed = program("time.sleep(100)")
    assert killed.stdout.readline() == "2.0\n"
    beside = int(killed.stdout.readline())
    killed.send_signal(number)
    wait_until(lambda: not runs(beside), 10.0)
    assert not list(tmp_path.rglob("*.tmp.*"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [{"beside": "0"}, {"before": "fresh_kernels.first._cache = __import__('numba').core.caching.NullCache()"}],
)
def test_nobody_is_started_if_not_wanted_or_without_a_place_for_code(program, arguments):
    said, told = program("pass", **arguments).communicate(timeout=120)
    assert (said, told) == ("2.0\n\n", "")


def test_the_number_of_processes_is_one_per_other_core_or_as_given(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: set(range(_cores)), raising=False)
    for given, _cores, expected in (("", 1, 0), ("", 2, 1), ("", 64, compilers.MOST), ("0", 8, 0), ("2", 1, 2)):
        monkeypatch.setenv(compilers.SWITCH, given)
        assert compilers._count() == expected


def test_a_number_of_processes_that_is_none_is_refused_in_one_line(monkeypatch, capsys):
    monkeypatch.setenv(compilers.SWITCH, "all")
    assert main(["keys", "mesh"]) == 2
    expected = (
        "tautflex: error: TAUTFLEX_COMPILERS: expected a number of processes, got 'all'; 0 compiles in one alone\n"
    )
    assert capsys.readouterr().err == expected


def test_types_are_written_and_read():
    vector = types.Array(types.float64, 1, "C")
    known = types.Tuple((types.int64, types.UniTuple(vector, 2), types.none, types.boolean))
    listed = ["int64", ["float64:1", "float64:1"], "none", "bool"]
    assert compilers.written(known) == listed
    assert compilers._type(listed) == known
    with pytest.raises(ValueError, match="in order of C"):
        compilers.written(types.Array(types.float64, 1, "A"))


def test_two_processes_that_save_at_once_do_not_take_each_others_code(tmp_path):
    """The index of the one that comes last names its own file, whatever the other one wrote meanwhile."""
    stamp, target, hashes = (1.0, 2), ("triple", "cpu", ""), ("code", "closure")
    one, other = (_File(str(tmp_path), "f", stamp) for _ in range(2))
    one._load_index = other._load_index = dict  # neither has seen what the other one saves
    one.save(((types.int64,), target, hashes), "whole numbers")
    other.save(((types.float64,), target, hashes), "real ones")
    one._save_data(one._data_name(1), "whole numbers")  # as Numba names them
    late = _File(str(tmp_path), "f", stamp)
    assert late.load(((types.float64,), target, hashes)) == "real ones"
    assert late.load(((types.int64,), target, hashes)) is None


@pytest.mark.slow
def test_list_of_functions_is_current():
    tool = Path(__file__).parents[2] / "tools" / "compiled.py"
    done = subprocess.run([sys.executable, tool, "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"commands compile other functions: python tools/compiled.py\n{done.stdout}"
