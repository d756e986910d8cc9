"""The house seen from outside: which module imports which, a picture of it, and compiled code that a change made stale.

``make rooms`` runs this file and draws ``docs/figures/rooms.svg``; ``python tools/house.py --stale`` removes stale
compiled code, which tests do by themselves.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from functools import cache
from html import escape
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
ROOT = HOME / "src" / "tautflex"
PICTURE = HOME / "docs" / "figures" / "rooms.svg"
MODULES = {
    ".".join(("tautflex", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in ROOT.rglob("*.py")
}


def imported(path: Path) -> Iterator[str]:
    """Modules of ours that a file names in any import: late ones, those for type checkers and those by name too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Constant) and re.fullmatch(r"[\w.]+:\w+", str(node.value)):
            names = [f"tautflex.{str(node.value).partition(':')[0]}"]  # "module:Class", imported when asked for
        else:
            continue
        yield from (name for name in names if name in MODULES)


@cache
def arrows() -> dict[str, set[str]]:
    """Modules that each module imports.

    Packages only pass names on; an arrow to one stands for an arrow to what it passes on.
    """
    return {
        name: {other for other in imported(path) if other != name and MODULES[other].name != "__init__.py"}
        for name, path in MODULES.items()
        if path.name != "__init__.py"
    }


def reached(name: str) -> set[str]:
    """Modules that a module needs, directly or through others."""
    found: set[str] = set()
    waiting = [name]
    while waiting:
        for other in arrows().get(waiting.pop(), ()):
            if other not in found:
                found.add(other)
                waiting.append(other)
    return found


def drop_stale_code() -> list[Path]:
    """Remove compiled functions that are older than a file they were made from, and return their files.

    Numba looks at the file of a function alone, not at those of the functions and constants that it built in.
    """
    compiled = {path: path.stat().st_mtime_ns for path in ROOT.rglob("*.nb[ic]")}
    changed = {name: path.stat().st_mtime_ns for name, path in MODULES.items()}
    if not compiled or min(compiled.values()) > max(changed.values()):
        return []  # the usual case, found without reading a file
    newest: dict[str, int] = {}
    stale = []
    for path, time in compiled.items():
        folder = path.parent.parent.relative_to(ROOT).parts
        name = ".".join(("tautflex", *folder, path.name.split(".")[0]))  # a file is called MODULE.FUNCTION-LINE...
        if name not in newest:
            newest[name] = max(changed.get(other, time + 1) for other in {name, *reached(name)})
        if newest[name] > time:
            path.unlink(missing_ok=True)
            stale.append(path)
    return stale


def rooms() -> list[str]:
    """Rooms from the top floor to the ground, in the order of the import contract, those of the solvers one by one."""
    tools = tomllib.loads((HOME / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    floors = {
        container: [name.strip(" ()") for layer in contract["layers"] for name in layer.split("|")]
        for contract in tools["importlinter"]["contracts"]
        if contract["type"] == "layers"
        for container in contract["containers"]
    }
    named: list[str] = []
    for room in floors["tautflex"]:
        inner = floors.get(f"tautflex.{room}")
        named += [f"{room}.{name}" for name in inner] if inner else [room]
    return [room for room in named if _files(room)]


def _files(room: str) -> list[str]:
    whole = f"tautflex.{room}"
    return [name for name in MODULES if f"{name}.".startswith(f"{whole}.")]


def picture() -> str:
    """Rooms and their imports as SVG: how many files of the room of a row import the room of a column."""
    names = rooms()
    files = {room: _files(room) for room in names}
    room_of = {name: room for room in names for name in files[room]}
    counts: Counter[tuple[str, str]] = Counter()
    for row in names:
        for name in files[row]:
            counts.update((row, column) for column in {room_of.get(other, row) for other in imported(MODULES[name])})
    cell, left, top = 30, 190, 150
    size = cell * len(names)
    width, height = left + size + 130, top + size + 40
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="system-ui,-apple-system,Segoe UI,Roboto,DejaVu Sans,sans-serif" font-size="13" fill="#1b1f24">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        '<text x="12" y="24" font-size="16" font-weight="600">Rooms and their imports</text>',
        '<text x="12" y="44" fill="#57606a">how many files of a row import the column</text>',
    ]
    for place, room in enumerate(names):
        middle, start = top + cell * place + cell // 2, left + cell * place
        parts += [
            f'<text x="{left - 46}" y="{middle + 4}" text-anchor="end">{escape(room)}</text>',
            f'<text x="{left - 10}" y="{middle + 4}" text-anchor="end" fill="#57606a">{len(files[room])}</text>',
            f'<text transform="translate({start + cell // 2 + 4} {top - 8}) rotate(-60)">{escape(room)}</text>',
            f'<rect x="{start}" y="{top + cell * place}" width="{cell}" height="{cell}" fill="#d5dbe1"/>',
        ]
    for (row, column), count in sorted(counts.items()):
        if row != column:
            x, y = left + cell * names.index(column), top + cell * names.index(row)
            share = count / len(files[row])
            upward = names.index(column) < names.index(row)
            parts += [
                f'<rect x="{x}" y="{y}" width="{cell}" height="{cell}" fill="{"#c0392b" if upward else "#2f7fc1"}" '
                f'fill-opacity="{0.12 + 0.68 * share:.2f}"/>',
                f'<text x="{x + cell // 2}" y="{y + cell // 2 + 4}" text-anchor="middle">{count}</text>',
            ]
    lines = [f"M{left} {top + cell * k}h{size}M{left + cell * k} {top}v{size}" for k in range(len(names) + 1)]
    parts += [
        f'<path d="{"".join(lines)}" stroke="#d5dbe1" fill="none"/>',
        f'<text x="{left}" y="{top + size + 26}" fill="#57606a">Beside the names: files of the room. '
        "Everything stands right of the diagonal: imports run one way, down.</text>",
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    if "--stale" in sys.argv[1:]:
        drop_stale_code()
    else:
        PICTURE.write_text(picture(), encoding="utf-8")
