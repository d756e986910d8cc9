"""One file from the sources of a page: style, scripts as modules, and data, with nothing to fetch."""

from __future__ import annotations

import base64
import html
import json
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from tautflex import checks
from tautflex.errors import InputError

_HERE = files("tautflex.pages")
# Name in import statements -> file.
_LIBRARIES = {"three": "vendor/three/three.module.min.js", "three/orbit": "vendor/three/OrbitControls.js"}


def assembled(page: str, title: str, data: Any) -> str:
    """Text of a page whose sources lie in a folder, and in ``common``: ``page.html``, styles, ``main.js``, modules.

    Modules import each other as ``page/name``; a map of names carries them inside the page.
    """
    sources = {item.name: item.read_text("utf-8") for part in ("common", page) for item in (_HERE / part).iterdir()}
    scripts = {name: text for name, text in sources.items() if name.endswith(".js")}
    modules = {name: _carried(_read(path)) for name, path in _LIBRARIES.items()}
    modules |= {f"page/{name.removesuffix('.js')}": _carried(text) for name, text in scripts.items()}
    parts = {
        "title": html.escape(title),
        "style": "".join(text for name, text in sources.items() if name.endswith(".css")),
        "modules": json.dumps({"imports": modules}),
        "data": json.dumps(data, allow_nan=False).replace("<", "\\u003c"),  # no text of a run ends the script
        "licence": html.escape(_read("vendor/three/LICENSE").replace("--", "- -")),
    }
    before, *rest = sources["page.html"].split("{{")
    found = [before]
    for part in rest:
        name, after = part.split("}}", 1)
        found += [parts[name.strip()], after]
    return "".join(found)


def page_file(path: Any, example: str) -> Path:
    """Where a page is to be written; InputError unless its name ends as that of a page."""
    target = checks.path("path", path)
    if target.suffix not in (".html", ".htm"):
        raise InputError(f"path: expected a name that ends with .html, got {str(target)!r}; write {example}")
    return target


@lru_cache(maxsize=16)
def _read(path: str) -> str:
    place = _HERE
    for part in path.split("/"):
        place = place / part
    return place.read_text("utf-8")


def _carried(text: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(text.encode("utf-8")).decode("ascii")
