"""Point masses and rotary inertias of an Abaqus file."""

from __future__ import annotations

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.instances import Placement
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import RawMass, RawNonstructural, shorten

_PER = {"MASS PER AREA": "membrane", "MASS PER LENGTH": "line", "TOTAL MASS": "total"}


def nonstructural(block: Block) -> RawNonstructural:
    """Mass that a NONSTRUCTURAL MASS block gives each element of its set."""
    block.require_options("ELSET", "UNITS", "DISTRIBUTION")
    units = " ".join(block.option("UNITS").upper().split())
    if units not in _PER or len(block.lines) != 1:
        raise MeshError(
            f"{block.where}: expected UNITS of {', '.join(_PER)} and a line with a number, got {shorten(units)}; write "
            "one of them"
        )
    value = vector(fields(block.lines[0][1])[:1], block.where, largest=1e300)
    return RawNonstructural(block.where, _PER[units], float(value[0]) if len(value) else 0.0)


def body(block: Block, placement: Placement) -> RawMass:
    """Body that a MASS or ROTARY INERTIA block gives each of its elements; moments in the axes of its scope."""
    block.require_options("ELSET")
    wanted = 1 if block.keyword == "MASS" else 3
    texts = [text for _, line in block.lines for text in fields(line)]
    if len(block.lines) != 1 or not wanted <= len(texts) <= (1 if wanted == 1 else 6):
        what = "a mass" if wanted == 1 else "I11, I22, I33"
        raise MeshError(f"{block.where}: expected one line with {what}, got {len(texts)} numbers; correct it")
    values = vector(texts, block.where, largest=1e300)
    if values[3:].any():
        raise MeshError(f"{block.where}: expected principal moments, got products of inertia; turn them to their axes")
    if wanted == 1:
        return RawMass(block.where, float(values[0]), np.zeros((3, 3)), np.zeros(3))
    return RawMass(block.where, 0.0, placement.turn @ np.diag(values[:3]) @ placement.turn.T, np.zeros(3))
