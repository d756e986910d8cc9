"""A reduced plant as data for a page: what its steps need, what is drawn, and a run to check the page against."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.control.compiled.axis_parts import AxisModel
from tautflex.control.compiled.parts import WHEEL, Drives, Sensing
from tautflex.control.signals import labels_of, units_of
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.pages.board import Board
from tautflex.pages.content import mesh_data, nearest_nodes
from tautflex.pages.encode import exact, packed, quantised
from tautflex.pages.explorable import Explorable
from tautflex.pages.film_stress import film_data
from tautflex.pages.played import Turn, played
from tautflex.plot.shapes import drawn_factor
from tautflex.reduction.polynomial.monomials import monomial_sizes

# Sliders of actuators at most; part of the span that a whole push of the hand is drawn with.
_SLIDERS, _DRAWN = 6, 0.15
# The run that pages are checked against: intervals, part of a limit that is held, when a place is pushed [s].
_CHECKED, _HELD, _PUSHED = 100, 0.3, (0.2, 0.25)
# Time after a slew in which its largest deflection is sought [s].
_AFTER = 1.0
# Parts of a model that its steps take; what goes back through the fields is their transpose.
_STEPPED = (
    "mass", "damping", "linear", "still", "quadratic", "fields", "viscous", "reach", "spin", "turned", "turning",
    "pull", "pull_slope", "square_follow", "square_through", "inertia", "load", "stress", "torque", "arms",
)  # fmt: skip


def plant_data(given: Explorable, board: Board) -> dict[str, Any]:
    """Everything that a page knows of a plant.

    Raises
    ------
    InputError
        If the loop is not stable at the start already.
    """
    plant, mesh, law = board.plant, board.drawing.mesh, given.law
    model, drives, sensing = board.constants
    names, units, readings = labels_of(plant.inputs), units_of(plant.inputs), labels_of(plant.outputs)
    omega, vectors = _modes(model)
    ratios = np.einsum("rn,rs,sn->n", vectors, model.damping, vectors) / (2.0 * omega)
    # What a slew moves most, by its static answer.
    moved = int(np.argmax(np.abs(vectors.T @ model.reach) / omega**2))
    frequency, ratio = float(omega[moved] / (2.0 * np.pi)), float(ratios[moved])
    if law.shaper != "none":
        frequency, ratio = float(law.frequencies[0]), float(np.ravel(law.damping_ratios)[0])
    turn = Turn.of(given.slew, given.axis, law.shaper, frequency, ratio)
    gains = {"stiffness": law.stiffness, "damping": law.damping, "inertia": law.inertia}
    pulls = [
        {"name": names[k].replace("_", " "), "number": k, "unit": units[k], "limit": float(drives.limit[k])}
        for k in range(1, board.first_hand)
        if np.isfinite(drives.limit[k])
    ][:_SLIDERS]
    interval, step, steps = (float(value) for value in drives.times[:3])
    magnification, sizes = _sizes(board, turn, gains)
    hands = _hands(board, model, magnification)
    shapes = given.rom.state.system.translations(given.rom.basis.kept)[:, board.drawing.nodes]
    nearest = nearest_nodes(mesh, np.array([np.pad(place, (0, 3 - len(place))) for place in board.probes.values()]))
    return {
        "model": {name: exact(getattr(model, name)) for name in _STEPPED}
        | {name: packed(getattr(model, name)) for name in ("first", "second")},
        "drives": _drives(drives, interval),
        "sensing": _sensing(sensing, given.axis),
        "interval": interval,
        "step": step,
        "steps": int(steps),
        "axis": given.axis,
        "torque": 0,
        "pulls": pulls,
        "readings": readings,
        "seen": {name: readings.index(name) for name in ("attitude", "rate", "rms") if name in readings}
        | {"w": [k for k, name in enumerate(readings) if name.startswith("w")]},
        "gains": gains,
        "turn": turn._asdict(),
        "lowest": {"frequency": float(omega[0] / (2.0 * np.pi)), "ratio": float(ratios[0])},
        "mesh": mesh_data(mesh) | {"probes": {"names": list(board.probes), "nodes": nearest}},
        "shapes": quantised(np.moveaxis(shapes, 0, -1)),
        "film": film_data(plant, board.drawing, sizes),
        "hands": hands,
        "magnification": magnification,
        "check": _check(board, turn, gains, pulls, hands),
        "title": given.title,
        "remarks": given.remarks,
    }


def _drives(drives: Drives, interval: float) -> dict[str, Any]:
    decay = np.exp(-interval / np.where(drives.lag > 0.0, drives.lag, np.inf))
    names = "limit", "rate", "lag", "resolution", "lowest", "momentum"
    parts = {name: exact(getattr(drives, name)) for name in names}
    whole = {"delay": packed(drives.delay), "wheel": packed(drives.kind == WHEEL)}
    return parts | whole | {"decay": exact(decay)}


def _sensing(sensing: Sensing, axis: int) -> dict[str, Any]:
    parts = {name: exact(getattr(sensing, name)) for name in ("look", "speed", "level", "form")}
    turned = {"rotation": exact(sensing.rotation[:, axis]), "rate": exact(sensing.rate[:, axis])}
    return parts | turned | {"rms": packed(sensing.rms)}


def _modes(model: AxisModel) -> tuple[Array, Array]:
    """Angular frequencies [rad/s] and mass-normalised vectors by columns, on a hub that is held."""
    lower = np.linalg.inv(np.linalg.cholesky(model.mass))
    squares, vectors = np.linalg.eigh(lower @ model.linear @ lower.T)
    return np.sqrt(squares), lower.T @ vectors


def _sizes(board: Board, turn: Turn, gains: dict[str, float]) -> tuple[float, Array]:
    """Factor that a slew is drawn with; what it makes of coordinates, monomials, command and frame, shape (z,)."""
    plant, found = board.plant, list[Array]()
    count = int(np.ceil((turn.duration + turn.delay + _AFTER) / plant.interval))
    measured = played(plant, turn, gains, count, told=lambda: found.append(plant.coordinates()))
    if plant.failed[0]:
        raise InputError(
            f"law: expected a loop that is stable through a slew of {turn.angle:g} rad in {turn.duration:g} s, got one "
            "whose motion outgrows its steps; lower the gains or the angle, or give it more time"
        )
    readings = labels_of(plant.outputs)
    seen = [k for k, name in enumerate(readings) if name.startswith("w")]
    drawn = drawn_factor(float(np.abs(measured[:, seen]).max(initial=0.0)), board.drawing.mesh.span)
    amplitude, largest = plant.rom.basis.amplitude, np.abs(found).max(axis=0)
    amplitude = np.maximum(largest, amplitude * np.linalg.norm(largest) / np.linalg.norm(amplitude))
    rate = measured[:, readings.index("rate")]
    turned = np.abs(rate).max() ** 2 + np.abs(np.diff(rate)).max() / plant.interval
    across = 1.0 - np.eye(3)["xyz".index(plant.hub.axes)]  # type: ignore[union-attr]
    limit = board.constants[1].limit
    command = np.where(np.isfinite(limit), limit, 1.0)
    frame = turned * np.append(np.outer(across, across), np.zeros(3))
    return drawn, np.concatenate([amplitude, monomial_sizes(amplitude), command, frame])


def _hands(board: Board, model: AxisModel, magnification: float) -> dict[str, Any]:
    """Places that can be pushed, as nodes of the drawing; that which gives most; and the force of a whole push [N]."""
    loads = model.load[1 + board.first_hand :]
    gives = np.einsum("hr,rh->h", loads, np.linalg.solve(model.linear.T, loads.T))
    strength = (
        _DRAWN * board.drawing.mesh.span / (magnification * float(gives.max(initial=0.0))) if gives.any() else 0.0
    )
    nodes = np.searchsorted(board.drawing.nodes, board.hands).tolist()
    return {"first": board.first_hand, "nodes": nodes, "knock": int(np.argmax(gives)) if len(gives) else 0} | {
        "strength": strength
    }


def _check(
    board: Board, turn: Turn, gains: dict[str, float], pulls: list[dict[str, Any]], hands: dict[str, Any]
) -> dict[str, Any]:
    """A run of everything at once, and its measurements."""
    held = {each["number"]: _HELD * each["limit"] for each in pulls[:1]}
    start, end = _PUSHED
    knocks = [{"number": hands["first"] + hands["knock"], "force": hands["strength"], "start": start, "end": end}]
    measured = played(board.plant, turn, gains, _CHECKED, held, knocks[: len(hands["nodes"])])
    asked = {"held": held, "knocks": knocks[: len(hands["nodes"])], "turn": turn._asdict(), "gains": gains}
    return asked | {"count": _CHECKED, "measured": exact(measured)}
