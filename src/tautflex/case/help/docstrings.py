"""What a class says about its fields: its NumPy docstring is the help of the case file."""

from __future__ import annotations

import re
from functools import cache

from docstring_parser import parse

# "[rad/s]" is a unit; "[paper sec. 3]", "[theory.md 4]" and "[Kane, Ryan & Banerjee 1987]" are sources.
_UNIT = re.compile(r"(?<!\[)\[((?!paper|theory)[^\[\]\d][^\]]{0,15}|1/[^\]]{1,9})\](?!\()")
_SENTENCE_END = re.compile(r"[.;:](?=\s|$)")


@cache
def field_texts(cls: type) -> dict[str, str]:
    """Description of every parameter in the docstrings of a class and its bases, in plain words on one line."""
    texts: dict[str, str] = {}
    for one in reversed(cls.__mro__):
        for entry in parse(one.__doc__ or "").params:
            for name in entry.arg_name.split(","):
                texts[name.strip()] = plain(entry.description or "")
    return texts


def summary(cls: type) -> str:
    """First sentence of a class's docstring; the one that dataclasses write by themselves says nothing."""
    text = cls.__doc__ or ""
    return "" if text.startswith(f"{cls.__name__}(") else plain(parse(text).short_description or "").rstrip(".")


def plain(text: str) -> str:
    """Words of a docstring without its marks, on one line."""
    return " ".join(text.replace("``", "").replace("`", "").split())


def short(text: str) -> str:
    """First clause of a description, as part of a sentence: small first letter, no full stop."""
    first = re.sub(r"^(?:An?|The) ", "", _SENTENCE_END.split(text, maxsplit=1)[0])
    if not first or first.startswith('"'):
        return ""
    return first[0].lower() + first[1:] if first[1:2].islower() else first


def unit(text: str) -> str:
    """Unit in the first brackets of a description that hold one; empty for a pure number."""
    found = _UNIT.search(text)
    return found.group(1) if found else ""
