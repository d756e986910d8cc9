"""A mesh whose groups have a meaning, ready to become a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.files.mesh.section.section_data import PRESTRESS as PRESTRESS_KEYS
from tautflex.files.mesh.section.section_data import MeshSection, initial_forces, made
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import Support
from tautflex.structure.links.link import Link
from tautflex.structure.masses import PointMass
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection, Section
from tautflex.structure.model import Model
from tautflex.structure.springs import Damper, Spring
from tautflex.text import brief

PARTS = {"membrane": ("triangles", "quads"), "cable": ("cables",), "beam": ("beams",)}
"""Elements of each kind."""
ELEMENTS = tuple(part for parts in PARTS.values() for part in parts)
PRESTRESS = {"membrane": "membrane_stress", "cable": "cable_tension", "beam": "beam_axial_force"}
"""Argument of `Model.from_mesh` for the prestress of each kind."""


@dataclass(frozen=True)
class MeshData:
    """Mesh read from a file.

    Parameters
    ----------
    nodes
        Positions [m], shape (node, 3); every node belongs to an element.
    triangles, cables, beams, quads
        Rows of ``nodes`` from 0, shapes (t, 3) or (t, 6), (c, 2), (b, 2), (q, 4).
    supports
        Held nodes.
    groups
        For each name in the file the rows it selects, e.g. ``groups["cables_x"]["cables"]``; the keys are those of
        ``triangles``, ``quads``, ``cables``, ``beams`` and ``nodes`` that the group has.
    beam_orientation
        Direction whose part normal to each beam is its local z axis, as the file states it, shape (b, 3); where it
        states none, that of `Model.from_mesh`.
    masses
        Rigid bodies at nodes.
    links, springs, dampers
        What joins nodes beside elements.
    sections
        What the file states about the section of each group; elements of one stand in a row.
    initial_stress
        Stress that the file gives ``"triangles"``, ... [Pa], in the axes of `Model.from_mesh`, shapes (t, 3), (q, 3),
        (c, 1), (b, 1).
    free_strain
        Strain that elements would take if they were free [-], shapes (element,): of temperatures, or given ones.
    nonstructural_mass
        Mass without stiffness that elements have beside that of their section [kg/m^2, kg/m], shapes (element,).
    """

    nodes: Array
    triangles: Indices
    cables: Indices
    beams: Indices
    supports: tuple[Support, ...] = ()
    groups: Mapping[str, Mapping[str, Indices]] = field(default_factory=dict)
    quads: Indices = field(default_factory=lambda: np.zeros((0, 4), dtype=np.int64))
    beam_orientation: Array | None = None
    masses: tuple[PointMass, ...] = ()
    links: tuple[Link, ...] = ()
    springs: tuple[Spring, ...] = ()
    dampers: tuple[Damper, ...] = ()
    sections: Mapping[str, MeshSection] = field(default_factory=dict)
    initial_stress: Mapping[str, Array] = field(default_factory=dict)
    free_strain: Mapping[str, Array] = field(default_factory=dict)
    nonstructural_mass: Mapping[str, Array] = field(default_factory=dict)
    __repr__ = brief

    def values(self, kind: str, by_group: Mapping[str, float]) -> Array:
        """Spread one value per group over the elements, e.g. tensions over cables.

        Parameters
        ----------
        kind
            ``"triangles"``, ``"quads"``, ``"cables"`` or ``"beams"``.
        by_group
            Value of each group; together the groups must cover every element once.

        Returns
        -------
        numpy.ndarray
            Value of each element, shape (element,).

        Raises
        ------
        InputError
            If a group does not exist, or an element has no value or two.
        """
        checks.one_of("kind", kind, ELEMENTS)
        spread = np.full(len(getattr(self, kind)), np.nan)
        for name, value in by_group.items():
            rows = self.groups.get(name, {}).get(kind)
            if rows is None:
                having = ", ".join(repr(group) for group, parts in self.groups.items() if kind in parts) or "none"
                raise InputError(f"by_group: expected groups of {kind} ({having}), got {name!r}; correct the name")
            if not np.isnan(spread[rows]).all():
                raise InputError(f"by_group: group {name!r} shares {kind} with another one; give each {kind[:-1]} once")
            spread[rows] = checks.finite(f"value of {name}", value)
        if np.isnan(spread).any():
            left = int(np.isnan(spread).sum())
            raise InputError(
                f"by_group: expected a value for all {kind}, got none for {left} of them; name more groups"
            )
        return spread

    def model(
        self,
        *,
        membrane: MembraneSection | Mapping[str, Any] | None = None,
        cable: CableSection | Mapping[str, Any] | None = None,
        beam: BeamSection | Mapping[str, Any] | None = None,
        sections: Mapping[str, Mapping[str, Any]] | None = None,
        **given: Any,
    ) -> Model:
        """Build the structure; everything else is passed on to `Model.from_mesh`.

        Parameters
        ----------
        membrane, cable, beam
            Section of all elements of a kind, in the place of those of the file; or values by key, such as ``strain``
            and ``law``, which hold for all of the kind unless the file's sections differ in them. What the file states
            is not needed.
        sections
            What replaces or completes the sections of groups, by key, e.g. ``{"pid3": {"thickness": 25e-6}}``: keys of
            `MeshSection`, ``strain``, ``law``, ``slack``, and ``stress_x`` and ``stress_y`` [Pa], ``tension`` or
            ``axial_force`` [N].
        **given
            Prestress, orientations, prestress mode; ``supports``, ``masses``, ``links``, ``springs``, ``dampers``,
            ``beam_orientation`` and prestress replace those of the file.

        Raises
        ------
        MeshError
            If the mesh is degenerate or disconnected.
        InputError
            If a section is missing or a value is unusable.
        """
        stated = dict(checks.instance("sections", sections or {}, Mapping, "a mapping from groups to keys"))
        for name in stated:
            self._require_elements(name)
        for part in (part for parts in PARTS.values() for part in parts):
            checks.float_array(part, getattr(self, part), (None, None))
        used: dict[str, Any] = {"membrane": membrane, "cable": cable, "beam": beam}
        for kind, one in used.items():
            count = sum(len(getattr(self, part)) for part in PARTS[kind])
            of_file = any(section.kind == kind for section in self.sections.values())
            told = any(
                one.get(part, np.zeros(0)).any()
                for one in (self.initial_stress, self.free_strain, self.nonstructural_mass)
                for part in PARTS[kind]
            )
            if count and (stated or of_file or told or isinstance(one, Mapping)):
                own = {name: keys for name, keys in stated.items() if set(self.groups[name]) & set(PARTS[kind])}
                used[kind] = self._element_sections(kind, own, one)
                given[PRESTRESS[kind]] = self._prestress(kind, used[kind], own, given.get(PRESTRESS[kind]), count)
            elif not count:
                used[kind] = None
        if self.beam_orientation is not None:
            given = {"beam_orientation": self.beam_orientation, **given}
        given = {"selections": self.groups, **given}
        return Model.from_mesh(
            self.nodes,
            triangles=self.triangles,
            quads=self.quads,
            cables=self.cables,
            beams=self.beams,
            **used,
            **{
                name: getattr(self, name)
                for name in ("supports", "masses", "links", "springs", "dampers")
                if name not in given
            },
            **given,
        )

    def _element_sections(self, kind: str, stated: Mapping[str, Mapping[str, Any]], given: Any) -> list[Section]:
        """Section of each element: of a user's group, of all that a user states of the kind, of the file."""
        own = {name: section for name, section in self.sections.items() if section.kind == kind}
        rest = given if isinstance(given, Mapping) else {}
        agreed = {
            key: value for key, value in rest.items() if len({str(one.values.get(key)) for one in own.values()}) < 2
        }
        whole = given is not None and not isinstance(given, Mapping)
        found: dict[tuple[str, str, float], Section] = {}
        extra = np.concatenate([self._extra(part) for part in PARTS[kind]]).tolist()
        each = list(zip(self._owners(kind, own), self._owners(kind, stated), extra, strict=True))
        for file, user, more in dict.fromkeys(each):
            name = f"sections.{user or file}" if user or file else kind
            below = agreed if file else rest
            section = (
                given if whole and not user else made(name, kind, own.get(file), {**below, **stated.get(user, {})})
            )
            if more:
                section = replace(section, nonstructural_mass=section.nonstructural_mass + more)
            found[file, user, more] = section
        return [found[one] for one in each]

    def _extra(self, part: str) -> Array:
        return self.nonstructural_mass.get(part, np.zeros(len(getattr(self, part))))

    def _prestress(
        self, kind: str, sections: Sequence[Section], stated: Mapping[str, Mapping[str, Any]], given: Any, count: int
    ) -> Array:
        """Prestress of each element as `Model.from_mesh` takes it: of groups, else ``given``, else the file's."""
        width = 3 if kind == "membrane" else 1
        if given is None:
            stress = [
                self.initial_stress.get(part, np.zeros((len(getattr(self, part)), width))) for part in PARTS[kind]
            ]
            strain = [self.free_strain.get(part, np.zeros(len(getattr(self, part)))) for part in PARTS[kind]]
            result = initial_forces(kind, sections, np.concatenate(stress), np.concatenate(strain))
        else:
            result = checks.spread(PRESTRESS[kind], given, count, width if width > 1 else None).reshape(count, width)
        for row, name in enumerate(self._owners(kind, stated)):
            told = [stated[name].get(key) for key in PRESTRESS_KEYS[kind]] if name else []
            if any(value is not None for value in told):
                values = [checks.finite(f"sections.{name}", value or 0.0) for value in told]
                result[row] = [*values, *[0.0] * (width - len(told))]
        return result if width > 1 else result[:, 0]

    def _owners(self, kind: str, names: Iterable[str]) -> list[str]:
        """Which of some groups each element of a kind belongs to, "" for none."""
        owner, first = np.full(sum(len(getattr(self, part)) for part in PARTS[kind]), "", dtype=object), 0
        for part in PARTS[kind]:
            for name in names:
                rows = first + self.groups[name].get(part, np.zeros(0, dtype=np.int64))
                if (owner[rows] != "").any():
                    other = next(one for one in owner[rows] if one)
                    raise InputError(f"sections: group {name!r} shares {part} with {other!r}; state each once")
                owner[rows] = name
            first += len(getattr(self, part))
        return list(owner)

    def _require_elements(self, name: str) -> None:
        if not set(self.groups.get(name, ())) & set(ELEMENTS):
            having = ", ".join(repr(one) for one, rows in self.groups.items() if set(ELEMENTS) & set(rows)) or "none"
            raise InputError(f"sections: expected groups of elements ({having}), got {name!r}; correct the name")
