"""Keyword blocks of Abaqus input files, before anything in them has a meaning."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from tautflex.errors import MeshError
from tautflex.files.mesh.include import Folder, Line, expanded, numbered_lines
from tautflex.files.mesh.raw import shorten

_INCLUDE = re.compile(r"\s*\*\s*include\s*(?:,|$)", re.IGNORECASE)
_INPUT = re.compile(r"input\s*=\s*\"?([^,\"]*)", re.IGNORECASE)
_TAKES_FILES = ("NODE", "ELEMENT", "NSET", "ELSET")


@dataclass(frozen=True)
class Block:
    """Keyword line with its options, the data lines below it, and the place of each for messages."""

    keyword: str
    options: dict[str, str]
    where: str
    lines: list[Line]

    def option(self, name: str) -> str:
        """Value of an option without quotes, "" if it is not given."""
        return self.options.get(name, "")

    def require_options(self, *known: str) -> None:
        """Raise MeshError if an option is given that is none of ``known``."""
        for name in self.options:
            if name not in known:
                raise MeshError(
                    f"{self.where}: expected options out of {', '.join(known) or 'none'}, got {shorten(name)}, which "
                    "is not read here and may change the structure; remove it"
                )


def blocks(text: str, folder: Folder) -> Iterator[Block]:
    """Keyword blocks of an input file and what it includes, comments left out, continued keyword lines joined."""
    current: Block | None = None
    pending = ""
    for where, raw_line in expanded(numbered_lines(text), folder, _included):
        line = raw_line.strip()
        if line.startswith("**") or not line:
            continue
        if pending or line.startswith("*"):
            pending += line
            if pending.endswith(","):
                continue
            if current is not None:
                yield _with_files(current, folder)
            current, pending = _block(pending, where), ""
        elif current is not None:
            current.lines.append((f"{where} ({current.keyword[:30]})", line))
        else:
            raise MeshError(f"{where}: expected a keyword such as *NODE, got {shorten(line)}; is this Abaqus input?")
    if pending:
        raise MeshError(
            f"expected the rest of a keyword behind its last comma, got the end of the file: {shorten(pending)}"
        )
    if current is not None:
        yield _with_files(current, folder)


def _included(where: str, text: str, more: Iterator[Line]) -> str | None:
    if _INCLUDE.match(text) is None:
        return None
    while text.rstrip().endswith(","):
        text += next(more, ("", "none"))[1]
    found = _INPUT.search(text)
    if found is None or not found[1].strip():
        raise MeshError(f"{where}: expected *INCLUDE, INPUT=file, got {shorten(text.strip())}; name the file")
    return found[1].strip()


def _with_files(block: Block, folder: Folder) -> Block:
    """Data lines that stand in a file of their own come before those below the keyword."""
    if "INPUT" in block.options and block.keyword in _TAKES_FILES:
        lines = [(where, line.strip()) for where, line in folder.lines(block.options.pop("INPUT"), block.where)]
        block.lines[:0] = [(where, line) for where, line in lines if line and not line.startswith("**")]
    return block


def _block(line: str, where: str) -> Block:
    keyword, *options = (part.strip() for part in line.split(","))
    pairs = (option.partition("=") for option in options if option)
    name = " ".join(keyword[1:].upper().split())
    return Block(
        name,
        {" ".join(key.upper().split()): value.strip().strip('"') for key, _, value in pairs},
        f"{where} ({name[:30]})",
        [],
    )


def fields(line: str) -> list[str]:
    """Fields of a data line without the empty ones at its end."""
    parts = [part.strip() for part in line.split(",")]
    while parts and not parts[-1]:
        parts.pop()
    return parts
