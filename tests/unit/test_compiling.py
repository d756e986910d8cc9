"""The first compilation is told once; code is kept where a user may write."""

from __future__ import annotations

from pathlib import Path

import numba

from tautflex import compiling


def test_the_first_compilation_is_told_once(monkeypatch, capsys):
    compiling.watch()
    monkeypatch.setattr(compiling, "announcing", True)
    monkeypatch.setattr(compiling, "announced", False)
    for _ in range(2):
        numba.njit(lambda x: x + 1)(1)
    assert capsys.readouterr().err == "tautflex: compiling once, a minute or two ...\n"


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
    own = [path.name for path in root.rglob("*.py") if "numba.njit(" in path.read_text(encoding="utf-8")]
    assert own == ["numeric.py"]
