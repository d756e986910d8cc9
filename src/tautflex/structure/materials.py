"""Materials and the cross-sections made of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import ClassVar, cast

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array

STRAINS = ("von-karman", "green-lagrange")
BEAM_STRAINS = (*STRAINS, "corotational")
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

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Material(youngs_modulus=3.5e9, density=1530.0, poisson_ratio=0.34).poisson_ratio
    0.34
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

    @property
    def isotropic(self) -> bool:
        """Whether it is alike in all directions."""
        return True

    @property
    def plane_stress(self) -> Array:
        """Elastic matrix of a film [Pa], for (e11, e22, g12), shape (3, 3) [paper (30)]."""
        nu = self.poisson_ratio
        factor = self.youngs_modulus / (1.0 - nu**2)
        return factor * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])


@dataclass(frozen=True)
class OrthotropicMaterial(Material):
    """Linear elastic material of a film with two principal directions: a fabric, a ply, a stretched foil.

    Parameters
    ----------
    youngs_modulus
        Young's modulus along direction 1 [Pa], > 0.
    density
        Mass density [kg/m^3], > 0.
    poisson_ratio
        Contraction along 2 under tension along 1, nu_12 [-]; ``nu_12^2 < E_1 / E_2``.
    youngs_modulus_2
        Young's modulus along direction 2 [Pa], > 0.
    shear_modulus_12
        Shear modulus [Pa], > 0.
    angle
        From the film's local x axis to direction 1, about its normal [rad].

    Raises
    ------
    InputError
        If a value is out of range.
    """

    youngs_modulus_2: float = field(kw_only=True)
    shear_modulus_12: float = field(kw_only=True)
    angle: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        for name in ("youngs_modulus", "youngs_modulus_2", "shear_modulus_12", "density"):
            checks.positive(name, getattr(self, name))
        checks.finite("angle", self.angle)
        limit = float(np.sqrt(self.youngs_modulus / self.youngs_modulus_2))
        if not abs(checks.finite("poisson_ratio", self.poisson_ratio)) < limit:
            raise InputError(
                f"poisson_ratio: expected nu_12 between -{limit:.4g} and {limit:.4g}, the square root of E_1 / E_2, "
                f"got {self.poisson_ratio:g}; no stable material has more"
            )

    @property
    def isotropic(self) -> bool:
        """Whether it is alike in all directions."""
        return False

    @property
    def plane_stress(self) -> Array:
        """Elastic matrix of a film [Pa], for (e11, e22, g12) in its local axes, shape (3, 3) [Jones 1999, 2.6]."""
        e1, e2, nu = self.youngs_modulus, self.youngs_modulus_2, self.poisson_ratio
        own = np.linalg.inv([[1 / e1, -nu / e1, 0.0], [-nu / e1, 1 / e2, 0.0], [0.0, 0.0, 1 / self.shear_modulus_12]])
        c, s = np.cos(self.angle), np.sin(self.angle)
        # Strains along 1 and 2 from those along the film's axes.
        turned = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
        return np.asarray(turned.T @ own @ turned)


@dataclass(frozen=True)
class _Smeared(Material):
    """Layers as one material: their stiffness per thickness; made by `laminate`."""

    stiffness: tuple[tuple[float, ...], ...] = field(kw_only=True)

    def __post_init__(self) -> None:
        checks.positive("density", self.density)

    @property
    def isotropic(self) -> bool:
        return False

    @property
    def plane_stress(self) -> Array:
        return np.array(self.stiffness)


def laminate(*layers: MembraneSection) -> MembraneSection:
    """Film of several layers that strain together: a coated foil, a fabric between foils, crossed plies.

    Its membrane stiffness and mass are the layers' sums; a stress of it is the resultant over the whole thickness.
    Films have no bending stiffness, so that the order of the layers does not matter.

    Parameters
    ----------
    layers
        One section for each; all with one strain measure and one law.

    Returns
    -------
    MembraneSection

    Raises
    ------
    InputError
        If there are none, they differ in strain measure or law, or a law needs equal stiffness in all directions.

    Examples
    --------
    >>> import tautflex as tf
    >>> film = tf.MembraneSection(tf.Material(3e9, 1420.0, 0.34), 25e-6)
    >>> coating = tf.MembraneSection(tf.Material(70e9, 2700.0, 0.34), 1e-7)
    >>> tf.laminate(film, coating, coating).thickness
    2.52e-05
    """
    checks.several("layers", layers, MembraneSection, "MembraneSection(...)")
    if not layers:
        raise InputError("layers: expected one or more sections, got none; write laminate(film, coating)")
    first = layers[0]
    if len(layers) == 1:
        return first
    for layer in layers:
        if (layer.strain, layer.law) != (first.strain, first.law):
            raise InputError(
                f"layers: expected one strain measure and one law, got {first.strain!r} with {first.law!r} and "
                f"{layer.strain!r} with {layer.law!r}; make them alike"
            )
    thickness = sum(layer.thickness for layer in layers)
    parts = [layer.thickness / thickness * layer.material.plane_stress for layer in layers]
    stiffness = np.sum(parts, axis=0)
    density = sum(layer.mass_per_measure for layer in layers) / thickness
    compliance = np.linalg.inv(stiffness)
    young, nu = float(1.0 / compliance[0, 0]), float(-compliance[0, 1] / compliance[0, 0])
    alike = all(layer.material.isotropic for layer in layers)
    rows = tuple(tuple(map(float, row)) for row in stiffness)
    material = Material(young, density, nu) if alike else _Smeared(young, density, nu, stiffness=rows)
    return MembraneSection(material, thickness, first.strain, first.law)


@dataclass(frozen=True)
class MembraneSection:
    """Film of constant thickness.

    Parameters
    ----------
    material
        Material of the film: `Material`, or `OrthotropicMaterial` along its local axes; `laminate` makes sections of
        several layers.
    thickness
        Thickness [m], > 0.
    strain
        ``"von-karman"`` (the paper's) or ``"green-lagrange"`` (objective under any rigid motion).
    law
        ``"elastic"``, which carries compression, ``"tension-field"``, which wrinkles instead, or a
        `tautflex.elements.laws.Law`.
    nonstructural_mass
        Mass per area of what has no stiffness, such as coatings and cells [kg/m^2].

    Examples
    --------
    >>> import tautflex as tf
    >>> kapton = tf.Material(youngs_modulus=3e9, density=1420.0, poisson_ratio=0.34)
    >>> tf.MembraneSection(kapton, 25e-6, law="tension-field").thickness
    2.5e-05
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
        if not self.material.isotropic and not (isinstance(self.law, str) and self.law == "elastic"):
            raise InputError(
                f"law: expected 'elastic' of a film that is not alike in all directions, got {self.law!r}; the "
                "criterion of wrinkling films is that of isotropic ones"
            )

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

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.CableSection(tf.Material(65e9, 1440.0), area=1e-6, slack=True).area
    1e-06
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
        ``"von-karman"`` (the paper's), ``"green-lagrange"`` (invariant to second order in rotations, which a
        prestressed free-flying frame needs; see :mod:`tautflex.elements.beam`), or ``"corotational"`` (invariant under
        rotations of any size, for booms that bend, buckle and turn; see :mod:`tautflex.elements.local_frame`).
    rotary_inertia
        Whether sections resist turning about their own axes when the beam bends; "corotational" beams always do.
    nonstructural_mass
        Mass per length of what has no stiffness, such as harness [kg/m]; it lies on the axis.

    Examples
    --------
    >>> import tautflex as tf
    >>> tube = tf.BeamSection(tf.Material(70e9, 1600.0, 0.3), 1.854e-4, 8.07e-8, 8.07e-8, 1.614e-7)
    >>> tube.inertia_y == tube.inertia_z
    True
    """

    material: Material
    area: float
    inertia_y: float
    inertia_z: float
    torsion_constant: float
    strain: str = "von-karman"
    rotary_inertia: bool = False
    nonstructural_mass: float = 0.0
    kind: ClassVar[str] = "beam"
    rotational: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _check(self, "area", "inertia_y", "inertia_z", "torsion_constant")
        checks.flag("rotary_inertia", self.rotary_inertia)

    @property
    def mass_per_measure(self) -> float:
        """Mass per length [kg/m]."""
        return self.material.density * self.area + self.nonstructural_mass


Section = MembraneSection | CableSection | BeamSection


def _check(section: Section, *sizes: str) -> None:
    checks.instance("material", section.material, Material, "a Material", remedy="write Material(3.5e9, 1530.0, 0.34)")
    if section.kind != "membrane" and not section.material.isotropic:
        raise InputError(f"material: expected an isotropic Material of a {section.kind}, got {section.material!r}")
    for name in sizes:
        checks.positive(name, getattr(section, name))
    checks.non_negative("nonstructural_mass", section.nonstructural_mass)
    checks.one_of("strain", section.strain, BEAM_STRAINS if isinstance(section, BeamSection) else STRAINS)
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
