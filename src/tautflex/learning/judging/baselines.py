"""Classical laws by short names, with first guesses of their numbers from the linear view of a loop."""

from __future__ import annotations

import numpy as np

from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.control.law import ControlLaw, FunctionLaw, added
from tautflex.control.laws.lqg import LQG
from tautflex.control.laws.pd import PD
from tautflex.control.laws.shaped_reference import ShapedReference
from tautflex.control.laws.stiffness_switching import StiffnessSwitching
from tautflex.control.laws.tension_damping import TensionDamping
from tautflex.control.linear import LinearPlant
from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.judging.scenarios import start_on
from tautflex.numeric import Array

LAWS = ("none", "pd", "lqg", "tension", "switching")
_SHAPERS = {"zv": "ZV", "zvd": "ZVD"}
_BANDWIDTH = 2.0  # of the attitude's loop [rad/s]
_DAMPING = 0.8  # its damping ratio
_MODES = 8  # that a law knows; an LQG knows as many more as it has to


def rest(time: float, measurement: Array) -> float:
    """No command."""
    return 0.0


def baseline(name: str, arena: Arena) -> ControlLaw:
    """Law by its name: parts of `LAWS` joined with ``+``, behind a shaper ``zv`` or ``zvd``, such as ``"zvd+pd"``.

    Raises
    ------
    InputError
        If the name is unknown, or the loop has not what the law needs.
    """
    parts = name.lower().split("+")
    shaper = _SHAPERS.get(parts[0])
    wanted = parts[1:] if shaper else parts
    for part in wanted:
        if part not in LAWS:
            known = f"{', '.join(LAWS)}, joined with +, behind zv or zvd"
            raise InputError(f"law: expected a name such as 'zvd+pd' of {known}, got {name!r}; choose some of them")
    if not wanted:
        raise InputError(f"law: expected a law behind {name!r}, got none; write for example {name}+pd")
    law = added(*(_law(part, arena) for part in wanted)) if len(wanted) > 1 else _law(wanted[0], arena)
    if shaper is None:
        return law
    frequencies, ratios = _ringing(arena)
    return ShapedReference(law, shaper, frequencies, ratios)


def _law(name: str, arena: Arena) -> ControlLaw:
    if name == "none":
        return FunctionLaw(rest)
    if name in ("tension", "switching"):
        return _tensions(name, arena)
    wheels = next((key for key, drive in arena.actuators.items() if isinstance(drive, HubTorque)), None)
    sensed = {channel.unit: channel.name for channel in reversed(arena.spec.measurements)}
    if wheels is None or not {"rad", "rad/s"} <= {*sensed}:
        text = f"law: expected a loop with a hub torque, attitude and rate for {name!r}, got none"
        raise InputError(f"{text}; choose 'tension' or 'none'")
    inertia = _inertia(arena.model, wheels, sensed["rad"])
    stiffness, damping = inertia * _BANDWIDTH**2, 2.0 * _DAMPING * _BANDWIDTH * inertia
    if name == "pd":
        return PD(stiffness, damping, inertia, attitude=sensed["rad"], rate=sensed["rad/s"], torque=wheels)
    tolerance = arena.task.attitude_tolerance
    tolerances = {sensed["rad"]: tolerance}
    tolerances |= {each.name: arena.task.surface_tolerance for each in arena.spec.measurements if each.unit == "m"}
    # As stiff as the PD: a gain that meets the limit within milliradians leaves a limit cycle behind each turn, since
    # the filter believes in commands that were cut.
    efforts = {wheels: stiffness * tolerance}
    most = arena.model.coordinates
    for modes in range(min(_MODES, most), most, 4):
        law = LQG(tolerances, efforts, modes=modes)
        try:
            start_on(law, arena)
        except InputError:  # of spillover
            continue
        return law
    return LQG(tolerances, efforts, modes=most)


def _tensions(name: str, arena: Arena) -> ControlLaw:
    kind = TensionDamping if name == "tension" else StiffnessSwitching
    modes = min(_MODES, arena.model.coordinates)
    laws = [
        kind((key,), float(np.max(arena.limits[arena.spec.command("commands", key)])), modes=modes)
        for key, drive in arena.actuators.items()
        if isinstance(drive, Actuator) and np.any(arena.model.bilinear[arena.spec.command("commands", key)])
    ]
    if not laws:
        raise InputError(f"law: expected an actuator that changes the stiffness for {name!r}, got none; choose 'pd'")
    return laws[0] if len(laws) == 1 else added(*laws)


def _inertia(model: LinearPlant, torque: str, attitude: str) -> float:
    """Inertia about the hub's axis [kg m^2]: ``-1/(w^2 G(iw))`` far below all modes."""
    w = 1e-2
    column, row = model.inputs.index(_first(model.inputs, torque)), model.outputs.index(_first(model.outputs, attitude))
    turn = model.C[row] @ np.linalg.solve(1j * w * np.eye(len(model.A)) - model.A, model.B[:, column])
    return float(abs(1.0 / (w * w * turn)))


def _ringing(arena: Arena, count: int = 2) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Frequencies [Hz] and damping ratios of the modes that torques on the hub make the film ring with most."""
    model = arena.model
    torque = [k for k, unit in enumerate(model.input_units) if unit == "N m"]
    film = [k for k, unit in enumerate(model.output_units) if unit in ("m", "m/s")]
    if not torque or not film:
        raise InputError("law: expected hub torques and a reading of the film for a shaper, got none; leave it out")
    values, right = np.linalg.eig(model.A)
    strength = np.abs(model.C[film] @ right).max(axis=0) * np.abs(np.linalg.solve(right, model.B[:, torque])).max(
        axis=1
    )
    ringing = np.flatnonzero(values.imag > 1e-6 * np.abs(values).max(initial=0.0))
    best = ringing[np.argsort(-strength[ringing], kind="stable")[:count]]
    best = best[np.argsort(values[best].imag)]
    frequencies = np.abs(values[best].imag) / (2.0 * np.pi)
    ratios = np.clip(-values[best].real / np.abs(values[best]), 0.0, 0.9)
    return tuple(frequencies.tolist()), tuple(ratios.tolist())


def _first(labels: tuple[str, ...], name: str) -> str:
    return next(label for label in labels if label.partition("[")[0] == name)
