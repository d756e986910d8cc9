"""Spring and dashpot elements of an Abaqus or CalculiX file."""

from __future__ import annotations

import numpy as np

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import finite, natural
from tautflex.files.mesh.raw import shorten
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Indices
from tautflex.structure.springs import Damper, Spring


def spring(block: Block, role: str, nodes: Indices) -> RawLink | None:
    """Spring or damper that a block makes of an element between rows of nodes; None if its number is 0."""
    block.require_options("ELSET")
    kind: type[Spring] | type[Damper] = Damper if block.keyword == "DASHPOT" else Spring
    lines = [fields(line) for _, line in block.lines if line.strip(", ")]
    wanted = 1 if role.endswith("a") else 2
    if len(lines) != wanted or len(lines[-1]) != 1:
        what = "a number" if wanted == 1 else "directions, then a number below"
        raise MeshError(f"{block.where}: expected {what}, got {len(lines)} line(s); tables are not read here")
    value, rows = finite(lines[-1][0], block.where), nodes.tolist()
    if value == 0.0:
        return None
    try:
        if role.endswith("a"):
            return RawLink(block.where, kind(rows, value))
        ways = [natural(text, block.where) for text in lines[0] if text]
        if len(set(ways)) != 1 or len(ways) > len(rows) or ways[0] > 6:
            got = shorten(str(lines[0]))
            raise MeshError(
                f"{block.where}: expected the same direction from 1 to 6 at each node, got {got}; correct it"
            )
        return RawLink(block.where, kind(rows, tuple((value * np.eye(6)[ways[0] - 1]).tolist())))
    except MeshError:
        raise
    except InputError as error:
        raise MeshError(f"{block.where}: {error}") from None
