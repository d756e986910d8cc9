"""Packages that most commands name and few use."""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any


def import_late(name: str) -> None:
    """Let a package be imported when something of it is used for the first time, by this process.

    `importlib.util.LazyLoader` imports it as soon as anybody looks through the modules for their names. The package
    that holds it is imported at once.
    """
    spec = None if name in sys.modules else find_spec(name)
    if spec is None:
        return
    place = ModuleType(name)
    place.__spec__, place.__file__ = spec, spec.origin

    def first_use(attribute: str) -> Any:
        if sys.modules.get(name) is place:
            del sys.modules[name]
        package = import_module(name)
        place.__dict__.update(package.__dict__)
        return getattr(package, attribute)

    place.__dict__["__getattr__"] = first_use
    sys.modules[name] = place
    holder, _, inner = name.rpartition(".")
    if holder:
        setattr(sys.modules[holder], inner, place)
