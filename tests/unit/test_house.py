"""The house itself: rooms of bearable size, no import circle, stored runs that know what they depend on."""

from __future__ import annotations

import os

import pytest

import house
from house import MODULES, ROOT, arrows, reached
from tautflex.case.prepared import source_files


def test_no_import_circle():
    circle = sorted(name for name in arrows() if name in reached(name))
    assert circle == []


def test_files_and_folders_of_bearable_size():
    long = {name: lines for name, path in MODULES.items() if (lines := len(path.read_text().splitlines())) > 400}
    assert long == {}
    folders = [ROOT, *(path for path in ROOT.rglob("*") if path.is_dir())]
    wide = {str(folder): count for folder in folders if (count := len(list(folder.glob("*.py")))) > 15}
    assert wide == {}


@pytest.mark.parametrize("name", ["study.work", "case.run", "solvers.linear.panels", "case.tables"])
def test_key_of_a_stored_run_covers_all_it_needs(name):
    needed = {MODULES[other] for other in {f"tautflex.{name}", *reached(f"tautflex.{name}")}}
    assert needed <= set(source_files())


def test_picture_of_the_rooms_is_current():
    picture = house.picture()
    assert house.PICTURE.read_text(encoding="utf-8") == picture, "imports between rooms changed: make rooms"
    assert "#c0392b" not in picture, "an import leads up, which the picture shows in red"


def test_compiled_code_older_than_what_it_was_made_from_goes(tmp_path, monkeypatch):
    """b builds in a's function, c stands alone; a is edited after all three were compiled."""
    modules = {f"tautflex.room.{name}": tmp_path / "room" / f"{name}.py" for name in "abc"}
    (tmp_path / "room" / "__pycache__").mkdir(parents=True)
    compiled = {name: tmp_path / "room" / "__pycache__" / f"{name}.f-1.py311.1.nbc" for name in "abc"}
    for time, paths in enumerate((modules.values(), compiled.values())):
        for path in paths:
            path.write_text("from tautflex.room import a" if path.name == "b.py" else "", encoding="utf-8")
            os.utime(path, (time, time))
    monkeypatch.setattr(house, "ROOT", tmp_path)
    monkeypatch.setattr(house, "MODULES", modules)
    arrows.cache_clear()
    try:
        assert house.drop_stale_code() == []
        os.utime(modules["tautflex.room.a"], (2, 2))
        assert sorted(house.drop_stale_code()) == [compiled["a"], compiled["b"]]
        assert list(compiled["c"].parent.iterdir()) == [compiled["c"]]
    finally:
        arrows.cache_clear()
