"""The structure as frozen data: nodes, groups of elements, supports and prestress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError, MeshError
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup, Support
from tautflex.structure.links.link import Link
from tautflex.structure.masses import PointMass
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection, section_runs
from tautflex.structure.mesh import blend_by_direction, check_elements, check_joints, connected_pieces
from tautflex.structure.numbering import Numbering
from tautflex.structure.shapes import LINE2, QUAD4, TRIANGLE3, TRIANGLE6, Shape, surface_shape
from tautflex.structure.springs import Damper, Spring
from tautflex.text import card, count

_SUPPORT = "Support.clamped([0])"
_MASS = "PointMass(node, mass=2.5)"
_LINK = "RigidLink(reference=0, nodes=(5,))"
_SPRING = "Spring((0, 5), stiffness=100.0)"
_DAMPER = "Damper((0, 5), damping=0.1)"
_SELECTIONS = "a mapping such as {'boom': {'nodes': [0, 1], 'beams': [4]}}"
PRESTRESS_MODES = ("equilibrium", "uniform", "initial-strain")


@dataclass(frozen=True)
class Model(Numbering):
    """Tensioned structure in its reference configuration; build it with `from_mesh` or from a case.

    ``prestress_stated`` tells whether the mode was chosen: its imbalance is then meant, and noted instead of warned of.
    ``selections`` are rows of ``"nodes"``, ``"cables"`` and so on under the names of a mesh file.
    """

    prestress_mode: str = "uniform"
    prestress_stated: bool = True
    selections: Mapping[str, Mapping[str, Indices]] = field(default_factory=dict, compare=False)

    @classmethod
    def from_mesh(
        cls,
        nodes: ArrayLike,
        *,
        triangles: ArrayLike | None = None,
        quads: ArrayLike | None = None,
        surfaces: Mapping[str, ArrayLike] | None = None,
        membrane: MembraneSection | Sequence[MembraneSection] | None = None,
        membrane_stress: ArrayLike = (0.0, 0.0, 0.0),
        membrane_orientation: ArrayLike = (1.0, 0.0, 0.0),
        cables: ArrayLike | None = None,
        cable: CableSection | Sequence[CableSection] | None = None,
        cable_tension: ArrayLike = 0.0,
        beams: ArrayLike | None = None,
        beam: BeamSection | Sequence[BeamSection] | None = None,
        beam_axial_force: ArrayLike = 0.0,
        beam_orientation: ArrayLike = (0.0, 0.0, 1.0),
        supports: Sequence[Support] = (),
        masses: Sequence[PointMass] = (),
        links: Sequence[Link] = (),
        springs: Sequence[Spring] = (),
        dampers: Sequence[Damper] = (),
        prestress_mode: str | None = None,
        selections: Mapping[str, Mapping[str, Indices]] | None = None,
    ) -> Model:
        """Build a model from any film elements, cables and beams in space.

        Parameters
        ----------
        nodes
            Positions in the floating frame [m], shape (node, 3).
        triangles, quads
            Node numbers of the film's elements from 0, shapes (t, 3) or (t, 6), and (t, 4); corners counter-clockwise,
            then the nodes in the middle of the sides, the first between corners 1 and 2.
        surfaces
            More film elements by the name of their shape, e.g. one registered by an element from outside.
        cables, beams
            Node numbers from 0, shapes (c, 2), (b, 2).
        membrane, cable, beam
            Section of each kind that is present: one for all its elements, or a sequence with one for each, the film's
            in the order of these arguments. Elements in a row that have the same are computed together.
        membrane_stress
            Given stress (sx, sy, txy) in the film's local axes [Pa], shape (3,) or (t, 3), the film's elements in
            the order of these arguments.
        membrane_orientation
            Direction whose projection on the film is its local x axis, shape (3,).
        cable_tension
            Pretension [N], scalar or shape (c,).
        beam_axial_force
            Given initial axial force, tension positive [N], scalar or shape (b,).
        beam_orientation
            Direction whose part normal to a beam is its local z axis, shape (3,) or (b, 3).
        supports
            Held nodes.
        masses
            Rigid bodies at nodes.
        links
            Displacements that follow others: `RigidLink`, `Tie`, `DistributingLink`, `Attachment`, `LinkEquation`.
        springs, dampers
            Springs and viscous dampers between nodes or to the floating frame.
        prestress_mode
            ``"uniform"``: the given stresses are the state, their imbalance carried by the reference;
            ``"equilibrium"``: cable tensions are final, film and beams respond; ``"initial-strain"``: cables
            are shortened to their tension between rigid ends, then everything relaxes (theory.md 5). None is
            ``"uniform"`` with a warning where the given stresses are far from balance.
        selections
            Rows of ``"nodes"``, ``"cables"`` and so on under names, by which cases choose them.

        Returns
        -------
        Model

        Raises
        ------
        MeshError
            If the mesh is degenerate, disconnected or refers to missing nodes.
        InputError
            If an argument has the wrong shape or value.

        Examples
        --------
        >>> import numpy as np
        >>> import tautflex as tf
        >>> nodes = np.column_stack([np.linspace(0.0, 1.0, 101), np.zeros((101, 2))])
        >>> rope = tf.CableSection(tf.Material(70e9, 1000.0), area=1e-6)                  # 1 g/m
        >>> string = tf.Model.from_mesh(nodes, cables=[(k, k + 1) for k in range(100)], cable=rope, cable_tension=10.0,
        ...                             supports=[tf.Support.pinned([0, 100])])
        >>> round(float(tf.solve_modes(tf.solve_prestress(string), n=1).frequencies[0]), 1)  # 100 m/s over twice 1 m
        50.0
        """
        points = checks.float_array("nodes", nodes, (None, 3), error=MeshError)
        film = _surface_elements(triangles, quads, {} if surfaces is None else surfaces, len(points))
        count = sum(len(elements) for _, elements in film)
        stress = checks.spread("membrane_stress", membrane_stress, count, 3)
        groups, first = [], 0
        for shape, elements in film:
            direction = checks.vector3("membrane_orientation", membrane_orientation)
            own = stress[first : first + len(elements)]
            runs = section_runs("membrane", membrane, MembraneSection, f"{shape.domain}s", first, len(elements))
            groups += [ElementGroup(section, shape, elements[rows], own[rows], direction) for section, rows in runs]
            first += len(elements)
        for name, lines, given, kind, load, initial, orientation in (
            ("cables", cables, cable, CableSection, "cable_tension", cable_tension, (0.0, 0.0, 1.0)),
            ("beams", beams, beam, BeamSection, "beam_axial_force", beam_axial_force, beam_orientation),
        ):
            elements = checks.index_array(name, () if lines is None else lines, 2, len(points), error=MeshError)
            if not len(elements):
                continue
            values = checks.spread(load, initial, len(elements))[:, None]
            direction = _directions("beam_orientation", orientation, len(elements))
            groups += [
                ElementGroup(
                    section, LINE2, elements[rows], values[rows], direction if direction.ndim == 1 else direction[rows]
                )
                for section, rows in section_runs(kind.kind, given, kind, name, 0, len(elements))
            ]
        held, stated = checks.several("supports", supports, Support, _SUPPORT), prestress_mode is not None
        return cls(
            points,
            tuple(groups),
            held,
            "uniform" if prestress_mode is None else prestress_mode,
            stated,
            masses=checks.several("masses", masses, PointMass, _MASS),
            links=checks.several("links", links, Link, _LINK),
            springs=checks.several("springs", springs, Spring, _SPRING),
            dampers=checks.several("dampers", dampers, Damper, _DAMPER),
            selections={} if selections is None else selections,
        )

    def __post_init__(self) -> None:
        checks.one_of("prestress_mode", self.prestress_mode, PRESTRESS_MODES)
        checks.several("supports", self.supports, Support, _SUPPORT)
        checks.several("masses", self.masses, PointMass, _MASS)
        checks.several("links", self.links, Link, _LINK)
        checks.several("springs", self.springs, Spring, _SPRING)
        checks.several("dampers", self.dampers, Damper, _DAMPER)
        checks.several("groups", self.groups, ElementGroup, "those that Model.from_mesh makes")
        checks.float_array("nodes", self.nodes, (None, 3), error=MeshError)
        for group in self.groups:
            name = f"{group.section.kind if group.shape.dimension == 1 else group.shape.domain}s"
            check_elements(name, group.shape, self.nodes, group.connectivity)
        check_joints([(group.shape, group.connectivity) for group in self.surfaces])
        checks.indices("masses", [body.node for body in self.masses], len(self.nodes), error=MeshError)
        for name in ("links", "springs", "dampers"):
            for number, one in enumerate(getattr(self, name)):
                checks.indices(f"{name}[{number}]", one.joined, len(self.nodes), error=MeshError)
        for support in self.supports:
            checks.indices("supports", support.nodes, len(self.nodes), error=MeshError)
        for name, parts in checks.instance("selections", self.selections, Mapping, _SELECTIONS).items():
            for part, rows in checks.instance(f"selections[{name!r}]", parts, Mapping, _SELECTIONS).items():
                count = len(self.nodes) if part == "nodes" else sum(len(group.connectivity) for group in self.groups)
                checks.indices(f"selections[{name!r}][{part!r}]", rows, count, part, error=MeshError)
        connectivity = [group.connectivity for group in self.groups]
        pieces = connected_pieces(len(self.nodes), connectivity, self.linked_pairs)
        self._require_held(pieces)
        for name in ("springs", "dampers"):
            for number, joint in enumerate(getattr(self, name)):
                joint.axes_at(self.nodes)
                still = [node for node in joint.joined if self.dof_offset[node + 1] - self.dof_offset[node] < 6]
                still = [node for node in still if not np.isin(self.translation_dofs[node], self.fixed_dofs).all()]
                if joint.turns and still:
                    raise MeshError(
                        f"{name}[{number}]: expected nodes that turn, got node {still[0]}, which no beam or rigid link "
                        f"turns; leave out {joint.quantity} about axes, and place"
                    )
        for body in self.masses:
            if body.turns and self.dof_offset[body.node + 1] - self.dof_offset[body.node] < 6:
                raise MeshError(
                    f"masses: expected a body without inertia and offset at node {body.node}, which no beam turns, got "
                    f"inertia {body.tensor.tolist()} and offset {body.arm.tolist()}; place it on a beam"
                )

    def _require_held(self, piece: Indices) -> None:
        """One piece may be free; of several, each must be held."""
        sizes = np.bincount(piece)
        for number in np.argsort(sizes, kind="stable") if len(sizes) > 1 else ():
            free = self.freedom_of(piece == number)
            if free:
                raise MeshError(
                    f"mesh: expected one connected structure, got {len(sizes)} pieces, of which the supports leave one "
                    f"({sizes[number]} node(s), e.g. node {int(np.flatnonzero(piece == number)[0])}) {free} rigid "
                    "motions free; merge duplicate nodes, join the pieces with cables or beams, or hold each of them"
                )

    def __repr__(self) -> str:
        elements = [
            count(
                group.connectivity, group.section.kind if group.shape.dimension == 1 else f"film {group.shape.domain}"
            )
            for group in self.groups
        ]
        size = " x ".join(f"{side:.4g}" for side in np.ptp(self.nodes, axis=0))
        held = count(np.unique(np.concatenate([[], *(support.nodes for support in self.supports)])), "node")
        carried = sum(body.mass for body in self.masses)
        bodies = {"masses": f"{carried:.4g} kg in {len(self.masses)} of its nodes"} if self.masses else {}
        if self.links:
            bodies["links"] = f"{count(self.links, 'link')}, {len(self.constraints.dependent)} unknowns follow"
        bodies |= {name: str(len(own)) for name in ("springs", "dampers") if (own := getattr(self, name))}
        lines = {
            "nodes": len(self.nodes),
            "unknowns": len(self.free_dofs),
            "elements": ", ".join(elements),
            **bodies,
            "size": f"{size} m",
            "mass": f"{self.mass:.4g} kg",
            "supports": f"{held} held" + (f", {self.rigid_freedom} rigid motions free" if self.rigid_freedom else ""),
            "prestress": self.prestress_mode,
        }
        return card(self, lines)

    @property
    def linked_pairs(self) -> Indices:
        """Pairs of nodes that links and springs join, shape (pair, 2)."""
        joined = [(spring.nodes[0], node) for spring in self.springs for node in spring.nodes[1:]]
        owner = np.repeat(np.arange(len(self.nodes)), np.diff(self.dof_offset))
        if not self.links:
            return np.reshape(joined, (-1, 2)).astype(np.int64)
        follows = self.constraints.dependent
        leads = self.constraints.matrix[follows].tocoo()
        pairs = np.stack([owner[follows][leads.row], owner[leads.col]], axis=1)
        return np.concatenate([pairs, np.reshape(joined, (-1, 2)).astype(np.int64)])

    @property
    def surfaces(self) -> tuple[ElementGroup, ...]:
        """Groups of film elements, in order."""
        return tuple(group for group in self.groups if group.shape.dimension == 2)

    @cached_property
    def triangles(self) -> Indices:
        """Linear triangles that stand for the film in pictures, shape (t, 3); its elements, where they are such."""
        return self._split_surfaces[0]

    @cached_property
    def triangle_owner(self) -> Indices:
        """Film element that each of `triangles` belongs to, numbered through `surfaces`, shape (t,)."""
        return self._split_surfaces[1]

    @cached_property
    def _split_surfaces(self) -> tuple[Indices, Indices]:
        cells, owners, first = [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)], 0
        for group in self.surfaces:
            split, owner = group.shape.split_elements(group.connectivity)
            cells.append(split)
            owners.append(first + owner)
            first += len(group.connectivity)
        return np.concatenate(cells), np.concatenate(owners)

    @property
    def membrane_count(self) -> int:
        """Number of film elements."""
        return sum(len(group.connectivity) for group in self.surfaces)

    @cached_property
    def cables(self) -> Indices:
        """Node numbers of the cables, shape (c, 2)."""
        return self._lines("cable")

    @cached_property
    def beams(self) -> Indices:
        """Node numbers of the beams, shape (b, 2)."""
        return self._lines("beam")

    def _lines(self, kind: str) -> Indices:
        found = [group.connectivity for group in self.groups if group.section.kind == kind]
        return np.concatenate([np.zeros((0, 2), dtype=np.int64), *found])

    def centre(self, kind: str, element: int) -> Array:
        """Mean of an element's nodes [m], shape (3,); elements are numbered through all groups of their kind.

        The place of a node, if the kind is ``"linked node"``.
        """
        if kind == "linked node":
            return np.asarray(self.nodes[element])
        for group in self.groups:
            if group.section.kind == kind:
                if element < len(group.connectivity):
                    return np.asarray(self.nodes[group.connectivity[element]].mean(axis=0))
                element -= len(group.connectivity)
        raise IndexError(f"no {kind} {element}")

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return sum(
            (
                group.section.mass_per_measure * float(group.shape.measure(self.nodes[group.connectivity]).sum())
                for group in self.groups
            ),
            float(sum(body.mass for body in self.masses)),
        )

    def with_pretension_scaled(self, scale_x: float, scale_y: float) -> Model:
        """Copy with the prestress along x and y multiplied by two factors.

        Cables and beams take the factor of their direction (squared cosines), films sx, sy and the geometric
        mean for the shear.
        """
        groups = []
        for group in self.groups:
            if group.shape.dimension == 2:
                factor = np.array([scale_x, scale_y, np.sqrt(abs(scale_x * scale_y))])
            else:
                factor = blend_by_direction(self.nodes, group.connectivity, scale_x, scale_y)[:, None]
            groups.append(replace(group, initial=group.initial * factor))
        return replace(self, groups=tuple(groups))


def _directions(name: str, value: ArrayLike, count: int) -> Array:
    """One direction for all elements, shape (3,), or one for each, shape (count, 3); none of length 0."""
    if checks.numbers(name, value).ndim != 2:
        return checks.vector3(name, value)
    each = checks.float_array(name, value, (count, 3))
    short = np.flatnonzero(np.linalg.norm(each, axis=1) == 0.0)
    if short.size:
        raise InputError(f"{name}: expected directions, got one of length 0 for element {short[0]}; give each a length")
    return each


def _surface_elements(
    triangles: ArrayLike | None, quads: ArrayLike | None, surfaces: Mapping[str, ArrayLike], node_count: int
) -> list[tuple[Shape, Indices]]:
    """Checked node numbers of the film's elements by shape."""
    checks.instance("surfaces", surfaces, Mapping, "a mapping from names of shapes to node numbers")
    six = triangles is not None and np.shape(checks.numbers("triangles", triangles, error=MeshError))[-1:] == (6,)
    corners = TRIANGLE6 if six else TRIANGLE3
    given = [("triangles", corners, triangles), ("quads", QUAD4, quads)]
    for name, elements in surfaces.items():
        given.append((f"surfaces[{name!r}]", surface_shape("surfaces", name), elements))
    return [
        (shape, checks.index_array(name, elements, len(shape.nodes), node_count, error=MeshError))
        for name, shape, elements in given
        if elements is not None and np.size(checks.numbers(name, elements, error=MeshError))
    ]
