"""Python files of the user's own classes, named on the command line; a case file alone never imports code."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from traceback import extract_tb

from tautflex.case.messages import one_line
from tautflex.errors import CaseError, TautflexError


def load_plugin(path: Path) -> None:
    """Import a Python file, which calls `tautflex.register` for its classes, as ``tautflex_plugin_`` and its name.

    Raises
    ------
    CaseError
        If the file is not there, or does not run to its end; one line with the reason and where it came from.
    """
    where = f"--plugin: {one_line(str(path))}"
    if not path.is_file():
        raise CaseError(f"{where}: no such file; name a Python file that calls tautflex.register")
    name = f"tautflex_plugin_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise CaseError(f"{where}: expected a Python file, got one that does not end in .py; rename it")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and type hints look their module up there
    try:
        spec.loader.exec_module(module)
    except TautflexError as error:
        raise CaseError(f"{where}: {error}") from None
    except Exception as error:  # whatever a stranger's file raises is one line about that file
        lines = [frame.lineno for frame in extract_tb(error.__traceback__) if frame.filename == str(path)]
        place = f" in line {lines[-1]}" if lines else ""
        raise CaseError(f"{where}: {type(error).__name__}{place}: {one_line(str(error))}; correct the file") from None
