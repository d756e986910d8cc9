"""Structures whose mesh comes from a file that the case names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh import MeshData, read_mesh
from tautflex.numeric import Array
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection
from tautflex.structure.mesh import blend_by_direction
from tautflex.structure.model import Model

if TYPE_CHECKING:
    from tautflex.case import Case


def meshed_model(
    case: Case,
    membrane: MembraneSection,
    cable: CableSection | None,
    beam: BeamSection | None,
    stress: tuple[float, float, float],
) -> Model:
    """Build the structure of a case with ``mesh.file``.

    Parameters
    ----------
    case
        Validated case that names a mesh file.
    membrane, cable, beam
        Sections of the case.
    stress
        Given film stress (sx, sy, txy) [Pa].

    Returns
    -------
    Model

    Raises
    ------
    InputError
        If the file cannot be read, or has elements for which the case has no section.
    """
    given = case.mesh
    assert given.file is not None
    mesh = read_mesh(given.file, given.names, unit_length=given.unit_length or 1.0)
    for kind, section, table in (("cables", cable, "cables"), ("beams", beam, "frame")):
        count = len(getattr(mesh, kind))
        if count and section is None:
            raise MeshError(f"{given.file}: has {count} {kind}, expected a section [{table}] in the case; add it")
        if not count and section is not None:
            raise MeshError(
                f"{given.file}: expected {kind}, which the case has a section for, got none; remove [{table}]"
            )
    return mesh.model(
        membrane=membrane,
        cable=cable,
        beam=beam,
        membrane_stress=stress,
        cable_tension=_tensions(case, mesh),
        prestress_mode=case.prestress.mode or "equilibrium",
    )


def _tensions(case: Case, mesh: MeshData) -> Array:
    """Tension of each cable [N], between pretension_x along x and pretension_y across it by the squared cosine."""
    if case.cables is None:
        return np.zeros(0)
    return blend_by_direction(mesh.nodes, mesh.cables, case.cables.pretension_x, case.cables.pretension_y)
