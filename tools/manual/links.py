"""Looks at every link of the finished pages: a place in the manual that is not there is a warning, thus an error."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from sphinx.util.logging import getLogger


class _Page(HTMLParser):
    """Names that a page has, and places that it leads to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.links: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        told = dict(attrs)
        self.names |= {told[key] or "" for key in ("id", "name") if key in told}
        self.links |= {told[key] or "" for key in ("href", "src") if key in told}


def dead_links(folder: Path) -> list[str]:
    """Links within a folder of pages that lead nowhere, as ``page: link``."""
    pages = {path: _Page(path.read_text("utf-8")) for path in folder.rglob("*.html") if "_static" not in path.parts}
    dead = []
    for path, page in pages.items():
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            goal = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            named = not parts.fragment or goal not in pages or unquote(parts.fragment) in pages[goal].names
            if not goal.exists() or not named:
                dead.append(f"{path.relative_to(folder)}: {link}")
    return dead


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""

    def look(app: Any, error: Exception | None) -> None:
        if error is None and app.builder.format == "html":
            for line in dead_links(Path(app.outdir)):
                getLogger(__name__).warning("dead link: %s", line)

    app.connect("build-finished", look)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
