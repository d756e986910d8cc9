"""From a validated case to the objects of the numerics; the only place where the two meet."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from tautflex.case.meshed import meshed_model
from tautflex.case.motion import maneuver_of
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import Maneuver
from tautflex.reduction.bases.modal_basis import ModalBasis
from tautflex.solvers.transient.adaptive import Adaptive
from tautflex.solvers.transient.explicit import CentralDifference
from tautflex.solvers.transient.methods.energy_conserving import EnergyConserving
from tautflex.solvers.transient.methods.generalized_alpha import HHT, GeneralizedAlpha, Newmark
from tautflex.solvers.transient.methods.scheme import ExplicitMethod, ImplicitMethod
from tautflex.solvers.transient.methods.wilson import WilsonTheta
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.materials import BeamSection, CableSection, Material, MembraneSection
from tautflex.structure.model import Model

if TYPE_CHECKING:
    from tautflex.case import Case

METHODS: dict[str, Callable[..., ImplicitMethod | ExplicitMethod]] = {
    "wilson-theta": WilsonTheta,
    "generalized-alpha": GeneralizedAlpha,
    "newmark": Newmark,
    "hht": HHT,
    "energy-conserving": EnergyConserving,
    "central-difference": CentralDifference,
}


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
        layout = AntennaLayout(film.length, film.width, mesh.divisions, mesh.pattern)
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
    return CableSection(material, given.area, case.membrane.strain, given.slack)


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
    return maneuver_of(case.maneuver)


def build_method(case: Case) -> ImplicitMethod | ExplicitMethod:
    """Build the integrator of a case."""
    return METHODS[case.solver.method](**case.solver.options)


def build_adaptive(case: Case) -> Adaptive | None:
    """Build the error control of a case; None for fixed steps."""
    given = case.solver
    if given.adaptive_tolerance is None:
        return None
    return Adaptive(given.adaptive_tolerance, given.min_step, given.max_step)


def build_damping(case: Case) -> Rayleigh:
    """Build the damping of a case."""
    return Rayleigh(case.damping.alpha, case.damping.beta)


def build_basis(case: Case) -> ModalBasis | None:
    """Build the basis of a case's reduced model; None for the full model."""
    given = case.reduction
    if given is None:
        return None
    return ModalBasis(**given.model_dump(exclude_none=True))


def build_coupling(case: Case) -> Coupling:
    """Build the coupling switches of a case."""
    given = case.coupling
    return Coupling(given.gyroscopic, given.euler, given.centrifugal, given.inertial_load)
