"""Classes that a case file can name: a class is its own section, and this is the one list of them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pkgutil import resolve_name
from typing import Any, TypeVar

from tautflex.errors import InputError, TautflexError

ENTRY_POINTS = "tautflex.plugins"
Class = TypeVar("Class", bound=type)


def kind_of(cls: type) -> str:
    """Name of a class in a case file: its attribute ``kind``, or its own name, as ``"spin-up"`` for SpinUp.

    Raises
    ------
    InputError
        If the attribute is no name that a case file could hold.
    """
    own = getattr(cls, "kind", None)
    if own is None or isinstance(own, property):
        own = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", cls.__name__).lower()
    if not isinstance(own, str) or not re.fullmatch(r"[\w.+-]+", own):
        text = f"register: expected as kind of {cls.__name__} a name of letters, digits and hyphens, got {own!r}"
        raise InputError(f'{text}; write for example kind: ClassVar[str] = "my-stop"')
    return own


class Registry(Mapping[str, type]):
    """Classes of one role by their names in a case file, installed plugins included.

    A class of tautflex is imported when it is asked for: numerics that a case does not name cost its reader no time.

    Parameters
    ----------
    role
        What its classes are, in a word.
    bases
        Places of base classes, any of which makes a class one of them; the first is the public one.
    classes
        Places of those of tautflex, ``"module:Class"``.
    """

    def __init__(self, role: str, bases: tuple[str, ...], classes: Mapping[str, str]) -> None:
        self.role, self._bases = role, bases
        self._classes: dict[str, Any] = dict(classes)

    @property
    def bases(self) -> tuple[type, ...]:
        """Base classes."""
        return tuple(map(_imported, self._bases))

    def __iter__(self) -> Iterator[str]:
        load_installed()
        return iter(self._classes)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __getitem__(self, kind: str) -> type:
        load_installed()
        return _imported(self._classes[kind])

    def add(self, cls: type) -> None:
        """Add a class; a newer one of the same name and file replaces it, another one is refused."""
        kind = kind_of(cls)
        known = _imported(self._classes.setdefault(kind, cls))
        if (known.__module__, known.__qualname__) != (cls.__module__, cls.__qualname__):
            text = f"register: expected a new name of a {self.role}, got {kind!r}, which {known.__module__} has"
            raise InputError(f"{text}; rename the class or give it an attribute kind")
        self._classes[kind] = cls


def _imported(place: Any) -> Any:
    return resolve_name(f"tautflex.{place}") if isinstance(place, str) else place


MANEUVERS = Registry(
    "maneuver",
    ("motion.kinematics:Maneuver",),
    {
        "stop": "motion.fixed_axis:Stop",
        "none": "motion.kinematics:AtRest",
        "spin-up": "motion.fixed_axis:SpinUp",
        "slew": "motion.fixed_axis:Slew",
        "tabulated": "motion.tabulated:Tabulated",
        "base-acceleration": "motion.translation:BaseAcceleration",
        "sequence": "motion.sequence:Sequence",
    },
)
METHODS = Registry(
    "method",
    ("solvers.transient.methods.scheme:Method", "solvers.transient.explicit:ExplicitMethod"),
    {
        "wilson-theta": "solvers.transient.methods.wilson:WilsonTheta",
        "generalized-alpha": "solvers.transient.methods.generalized_alpha:GeneralizedAlpha",
        "newmark": "solvers.transient.methods.generalized_alpha:Newmark",
        "hht": "solvers.transient.methods.generalized_alpha:HHT",
        "bathe": "solvers.transient.methods.bathe:Bathe",
        "energy-conserving": "solvers.transient.methods.energy_conserving:EnergyConserving",
        "central-difference": "solvers.transient.methods.central_difference:CentralDifference",
        "condensed-difference": "solvers.transient.methods.condensed_difference:CondensedDifference",
    },
)
INPUTS = Registry(
    "input",
    ("mechanics.loads.inputs:TimeInput",),
    {
        "nodal-force": "mechanics.loads.effects.nodal_force:NodalForce",
        "edge-force": "mechanics.loads.effects.edge_force:EdgeForce",
        "pressure": "mechanics.loads.effects.film_pressure:Pressure",
        "cable-tension": "mechanics.loads.effects.cable_tension:CableTension",
        "tension-group": "mechanics.loads.effects.tension_group:TensionGroup",
        "stay-cable": "mechanics.loads.effects.stay_cable:StayCable",
        "membrane-temperature": "mechanics.loads.effects.temperature.membrane:MembraneTemperature",
        "cable-temperature": "mechanics.loads.effects.temperature.cables:CableTemperature",
        "frame-temperature": "mechanics.loads.effects.temperature.frame:FrameTemperature",
        "solar-pressure": "mechanics.loads.effects.solar_pressure:SolarPressure",
        "support-motion": "mechanics.loads.effects.support_motion:SupportMotion",
        "piezo-film": "mechanics.loads.effects.piezo_film:PiezoFilm",
        "piezo-pair": "mechanics.loads.effects.piezo_pair:PiezoPair",
    },
)
DAMPINGS = Registry(
    "damping",
    ("mechanics.dampings.damping:Damping",),
    {"rayleigh": "mechanics.dampings.rayleigh:Rayleigh", "modal": "mechanics.dampings.modal:Modal"},
)
BASES = Registry("basis", ("reduction.bases.vectors:Basis",), {"modal": "reduction.bases.modal_basis:ModalBasis"})
LINKS = Registry(
    "link",
    ("structure.links.link:Link",),
    {
        "rigid": "structure.links.rigid:RigidLink",
        "tie": "structure.links.tie:Tie",
        "distributing": "structure.links.distributing:DistributingLink",
        "attachment": "structure.links.attachment:Attachment",
        "equation": "structure.links.equation:LinkEquation",
    },
)
SENSORS = Registry(
    "sensor",
    ("control.sensors.sensor:Sensor",),
    {
        "attitude": "control.sensors.attitude:Attitude",
        "rate": "control.sensors.rate:Rate",
        "displacement": "control.sensors.displacement:Displacement",
        "velocity": "control.sensors.velocity:Velocity",
        "cable-tension": "control.sensors.cable_tension:CableTensionSensor",
        "surface-rms": "control.sensors.surface_rms:SurfaceRms",
        "modal-coordinates": "control.sensors.modal_coordinates:ModalCoordinates",
    },
)
CONTROLLERS = Registry(
    "controller",
    ("control.law:ControlLaw",),
    {
        "pd": "control.laws.pd:PD",
        "lqr": "control.laws.lqr:LQR",
        "lqg": "control.laws.lqg:LQG",
        "mpc": "control.laws.mpc:MPC",
        "policy": "control.laws.policy:PolicyLaw",
        "positive-position-feedback": "control.laws.ppf:PositivePositionFeedback",
        "independent-modal-control": "control.laws.imsc:IndependentModalControl",
        "tension-damping": "control.laws.tension_damping:TensionDamping",
        "stiffness-switching": "control.laws.stiffness_switching:StiffnessSwitching",
        "shaped-reference": "control.laws.shaped_reference:ShapedReference",
    },
)


class _Driven(Registry):
    """What a plant may command: wheels, and every effect that may also be an input in time."""

    def __iter__(self) -> Iterator[str]:
        yield from super().__iter__()
        effect = _imported("mechanics.loads.inputs:Effect")
        yield from (kind for kind, cls in INPUTS.items() if issubclass(cls, effect))

    def __getitem__(self, kind: str) -> type:
        return super().__getitem__(kind) if kind in self._classes else INPUTS[kind]


ACTUATORS = _Driven(
    "actuator",
    ("control.actuators.hub_torque:HubTorque",),
    {"hub-torque": "control.actuators.hub_torque:HubTorque"},
)
TASKS = Registry(
    "task",
    ("control.tasks.task:Task",),
    {
        "slew": "control.tasks.slew:SlewTask",
        "stop": "control.tasks.stop:StopTask",
        "hold": "control.tasks.hold:HoldTask",
    },
)
_ALL = (MANEUVERS, METHODS, INPUTS, DAMPINGS, BASES, LINKS, SENSORS, CONTROLLERS, TASKS)
# Classes for models, which keep their own lists.
_PARTS = {"elements:Element": "elements:register_element", "elements:Law": "elements:register_law"}


def register(cls: Class) -> Class:
    """Make a class of yours known: to case files, and an element or a constitutive law to models.

    May stand as a decorator. What the class is, is seen from its base: `Element`, `Law`, `Maneuver`, `Method`,
    `TimeInput`, `Damping`, `Basis`, `Link`, `Sensor`, `ControlLaw` or `Task`. Its name in a case file is that of
    the class in small letters with hyphens, or its attribute ``kind``; its fields are the keys, its docstring is their
    help, and an `InputError` of its ``__post_init__`` is the message about a wrong value.

    Parameters
    ----------
    cls
        Frozen dataclass.

    Returns
    -------
    type
        The class itself.

    Raises
    ------
    InputError
        If it is no class, no dataclass, nothing that tautflex knows a place for, or its name is taken.
    """
    if not isinstance(cls, type):
        raise InputError(f"register: expected a class, got {cls!r}; write register(MyClass)")
    for base, place in _PARTS.items():
        if issubclass(cls, _imported(base)):
            return _imported(place)(cls)
    registry = next((one for one in _ALL if issubclass(cls, one.bases)), None)
    if registry is None:
        names = ", ".join(f"tf.{_imported(base).__name__}" for base in (*_PARTS, *(one._bases[0] for one in _ALL)))
        text = f"register: expected a subclass of one of {names}, got {cls.__name__}"
        raise InputError(f"{text}; see tests/extension for one of each")
    if is_dataclass(cls) and any(field.name == "kind" for field in fields(cls)):
        text = f"register: expected no field kind in {cls.__name__}, which names the class in a case file"
        raise InputError(f"{text}; give the field another name, or annotate it as ClassVar")
    if not is_dataclass(cls):
        raise InputError(f"register: expected a dataclass, got {cls.__name__}; put @dataclass(frozen=True) above it")
    registry.add(cls)
    return cls


@cache
def load_installed() -> None:
    """Import what installed packages offer in the entry point group ``tautflex.plugins``, once.

    An entry point names a module that calls `register`, or a class, which is then registered.

    Raises
    ------
    InputError
        If one of them cannot be imported; the message names the package.
    """
    for entry in entry_points(group=ENTRY_POINTS):
        _load(entry)


def _load(entry: EntryPoint) -> None:
    try:
        found = entry.load()
    except TautflexError:
        raise
    except Exception as error:  # whatever a stranger's module raises is one line about that module
        text = f"{ENTRY_POINTS}: cannot load the plugin {entry.name!r} = {entry.value!r}"
        raise InputError(f"{text} ({type(error).__name__}: {error}); repair or uninstall its package") from None
    if isinstance(found, type):
        register(found)
