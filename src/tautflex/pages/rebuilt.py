"""What the structure behind a run tells beside its record: modes, cable tensions and states of the film over time."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.case import build
from tautflex.case.reading import parse_case
from tautflex.control.actuators.actuator import Actuator
from tautflex.errors import TautflexError
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.mechanics.membrane import StressSurvey
from tautflex.numeric import Array
from tautflex.solvers.static.prestress import PrestressedState

# Part of the largest displacement by which a node may stand elsewhere in the structure than in the record.
_SAME = 1e-4


class Structure(NamedTuple):
    """Prestressed state of a run and its inputs in time; None where actuators pull that the record does not tell."""

    state: PrestressedState
    inputs: list[TimeInput] | None


def structure_of(run: xr.Dataset, folder: Path) -> Structure:
    """Structure that the case text of a run describes; files that it names are sought from ``folder`` on.

    Raises TautflexError, in words, where there is no text or it cannot be built here.
    """
    if "case" not in run.attrs:
        raise TautflexError("the run has no case text (it was not made from a case file)")
    case = parse_case(run.attrs["case"], directory=folder)
    state = build.build_state(case)
    if len(state.model.nodes) != run.sizes["node"]:
        raise TautflexError("the case text now gives another mesh")
    pulls = any(isinstance(given.placed(state.model), Actuator) for given in case.actuators.values())
    return Structure(state, None if pulls and "command" in run else build.build_inputs(case, state))


def stresses_over_time(structure: Structure, times: Array, frames: Array) -> tuple[Array, NDArray[np.int8]]:
    """Tension of the cables [N], shape (frame, cable), and state of each triangle of the film, (frame, triangle).

    Raises TautflexError, in words, where displacements of the nodes do not tell them.
    """
    state, inputs = structure.state, structure.inputs
    system, model = state.system, state.model
    if inputs is None:
        raise TautflexError("actuators change the stress, by amounts that the record does not tell")
    given, full = InputSet(system, inputs), np.zeros(model.dof_count)
    system = given.whole
    workspace, unknowns = system.workspace(), np.concatenate([model.free_dofs, system.moved])
    survey, tension, states = StressSurvey(system, workspace), list[Array](), list[NDArray[np.int8]]()
    for time, frame in zip(times, frames, strict=True):
        full[model.translation_dofs] = frame
        q = full[unknowns]
        if np.abs(system.translations(q) - frame).max(initial=0.0) > _SAME * np.abs(frames).max(initial=0.0):
            raise TautflexError("nodes follow links that turn, which the record does not tell")
        if given:
            workspace.change_initial_stress(given.stress(float(time)))
        workspace.strain_energy(q)
        forces = [system.blocks[index].size * workspace.stress[index][:, 0] for index in system.block_index("cable")]
        tension.append(np.concatenate([np.zeros(0), *forces]))
        states.append(survey.membrane_states()[model.triangle_owner])
    return np.array(tension), np.array(states, dtype=np.int8)
