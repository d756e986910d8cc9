"""From a validated case to the objects of the numerics; the only place where the two meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.case.messages import of_mesh_file
from tautflex.case.options import within
from tautflex.case.schema import Case
from tautflex.case.sections.inputs import nearest_node
from tautflex.case.sections.structural import EdgeCords, Membrane
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.drive import Drive
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.errors import CaseError, InputError, MeshError
from tautflex.files.mesh import read_mesh
from tautflex.files.mesh.section.section_data import PRESTRESS, keys, made
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.motion.kinematics import Maneuver
from tautflex.numeric import within_arithmetic
from tautflex.reduction.inputs import require_linear
from tautflex.solvers.plausibility import point_text
from tautflex.solvers.static.equip import equip
from tautflex.solvers.static.form import find_form
from tautflex.solvers.static.prestress import PrestressedState, solve_prestress
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.masses import PointMass
from tautflex.structure.materials import (
    BeamSection,
    CableSection,
    Material,
    MembraneSection,
    OrthotropicMaterial,
    Section,
    laminate,
)
from tautflex.structure.mesh import blend_by_direction
from tautflex.structure.model import Model
from tautflex.structure.scalloped import build_scalloped_antenna


@within_arithmetic()
def build_model(case: Case) -> Model:
    """Build the structure of a case.

    Parameters
    ----------
    case
        Validated case.

    Returns
    -------
    Model

    Raises
    ------
    InputError
        If geometry and mesh contradict each other, or a mesh file cannot be read or lacks what the case describes.

    Examples
    --------
    >>> import tautflex as tf
    >>> model = tf.build_model(tf.load_case("m2.toml"))
    >>> f"{model.mass:.2f} kg"
    '6.13 kg'
    """
    checks.instance("case", case, Case, "a case", remedy="load_case('m2.toml') gives one")
    model = _bare_model(case)
    added: dict[str, list[Any]] = {"masses": [*_bodies(case, model)]}
    if case.mesh.file is None:  # those of a mesh may be what holds its pieces together
        added |= _joints(case, model)
    own: dict[str, Any] = {name: (*getattr(model, name), *more) for name, more in added.items() if more}
    return replace(model, **own) if own else model


def _joints(case: Case, where: Any) -> dict[str, list[Any]]:
    """Links, springs and dampers that the case itself places among the nodes of a model or mesh."""
    found: dict[str, list[Any]] = {"links": [], "springs": [], "dampers": []}
    for name, joints in found.items():
        for number, given in enumerate(getattr(case, name)):
            with within(f"{name}[{number}]"):
                joints.append(given.placed(where))
    return found


def _bodies(case: Case, model: Model) -> Iterator[PointMass]:
    """Bodies that the case itself places; CaseError if there is no such node."""
    for number, given in enumerate(case.masses):
        with within(f"masses[{number}]"):
            node = given.node if given.near is None else nearest_node(model, np.array(given.near))
            body = PointMass(checks.whole("node", node, 0), given.mass, given.inertia, given.offset)
            checks.indices("node", [body.node], len(model.nodes))
            yield body


def _made(name: str, kind: str, stated: dict[str, Any]) -> Section:
    """Section of what the case states; CaseError if it does not go together."""
    try:
        return made(name, kind, None, stated)
    except InputError as error:
        raise CaseError(*error.problems) from None


def _bare_model(case: Case) -> Model:
    """Structure without the bodies that the case places."""
    film, mesh, cables, frame = case.membrane, case.mesh, case.cables, case.frame
    if mesh.file is not None:
        return _meshed_model(case, mesh.file)
    own = _membrane_section(film)
    sections = {
        name: _made(name, kind, stated) if own is None or kind != "membrane" else own
        for name, (kind, stated) in stated_sections(case).items()
    }
    stress, mode = membrane_stress(case) or (0.0, 0.0, 0.0), case.prestress.mode or "equilibrium"
    shape: dict[str, Any] = {"length": film.length, "width": film.width, "element": mesh.element}
    shape |= {"divisions": mesh.divisions, "pattern": mesh.pattern}
    membrane: Any = sections["membrane"]
    if cables is None or frame is None:
        return build_fixed_film(AntennaLayout(**shape), membrane, stress)
    shape |= {"frame_length": frame.length, "frame_width": frame.width, "support": frame.support}
    shape |= {f"cables_{name}": getattr(cables, name) for name in ("per_long_edge", "per_short_edge")}
    layout = AntennaLayout(**shape, distribution=cables.distribution, cable_segments=cables.segments)
    cable: Any = sections["cables"]
    beam: Any = sections["frame"]
    if case.edge_cords is not None:
        return _scalloped(layout, case.edge_cords, (membrane, cable, beam), stress)
    pull_x, pull_y = cables.pretensions
    tensions = {"pretension_x": pull_x, "pretension_y": pull_y}
    return build_antenna(layout, membrane, cable, beam, **tensions, membrane_stress=stress, prestress_mode=mode)


def stated_sections(case: Case) -> dict[str, tuple[str, dict[str, Any]]]:
    """What the case states of all elements of a kind: the kind and values by key, by section of the case."""
    found = {}
    for name, kind in (("membrane", "membrane"), ("cables", "cable"), ("frame", "beam")):
        section = getattr(case, name)
        stated = {"strain": case.membrane.strain}
        if section is not None:
            stated |= {key: value for key in keys(kind) if (value := getattr(section, key, None)) is not None}
        if section is not None or case.mesh.file is not None:
            found[name] = kind, {key: value for key, value in stated.items() if key not in PRESTRESS[kind]}
    return found


def _meshed_model(case: Case, file: str) -> Model:
    """Structure whose mesh comes from a file; tensions of cables by their direction, unless groups have their own."""
    told, cables = case.mesh, case.cables
    length = told.unit_length or 1.0
    try:
        mesh = read_mesh(file, told.names, unit_length=length, unit_mass=told.unit_mass, step=told.step)
    except MeshError as error:
        raise MeshError(*map(of_mesh_file, error.problems)) from None
    given: dict[str, Any] = {}
    for table, kind, part in (("cables", "cable", "cables"), ("frame", "beam", "beams")):
        count, stated = len(getattr(mesh, part)), getattr(case, table) is not None
        if count and not (stated or told.sections or any(one.kind == kind for one in mesh.sections.values())):
            raise MeshError(f"{file}: has {count} {part}, expected a section [{table}] in the case; add it")
        if not count and stated:
            raise MeshError(f"{file}: expected {part}, which the case has a section for, got none; remove [{table}]")
    stress = membrane_stress(case)
    if stress is not None:
        given["membrane_stress"] = stress
    if cables is not None and cables.pretension_x is not None and cables.pretension_y is not None:
        given["cable_tension"] = blend_by_direction(mesh.nodes, mesh.cables, cables.pretension_x, cables.pretension_y)
    sections = {name: one.model_dump(exclude_none=True) for name, one in (told.sections or {}).items()}
    given |= dict(stated_sections(case).values())
    given["membrane"] = _membrane_section(case.membrane) or given["membrane"]
    given |= {name: (*getattr(mesh, name), *more) for name, more in _joints(case, mesh).items()}
    try:
        model = mesh.model(sections=sections, prestress_mode=case.prestress.mode or "equilibrium", **given)
    except InputError as error:
        raise type(error)(*map(of_mesh_file, error.problems)).behind(f"{file}: ") from None
    for group in model.groups:
        if group.section.kind == "cable" and not (group.initial > 0.0).all():
            row = int(np.argmin(group.initial[:, 0]))
            place = point_text(model.nodes[group.connectivity[row]].mean(axis=0))
            raise MeshError(
                f"{file}: expected tension of every cable, got {group.initial[row, 0]:.4g} N of the one at "
                f"{place}; give cables.pretension_x and pretension_y, or tension under [mesh.sections.NAME]"
            )
    return model


def _scalloped(
    layout: AntennaLayout,
    given: EdgeCords,
    sections: tuple[MembraneSection, CableSection, BeamSection],
    stress: tuple[float, float, float],
) -> Model:
    """Antenna between cut edges, its nodes where the film's stress balances the cords."""
    membrane, cable, frame = sections
    cord = CableSection(Material(given.youngs_modulus, given.density), given.area, cable.strain)
    with within("edge_cords"):
        chosen: dict[str, Any] = {"sag": given.sag, "corners": given.corners, "membrane_stress": stress[:2]}
        return find_form(build_scalloped_antenna(layout, membrane, cable, cord, frame, **chosen))


def _membrane_section(given: Membrane) -> Section | None:
    """Section of a film of two directions or with layers, None of another; CaseError if it is not stated whole."""
    if given.youngs_modulus_y is None and not given.layers:
        return None
    for key in ("youngs_modulus", "density", "poisson_ratio", "thickness"):
        if getattr(given, key) is None:
            raise CaseError(f"membrane.{key}: missing beside youngs_modulus_y or layers, expected a number; add it")
    numbers: Any = given.youngs_modulus, given.density, given.poisson_ratio
    thickness: Any = given.thickness
    with within("membrane"):
        if given.youngs_modulus_y is None or given.shear_modulus is None:
            material = Material(*numbers)
        else:
            other = {"youngs_modulus_2": given.youngs_modulus_y, "shear_modulus_12": given.shear_modulus}
            material = OrthotropicMaterial(*numbers, **other)
        film = MembraneSection(material, thickness, given.strain, given.law)
        coatings = (
            replace(film, material=Material(on.youngs_modulus, on.density, on.poisson_ratio), thickness=on.thickness)
            for on in given.layers
        )
        return laminate(film, *coatings)


def membrane_stress(case: Case) -> tuple[float, float, float] | None:
    """Return the given film stress (sx, sy, txy) [Pa]; None where the case states none."""
    film, cables, ratios = case.membrane, case.cables, case.prestress.resultant_per_pretension
    if film.stress_x is not None and film.stress_y is not None:
        return film.stress_x, film.stress_y, 0.0
    if case.prestress.mode != "uniform" or ratios is None or cables is None or film.thickness is None:
        return None
    if cables.pretension_x is None or cables.pretension_y is None:
        raise CaseError(
            "prestress.resultant_per_pretension: expected it beside cables.pretension_x and pretension_y, got none; "
            "give both, or membrane.stress_x and stress_y"
        )
    return ratios[0] * cables.pretension_x / film.thickness, ratios[1] * cables.pretension_y / film.thickness, 0.0


def build_maneuver(case: Case) -> Maneuver:
    """Build the maneuver of a case; CaseError if its values or its table do not go together."""
    with within("maneuver"):
        return case.maneuver.build()


def build_damping(case: Case, state: PrestressedState) -> Damping:
    """Build the damping of a case, tried on its structure; CaseError if it does not fit."""
    with within("damping"):
        damping: Damping = case.damping.build()
        damping.matrix(state.linear)
        return damping


def build_state(case: Case) -> PrestressedState:
    """Build the structure of a case in its prestressed state, with the tendons of its inputs and actuators.

    Raises
    ------
    InputError
        If the case cannot be built or prestressed, or an input or actuator does not fit the structure.
    """
    state, inputs = solve_prestress(build_model(case)), []
    for section in ("inputs", "actuators"):
        for name, given in getattr(case, section).items():
            with within(f"{section}.{name}"):
                placed = given.placed(state.model)
                if isinstance(placed, HubTorque):
                    continue
                inputs.append(placed.effect if isinstance(placed, Actuator) else placed)
                state = equip(state, inputs[-1:])
    return equip(state, inputs)


def build_inputs(case: Case, state: PrestressedState) -> list[TimeInput]:
    """Build the inputs of a case for its structure, each tried at t = 0.

    Raises
    ------
    CaseError
        If a table cannot be read, or an input does not fit the structure.
    """
    found = []
    for name, given in case.inputs.items():
        with within(f"inputs.{name}"):
            found.append(given.placed(state.model))
            tried = found[-1].prepare(state.system)
            tried.load(0.0)
            tried.follower(0.0)
            tried.stress(0.0)
    if case.reduction is not None:
        require_linear(InputSet(state.system, found))
    return found


def build_actuators(case: Case, state: PrestressedState) -> dict[str, Drive]:
    """Build the actuators of a case for its structure; CaseError if one does not fit."""
    found = dict[str, Drive]()
    for name, given in case.actuators.items():
        with within(f"actuators.{name}"):
            drive = found[name] = given.placed(state.model)
            if isinstance(drive, Actuator):
                drive.effect.prepare(state.system)
    return found
