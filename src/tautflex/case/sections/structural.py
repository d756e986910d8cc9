"""Sections of a case file that describe the structure: membrane, cables, frame, mesh, prestress."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from tautflex.case.messages import choices, problem, show
from tautflex.case.section import Count, Flag, NonNegative, Number, Positive, Section
from tautflex.structure.materials import LAW_NAMES
from tautflex.structure.shapes import SHAPES

EdgeCount = Annotated[Count, Field(ge=2)]


def _inside_elastic_range(value: float) -> float:
    if not -1.0 < value < 0.5:
        raise problem("a number inside (-1, 0.5)", value, "give Poisson's ratio; films have 0.3 to 0.4")
    return value


def _known_law(kind: str, value: object) -> object:
    if value not in LAW_NAMES[kind]:
        raise problem(f"one of {choices(LAW_NAMES[kind])}", value, "choose one of them")
    return value


class Membrane(Section):
    """Rectangular film, centred at the origin, x along ``length``.

    ``law = "tension-field"`` lets the film wrinkle and go slack; ``"elastic"`` carries any compression.
    ``stress_x`` and ``stress_y`` [Pa] state a given uniform stress (``prestress.mode = "uniform"``).
    """

    length: Positive | None = Field(default=None, description="side along x [m]", examples=[2.0])
    width: Positive | None = Field(default=None, description="side along y [m]", examples=[1.0])
    thickness: Positive = Field(description="film thickness [m]", examples=[1e-4])
    youngs_modulus: Positive = Field(description="Young's modulus of the film [Pa]", examples=[3.5e9])
    poisson_ratio: Number = Field(description="Poisson's ratio of the film", examples=[0.34])
    density: Positive = Field(description="mass density of the film [kg/m^3]", examples=[1530.0])
    strain: Literal["von-karman", "green-lagrange"] = Field(
        default="von-karman", description="strain measure of film, cables and frame", examples=["von-karman"]
    )
    law: Annotated[str, BeforeValidator(partial(_known_law, "membrane"))] = Field(
        default="elastic", description="material law of the film", examples=["tension-field"]
    )
    edges: Literal["cables", "fixed"] = Field(
        default="cables", description="what holds the edges of the film", examples=["cables"]
    )
    stress_x: Number | None = Field(default=None, description="given stress along x [Pa]", examples=[4170.0])
    stress_y: Number | None = Field(default=None, description="given stress along y [Pa]", examples=[5470.0])

    _poisson = field_validator("poisson_ratio")(_inside_elastic_range)

    @model_validator(mode="after")
    def _both_stresses(self) -> Self:
        if (self.stress_x is None) != (self.stress_y is None):
            given, lacking = ("stress_x", "stress_y") if self.stress_y is None else ("stress_y", "stress_x")
            stated = f"{given} = {getattr(self, given):g}"
            raise ValueError(f"{lacking}: missing, expected a stress [Pa] beside {stated}; add it")
        return self


class Cables(Section):
    """Cables from the film's edges straight to the frame, evenly spaced, the outer ones at its corners."""

    per_long_edge: EdgeCount | None = Field(
        default=None, description="number of cables on each edge along x, at least 2", examples=[11]
    )
    per_short_edge: EdgeCount | None = Field(
        default=None, description="number of cables on each edge along y, at least 2", examples=[6]
    )
    youngs_modulus: Positive = Field(description="Young's modulus of the cables [Pa]", examples=[133e9])
    area: Positive = Field(description="cross-sectional area of one cable [m^2]", examples=[3.14e-6])
    density: Positive = Field(description="mass density of the cables [kg/m^3]", examples=[1440.0])
    pretension_x: Number = Field(description="tension per cable pulling along x [N]", examples=[0.59])
    pretension_y: Number = Field(description="tension per cable pulling along y [N]", examples=[1.0])
    distribution: Literal["equal", "tributary"] = Field(
        default="equal",
        description="'equal' tensions, or 'tributary': corner cables carry half",
        examples=["equal"],
    )
    slack: Flag = Field(
        default=False,
        description="choice true or false: a cable goes slack instead of pushing",
        examples=[True],
    )
    law: Annotated[str, BeforeValidator(partial(_known_law, "cable"))] = Field(
        default="elastic", description="material law of the cables; 'slack' is slack = true", examples=["slack"]
    )

    @field_validator("pretension_x", "pretension_y")
    @classmethod
    def _taut(cls, value: float) -> float:
        if value == 0.0:
            remedy = "singular: a membrane without tension has no transverse stiffness, give a tension [N]"
            raise problem("a number > 0", value, remedy)
        if value < 0.0:
            raise problem("a number > 0", value, "a cable cannot push, give its tension [N]")
        return value


class Frame(Section):
    """Rectangular frame of beams; ``inertia_z`` bends in the antenna's plane, ``inertia_y`` out of it."""

    length: Positive | None = Field(default=None, description="centre-line side along x [m]", examples=[2.5])
    width: Positive | None = Field(default=None, description="centre-line side along y [m]", examples=[1.5])
    youngs_modulus: Positive = Field(description="Young's modulus of the frame [Pa]", examples=[3e9])
    poisson_ratio: Number = Field(description="Poisson's ratio of the frame", examples=[0.38])
    density: Positive = Field(description="mass density of the frame [kg/m^3]", examples=[1380.0])
    area: Positive = Field(description="cross-sectional area [m^2]", examples=[5.24e-4])
    inertia_y: Positive = Field(description="second moment of area, bending out of plane [m^4]", examples=[4.81e-7])
    inertia_z: Positive = Field(description="second moment of area, bending in plane [m^4]", examples=[2.69e-7])
    torsion_constant: Positive = Field(description="torsion constant [m^4]", examples=[7.5e-7])
    support: Literal["corners", "all", "axis", "short-side", "free"] = Field(
        default="corners", description="clamped part of the frame", examples=["corners"]
    )

    _poisson = field_validator("poisson_ratio")(_inside_elastic_range)


class Mesh(Section):
    """Mesh: a grid of cells along x and y, each one quad or cut by a diagonal into two triangles, or a file.

    With ``file`` (Gmsh, Abaqus or Nastran) film, cables, frame and supports come from its groups; the case states
    sections and tensions only, a cable's tension by its direction. ``names`` gives roles to groups whose names
    do not tell them.
    """

    divisions: tuple[Count, Count] = Field(
        default=(20, 10), description="numbers of cells along x and y, integers >= 1", examples=[(20, 10)]
    )
    pattern: Literal["alternating", "regular"] = Field(
        default="alternating", description="directions of the diagonals; quads have none", examples=["alternating"]
    )
    element: str = Field(default="triangle3", description="shape of the film's elements", examples=["triangle6"])
    file: str | None = Field(
        default=None, strict=True, description="mesh file (.msh, .inp, .bdf)", examples=["antenna.msh"]
    )
    unit_length: Positive | None = Field(default=None, description="length of the file's unit [m]", examples=[0.001])
    names: dict[str, Literal["membrane", "cable", "beam", "clamped", "pinned", "support", "ignore"]] | None = Field(
        default=None, description="roles of groups in the file", examples=[{"skin": "membrane"}]
    )

    @property
    def node_spaces(self) -> tuple[int, int]:
        """Spaces between the film's nodes along x and y."""
        per_cell = 2 if SHAPES[self.element].midside_nodes else 1
        return per_cell * self.divisions[0], per_cell * self.divisions[1]

    @field_validator("element")
    @classmethod
    def _known_shape(cls, value: str) -> str:
        known = [name for name, shape in SHAPES.items() if shape.dimension == 2]
        if value not in known:
            raise problem("one of " + ", ".join(map(repr, known)), value, "choose one of them")
        return value

    @model_validator(mode="after")
    def _file_or_divisions(self) -> Self:
        for key in ("divisions", "pattern", "element"):
            if self.file is not None and key in self.model_fields_set:
                text = f"{key}: expected no value beside file = {show(self.file)}, got {show(getattr(self, key))}"
                raise ValueError(f"{text}; remove one of the two")
        for key in ("unit_length", "names"):
            if self.file is None and getattr(self, key) is not None:
                text = f"{key}: expected no value without file, got {show(getattr(self, key))}"
                raise ValueError(f"{text}; add file, or remove it")
        return self

    @model_serializer(mode="wrap")
    def _without_unused(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out the built-in mesh beside a file."""
        values: dict[str, Any] = serialize(self)
        left_out = () if self.file is None else ("divisions", "pattern", "element")
        return {key: value for key, value in values.items() if key not in left_out}


class Prestress(Section):
    """How the reference state comes about (theory: prestress).

    ``resultant_per_pretension`` [1/m] gives, in uniform mode, the membrane resultants along x and y in N/m
    per N of ``pretension_x`` and ``pretension_y``; it replaces ``membrane.stress_x`` and ``stress_y``.
    """

    mode: Literal["equilibrium", "uniform", "initial-strain"] | None = Field(
        default=None,
        description="prestress mode; default 'equilibrium' with cables, 'uniform' with fixed edges",
        examples=["equilibrium"],
    )
    resultant_per_pretension: tuple[NonNegative, NonNegative] | None = Field(
        default=None,
        description="membrane resultant per cable tension along x and y [1/m]",
        examples=[(0.707, 0.547)],
    )
