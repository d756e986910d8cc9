"""Sections of a case file that describe the structure: membrane, cables, frame, mesh, prestress."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    Strict,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from tautflex.case.messages import problem, show
from tautflex.case.section import Count, Flag, NonNegative, Number, Positive, Section, Vector, Words, key
from tautflex.structure.materials import LAW_NAMES
from tautflex.structure.shapes import SHAPES

EdgeCount = Annotated[Count, Field(ge=2)]
MembraneLaw = Annotated[str, BeforeValidator(Words(lambda: LAW_NAMES["membrane"]))]
CableLaw = Annotated[str, BeforeValidator(Words(lambda: LAW_NAMES["cable"]))]
Surface = Annotated[str, BeforeValidator(Words(lambda: (n for n, shape in SHAPES.items() if shape.dimension == 2)))]


def without_file(meaning: str, example: Any) -> Any:
    """Key that is needed where no mesh file can state it."""
    return key(meaning, example, None, json_schema_extra={"needed": "needed without mesh.file"})


Strain = Literal["von-karman", "green-lagrange"]
BeamStrain = Literal["von-karman", "green-lagrange", "corotational"]


def _laws() -> Iterator[str]:
    return (name for names in LAW_NAMES.values() for name in names)


def _inside_elastic_range(value: float | None) -> float | None:
    if value is not None and not -1.0 < value < 0.5:
        raise problem("a number inside (-1, 0.5)", value, "give Poisson's ratio; films have 0.3 to 0.4")
    return value


class FilmLayer(Section):
    """Isotropic layer on the film that strains with it: a coating, a second foil."""

    thickness: Positive = key("thickness of the layer [m]", 1e-7)
    youngs_modulus: Positive = key("Young's modulus of the layer [Pa]", 70e9)
    poisson_ratio: Number = key("Poisson's ratio of the layer", 0.34)
    density: Positive = key("mass density of the layer [kg/m^3]", 2700.0)

    _poisson = field_validator("poisson_ratio")(_inside_elastic_range)


class Membrane(Section):
    """Rectangular film, centred at the origin, x along ``length``.

    With ``youngs_modulus_y`` and ``shear_modulus`` it is orthotropic, ``youngs_modulus`` that along x and
    ``poisson_ratio`` the contraction along y under tension along x. ``[[membrane.layers]]`` add coatings.

    ``law = "tension-field"`` lets the film wrinkle and go slack; ``"elastic"`` carries any compression.
    ``stress_x`` and ``stress_y`` [Pa] state a given uniform stress (``prestress.mode = "uniform"``, and scalloped
    edges, which are cut so that the whole film has it). Beside a mesh file, what its sections state may be left out.
    """

    length: Positive | None = without_file("side along x [m]", 2.0)
    width: Positive | None = without_file("side along y [m]", 1.0)
    thickness: Positive | None = without_file("film thickness [m]", 1e-4)
    youngs_modulus: Positive | None = without_file("Young's modulus of the film [Pa]", 3.5e9)
    youngs_modulus_y: Positive | None = key("that along y of an orthotropic film [Pa]", 3.0e9, None)
    shear_modulus: Positive | None = key("shear modulus of an orthotropic film [Pa]", 1.2e9, None)
    poisson_ratio: Number | None = without_file("Poisson's ratio of the film", 0.34)
    density: Positive | None = without_file("mass density of the film [kg/m^3]", 1530.0)
    layers: tuple[FilmLayer, ...] = key("layers on the film, [[membrane.layers]] sections", default=())
    strain: Strain = key("strain measure of film, cables and, unless it has its own, frame", default="von-karman")
    law: MembraneLaw = key("material law of the film", "tension-field", "elastic")
    edges: Literal["cables", "fixed", "scalloped"] = key(
        "what holds the edges of the film; 'scalloped': cords in edges cut along arcs, and cables between these",
        default="cables",
    )
    stress_x: Number | None = key("given stress along x [Pa]", 4170.0, None)
    stress_y: Number | None = key("given stress along y [Pa]", 5470.0, None)

    @field_validator("poisson_ratio")
    @classmethod
    def _poisson(cls, value: float | None, info: ValidationInfo) -> float | None:
        return value if info.data.get("youngs_modulus_y") else _inside_elastic_range(value)

    @model_validator(mode="after")
    def _both_moduli(self) -> Self:
        if (self.youngs_modulus_y is None) != (self.shear_modulus is None):
            lacking = "youngs_modulus_y" if self.youngs_modulus_y is None else "shear_modulus"
            raise ValueError(f"{lacking}: missing, expected both moduli of an orthotropic film [Pa] or none; add it")
        return self

    @model_validator(mode="after")
    def _both_stresses(self) -> Self:
        if (self.stress_x is None) != (self.stress_y is None):
            given, lacking = ("stress_x", "stress_y") if self.stress_y is None else ("stress_y", "stress_x")
            stated = f"{given} = {getattr(self, given):g}"
            raise ValueError(f"{lacking}: missing, expected a stress [Pa] beside {stated}; add it")
        return self


class Cables(Section):
    """Cables from the film's edges straight to the frame, evenly spaced, the outer ones at its corners.

    Between scalloped edges they stand where two arcs meet, and their tensions follow from the film's stress. Beside a
    mesh file, what its sections state may be left out.
    """

    per_long_edge: EdgeCount | None = without_file("number of cables on each edge along x, at least 2", 11)
    per_short_edge: EdgeCount | None = without_file("number of cables on each edge along y, at least 2", 6)
    youngs_modulus: Positive | None = without_file("Young's modulus of the cables [Pa]", 133e9)
    area: Positive | None = without_file("cross-sectional area of one cable [m^2]", 3.14e-6)
    density: Positive | None = without_file("mass density of the cables [kg/m^3]", 1440.0)
    segments: Count = key("elements of each cable; of several, it can swing by itself", default=1)
    pretension_x: Number | None = key("tension per cable pulling along x [N]", 0.59, None)
    pretension_y: Number | None = key("tension per cable pulling along y [N]", 1.0, None)
    distribution: Literal["equal", "tributary"] = key(
        "'equal' tensions, or 'tributary': corner cables carry half", default="equal"
    )
    slack: Flag = key("choice true or false: a cable goes slack instead of pushing", True, False)
    law: CableLaw = key("material law of the cables; 'slack' is slack = true", "slack", "elastic")

    @property
    def pretensions(self) -> tuple[float, float]:
        """Tensions per cable along x and y [N]; zeros beside scalloped edges, where they follow from other things."""
        return self.pretension_x or 0.0, self.pretension_y or 0.0

    @field_validator("pretension_x", "pretension_y")
    @classmethod
    def _taut(cls, value: float | None) -> float | None:
        if value == 0.0:
            remedy = "singular: a membrane without tension has no transverse stiffness, give a tension [N]"
            raise problem("a number > 0", value, remedy)
        if value is not None and value < 0.0:
            raise problem("a number > 0", value, "a cable cannot push, give its tension [N]")
        return value


class EdgeCords(Section):
    """Cords in scalloped edges (``membrane.edges = "scalloped"``).

    Their tensions follow from the film's stress and the cut. With ``corners = "diagonal"`` the short edges are cut so
    that the straps at the corners point to those of the frame.
    """

    sag: Positive = key("depth of an arc over its span", 0.1)
    corners: Literal["straight", "diagonal"] = key(
        "at each corner two cables along x and y, or one strap to the frame's corner", default="straight"
    )
    youngs_modulus: Positive = key("Young's modulus of the cords [Pa]", 133e9)
    area: Positive = key("cross-sectional area of a cord [m^2]", 7.85e-7)
    density: Positive = key("mass density of the cords [kg/m^3]", 1440.0)


class Frame(Section):
    """Rectangular frame of beams; ``inertia_z`` bends in the antenna's plane, ``inertia_y`` out of it.

    ``strain = "corotational"`` lets beams turn by any angle, buckle sideways and twist under their axial force. Beside
    a mesh file, what its sections state may be left out.
    """

    length: Positive | None = without_file("centre-line side along x [m]", 2.5)
    width: Positive | None = without_file("centre-line side along y [m]", 1.5)
    youngs_modulus: Positive | None = without_file("Young's modulus of the frame [Pa]", 3e9)
    poisson_ratio: Number | None = without_file("Poisson's ratio of the frame", 0.38)
    density: Positive | None = without_file("mass density of the frame [kg/m^3]", 1380.0)
    area: Positive | None = without_file("cross-sectional area [m^2]", 5.24e-4)
    inertia_y: Positive | None = without_file("second moment of area, bending out of plane [m^4]", 4.81e-7)
    inertia_z: Positive | None = without_file("second moment of area, bending in plane [m^4]", 2.69e-7)
    torsion_constant: Positive | None = without_file("torsion constant [m^4]", 7.5e-7)
    strain: BeamStrain | None = key("strain measure of the beams; default: the film's", "corotational", None)
    rotary_inertia: Flag = key(
        "choice true or false: bending turns sections that resist it; 'corotational' ones always do", True, False
    )
    support: Literal["corners", "all", "axis", "short-side", "free"] = key(
        "clamped part of the frame", default="corners"
    )

    _poisson = field_validator("poisson_ratio")(_inside_elastic_range)


class GroupSection(Section):
    """Section of a group of a mesh file; its keys replace what the file states, and complete it.

    ``nonstructural_mass`` is per area of film, per length of cables and beams.
    """

    youngs_modulus: Positive | None = key("Young's modulus [Pa]", 3.5e9, None)
    poisson_ratio: Number | None = key("Poisson's ratio", 0.34, None)
    density: Positive | None = key("mass density [kg/m^3]", 1530.0, None)
    thickness: Positive | None = key("thickness of film [m]", 25e-6, None)
    area: Positive | None = key("cross-sectional area of cables or beams [m^2]", 3.14e-6, None)
    inertia_y: Positive | None = key("second moment of area of beams about local y [m^4]", 4.81e-7, None)
    inertia_z: Positive | None = key("second moment of area of beams about local z [m^4]", 2.69e-7, None)
    torsion_constant: Positive | None = key("torsion constant of beams [m^4]", 7.5e-7, None)
    nonstructural_mass: NonNegative | None = key("mass without stiffness [kg/m^2, kg/m]", 0.05, None)
    strain: BeamStrain | None = key("strain measure, if another than the film's", "green-lagrange", None)
    rotary_inertia: Flag | None = key(
        "choice true or false: bending turns sections of beams that resist it", True, None
    )
    law: Annotated[str, BeforeValidator(Words(_laws))] | None = key("material law", "tension-field", None)
    slack: Flag | None = key("choice true or false: a cable goes slack instead of pushing", True, None)
    stress_x: Number | None = key("given stress of film along its local x [Pa]", 4170.0, None)
    stress_y: Number | None = key("given stress of film along its local y [Pa]", 5470.0, None)
    tension: Positive | None = key("tension of each cable [N]", 0.59, None)
    axial_force: Number | None = key("given axial force of beams, tension positive [N]", -2.0, None)

    _poisson = field_validator("poisson_ratio")(_inside_elastic_range)


class Mesh(Section):
    """Mesh: a grid of cells along x and y, each one quad or cut by a diagonal into two triangles, or a file.

    With ``file`` (Gmsh, Abaqus or Nastran) film, cables, frame and supports come from its groups. A key of a
    section is that of ``[mesh.sections.NAME]`` for its group; else that of [membrane], [cables] or [frame], unless
    sections of the file differ in it; else the file's. Tensions of cables go by their direction. ``names`` gives
    roles to groups whose names do not tell them. ``step`` is left out where the file has one step (Abaqus) or
    subcase (Nastran), or one that asks for frequencies, or all have the same supports.
    """

    divisions: tuple[Count, Count] = key("numbers of cells along x and y, integers >= 1", default=(20, 10))
    pattern: Literal["alternating", "regular"] = key(
        "directions of the diagonals; quads have none", default="alternating"
    )
    element: Surface = key("shape of the film's elements", "triangle6", "triangle3")
    file: str | None = key("mesh file (.msh, .inp, .bdf)", "antenna.msh", None, strict=True)
    unit_length: Positive | None = key("length of the file's unit [m]", 0.001, None)
    unit_mass: Positive | None = key("mass of the file's unit [kg]; beside unit_length", 1000.0, None)
    step: Count | None = key("step or subcase of the file whose supports hold, from 1", 2, None)
    names: dict[str, Literal["membrane", "cable", "beam", "clamped", "pinned", "support", "ignore"]] | None = key(
        "roles of groups in the file", {"skin": "membrane"}, None
    )
    sections: dict[str, GroupSection] | None = key(
        "[mesh.sections.NAME] sections of groups in the file", {"booms": {"area": 1e-4}}, None
    )

    @property
    def node_spaces(self) -> tuple[int, int]:
        """Spaces between the film's nodes along x and y."""
        per_cell = 2 if SHAPES[self.element].midside_nodes else 1
        return per_cell * self.divisions[0], per_cell * self.divisions[1]

    @model_validator(mode="after")
    def _file_or_divisions(self) -> Self:
        for name in ("divisions", "pattern", "element"):
            if self.file is not None and name in self.model_fields_set:
                text = f"{name}: expected no value beside file = {show(self.file)}, got {show(getattr(self, name))}"
                raise ValueError(f"{text}; remove one of the two")
        for name in ("unit_length", "unit_mass", "step", "names", "sections"):
            if self.file is None and getattr(self, name) is not None:
                text = f"{name}: expected no value without file, got {show(getattr(self, name))}"
                raise ValueError(f"{text}; add file, or remove it")
        return self

    @model_serializer(mode="wrap")
    def _without_unused(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out the built-in mesh beside a file."""
        values: dict[str, Any] = serialize(self)
        left_out = () if self.file is None else ("divisions", "pattern", "element")
        return {key: value for key, value in values.items() if key not in left_out}


class Mass(Section):
    """Rigid body at a node: a payload, a feed, a tip mass. With inertia or offset the node must carry a beam."""

    node: Annotated[int, Strict(), Field(ge=0)] | None = key("number of the node, from 0", 12, None)
    near: tuple[Number, Number] | Vector | None = key("point whose nearest node carries it [m]", (1.25, 0.75), None)
    mass: NonNegative = key("mass [kg]", 2.5, 0.0)
    inertia: NonNegative | Vector | tuple[Vector, Vector, Vector] = key(
        "inertia about its centre of mass [kg m^2]: one number, principal moments, or a tensor", (0.1, 0.1, 0.2), 0.0
    )
    offset: Vector = key("centre of mass from the node [m]", (0.0, 0.0, 0.1), (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.node is None) == (self.near is None):
            got = "neither" if self.node is None else f"node = {self.node} and near = {show(self.near)}"
            raise ValueError(f"near: expected a point near a node, or its number under node, got {got}; give one")
        return self


class Prestress(Section):
    """How the reference state comes about (theory: prestress).

    ``resultant_per_pretension`` [1/m] gives, in uniform mode, the membrane resultants along x and y in N/m
    per N of ``pretension_x`` and ``pretension_y``; it replaces ``membrane.stress_x`` and ``stress_y``.
    """

    mode: Literal["equilibrium", "uniform", "initial-strain"] | None = key(
        "prestress mode; default 'equilibrium' with cables, 'uniform' with fixed edges", "equilibrium", None
    )
    resultant_per_pretension: tuple[NonNegative, NonNegative] | None = key(
        "membrane resultant per cable tension along x and y [1/m]", (0.707, 0.547), None
    )
