"""The keys of a case file, listed from the sections and classes themselves."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from types import UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from tautflex import checks
from tautflex.case.help import docstrings
from tautflex.case.messages import SIGNS, choices, show
from tautflex.case.options import Chosen
from tautflex.case.schema import Case
from tautflex.case.section import Section, Words, section_of_field
from tautflex.case.sections.maneuver import Step
from tautflex.case.sections.structural import GroupSection
from tautflex.case.tables import TimeTableKeys
from tautflex.errors import CaseError

_RANGE = re.compile(r"(?<=, )[<>]=? ?\d+(?:[./]\d+)?|in [\[(][^\])]*[\])]")
_TITLES = {name: f"[{name}.NAME]" for name in ("inputs", "actuators", "sensors")} | {
    name: f"[[{name}]]" for name in ("masses", "links", "springs", "dampers")
}
_NAMES = {float: "number", int: "integer", bool: "true or false", str: "text", type(None): ""}


class KeyEntry(NamedTuple):
    """One key: where it may be left out, its default is empty, where it must not, ``"needed"``."""

    name: str
    type: str
    unit: str
    range: str
    default: str
    meaning: str


class SectionEntry(NamedTuple):
    """Keys of a section, or of one kind that it may be of: ``[maneuver] kind = "stop"``."""

    title: str
    about: str
    keys: tuple[KeyEntry, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain tables and lists."""
        return {"title": self.title, "about": self.about, "keys": [key._asdict() for key in self.keys]}


def reference(name: str | None = None) -> list[SectionEntry]:
    """List the keys of one section of a case file or of all, classes registered by the user included.

    Raises
    ------
    CaseError
        If there is no such section.
    """
    sections = {one: list(_entries(one, field)) for one, field in Case.model_fields.items() if section_of_field(field)}
    found = {**sections, "maneuver.steps": [_steps()], "mesh.sections": [_groups()]}
    if name is not None and name not in found:
        raise CaseError(f"keys: expected one of {choices(list(found))}, got {show(name)}; {checks.pick(name, found)}")
    return [entry for one in sections for entry in sections[one]] if name is None else found[name]


def _entries(name: str, field: FieldInfo) -> Iterator[SectionEntry]:
    section, title = section_of_field(field), _TITLES.get(name, f"[{name}]")
    assert section is not None
    if not issubclass(section, Chosen):
        yield SectionEntry(title, _about(section), _keys(section))
        if name == "mesh":
            yield _groups()
        return
    shared = _keys(section)
    if shared:
        yield SectionEntry(title, f"{_about(section)} Keys beside those of the {section.naming_key}:", shared)
    for kind, cls in section.registry.items():
        about = docstrings.summary(cls) or _about(section).rstrip(".")
        keys = tuple(key for key in _keys(section.of_kind(kind)) if key.name not in section.model_fields)
        yield SectionEntry(f'{title} {section.naming_key} = "{kind}"', f"{about}.", keys)
    if name == "maneuver":
        yield _steps()
    if name == "inputs":
        yield SectionEntry("{ times, values } or { file }", _about(TimeTableKeys), _keys(TimeTableKeys))


def entry_of(title: str, section: type[Section]) -> SectionEntry:
    """Keys of a section that is no choice among classes, under a title."""
    keys = tuple(key._replace(name=section.model_fields[key.name].alias or key.name) for key in _keys(section))
    return SectionEntry(title, _about(section), keys)


def _steps() -> SectionEntry:
    return SectionEntry("[[maneuver.steps]]", f"{_about(Step)} Its kind and keys are those of [maneuver].", _keys(Step))


def _groups() -> SectionEntry:
    return SectionEntry("[mesh.sections.NAME]", _about(GroupSection), _keys(GroupSection))


def _about(section: type[Section]) -> str:
    return docstrings.plain((section.__doc__ or "").split("\n\n")[0])


def _keys(section: type[Section]) -> tuple[KeyEntry, ...]:
    chosen = section if issubclass(section, Chosen) else None
    texts = docstrings.field_texts(chosen.made_from) if chosen and chosen.made_from else {}
    named = chosen.naming_key if chosen else None
    fields = {name: field for name, field in section.model_fields.items() if name != named}
    return tuple(_key(name, field, texts.get(name) or _sentence(field)) for name, field in fields.items())


def _sentence(field: FieldInfo) -> str:
    text = (field.description or "").removeprefix("choice true or false: ")
    return f"{text[:1].upper()}{text[1:]}."


def _key(name: str, field: FieldInfo, text: str) -> KeyEntry:
    limits = _limits(field.metadata) or [part for hint in get_args(field.annotation) for part in _limits_of(hint)]
    found = _RANGE.search(text)
    return KeyEntry(
        name=name,
        type=" | ".join(f'"{word}"' for word in _words(field)) or _type(field.annotation),
        unit=docstrings.unit(text),
        range=", ".join(limits) or (found[0] if found else ""),
        default="needed" if field.is_required() else _needed(field) or _default(field),
        meaning=text,
    )


def _needed(field: FieldInfo) -> str:
    """When a key is needed that another one may replace."""
    extra = field.json_schema_extra
    return str(extra.get("needed", "")) if isinstance(extra, dict) else ""


def _words(field: FieldInfo) -> list[str]:
    """Allowed words, where a list of them may still grow."""
    return [
        word for one in field.metadata if isinstance(getattr(one, "func", None), Words) for word in one.func.words()
    ]


def _limits_of(hint: Any) -> list[str]:
    """Limits of an annotated number, whose annotations may be nested fields of pydantic."""
    parts = getattr(hint, "__metadata__", ())
    return _limits([one for part in parts for one in getattr(part, "metadata", (part,))])


def _limits(metadata: Sequence[Any]) -> list[str]:
    found: dict[str, float] = {}  # of two limits on one side the narrower one
    for one in metadata:
        for key, sign in SIGNS.items():
            if hasattr(one, key):
                narrower = max if ">" in sign else min
                found[sign] = narrower(found.get(sign, getattr(one, key)), getattr(one, key))
    return [f"{sign} {value:g}" for sign, value in found.items()]


def _default(field: FieldInfo) -> str:
    value = field.get_default(call_default_factory=True)
    return "" if value is None else show(value).replace("'", '"')


def _type(hint: Any) -> str:
    origin, parts = get_origin(hint), get_args(hint)
    if hasattr(hint, "__metadata__"):
        return _type(parts[0])
    if origin is Literal:
        return " | ".join(f'"{part}"' for part in parts)
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(filter(None, map(_type, parts))))
    if origin is tuple:
        inner = [_type(part) for part in parts if part is not Ellipsis]
        if Ellipsis not in parts:
            return f"[{', '.join(inner)}]"
        return f"list of {inner[0]}s" if inner[0].isalpha() else "list of lists"
    if origin is dict:
        return "table"
    if isinstance(hint, type) and issubclass(hint, TimeTableKeys):
        return "{ times, values } or { file }"
    if isinstance(hint, type) and issubclass(hint, Section):
        return "table"
    return _NAMES.get(hint, "")


def markdown(entries: list[SectionEntry], *, whole: bool = True) -> str:
    """The reference as a page of the documentation, or a part of it without the head."""
    head = [
        "# The case file",
        "",
        "TOML, SI units, `schema = 1` at the top. A key without default may be left out, which the texts call None.",
        "Every key in rad, rad/s or rad/s^2 can be given in degrees: `angle_deg = 30` for `angle`.",
        "",
        "This page is what `tautflex keys --markdown` prints (`make reference` writes it): the classes themselves say",
        "what stands here. `tautflex keys SECTION` shows one section, with `--plugin FILE.py` also classes of yours.",
        "",
    ]
    lines = head if whole else []
    for entry in entries:
        lines += [f"## {entry.title}", "", entry.about, ""]
        if entry.keys:
            lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
        for key in entry.keys:
            value = f"{key.type} [{key.unit}]" if key.unit else key.type
            cells = (f"`{key.name}`", ", ".join(filter(None, (value, key.range))), key.default, key.meaning)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines += [""] if entry.keys else []
    return "\n".join(lines).rstrip() + "\n"
