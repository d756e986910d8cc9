"""Parameters that several commands share, and how they write their answer."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from tautflex.errors import CaseError, InputError

if TYPE_CHECKING:
    from tautflex.case import Case

CaseFile = Annotated[Path, Parameter(help="Case file (TOML).")]
Overrides = Annotated[
    list[str] | None,
    Parameter(name="--set", help="Change one key, section.key=value; may be repeated."),
]
AsJson = Annotated[bool, Parameter(name="--json", help="Print one JSON object and nothing else.")]
Plugins = Annotated[
    list[Path] | None,
    Parameter(name="--plugin", help="Python file that registers classes of yours; may be repeated."),
]
Force = Annotated[bool, Parameter(name="--force", help="Overwrite an existing file.")]


def print_json(values: Mapping[str, Any]) -> None:
    """Write one JSON object to stdout; numbers that are not finite become null."""
    sys.stdout.write(json.dumps(jsonable(values), allow_nan=False) + "\n")
    sys.stdout.flush()


def jsonable(value: Any) -> Any:
    """Copy nested mappings and sequences with numpy's numbers as Python's, paths as texts, NaN and infinity as None."""
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [jsonable(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return jsonable(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def use_plugins(files: Sequence[Path] | None) -> None:
    """Import the files that --plugin names; CaseError if one does not run."""
    for file in files or ():
        from tautflex.case.plugins import load_plugin

        load_plugin(file)


def load(case: Path, override: Sequence[str] | None, plugin: Sequence[Path] | None) -> Case:
    """Read the case of a command, which may name classes of plugins."""
    use_plugins(plugin)
    from tautflex.case import load_case

    return load_case(case, override or ())


@contextmanager
def about(case: Path) -> Iterator[None]:
    """Put the name of the case in front of what the numerics, which know no files, say about it."""
    try:
        yield
    except InputError as error:
        raise type(error)(f"{case}: {error}") from None


def require_new_file(path: Path, *, force: bool) -> None:
    """Raise CaseError unless a file can be written at ``path``; nothing is created."""
    if path.is_dir():
        raise CaseError(f"{path}: expected a file to write, got a directory; name a file in it")
    if path.exists() and not force:
        raise CaseError(f"{path}: expected a new file, got one that exists; choose another name or add --force")
    if not path.parent.is_dir():
        raise CaseError(f"{path}: expected an existing directory, got {path.parent}; create it first")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise CaseError(f"{path}: cannot write there (permission denied); choose another place")


def require_output_directory(path: Path) -> None:
    """Raise CaseError unless results can be written into ``path``; nothing is created."""
    nearest = path
    while not nearest.exists() and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        raise CaseError(f"{path}: expected an output directory, got the file {nearest}; choose another with -o")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise CaseError(f"{path}: cannot write there (permission denied); choose another directory with -o")
