"""What all commands share: options, and how they give their answer."""

from __future__ import annotations

import inspect
import json
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, get_type_hints

from cyclopts import Parameter

from tautflex.cli.late import import_late
from tautflex.errors import CaseError, InputError
from tautflex.files.transaction import result_file

if TYPE_CHECKING:
    from tautflex.case import Case

CaseFile = Annotated[Path, Parameter(help="Case file (TOML).")]
Overrides = Annotated[
    list[str] | None,
    Parameter(name="--set", help="Change one key, section.key=value, or take it out, section.key=; may be repeated."),
]
ResultFolder = Annotated[
    Path | None,
    Parameter(name=["-o", "--output"], help="Directory for results; default: named like the case, here."),
]
Force = Annotated[bool, Parameter(name="--force", help="Replace what is there.")]
_SHARED: dict[str, tuple[Any, Any]] = {
    "plugin": (
        Annotated[
            list[Path] | None,
            Parameter(name="--plugin", help="Python file that registers classes of yours; may be repeated."),
        ],
        None,
    ),
    "as_json": (Annotated[bool, Parameter(name="--json", help="Print one JSON object and nothing else.")], False),
}


class Answer(NamedTuple):
    """What a command found out: numbers for --json, how a person sees them, exit code, and what stopped it."""

    values: Mapping[str, Any]
    show: Callable[[], object]
    code: int = 0
    error: InputError | None = None


def command(function: Callable[..., Answer | int]) -> Callable[..., int]:
    """Give a command the options that all have, and print its answer; with --json nothing else goes to stdout."""
    own = inspect.signature(function)

    def run(*arguments: Any, plugin: Sequence[Path] | None = None, as_json: bool = False, **options: Any) -> int:
        with redirect_stdout(sys.stderr if as_json else sys.stdout):  # plugins may print
            for file in plugin or ():
                from tautflex.case.plugins import load_plugin

                load_plugin(file)
            answer = function(*arguments, **options)
        if isinstance(answer, int):
            return answer
        if as_json:
            # Not written to sys.stdout, which is None where a caller closed it.
            print(json.dumps(jsonable(answer.values), allow_nan=False), flush=True)  # noqa: T201
        if answer.error is not None:
            raise answer.error
        if not as_json:
            answer.show()
        return answer.code

    shared = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=value) for name, (_, value) in _SHARED.items()
    ]
    hints = get_type_hints(function, include_extras=True) | {name: hint for name, (hint, _) in _SHARED.items()}
    run.__name__, run.__doc__, run.__annotations__ = function.__name__, flowing(function.__doc__ or ""), hints
    run.__signature__ = own.replace(parameters=[*own.parameters.values(), *shared])  # type: ignore[attr-defined]
    return run


def flowing(text: str) -> str:
    """A docstring with one line for every paragraph, which help wraps at the width of the terminal."""
    paragraphs = inspect.cleandoc(text).split("\n\n")
    return "\n\n".join(each if each.startswith("Example") else " ".join(each.split("\n")) for each in paragraphs)


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


def load(case: Path, override: Sequence[str] | None) -> Case:
    """Read the case of a command."""
    for name in ("numpy.f2py", "numpy.ma", "numpy.testing"):  # scipy asks for all that numpy has
        import_late(name)
    from tautflex.case import load_case

    return load_case(case, override or ())


@contextmanager
def about(case: Path) -> Iterator[None]:
    """Put the name of the case in front of what the numerics, which know no files, say about it."""
    try:
        yield
    except InputError as error:
        raise error.behind(f"{case}: ") from None


def stored_run(path: Path) -> Path:
    """File of results that a path means, that of a run or its folder.

    Raises
    ------
    CaseError
        If there is none.
    """
    found = path / "run.nc" if path.is_dir() else path
    if not found.is_file():
        text = f"{path}: expected the folder of a run or its run.nc, got {found}, which does not exist"
        raise CaseError(f"{text}; `tautflex run` writes one")
    return found


@contextmanager
def new_file(path: Path, *, force: bool) -> Iterator[None]:
    """Keep a file to this command, as long as it takes to make it; CaseError if it may not be written."""
    require_new_file(path, force=force)
    with result_file(path):
        require_new_file(path, force=force)  # by another command that ended just now
        yield


def require_new_file(path: Path, *, force: bool) -> None:
    """Raise CaseError unless a file can be written at ``path``; nothing is created."""
    if path.is_dir():
        raise CaseError(f"{path}: expected a file to write, got a directory; name a file in it")
    if path.exists() and not force:
        raise CaseError(f"{path}: expected a new file, got one that exists; choose another name or add --force")
    if path.is_symlink() and not path.exists():
        raise CaseError(f"{path}: expected a file to write, got a link to nothing; choose another name")
    if not path.parent.is_dir():
        raise CaseError(f"{path}: expected an existing directory, got {path.parent}; create it first")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise CaseError(f"{path}: cannot write there (permission denied); choose another place")


def require_output_directory(path: Path) -> None:
    """Raise CaseError unless results can be written into ``path``; nothing is created."""
    nearest = path
    while not nearest.exists() and nearest != nearest.parent:
        if nearest.is_symlink():
            raise CaseError(f"{path}: {nearest} is a link to nothing; choose another directory with -o")
        nearest = nearest.parent
    if not nearest.is_dir():
        raise CaseError(f"{path}: expected an output directory, got the file {nearest}; choose another with -o")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise CaseError(f"{path}: cannot write there (permission denied); choose another directory with -o")
