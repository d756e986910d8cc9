"""tautflex: nonlinear dynamics of tensioned membrane antennas on maneuvering spacecraft.

Names are loaded when first used, so that importing the package costs nothing.

Examples
--------
>>> import tautflex as tf
>>> case = tf.load_case("m2.toml")            # doctest: +SKIP
>>> state = tf.solve_prestress(tf.build_model(case))  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tautflex._version import __version__

if TYPE_CHECKING:
    from tautflex import errors
    from tautflex.analysis import (
        amplitude,
        dominant_frequency,
        dominant_shape,
        mac,
        mac_table,
        maneuver_end,
        pod,
        scalogram,
        spectrum,
    )
    from tautflex.analysis.participation import appendage_data, dynamic_mass
    from tautflex.batch import Batch
    from tautflex.config import Case, load_case
    from tautflex.errors import (
        CaseError,
        InputError,
        MeshError,
        MissingExtraError,
        NotConvergedError,
        PrestressError,
        TautflexError,
        UnsupportedError,
    )
    from tautflex.exchange import MeshData, read_mesh
    from tautflex.exchange.appendage import save_appendage
    from tautflex.export import write_csv, write_vtu
    from tautflex.mechanics.damping import Rayleigh
    from tautflex.mechanics.film import film_states
    from tautflex.mechanics.inputs import CableTension, EdgeForce, FilmTemperature, NodalForce
    from tautflex.mechanics.loads import PressureLoad
    from tautflex.motion.attitude import attitude
    from tautflex.motion.base import BaseAcceleration
    from tautflex.motion.coupling import Coupling
    from tautflex.motion.hub import FreeHub, HubState
    from tautflex.motion.maneuvers import AtRest, Stop
    from tautflex.motion.sequence import Sequence
    from tautflex.motion.slew import Slew, SpinUp
    from tautflex.motion.tabulated import Tabulated
    from tautflex.reduction.basis import ModalBasis, PodBasis
    from tautflex.reduction.hyper import HyperReducedModel, hyper_reduce
    from tautflex.reduction.model import ReducedModel, reduce
    from tautflex.results import load, save
    from tautflex.solvers.adaptive import Adaptive
    from tautflex.solvers.campbell import campbell
    from tautflex.solvers.central_difference import CentralDifference
    from tautflex.solvers.dynamics import simulate
    from tautflex.solvers.energy_conserving import EnergyConserving
    from tautflex.solvers.generalized_alpha import HHT, GeneralizedAlpha, Newmark
    from tautflex.solvers.linear import linear_solver
    from tautflex.solvers.modal import solve_modes
    from tautflex.solvers.prestress import solve_prestress
    from tautflex.solvers.spinning import solve_spinning_modes
    from tautflex.solvers.static import solve_static
    from tautflex.solvers.tuning import tune_pretension
    from tautflex.solvers.wilson import WilsonTheta
    from tautflex.structure.materials import BeamSection, CableSection, Material, MembraneSection
    from tautflex.structure.model import Model, Support
    from tautflex.study.build import build_model

__all__ = [
    "HHT",
    "Adaptive",
    "AtRest",
    "BaseAcceleration",
    "Batch",
    "BeamSection",
    "CableSection",
    "CableTension",
    "Case",
    "CaseError",
    "CentralDifference",
    "Coupling",
    "EdgeForce",
    "EnergyConserving",
    "FilmTemperature",
    "FreeHub",
    "GeneralizedAlpha",
    "HubState",
    "HyperReducedModel",
    "InputError",
    "Material",
    "MembraneSection",
    "MeshData",
    "MeshError",
    "MissingExtraError",
    "ModalBasis",
    "Model",
    "Newmark",
    "NodalForce",
    "NotConvergedError",
    "PodBasis",
    "PressureLoad",
    "PrestressError",
    "Rayleigh",
    "ReducedModel",
    "Sequence",
    "Slew",
    "SpinUp",
    "Stop",
    "Support",
    "Tabulated",
    "TautflexError",
    "UnsupportedError",
    "WilsonTheta",
    "__version__",
    "amplitude",
    "appendage_data",
    "attitude",
    "build_model",
    "campbell",
    "dominant_frequency",
    "dominant_shape",
    "dynamic_mass",
    "errors",
    "film_states",
    "hyper_reduce",
    "linear_solver",
    "load",
    "load_case",
    "mac",
    "mac_table",
    "maneuver_end",
    "pod",
    "read_mesh",
    "reduce",
    "save",
    "save_appendage",
    "scalogram",
    "simulate",
    "solve_modes",
    "solve_prestress",
    "solve_spinning_modes",
    "solve_static",
    "spectrum",
    "tune_pretension",
    "write_csv",
    "write_vtu",
]

_NAMES_OF_MODULE = {
    "analysis": (
        "amplitude",
        "dominant_frequency",
        "dominant_shape",
        "mac",
        "mac_table",
        "maneuver_end",
        "pod",
        "scalogram",
        "spectrum",
    ),
    "analysis.participation": (
        "appendage_data",
        "dynamic_mass",
    ),
    "batch": ("Batch",),
    "config": (
        "Case",
        "load_case",
    ),
    "errors": (
        "CaseError",
        "InputError",
        "MeshError",
        "MissingExtraError",
        "NotConvergedError",
        "PrestressError",
        "TautflexError",
        "UnsupportedError",
    ),
    "exchange": (
        "MeshData",
        "read_mesh",
    ),
    "exchange.appendage": ("save_appendage",),
    "export": (
        "write_csv",
        "write_vtu",
    ),
    "mechanics.damping": ("Rayleigh",),
    "mechanics.film": ("film_states",),
    "mechanics.inputs": (
        "CableTension",
        "EdgeForce",
        "FilmTemperature",
        "NodalForce",
    ),
    "mechanics.loads": ("PressureLoad",),
    "motion.attitude": ("attitude",),
    "motion.base": ("BaseAcceleration",),
    "motion.coupling": ("Coupling",),
    "motion.hub": (
        "FreeHub",
        "HubState",
    ),
    "motion.maneuvers": (
        "AtRest",
        "Stop",
    ),
    "motion.sequence": ("Sequence",),
    "motion.slew": (
        "Slew",
        "SpinUp",
    ),
    "motion.tabulated": ("Tabulated",),
    "reduction.basis": (
        "ModalBasis",
        "PodBasis",
    ),
    "reduction.hyper": (
        "HyperReducedModel",
        "hyper_reduce",
    ),
    "reduction.model": (
        "ReducedModel",
        "reduce",
    ),
    "results": (
        "load",
        "save",
    ),
    "solvers.adaptive": ("Adaptive",),
    "solvers.campbell": ("campbell",),
    "solvers.central_difference": ("CentralDifference",),
    "solvers.dynamics": ("simulate",),
    "solvers.energy_conserving": ("EnergyConserving",),
    "solvers.generalized_alpha": (
        "GeneralizedAlpha",
        "HHT",
        "Newmark",
    ),
    "solvers.linear": ("linear_solver",),
    "solvers.modal": ("solve_modes",),
    "solvers.prestress": ("solve_prestress",),
    "solvers.spinning": ("solve_spinning_modes",),
    "solvers.static": ("solve_static",),
    "solvers.tuning": ("tune_pretension",),
    "solvers.wilson": ("WilsonTheta",),
    "structure.materials": (
        "BeamSection",
        "CableSection",
        "Material",
        "MembraneSection",
    ),
    "structure.model": (
        "Model",
        "Support",
    ),
    "study.build": ("build_model",),
}
_MODULE_OF_NAME = {name: module for module, names in _NAMES_OF_MODULE.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "errors":
        return import_module("tautflex.errors")
    if name not in _MODULE_OF_NAME:
        raise AttributeError(f"module 'tautflex' has no attribute {name!r}")
    value = getattr(import_module(f"tautflex.{_MODULE_OF_NAME[name]}"), name)
    # Overwrites the sub-module of the same name, if importing it put one there.
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
