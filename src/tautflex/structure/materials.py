"""Isotropic materials and the cross-sections made of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import ClassVar, cast

from tautflex import checks
from tautflex.errors import InputError

STRAINS = ("von-karman", "green-lagrange")
LAW_NAMES = {"membrane": ["elastic", "tension-field"], "cable": ["elastic", "slack"]}
"""Names of laws that a kind of section may have; `tautflex.elements.laws` holds the laws, registering one adds here."""


@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic material.

    Parameters
    ----------
    youngs_modulus
        Young's modulus [Pa], > 0.
    density
        Mass density [kg/m^3], > 0.
    poisson_ratio
        Poisson ratio [-], inside (-1, 0.5).

    Raises
    ------
    InputError
        If a value is out of range.
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float = 0.0

    def __post_init__(self) -> None:
        checks.positive("youngs_modulus", self.youngs_modulus)
        checks.positive("density", self.density)
        checks.poisson_ratio("poisson_ratio", self.poisson_ratio)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))


@dataclass(frozen=True)
class MembraneSection:
    """Film of constant thickness.

    Parameters
    ----------
    material
        Material of the film.
    thickness
        Thickness [m], > 0.
    strain
        ``"von-karman"`` (the paper's) or ``"green-lagrange"`` (objective under any rigid motion).
    law
        ``"elastic"``, which carries compression, ``"tension-field"``, which wrinkles instead, or a
        `tautflex.elements.laws.Law`.
    nonstructural_mass
        Mass per area of what has no stiffness, such as coatings and cells [kg/m^2].
    """

    material: Material
    thickness: float
    strain: str = "von-karman"
    law: object = "elastic"
    nonstructural_mass: float = 0.0
    kind: ClassVar[str] = "membrane"
    rotational: ClassVar[bool] = False

    def __post_init__(self) -> None:
        _check(self, "thickness")

    @property
    def mass_per_measure(self) -> float:
        """Mass per area [kg/m^2]."""
        return self.material.density * self.thickness + self.nonstructural_mass


@dataclass(frozen=True)
class CableSection:
    """Cable or string that carries axial force only.

    Parameters
    ----------
    material
        Material of the cable.
    area
        Cross-sectional area [m^2], > 0.
    strain
        ``"von-karman"`` or ``"green-lagrange"``.
    slack
        Whether the cable goes slack instead of carrying compression; short for ``law="slack"``.
    law
        ``"elastic"``, ``"slack"`` or a `tautflex.elements.laws.Law`.
    nonstructural_mass
        Mass per length of what has no stiffness, such as sheaths [kg/m].
    """

    material: Material
    area: float
    strain: str = "von-karman"
    slack: bool = False
    law: object = "elastic"
    nonstructural_mass: float = 0.0
    kind: ClassVar[str] = "cable"
    rotational: ClassVar[bool] = False

    def __post_init__(self) -> None:
        _check(self, "area")
        checks.flag("slack", self.slack)
        if self.slack and self.law not in ("elastic", "slack"):
            raise InputError(f"slack: expected False with a law of its own, got True and law = {self.law!r}")

    @property
    def mass_per_measure(self) -> float:
        """Mass per length [kg/m]."""
        return self.material.density * self.area + self.nonstructural_mass


@dataclass(frozen=True)
class BeamSection:
    """Euler-Bernoulli beam with its principal axes along local y and z.

    Parameters
    ----------
    material
        Material of the beam.
    area
        Cross-sectional area [m^2], > 0.
    inertia_y, inertia_z
        Second moments of area about local y and z [m^4], > 0; ``inertia_z`` resists deflection along local y.
    torsion_constant
        Saint-Venant torsion constant [m^4], > 0.
    strain
        ``"von-karman"`` (the paper's) or ``"green-lagrange"`` (invariant to second order in rotations, which
        a prestressed free-flying frame needs; see :mod:`tautflex.elements.beam`).
    nonstructural_mass
        Mass per length of what has no stiffness, such as harness [kg/m]; it lies on the axis.
    """

    material: Material
    area: float
    inertia_y: float
    inertia_z: float
    torsion_constant: float
    strain: str = "von-karman"
    nonstructural_mass: float = 0.0
    kind: ClassVar[str] = "beam"
    rotational: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _check(self, "area", "inertia_y", "inertia_z", "torsion_constant")

    @property
    def mass_per_measure(self) -> float:
        """Mass per length [kg/m]."""
        return self.material.density * self.area + self.nonstructural_mass


Section = MembraneSection | CableSection | BeamSection


def _check(section: Section, *sizes: str) -> None:
    checks.instance("material", section.material, Material, "a Material", remedy="write Material(3.5e9, 1530.0, 0.34)")
    for name in sizes:
        checks.positive(name, getattr(section, name))
    checks.non_negative("nonstructural_mass", section.nonstructural_mass)
    checks.one_of("strain", section.strain, STRAINS)
    if not isinstance(section, BeamSection) and isinstance(section.law, str):
        checks.one_of("law", section.law, LAW_NAMES[section.kind])


def section_runs(
    name: str, given: object, kind: type[Section], elements: str, first: int, count: int
) -> Iterator[tuple[Section, slice]]:
    """Sections of ``count`` elements from number ``first``, and where each holds: elements in a row that have the same.

    Parameters
    ----------
    name
        Of the argument, for messages.
    given
        One section for all elements, or a sequence with one for each.
    kind
        Class of the sections.
    elements
        What needs the section, for messages.
    first, count
        Which of the elements are asked for.

    Raises
    ------
    InputError
        If there is none, one of another kind, or not one for each element.
    """
    if isinstance(given, Sequence) and not isinstance(given, str):
        each = list(given[first : first + count])
        if len(each) < count:
            raise InputError(f"{name}: expected one section, or one for each element, got {len(given)}; give one each")
    else:
        each = [given] * count
    start = 0
    for section, members in groupby(each):
        end = start + len(list(members))
        found = checks.instance(elements, section, kind, f"a {kind.__name__}", remedy="elements need a section")
        yield cast(Section, found), slice(start, end)
        start = end
