"""Temperatures of an Abaqus file, and the strain that elements would take at them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array, Indices


def free_strain(
    initial: list[Block],
    later: list[Block],
    names: Names,
    count: int,
    expansion: Mapping[str, Array],
    elements: Mapping[str, Indices],
) -> dict[str, Array]:
    """Strain of free elements ``a (T - T0)``, the mean over their nodes, by shape, shapes (element,).

    Parameters
    ----------
    initial, later
        INITIAL CONDITIONS of temperature, T0, which are 0 where none is stated; TEMPERATURE of the step.
    names
        Nodes by name.
    count
        Number of nodes.
    expansion
        Coefficient of expansion a of the elements of each shape.
    elements
        Rows of their nodes.
    """
    before = np.zeros(count)
    for block in initial:
        block.require_options("TYPE")
        _set(before, block, names)
    now = before.copy()
    for block in later:
        block.require_options("OP", "AMPLITUDE")
        _set(now, block, names)
    change = now - before
    return {shape: expansion[shape] * change[rows].mean(axis=1) for shape, rows in elements.items()}


def _set(temperature: Array, block: Block, names: Names) -> None:
    for where, line in block.lines:
        target, *texts = fields(line) or [""]
        values = vector(texts, where)
        if not len(values) or (values[1:] != values[0]).any():
            raise MeshError(
                f"{where}: expected node or set and one temperature, got {shorten(line)}; gradients through sections "
                "are not read here"
            )
        temperature[names.find(target, where)] = values[0]
