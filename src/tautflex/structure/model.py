"""The structure as frozen data: nodes, groups of elements, supports, prestress and the numbering of its unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import MeshError
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection, Section, require_section
from tautflex.structure.mesh import check_connected, check_lines, check_triangles

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
PRESTRESS_MODES = ("equilibrium", "uniform", "initial-strain")


@dataclass(frozen=True)
class ElementGroup:
    """Elements of one kind and one section.

    Parameters
    ----------
    section
        Membrane, cable or beam section.
    connectivity
        Node numbers, shape (element, corner).
    initial
        Prestress of each element: membrane stress (sx, sy, txy) in local axes [Pa], shape (element, 3); cable
        tension [N], shape (element, 1); beam axial force [N], shape (element, 1).
    orientation
        Direction that fixes the local axes: local x of a membrane is its projection on the film; local z of a
        beam is its part normal to the beam.
    """

    section: Section
    connectivity: NDArray[np.int64]
    initial: NDArray[np.float64]
    orientation: NDArray[np.float64]


@dataclass(frozen=True)
class Support:
    """Nodes held in given directions of the floating frame.

    Parameters
    ----------
    nodes
        Node numbers.
    directions
        Any of ``"x", "y", "z", "rx", "ry", "rz"``; rotations are ignored at nodes that have none.
    """

    nodes: tuple[int, ...]
    directions: tuple[str, ...] = DIRECTIONS

    @classmethod
    def clamped(cls, nodes: ArrayLike) -> Support:
        """Hold all six directions of ``nodes``."""
        return cls(tuple(int(i) for i in np.atleast_1d(np.asarray(nodes))))

    @classmethod
    def pinned(cls, nodes: ArrayLike) -> Support:
        """Hold the three translations of ``nodes``."""
        return cls(tuple(int(i) for i in np.atleast_1d(np.asarray(nodes))), DIRECTIONS[:3])


@dataclass(frozen=True)
class Model:
    """Tensioned structure in its reference configuration; build it with `from_mesh` or from a case.

    Unknowns are numbered node by node: three translations, then three rotations at nodes that carry beams.
    """

    nodes: NDArray[np.float64]
    groups: tuple[ElementGroup, ...]
    supports: tuple[Support, ...] = ()
    prestress_mode: str = "uniform"

    @classmethod
    def from_mesh(
        cls,
        nodes: ArrayLike,
        *,
        triangles: ArrayLike | None = None,
        membrane: MembraneSection | None = None,
        membrane_stress: ArrayLike = (0.0, 0.0, 0.0),
        membrane_orientation: ArrayLike = (1.0, 0.0, 0.0),
        cables: ArrayLike | None = None,
        cable: CableSection | None = None,
        cable_tension: ArrayLike = 0.0,
        beams: ArrayLike | None = None,
        beam: BeamSection | None = None,
        beam_axial_force: ArrayLike = 0.0,
        beam_orientation: ArrayLike = (0.0, 0.0, 1.0),
        supports: Sequence[Support] = (),
        prestress_mode: str = "uniform",
    ) -> Model:
        """Build a model from any triangles, cables and beams in space.

        Parameters
        ----------
        nodes
            Positions in the floating frame [m], shape (node, 3).
        triangles, cables, beams
            Node numbers from 0, shapes (t, 3), (c, 2), (b, 2).
        membrane, cable, beam
            Section of each kind that is present.
        membrane_stress
            Given stress (sx, sy, txy) in the film's local axes [Pa], shape (3,) or (t, 3).
        membrane_orientation
            Direction whose projection on the film is its local x axis, shape (3,).
        cable_tension
            Pretension [N], scalar or shape (c,).
        beam_axial_force
            Given initial axial force, tension positive [N], scalar or shape (b,).
        beam_orientation
            Direction whose part normal to a beam is its local z axis, shape (3,).
        supports
            Held nodes.
        prestress_mode
            ``"uniform"``: the given stresses are the state, their imbalance carried by the reference;
            ``"equilibrium"``: cable tensions are final, film and beams respond; ``"initial-strain"``: cables
            are shortened to their tension between rigid ends, then everything relaxes (theory.md 5).

        Returns
        -------
        Model

        Raises
        ------
        MeshError
            If the mesh is degenerate, disconnected or refers to missing nodes.
        InputError
            If an argument has the wrong shape or value.
        """
        points = checks.float_array("nodes", nodes, (None, 3), error=MeshError)
        groups = []
        for name, connectivity, section, kind, initial, width, orientation in (
            ("triangles", triangles, membrane, MembraneSection, membrane_stress, 3, membrane_orientation),
            ("cables", cables, cable, CableSection, cable_tension, 1, (0.0, 0.0, 1.0)),
            ("beams", beams, beam, BeamSection, beam_axial_force, 1, beam_orientation),
        ):
            if connectivity is None or not np.size(connectivity):
                continue
            require_section(name, section, kind)
            assert section is not None
            elements = checks.index_array(name, connectivity, section.corners, len(points), error=MeshError)
            values = np.asarray(initial, dtype=float)
            values = values.reshape(-1, 1) if width == 1 else values
            values = np.array(np.broadcast_to(values, (len(elements), width)))
            checks.float_array(f"prestress of {name}", values, (len(elements), width))
            groups.append(ElementGroup(section, elements, values, checks.vector3("orientation", orientation)))
        return cls(points, tuple(groups), tuple(supports), prestress_mode)

    def __post_init__(self) -> None:
        checks.one_of("prestress_mode", self.prestress_mode, PRESTRESS_MODES)
        check_triangles(self.nodes, self.triangles)
        check_lines("cables", self.nodes, self.cables)
        check_lines("beams", self.nodes, self.beams)
        check_connected(len(self.nodes), [group.connectivity for group in self.groups])
        for support in self.supports:
            checks.index_array("supports", np.reshape(support.nodes, (-1, 1)), 1, len(self.nodes), error=MeshError)
            for direction in support.directions:
                checks.one_of("support direction", direction, DIRECTIONS)

    def _connectivity(self, kind: str, corners: int) -> NDArray[np.int64]:
        found = [group.connectivity for group in self.groups if group.section.kind == kind]
        return np.concatenate(found) if found else np.zeros((0, corners), dtype=np.int64)

    @cached_property
    def triangles(self) -> NDArray[np.int64]:
        """Node numbers of the film's elements, shape (t, 3)."""
        return self._connectivity("membrane", 3)

    @cached_property
    def cables(self) -> NDArray[np.int64]:
        """Node numbers of the cables, shape (c, 2)."""
        return self._connectivity("cable", 2)

    @cached_property
    def beams(self) -> NDArray[np.int64]:
        """Node numbers of the beams, shape (b, 2)."""
        return self._connectivity("beam", 2)

    @cached_property
    def dof_offset(self) -> NDArray[np.int64]:
        """First unknown of each node, shape (node + 1,); the last entry is the number of unknowns."""
        per_node = np.full(len(self.nodes), 3)
        for group in self.groups:
            if group.section.rotational:
                per_node[group.connectivity] = 6
        return np.concatenate([[0], np.cumsum(per_node)])

    @property
    def dof_count(self) -> int:
        """Number of unknowns before supports are applied."""
        return int(self.dof_offset[-1])

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        total = 0.0
        for group in self.groups:
            corners = self.nodes[group.connectivity]
            first = corners[:, 1] - corners[:, 0]
            if group.section.kind == "membrane":
                measure = 0.5 * np.linalg.norm(np.cross(first, corners[:, 2] - corners[:, 0]), axis=1)
            else:
                measure = np.linalg.norm(first, axis=1)
            total += group.section.mass_per_measure * float(measure.sum())
        return total

    def element_dofs(self, group: ElementGroup) -> NDArray[np.int64]:
        """Unknowns of each element, shape (element, 3 or 6 per corner)."""
        count = 6 if group.section.rotational else 3
        first = self.dof_offset[group.connectivity]
        return (first[:, :, None] + np.arange(count)).reshape(len(first), -1)

    @cached_property
    def translation_dofs(self) -> NDArray[np.int64]:
        """Unknowns of the three translations of each node, shape (node, 3)."""
        return self.dof_offset[:-1, None] + np.arange(3)

    @cached_property
    def fixed_dofs(self) -> NDArray[np.int64]:
        """Unknowns held by supports, sorted."""
        fixed: set[int] = set()
        for support in self.supports:
            for direction in support.directions:
                step = DIRECTIONS.index(direction)
                for node in support.nodes:
                    dof = int(self.dof_offset[node]) + step
                    if dof < self.dof_offset[node + 1]:
                        fixed.add(dof)
        return np.array(sorted(fixed), dtype=np.int64)

    @cached_property
    def free_dofs(self) -> NDArray[np.int64]:
        """Unknowns that can move, sorted."""
        return np.setdiff1d(np.arange(self.dof_count), self.fixed_dofs)

    @cached_property
    def rigid_motions(self) -> NDArray[np.float64]:
        """Infinitesimal rigid motions about the origin, shape (dof, 6): three translations, three rotations."""
        motions = np.zeros((self.dof_count, 6))
        x, y, z = self.nodes.T
        dofs = self.translation_dofs
        for axis in range(3):
            motions[dofs[:, axis], axis] = 1.0
        motions[dofs[:, 1], 3], motions[dofs[:, 2], 3] = -z, y
        motions[dofs[:, 0], 4], motions[dofs[:, 2], 4] = z, -x
        motions[dofs[:, 0], 5], motions[dofs[:, 1], 5] = -y, x
        turning = np.flatnonzero(np.diff(self.dof_offset) == 6)
        for axis in range(3):
            motions[self.dof_offset[turning] + 3 + axis, 3 + axis] = 1.0
        return motions

    @property
    def rigid_freedom(self) -> int:
        """Number of independent rigid motions that the supports leave free."""
        motions = self.rigid_motions / max(1.0, float(np.abs(self.nodes).max()))
        held = motions[self.fixed_dofs]
        rank = int(np.linalg.matrix_rank(held, tol=1e-9)) if held.size else 0
        return int(np.linalg.matrix_rank(motions, tol=1e-9)) - rank

    def with_pretension_scaled(self, scale_x: float, scale_y: float) -> Model:
        """Copy with the prestress along x and y multiplied by two factors.

        Cables and beams take the factor of their direction (squared cosines), films sx, sy and the geometric
        mean for the shear.
        """
        groups = []
        for group in self.groups:
            if group.section.kind == "membrane":
                factor = np.array([scale_x, scale_y, np.sqrt(abs(scale_x * scale_y))])
            else:
                ends = self.nodes[group.connectivity]
                along = (ends[:, 1] - ends[:, 0]) ** 2
                weight_x = along[:, :1] / along.sum(axis=1, keepdims=True)
                factor = scale_x * weight_x + scale_y * (1.0 - weight_x)
            groups.append(replace(group, initial=group.initial * factor))
        return replace(self, groups=tuple(groups))
