"""Compilation that takes a while is told once; code is kept where a user may write."""

from __future__ import annotations

import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from numba.core import event

from tautflex import compiling
from tautflex.case import template


@pytest.fixture
def compile_anew(monkeypatch):
    """A function that compiles for the given time and more, as often as it is asked."""
    compiling.watch()
    monkeypatch.setattr(compiling, "announcing", True)
    monkeypatch.setattr(compiling, "announced", False)

    def compile_one(least: float) -> None:
        with event.trigger_event("numba:compile"):
            time.sleep(least)
            with event.trigger_event("numba:compile"):
                numba.njit(lambda x: x + 1)(1)

    return compile_one


def test_compilation_that_takes_a_while_is_told_once_while_it_goes_on(monkeypatch, capsys, compile_anew):
    monkeypatch.setattr(compiling, "patience", 0.01)
    for _ in range(2):
        compile_anew(0.1)
    told = capsys.readouterr().err
    assert told.startswith("tautflex: compiling what is used here for the first time")
    assert told.count("\n") == 1


def test_compilation_of_a_moment_is_not_told(monkeypatch, capsys, compile_anew):
    monkeypatch.setattr(compiling, "patience", 1e3)
    compile_anew(0.0)
    assert not capsys.readouterr().err


def test_code_is_kept_in_a_folder_of_this_user_alone(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    compiling.temporary_place.cache_clear()
    place = compiling.temporary_place()
    others = tmp_path / place.rsplit("/", 1)[-1]
    assert others.is_dir()
    assert others.stat().st_mode & 0o077 == 0
    others.chmod(0o777)  # somebody else may have put code there
    compiling.temporary_place.cache_clear()
    assert compiling.temporary_place() != place
    compiling.temporary_place.cache_clear()


def test_kernels_are_compiled_by_the_one_function_that_finds_a_place_for_their_code():
    root = Path(compiling.__file__).parent
    own = [
        path.name for path in root.rglob("*.py") if "njit(" in (text := path.read_text("utf-8")) or "= Kernel(" in text
    ]
    assert own == ["numeric.py"]


def test_what_compiled_code_calls_has_no_machine_code_of_its_own_until_python_calls_it(tmp_path, monkeypatch):
    (tmp_path / "fresh_kernels.py").write_text(_KERNELS)  # where no code is kept yet
    monkeypatch.syspath_prepend(tmp_path)
    kernels = import_module("fresh_kernels")
    x = np.array([1.0, 3.0])
    assert kernels.mean(x) == 2.0
    assert (len(kernels.total.part.signatures), len(kernels.total.signatures)) == (1, 0)
    assert "@function" not in kernels.total.part.inspect_asm(kernels.total.part.signatures[0])
    assert kernels.total(x) == 4.0
    with pytest.raises(ValueError, match="no values"):
        kernels.mean(np.zeros(0))


_KERNELS = """
from tautflex.case import template
from tautflex.numeric import jit
@jit
def total(x):
    return x[0] + x[1]
@jit
def mean(x):
    if not x.size:
        raise ValueError("no values")
    return total(x) / 2
@jit
def twice(x):
    return 2 * total(x)
"""


@pytest.mark.slow
def test_later_processes_find_the_code_and_build_it_into_other_callers(tmp_path):
    (tmp_path / "kernels.py").write_text(_KERNELS)
    program = "import numpy, kernels as k; x = numpy.array([1.0, 3.0]); print({}, *[sum(c) for c in ({})])"
    found = "f.stats.cache_hits.values() for f in (k.mean, k.total.part, k.total)"
    answers = [
        subprocess.run(
            [sys.executable, "-c", program.format(called, found)],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        for called in ("k.mean(x)", "k.mean(x)", "k.twice(x)", "k.total(x)")
    ]
    assert answers == [["2.0", "0", "0", "0"], ["2.0", "1", "0", "0"], ["8.0", "0", "1", "0"], ["4.0", "0", "0", "0"]]


def test_code_of_batches_is_kept_among_the_users_caches_if_these_can_be_written(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert compiling.user_place("jax") == str(tmp_path / "tautflex" / "jax")
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert compiling.user_place("jax") is None


@pytest.mark.slow
def test_check_imports_nothing_that_it_does_not_use(tmp_path):
    (tmp_path / "m2.toml").write_text(template("m2"), encoding="utf-8")
    program = (
        "import sys; from tautflex.cli import main; main(['check', 'm2.toml']); print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    unused = {"pandas", "xarray.core", "matplotlib", "scipy.integrate", "scipy.optimize", "scipy.io", "jax"}
    assert not unused & set(done.stderr.split())


def test_a_training_says_when_it_compiles_and_when_it_begins(monkeypatch, capsys):
    training = pytest.importorskip("tautflex.learning.train")
    monkeypatch.setattr(compiling, "announcing", True)
    made, told = object.__new__(training._Training), []
    at = SimpleNamespace(mean=0, best_cost=0.0, _replace=lambda **new: at)

    def heard(answer):
        told.append(capsys.readouterr().err)
        return answer

    made._s, made._segments, made._draw = {"judge_every": 2}, 5, lambda number: (0, 0)
    made._start, made._iterate = lambda: heard((at, 2.5)), lambda at, number: heard((at, 1.0))
    made._judge, made._result = lambda layers: 3.0, lambda at, judged: judged
    assert made.train(2, None, None) == [(0, 2.5), (2, 3.0)]
    started = "tautflex: compiling the training, plant and policy together ...\n"
    assert told == [started, "", "tautflex: compiled, training from a cost of 2.5 ...\n"]
    said = []
    made.train(2, None, lambda fraction, message: said.append((fraction, message.split()[0])))
    assert said == [(0.0, "compiling"), (0.0, "compiled,"), (1.0, "cost")]
    assert capsys.readouterr().err == ""  # who follows the progress is told there
