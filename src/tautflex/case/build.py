"""From a validated case to the objects of the numerics; the only place where the two meet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.case.options import within
from tautflex.case.schema import Case
from tautflex.case.sections.inputs import nearest_node
from tautflex.case.sections.structural import Cables, EdgeCords, Frame, Membrane
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.errors import MeshError
from tautflex.files.mesh import read_mesh
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.motion.kinematics import Maneuver
from tautflex.numeric import within_arithmetic
from tautflex.reduction.inputs import require_linear
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
    """
    checks.instance("case", case, Case, "a case", remedy="load_case('m2.toml') gives one")
    model = _bare_model(case)
    return replace(model, masses=(*model.masses, *_bodies(case, model))) if case.masses else model


def _bodies(case: Case, model: Model) -> Iterator[PointMass]:
    """Bodies that the case itself places; CaseError if there is no such node."""
    for number, given in enumerate(case.masses):
        with within(f"masses[{number}]"):
            node = given.node if given.near is None else nearest_node(model, np.array(given.near))
            body = PointMass(checks.whole("node", node, 0), given.mass, given.inertia, given.offset)
            checks.indices("node", [body.node], len(model.nodes))
            yield body


def _bare_model(case: Case) -> Model:
    """Structure without the bodies that the case places."""
    film, mesh, cables, frame = case.membrane, case.mesh, case.cables, case.frame
    membrane = _membrane_section(film)
    stated: dict[str, Any] = {
        "membrane_stress": membrane_stress(case),
        "prestress_mode": case.prestress.mode or "equilibrium",
    }
    cable = None if cables is None else _cable_section(cables, film.strain)
    beam = None if frame is None else _beam_section(frame, film.strain)
    if mesh.file is not None:
        return _meshed_model(case, mesh.file, cable, beam, membrane=membrane, **stated)
    shape: dict[str, Any] = {"length": film.length, "width": film.width, "element": mesh.element}
    shape |= {"divisions": mesh.divisions, "pattern": mesh.pattern}
    if cables is None or cable is None or frame is None or beam is None:
        return build_fixed_film(AntennaLayout(**shape), membrane, stated["membrane_stress"])
    shape |= {"frame_length": frame.length, "frame_width": frame.width, "support": frame.support}
    shape |= {f"cables_{name}": getattr(cables, name) for name in ("per_long_edge", "per_short_edge")}
    layout = AntennaLayout(**shape, distribution=cables.distribution, cable_segments=cables.segments)
    if case.edge_cords is not None:
        return _scalloped(layout, case.edge_cords, (membrane, cable, beam), stated["membrane_stress"])
    pull_x, pull_y = cables.pretensions
    return build_antenna(layout, membrane, cable, beam, pretension_x=pull_x, pretension_y=pull_y, **stated)


def _meshed_model(case: Case, file: str, cable: CableSection | None, beam: BeamSection | None, **stated: Any) -> Model:
    """Structure whose mesh comes from a file; tensions of cables by their direction."""
    told = case.mesh
    mesh = read_mesh(
        file,
        told.names,
        unit_length=told.unit_length or 1.0,
        unit_mass=told.unit_mass,
        step=told.step,
    )
    for kind, section, table in (("cables", cable, "cables"), ("beams", beam, "frame")):
        count = len(getattr(mesh, kind))
        if count and section is None:
            raise MeshError(f"{file}: has {count} {kind}, expected a section [{table}] in the case; add it")
        if not count and section is not None:
            raise MeshError(f"{file}: expected {kind}, which the case has a section for, got none; remove [{table}]")
    given, tension = case.cables, np.zeros(0)
    if given is not None:
        tension = blend_by_direction(mesh.nodes, mesh.cables, *given.pretensions)
    return mesh.model(cable=cable, beam=beam, cable_tension=tension, **stated)


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


def _membrane_section(given: Membrane) -> MembraneSection:
    """Section of the film and the layers on it; CaseError if they do not go together."""
    numbers = given.youngs_modulus, given.density, given.poisson_ratio
    with within("membrane"):
        if given.youngs_modulus_y is None or given.shear_modulus is None:
            material = Material(*numbers)
        else:
            other = {"youngs_modulus_2": given.youngs_modulus_y, "shear_modulus_12": given.shear_modulus}
            material = OrthotropicMaterial(*numbers, **other)
        film = MembraneSection(material, given.thickness, given.strain, given.law)
        coatings = (
            replace(film, material=Material(on.youngs_modulus, on.density, on.poisson_ratio), thickness=on.thickness)
            for on in given.layers
        )
        return laminate(film, *coatings)


def _cable_section(given: Cables, strain: str) -> CableSection:
    material = Material(given.youngs_modulus, given.density)
    with within("cables"):
        return CableSection(material, given.area, strain, given.slack, given.law)


def _beam_section(given: Frame, strain: str) -> BeamSection:
    return BeamSection(
        Material(given.youngs_modulus, given.density, given.poisson_ratio),
        given.area,
        given.inertia_y,
        given.inertia_z,
        given.torsion_constant,
        given.strain or strain,
        given.rotary_inertia,
    )


def membrane_stress(case: Case) -> tuple[float, float, float]:
    """Return the given film stress (sx, sy, txy) [Pa]; zeros where the film responds to the cables."""
    film, ratios = case.membrane, case.prestress.resultant_per_pretension
    if film.stress_x is not None and film.stress_y is not None:
        return film.stress_x, film.stress_y, 0.0
    if case.prestress.mode == "uniform" and ratios is not None and case.cables is not None:
        tensions = case.cables.pretensions
        return ratios[0] * tensions[0] / film.thickness, ratios[1] * tensions[1] / film.thickness, 0.0
    return 0.0, 0.0, 0.0


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
