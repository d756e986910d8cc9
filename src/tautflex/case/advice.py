"""What a user should know about a valid case before running it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tautflex.case.build import build_damping, build_inputs, build_maneuver, stated_sections
from tautflex.errors import CaseError
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.numeric import Array
from tautflex.solvers.plausibility import FEW_STEPS, doubts_about_maneuver, doubts_about_probes, short_motions
from tautflex.solvers.static.stability import find_start
from tautflex.solvers.transient.probes import place_probes
from tautflex.structure.shapes import SHAPES

if TYPE_CHECKING:
    from tautflex.case import Case
    from tautflex.solvers.static.prestress import PrestressedState


def advise(case: Case, state: PrestressedState) -> tuple[list[str], list[str]]:
    """List warnings about a case and what was made of it, each with what to do, and notes on what it chose on purpose.

    Raises
    ------
    CaseError
        If values of the maneuver or of an input do not go together, or a table cannot be read.
    """
    maneuver = build_maneuver(case)
    build_inputs(case, state)
    about_loop = _about_loop(case, state)
    damping = build_damping(case, state)
    count, most = getattr(case.reduction, "count", None), state.system.size - 1
    if count is not None and count > most:
        raise CaseError(f"reduction.count: expected at most the {most} modes of this mesh, got {count}; take fewer")
    step = case.solver.time_step if case.solver.adaptive_tolerance is None else None
    about_maneuver = doubts_about_maneuver(maneuver, step, case.solver.end_time)
    start = find_start(state, maneuver.start(), case.coupling.build(), damping)
    read = place_probes(state.system, case.output.probes, case.output.probe_reading).positions
    warnings = [
        *state.warnings,
        *_about_mesh(case),
        *_about_supports(case, state, maneuver),
        *_about_cables(case),
        *about_maneuver,
        *about_loop,
        *start.warnings,
        *_about_probes(case, state, read),
        *_about_run(case, maneuver),
    ]
    return warnings, [*state.notes, *_about_sections(case, state), *_notes(case, state, read)]


def _about_supports(case: Case, state: PrestressedState, maneuver: Maneuver) -> Iterator[str]:
    free = state.system.model.rigid_freedom
    if free and not (case.hub is None and isinstance(maneuver, AtRest)):
        where = (
            "frame.support = 'corners'" if case.mesh.file is None else "a group of nodes named 'support' in the mesh"
        )
        yield (
            f"nothing holds the structure against {free} rigid motion(s), and no maneuver or hub can move it; give it "
            f"supports: {where}"
        )


def _about_loop(case: Case, state: PrestressedState) -> list[str]:
    if case.controller is None and case.hub is None and not case.actuators and not case.sensors:
        return []
    from tautflex.case.loop import check_loop  # brings reduced models and control along, a tenth of a second

    return check_loop(case, state)


def _notes(case: Case, state: PrestressedState, read: Array) -> Iterator[str]:
    if case.output.probe_reading != "nearest-node":
        return
    for (name, point), place in zip(case.output.probes.items(), read, strict=True):
        away = float(np.linalg.norm(place[: len(point)] - point))
        if away > 1e-9 * np.ptp(state.model.nodes, axis=0).max():
            yield (
                f"probe {name} is read {away:.3g} m away, at node ({place[0]:.4g}, {place[1]:.4g}); "
                "output.probe_reading = 'interpolate' reads at the point itself"
            )


def _about_sections(case: Case, state: PrestressedState) -> Iterator[str]:
    """What the case states of a whole kind of elements and some have otherwise."""
    for name, (kind, stated) in stated_sections(case).items():
        own = [group.section for group in state.model.groups if group.section.kind == kind]
        one_for_all = kind == "membrane" and (case.membrane.layers or case.membrane.youngs_modulus_y)
        for key, value in stated.items() if case.mesh.file is not None and not one_for_all else ():
            found = {str(getattr(one, key, getattr(one.material, key, value))) for one in own} - {str(value)}
            if found:
                yield (
                    f"{name}.{key} = {value} does not hold for all: some have {', '.join(sorted(found))}, as "
                    "[mesh.sections.NAME] or sections of the mesh file that differ state it"
                )


def _about_mesh(case: Case) -> Iterator[str]:
    mesh = case.mesh
    if "pattern" in mesh.model_fields_set and SHAPES[mesh.element].domain != "triangle":
        yield f"mesh.pattern = '{mesh.pattern}' is not used: cells of '{mesh.element}' have no diagonal; remove it"


def _about_cables(case: Case) -> Iterator[str]:
    cables, have = case.cables, case.mesh.node_spaces
    if cables is None or cables.per_long_edge is None or cables.per_short_edge is None or case.edge_cords is not None:
        return  # a mesh file has its cables where it has them, cords hold edges between cables
    spaces = (cables.per_long_edge - 1, cables.per_short_edge - 1)
    if have[0] > spaces[0] or have[1] > spaces[1]:
        what = "cells" if have == case.mesh.divisions else "spaces between nodes"
        yield (
            f"edge nodes without a cable: {list(have)} {what} but {list(spaces)} cable spaces; a free edge between "
            f"cables tends to compression, set cables.per_long_edge and per_short_edge to {what} + 1"
        )


def _about_probes(case: Case, state: PrestressedState, read: Array) -> list[str]:
    if not case.output.probes and case.task is not None:
        return []  # an episode is judged by what its task measures
    if not case.output.probes:
        return ["output.probes is empty: a run will keep no time history; add a point to [output.probes]"]
    return doubts_about_probes(state.model, case.output.probes, read)


def _about_run(case: Case, maneuver: Maneuver) -> Iterator[str]:
    if case.maneuver.kind == "none" and case.hub is None and not case.inputs:
        yield "maneuver.kind = 'none': nothing moves the antenna; set kind = 'stop' to excite it"
    fields, solver = case.output.fields, case.solver
    late = [instant for instant in fields if instant > solver.end_time] if isinstance(fields, tuple) else []
    if late:
        text = f"output.fields: {late} s lie after end_time = {solver.end_time:g} s and are left out"
        yield f"{text}; run longer to store them"
    for duration in short_motions(maneuver, solver.time_step):
        text = f"solver.time_step = {solver.time_step:g} s resolves the maneuver of {duration:g} s with fewer than"
        yield f"{text} {FEW_STEPS} steps; use a smaller one"
