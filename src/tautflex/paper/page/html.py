"""The page as one HTML file: style and pictures inside, nothing fetched from anywhere."""

from __future__ import annotations

import base64
import struct
from collections.abc import Sequence
from html import escape
from pathlib import Path

from tautflex.paper.page.blocks import Block, Bullets, Command, Heading, Paragraph, Picture, Table

_SCREEN = 0.68  # CSS pixels per pixel of a figure drawn at 200 dpi: its 9-point text reads as 17 pixels

_STYLE = """
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#57606a;--page:#fff;--card:#f6f8fa;--line:#d5dbe1;--link:#0a58a8;
--good:#d7f0e2;--fair:#fdeec4;--poor:#fbd9cf}
@media (prefers-color-scheme:dark){:root{--ink:#e6e8eb;--soft:#a3abb4;--page:#14171a;--card:#1e2327;--line:#39414a;
--link:#7cb7f2;--good:#16462f;--fair:#54430f;--poor:#662c1c}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
font:16px/1.55 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
main{max-width:76rem;margin:0 auto;padding:1.5rem 1rem 4rem}
h1{font-size:1.9rem;line-height:1.2;margin:.2em 0 .6em}
h2{margin:2.6rem 0 .6rem;padding-bottom:.25rem;border-bottom:1px solid var(--line);font-size:1.4rem}
h3{margin:1.8rem 0 .4rem;font-size:1.1rem}
p,ul{max-width:46rem}li{margin:.35rem 0}a{color:var(--link)}
nav{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:.6rem 1rem;margin:1rem 0}
nav summary{cursor:pointer;font-weight:600}nav ul{margin:.4rem 0 .2rem;padding-left:1.2rem;columns:18rem}
nav li{margin:.1rem 0}nav li.deep{margin-left:1rem;font-size:.93em}
pre{background:var(--card);border:1px solid var(--line);border-radius:6px;padding:.6rem .8rem;overflow-x:auto}
.wide{overflow-x:auto;margin:.8rem 0}
table{border-collapse:collapse;font-size:.92rem;font-variant-numeric:tabular-nums}
th,td{padding:.28rem .65rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{border-bottom:2px solid var(--line);vertical-align:bottom}
td.number,th.number{text-align:right}td.number{white-space:nowrap}
td:first-child{white-space:nowrap}td:nth-child(2):not(.number){min-width:14rem}
td:last-child:not(.number){min-width:14rem}
td.good{background:var(--good)}td.fair{background:var(--fair)}td.poor{background:var(--poor);font-weight:600}
.figures{display:flex;flex-wrap:wrap;gap:1rem}
figure{margin:0;max-width:100%;flex:0 1 auto;padding:.6rem;
background:var(--card);border:1px solid var(--line);border-radius:8px}
figure img{display:block;max-width:100%;height:auto;background:#fff;border-radius:4px}
figcaption{margin-top:.5rem;font-size:.9rem;color:var(--soft);width:0;min-width:100%}figcaption b{color:var(--ink)}
th.number{min-width:4rem}
@media (max-width:45rem){th,td{padding:.25rem .4rem}td:first-child{white-space:normal;min-width:6.5rem}
td:nth-child(2):not(.number){min-width:7.5rem}td:last-child:not(.number){min-width:11rem}}
@media print{nav{display:none}figure{break-inside:avoid}}
"""


def to_html(blocks: Sequence[Block], title: str) -> str:
    """Return the text of the HTML file; pictures are read and embedded.

    Raises
    ------
    OSError
        If a picture cannot be read.
    """
    contents, rest = _contents(blocks), list(blocks)
    first = next((k for k, block in enumerate(rest) if isinstance(block, Heading)), len(rest))
    parts = [_body(rest[:first]), contents, _body(rest[first:])]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"<h1>{escape(title)}</h1>\n" + "\n".join(parts) + "\n</main>\n</body>\n</html>\n"
    )


def _contents(blocks: Sequence[Block]) -> str:
    items = [
        f'<li{_class("deep" if block.level > 2 else "")}><a href="#{block.anchor}">{escape(block.text)}</a></li>'
        for block in blocks
        if isinstance(block, Heading)
    ]
    return f"<nav><details open><summary>Contents</summary><ul>{''.join(items)}</ul></details></nav>"


def _body(blocks: Sequence[Block]) -> str:
    """Blocks one after the other; pictures that follow each other share a row where there is room."""
    parts: list[str] = []
    row: list[str] = []
    for block in blocks:
        if isinstance(block, Picture):
            row.append(_picture(block))
            continue
        if row:
            parts.append(f'<div class="figures">{"".join(row)}</div>')
            row = []
        parts.append(_block(block))
    if row:
        parts.append(f'<div class="figures">{"".join(row)}</div>')
    return "\n".join(parts)


def _block(block: Heading | Paragraph | Bullets | Command | Table) -> str:
    if isinstance(block, Heading):
        return f'<h{block.level} id="{block.anchor}">{escape(block.text)}</h{block.level}>'
    if isinstance(block, Paragraph):
        return f"<p>{_bold(block.lead)}{escape(block.text)}</p>"
    if isinstance(block, Bullets):
        return "<ul>" + "".join(f"<li>{_bold(lead)}{escape(text)}</li>" for lead, text in block.items) + "</ul>"
    if isinstance(block, Command):
        return f"<pre><code>{escape(block.text)}</code></pre>"
    return _table(block)


def _bold(lead: str) -> str:
    return f"<b>{escape(lead)}</b> " if lead else ""


def _class(name: str) -> str:
    return f' class="{name}"' if name else ""


def _table(table: Table) -> str:
    numeric = [bool(table.rows) and all(row[k].number for row in table.rows) for k in range(len(table.header))]
    head = "".join(
        f'<th scope="col"{_class("number" if number else "")}>{escape(text)}</th>'
        for text, number in zip(table.header, numeric, strict=True)
    )
    lines = []
    for row in table.rows:
        cells = []
        for cell in row:
            kind = " ".join(word for word in ("number" if cell.number else "", cell.level) if word)
            cells.append(f"<td{_class(kind)}>{escape(cell.text)}</td>")
        lines.append(f"<tr>{''.join(cells)}</tr>")
    body = "\n".join(lines)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table></div>'


def _picture(picture: Picture) -> str:
    data = Path(picture.file).read_bytes()
    width, height = struct.unpack(">II", data[16:24])  # a PNG begins with its signature and its size
    text = base64.b64encode(data).decode("ascii")
    return (
        f'<figure><img alt="{escape(picture.title)}" width="{round(_SCREEN * width)}" '
        f'height="{round(_SCREEN * height)}" src="data:image/png;base64,{text}">'
        f"<figcaption><b>{escape(picture.title)}</b> {escape(picture.caption)}</figcaption></figure>"
    )
