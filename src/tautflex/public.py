"""Public names of a package: listed in its stub, loaded when used."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lazy_loader import attach_stub  # type: ignore[import-untyped]


def public_names(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a package from the stub beside its file.

    A name that is none asks for the nearest one: Python does so in its own tracebacks only, notebooks do not.
    """
    load, names, everything = attach_stub(package, file)

    def found(name: str) -> Any:
        if name in everything or name.startswith("_"):
            return load(name)
        try:
            return load(name)
        except AttributeError:
            from difflib import get_close_matches  # only here, the import of the package is to cost nothing

            near = get_close_matches(name, everything, n=1, cutoff=0.7)
            asked = f"; did you mean {near[0]!r}?" if near else ""
            # Without an object, so that Python does not ask again.
            text = f"module {package!r} has no attribute {name!r}{asked}"
            raise AttributeError(text, name=name, obj=None) from None

    return found, names, everything
