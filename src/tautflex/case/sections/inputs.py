"""Sections [inputs.NAME] of a case file: what acts on the structure in time; each input's class is its own section."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from tautflex.case.messages import show
from tautflex.case.options import Chosen
from tautflex.case.registry import INPUTS
from tautflex.case.section import Number, key
from tautflex.errors import CaseError
from tautflex.mechanics.loads.effects.cables import cables_along
from tautflex.mechanics.loads.inputs import Effect
from tautflex.numeric import Array, Indices

if TYPE_CHECKING:
    from tautflex.structure.model import Model

Side = Literal["-x", "+x", "-y", "+y"]
Point = tuple[Number, Number] | tuple[Number, Number, Number]


class Placed(Chosen):
    """What acts somewhere on the structure."""

    @classmethod
    def parts_for(cls, kind: str, target: type) -> tuple[type[Chosen], ...]:
        """Nodes and cables, which a case knows no numbers of, may be chosen by place, or by names of a mesh file."""
        names = {field.name for field in dataclasses.fields(target)}
        return (*((ChosenNodes,) if "nodes" in names else ()), *((_Cables,) if "cables" in names else ()), cls)

    def placed(self, model: Model) -> Any:
        """Make it for a model.

        Raises
        ------
        CaseError
            If the class refuses the values, or nothing stands where the case says; the message begins with the key.
        """
        return self.build()


class Input(Placed):
    """Force, tension, temperature, electric field or an input of yours in time: a number, a vector, or a table."""

    registry = INPUTS

    @classmethod
    def needed_keys(cls, target: type) -> tuple[str, ...]:
        """The signal: an input in time has no one else who commands it."""
        return (target.signal,) if issubclass(target, Effect) else ()


class ChosenNodes(Chosen):
    """Nodes by number or place."""

    optional_keys: ClassVar[tuple[str, ...]] = ("nodes",)
    near: Point | tuple[Point, ...] | None = key(
        "point, or list of points, whose nearest nodes are meant [m]", (0.5, 0.2), None
    )
    side: Side | None = key("side of the film whose nodes are meant", "+x", None)
    group: str | None = key("group of the mesh file whose nodes are meant, those of its elements too", "tips", None)

    def require_one_choice(self) -> None:
        """Raise CaseError unless the nodes are said in one way."""
        given = [name for name in ("nodes", "near", "side", "group") if getattr(self, name) is not None]
        if not given:
            text = f"nodes: missing, {self.choice()} expects nodes, near, side or group"
            raise CaseError(f"{text}; add for example near = [0.5, 0.2]")
        if len(given) > 1:
            value = show(getattr(self, given[1]))
            raise CaseError(f"{given[1]}: expected no value beside {given[0]}, got {value}; keep one of the two")

    def check_values(self) -> None:
        """Raise CaseError unless the nodes are said in one way and the class takes the values."""
        self.require_one_choice()
        if self.nodes is not None:
            super().check_values()

    def known(self, model: Model) -> dict[str, Any]:
        """What the places stand for in a structure."""
        if self.near is not None:
            points = np.atleast_2d(np.asarray(self.near, dtype=float))
            return {"nodes": tuple(nearest_node(model, point) for point in points)}
        if self.group is not None:
            return {"nodes": _nodes_of_group(model, self.group)}
        return {} if self.side is None else {"nodes": _nodes_of_side(model, self.side)}

    def placed(self, model: Model) -> Any:
        """Make it for a model."""
        return self.build(**self.known(model))


class _Cables(Chosen):
    """Cables by number, side or group."""

    side: Side | None = key("side of the film whose cables are meant; all if not given", "+x", None)
    group: str | None = key("group of the mesh file whose cables are meant", "pid2", None)

    def check_values(self) -> None:
        given = [name for name in ("cables", "side", "group") if getattr(self, name) is not None]
        if len(given) > 1:
            value = show(getattr(self, given[1]))
            raise CaseError(f"{given[1]}: expected no value beside {given[0]}, got {value}; keep one of the two")
        super().check_values()

    def placed(self, model: Model) -> Any:
        if self.group is not None:
            return self.build(cables=_rows_of_group(model, self.group, "cables"))
        if self.side is None:
            return self.build()
        return self.build(cables=_cables_of_side(model, self.side))


class ChosenPoints(Chosen):
    """Points by place, or by the nodes that stand there."""

    optional_keys: ClassVar[tuple[str, ...]] = ("points",)
    group: str | None = key(
        "group of the mesh file whose nodes are the points, those of its elements too", "tips", None
    )

    def check_values(self) -> None:
        """Raise CaseError unless the points are said in one way and the class takes the values."""
        if self.points is not None and self.group is not None:
            raise CaseError(f"group: expected no value beside points, got {show(self.group)}; keep one of the two")
        if self.points is None and self.group is None:
            text = f"points: missing, {self.choice()} expects points or group"
            raise CaseError(f"{text}; add for example points = [[0.5, 0.2]]")
        if self.group is None:
            super().check_values()

    def placed(self, model: Model) -> Any:
        """Make it for a model."""
        if self.group is None:
            return self.build()
        nodes = _nodes_of_group(model, self.group)
        for node in nodes:
            first = int(np.linalg.norm(model.nodes - model.nodes[node], axis=1).argmin())
            if first != node:
                raise CaseError(
                    f"group: expected nodes that stand alone where they are, got {show(self.group)}, whose node {node} "
                    f"shares its place with node {first}; name another group, or place points"
                )
        return self.build(points=tuple(map(tuple, model.nodes[list(nodes)].tolist())))


def nearest_node(model: Model, point: Array) -> int:
    """Node nearest to a point (x, y) of the plane z = 0, or (x, y, z)."""
    place = np.zeros(3)
    place[: len(point)] = point
    away = np.linalg.norm(model.nodes - place, axis=1)
    node = int(away.argmin())
    if away[node] > _longest_side(model):
        where = f"{show(point.tolist())}, {away[node]:.3g} m from the nearest one"
        raise CaseError(f"near: expected a point within an element's length of a node, got {where}; move it")
    return node


def _rows_of_group(model: Model, name: str, *parts: str) -> tuple[int, ...]:
    """Rows of the first part that a group of the mesh file selects, and nodes of the others.

    Raises
    ------
    CaseError
        If there is no such group, or it selects none of them.
    """
    named = _selections(model)
    own = named.get(name, {})
    rows = [own[part] if part == parts[0] else getattr(model, part)[own[part]] for part in parts if part in own]
    found = np.unique(np.concatenate([np.zeros(0, np.int64), *(one.ravel() for one in rows)]))
    if not found.size:
        having = [one for one, selected in named.items() if set(parts) & set(selected)]
        raise CaseError(
            f"group: expected a group of the mesh file with {parts[0]} ({', '.join(having) or 'none'}), got "
            f"{show(name)}; name one of them"
        )
    return tuple(found.tolist())


def _selections(model: Model) -> Mapping[str, Mapping[str, Indices]]:
    """Groups of the mesh file, of a structure or of the mesh that it will be made of."""
    found: Mapping[str, Mapping[str, Indices]] = getattr(model, "selections", None) or getattr(model, "groups", {})
    return found if isinstance(found, Mapping) else {}


def _nodes_of_group(model: Model, name: str) -> tuple[int, ...]:
    return _rows_of_group(model, name, "nodes", "triangles", "quads", "cables", "beams")


def _film(model: Model) -> tuple[Indices, Indices]:
    """Triangles of a structure, and quadrilaterals, which meshes have beside them."""
    return model.triangles, getattr(model, "quads", np.zeros((0, 4), dtype=np.int64))


def _longest_side(model: Model) -> float:
    """Length of the longest side of an element [m]."""
    sides = [
        model.nodes[cells] - model.nodes[np.roll(cells, 1, axis=1)]
        for cells in (*_film(model), model.cables, model.beams)
    ]
    return max(float(np.linalg.norm(side, axis=2).max(initial=0.0)) for side in sides)


def _axis(side: Side) -> tuple[int, float]:
    return "xy".index(side[1]), 1.0 if side[0] == "+" else -1.0


def _nodes_of_side(model: Model, side: Side) -> tuple[int, ...]:
    """Nodes of the film that lie farthest in a direction, in their order along the side."""
    axis, sign = _axis(side)
    film = np.unique(np.concatenate([cells.ravel() for cells in _film(model)]))
    if not film.size:
        raise CaseError(f"side: expected a model with a film, got none for {show(side)}; give nodes or near")
    places = sign * model.nodes[film, axis]
    span = np.ptp(model.nodes[film], axis=0).max()
    edge = film[places >= places.max() - 1e-6 * span]
    return tuple(int(node) for node in edge[np.argsort(model.nodes[edge, 1 - axis], kind="stable")])


def _cables_of_side(model: Model, side: Side) -> tuple[int, ...]:
    """Cables that run mainly along an axis, on one side of the origin."""
    axis, sign = _axis(side)
    chosen = cables_along(model, axis) & (sign * model.nodes[model.cables][:, :, axis].mean(axis=1) > 0.0)
    if not chosen.any():
        raise CaseError(f"side: expected a side with cables, got {show(side)}; give the numbers of cables instead")
    return tuple(int(cable) for cable in np.flatnonzero(chosen))
