"""Classes that a case file can name: a class is its own section, and this is the one list of them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from tautflex.elements import Element, Law, register_element, register_law
from tautflex.errors import InputError, TautflexError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.dampings.modal import Modal
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.cable_tension import CableTension
from tautflex.mechanics.loads.edge_force import EdgeForce
from tautflex.mechanics.loads.film_pressure import Pressure
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.mechanics.loads.membrane_temperature import MembraneTemperature
from tautflex.mechanics.loads.nodal_force import NodalForce
from tautflex.motion.fixed_axis import Slew, SpinUp, Stop
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.motion.sequence import Sequence
from tautflex.motion.tabulated import Tabulated
from tautflex.motion.translation import BaseAcceleration
from tautflex.reduction.bases.modal_basis import ModalBasis
from tautflex.reduction.bases.vectors import Basis
from tautflex.solvers.transient.explicit import ExplicitMethod
from tautflex.solvers.transient.methods.bathe import Bathe
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.methods.energy_conserving import EnergyConserving
from tautflex.solvers.transient.methods.generalized_alpha import HHT, GeneralizedAlpha, Newmark
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.methods.wilson import WilsonTheta

ENTRY_POINTS = "tautflex.plugins"
# Names that differ from that of the class.
_NAMES: dict[type, str] = {AtRest: "none", ModalBasis: "modal"}
Class = TypeVar("Class", bound=type)


def kind_of(cls: type) -> str:
    """Name of a class in a case file: its attribute ``kind``, or its own name, as ``"spin-up"`` for SpinUp."""
    own = getattr(cls, "kind", None)
    if isinstance(own, str):
        return own
    return _NAMES.get(cls) or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", cls.__name__).lower()


class Registry(Mapping[str, type]):
    """Classes of one role by their names in a case file, installed plugins included.

    Parameters
    ----------
    role
        What its classes are, in a word.
    bases
        Base classes, any of which makes a class one of them; the first is the public one.
    classes
        Those of tautflex.
    """

    def __init__(self, role: str, bases: tuple[type, ...], *classes: type) -> None:
        self.role, self.bases = role, bases
        self._classes = {kind_of(cls): cls for cls in classes}

    def __iter__(self) -> Iterator[str]:
        load_installed()
        return iter(self._classes)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __getitem__(self, kind: str) -> type:
        load_installed()
        return self._classes[kind]

    def add(self, cls: type) -> None:
        """Add a class; a newer one of the same name and file replaces it, another one is refused."""
        kind = kind_of(cls)
        known = self._classes.setdefault(kind, cls)
        if known is not cls and (known.__module__, known.__qualname__) != (cls.__module__, cls.__qualname__):
            text = f"register: expected a new name of a {self.role}, got {kind!r}, which {known.__module__} has"
            raise InputError(f"{text}; rename the class or give it an attribute kind")
        self._classes[kind] = cls


MANEUVERS = Registry("maneuver", (Maneuver,), Stop, AtRest, SpinUp, Slew, Tabulated, BaseAcceleration, Sequence)
METHODS = Registry(
    "method",
    (Method, ExplicitMethod),
    WilsonTheta,
    GeneralizedAlpha,
    Newmark,
    HHT,
    Bathe,
    EnergyConserving,
    CentralDifference,
)
INPUTS = Registry("input", (TimeInput,), NodalForce, EdgeForce, Pressure, CableTension, MembraneTemperature)
DAMPINGS = Registry("damping", (Damping,), Rayleigh, Modal)
BASES = Registry("basis", (Basis,), ModalBasis)
_ALL = (MANEUVERS, METHODS, INPUTS, DAMPINGS, BASES)


def register(cls: Class) -> Class:
    """Make a class of yours known: to case files, and an element or a constitutive law to models.

    May stand as a decorator. What the class is, is seen from its base: `Element`, `Law`, `Maneuver`, `Method`,
    `TimeInput`, `Damping` or `Basis`. Its name in a case file is that of the class in small letters with hyphens, or
    its attribute ``kind``; its fields are the keys, its docstring is their help, and an `InputError` of its
    ``__post_init__`` is the message about a wrong value.

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
    if issubclass(cls, Element):
        return register_element(cls)
    if issubclass(cls, Law):
        return register_law(cls)
    registry = next((one for one in _ALL if issubclass(cls, one.bases)), None)
    if registry is None:
        names = ", ".join(f"tf.{base.__name__}" for base in (Element, Law, *(one.bases[0] for one in _ALL)))
        text = f"register: expected a subclass of one of {names}, got {cls.__name__}"
        raise InputError(f"{text}; see tests/extension for one of each")
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
