"""A plant to play with: the reduced model that steps, what is watched of it, and places that can be pushed."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from tautflex.control.actuators.actuator import Actuator
from tautflex.control.compiled.axis_parts import AxisModel
from tautflex.control.compiled.compiled_plant import CompiledPlant
from tautflex.control.compiled.parts import Drives, Sensing
from tautflex.control.sensors.attitude import Attitude
from tautflex.control.sensors.displacement import Displacement
from tautflex.control.sensors.rate import Rate
from tautflex.control.sensors.sensor import Sensor
from tautflex.control.sensors.surface_rms import SurfaceRms
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.nodal_force import NodalForce
from tautflex.numeric import Array, Indices
from tautflex.pages.explorable import Explorable
from tautflex.pages.thinning import Drawing, drawing_of
from tautflex.solvers.variables import mesh_variables

# Places of the film that can be pushed, and points that are watched; steps per radian of the fastest coordinate.
_HANDS, _PROBES, _FINE = 40, 3, 1.0 / 0.35
# What the page calls its own: names that no other actuator may have.
TORQUE, _HAND = "torque", "hand"


class Board(NamedTuple):
    """A plant to play with.

    Parameters
    ----------
    plant
        Commanded by a wheel, then what acts on the structure, then forces on the `hands`.
    drawing
        Mesh to draw.
    hands
        Nodes of the film that can be pushed along z, one number of the command each.
    probes
        Names and places of what is watched [m].
    """

    plant: CompiledPlant
    drawing: Drawing
    hands: Indices
    probes: dict[str, Array]

    @property
    def constants(self) -> tuple[AxisModel, Drives, Sensing]:
        """Arrays of the compiled loop."""
        model, drives, sensing = self.plant.constants
        return model, drives, sensing

    @property
    def first_hand(self) -> int:
        """Number of the first force in the command."""
        return len(self.constants[1].kind) - len(self.hands)


def board_of(given: Explorable) -> Board:
    """Plant with sensors to watch, and forces on places of the film.

    Raises
    ------
    InputError
        If an actuator has a name of the page's own, or does not fit.
    """
    state, rom = given.rom.state, given.rom
    nodes, drawing = state.model.nodes, drawing_of(xr.Dataset(mesh_variables(state.model)))
    hands = _spread(nodes, np.intersect1d(state.model.triangles, drawing.nodes))
    drives: dict[str, Any] = {TORQUE: given.torque}
    for name, drive in given.actuators.items():
        if name == TORQUE or name.startswith(_HAND):
            raise InputError(f"actuators: expected names that do not begin with 'torque' or 'hand', got {name!r}")
        drives[name] = drive
    for number, node in enumerate(hands.tolist()):
        drives[f"{_HAND}{number}"] = Actuator(effect=NodalForce([node], direction=(0.0, 0.0, 1.0)))
    probes = {name: np.asarray(place, dtype=float) for name, place in list(given.probes.items())[:_PROBES]}
    sensors: dict[str, Sensor] = {"attitude": Attitude(), "rate": Rate()}
    if len(hands):
        probes = probes or {"A": nodes[_lively(nodes, hands)]}
        sensors["rms"] = SurfaceRms()
    if probes:
        sensors["w"] = Displacement(tuple(tuple(place.tolist()) for place in probes.values()))
    c = rom.coefficients
    fastest = np.sqrt(float(np.linalg.eigvals(np.linalg.solve(c.mass, c.linear)).real.max()))
    step = given.interval / np.ceil(_FINE * given.interval * fastest)
    asked: dict[str, Any] = {"interval": given.interval, "time_step": step, "damping": given.damping}
    return Board(CompiledPlant(rom, given.hub, drives, sensors, **asked), drawing, hands, probes)


def _spread(nodes: Array, film: Indices) -> Indices:
    """Nodes of the film far from each other, in rising order."""
    if not len(film):
        return film
    places = nodes[film]
    chosen = [int(np.linalg.norm(places - places.mean(axis=0), axis=1).argmin())]
    away = np.linalg.norm(places - places[chosen[0]], axis=1)
    while len(chosen) < min(_HANDS, len(film)):
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return np.sort(film[chosen])


def _lively(nodes: Array, hands: Indices) -> int:
    """Place near a corner of the film, which most modes move."""
    low, high = nodes[hands].min(axis=0), nodes[hands].max(axis=0)
    return int(hands[np.linalg.norm(nodes[hands] - (low + 0.85 * (high - low)), axis=1).argmin()])
