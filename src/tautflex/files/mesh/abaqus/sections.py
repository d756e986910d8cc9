"""Directions that an Abaqus file states: of the cross-sections of beams, of the supports of nodes."""

from __future__ import annotations

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.instances import Placement
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import shorten
from tautflex.files.mesh.systems import System
from tautflex.numeric import Array

# Cross-sections whose dimensions stand on one line, so that the next one has the direction n1.
_ONE_LINE = ("RECT", "CIRC", "PIPE", "THICK PIPE", "BOX", "I", "L", "HEX", "TRAPEZOID", "GENERAL")
_DEFAULT = np.array([0.0, 0.0, -1.0])


def beam_directions(block: Block, placement: Placement, ends: Array) -> Array:
    """Direction of local z of beams, ``t x n1``, so that n1 is local y and I11 bends about it; shape (beam, 3).

    Parameters
    ----------
    block
        Beam section.
    placement
        Where it stands.
    ends
        Positions of the beams' ends, shape (beam, 2, 3).

    Raises
    ------
    MeshError
        If the direction cannot be read, or a beam runs along it.
    """
    kind = " ".join(block.option("SECTION").upper().split()) or ("GENERAL" if "GENERAL" in block.keyword else "")
    for name in ("OFFSET1", "OFFSET2", "OFFSET"):
        if name in block.options:
            raise MeshError(f"{block.where}: {name} of a cross-section is not read here; move the nodes")
    if kind not in _ONE_LINE:
        raise MeshError(f"{block.where}: expected SECTION of {', '.join(_ONE_LINE)}, got {shorten(kind)}; choose one")
    stated = fields(block.lines[1][1]) if len(block.lines) > 1 else []
    if any(stated):
        where = block.lines[1][0]
        if len(stated) > 3:
            raise MeshError(f"{where}: expected the three direction cosines of n1, got {len(stated)}; correct the line")
        first = vector([*stated, "", ""][:3], where)
    elif placement.is_turned:
        raise MeshError(f"{block.where}: expected the direction n1 in a turned instance, got none; state it")
    else:
        first = _DEFAULT
    along = ends[:, 1] - ends[:, 0]
    result = np.cross(along, placement.turn @ first)
    limit = 1e-9 * np.linalg.norm(along, axis=1) * np.linalg.norm(first)
    if not (np.linalg.norm(result, axis=1) > limit).all():
        raise MeshError(f"{block.where}: expected a direction n1 across the beams, got one along a beam; correct it")
    return result


def node_axes(block: Block, placement: Placement, names: Names, nodes: Array) -> dict[int, Array]:
    """Directions of the nodes of a TRANSFORM as rows, shape (3, 3), by row of the node.

    TYPE=R: point a on the local x axis, b in the local x-y plane; TYPE=C: a and b on the axis; directions r, t, z.
    """
    block.require_options("NSET", "TYPE")
    kind = block.option("TYPE").upper() or "R"
    texts = [text for _, line in block.lines for text in fields(line)]
    if kind not in ("R", "C") or not 1 <= len(texts) <= 6 or len(block.lines) != 1:
        raise MeshError(
            f"{block.where}: expected TYPE=R or C and a line of two points, got {shorten(kind)}; correct it"
        )
    a, b = vector([*texts, *[""] * (6 - len(texts))], block.where).reshape(2, 3)
    if kind == "R":
        x, z = placement.turn @ a, np.cross(placement.turn @ a, placement.turn @ b)
        origin = np.zeros(3)
    else:
        origin, z = placement.points(a[None])[0], placement.turn @ (b - a)
        x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    if not np.linalg.norm(x) * np.linalg.norm(z) > 0.0:
        raise MeshError(f"{block.where}: expected two points that fix the directions, got points on a line; correct it")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    system = System(kind, origin, np.array([x, np.cross(z, x), z]))
    return {row: system.directions(nodes[row]) for row in names.find(block.option("NSET"), block.where).tolist()}
