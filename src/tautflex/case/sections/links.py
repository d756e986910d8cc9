"""Sections [[links]], [[springs]] and [[dampers]] of a case file: what joins nodes beside elements."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, Strict, model_validator

from tautflex.case.messages import show
from tautflex.case.options import Chosen
from tautflex.case.registry import LINKS
from tautflex.case.section import Number, Section, Vector, key
from tautflex.case.sections.inputs import ChosenNodes, Placed, Point, nearest_node
from tautflex.errors import CaseError
from tautflex.structure.springs import Damper as DamperElement
from tautflex.structure.springs import Spring as SpringElement

Node = Annotated[int, Strict(), Field(ge=0)]


class Link(Placed):
    """Displacements that follow others: rigid parts, ties, couplings, cable ends on the film, or a link of yours."""

    registry = LINKS

    @classmethod
    def parts_for(cls, kind: str, target: type) -> tuple[type[Chosen], ...]:
        """Nodes and the reference, which a case may know no numbers of, may be chosen by place."""
        names = {field.name for field in dataclasses.fields(target)}
        first: tuple[type[Chosen], ...] = (_Joined,) if "reference" in names else (ChosenNodes,)
        return (*(first if "nodes" in names else ()), cls)


class _Joined(ChosenNodes):
    """A reference and other nodes by number or place."""

    optional_keys = ("nodes", "reference")
    reference_near: Point | None = key("point whose nearest node is the reference [m]", (1.25, 0.75), None)

    def check_values(self) -> None:
        if (self.reference is None) == (self.reference_near is None):
            got = "neither" if self.reference is None else f"both, {self.reference} and {show(self.reference_near)}"
            raise CaseError(f"reference: expected its number, or a point near it under reference_near, got {got}")
        if self.reference is None:
            self.require_one_choice()
        else:
            super().check_values()

    def known(self, model: Any) -> dict[str, Any]:
        found = super().known(model)
        if self.reference_near is not None:
            found["reference"] = nearest_node(model, np.asarray(self.reference_near, dtype=float))
        return found


class _Between(Section):
    """Two nodes, or one and the floating frame, by number or place."""

    nodes: tuple[Node, ...] | None = key("numbers of the nodes, from 0", (12, 40), None)
    near: Point | tuple[Point, ...] | None = key(
        "point, or two points, whose nearest nodes are meant [m]", ((1.25, 0.75), (1.0, 0.5)), None
    )
    axes: tuple[Vector, Vector, Vector] | None = key(
        "directions x, y, z that are meant, the frame's if not given",
        ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        None,
    )
    place: Number | None = key("where it acts between two nodes, from 0 to 1, with rigid arms to both", 0.5, None)

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.nodes is None) == (self.near is None):
            got = "neither" if self.nodes is None else f"nodes = {show(self.nodes)} and near = {show(self.near)}"
            raise ValueError(f"near: expected points near nodes, or their numbers under nodes, got {got}; give one")
        return self

    def found(self, model: Any) -> tuple[int, ...]:
        """Numbers of the nodes; CaseError if none is near."""
        if self.nodes is not None:
            return self.nodes
        return tuple(nearest_node(model, point) for point in np.atleast_2d(np.asarray(self.near, dtype=float)))


class Spring(_Between):
    """Linear spring without mass between two nodes, or between one and the floating frame."""

    stiffness: Number | tuple[Number, ...] = key(
        "along the line between two nodes; or along x, y, z [N/m], or also about them [N m/rad]", (100.0, 0.0, 0.0)
    )

    def placed(self, model: Any) -> SpringElement:
        """Make it for a structure; CaseError if no node is near."""
        return SpringElement(self.found(model), self.stiffness, self.axes, self.place)


class Damper(_Between):
    """Viscous damper (dashpot) between two nodes, or between one and the floating frame; beside [damping]."""

    damping: Number | tuple[Number, ...] = key(
        "along the line between two nodes; or along x, y, z [N s/m], or also about them [N m s/rad]", (0.1, 0.0, 0.0)
    )

    def placed(self, model: Any) -> DamperElement:
        """Make it for a structure; CaseError if no node is near."""
        return DamperElement(self.found(model), self.damping, self.axes, self.place)
