"""Geometry is stated once: by the keys of a case, or by the mesh file it names."""

from __future__ import annotations

from collections.abc import Mapping

from tautflex.case.messages import meaning, show
from tautflex.case.section import Section

# Keys of the built-in antenna: needed without a mesh file, refused beside one ...
_NEEDED = {
    "membrane": ("length", "width"),
    "cables": ("per_long_edge", "per_short_edge"),
    "frame": ("length", "width"),
}
# ... and those that have a default, which says nothing beside a mesh file.
_OPTIONAL = {"cables": ("distribution",), "frame": ("support",)}


def require_one_geometry(sections: Mapping[str, Section | None], file: str | None) -> None:
    """Raise ValueError if the geometry is stated twice or not at all.

    Parameters
    ----------
    sections
        The sections ``membrane``, ``cables`` and ``frame`` of a case, None where there is none.
    file
        Mesh file, if the case names one.
    """
    for name, section in sections.items():
        if section is None:
            continue
        fields = type(section).model_fields
        for key in _NEEDED[name]:
            value = getattr(section, key)
            if file is None and value is None:
                raise ValueError(f"{name}.{key}: missing, expected the {meaning(key, fields[key])}; add it")
            if file is not None and value is not None:
                raise ValueError(_stated_twice(f"{name}.{key}", value, file))
        for key in _OPTIONAL.get(name, ()) if file is not None else ():
            value = getattr(section, key)
            if value != fields[key].default:
                raise ValueError(_stated_twice(f"{name}.{key}", value, file))


def _stated_twice(key: str, value: object, file: str | None) -> str:
    return f"{key}: expected no value beside mesh.file = {show(file)}, got {show(value)}; remove one of the two"
