"""Elements as data: each file declares one kind; the registry below is all that names them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tautflex.elements import beam, cable, membrane
from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.structure.groups import ElementGroup
from tautflex.structure.model import Model

Declaration = Callable[[NDArray[np.float64], ElementGroup, NDArray[np.int64]], ElementBlock]

DECLARATIONS: dict[str, Declaration] = {
    "membrane": membrane.declare,
    "cable": cable.declare,
    "beam": beam.declare,
}


def element_blocks(model: Model) -> tuple[ElementBlock, ...]:
    """Turn every element group of a model into data, in the order of ``model.groups``.

    Parameters
    ----------
    model
        The structure.

    Returns
    -------
    tuple of ElementBlock
    """
    return tuple(
        DECLARATIONS[group.section.kind](model.nodes, group, model.element_dofs(group)) for group in model.groups
    )


__all__ = ["DECLARATIONS", "ElementBlock", "InertiaPoints", "element_blocks"]
