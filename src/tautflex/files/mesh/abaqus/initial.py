"""Initial stresses of an Abaqus file."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.gathered import SHAPES
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array, Indices

_ALONG_X = 0.999  # cosine beyond which the format takes another axis than x
_EQUAL = 1e-9


def initial_stress(
    blocks: list[Block],
    names: Names,
    shape: Indices,
    row: Indices,
    elements: Mapping[str, Indices],
    nodes: Array,
) -> dict[str, Array]:
    """Stress (s11, s22, s12) of the elements of each shape in their local axes, along lines s11; shapes (element, 3).

    The format's local 1 direction of films is the projection of x, as that of `Model.from_mesh`. ``shape`` and ``row``
    are the place of the shape of each element, and its row there.

    Raises
    ------
    MeshError
        If other things than stresses are given, or they need axes that the film does not have.
    """
    found = {name: np.zeros((len(own), 3)) for name, own in elements.items()}
    for block in blocks:
        kind = block.option("TYPE").upper()
        if kind == "TEMPERATURE":
            continue
        block.require_options("TYPE")
        if kind != "STRESS":
            raise MeshError(f"{block.where}: expected TYPE=STRESS, got {shorten(kind)}; state it in the case")
        for where, line in block.lines:
            target, *texts = fields(line) or [""]
            if not 1 <= len(texts) <= 3:
                raise MeshError(f"{where}: expected s11, s22, s12, got {len(texts)} numbers; correct the line")
            stress = np.zeros(3)
            stress[: len(texts)] = vector(texts, where, largest=1e30)
            members = names.find(target, where)
            for place, name in enumerate(SHAPES):
                own = row[members[shape[members] == place]]
                if not len(own):
                    continue
                if name.startswith("line"):
                    _require(not stress[1:].any(), where, "one stress of lines, got several; leave the others out")
                elif stress[2] or abs(stress[1] - stress[0]) > _EQUAL * abs(stress[0]):
                    _require(not stress[2], where, "no shear, got s12; state the stress in the case")
                    corner = nodes[elements[name][own]]
                    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
                    away = np.abs(normal[:, 0]) < _ALONG_X * np.linalg.norm(normal, axis=1)
                    _require(bool(away.all()), where, "film that is not across x; state the stress in the case")
                found[name][own] = stress
    return found


def _require(fits: bool, where: str, text: str) -> None:
    if not fits:
        raise MeshError(f"{where}: expected {text}")
