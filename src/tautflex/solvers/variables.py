"""Stored variables: names, dimensions, units and words, once for all results."""

from __future__ import annotations

from typing import Any

from tautflex.structure.model import Model


def mesh_variables(model: Model) -> dict[str, tuple[Any, ...]]:
    """Mesh as Dataset variables, so that results can be drawn without the model."""
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
    return variables
