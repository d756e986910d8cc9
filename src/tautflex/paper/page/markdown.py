"""The page as Markdown, for the documentation; pictures are linked."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from tautflex.paper.page.blocks import Block, Bullets, Command, Heading, Paragraph, Table

_MARKS = {"": "", "good": "", "fair": " (!)", "poor": " **(!!)**"}


def to_markdown(blocks: Sequence[Block], title: str, folder: str | os.PathLike[str]) -> str:
    """Return the text of the Markdown file that will stand in a folder; links to pictures are relative to it."""
    return "\n\n".join([f"# {title}", *(_block(block, Path(folder)) for block in blocks)]) + "\n"


def _block(block: Block, folder: Path) -> str:
    if isinstance(block, Heading):
        return f"{'#' * block.level} {block.text}"
    if isinstance(block, Paragraph):
        return _lead(block.lead) + block.text
    if isinstance(block, Bullets):
        return "\n".join(f"- {_lead(lead)}{text}" for lead, text in block.items)
    if isinstance(block, Command):
        return f"```\n{block.text}\n```"
    if isinstance(block, Table):
        return _table(block)
    place = Path(os.path.relpath(block.file, folder)).as_posix()
    return f"![{block.title}](<{place}>)\n\n{_lead(block.title)}{block.caption}".rstrip()


def _lead(lead: str) -> str:
    return f"**{lead}** " if lead else ""


def _table(table: Table) -> str:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

    numeric = [bool(table.rows) and all(row[k].number for row in table.rows) for k in range(len(table.header))]
    rule = line(["---:" if number else "---" for number in numeric])
    body = [line([cell.text + _MARKS[cell.level] for cell in row]) for row in table.rows]
    return "\n".join([line(table.header), rule, *body])
