"""One line per problem: the key, what was expected, what came, and what to try.

Own, because pydantic's messages take several lines each, name Python's types and never say what to try.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from pydantic import BaseModel, ValidationError

from tautflex import checks
from tautflex.errors import CaseError

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo
    from pydantic_core import ErrorDetails

_LONGEST_VALUE = 60


_KINDS = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "an integer",
    "int_from_float": "an integer",
    "bool_type": "true or false",
    "string_type": "a text in quotes",
    "finite_number": "a finite number",
    "tuple_type": "a list",
    "dict_type": "a table of names and values",
    "model_type": "a table of keys and values",
    "model_attributes_type": "a table of keys and values",
}

_UNKNOWN = "extra_forbidden"
_BRANCHES = ("float", "int", "str", "bool")

# Limits of numbers, as pydantic and the annotations of fields call them.
SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


def problem(expected: str, got: object, remedy: str) -> ValueError:
    """Make the error a validator raises: ``expected ..., got ...; remedy``."""
    return ValueError(f"expected {expected}, got {show(got)}; {remedy}")


def require_names(names: Iterable[str], what: str, example: str) -> None:
    """Raise ValueError unless names can be shown."""
    for name in names:
        if not name.strip() or not name.isprintable():
            raise problem(f"{what} of printable characters", name, f"name it for example {example}")


def show(value: object) -> str:
    """Write a value the way a case file would, on one line and not too long."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, tuple):
        text = repr(list(value))
    elif isinstance(value, BaseModel):
        text = f"a {type(value).__name__}"
    else:
        try:
            text = repr(value)
        except ValueError:  # integers beyond Python's limit of digits
            text = "an integer of thousands of digits"
    text = one_line(text)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "..."


def one_line(text: str) -> str:
    """Escape whatever would break a message into lines or garble a terminal."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "replace").decode() for c in text)


def case_error(error: ValidationError, model: type[BaseModel]) -> CaseError:
    """Turn what pydantic found in ``model`` into one line for every wrong key.

    A section reports relative to itself; the case that holds it puts the section's name in front.
    """
    found: dict[str, ErrorDetails] = {}
    details = error.errors(include_url=False)
    for item in sorted(details, key=lambda item: item["type"] != _UNKNOWN):
        place, inner = _place(item), _cause(item)
        key = ".".join(str(part) for part in place if isinstance(inner, CaseError) or isinstance(part, str))
        if len(place) > len(_place(found.setdefault(key, item))):
            found[key] = item  # of several readings of a value the furthest one counts
    explained = _explained([str(item["loc"][0]) for item in details if item["type"] == _UNKNOWN], model)
    told = [
        item
        for key, item in found.items()
        if not any(other.startswith(f"{key}.") for other in found)
        and not (item["type"] == "missing" and explained(str(item["loc"][0])))
    ]
    return CaseError(*(one_line(line) for item in told for line in _lines(item, model)))


def _explained(unknown: Sequence[str], model: type[BaseModel]) -> Callable[[str], bool]:
    """Whether a key is missing only because one is misspelt, or because its section names the wrong class."""
    own, others = _known(model)
    if any(name in others for name in unknown):
        return lambda name: True
    remedies = {checks.meant(name, own) for name in unknown}
    return lambda name: any(repr(name) in remedy for remedy in remedies)


def _lines(item: ErrorDetails, model: type[BaseModel]) -> list[str]:
    place, index, inner = _place(item), "", _cause(item)
    if isinstance(inner, CaseError):
        return [".".join([*map(str, place), problem]) for problem in inner.problems]
    while place and isinstance(place[-1], int):
        index = f" at index {place.pop()}"
    text = str(inner) if inner is not None else _sentence(item, model, index)
    return [": ".join(filter(None, [".".join(map(str, place)), text]))]


def _cause(detail: ErrorDetails) -> object:
    return detail.get("ctx", {}).get("error")


def _place(detail: ErrorDetails) -> list[int | str]:
    """Key, and index in a list; pydantic also lists which branch of "A or B" it tried, as "float" or "tuple[...]"."""
    return [part for part in detail["loc"] if "[" not in str(part) and part not in _BRANCHES]


def of_mesh_file(problem: str) -> str:
    """What is wrong with a mesh file, with remedies that are keys of a case file instead of arguments in Python."""
    problem = re.sub(r"(?<![\w.])names ?= ?\{(.*?)\}", lambda found: f"mesh.names = {{ {_roles(found[1])} }}", problem)
    problem = re.sub(r"(?<![\w.'])(unit_mass|unit_length|step(?= =))", r"mesh.\1", problem)
    problem = re.sub(r"(?<![^ ])(names|sections)(?=[.:])", r"mesh.\1", problem, count=1)
    sections = {"cable": "cables", "beam": "frame"}
    return re.sub(r"(?<![^ ])(cable|beam)(?=\.\w+: )", lambda found: sections[found[1]], problem, count=1)


def _roles(text: str) -> str:
    """Roles by group as a table of a case file; names that are no bare keys stand in quotes."""
    pairs = re.findall(r"'?([^',={}]+?)'?(?: =|:) ('\w+')", text)
    keys = [name.strip() if re.fullmatch(r"[\w-]+", name.strip()) else repr(name.strip()) for name, _ in pairs]
    return ", ".join(f"{name} = {role}" for name, (_, role) in zip(keys, pairs, strict=True))


def choices(names: Sequence[str]) -> str:
    """Names in quotes, as the end of "expected one of"."""
    *others, last = [repr(name) for name in names]
    return f"{', '.join(others)} or {last}" if others else last


def unknown_key(name: str, value: object, known: Collection[str], meant: Collection[str] = ()) -> str:
    """Sentence for a key that does not exist, with the nearest one that does, here or elsewhere."""
    return f"unknown key with value {show(value)}, expected one of {', '.join(known)}; {_remedy(name, known, meant)}"


def _remedy(name: str, known: Collection[str], meant: Collection[str] = ()) -> str:
    return checks.meant(name, known) or checks.meant(name, meant) or "remove it"


def _known(model: type[BaseModel]) -> tuple[Collection[str], Mapping[str, str]]:
    """Keys of a section, and those of the others of its choice with the class that has each."""
    own = _fields(model)
    others = model.homes() if hasattr(model, "homes") else {}
    return own, {name: kind for name, kind in others.items() if name not in own}


def _sentence(detail: ErrorDetails, model: type[BaseModel], index: str) -> str:
    kind, context, value = detail["type"], detail.get("ctx", {}), detail["input"]
    name = str(detail["loc"][0]) if detail["loc"] else ""
    field = _fields(model).get(name)
    if kind == _UNKNOWN:
        own, others = _known(model)
        if name in others:
            remedy = f"remove it or set {getattr(model, 'naming_key', 'kind')} = {others[name]!r}"
            return f"expected no value with {model.choice()}, got {show(value)}; {remedy}"  # type: ignore[attr-defined]
        return unknown_key(name, value, own, others)
    if kind == "missing" and len(detail["loc"]) == 1:
        wanted = f"{model.choice()} expects" if hasattr(model, "choice") else "expected"
        return f"missing, {wanted} the {meaning(name, field)}; add it"
    limit = next((name for name in SIGNS if name in context), None)
    if limit is not None:
        expected = f"a number {SIGNS[limit]} {context[limit]:g}"
    elif kind == "literal_error":
        offered = re.findall(r"'([^']*)'", context["expected"])
        return f"expected one of {context['expected']}, got {show(value)}{index}; {checks.pick(value, offered)}"
    elif kind in ("too_long", "too_short", "missing"):
        expected, index = "a list of the right length", ""
    else:
        expected = _KINDS.get(kind, detail["msg"].removeprefix("Input should be "))
    return f"expected {expected}, got {show(value)}{index}; write the {meaning(name, field)}"


def _fields(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Keys of a section, the one that names a class first."""
    named = getattr(model, "naming_key", None)
    fields = sorted(model.model_fields.items(), key=lambda item: item[0] != named)
    return {field.alias or name: field for name, field in fields}


def meaning(name: str, field: FieldInfo | None) -> str:
    """Describe a field with an example, as the remedy of every message about it."""
    if field is None or field.description is None:
        return "value the documentation of case files states"
    if not field.examples:
        return field.description
    return f"{field.description}, for example {name} = {_toml(field.examples[0])}"


def _toml(example: object) -> str:
    if isinstance(example, dict):
        return "{ " + ", ".join(f"{key} = {show(value)}" for key, value in example.items()) + " }"
    return show(example)
