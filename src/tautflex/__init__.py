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
    from tautflex.analysis.mac import mac, mac_table
    from tautflex.analysis.pod import dominant_shape, pod
    from tautflex.analysis.record import maneuver_end
    from tautflex.analysis.spectrum import amplitude, dominant_frequency, spectrum
    from tautflex.analysis.wavelet import scalogram
    from tautflex.batch import Batch
    from tautflex.case import Case, load_case
    from tautflex.case.build import build_model
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
    from tautflex.files.appendage import save_appendage
    from tautflex.files.export import write_csv, write_vtu
    from tautflex.files.mesh import MeshData, read_mesh
    from tautflex.files.netcdf import load, save
    from tautflex.mechanics.dampings.rayleigh import Rayleigh
    from tautflex.mechanics.loads.inputs import CableTension, EdgeForce, FilmTemperature, NodalForce
    from tautflex.mechanics.loads.pressure import PressureLoad
    from tautflex.mechanics.membrane import film_states
    from tautflex.motion.attitude import attitude
    from tautflex.motion.coupling import Coupling
    from tautflex.motion.fixed_axis import FixedAxis, RateFormula, Slew, SpinUp, Stop
    from tautflex.motion.hub import FreeHub, HubState
    from tautflex.motion.kinematics import AtRest, Maneuver, RigidMotion, Segment
    from tautflex.motion.profiles import Stretch, UnitStep
    from tautflex.motion.sequence import Sequence
    from tautflex.motion.tabulated import Tabulated
    from tautflex.motion.translation import BaseAcceleration
    from tautflex.reduction.bases.modal_basis import ModalBasis
    from tautflex.reduction.bases.pod_basis import PodBasis
    from tautflex.reduction.bases.vectors import Basis, BasisVectors
    from tautflex.reduction.hyper.model import HyperReducedModel, hyper_reduce
    from tautflex.reduction.polynomial.model import ReducedModel, reduce
    from tautflex.solvers.linear.factorization import linear_solver
    from tautflex.solvers.modal.campbell import campbell
    from tautflex.solvers.modal.natural import solve_modes
    from tautflex.solvers.modal.participation import appendage_data, dynamic_mass
    from tautflex.solvers.modal.spinning import solve_spinning_modes
    from tautflex.solvers.modal.tuning import tune_pretension
    from tautflex.solvers.static.equilibrium import solve_static
    from tautflex.solvers.static.prestress import solve_prestress
    from tautflex.solvers.transient.adaptive import Adaptive
    from tautflex.solvers.transient.explicit import CentralDifference
    from tautflex.solvers.transient.methods.energy_conserving import EnergyConserving
    from tautflex.solvers.transient.methods.generalized_alpha import HHT, GeneralizedAlpha, Newmark
    from tautflex.solvers.transient.methods.wilson import WilsonTheta
    from tautflex.solvers.transient.simulate import simulate
    from tautflex.structure.materials import BeamSection, CableSection, Material, MembraneSection
    from tautflex.structure.model import Model, Support

__all__ = [
    "HHT",
    "Adaptive",
    "AtRest",
    "BaseAcceleration",
    "Basis",
    "BasisVectors",
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
    "FixedAxis",
    "FreeHub",
    "GeneralizedAlpha",
    "HubState",
    "HyperReducedModel",
    "InputError",
    "Maneuver",
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
    "RateFormula",
    "Rayleigh",
    "ReducedModel",
    "RigidMotion",
    "Segment",
    "Sequence",
    "Slew",
    "SpinUp",
    "Stop",
    "Stretch",
    "Support",
    "Tabulated",
    "TautflexError",
    "UnitStep",
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
    "solvers.modal.participation": (
        "appendage_data",
        "dynamic_mass",
    ),
    "batch": ("Batch",),
    "case": (
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
    "files.mesh": (
        "MeshData",
        "read_mesh",
    ),
    "files.appendage": ("save_appendage",),
    "files.export": (
        "write_csv",
        "write_vtu",
    ),
    "mechanics.dampings.rayleigh": ("Rayleigh",),
    "mechanics.membrane": ("film_states",),
    "mechanics.loads.inputs": (
        "CableTension",
        "EdgeForce",
        "FilmTemperature",
        "NodalForce",
    ),
    "mechanics.loads.pressure": ("PressureLoad",),
    "motion.attitude": ("attitude",),
    "motion.translation": ("BaseAcceleration",),
    "motion.coupling": ("Coupling",),
    "motion.hub": (
        "FreeHub",
        "HubState",
    ),
    "motion.fixed_axis": (
        "FixedAxis",
        "RateFormula",
        "Slew",
        "SpinUp",
        "Stop",
    ),
    "motion.kinematics": (
        "AtRest",
        "Maneuver",
        "RigidMotion",
        "Segment",
    ),
    "motion.profiles": (
        "Stretch",
        "UnitStep",
    ),
    "motion.sequence": ("Sequence",),
    "motion.tabulated": ("Tabulated",),
    "reduction.bases.modal_basis": ("ModalBasis",),
    "reduction.bases.pod_basis": ("PodBasis",),
    "reduction.bases.vectors": (
        "Basis",
        "BasisVectors",
    ),
    "reduction.hyper.model": (
        "HyperReducedModel",
        "hyper_reduce",
    ),
    "reduction.polynomial.model": (
        "ReducedModel",
        "reduce",
    ),
    "files.netcdf": (
        "load",
        "save",
    ),
    "solvers.transient.adaptive": ("Adaptive",),
    "solvers.modal.campbell": ("campbell",),
    "solvers.transient.explicit": ("CentralDifference",),
    "solvers.transient.simulate": ("simulate",),
    "solvers.transient.methods.energy_conserving": ("EnergyConserving",),
    "solvers.transient.methods.generalized_alpha": (
        "GeneralizedAlpha",
        "HHT",
        "Newmark",
    ),
    "solvers.linear.factorization": ("linear_solver",),
    "solvers.modal.natural": ("solve_modes",),
    "solvers.static.prestress": ("solve_prestress",),
    "solvers.modal.spinning": ("solve_spinning_modes",),
    "solvers.static.equilibrium": ("solve_static",),
    "solvers.modal.tuning": ("tune_pretension",),
    "solvers.transient.methods.wilson": ("WilsonTheta",),
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
    "case.build": ("build_model",),
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
