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
        pod,
        scalogram,
        spectrum,
    )
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
    from tautflex.mechanics.damping import Rayleigh
    from tautflex.motion.coupling import Coupling
    from tautflex.motion.maneuvers import Stop
    from tautflex.results import load, save
    from tautflex.solvers.dynamics import simulate
    from tautflex.solvers.generalized_alpha import HHT, GeneralizedAlpha, Newmark
    from tautflex.solvers.modal import solve_modes
    from tautflex.solvers.prestress import solve_prestress
    from tautflex.solvers.tuning import tune_pretension
    from tautflex.solvers.wilson import WilsonTheta
    from tautflex.structure.model import Model
    from tautflex.study.build import build_model

__all__ = [
    "HHT",
    "Case",
    "CaseError",
    "Coupling",
    "GeneralizedAlpha",
    "InputError",
    "MeshError",
    "MissingExtraError",
    "Model",
    "Newmark",
    "NotConvergedError",
    "PrestressError",
    "Rayleigh",
    "Stop",
    "TautflexError",
    "UnsupportedError",
    "WilsonTheta",
    "__version__",
    "amplitude",
    "build_model",
    "dominant_frequency",
    "dominant_shape",
    "errors",
    "load",
    "load_case",
    "mac",
    "mac_table",
    "pod",
    "save",
    "scalogram",
    "simulate",
    "solve_modes",
    "solve_prestress",
    "spectrum",
    "tune_pretension",
]

_NAMES_OF_MODULE = {
    "analysis": (
        "amplitude", "dominant_frequency", "dominant_shape", "mac", "mac_table", "pod", "scalogram",
        "spectrum",
    ),
    "config": ("Case", "load_case"),
    "errors": (
        "CaseError", "InputError", "MeshError", "MissingExtraError", "NotConvergedError", "PrestressError",
        "TautflexError", "UnsupportedError",
    ),
    "mechanics.damping": ("Rayleigh",),
    "motion.coupling": ("Coupling",),
    "motion.maneuvers": ("Stop",),
    "results": ("load", "save"),
    "solvers.dynamics": ("simulate",),
    "solvers.generalized_alpha": ("GeneralizedAlpha", "HHT", "Newmark"),
    "solvers.modal": ("solve_modes",),
    "solvers.prestress": ("solve_prestress",),
    "solvers.tuning": ("tune_pretension",),
    "solvers.wilson": ("WilsonTheta",),
    "structure.model": ("Model",),
    "study.build": ("build_model",),
}  # fmt: skip
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
