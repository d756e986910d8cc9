"""Python files of the user's own classes, named on the command line; a case file alone never imports code."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from pathlib import Path
from traceback import extract_tb

from tautflex.case.messages import one_line
from tautflex.errors import CaseError, TautflexError

# Files that were loaded, by their whole path, as they were named.
LOADED: dict[str, Path] = {}


def load_plugin(path: Path) -> None:
    """Import a Python file, which calls `tautflex.register` for its classes.

    Raises
    ------
    CaseError
        If the file is not there, or does not run to its end; one line with the reason and where it came from.
    """
    where = f"--plugin: {one_line(str(path))}"
    if not path.is_file():
        raise CaseError(f"{where}: no such file; name a Python file that calls tautflex.register")
    own, name = path.resolve(), f"tautflex_plugin_{path.stem}"
    known = sys.modules.get(name)
    if known is not None and known.__file__ != str(own):
        # A file of the same name in another folder is another module.
        name += f"_{hashlib.sha256(str(own).encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, own)
    if spec is None or spec.loader is None:
        raise CaseError(f"{where}: expected a Python file, got one that does not end in .py; rename it")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and type hints look their module up there
    LOADED[str(own)] = path
    try:
        spec.loader.exec_module(module)
    except KeyboardInterrupt:
        raise
    except TautflexError as error:
        del LOADED[str(own)]
        raise CaseError(f"{where}: {error}") from None
    except BaseException as error:  # whatever a stranger's file raises, an exit too, is one line about that file
        said = blame(error) or f"{where}: {type(error).__name__}: {one_line(str(error))}"
        del LOADED[str(own)]
        raise CaseError(said) from None


def blame(error: BaseException) -> str | None:
    """One line about the plugin that an exception came from, or may have; None where no plugin is loaded."""
    if not LOADED:
        return None
    said = f"{type(error).__name__}: {one_line(str(error))}"
    for frame in reversed(extract_tb(error.__traceback__)):
        if frame.filename in LOADED:
            return f"--plugin: {LOADED[frame.filename]}: {said} in line {frame.lineno}; correct the file"
    names = ", ".join(str(path) for path in LOADED.values())
    return f"--plugin: {said}, from what a class of {names} gave back; compare it with its base class"
