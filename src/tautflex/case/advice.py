"""What a user should know about a valid case before running it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tautflex.case.build import build_inputs, build_maneuver
from tautflex.solvers.plausibility import doubts_about_maneuver, doubts_about_probes
from tautflex.solvers.static.stability import find_start
from tautflex.solvers.transient.probes import place_probes
from tautflex.structure.shapes import SHAPES

if TYPE_CHECKING:
    from tautflex.case import Case
    from tautflex.solvers.static.prestress import PrestressedState


def advise(case: Case, state: PrestressedState) -> list[str]:
    """List warnings about a case and what was made of it, each one sentence with what to do.

    Raises
    ------
    CaseError
        If values of the maneuver or of an input do not go together, or a table cannot be read.
    """
    maneuver = build_maneuver(case)
    build_inputs(case, state)
    about_structure = [*_about_mesh(case), *_about_cables(case), *doubts_about_maneuver(maneuver)]
    start = find_start(state, maneuver.start(), case.coupling.build(), case.damping.build())
    return [*state.warnings, *about_structure, *start.warnings, *_about_probes(case, state), *_about_run(case)]


def notes(case: Case, state: PrestressedState) -> list[str]:
    """List what a case chooses on purpose and what follows from it, each one sentence."""
    found = list(state.notes)
    if case.output.probe_reading == "nearest-node":
        read = place_probes(state.system, case.output.probes, case.output.probe_reading).positions
        for (name, point), place in zip(case.output.probes.items(), read, strict=True):
            away = float(np.hypot(*(place[:2] - point)))
            if away > 1e-9 * np.ptp(state.model.nodes, axis=0).max():
                found.append(
                    f"probe {name} is read {away:.3g} m away, at node ({place[0]:.4g}, {place[1]:.4g}); "
                    "output.probe_reading = 'interpolate' reads at the point itself"
                )
    return found


def _about_mesh(case: Case) -> list[str]:
    mesh = case.mesh
    if "pattern" not in mesh.model_fields_set or SHAPES[mesh.element].domain == "triangle":
        return []
    return [f"mesh.pattern = '{mesh.pattern}' is not used: cells of '{mesh.element}' have no diagonal; remove it"]


def _about_cables(case: Case) -> list[str]:
    warnings: list[str] = []
    if case.cables is None or case.cables.per_long_edge is None or case.cables.per_short_edge is None:
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


def _about_probes(case: Case, state: PrestressedState) -> list[str]:
    if not case.output.probes:
        return ["output.probes is empty: a run will keep no time history; add a point to [output.probes]"]
    placed = place_probes(state.system, case.output.probes, case.output.probe_reading)
    return doubts_about_probes(state.model, case.output.probes, placed.positions)


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
