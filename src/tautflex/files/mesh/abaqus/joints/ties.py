"""Ties and embedded elements of an Abaqus file: nodes that move with what lies at their place."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.joints.surfaces import Surfaces, Whole
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.raw import integers, shorten
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.equation import LinkEquation
from tautflex.structure.links.tie import Tie
from tautflex.structure.locate import locate
from tautflex.structure.shapes import QUAD4, TRIANGLE3, TRIANGLE6

_FILMS = {"triangle3": TRIANGLE3, "quad4": QUAD4, "triangle6": TRIANGLE6}
_AT = 1e-6  # of the extent of what leads: farther away nodes are elsewhere


def tied(scope: str, block: Block, surfaces: Surfaces, whole: Whole) -> Iterator[RawLink]:
    """Links of a TIE: nodes of the first surface of each line follow the second."""
    block.require_options("NAME", "ADJUST", "TYPE", "POSITION TOLERANCE", "NO ROTATION", "NO THICKNESS")
    for where, line in block.lines:
        names = fields(line)
        if len(names) != 2:
            raise MeshError(f"{where}: expected two surfaces, got {shorten(line)}; write those that follow first")
        follow, lead = (surfaces.find(scope, name, where) for name in names)
        ways = DIRECTIONS[:3] if "NO ROTATION" in block.options else DIRECTIONS
        elements = np.unique(np.concatenate([integers([]), *lead.elements]))
        yield from _held(where, list(follow.nodes), list(lead.nodes), elements, whole, ways)


def embedded(block: Block, names: Names, whole: Whole) -> Iterator[RawLink]:
    """Links of an EMBEDDED ELEMENT: nodes of its elements follow the film of HOST ELSET, in translation."""
    block.require_options("HOST ELSET", "ROUNDOFF TOLERANCE", "EXTERIOR TOLERANCE", "ABSOLUTE EXTERIOR TOLERANCE")
    host = names.find(block.option("HOST ELSET"), block.where)
    for where, line in block.lines:
        for target in fields(line):
            inside = {n for _, rows in whole.of(names.find(target, where)) for n in rows.ravel().tolist()}
            lead = {n for _, rows in whole.of(host) for n in rows.ravel().tolist()}
            yield from _held(where, sorted(inside), sorted(lead), host, whole, DIRECTIONS[:3])


def _held(
    where: str, nodes: list[int], leading: list[int], elements: Indices, whole: Whole, ways: tuple[str, ...]
) -> Iterator[RawLink]:
    """Ties of nodes to those that lead at their place, and interpolation in the film between them."""
    if not leading:
        raise MeshError(f"{where}: expected a surface with nodes to lead, got none; name another")
    places = whole.positions[leading]
    reach = _AT * float(np.ptp(places, axis=0).max())
    for node in nodes:
        if node in leading:
            continue
        away = np.linalg.norm(places - whole.positions[node], axis=1)
        if away.min() <= reach:
            yield RawLink(where, Tie(leading[int(away.argmin())], [node], ways))
            continue
        found = _under(whole, elements, whole.positions[node])
        if found is None:
            place = ", ".join(f"{x:g}" for x in whole.positions[node])
            raise MeshError(
                f"{where}: expected nodes on the film that leads (of M3D3, M3D4 or M3D6), got one at ({place}) beside "
                "it; move it there, as ADJUST would, or leave it out of the surface"
            )
        for way in DIRECTIONS[:3]:
            shares = [(int(other), way, -float(share)) for other, share in zip(*found, strict=True) if share]
            yield RawLink(where, LinkEquation(((node, way, 1.0), *shares)))


def _under(whole: Whole, elements: Indices, place: Array) -> tuple[Indices, Array] | None:
    """Nodes of the film's element that lies at a place, and their weights there."""
    for name, rows in whole.of(elements):
        if name in _FILMS:
            used, local = np.unique(rows, return_inverse=True)
            own = whole.positions[used]
            # Elements are looked for along the normal of their best plane.
            away = own - own.mean(axis=0)
            axes = np.linalg.eigh(away.T @ away)[1].T[::-1]
            axes[2] *= np.linalg.det(axes)
            found = locate(_FILMS[name], own @ axes.T, local.reshape(rows.shape), axes @ place)
            if found is not None:
                return rows[found[0]], found[1]
    return None
