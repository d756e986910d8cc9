"""Page of all commands, from what `--help` of each says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from manual.pages import write
from tautflex.cli import app as commands

INTRODUCTION = """# Commands

What `tautflex COMMAND --help` says, on one page. Exit codes: 0 done, 1 not converged or
failures in a study, 2 bad input, 130 interrupted.
"""


def text() -> str:
    """The page; the title, the summary and the library's own table of contents give way to ours."""
    whole = commands.generate_docs(output_format="markdown")
    start = whole.index("## tautflex ")
    return INTRODUCTION + "\n" + re.sub(r"^Example: (.*)$", r"Example: `\1`", whole[start:], flags=re.M) + "\n"


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "generated" / "commands.md", text()))
    return {"parallel_read_safe": True}
