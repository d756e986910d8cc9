"""Stored variables: names, dimensions, units and words, once for all results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from tautflex.structure.model import Model
from tautflex.structure.shapes import TRIANGLE3

# Every variable that may describe the mesh of a result.
MESH_VARIABLES = (
    *("node_position", "triangle", "cable", "beam"),
    *("triangle_owner", "membrane", "membrane_cell", "membrane_edge"),
)

COMPONENTS = ["x", "y", "z"]


class Variable(NamedTuple):
    """What is known of a stored variable before its numbers.

    Parameters
    ----------
    dims
        Names of its dimensions.
    units
        In which it is stored; ``{units}`` stands for those of the record that it was made from.
    words
        Long name; ``{name}`` stands for that of the record.
    """

    dims: tuple[str, ...]
    units: str
    words: str


Variables = dict[str, Variable]

_TABLE, _SAMPLE, _VECTOR = ("rate", "branch"), ("time", "probe"), ("time", "component")
_DIRECTIONS = ("direction", "other_direction")
_MASSES = "kg, kg m, kg m^2"

SCALARS: Variables = {
    "kinetic_energy": Variable(("time",), "J", "kinetic energy of the elastic motion"),
    "strain_energy": Variable(("time",), "J", "strain energy above the reference"),
    "min_principal_resultant": Variable(("time",), "N m-1", "smallest principal film resultant"),
    "max_principal_resultant": Variable(("time",), "N m-1", "largest principal film resultant"),
    "wrinkled_fraction": Variable(
        ("time",), "1", "part of the film's area that is wrinkled (would be, with the elastic law)"
    ),
    "slack_fraction": Variable(
        ("time",), "1", "part of the film's area that is slack (would be, with the elastic law)"
    ),
    "slack_cables": Variable(("time",), "1", "number of cables without tension"),
}
"""Of every sample of a run, in the order in which they are sampled."""

RUN: Variables = {
    **{n: Variable(_SAMPLE, "m", f"elastic displacement along {x}") for n, x in zip("uvw", COMPONENTS, strict=True)},
    **{
        f"{n}_velocity": Variable(_SAMPLE, "m s-1", f"elastic velocity along {x}")
        for n, x in zip("uvw", COMPONENTS, strict=True)
    },
    "angular_velocity": Variable(_VECTOR, "rad s-1", "angular velocity of the floating frame"),
    "angular_acceleration": Variable(_VECTOR, "rad s-2", "angular acceleration of the floating frame"),
    **SCALARS,
    "displacement": Variable(("field_time", "node", "component"), "m", "elastic displacement of all nodes"),
    "film_state": Variable(("field_time", "triangle_element"), "1", "state of each film element"),
    "probe_position": Variable(("probe", "component"), "m", "reference position of the probe"),
    "time": Variable(("time",), "s", "time"),
    "field_time": Variable(("field_time",), "s", "time of stored fields"),
}

HUB: Variables = {
    **RUN,
    "kinetic_energy": Variable(("time",), "J", "kinetic energy of hub and structure, inertial frame"),
    "hub_position": Variable(_VECTOR, "m", "position of the floating frame's origin, inertial axes"),
    "hub_velocity": Variable(_VECTOR, "m s-1", "velocity of the floating frame's origin, inertial axes"),
    "linear_momentum": Variable(_VECTOR, "kg m s-1", "total linear momentum, inertial axes"),
    "angular_momentum": Variable(
        _VECTOR, "kg m2 s-1", "total angular momentum about the inertial origin, inertial axes"
    ),
    "attitude": Variable(
        ("time", "quaternion"), "1", "attitude quaternion, scalar first, floating frame to inertial frame"
    ),
    "work": Variable(("time",), "J", "work of hub force and torque since the start"),
}

REDUCED_RUN: Variables = {
    **RUN,
    "coordinate": Variable(("time", "basis_vector"), "kg^1/2 m", "coordinate of the reduced model"),
    "truncated_energy": Variable(
        ("check_time",),
        "1",
        "strain energy that the unbalanced force would have outside the basis, over the run's largest energy",
    ),
    "check_time": Variable(("check_time",), "s", "instant of a check"),
}

_OF_RUN = [*(n + suffix for suffix in ("", "_velocity") for n in "uvw"), "kinetic_energy", "strain_energy"]
BATCH: Variables = {
    **{name: RUN[name]._replace(dims=("run", *RUN[name].dims)) for name in _OF_RUN},
    "status": Variable(("run",), "", ""),
    "iterations": Variable(("run",), "1", "nonlinear iterations"),
    "maneuver_end": Variable(("run",), "s", "end of the maneuver"),
    "probe_position": RUN["probe_position"],
    "time": RUN["time"],
}

_LABELS: Variables = {
    "label_m": Variable(("mode",), "1", "half-waves along x, 0 where none"),
    "label_n": Variable(("mode",), "1", "half-waves along y, 0 where none"),
}
MODES: Variables = {
    "frequency": Variable(("mode",), "Hz", "natural frequency"),
    "shape": Variable(("mode", "node", "component"), "kg^-1/2", "mass-normalised mode shape"),
    **_LABELS,
    "symmetry": Variable(("mode",), "1", "symmetry about x = 0 and y = 0"),
    "effective_mass": Variable(
        ("mode", "direction"), "kg, kg m^2", "effective mass (x, y, z) and inertia (rx, ry, rz)"
    ),
}

_SPINNING: Variables = {
    "frequency": Variable(("mode",), "Hz", "frequency in the rotating frame"),
    "growth_rate": Variable(("mode",), "s-1", "growth rate"),
    "damping_ratio": Variable(("mode",), "1", "damping ratio"),
    "whirl": Variable(("mode",), "1", "sense of the orbits, 1 forward, -1 backward"),
    **_LABELS,
}
SPINNING_MODES: Variables = {
    **_SPINNING,
    "shape": Variable(("mode", "node", "component"), "kg^-1/2", "real part of the mode shape"),
    "shape_quadrature": Variable(("mode", "node", "component"), "kg^-1/2", "imaginary part of the mode shape"),
}
CAMPBELL: Variables = {
    **{name: variable._replace(dims=_TABLE) for name, variable in _SPINNING.items()},
    "mac": Variable(_TABLE, "1", "weakest link from the rate before"),
    "stable": Variable(("rate",), "1", "whether no mode grows"),
    "min_principal_resultant": Variable(("rate",), "N m-1", "smallest principal film resultant of the equilibrium"),
    "rate": Variable(("rate",), "rad s-1", "angular rate"),
}

APPENDAGE: Variables = {
    "frequency": MODES["frequency"],
    "damping_ratio": _SPINNING["damping_ratio"],
    "participation": Variable(
        ("mode", "direction"), "kg^1/2, kg^1/2 m", "participation in rigid motions about the point"
    ),
    "effective_mass": Variable(("mode", "direction"), "kg, kg m^2", "effective mass and inertia"),
    "rigid_mass": Variable(_DIRECTIONS, _MASSES, "mass matrix of the rigid structure"),
    "free_mass": Variable(_DIRECTIONS, _MASSES, "mass matrix that all modes together hold"),
    "residual_mass": Variable(_DIRECTIONS, _MASSES, "rigid mass less that of these modes"),
    "completeness": Variable(("direction",), "1", "part of the free mass that these modes hold"),
    "point": Variable(("component",), "m", "reference point"),
}

# Dimensions behind time, and time itself, are those of the data.
POD: Variables = {
    "shape": Variable(("mode",), "1", "proper orthogonal mode"),
    "value": Variable(("mode",), "({units})^2", "proper orthogonal value"),
    "participation": Variable(("mode",), "1", "participation factor"),
    "cumulative": Variable(("mode",), "1", "cumulative participation"),
    "coefficient": Variable(("mode",), "{units}", "response along the mode"),
    "mode": Variable(("mode",), "", "proper orthogonal mode"),
    "dominant_shape": Variable((), "1", "dominant shape"),
}
MAC: Variables = {
    "mode": Variable(("rank",), "1", "number of the normal mode"),
    "mac": Variable(("rank",), "1", "modal assurance criterion"),
    "cumulative": Variable(("rank",), "1", "cumulative criterion"),
    "frequency": Variable(("rank",), "Hz", "natural frequency"),
    "rank": Variable(("rank",), "", "rank"),
}
SPECTRUM: Variables = {
    "amplitude": Variable(("frequency",), "{units}", "amplitude of {name}"),
    "energy": Variable(("frequency",), "({units})^2 s/Hz", "energy spectral density of {name}"),
    "frequency": Variable(("frequency",), "Hz", "frequency"),
}
SCALOGRAM: Variables = {
    "magnitude": Variable(("frequency", "time"), "{units}", "wavelet amplitude of {name}"),
    "ridge": Variable(("time",), "Hz", "frequency of largest wavelet amplitude"),
    "ridge_magnitude": Variable(("time",), "{units}", "largest wavelet amplitude of {name}"),
    "cone_of_influence": Variable(("time",), "Hz", "lowest frequency free of end effects"),
    "frequency": SPECTRUM["frequency"],
    "time": RUN["time"],
}


def about(variable: Variable, **record: str) -> dict[str, str]:
    """Attributes of a variable; ``record`` has the units and the name of what it was made from."""
    given = {"long_name": variable.words.format(**record), "units": variable.units.format(**record)}
    return {key: text for key, text in given.items() if text}


def described(table: Variables, arrays: Mapping[str, Any], **record: str) -> dict[str, tuple[Any, ...]]:
    """Arrays by name as Dataset variables with the dimensions, units and words of a table."""
    return {name: (table[name].dims, array, about(table[name], **record)) for name, array in arrays.items()}


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
