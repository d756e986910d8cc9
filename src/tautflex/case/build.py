"""From a validated case to the objects of the numerics; the only place where the two meet."""

from __future__ import annotations

from typing import Any

from tautflex.case.meshed import meshed_model
from tautflex.case.options import within
from tautflex.case.schema import Case
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import Maneuver
from tautflex.reduction.bases.vectors import Basis
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.adaptive import Adaptive
from tautflex.solvers.transient.explicit import ExplicitMethod
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.materials import BeamSection, CableSection, Material, MembraneSection
from tautflex.structure.model import Model


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
        If geometry and mesh contradict each other.
    """
    film, mesh = case.membrane, case.mesh
    membrane = MembraneSection(
        Material(film.youngs_modulus, film.density, film.poisson_ratio), film.thickness, film.strain, film.law
    )
    cable, beam = _cable_section(case), _beam_section(case)
    if mesh.file is not None:
        return meshed_model(case, membrane, cable, beam, membrane_stress(case))
    assert film.length is not None
    assert film.width is not None
    if case.cables is None or case.frame is None:
        layout = AntennaLayout(film.length, film.width, mesh.divisions, mesh.pattern, element=mesh.element)
        return build_fixed_film(layout, membrane, membrane_stress(case))
    cables, frame = case.cables, case.frame
    assert cable is not None
    assert beam is not None
    assert cables.per_long_edge is not None
    assert cables.per_short_edge is not None
    layout = AntennaLayout(
        film.length,
        film.width,
        mesh.divisions,
        mesh.pattern,
        frame.length,
        frame.width,
        cables.per_long_edge,
        cables.per_short_edge,
        cables.distribution,
        frame.support,
        mesh.element,
    )
    return build_antenna(
        layout,
        membrane,
        cable,
        beam,
        pretension_x=cables.pretension_x,
        pretension_y=cables.pretension_y,
        membrane_stress=membrane_stress(case),
        prestress_mode=case.prestress.mode or "equilibrium",
    )


def _cable_section(case: Case) -> CableSection | None:
    given = case.cables
    if given is None:
        return None
    material = Material(given.youngs_modulus, given.density)
    with within("cables"):
        return CableSection(material, given.area, case.membrane.strain, given.slack, given.law)


def _beam_section(case: Case) -> BeamSection | None:
    given = case.frame
    if given is None:
        return None
    return BeamSection(
        Material(given.youngs_modulus, given.density, given.poisson_ratio),
        given.area,
        given.inertia_y,
        given.inertia_z,
        given.torsion_constant,
        case.membrane.strain,
    )


def membrane_stress(case: Case) -> tuple[float, float, float]:
    """Return the given film stress (sx, sy, txy) [Pa]; zeros where the film responds to the cables."""
    film, ratios = case.membrane, case.prestress.resultant_per_pretension
    if film.stress_x is not None and film.stress_y is not None:
        return film.stress_x, film.stress_y, 0.0
    if case.prestress.mode == "uniform" and ratios is not None and case.cables is not None:
        tensions = case.cables.pretension_x, case.cables.pretension_y
        return ratios[0] * tensions[0] / film.thickness, ratios[1] * tensions[1] / film.thickness, 0.0
    return 0.0, 0.0, 0.0


def build_maneuver(case: Case) -> Maneuver:
    """Build the maneuver of a case; CaseError if its values or its table do not go together."""
    with within("maneuver"):
        return case.maneuver.build()


def build_method(case: Case) -> Method | ExplicitMethod:
    """Build the integrator of a case."""
    return case.solver.build()


def build_adaptive(case: Case) -> Adaptive | None:
    """Build the error control of a case; None for fixed steps."""
    return case.solver.adaptive()


def build_damping(case: Case) -> Any:
    """Build the damping of a case."""
    return case.damping.build()


def build_basis(case: Case) -> Basis | None:
    """Build the basis of a case's reduced model; None for the full model."""
    return None if case.reduction is None else case.reduction.build()


def build_coupling(case: Case) -> Coupling:
    """Build the coupling switches of a case."""
    return Coupling(**case.coupling.model_dump())


def build_inputs(case: Case, state: PrestressedState) -> list[TimeInput]:
    """Build the inputs of a case for its structure, each tried at t = 0.

    Parameters
    ----------
    case
        Validated case.
    state
        What `solve_prestress` made of it.

    Returns
    -------
    list of TimeInput

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
            tried.stress(0.0)
    return found
