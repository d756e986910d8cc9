"""Stored variables: names, dimensions, units and words, once for all results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.structure.model import Model
from tautflex.structure.shapes import TRIANGLE3
from tautflex.text import shown

if TYPE_CHECKING:
    import xarray as xr

COMPONENTS = ["x", "y", "z"]
_ALONG = tuple(zip("uvw", COMPONENTS, strict=True))


class Variable(NamedTuple):
    """Dimensions, units and long name of a stored variable, before its numbers.

    ``{units}`` and ``{name}`` in them stand for those of the record that it was made from.
    """

    dims: tuple[str, ...]
    units: str
    words: str


Variables = dict[str, Variable]


def _of(dims: str, units: str, words: str) -> Variable:
    return Variable(tuple(dims.split()), units, words)


MESH: Variables = {
    "node_position": _of("node component", "m", "reference position"),
    "triangle": _of("triangle_element corner", "1", "nodes of each triangle"),
    "cable": _of("cable_element end", "1", "nodes of each cable"),
    "beam": _of("beam_element end", "1", "nodes of each beam"),
    "triangle_owner": _of("triangle_element", "1", "film element that each triangle is a part of"),
    "membrane": _of("membrane_element membrane_node", "1", "nodes of each film element, -1 where it has fewer"),
    "membrane_cell": _of("membrane_element", "1", "VTK's type of each film element"),
    "membrane_edge": _of("membrane_line end", "1", "nodes of each line between film elements"),
    "link": _of("link_line end", "1", "nodes that each link or spring joins"),
    "held": _of("held_node", "1", "nodes that supports hold"),
}
"""Every variable that may describe the mesh of a result."""

SCALARS: Variables = {
    "kinetic_energy": _of("time", "J", "kinetic energy of the elastic motion"),
    "strain_energy": _of("time", "J", "strain energy above the reference"),
    "min_principal_resultant": _of("time", "N m-1", "smallest principal film resultant"),
    "max_principal_resultant": _of("time", "N m-1", "largest principal film resultant"),
    "wrinkled_fraction": _of("time", "1", "part of the film's area that is wrinkled (would be, with the elastic law)"),
    "slack_fraction": _of("time", "1", "part of the film's area that is slack (would be, with the elastic law)"),
    "slack_cables": _of("time", "1", "number of cables without tension"),
}
"""Of every sample of a run, in the order in which they are sampled."""

SURFACE: Variables = {
    "rms": _of("time", "m", "root mean square of the film's displacement about its best plane"),
    "tilt_x": _of("time", "rad", "rotation of the film's best plane about x"),
    "tilt_y": _of("time", "rad", "rotation of the film's best plane about y"),
    "piston": _of("time", "m", "mean displacement across the film"),
    "ruze_loss": _of("time", "dB", "loss of gain by the surface's error (Ruze)"),
}
"""Of the film as a reflecting surface."""

OF_SURFACE = {f"surface_{name}": name for name in ("rms", "tilt_x", "tilt_y", "piston")}
"""Their names in a run, in the order in which they are sampled."""

RUN: Variables = {
    **{n: _of("time probe", "m", f"elastic displacement along {x}") for n, x in _ALONG},
    **{f"{n}_velocity": _of("time probe", "m s-1", f"elastic velocity along {x}") for n, x in _ALONG},
    "angular_velocity": _of("time component", "rad s-1", "angular velocity of the floating frame"),
    "angular_acceleration": _of("time component", "rad s-2", "angular acceleration of the floating frame"),
    **SCALARS,
    **{stored: SURFACE[name] for stored, name in OF_SURFACE.items()},
    "displacement": _of("field_time node component", "m", "elastic displacement of all nodes"),
    "film_state": _of("field_time triangle_element", "1", "state of each film element"),
    "frame_displacement": _of("frame_time node component", "m", "elastic displacement of all nodes, in single"),
    "probe_position": _of("probe component", "m", "reference position of the probe"),
    "time": _of("time", "s", "time"),
    "field_time": _of("field_time", "s", "time of stored fields"),
    "frame_time": _of("frame_time", "s", "time of the frames of pictures that move"),
}

HUB: Variables = {
    **RUN,
    "kinetic_energy": _of("time", "J", "kinetic energy of hub and structure, inertial frame"),
    "hub_position": _of("time component", "m", "position of the floating frame's origin, inertial axes"),
    "hub_velocity": _of("time component", "m s-1", "velocity of the floating frame's origin, inertial axes"),
    "linear_momentum": _of("time component", "kg m s-1", "total linear momentum, inertial axes"),
    "angular_momentum": _of(
        "time component", "kg m2 s-1", "total angular momentum about the inertial origin, inertial axes"
    ),
    "attitude": _of("time quaternion", "1", "attitude quaternion, scalar first, floating frame to inertial frame"),
    "work": _of("time", "J", "work of hub force and torque since the start"),
}

REDUCED_RUN: Variables = {
    **RUN,
    "coordinate": _of("time basis_vector", "kg^1/2 m", "coordinate of the reduced model"),
    "truncated_energy": _of(
        "check_time",
        "1",
        "strain energy that the unbalanced force would have outside the basis, over the run's largest energy",
    ),
    "check_time": _of("check_time", "s", "instant of a check"),
}

LOOP: Variables = {
    "measurement": _of("sample_time output", "1", "what sensors told, each in its unit"),
    "command": _of("sample_time input", "1", "what actuators were told until the next sample, each in its unit"),
    "reference": _of("sample_time asked axis", "1", "what the hub was to follow, rad, rad s-1, rad s-2"),
    "attitude_error": _of("sample_time", "rad", "angle between the hub and what it was to follow"),
    "source_work": _of("sample_time source", "J", "work that each actuator has done since the start"),
    "sample_time": _of("sample_time", "s", "time of a sample of the loop"),
}

_OF_RUN = [*(n + suffix for suffix in ("", "_velocity") for n in "uvw"), "kinetic_energy", "strain_energy"]
BATCH: Variables = {
    **{name: RUN[name]._replace(dims=("run", *RUN[name].dims)) for name in _OF_RUN},
    **{name: HUB[name]._replace(dims=("run", *HUB[name].dims)) for name in ("attitude", "angular_velocity")},
    "angle": _of("run time", "rad", "angle that a hub of one axis has turned through"),
    "status": _of("run", "", ""),
    "iterations": _of("run", "1", "nonlinear iterations"),
    "maneuver_end": _of("run", "s", "end of the maneuver"),
    "probe_position": RUN["probe_position"],
    "time": RUN["time"],
}

_LABELS: Variables = {
    "label_m": _of("mode", "1", "half-waves along x, 0 where none"),
    "label_n": _of("mode", "1", "half-waves along y, 0 where none"),
}
MODES: Variables = {
    "frequency": _of("mode", "Hz", "natural frequency"),
    "shape": _of("mode node component", "kg^-1/2", "mass-normalised mode shape"),
    **_LABELS,
    "symmetry": _of("mode", "1", "symmetry about x = 0 and y = 0"),
    "effective_mass": _of("mode direction", "kg, kg m^2", "effective mass (x, y, z) and inertia (rx, ry, rz)"),
}

_SPINNING: Variables = {
    "frequency": _of("mode", "Hz", "frequency in the rotating frame"),
    "growth_rate": _of("mode", "s-1", "growth rate"),
    "damping_ratio": _of("mode", "1", "damping ratio"),
    "whirl": _of("mode", "1", "sense of the orbits, 1 forward, -1 backward"),
    **_LABELS,
}
SPINNING_MODES: Variables = {
    **_SPINNING,
    "shape": _of("mode node component", "kg^-1/2", "real part of the mode shape"),
    "shape_quadrature": _of("mode node component", "kg^-1/2", "imaginary part of the mode shape"),
}
CAMPBELL: Variables = {
    **{name: variable._replace(dims=("rate", "branch")) for name, variable in _SPINNING.items()},
    "mac": _of("rate branch", "1", "weakest link from the rate before"),
    "stable": _of("rate", "1", "whether no mode grows"),
    "min_principal_resultant": _of("rate", "N m-1", "smallest principal film resultant of the equilibrium"),
    "rate": _of("rate", "rad s-1", "angular rate"),
}

_MASSES = "kg, kg m, kg m^2"
APPENDAGE: Variables = {
    "frequency": MODES["frequency"],
    "damping_ratio": _SPINNING["damping_ratio"],
    "participation": _of("mode direction", "kg^1/2, kg^1/2 m", "participation in rigid motions about the point"),
    "effective_mass": _of("mode direction", "kg, kg m^2", "effective mass and inertia"),
    "rigid_mass": _of("direction other_direction", _MASSES, "mass matrix of the rigid structure"),
    "free_mass": _of("direction other_direction", _MASSES, "mass matrix that all modes together hold"),
    "residual_mass": _of("direction other_direction", _MASSES, "rigid mass less that of these modes"),
    "completeness": _of("direction", "1", "part of the free mass that these modes hold"),
    "point": _of("component", "m", "reference point"),
}
AUTHORITY: Variables = {
    "frequency": MODES["frequency"],
    "stiffness": _of("input mode", "1", "relative change of the mode's stiffness by the input at its limit"),
    "force": _of("input mode", "N/kg^1/2", "force on the mass-normalised mode by the input at its limit"),
    "deflection": _of("input mode", "m", "largest static displacement of the mode by that force"),
    "stroke": _of("input", "m", "length that is reeled in for the limit"),
    "limit": _of("input", "", "largest size of the input"),
}

# Dimensions behind time, and time itself, are those of the data.
POD: Variables = {
    "shape": _of("mode", "1", "proper orthogonal mode"),
    "value": _of("mode", "({units})^2", "proper orthogonal value"),
    "participation": _of("mode", "1", "participation factor"),
    "cumulative": _of("mode", "1", "cumulative participation"),
    "coefficient": _of("mode", "{units}", "response along the mode"),
    "mode": _of("mode", "", "proper orthogonal mode"),
    "dominant_shape": _of("", "1", "dominant shape"),
}
MAC: Variables = {
    "mode": _of("rank", "1", "number of the normal mode"),
    "mac": _of("rank", "1", "modal assurance criterion"),
    "cumulative": _of("rank", "1", "cumulative criterion"),
    "frequency": _of("rank", "Hz", "natural frequency"),
    "rank": _of("rank", "", "rank"),
}
SPECTRUM: Variables = {
    "amplitude": _of("frequency", "{units}", "amplitude of {name}"),
    "energy": _of("frequency", "({units})^2 s/Hz", "energy spectral density of {name}"),
    "frequency": _of("frequency", "Hz", "frequency"),
}
SCALOGRAM: Variables = {
    "magnitude": _of("frequency time", "{units}", "wavelet amplitude of {name}"),
    "ridge": _of("time", "Hz", "frequency of largest wavelet amplitude"),
    "ridge_magnitude": _of("time", "{units}", "largest wavelet amplitude of {name}"),
    "cone_of_influence": _of("time", "Hz", "lowest frequency free of end effects"),
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


def dataset_of(name: str, given: Any, *wanted: str, remedy: str, table: Variables | None = None) -> xr.Dataset:
    """Return the Dataset of a result, itself, of a `Run` or `Modes`; InputError unless it has what is wanted.

    With a ``table`` the variables must have the dimensions that it tells, in any order.
    """
    import xarray as xr  # half a second, which a case that is refused need not wait for

    found = given
    if not isinstance(given, xr.Dataset | xr.DataArray | type | np.ndarray):
        found = given.to_dataset() if hasattr(given, "to_dataset") else getattr(given, "data", given)
    dims = {variable: table[variable].dims if table else () for variable in wanted}
    words = [f"{variable!r} ({', '.join(names)})" if names else repr(variable) for variable, names in dims.items()]
    expected = f"a Dataset with {', '.join(words)}" if wanted else "a Dataset"
    data = checks.instance(name, found, xr.Dataset, expected, remedy=remedy)
    if any(variable not in data for variable in wanted):
        raise InputError(f"{name}: expected {expected}, got {shown(sorted(map(str, data.variables)))}; {remedy}")
    for variable, names in dims.items():
        if names and set(data[variable].dims) != set(names):
            raise InputError(f"{name}: expected {expected}, got {variable!r} {data[variable].dims}; {remedy}")
    return data


def mesh_variables(model: Model) -> dict[str, tuple[Any, ...]]:
    """Mesh as Dataset variables, so that results can be drawn and written without the model.

    ``link`` is there with links or springs, ``held`` with supports. ``triangle`` holds linear triangles. Where the
    film's elements are others, these are what stands for them in pictures, ``triangle_owner`` tells the film element of
    each, and ``membrane``, ``membrane_cell`` (VTK's number of the cell type) and ``membrane_edge`` hold the elements
    themselves and the lines between them.
    """
    lines = {"triangle": model.triangles, "cable": model.cables, "beam": model.beams}
    arrays = {"node_position": model.nodes, **lines}
    if any(group.shape != TRIANGLE3 for group in model.surfaces):
        arrays |= _membranes(model)
    if len(model.linked_pairs):
        arrays["link"] = np.unique(np.sort(model.linked_pairs, axis=1), axis=0)
    if model.supports:
        arrays["held"] = np.unique(np.concatenate([support.nodes for support in model.supports]))
    return described(MESH, arrays)


def _membranes(model: Model) -> dict[str, Any]:
    corners = [group.connectivity for group in model.surfaces]
    widest = max(nodes.shape[1] for nodes in corners)
    rows = [np.pad(nodes, ((0, 0), (0, widest - nodes.shape[1])), constant_values=-1) for nodes in corners]
    edges = [
        group.connectivity[:, edge[k : k + 2]]
        for group in model.surfaces
        for edge in group.shape.edges
        for k in range(len(edge) - 1)
    ]
    return {
        "triangle_owner": model.triangle_owner,
        "membrane": np.concatenate(rows),
        "membrane_cell": np.repeat([group.shape.vtk_cell for group in model.surfaces], [len(row) for row in rows]),
        "membrane_edge": np.unique(np.sort(np.concatenate(edges), axis=1), axis=0),
    }
