"""The house itself: rooms of bearable size, no import circle, stored runs that know what they depend on."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import tautflex
from tautflex.paper.finished_runs import source_files

ROOT = Path(tautflex.__file__).parent
MODULES = {
    ".".join(("tautflex", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in ROOT.rglob("*.py")
}


def imported(path: Path) -> Iterator[str]:
    """Modules of ours that a file names in any import: late ones and those for type checkers too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        else:
            continue
        yield from (name for name in names if name in MODULES)


# Packages only pass names on; an arrow to one stands for an arrow to what it passes on.
ARROWS = {
    name: {other for other in imported(path) if other != name and MODULES[other].name != "__init__.py"}
    for name, path in MODULES.items()
    if path.name != "__init__.py"
}


def reached(name: str) -> set[str]:
    """Modules that a module needs, directly or through others."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        for other in ARROWS.get(waiting.pop(), ()):
            if other not in found:
                found.add(other)
                waiting.append(other)
    return found


def test_no_import_circle():
    circle = sorted(name for name in ARROWS if name in reached(name))
    assert circle == []


def test_files_and_folders_of_bearable_size():
    long = {name: lines for name, path in MODULES.items() if (lines := len(path.read_text().splitlines())) > 400}
    assert long == {}
    folders = [ROOT, *(path for path in ROOT.rglob("*") if path.is_dir())]
    wide = {str(folder): count for folder in folders if (count := len(list(folder.glob("*.py")))) > 15}
    assert wide == {}


@pytest.mark.parametrize("name", ["paper.work", "case.run", "solvers.linear.panels", "case.tables"])
def test_key_of_a_stored_run_covers_all_it_needs(name):
    needed = {MODULES[other] for other in {f"tautflex.{name}", *reached(f"tautflex.{name}")}}
    assert needed <= set(source_files())
