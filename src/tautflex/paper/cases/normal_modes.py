"""Natural modes of the antennas that the tables and figures compare with."""

from __future__ import annotations

from collections.abc import Iterable

import xarray as xr

from tautflex.case import Case
from tautflex.case.build import build_model
from tautflex.errors import InputError
from tautflex.paper.cases.catalogue import COARSE_MESHES, FITTED_MESHES, VARIANTS, mesh_name, model_case
from tautflex.paper.cases.run_names import MODELS
from tautflex.solvers.modal.natural import solve_modes
from tautflex.solvers.static.prestress import solve_prestress

_MESHES = {"published": tuple(FITTED_MESHES), "consistent": COARSE_MESHES}
MODE_COUNT = 60
"""The paper's Table 3 ranks modes up to the 51st."""
DOMINANT_LABEL = (1, 2)
"""Half waves of the mode that rotation about the long mid-line excites; the paper's fourth [paper, Table 3]."""


def antenna_name(model: str, variant: str = "published") -> str:
    """Return the key of an antenna's modes, e.g. ``published/M2``."""
    return f"{variant}/{model}"


def antenna_cases() -> dict[str, Case]:
    """List every antenna by name: M1, M2, M3 of all variants, some also on other meshes."""
    cases = {}
    for variant in VARIANTS:
        for model in MODELS:
            name = antenna_name(model, variant)
            cases[name] = model_case(model, variant)
            for cells in _MESHES.get(variant, ()):
                cases[mesh_name(name, cells)] = model_case(model, variant, cells)
    return cases


def antenna_modes(names: Iterable[str]) -> dict[str, xr.Dataset]:
    """Compute the modes of antennas by name.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    cases = antenna_cases()
    wanted = list(dict.fromkeys(names))
    unknown = [name for name in wanted if name not in cases]
    if unknown:
        raise InputError(f"names: expected some of {', '.join(cases)}, got {unknown}")
    return {name: solve_modes(solve_prestress(build_model(cases[name])), n=MODE_COUNT).to_dataset() for name in wanted}


def dominant_mode(modes: xr.Dataset) -> int:
    """Return the number, from 1, of the first mode with one half wave along x and two along y.

    Raises
    ------
    InputError
        If no mode has that label.
    """
    m, n = DOMINANT_LABEL
    found = (modes["label_m"].values == m) & (modes["label_n"].values == n)
    if not found.any():
        raise InputError(f"modes: expected a mode with half waves {DOMINANT_LABEL}, got none; compute more modes")
    return int(found.argmax()) + 1


def frequency_of(modes: xr.Dataset, number: int) -> float:
    """Return the natural frequency [Hz] of a mode, counted from 1."""
    return float(modes["frequency"].values[number - 1])
