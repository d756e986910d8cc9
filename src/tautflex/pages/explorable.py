"""What a page can be made to explore: a reduced model on a hub of one axis, and what stands in for what nobody gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.case import build
from tautflex.case.prepared import reduced_model
from tautflex.case.schema import Case
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.drive import Drive
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.control.laws.pd import PD
from tautflex.errors import InputError, TautflexError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.effects.tension_group import TensionGroup
from tautflex.motion.fixed_axis import FixedAxis, Slew
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import Maneuver
from tautflex.numeric import Array
from tautflex.reduction.polynomial.model import ReducedModel, reduce
from tautflex.solvers.modal.rigid import rigid_mass
from tautflex.solvers.static.equip import equip
from tautflex.solvers.static.prestress import PrestressedState

AXES = "xyz"
# What stands in: part of the largest pretension, interval [s], damping [1/s, s], slew [rad, s], loop's bandwidth
# [rad/s] and damping ratio.
_PULL, _INTERVAL, _DAMPING, _SLEW, _LOOP = 0.6, 0.01, (1e-3, 1e-3), (0.5, 2.0), (2.0, 0.8)


@dataclass
class Explorable:
    """A reduced model and all that moves it.

    Parameters
    ----------
    rom
        Reduced model of a state that is equipped for the actuators.
    hub
        Of one axis, at rest.
    torque
        Wheel about this axis.
    actuators
        What acts on the structure.
    damping
        Of the structure.
    law
        Attitude control.
    slew
        What the hub is to follow.
    interval
        Time between two commands [s].
    probes
        Points of the film to watch, by name; empty: one is chosen.
    title
        Of the page.
    remarks
        What stands in for what nobody gave, in words.
    """

    rom: ReducedModel
    hub: FreeHub
    torque: HubTorque
    actuators: dict[str, Drive]
    damping: Damping
    law: PD
    slew: Slew
    interval: float = _INTERVAL
    probes: Mapping[str, Any] = field(default_factory=dict)
    title: str = "antenna"
    remarks: list[str] = field(default_factory=list)

    @property
    def axis(self) -> int:
        """Number of the axis."""
        return AXES.index(self.hub.axes)


def explorable(
    model: Case | PrestressedState | ReducedModel,
    hub: FreeHub | None = None,
    actuators: Mapping[str, Drive] | None = None,
    damping: Damping | None = None,
    law: PD | None = None,
    slew: Slew | None = None,
) -> Explorable:
    """Take what is given, from the case what it has, and say what stands in for the rest.

    Raises
    ------
    InputError
        If the structure cannot be built or reduced, or an actuator does not fit it.
    """
    kinds, text = (Case, PrestressedState, ReducedModel), "a case, a prestressed state or a reduced model"
    checks.instance("model", model, kinds, text, remedy="load_case('m2.toml') gives a case")
    asked: dict[str, tuple[Any, type, str]] = {
        "hub": (hub, FreeHub, "a FreeHub(...)"),
        "damping": (damping, Damping, "a damping such as Rayleigh(1e-3, 1e-3)"),
        "law": (law, PD, "a PD(...)"),
        "slew": (slew, Slew, "a Slew(...)"),
    }
    for name, (given, kind, words) in asked.items():
        checks.instance(name, given, (kind, type(None)), f"{words}, or None")
    case = model if isinstance(model, Case) else None
    said, more = list[str](), dict[str, Any]()
    state = build.build_state(model) if isinstance(model, Case) else getattr(model, "state", model)
    assert isinstance(state, PrestressedState)
    turn: Maneuver | None = slew
    own = actuators
    if case is not None:
        more = {"probes": case.output.probes, "interval": case.loop.interval if case.controller else _INTERVAL}
        hub = case.hub.build() if hub is None and case.hub is not None else hub
        own = build.build_actuators(case, state) if actuators is None else actuators
        damping = build.build_damping(case, state) if damping is None else damping
        law = _law_of(case) if law is None else law
        turn = build.build_maneuver(case) if slew is None else slew
        if case.inputs:
            said.append("the inputs in time of the case are left out")
    axis = AXES.index(hub.axes) if hub is not None and hub.axes in AXES else _axis_of(turn, said)
    wheel, drives = _parted(own, axis, said)
    rom = model if isinstance(model, ReducedModel) else None
    if actuators is None and not drives and rom is None:
        state, drives = _pulled(state, said)
    # Sliders move slowly: what answers them does so at once, and needs no coordinates of its own.
    if rom is None and case is not None:
        rom = reduced_model(case, state, [])
    if rom is None:
        rom = reduce(state)
        said.append("reduced by the standard basis, ModalBasis()")
    turning = _hub(hub, axis, rom, said)
    inertia = float(turning.tensor[axis, axis]) + _inertia(rom.state, axis)
    if damping is None or not any(np.any(value) for value in damping.numbers.values()):
        damping = Rayleigh(*_DAMPING)
        said.append(f"damping alpha = {_DAMPING[0]:g} 1/s, beta = {_DAMPING[1]:g} s, as there was none")
    if law is None:
        law = PD(inertia * _LOOP[0] ** 2, 2.0 * _LOOP[1] * inertia * _LOOP[0], inertia)
        said.append(f"attitude control of {_LOOP[0]:g} rad/s")
    if not isinstance(turn, Slew):
        turn = Slew(*_SLEW, "bang-bang", tuple(np.eye(3)[axis].tolist()))
        said.append(f"a slew of {_SLEW[0]:g} rad in {_SLEW[1]:g} s")
    if abs(turn.angle) > np.pi:
        text = f"slew: expected an angle within half a turn, {np.pi:.4g} rad, as star trackers tell it"
        raise InputError(f"{text}, got {turn.angle:g}; choose a smaller one")
    return Explorable(rom, turning, wheel, drives, damping, law, turn, remarks=said, **more)


def _law_of(case: Case) -> PD | None:
    """The PD law of a case, if it has one."""
    several = case.controller if isinstance(case.controller, tuple) else (case.controller,)
    laws = [given.build() for given in several if given is not None]
    laws = [getattr(each, "law", each) for each in laws]  # behind a shaper
    return next((each for each in laws if isinstance(each, PD)), None)


def _axis_of(maneuver: Any, said: list[str]) -> int:
    """Axis of the hub that is nearest to that of a maneuver."""
    direction = np.asarray(maneuver.axis if isinstance(maneuver, FixedAxis) else (1.0, 0.0, 0.0), dtype=float)
    axis = int(np.abs(direction).argmax())
    if np.abs(np.delete(direction, axis)).max() > 1e-9 * np.abs(direction).max():
        said.append(f"it turns about {AXES[axis]}, the axis nearest to that of the maneuver")
    return axis


def _parted(actuators: Mapping[str, Drive] | None, axis: int, said: list[str]) -> tuple[HubTorque, dict[str, Drive]]:
    """Wheel about an axis, and what acts on the structure."""
    if actuators is not None:
        checks.instance("actuators", actuators, Mapping, "a table of names and actuators")
    wheel, drives = None, dict[str, Drive]()
    for name, drive in (actuators or {}).items():
        checks.instance(f"actuators.{name}", drive, Drive, "an actuator such as HubTorque(...)")
        if not isinstance(drive, HubTorque):
            drives[name] = replace(drive, monitor=False)  # sliders do not pump
        elif AXES[axis] in drive.axis and wheel is None:
            limit = drive.limit
            if limit is not None and np.ndim(limit):
                limit = float(np.ravel(np.asarray(limit))[drive.axis.index(AXES[axis])])
            wheel = replace(drive, axis=AXES[axis], limit=limit)
    if wheel is None:
        said.append("a wheel without limits")
    return HubTorque(AXES[axis]) if wheel is None else wheel, drives


def _pulled(state: PrestressedState, said: list[str]) -> tuple[PrestressedState, dict[str, Drive]]:
    """A state whose cables can be pulled, those along x and those along y."""
    drives = dict[str, Drive]()
    for letter in AXES[:2] if len(state.model.cables) else "":
        effect = TensionGroup(letter, command="tension", share="pretension")
        try:
            equipped = equip(state, [effect])
            most = _PULL * float(-effect.prepare(equipped.system).lowest)
        except TautflexError:
            continue  # no cables that way, or none that may be pulled
        if np.isfinite(most) and most > 0.0:
            state, drives[f"tension_{letter}"] = equipped, Actuator(effect=effect, limit=most)
    if drives:
        said.append(f"drives that hold the cables' tension, up to {100.0 * _PULL:g} % beside the pretension")
    return state, drives


def _inertia(state: PrestressedState, axis: int) -> float:
    """Moment of inertia of the structure about an axis through the origin [kg m^2]."""
    return float(rigid_mass(state.system.inertia, np.zeros(3))[3 + axis, 3 + axis])


def _hub(hub: FreeHub | None, axis: int, rom: ReducedModel, said: list[str]) -> FreeHub:
    """A hub at rest that turns about one axis."""
    letter = AXES[axis]
    if hub is None:
        own = 2.0 * _inertia(rom.state, axis)
        said.append(f"a hub that turns about {letter} with {own:.3g} kg m², twice the structure's own")
        return FreeHub(1.0, np.full(3, own), axes=letter)
    if hub.axes != letter:
        said.append(f"the hub turns about {letter} alone")
    tensor: Array = hub.tensor
    return FreeHub(hub.mass, tensor, hub.center, axes=letter)
