"""The whole case: sections, and the rules that hold between them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any, Literal, Self

import tomli_w
from pydantic import BeforeValidator, Field, SerializeAsAny, ValidationInfo, field_validator, model_validator

from tautflex.case import memory
from tautflex.case.messages import meaning, require_names, show
from tautflex.case.section import Section, key, meant_by
from tautflex.case.sections.control import Actuator, Controller, Hub, Loop, Sensor, Task
from tautflex.case.sections.dynamic import Coupling, Damping, Output, Reduction, Solver
from tautflex.case.sections.inputs import Input
from tautflex.case.sections.links import Damper, Link, Spring
from tautflex.case.sections.loop_rules import loop_contradictions
from tautflex.case.sections.maneuver import Maneuver
from tautflex.case.sections.structural import Cables, EdgeCords, Frame, Mass, Membrane, Mesh, Prestress
from tautflex.errors import CaseError
from tautflex.structure.shapes import SHAPES
from tautflex.text import card, shown

_LARGEST = 1e300  # keeps products of absurd step counts finite
# Geometry of the built-in antenna; beside a mesh file it is stated twice.
_GEOMETRY = {
    "membrane": ("length", "width"),
    "cables": ("per_long_edge", "per_short_edge", "distribution", "segments"),
    "frame": ("length", "width", "support"),
}
# What a mesh file may state instead.
_MATERIAL = ("youngs_modulus", "density")
_SECTIONS = {
    "membrane": ("thickness", "poisson_ratio", *_MATERIAL),
    "cables": ("area", *_MATERIAL),
    "frame": ("area", "inertia_y", "inertia_z", "torsion_constant", "poisson_ratio", *_MATERIAL),
}


class Case(Section):
    """A validated antenna, maneuver and solver: what a case file holds, SI units.

    Sections may be given as the classes of `tautflex.case` or as plain dictionaries.

    Raises
    ------
    CaseError
        If a key is unknown, missing or unusable, or if two sections contradict each other.

    Examples
    --------
    >>> import tautflex as tf
    >>> film = dict(length=2.0, width=1.0, thickness=1e-4, youngs_modulus=3.5e9, poisson_ratio=0.34,
    ...             density=1530.0, edges="fixed", stress_x=4e3, stress_y=4e3)
    >>> tf.Case(schema=1, membrane=film).prestress.mode
    'uniform'
    """

    # "schema" is the key in the file; BaseModel keeps that attribute name for itself.
    schema_number: Literal[1] = Field(default=1, alias="schema", description="version of the case format", examples=[1])
    membrane: Membrane = key("[membrane] section")
    cables: Cables | None = key("[cables] section", None, None)
    edge_cords: EdgeCords | None = key("[edge_cords] section", None, None)
    frame: Frame | None = key("[frame] section", None, None)
    mesh: Mesh = key("[mesh] section", default=Mesh())
    masses: tuple[Mass, ...] = key("[[masses]] sections", default=())
    links: tuple[Annotated[SerializeAsAny[Link], BeforeValidator(Link.from_table)], ...] = key(
        "[[links]] sections", default=()
    )
    springs: tuple[Spring, ...] = key("[[springs]] sections", default=())
    dampers: tuple[Damper, ...] = key("[[dampers]] sections", default=())
    prestress: Prestress = key("[prestress] section", default=Prestress())
    maneuver: Annotated[SerializeAsAny[Maneuver], BeforeValidator(Maneuver.from_table)] = Field(
        default_factory=Maneuver, description="[maneuver] section"
    )
    damping: Annotated[SerializeAsAny[Damping], BeforeValidator(Damping.from_table)] = Field(
        default_factory=Damping, description="[damping] section"
    )
    coupling: Coupling = key("[coupling] section", default=Coupling())
    solver: Annotated[SerializeAsAny[Solver], BeforeValidator(Solver.from_table)] = Field(
        default_factory=Solver, description="[solver] section"
    )
    inputs: dict[str, Annotated[SerializeAsAny[Input], BeforeValidator(Input.from_table)]] = key(
        "[inputs.NAME] sections", default={}
    )
    hub: Annotated[Hub | None, BeforeValidator(Hub.from_table)] = key("[hub] section", None, None)
    actuators: dict[str, Annotated[SerializeAsAny[Actuator], BeforeValidator(Actuator.from_table)]] = key(
        "[actuators.NAME] sections", default={}
    )
    sensors: dict[str, Annotated[SerializeAsAny[Sensor], BeforeValidator(Sensor.from_table)]] = key(
        "[sensors.NAME] sections", default={}
    )
    controller: Annotated[
        SerializeAsAny[Controller] | tuple[SerializeAsAny[Controller], ...] | None,
        BeforeValidator(Controller.one_or_more),
    ] = key("[controller] section, or [[controller]] sections", None, None)
    task: Annotated[SerializeAsAny[Task] | None, BeforeValidator(Task.from_table)] = key("[task] section", None, None)
    loop: Loop = key("[loop] section", default=Loop())
    output: Output = key("[output] section", default=Output())
    reduction: Annotated[SerializeAsAny[Reduction] | None, BeforeValidator(Reduction.from_table)] = key(
        "[reduction] section", None, None
    )

    def to_toml(self) -> str:
        """Write the case as TOML text that `load_case` reads back to an equal case."""
        values = self.model_dump(mode="python", by_alias=True, exclude_none=True)
        return tomli_w.dumps({name: value for name, value in values.items() if value not in ({}, ())})

    def __repr__(self) -> str:
        sections = self.model_dump(exclude_defaults=True, exclude_none=True)
        told = {
            name: ", ".join(f"{key} = {shown(value)}" for key, value in dict(keys).items())
            for name, keys in sections.items()
            if name not in ("schema_number", "masses", "links", "springs", "dampers")
        }
        if self.masses:
            told["masses"] = f"{len(self.masses)}, {sum(body.mass for body in self.masses):.4g} kg"
        told |= {name: str(len(own)) for name in ("links", "springs", "dampers") if (own := getattr(self, name))}
        return card(self, told)

    __str__ = __repr__

    def replaced(self, **sections: Any) -> Case:
        """Return a validated copy with keys changed, e.g. ``case.replaced(cables={"pretension_x": 1.0})``.

        None takes a key or a section out, so that it has its default again; what is no table replaces the section.

        Examples
        --------
        >>> import tautflex as tf
        >>> tf.load_case("m2.toml").replaced(maneuver={"duration": 0.5}).maneuver.duration
        0.5
        """
        values = self.model_dump(by_alias=True, exclude_none=True)
        for name, changes in sections.items():
            now = values.pop(name, {})
            if isinstance(changes, dict):
                changed = {**(now if isinstance(now, dict) else {}), **changes}
                values[name] = {key: value for key, value in changed.items() if value is not None}
            elif changes is not None or name not in Case.model_fields:
                values[name] = changes
        return Case(**values)

    @field_validator("inputs", "actuators", "sensors")
    @classmethod
    def _sections_have_names(cls, value: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        require_names(value, f"names of {info.field_name}", "push")
        return value

    @model_validator(mode="after")
    def _prestress_is_stated_once(self) -> Self:
        default = "uniform" if self.membrane.edges == "fixed" else "equilibrium"
        if self.prestress.mode is None:
            stated = self.prestress.model_copy(update={"mode": default})
            self.__dict__["prestress"] = stated  # the one default that depends on another section
        return self

    @model_validator(mode="after")
    def _sections_go_together(self) -> Self:
        """All that contradicts itself in one answer, but for rules whose ground another problem takes away."""
        problems = list[str]()

        def ask(*rules: Callable[[Case], Iterator[str]]) -> None:
            for rule in rules:
                whole = {text.partition(":")[0] for text in problems}  # of a section that should not be there
                problems.extend(text for text in rule(self) if text.partition(".")[0] not in whole)

        ask(Case._edges_have_what_they_need, Case._geometry_is_stated_once, Case._tensions_are_stated_once)
        if not problems:
            ask(Case._frame_surrounds_membrane, Case._mesh_has_a_node_per_cable, Case._stress_has_one_source)
        ask(Case._probes_are_on_the_film, Case._reduction_fits_the_case, loop_contradictions, Case._fits_in_memory)
        if problems:
            raise CaseError(*problems)
        return self

    def _further(self, values: dict[str, Any], problems: Sequence[str]) -> Iterator[str]:
        """What the antenna lacks beside keys that are wrong: its rules are not come to otherwise."""
        yield from super()._further(values, problems)
        tables, meant = dict(values), [(text.partition(":")[0].split("."), meant_by(text)) for text in problems]
        for (name, *inner), right in sorted(meant, key=lambda one: len(one[0])):
            if right and not inner and name in values:
                tables.setdefault(right, values[name])
            elif right and isinstance(own := tables.get(name), dict) and len(inner) == 1:
                tables[name] = {right: own.get(inner[0])} | own
        kinds: dict[str, type[Section]] = {"membrane": Membrane, "cables": Cables, "frame": Frame, "mesh": Mesh}
        taken = {name: tables.get(name, {} if name == "mesh" else None) for name in kinds}
        as_it_is = {
            name: kinds[name].model_construct(**own) if isinstance(own, dict) else own for name, own in taken.items()
        }
        if not all(isinstance(own, Section | None) for own in as_it_is.values()) or as_it_is["membrane"] is None:
            return
        given: dict[str, Any] = as_it_is | {"edge_cords": tables.get("edge_cords")}
        case, wrong = Case.model_construct(**given), [keys for keys, _ in meant]
        wrong += [[right] for keys, right in meant if right and len(keys) == 1]  # what a misspelt one lacks is open
        known = ["membrane", "edges"] not in wrong
        rules = Case._edges_have_what_they_need, Case._tensions_are_stated_once
        for rule in (*rules, Case._geometry_is_stated_once) if known else (Case._geometry_is_stated_once,):
            for text in rule(case):
                section, *key = text.partition(":")[0].split(".")
                if ": missing," in text and [section] not in wrong and [section, *key] not in wrong:
                    yield text

    def _geometry_is_stated_once(self) -> Iterator[str]:
        file = self.mesh.file
        for name, names in _GEOMETRY.items():
            section = getattr(self, name)
            for one in (*names, *_SECTIONS[name]) if section is not None else ():
                value, field = getattr(section, one), type(section).model_fields[one]
                if file is None and value is None:
                    yield f"{name}.{one}: missing, expected the {meaning(one, field)}; add it"
                if file is not None and one in names and value != field.default:
                    text = f"{name}.{one}: expected no value beside mesh.file = {show(file)}, got {show(value)}"
                    yield f"{text}; remove one of the two"

    def _edges_have_what_they_need(self) -> Iterator[str]:
        edges, has_file = self.membrane.edges, self.mesh.file is not None
        for name in ("cables", "frame", "edge_cords"):
            section, needed = getattr(self, name), edges == "scalloped" or (edges == "cables" and name != "edge_cords")
            if name == "frame" and has_file:
                continue  # whether there is one is the file's to say
            if needed and section is None and not has_file:
                text = f"{name}: missing, membrane.edges = {edges!r} expects a [{name}] section"
                yield f"{text}; add it, or set membrane.edges = 'fixed' for a plain film"
            if not needed and section is not None:
                text = f"{name}: expected no such section with membrane.edges = {edges!r}, got [{name}]"
                other = "scalloped" if name == "edge_cords" else "cables"
                yield f"{text}; remove it, or set membrane.edges = {other!r}"
        if edges == "scalloped" and has_file:
            text = f"membrane.edges: expected 'cables' or 'fixed' beside mesh.file = {show(self.mesh.file)}"
            yield f"{text}, got 'scalloped'; cords of a mesh file are cables of it, remove one of the two"

    def _tensions_are_stated_once(self) -> Iterator[str]:
        """Tensions of cables are given, but those beside scalloped edges follow from the film's stress."""
        if self.cables is None:
            return
        scalloped = self.membrane.edges == "scalloped"
        for name in ("pretension_x", "pretension_y", "distribution"):
            value, field = getattr(self.cables, name), Cables.model_fields[name]
            if scalloped and value != field.default:
                text = f"cables.{name}: expected no value with membrane.edges = 'scalloped', got {show(value)}"
                yield f"{text}; remove it, tensions follow from membrane.stress_x, stress_y and the cut"
            if not scalloped and value is None and self.mesh.file is None:
                yield f"cables.{name}: missing, expected the {meaning(name, field)}; add it"

    def _frame_surrounds_membrane(self) -> Iterator[str]:
        for side in ("length", "width") if self.mesh.file is None else ():
            inner = getattr(self.membrane, side)
            if self.frame is not None and getattr(self.frame, side) <= inner:
                text = f"frame.{side}: expected more than membrane.{side} = {inner:g} m"
                yield f"{text}, got {getattr(self.frame, side):g}; the cables span the gap, enlarge it"

    def _mesh_has_a_node_per_cable(self) -> Iterator[str]:
        if self.cables is not None:
            counts = (self.cables.per_long_edge, self.cables.per_short_edge)
            for axis, count, have in zip("xy", counts, self.mesh.divisions, strict=True):
                least = 0 if count is None else SHAPES[self.mesh.element].least_divisions(count - 1)
                if have < least:
                    text = f"mesh.divisions: expected at least {least} cells along {axis} for {count} cables"
                    yield f"{text}, got {_pair(self.mesh.divisions)}; refine the mesh or remove cables"

    def _stress_has_one_source(self) -> Iterator[str]:
        """Exactly one source of the membrane's stress: equilibrium, stress_x and stress_y, or resultants."""
        mode, stress = self.prestress.mode, self.membrane.stress_x
        ratios = self.prestress.resultant_per_pretension
        if self.membrane.edges == "fixed":
            if mode != "uniform":
                text = f"prestress.mode: expected 'uniform' with membrane.edges = 'fixed', got {mode!r}"
                yield f"{text}; remove it and give membrane.stress_x and stress_y"
            if ratios is not None:
                text = "prestress.resultant_per_pretension: expected no value with membrane.edges = 'fixed'"
                yield f"{text}, got {list(ratios)}; remove it, there are no cables"
            if stress is None and self.mesh.file is None:
                text = "membrane.stress_x: missing, membrane.edges = 'fixed' expects stress_x and stress_y [Pa]"
                yield f"{text}; add them under [membrane], for example 4000.0"
            return
        if self.membrane.edges == "scalloped":
            if mode != "equilibrium" or ratios is not None:
                stated = f"mode = {mode!r}" if ratios is None else f"resultant_per_pretension = {list(ratios)}"
                text = f"prestress: expected nothing stated with membrane.edges = 'scalloped', got {stated}"
                yield f"{text}; remove it, the edges are cut to carry membrane.stress_x and stress_y"
            if stress is None:
                text = "membrane.stress_x: missing, membrane.edges = 'scalloped' expects stress_x and stress_y [Pa]"
                yield f"{text}; add them under [membrane], for example 2e5"
            return
        if mode == "uniform" and stress is None and ratios is None and self.mesh.file is None:
            text = "prestress.resultant_per_pretension: missing, mode = 'uniform' expects the membrane's tension"
            yield f"{text}; add it, or give membrane.stress_x and stress_y [Pa]"
        if mode == "uniform" and ratios is not None and self.membrane.thickness is None:
            text = (
                f"prestress.resultant_per_pretension: expected it beside membrane.thickness, got {list(ratios)} alone"
            )
            yield f"{text}; add the thickness, or give membrane.stress_x and stress_y [Pa]"
        if mode == "uniform" and stress is not None and ratios is not None:
            text = f"prestress.resultant_per_pretension: expected no value beside membrane.stress_x = {stress:g}"
            yield f"{text}, got {list(ratios)}; keep one of the two"
        if mode != "uniform" and stress is not None:
            text = f"membrane.stress_x: expected no value with prestress.mode = {mode!r}, got {stress:g}"
            yield f"{text}; remove it, or set prestress.mode = 'uniform'"

    def _probes_are_on_the_film(self) -> Iterator[str]:
        if self.membrane.length is None or self.membrane.width is None:
            return  # of a mesh file, which is not read here
        half = (self.membrane.length / 2, self.membrane.width / 2)
        for name, point in self.output.probes.items():
            if len(point) == 2 and (abs(point[0]) > half[0] or abs(point[1]) > half[1]):
                film = f"|x| <= {half[0]:g} and |y| <= {half[1]:g} m"
                text = f"output.probes.{name}: expected a point on the film, {film}"
                remedy = "the origin is the film's centre, move the probe, or give x, y and z of a node of the frame"
                yield f"{text}, got {list(point)}; {remedy}"

    def _reduction_fits_the_case(self) -> Iterator[str]:
        """A reduced model has elastic laws and fixed steps."""
        if self.reduction is None:
            return
        if self.membrane.law != "elastic":
            text = f"reduction: expected membrane.law = 'elastic' with a [reduction], got {self.membrane.law!r}"
            yield f"{text}; remove [reduction], or use hyper_reduce from Python"
        for name, section in (self.mesh.sections or {}).items():
            if section.slack or section.law not in (None, "elastic"):
                text = f"reduction: expected elastic laws with a [reduction], got another in mesh.sections.{name}"
                yield f"{text}; remove [reduction], or use hyper_reduce from Python"
        if self.cables is not None and self.cables.slack:
            text = "reduction: expected cables.slack = false with a [reduction], got true"
            yield f"{text}; remove [reduction], or use hyper_reduce from Python"
        if self.solver.adaptive_tolerance is not None:
            text = f"reduction: expected no solver.adaptive_tolerance with it, got {self.solver.adaptive_tolerance:g}"
            yield f"{text}; remove it, steps of a reduced model cost next to nothing"

    def _fits_in_memory(self) -> Iterator[str]:
        available = memory.available_bytes()
        limit = f"fits in the {available / 1e9:.3g} GB of memory available"
        divisions = self.mesh.node_spaces if self.mesh.file is None else (1, 1)
        needed: float = memory.mesh_bytes(divisions)
        if needed > available:
            text = f"mesh.divisions: expected a mesh that {limit}"
            size = f"about {min(needed, _LARGEST) / 1e9:.3g} GB"
            yield f"{text}, got {_pair(divisions)} which needs {size}; use fewer divisions"
            return
        steps = min(self.solver.end_time / self.solver.time_step, _LARGEST)
        stored = steps / min(self.output.every, _LARGEST)
        keeps_all = self.output.fields == "all"
        needed = memory.history_bytes(stored, len(self.output.probes), divisions, keeps_all)
        if needed > available:
            text = f"output.every: expected a history that {limit}"
            size = f"{stored:.3g} stored steps which need about {needed / 1e9:.3g} GB"
            remedy = "raise every, enlarge solver.time_step, or store fields at fewer instants"
            yield f"{text}, got {self.output.every} giving {size}; {remedy}"


def _pair(divisions: tuple[int, int]) -> str:
    return "[" + ", ".join(f"{min(value, _LARGEST):.6g}" for value in divisions) + "]"
