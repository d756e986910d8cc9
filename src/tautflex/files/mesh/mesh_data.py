"""A mesh whose groups have a meaning, ready to become a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import Support
from tautflex.structure.links.link import Link
from tautflex.structure.masses import PointMass
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection
from tautflex.structure.model import Model
from tautflex.structure.springs import Spring
from tautflex.text import brief

ELEMENTS = ("triangles", "quads", "cables", "beams")


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
    links, springs
        What joins nodes beside elements.
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
        membrane: MembraneSection | None = None,
        cable: CableSection | None = None,
        beam: BeamSection | None = None,
        **given: Any,
    ) -> Model:
        """Build the structure; everything else is passed on to `Model.from_mesh`.

        Parameters
        ----------
        membrane, cable, beam
            Section of each kind that the mesh has.
        **given
            Prestress, orientations, prestress mode; ``supports``, ``masses``, ``links``, ``springs`` and
            ``beam_orientation`` replace those of the file.

        Raises
        ------
        MeshError
            If the mesh is degenerate or disconnected.
        InputError
            If a section is missing or a value is unusable.
        """
        if self.beam_orientation is not None:
            given = {"beam_orientation": self.beam_orientation, **given}
        return Model.from_mesh(
            self.nodes,
            triangles=self.triangles,
            quads=self.quads,
            membrane=membrane,
            cables=self.cables,
            cable=cable,
            beams=self.beams,
            beam=beam,
            **{name: getattr(self, name) for name in ("supports", "masses", "links", "springs") if name not in given},
            **given,
        )
