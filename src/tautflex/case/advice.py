"""What a user should know about a valid case before running it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tautflex.case.build import build_damping, build_inputs, build_maneuver
from tautflex.errors import CaseError
from tautflex.structure.shapes import SHAPES

if TYPE_CHECKING:
    from tautflex.case import Case
    from tautflex.solvers.static.prestress import PrestressedState
    from tautflex.structure.model import Model


def advise(case: Case, model: Model, state: PrestressedState) -> list[str]:
    """List warnings about a case and what was made of it, each one sentence with what to do.

    Raises
    ------
    CaseError
        If values of the maneuver or of an input do not go together, or a table cannot be read.
    """
    build_maneuver(case)
    build_inputs(case, state)
    build_damping(case, state)
    count, most = getattr(case.reduction, "count", None), state.system.size - 1
    if count is not None and count > most:
        raise CaseError(f"reduction.count: expected at most the {most} modes of this mesh, got {count}; take fewer")
    about_structure = [*_about_mesh(case), *_about_prestress(case, state)]
    return [*state.warnings, *about_structure, *_about_probes(case, model), *_about_run(case)]


def _about_mesh(case: Case) -> list[str]:
    mesh = case.mesh
    if "pattern" not in mesh.model_fields_set or SHAPES[mesh.element].domain == "triangle":
        return []
    return [f"mesh.pattern = '{mesh.pattern}' is not used: cells of '{mesh.element}' have no diagonal; remove it"]


def _about_prestress(case: Case, state: PrestressedState) -> list[str]:
    warnings: list[str] = []
    if case.cables is None:
        return warnings
    pull = max(case.cables.pretension_x, case.cables.pretension_y)
    if case.prestress.mode == "uniform" and state.residual > 1e-6 * pull:
        warnings.append(
            f"cables and film do not balance: {state.residual:.3g} N is taken as carried by the reference "
            "state; set prestress.mode = 'equilibrium' for a structure in true equilibrium"
        )
    if case.cables.per_long_edge is None or case.cables.per_short_edge is None:
        return warnings  # a mesh file has its cables where it has them
    spaces = (case.cables.per_long_edge - 1, case.cables.per_short_edge - 1)
    if any(have > gaps for have, gaps in zip(case.mesh.node_spaces, spaces, strict=True)):
        what = "cells" if case.mesh.node_spaces == case.mesh.divisions else "spaces between nodes"
        warnings.append(
            f"edge nodes without a cable: {list(case.mesh.node_spaces)} {what} but {list(spaces)} cable spaces; "
            "a free edge between cables tends to compression, set cables.per_long_edge and per_short_edge "
            f"to {what} + 1"
        )
    return warnings


def _about_probes(case: Case, model: Model) -> list[str]:
    warnings: list[str] = []
    if not case.output.probes:
        warnings.append("output.probes is empty: a run will keep no time history; add a point to [output.probes]")
    if case.output.probe_reading == "nearest-node":
        film = model.nodes[np.unique(model.triangles)]
        for name, point in case.output.probes.items():
            distance = np.hypot(film[:, 0] - point[0], film[:, 1] - point[1])
            nearest = film[distance.argmin()]
            if distance.min() > 1e-9 * np.ptp(film, axis=0).max():
                warnings.append(
                    f"probe {name} is read {distance.min():.3g} m away, at node "
                    f"({nearest[0]:.4g}, {nearest[1]:.4g}); "
                    "set output.probe_reading = 'interpolate' to read at the point itself"
                )
    return warnings


def _about_run(case: Case) -> list[str]:
    warnings: list[str] = []
    if case.maneuver.kind == "none":
        warnings.append("maneuver.kind = 'none': nothing moves the antenna; set kind = 'stop' to excite it")
    if isinstance(case.output.fields, tuple):
        late = [instant for instant in case.output.fields if instant > case.solver.end_time]
        if late:
            warnings.append(
                f"output.fields: {late} s lie after end_time = {case.solver.end_time:g} s and are left out; "
                "run longer to store them"
            )
    motions = (case.maneuver, *getattr(case.maneuver, "steps", ()))
    for duration in (getattr(motion, "duration", None) for motion in motions):
        if isinstance(duration, float) and case.solver.time_step > duration / 5:
            warnings.append(
                f"solver.time_step = {case.solver.time_step:g} s resolves the maneuver of {duration:g} s with "
                "fewer than 5 steps; use a smaller one"
            )
    return warnings
