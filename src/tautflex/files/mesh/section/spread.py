"""What a file spreads over its elements: sections, masses without stiffness, initial stresses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import KINDS, RawMesh, shorten
from tautflex.files.mesh.section.section_data import MeshSection
from tautflex.numeric import Array, Indices
from tautflex.structure.shapes import LINE2, QUAD4, TRIANGLE3, TRIANGLE6

Roles = Mapping[str, NDArray[np.str_]]
"""Role of each element by kind."""


def section_numbers(raw: RawMesh, role: Roles) -> dict[str, Indices]:
    """Number of the group that states the section of each element, -1 for none; MeshError if two do."""
    number = {kind: np.full(len(raw.elements[kind]), -1, dtype=np.int64) for kind in KINDS}
    for place, group in enumerate(raw.groups):
        for section in group.sections:
            for kind in KINDS:
                rows = group.of(kind)
                rows = rows[role[kind][rows] == section.kind]
                if (number[kind][rows] >= 0).any():
                    other = raw.groups[int(number[kind][rows].max())].name
                    raise MeshError(
                        f"{section.where}: expected one section of every element, got a second one of some in "
                        f"{shorten(group.name)}, after {shorten(other)}; remove one"
                    )
                number[kind][rows] = place
    return number


def sections(
    raw: RawMesh, role: Roles, unit_length: float, unit_mass: float | None
) -> Iterator[tuple[str, MeshSection]]:
    """Sections of the elements that are there, by the name of their group."""
    for group in raw.groups:
        for section in group.sections:
            if any((role[kind][group.of(kind)] == section.kind).any() for kind in KINDS):
                yield group.name, section.in_units(unit_length, unit_mass)


def initial_stress(raw: RawMesh, kind: str, rows: Indices, unit_length: float, unit_mass: float | None) -> Array | None:
    """Initial stress of elements of a kind [Pa], shape (row, 3), along lines (row, 1); None where there is none."""
    found = raw.stress.get(kind, np.zeros((0, 3)))
    if not found.size or not found[rows].any():
        return None
    factor = in_kilograms("initial stress", unit_length, unit_mass) / unit_length
    return np.asarray(factor * found[rows][:, : 1 if kind == "lines" else 3])


def nonstructural(
    raw: RawMesh,
    role: Roles,
    section: Mapping[str, Indices],
    unit_length: float,
    unit_mass: float | None,
) -> dict[str, Array]:
    """Mass without stiffness that each element has beside that of its section [kg/m^2, kg/m]."""
    extra = {kind: np.zeros(len(raw.elements[kind])) for kind in KINDS}
    for group in raw.groups:
        for one in group.nonstructural:
            rows = {kind: own[role[kind][own] != "ignore"] for kind in KINDS if len(own := group.of(kind))}
            mass = one.value * in_kilograms(one.where, unit_length, unit_mass)
            if one.per in ("total", "shared"):
                if (
                    one.per == "total"
                    and len({int(number) for kind, own in rows.items() for number in section[kind][own]}) > 1
                ):
                    raise MeshError(
                        f"{one.where}: expected elements of one section to share a total mass, got several; state "
                        "it per area or length"
                    )
                size = sum(float(_measures(raw, kind, own).sum()) for kind, own in rows.items()) * unit_length ** (
                    1 if "lines" in rows else 2
                )
                density = mass / size if size > 0.0 else 0.0
            else:
                wrong = "lines" in rows if one.per == "membrane" else len(rows.keys() - {"lines"}) > 0
                if wrong:
                    raise MeshError(
                        f"{one.where}: expected mass per area of films, per length of lines; correct its units"
                    )
                density = mass / unit_length ** (2 if one.per == "membrane" else 1)
            if not 0.0 <= density < np.inf:
                raise MeshError(f"{one.where}: expected a mass >= 0, got {one.value:g}; correct it")
            for kind, own in rows.items():
                extra[kind][own] += density
    return extra


def _measures(raw: RawMesh, kind: str, rows: Indices) -> Array:
    """Areas or lengths of elements in the file's units, shape (row,)."""
    connectivity = raw.elements[kind][rows]
    shape = {2: LINE2, 3: TRIANGLE3, 4: QUAD4, 6: TRIANGLE6}[connectivity.shape[1]]
    return np.asarray(shape.measure(raw.nodes[connectivity]))


def in_kilograms(where: str, unit_length: float, unit_mass: float | None) -> float:
    """Kilograms of the file's unit of mass; MeshError if it is needed and not stated."""
    if unit_length != 1.0 and unit_mass is None:
        raise MeshError(
            f"{where}: expected unit_mass beside unit_length = {unit_length:g}, got none; state the file's unit of "
            "mass in kg (1000 for t, mm, s)"
        )
    return unit_mass or 1.0
