"""What mesh files and their users state about sections, key by key, and the sections made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.structure.materials import BeamSection, CableSection, Material, MembraneSection, Section

_MATERIAL = ("youngs_modulus", "density", "poisson_ratio")
_SIZES = {
    "membrane": ("thickness",),
    "cable": ("area",),
    "beam": ("area", "inertia_y", "inertia_z", "torsion_constant"),
}
_OPTIONS = {"membrane": ("law",), "cable": ("law", "slack"), "beam": ("rotary_inertia",)}
_CLASSES: Mapping[str, Any] = {"membrane": MembraneSection, "cable": CableSection, "beam": BeamSection}
PRESTRESS = {"membrane": ("stress_x", "stress_y"), "cable": ("tension",), "beam": ("axial_force",)}
"""Keys of a section that state prestress, by kind of element."""
# Powers of the unit of length and of mass, time in seconds; nonstructural mass is per area of film, length of lines.
_UNITS = {
    "youngs_modulus": (-1, 1),
    "density": (-3, 1),
    "thickness": (1, 0),
    "area": (2, 0),
    "inertia_y": (4, 0),
    "inertia_z": (4, 0),
    "torsion_constant": (4, 0),
}


def keys(kind: str) -> tuple[str, ...]:
    """Keys that a section of a kind of element may have."""
    return (*_MATERIAL, *_SIZES[kind], "nonstructural_mass", "strain", *_OPTIONS[kind], *PRESTRESS[kind])


@dataclass(frozen=True)
class MeshSection:
    """What a mesh file states about the section of a group of elements.

    Parameters
    ----------
    kind
        Kind of the elements, ``"membrane"``, ``"cable"`` or ``"beam"``.
    values
        What is stated, by the keys of sections of cases, in SI units: ``youngs_modulus``, ``poisson_ratio``,
        ``density``, ``thickness``, ``area``, ``inertia_y``, ``inertia_z``, ``torsion_constant``,
        ``nonstructural_mass``.
    doubt
        What else the file says of the section and tautflex cannot express; it must then be stated whole.
    """

    kind: str
    values: Mapping[str, float]
    doubt: str = ""


@dataclass(frozen=True)
class RawSection:
    """The same in the units of the file; ``where`` is its place for messages."""

    where: str
    kind: str
    values: Mapping[str, float] = field(default_factory=dict)
    doubt: str = ""

    def in_units(self, length: float, mass: float | None) -> MeshSection:
        """Section in SI units; without a unit of mass only what needs none."""
        found = {}
        for name, value in self.values.items():
            nonstructural = (-2 if self.kind == "membrane" else -1, 1)
            along, heavy = nonstructural if name == "nonstructural_mass" else _UNITS.get(name, (0, 0))
            known = not heavy or mass is not None or length == 1.0
            found[name] = value * length**along * (mass or 1.0) ** heavy if known else np.nan
        return MeshSection(self.kind, found, f"{self.where}: {self.doubt}" if self.doubt else "")


def made(name: str, kind: str, found: MeshSection | None, stated: Mapping[str, Any]) -> Section:
    """Section of a kind of what a file has found and a user has stated, which comes first.

    Raises
    ------
    InputError
        If a value is missing or unusable, or a stated key is none of the kind.
    """
    for key in stated:
        if key not in keys(kind):
            raise InputError(f"{name}.{key}: expected keys out of {', '.join(keys(kind))} of a {kind}; remove it")
    needed = [*(key for key in _MATERIAL if key != "poisson_ratio" or kind != "cable"), *_SIZES[kind]]
    file = {} if found is None else found.values
    values = {**file, **stated}
    for key in (*needed, "nonstructural_mass"):
        if key not in stated and found is not None and found.doubt and key in needed:
            text = f"{name}.{key}: missing, and the file's cannot be taken: {found.doubt}; state it"
        elif values.get(key, 0.0) != values.get(key, 0.0):
            text = f"{name}.{key}: missing, that of the file is in units of mass that are not stated; give unit_mass"
        elif key in needed and key not in values:
            text = f"{name}.{key}: missing, neither the file nor you state it of its {kind}s; state it"
        else:
            continue
        raise InputError(text)
    try:
        material = Material(*(values[key] for key in _MATERIAL if key in values))
        extra = {key: values[key] for key in ("strain", "nonstructural_mass", *_OPTIONS[kind]) if key in values}
        section: Section = _CLASSES[kind](material, *(values[key] for key in _SIZES[kind]), **extra)
    except InputError as error:
        raise InputError(f"{name}.{error}") from None
    return section


def initial_forces(kind: str, sections: Sequence[Section], stress: Array, strain: Array) -> Array:
    """What `Model.from_mesh` takes as prestress of elements, of an initial stress and a free strain.

    Parameters
    ----------
    kind
        Kind of the elements.
    sections
        Their sections.
    stress
        Given stress [Pa]: (sx, sy, txy) of films, shape (element, 3), along lines, shape (element, 1).
    strain
        Strain that the elements would take if they were free [-], in all directions of films, shape (element,): held
        back it makes the stress ``-C (strain, strain, 0)`` of films, ``-E strain`` of lines.

    Returns
    -------
    numpy.ndarray
        Stresses of films [Pa], shape (element, 3), forces of lines [N], shape (element, 1).
    """
    if kind == "membrane":
        held = {section: -section.material.plane_stress[:, :2].sum(axis=1) for section in dict.fromkeys(sections)}
        return np.asarray(stress + np.array([held[section] for section in sections]) * strain[:, None])
    modulus = np.array([section.material.youngs_modulus for section in sections])
    area = np.array([getattr(section, "area", np.nan) for section in sections])
    return np.asarray(area[:, None] * (stress - (modulus * strain)[:, None]))
