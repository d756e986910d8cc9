"""Reading case files: TOML text, `--set` overrides, and everything that can be wrong before validation."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from shlex import quote
from typing import Any

from tautflex import checks
from tautflex.case.messages import choices, one_line, show, unknown_key
from tautflex.case.options import Chosen
from tautflex.case.schema import Case
from tautflex.case.section import DEGREES, section_of_field
from tautflex.errors import CaseError
from tautflex.files.content import read_text

_DATA = files("tautflex").joinpath("data")
_FILES = {
    start + file.name.removesuffix(".toml"): file
    for start, folder in (("", "templates"), ("task-", "tasks"))
    for file in _DATA.joinpath(folder).iterdir()
}
TEMPLATES = tuple(sorted(_FILES))
"""Names of the commented cases that `tautflex init` writes; each is a file."""
STUDY = "study"
"""Name of the commented study that it writes."""
_STUDY_CASE = "m2-reduced.toml"

_LARGEST_FILE = 10_000_000
_DEEPEST = 20


def template(name: str = "m2") -> str:
    """Text of a commented case.

    Parameters
    ----------
    name
        One of `TEMPLATES`, or `STUDY`.

    Raises
    ------
    CaseError
        If there is no such template.
    """
    if name == STUDY:
        return _DATA.joinpath("studies", "study.toml").read_text(encoding="utf-8")
    if name not in TEMPLATES:
        known = choices((*TEMPLATES, STUDY))
        raise CaseError(
            f"template: expected one of {known}, got {show(name)}; {checks.pick(name, (*TEMPLATES, STUDY))}"
        )
    return _FILES[name].read_text(encoding="utf-8")


def template_files(name: str) -> dict[str, str]:
    """Texts of the files that a commented case or study names, by the names it has for them: its mesh, its case."""
    if name == STUDY:
        return {_STUDY_CASE: reduced_template("m2")}
    mesh = tomllib.loads(template(name)).get("mesh", {}).get("file")
    return {} if mesh is None else {mesh: _DATA.joinpath("meshes", mesh).read_text(encoding="utf-8")}


def reduced_template(name: str) -> str:
    """Text of a commented case with the section [reduction] that it shows put in force."""
    text = template(name)
    for line in ("[reduction]", 'directions = ["rx"]'):
        text = text.replace(f"# {line}", line)
    return text


def load_case(path: str | os.PathLike[str], overrides: Sequence[str] = ()) -> Case:
    """Read and validate a case file.

    Parameters
    ----------
    path
        TOML file, UTF-8.
    overrides
        Changes of single keys, ``"section.key=value"``, the value written as in TOML (bare words are texts). Nothing
        behind the equals sign takes the key or section out. Another kind takes out the keys that it does not have.

    Returns
    -------
    Case
        Frozen, validated.

    Raises
    ------
    CaseError
        One line with file, key, value, expectation and remedy.

    Examples
    --------
    >>> import tautflex as tf
    >>> case = tf.load_case("m2.toml", ["maneuver.duration=0.5"])
    >>> case.maneuver.duration
    0.5
    """
    source = checks.path("path", path)
    checks.several("overrides", overrides, str, "'damping.alpha=0.01'")
    return _validated(case_values(source), overrides, one_line(str(path)))


def case_values(path: Path) -> dict[str, Any]:
    """Tables of a case file as they stand there, but for names of files, which are relative to where the program runs.

    Raises
    ------
    CaseError
        If the file cannot be read as TOML.
    """
    name = one_line(str(path))
    missing = f"write one with `tautflex init {quote(name)}`"
    text = read_text(path, name, "case file", _LARGEST_FILE, missing, CaseError)
    return _placed(_parsed(text, name, "tautflex init"), path.parent)


def changed_text(path: Path, overrides: Sequence[str], changes: Mapping[str, Mapping[str, Any]], home: Path) -> str:
    """Text of a case file with keys changed and everything else as it stands there, comments too.

    Parameters
    ----------
    path
        The case file.
    overrides
        Changes of single keys as in `load_case`; they come first.
    changes
        Section -> key -> value.
    home
        Folder the text will be in: names of files in it are made relative to that.
    """
    import tomlkit

    document: Any = tomlkit.parse(read_text(path, one_line(str(path)), "case file", _LARGEST_FILE, "", CaseError))
    _placed(document, path.parent)
    for override in sorted(overrides, key=_is_no_choice):
        _apply(document, override)
    for section, keys in changes.items():
        for name, value in keys.items():
            change_key(document[section], name, value)
    _each_file(document, lambda file: os.path.relpath(file, home))
    return tomlkit.dumps(document)


def study_values(path: Path) -> dict[str, Any]:
    """Tables of a study file as they stand there; CaseError if the file cannot be read as TOML."""
    name = one_line(str(path))
    missing = f"write one with `tautflex init {quote(name)} --template study`"
    text = read_text(path, name, "study file", _LARGEST_FILE, missing, CaseError)
    values = _parsed(text, name, "tautflex init --template study")
    if "maneuver" in values and "base" not in values:
        told = f"{name}: expected a study, got a case; write base = {show(name)} and [axes] in a file of its own"
        raise CaseError(f"{told}, `tautflex init study.toml --template study` shows how")
    return values


def parse_case(text: str, overrides: Sequence[str] = (), *, source: str = "case", directory: Path = Path()) -> Case:
    """Validate the text of a case file; ``source`` names it in messages. See `load_case`.

    File names in the case are relative to ``directory``, those in overrides to where the program runs.
    """
    source = one_line(source)
    return _validated(_placed(_parsed(text, source, "tautflex init"), directory), overrides, source)


def _validated(values: dict[str, Any], overrides: Sequence[str], source: str) -> Case:
    problems, failed = list[str](), set[str]()
    for override in sorted(overrides, key=_is_no_choice):
        try:
            _apply(values, override)
        except CaseError as error:
            problems += error.problems
            failed.add(re.split(r"\W", override.strip(), maxsplit=1)[0])
    _require_shallow(values, source)
    if "base" in values and "maneuver" not in values:
        told = f"{source}: expected a case, got a study of {show(values['base'])}"
        raise CaseError(f"{told}; `tautflex sweep` and `tautflex design` take it")
    if values.get("schema", 1) != 1 or isinstance(values.get("schema"), bool | float):
        text = f"{source}: schema: expected 1, the format this release reads, got {show(values['schema'])}"
        raise CaseError(f"{text}; write the case anew with `tautflex init`")
    try:
        case = Case(**values)
    except CaseError as error:
        # What a change that failed was meant to change may be wrong without it.
        sure = (told for told in error.problems if re.split(r"\W", told, maxsplit=1)[0] not in failed)
        problems += (f"{source}: {told}" for told in sure)
    if "schema" not in values and not any("did you mean 'schema'" in told for told in problems):
        problems.insert(0, f"{source}: schema: missing, expected 1; add the line `schema = 1` at the top")
    if problems:
        raise CaseError(*problems)
    return case


def _parsed(text: str, source: str, start: str) -> dict[str, Any]:
    """Tables of a TOML text; CaseError if it is none."""
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{source}: not valid TOML: {one_line(str(error))}; correct the syntax there") from None
    except (RecursionError, ValueError) as error:  # absurd nesting, numbers of thousands of digits
        reason = one_line(str(error))[:120]
        raise CaseError(f"{source}: not readable as TOML: {reason}; start from `{start}`") from None
    _require_shallow(values, source)
    return values


def _placed(values: dict[str, Any], directory: Path) -> dict[str, Any]:
    """Tables of a case with the files that they name relative to where the program runs."""
    _each_file(values, lambda file: str(directory / file))
    return values


def _each_file(values: dict[str, Any], place: Callable[[str], str]) -> None:
    """Name the files of a case anew."""
    for section in ("maneuver", "mesh", "inputs", "controller"):
        _place_files(values.get(section), place)


def _require_shallow(values: dict[str, Any], source: str) -> None:
    """Refuse tables and lists in each other, deep enough to exhaust the stack of whoever walks through them."""
    inside, depth = [values], 0
    while inside:
        inside = [part for one in inside for part in (one.values() if isinstance(one, dict) else one)]
        inside = [part for part in inside if isinstance(part, dict | list)]
        depth += 1
        if depth > _DEEPEST:
            text = f"{source}: expected tables and lists at most {_DEEPEST} deep in each other, got deeper ones"
            raise CaseError(f"{text}; write section.key = value")


def _place_files(values: Any, place: Callable[[str], str]) -> None:
    """Name tables and meshes anew; what is no text is left to validation."""
    if isinstance(values, list):
        for value in values:
            _place_files(value, place)
    elif isinstance(values, dict):
        for key, value in values.items():
            if key == "file" and isinstance(value, str):
                if place(value) != value:
                    values[key] = place(value)
            else:
                _place_files(value, place)


def _is_no_choice(override: str) -> bool:
    """Changes that choose a class come first: they take out what belongs to others, but no other change."""
    return override.partition("=")[0].strip().rpartition(".")[2] not in ("kind", "method")


def _apply(values: dict[str, Any], override: str) -> None:
    """Change one key of a parsed case in place; whether the key exists is left to validation."""
    path, sign, text = override.partition("=")
    keys = [part.strip() for part in path.split(".")]
    if not sign or not all(keys):
        wanted = "expected section.key=value, for example damping.alpha=0.01"
        raise CaseError(f"--set: {wanted}, got {show(override)}; write key, equals sign and value")
    table = values
    for key in keys[:-1]:
        table = table.setdefault(key, {})
        if not isinstance(table, dict):
            what, remedy = "a value, not a section", "use section.key=value"
            if isinstance(table, list):
                what, remedy = "a list of tables, not one section", "change the file, or leave one table there"
            raise CaseError(f"--set: {path.strip()}: {key!r} is {what}; {remedy}")
    name = keys[-1]
    if not text.strip():
        if name not in table:
            remedy = unknown_key(name, "", list(table)).rpartition("; ")[2]
            raise CaseError(f"--set: {path.strip()}: expected a key to take out, got none of that name; {remedy}")
        del table[name]
        return
    change_key(table, name, _value(text.strip()))
    section = section_of_field(Case.model_fields[keys[0]]) if keys[0] in Case.model_fields else None
    if section is not None and issubclass(section, Chosen) and name == section.naming_key:
        for other in section.foreign_keys(table):
            del table[other]


def change_key(table: Any, name: Any, value: Any) -> None:
    """Set a key of a table, which may stand there in the other unit of angles, or an entry of a list, in place."""
    if isinstance(table, dict):
        table.pop(name.removesuffix(DEGREES) if name.endswith(DEGREES) else name + DEGREES, None)
    table[name] = value


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return text
