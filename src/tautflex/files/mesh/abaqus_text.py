"""Keyword blocks of Abaqus input files, before anything in them has a meaning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import shorten


@dataclass(frozen=True)
class Block:
    """Keyword line with its options, the data lines below it, and the place of each for messages."""

    keyword: str
    options: dict[str, str]
    where: str
    lines: list[tuple[str, str]]


def blocks(text: str) -> Iterator[Block]:
    """Keyword blocks of an input file, comments left out, continued keyword lines joined."""
    current: Block | None = None
    pending = ""
    for number, raw_line in enumerate(text.splitlines(), start=1):
        line = raw_line.strip()
        if line.startswith("**") or not line:
            continue
        if pending or line.startswith("*"):
            pending += line
            if pending.endswith(","):
                continue
            if current is not None:
                yield current
            current, pending = _block(pending, number), ""
        elif current is not None:
            current.lines.append((f"line {number} ({current.keyword[:30]})", line))
        else:
            raise MeshError(
                f"line {number}: expected a keyword such as *NODE, got {shorten(line)}; is this Abaqus input?"
            )
    if current is not None:
        yield current


def _block(line: str, number: int) -> Block:
    keyword, *options = (part.strip() for part in line.split(","))
    pairs = (option.partition("=") for option in options)
    name = " ".join(keyword[1:].upper().split())
    return Block(
        name,
        {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs},
        f"line {number} ({name[:30]})",
        [],
    )


def bare_name(name: str) -> str:
    """Name of a set or number without the instance in front of it."""
    return name.strip().strip('"').rpartition(".")[2].strip()


def fields(line: str) -> list[str]:
    """Fields of a data line without the empty ones at its end."""
    parts = [part.strip() for part in line.split(",")]
    while parts and not parts[-1]:
        parts.pop()
    return parts
