"""An Abaqus or CalculiX input file as a mesh."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.conditions import Steps, held_groups, removed_elements
from tautflex.files.mesh.abaqus.initial import initial_stress
from tautflex.files.mesh.abaqus.instances import Placement
from tautflex.files.mesh.abaqus.joints.links import Joints
from tautflex.files.mesh.abaqus.joints.releases import releases
from tautflex.files.mesh.abaqus.joints.springs import spring
from tautflex.files.mesh.abaqus.joints.surfaces import Surfaces, Whole
from tautflex.files.mesh.abaqus.joints.ties import embedded, tied
from tautflex.files.mesh.abaqus.keywords import WORDS
from tautflex.files.mesh.abaqus.masses import body, nonstructural
from tautflex.files.mesh.abaqus.materials import MATERIALS, Materials
from tautflex.files.mesh.abaqus.properties import section
from tautflex.files.mesh.abaqus.scope import Scope
from tautflex.files.mesh.abaqus.sections import beam_directions, node_axes
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.temperatures import free_strain
from tautflex.files.mesh.abaqus.text import Block, blocks
from tautflex.files.mesh.gathered import SHAPES, UNSTATED
from tautflex.files.mesh.include import Folder
from tautflex.files.mesh.new_ends import NewEnds
from tautflex.files.mesh.raw import (
    Budget,
    RawGroup,
    RawMass,
    RawMesh,
    RawNonstructural,
    integers,
    require_coordinates,
    shorten,
)
from tautflex.files.mesh.raw_links import RawLink
from tautflex.files.mesh.second_order import simplified
from tautflex.files.mesh.section.section_data import RawSection
from tautflex.numeric import Array, Indices, Mask


def read_abaqus(text: str, folder: Folder | None = None, step: int | None = None) -> RawMesh:
    """Read the mesh of an Abaqus or CalculiX input file.

    Sets are groups under their names, ``instance.name`` where several have the same one; elements without ELSET are
    in one of the name of their type.

    Parameters
    ----------
    text
        The file.
    folder
        Where included files are.
    step
        Number of the step whose supports hold; None for the only one, or the only one that asks for frequencies.

    Raises
    ------
    MeshError
        If a line is wrong, or would change the structure and is not read.
    """
    content = _Content()
    for block in blocks(text, folder or Folder()):
        if WORDS.is_read(block.keyword, block.where):
            content.read(block)
    return _Whole(content.placements()).mesh(content, step)


@dataclass
class _Content:
    """What the blocks read so far have brought, and where the next one belongs."""

    outside: Scope = field(default_factory=Scope)
    parts: dict[str, Scope] = field(default_factory=dict)
    instances: list[tuple[Block, Scope]] = field(default_factory=list)
    steps: Steps = field(default_factory=Steps)
    materials: Materials = field(default_factory=Materials)
    initial: list[Block] = field(default_factory=list)
    current: Scope | None = None

    def read(self, block: Block) -> None:
        if block.keyword == "PART":
            block.require_options("NAME")
            name = block.option("NAME")
            if not name or name.casefold() in self.parts:
                raise MeshError(f"{block.where}: expected a part of a new name, got {shorten(name)}; rename it")
            self.current = self.parts[name.casefold()] = Scope(name=name)
        elif block.keyword == "INSTANCE":
            self.current = Scope(name=block.option("NAME"))
            self.instances.append((block, self.current))
        elif block.keyword in ("END PART", "END INSTANCE", "ASSEMBLY", "END ASSEMBLY"):
            self.current = None
        elif block.keyword == "INITIAL CONDITIONS":
            self.initial.append(block)
        elif block.keyword in ("BOUNDARY", "STEP", "END STEP", "FREQUENCY", "MODEL CHANGE", "TEMPERATURE"):
            if self.current is not None:
                raise MeshError(f"{block.where}: expected this outside of parts and instances; move it behind them")
            self.steps.read(block)
        elif block.keyword in MATERIALS:
            self.materials.read(block)
        elif block.keyword not in ("HEADING", "INCLUDE"):
            (self.current or self.outside).read(block)

    def placements(self) -> list[Placement]:
        """What stands outside, then every instance."""
        if self.parts and not self.instances:
            raise MeshError("expected instances of the parts, got none; add an assembly, or export a flat input file")
        found = [Placement.at_rest(self.outside)]
        for block, own in self.instances:
            part = self.parts.get(block.option("PART").casefold())
            found.append(Placement.of_instance(block, part, own))
        names = Counter(placement.name.casefold() for placement in found)
        twice = [name for name, count in names.items() if count > 1]
        if twice:
            raise MeshError(f"instance {shorten(twice[0])}: defined twice; give each instance its own name")
        return found


@dataclass
class _Told:
    """What blocks beside elements say: of each line, of each element, of nodes by row, of sets by scope and name."""

    orientation: Array
    oriented: Mask
    expansion: Array
    axes: dict[int, Array] = field(default_factory=dict)
    sections: dict[tuple[str, str], list[RawSection]] = field(default_factory=dict)
    nonstructural: dict[tuple[str, str], list[RawNonstructural]] = field(default_factory=dict)


class _Whole:
    """All placements as one mesh: nodes, elements by shape, and the names of both in each."""

    def __init__(self, placements: list[Placement]) -> None:
        self._placements, self._budget = placements, Budget()
        moved = []
        for placement in placements:
            positions = np.array(placement.scope.positions, dtype=float).reshape(-1, 3)
            numbers = integers(placement.scope.node_numbers)
            require_coordinates(positions, numbers)
            moved.append(placement.points(positions))
            require_coordinates(moved[-1], numbers)
        self.nodes = np.concatenate(moved)
        self.elements: dict[str, list[Indices]] = {shape: [] for shape in SHAPES}
        self.roles: dict[str, list[str]] = {shape: [] for shape in SHAPES}
        self._shape, self._row = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        self._node_names: list[Names] = []
        self._element_names: list[Names] = []
        first_node = first_element = 0
        for placement in placements:
            scope = placement.scope
            nodes = scope.nodes("node")
            self._node_names.append(Names(nodes, first_node + np.arange(len(scope.node_numbers))))
            elements, shape, row = scope.element_rows()
            counts = np.array([sum(len(part) for part in self.elements[name]) for name in SHAPES])
            self._shape.append(shape)
            self._row.append(row + counts[shape])
            self._element_names.append(Names(elements, first_element + np.arange(len(shape))))
            for name, connectivity in scope.connectivity(nodes).items():
                self.elements[name].append(connectivity + first_node)
                self.roles[name] += scope.roles[name]
            first_node += len(scope.node_numbers)
            first_element += len(shape)
        self._read_sets()

    def _read_sets(self) -> None:
        """Sets of the instances, then those outside, which may be made of them."""
        inner = [placement.name.casefold() for placement in self._placements[1:]]
        for names in (self._node_names, self._element_names):
            names[0].instances = dict(zip(inner, names[1:], strict=True))
        for k in [*range(1, len(self._placements)), 0]:
            placement = self._placements[k]
            for names, parts in (
                (self._node_names[k], placement.scope.node_parts),
                (self._element_names[k], placement.scope.element_parts),
            ):
                for name, numbers in parts:
                    names.add_numbers(name, numbers)
            for block in placement.blocks("sets"):
                (self._node_names if block.keyword == "NSET" else self._element_names)[k].read(block, self._budget)

    def mesh(self, content: _Content, step: int | None) -> RawMesh:
        """The mesh with its groups and the supports of a step."""
        shape, row = np.concatenate(self._shape), np.concatenate(self._row)
        elements = {
            name: np.concatenate([np.zeros((0, SHAPES[name]), np.int64), *parts])
            for name, parts in self.elements.items()
        }
        conditions, changes, warm = content.steps.in_force(step)
        told = self._told(content.materials, bool(warm), shape, row, elements["line2"])
        gone = removed_elements(changes, self._element_names[0])
        groups = [
            *self._groups(shape, row, told.sections, told.nonstructural),
            *held_groups(conditions, self._node_names[0], told.axes, self._budget),
            *([RawGroup("model change", _by_shape(shape[gone], row[gone]), role="ignore")] if len(gone) else ()),
        ]
        roles = {name: np.array(own, dtype="<U8") for name, own in self.roles.items()}
        masses = list(self._masses(shape, row, elements["point1"]))
        cold = [block for block in content.initial if block.option("TYPE").upper() == "TEMPERATURE"]
        given = [block for block in content.initial if block not in cold]
        stress = initial_stress(given, self._element_names[0], shape, row, elements, self.nodes, told.oriented)
        expansion = {name: np.zeros(len(own)) for name, own in elements.items()}
        for place, own in enumerate(expansion.values()):
            own[row[shape == place]] = told.expansion[shape == place]
        strain = free_strain(cold, warm, self._node_names[0], len(self.nodes), expansion, elements)
        links = [*self._links(shape, row, elements, told.axes), *self._springs(shape, row, elements)]
        ends = NewEnds(list(self.nodes))
        elements["line2"] = self._released(ends, told.orientation, shape, row, elements["line2"])
        links += ends.links
        nodes = np.reshape(ends.points, (-1, 3))
        return simplified(
            nodes, elements, roles, told.orientation, groups, True, masses, links, stress, strain if warm else None
        )

    def _told(self, materials: Materials, warm: bool, shape: Indices, row: Indices, lines: Indices) -> _Told:
        """What sections, transformed directions and nonstructural masses of all scopes say."""
        told = _Told(
            np.array([UNSTATED] * len(lines)).reshape(-1, 3), np.zeros(len(shape), dtype=bool), np.zeros(len(shape))
        )
        ends, line = self.nodes[lines], list(SHAPES).index("line2")
        for placement, nodes, names in zip(self._placements, self._node_names, self._element_names, strict=True):
            for block in placement.blocks("transforms"):
                told.axes.update(node_axes(block, placement, nodes, self.nodes))
            for block in placement.blocks("sections"):
                target = block.option("ELSET")
                if target not in names:
                    continue  # the section of no element
                own = told.sections.setdefault((placement.name, names.key(target)), [])
                own.append(section(block, materials))
                found = names.find(target, block.where)
                told.oriented[found] |= "ORIENTATION" in block.options
                if warm:
                    told.expansion[found] = materials.expansion(block)
                if own[-1].kind == "beam":
                    rows = row[found[shape[found] == line]]
                    told.orientation[rows] = beam_directions(block, placement, ends[rows])
            for block in placement.blocks("nonstructural"):
                names.find(block.option("ELSET"), block.where)
                key = placement.name, names.key(block.option("ELSET"))
                told.nonstructural.setdefault(key, []).append(nonstructural(block))
        return told

    def _links(
        self, shape: Indices, row: Indices, elements: dict[str, Indices], axes: dict[int, Array]
    ) -> Iterator[RawLink]:
        """Links of all scopes."""
        shapes = list(SHAPES)

        def corners(found: Indices) -> tuple[Indices, Indices]:
            beams, others = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
            for place in np.unique(shape[found]).tolist():
                rows = row[found[shape[found] == place]]
                turning = np.array(self.roles[shapes[place]], dtype=object)[rows] == "beam"
                beams.append(elements[shapes[place]][rows[turning]].ravel())
                others.append(elements[shapes[place]][rows[~turning]].ravel())
            return np.concatenate(beams), np.concatenate(others)

        whole = Whole(self.nodes, shape, row, elements)
        surfaces = Surfaces(whole)
        scopes = list(zip(self._placements, self._node_names, self._element_names, strict=True))
        for placement, nodes, names in scopes:
            for block in placement.blocks("surfaces"):
                surfaces.read(placement.name, block, nodes, names)
        for placement, nodes, names in scopes:
            find = partial(surfaces.find, placement.name)
            yield from Joints(placement.blocks("links"), nodes, names, corners, axes, find).links()
            for block in placement.blocks("ties"):
                if block.keyword == "TIE":
                    yield from tied(placement.name, block, surfaces, whole)
                else:
                    yield from embedded(block, names, whole)

    def _released(self, ends: NewEnds, orientation: Array, shape: Indices, row: Indices, lines: Indices) -> Indices:
        """Rows of the nodes of lines with new ones at the ends of beams that are hinged."""
        line, lines = list(SHAPES).index("line2"), lines.copy()
        for placement, names in zip(self._placements, self._element_names, strict=True):
            for block in placement.blocks("releases"):
                for where, target, end, free in releases(block):
                    found = names.find(target, where)
                    own = row[found]
                    if (shape[found] != line).any() or any(self.roles["line2"][k] != "beam" for k in own):
                        raise MeshError(f"{where}: expected beams, got others; correct the set")
                    for k in own.tolist():
                        lines[k, end] = ends.hinged(where, lines[k].tolist(), end, free, orientation[k])
        return lines

    def _springs(self, shape: Indices, row: Indices, elements: dict[str, Indices]) -> Iterator[RawLink]:
        """Springs and dampers of all scopes; MeshError if an element has no number, or another kind has one."""
        places = {list(SHAPES).index(name): name for name in ("spring1", "spring2")}
        left = {(name, k) for name in places.values() for k in range(len(elements[name]))}
        for placement, names in zip(self._placements, self._element_names, strict=True):
            for block in placement.blocks("springs"):
                for one in names.find(block.option("ELSET"), block.where).tolist():
                    name, k = places.get(int(shape[one]), ""), int(row[one])
                    if not name or not self.roles[name][k].startswith(block.keyword.lower()):
                        kind = block.keyword.lower()
                        raise MeshError(f"{block.where}: expected {kind} elements, got others; correct the set")
                    if (name, k) not in left:
                        raise MeshError(
                            f"{block.where}: expected elements without a {block.keyword}, got one; remove it"
                        )
                    left.remove((name, k))
                    found = spring(block, self.roles[name][k], elements[name][k])
                    if found is not None:
                        yield found
        if left:
            raise MeshError(f"expected *SPRING or *DASHPOT of every such element, got none of {len(left)}; add it")

    def _masses(self, shape: Indices, row: Indices, points: Indices) -> Iterator[RawMass]:
        """Bodies of all point elements; MeshError if one has none, or another kind than its type says."""
        point, left = list(SHAPES).index("point1"), set(range(len(points)))
        for placement, names in zip(self._placements, self._element_names, strict=True):
            for block in placement.blocks("bodies"):
                found = names.find(block.option("ELSET"), block.where)
                own, role = row[found], "mass" if block.keyword == "MASS" else "inertia"
                if (shape[found] != point).any() or any(self.roles["point1"][k] != role for k in own):
                    kind = "MASS" if role == "mass" else "ROTARYI"
                    raise MeshError(f"{block.where}: expected elements of TYPE={kind}, got others; correct the set")
                if not left.issuperset(own.tolist()):
                    raise MeshError(f"{block.where}: expected elements without a {block.keyword}, got some; remove one")
                left -= set(own.tolist())
                for k in own:
                    yield replace(body(block, placement), node=int(points[k, 0]))
        if left:
            raise MeshError(
                f"expected *MASS or *ROTARY INERTIA of every point element, got none of {len(left)}; add it"
            )

    def _groups(
        self,
        shape: Indices,
        row: Indices,
        sections: Mapping[tuple[str, str], Sequence[RawSection]],
        nonstructural_of: Mapping[tuple[str, str], Sequence[RawNonstructural]],
    ) -> Iterator[RawGroup]:
        """Groups of all sets with their sections; a name that several scopes use has the instance in front of it."""
        scopes = [
            {name.casefold() for names in both for name, _ in names.items()}
            for both in zip(self._node_names, self._element_names, strict=True)
        ]
        times = Counter(name for scope in scopes for name in scope)
        for placement, nodes, elements in zip(self._placements, self._node_names, self._element_names, strict=True):
            for names, of_nodes in ((elements, False), (nodes, True)):
                for name, rows in names.items():
                    long = placement.name and times[name.casefold()] > 1
                    found = {"nodes": rows} if of_nodes else _by_shape(shape[rows], row[rows])
                    key = placement.name, name.casefold()
                    own = () if of_nodes else tuple(sections.get(key, ()))
                    more = () if of_nodes else tuple(nonstructural_of.get(key, ()))
                    full = f"{placement.name}.{name}" if long else name
                    yield RawGroup(full, found, sections=own, nonstructural=more)


def _by_shape(shape: Indices, row: Indices) -> dict[str, Indices]:
    return {name: row[shape == place] for place, name in enumerate(SHAPES) if (shape == place).any()}
