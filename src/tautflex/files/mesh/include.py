"""Files that a mesh file includes: only those in its own folder and below, to a bounded depth."""

from __future__ import annotations

import codecs
import io
from collections.abc import Callable, Iterator
from pathlib import Path

from tautflex.errors import MeshError
from tautflex.files.content import read_bytes
from tautflex.files.mesh.raw import shorten

Line = tuple[str, str]
"""Place of a line for messages, and its text."""
LARGEST_FILE = 200_000_000
DEEPEST = 10
_MOST_FILES = 1000


def numbered_lines(text: str, file: str = "") -> list[Line]:
    """Lines of a text with their places, "line 3" or "wing.bdf line 3"."""
    prefix = f"{file} line" if file else "line"
    # Not `str.splitlines`, which also ends lines at bytes that comments in other encodings have within letters.
    lines = io.StringIO(text, newline=None)
    return [(f"{prefix} {number}", line.rstrip("\n")) for number, line in enumerate(lines, start=1)]


def decoded(content: bytes, where: str = "") -> str:
    """Text of a file, whose comments may be in any encoding of bytes and all else is ASCII; MeshError if in UTF-16."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise MeshError(f"{where}expected text in ASCII or UTF-8, got UTF-16; save it as UTF-8")
    return content.removeprefix(codecs.BOM_UTF8).decode("latin-1")


class Folder:
    """The folder of a mesh file, and what may still be read from it.

    Parameters
    ----------
    file
        The mesh file; None for a text that came from none, which can include nothing.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._root = None if file is None else file.absolute().parent.resolve()
        self._bytes, self._files = LARGEST_FILE, _MOST_FILES

    def lines(self, name: str, where: str) -> list[Line]:
        """Lines of an included file; MeshError if it is outside the folder, missing, or too large."""
        shown = shorten(name, 80)
        if self._root is None:
            raise MeshError(f"{where}: expected one text, got an included file {shown}; read the file by its path")
        try:
            path = (self._root / name.replace("\\", "/")).resolve()
        except (OSError, ValueError, RuntimeError) as error:
            raise MeshError(f"{where}: cannot find the included file {shown} ({error}); correct its name") from None
        if not path.is_relative_to(self._root):
            raise MeshError(
                f"{where}: expected an included file in the folder of the mesh or below, got {shown}; move it there"
            )
        self._files -= 1
        content = read_bytes(path, f"{where}: {shown}", "mesh", LARGEST_FILE, "put it beside the mesh", MeshError)
        self._bytes -= len(content)
        if self._bytes < 0 or self._files < 0:
            raise MeshError(
                f"{where}: expected at most {_MOST_FILES} included files of {LARGEST_FILE / 1e6:g} MB together, got "
                "more; does a file include itself?"
            )
        return numbered_lines(decoded(content, f"{where}: {shown}: "), shorten(path.name, 30).strip("'"))


Statement = Callable[[str, str, Iterator[Line]], str | None]
"""Name of the file that a line includes, None if it is another line; it may take further lines."""


def expanded(lines: list[Line], folder: Folder, statement: Statement, depth: int = 0) -> Iterator[Line]:
    """All lines, those of included files in their places."""
    rest = iter(lines)
    for where, text in rest:
        name = statement(where, text, rest)
        if name is None:
            yield where, text
        elif depth >= DEEPEST:
            raise MeshError(
                f"{where}: expected files included to a depth of {DEEPEST}, got a deeper one; does one include itself?"
            )
        else:
            yield from expanded(folder.lines(name, where), folder, statement, depth + 1)
