"""Stored variables: names, dimensions, units and words, once for all results."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.structure.model import Model
from tautflex.structure.shapes import TRIANGLE3

# Every variable that may describe the mesh of a result.
MESH_VARIABLES = (
    *("node_position", "triangle", "cable", "beam"),
    *("triangle_owner", "membrane", "membrane_cell", "membrane_edge"),
)


def mesh_variables(model: Model) -> dict[str, tuple[Any, ...]]:
    """Mesh as Dataset variables, so that results can be drawn and written without the model.

    ``triangle`` holds linear triangles. Where the film's elements are others, these are what stands for them in
    pictures, ``triangle_owner`` tells the film element of each, and ``membrane``, ``membrane_cell`` (VTK's number of
    the cell type) and ``membrane_edge`` hold the elements themselves and the lines between them.
    """
    variables: dict[str, tuple[Any, ...]] = {
        "node_position": (
            ("node", "component"),
            model.nodes,
            {"long_name": "reference position", "units": "m"},
        )
    }
    for name, corner, elements in (
        ("triangle", "corner", model.triangles),
        ("cable", "end", model.cables),
        ("beam", "end", model.beams),
    ):
        about = {"long_name": f"nodes of each {name}", "units": "1"}
        variables[name] = ((f"{name}_element", corner), elements, about)
    if all(group.shape == TRIANGLE3 for group in model.surfaces):
        return variables
    return variables | _membrane_variables(model)


def _membrane_variables(model: Model) -> dict[str, tuple[Any, ...]]:
    widest = max(group.connectivity.shape[1] for group in model.surfaces)
    rows = [
        np.pad(group.connectivity, ((0, 0), (0, widest - group.connectivity.shape[1])), constant_values=-1)
        for group in model.surfaces
    ]
    cells = np.repeat(
        [group.shape.vtk_cell for group in model.surfaces], [len(group.connectivity) for group in model.surfaces]
    )
    edges = [
        group.connectivity[:, edge[k : k + 2]]
        for group in model.surfaces
        for edge in group.shape.edges
        for k in range(len(edge) - 1)
    ]
    return {
        "triangle_owner": (
            "triangle_element",
            model.triangle_owner,
            {"long_name": "film element that each triangle is a part of", "units": "1"},
        ),
        "membrane": (
            ("membrane_element", "membrane_node"),
            np.concatenate(rows),
            {"long_name": "nodes of each film element, -1 where it has fewer", "units": "1"},
        ),
        "membrane_cell": ("membrane_element", cells, {"long_name": "VTK's type of each film element", "units": "1"}),
        "membrane_edge": (
            ("membrane_line", "end"),
            np.unique(np.sort(np.concatenate(edges), axis=1), axis=0),
            {"long_name": "nodes of each line between film elements", "units": "1"},
        ),
    }
