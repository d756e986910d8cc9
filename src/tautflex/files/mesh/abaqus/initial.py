"""Initial stresses of an Abaqus file, in the axes of a structure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tautflex.elements.axes import film_axes
from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.gathered import SHAPES
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array, Indices, Mask

_ALONG_X = np.cos(np.radians(0.1))  # of the angle between x and the normal within which the format projects z


def initial_stress(
    blocks: list[Block],
    names: Names,
    shape: Indices,
    row: Indices,
    elements: Mapping[str, Indices],
    nodes: Array,
    oriented: Mask,
) -> dict[str, Array]:
    """Stress (sx, sy, txy) of films in the axes of `Model.from_mesh`, along lines s11; by shape, (element, 3).

    ``shape`` and ``row`` are the place of the shape of each element, and its row there; ``oriented`` tells which
    elements have an ORIENTATION of their own, which is not read.

    Raises
    ------
    MeshError
        If other things than stresses are given, or of other elements.
    """
    found = {name: np.zeros((len(own), 3)) for name, own in elements.items()}
    for block in blocks:
        block.require_options("TYPE")
        if block.option("TYPE").upper() != "STRESS":
            got = shorten(block.option("TYPE"))
            raise MeshError(f"{block.where}: expected TYPE=STRESS or TEMPERATURE, got {got}; state it in the case")
        for where, line in block.lines:
            target, *texts = fields(line) or [""]
            if not 1 <= len(texts) <= 3:
                raise MeshError(f"{where}: expected s11, s22, s12, got {len(texts)} numbers; correct the line")
            stress = np.zeros(3)
            stress[: len(texts)] = vector(texts, where, largest=1e30)
            members = names.find(target, where)
            if oriented[members].any() and (stress[2] or stress[0] != stress[1]):
                raise MeshError(
                    f"{where}: expected stresses along x and y, got some along an ORIENTATION, which is not read here; "
                    "state the stress in the case"
                )
            for place, name in enumerate(SHAPES):
                own = row[members[shape[members] == place]]
                if not len(own):
                    continue
                if name.startswith("line"):
                    if stress[1:].any():
                        raise MeshError(f"{where}: expected one stress of lines, got several; leave the others out")
                    found[name][own] = stress
                elif name.startswith(("point", "spring")):
                    raise MeshError(f"{where}: expected films, cables or beams, got others; leave them out")
                else:
                    found[name][own] = _turned(stress, nodes[elements[name][own]][:, : 3 if name[0] == "t" else 4])
    return found


def _turned(stress: Array, corners: Array) -> Array:
    """Stress in the format's local axes as that in the axes of `Model.from_mesh`, shape (film, 3).

    Both have the projection of x as their first axis where they can. The format's normal is that of the corner order,
    so that a film listed the other way round has the other sign of shear.
    """
    last = corners.shape[1] - 1
    tangents = np.stack([corners[:, 1] - corners[:, 0], corners[:, last] - corners[:, 0]], axis=1)
    normal = np.cross(tangents[:, 0], tangents[:, 1])
    size = np.linalg.norm(normal, axis=1)
    if not (size > 0.0).all():
        return np.broadcast_to(stress, (len(corners), 3))  # folded, which is found when the mesh is checked
    normal /= size[:, None]
    direction = np.where(np.abs(normal[:, :1]) < _ALONG_X, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    first = direction - np.sum(normal * direction, axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    own = np.stack([first, np.cross(normal, first)], axis=1)
    turn = film_axes(tangents, np.array([1.0, 0.0, 0.0]))[0][:, :2] @ own.transpose(0, 2, 1)
    tensor = turn @ np.array([[stress[0], stress[2]], [stress[2], stress[1]]]) @ turn.transpose(0, 2, 1)
    return np.stack([tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1]], axis=1)
