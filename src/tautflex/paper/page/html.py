"""The page as one HTML file: made from its Markdown, style and pictures inside, nothing fetched from anywhere."""

from __future__ import annotations

import base64
import os
import re
import struct
from html import escape
from pathlib import Path
from urllib.parse import unquote

from markdown_it import MarkdownIt
from markdown_it.token import Token

_SCREEN = 0.68  # CSS pixels per pixel of a figure drawn at 200 dpi: its 9-point text reads as 17 pixels

# Marks and pictures bring their style with them: a cell with a mark is coloured, a paragraph with a picture is a card.
_STYLE = """
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#57606a;--page:#fff;--card:#f6f8fa;--line:#d5dbe1;--link:#0a58a8;
--fair:#fdeec4;--poor:#fbd9cf}
@media (prefers-color-scheme:dark){:root{--ink:#e6e8eb;--soft:#a3abb4;--page:#14171a;--card:#1e2327;--line:#39414a;
--link:#7cb7f2;--fair:#54430f;--poor:#662c1c}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
main{max-width:76rem;margin:0 auto;padding:1.5rem 1rem 4rem}
h1{font-size:1.9rem;line-height:1.2;margin:.2em 0 .6em}
h2{margin:2.6rem 0 .6rem;padding-bottom:.25rem;border-bottom:1px solid var(--line);font-size:1.4rem}
h3{margin:1.8rem 0 .4rem;font-size:1.1rem}
p,ul{max-width:46rem}li{margin:.35rem 0}a{color:var(--link)}
nav{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:.6rem 1rem;margin:1rem 0}
nav summary{cursor:pointer;font-weight:600}nav ul{margin:.4rem 0 .2rem;padding-left:1.2rem;columns:18rem;max-width:none}
nav li{margin:.1rem 0}nav li.deep{margin-left:1rem;font-size:.93em}
pre{background:var(--card);border:1px solid var(--line);border-radius:6px;padding:.6rem .8rem;overflow-x:auto}
table{display:block;overflow-x:auto;width:max-content;max-width:100%;margin:.8rem 0;
border-collapse:collapse;font-size:.92rem;font-variant-numeric:tabular-nums}
th,td{padding:.28rem .65rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{border-bottom:2px solid var(--line);vertical-align:bottom}
th[style]{min-width:4rem}td[style],td:first-child{white-space:nowrap}
td:nth-child(2):not([style]),td:last-child:not([style]){min-width:14rem}
td:has(em){background:var(--fair)}td:has(strong){background:var(--poor)}
p:has(img){display:inline-block;width:min-content;margin:.3rem .6rem .3rem 0;padding:.6rem;vertical-align:top;
background:var(--card);border:1px solid var(--line);border-radius:8px;font-size:.9rem;color:var(--soft);max-width:none}
img{display:block;max-width:calc(100vw - 5rem);height:auto;margin-bottom:-1rem;background:#fff;border-radius:4px}
p:has(img) strong{color:var(--ink)}
@media (max-width:45rem){th,td{padding:.25rem .4rem}td:first-child{white-space:normal;min-width:6.5rem}
td:nth-child(2):not([style]){min-width:7.5rem}td:last-child:not([style]){min-width:11rem}}
@media print{nav{display:none}p:has(img){break-inside:avoid}}
"""


def to_html(text: str, folder: Path) -> str:
    """Return the HTML file of a Markdown text; pictures, linked from a folder, are read and embedded.

    A table of contents stands before the first heading of level 2.

    Raises
    ------
    OSError
        If a picture cannot be read.
    """
    parser = MarkdownIt("commonmark", {"html": False, "xhtmlOut": False}).enable("table")
    tokens = parser.parse(text)
    headings = []
    for place, token in enumerate(tokens):
        if token.type == "heading_open":
            title = tokens[place + 1].content
            anchor = re.sub(r"\W+", "-", title.lower()).strip("-")
            token.attrSet("id", anchor)
            headings.append((token.tag, anchor, escape(title)))
        for part in token.children or ():
            if part.type == "image":
                _embed(part, folder)
    first = next((place for place, token in enumerate(tokens) if token.tag == "h2"), len(tokens))
    before, after = (parser.renderer.render(some, parser.options, {}) for some in (tokens[:first], tokens[first:]))
    items = "".join(
        f'<li{" class=deep" * (tag > "h2")}><a href="#{anchor}">{title}</a></li>'
        for tag, anchor, title in headings
        if tag > "h1"
    )
    contents = f"<nav><details open><summary>Contents</summary><ul>{items}</ul></details></nav>\n"
    title = headings[0][2] if headings else ""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"{before}{contents}{after}</main>\n</body>\n</html>\n"
    )


def _embed(image: Token, folder: Path) -> None:
    path = os.path.normpath(folder / unquote(str(image.attrs["src"])))  # folder itself need not be there yet
    data = Path(path).read_bytes()
    width, height = struct.unpack(">II", data[16:24])  # a PNG begins with its signature and its size
    image.attrs["src"] = "data:image/png;base64," + base64.b64encode(data).decode("ascii")
    image.attrs |= {"width": round(_SCREEN * width), "height": round(_SCREEN * height)}
