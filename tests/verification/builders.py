"""Small structures with known answers, shared by the verification tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tautflex import BeamSection, CableSection, Material, MembraneSection, Model
from tautflex.elements.block import ElementBlock
from tautflex.mechanics.system import StructuralSystem
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.antenna import AntennaLayout, build_antenna
from tautflex.structure.model import Support

Array = NDArray[np.float64]

FILM = Material(3.5e9, 1530.0, 0.34)
CABLE = Material(133e9, 1440.0, 0.36)
FRAME = Material(3e9, 1380.0, 0.38)
THICKNESS = 1e-4
AREAL_DENSITY = FILM.density * THICKNESS

# Case file of a small film with fixed edges, without a maneuver.
FILM_CASE = """schema = 1
[membrane]
length = 1.0
width = 0.8
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 4000.0
stress_y = 3000.0
[mesh]
divisions = [4, 4]
[solver]
time_step = 0.01
end_time = 0.3
[output.probes]
A = [0.2, 0.1]
"""
STOPPED_FILM = f"""{FILM_CASE}[maneuver]
kind = "stop"
rate = 0.5
duration = 0.1
[output]
fields = [0.1, 0.5, 2.0]
"""


def rotation(seed: int) -> Array:
    """Random proper rotation matrix."""
    matrix, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return matrix * np.sign(np.linalg.det(matrix))


def rotation_matrix(vector: Array) -> Array:
    """Rotation by the vector's length about its direction (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def unstressed(model: Model) -> PrestressedState:
    """Reference state of a structure that needs no prestress (beams)."""
    system = StructuralSystem.from_model(model)
    return PrestressedState(system, np.zeros(system.size), 0.0, 0.0, 0)


def observed_order(errors: list[Array] | Array) -> Array:
    """Orders of convergence from errors on meshes refined by two, coarse to fine."""
    sizes = np.abs(np.asarray(errors))
    return np.log2(sizes[:-1] / sizes[1:])


def line_nodes(length: float, elements: int, along: Array | None = None) -> Array:
    """Evenly spaced nodes from the origin."""
    direction = np.array([1.0, 0.0, 0.0]) if along is None else along
    return np.linspace(0.0, length, elements + 1)[:, None] * direction


def line_elements(elements: int) -> NDArray[np.int64]:
    """Two-node elements joining consecutive nodes."""
    return np.column_stack([np.arange(elements), np.arange(1, elements + 1)])


def strains(block: ElementBlock, q: Array) -> Array:
    """Strains of each element of a block at all unknowns ``q`` of the model, shape (element, strain)."""
    g = np.einsum("nij,nj->ni", block.gradient, q[block.rows_of(block.dofs)])
    return g @ block.linear.T + 0.5 * np.einsum("sij,ni,nj->ns", block.quadratic, g, g)


def antenna(
    resultants: tuple[float, float],
    divisions: tuple[int, int] = (10, 5),
    *,
    support: str = "corners",
    strain: str = "von-karman",
    beam_strain: str | None = None,
    mode: str = "equilibrium",
    cables: tuple[int, int] | None = None,
    cable_density: float = CABLE.density,
    distribution: str = "tributary",
) -> Model:
    """The paper's film, cables and frame; cables at every edge node, tension = resultant x spacing."""
    count_x, count_y = cables or (divisions[0] + 1, divisions[1] + 1)
    layout = AntennaLayout(2.0, 1.0, divisions, "alternating", 2.5, 1.5, count_x, count_y, distribution, support)
    return build_antenna(
        layout,
        MembraneSection(FILM, THICKNESS, strain),
        CableSection(Material(133e9, cable_density, 0.36), 3.14e-6, strain),
        BeamSection(FRAME, 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7, beam_strain or strain),
        pretension_x=resultants[0] * 1.0 / (count_y - 1),
        pretension_y=resultants[1] * 2.0 / (count_x - 1),
        prestress_mode=mode,
    )


def disc_mesh(radius: float, rings: int) -> tuple[Array, NDArray[np.int64]]:
    """Triangulate a disc: ring k has 6 k nodes; the last 6 * rings nodes are the rim."""
    points, first = [np.zeros((1, 2))], [0]
    for k in range(1, rings + 1):
        angle = 2.0 * np.pi * np.arange(6 * k) / (6 * k)
        first.append(first[-1] + max(6 * (k - 1), 1))
        points.append(radius * k / rings * np.column_stack([np.cos(angle), np.sin(angle)]))
    triangles = []
    for k in range(1, rings + 1):
        inner, outer = max(6 * (k - 1), 1), 6 * k
        for sector in range(6):
            for j in range(k):
                a = first[k] + (sector * k + j) % outer
                b = first[k] + (sector * k + j + 1) % outer
                c = first[k - 1] + (sector * (k - 1) + j) % inner
                triangles.append((a, b, c))
                if j < k - 1:
                    triangles.append((c, b, first[k - 1] + (sector * (k - 1) + j + 1) % inner))
    plane = np.concatenate(points)
    return np.column_stack([plane, np.zeros(len(plane))]), np.array(triangles)


def beam_line(
    section: BeamSection,
    length: float,
    elements: int,
    supports: tuple[Support, ...] = (),
    *,
    turn: Array | None = None,
    axial_force: float = 0.0,
) -> Model:
    """Straight beam along x with local z = z, turned by a rotation matrix if given."""
    matrix = np.eye(3) if turn is None else turn
    return Model.from_mesh(
        line_nodes(length, elements) @ matrix.T,
        beams=line_elements(elements),
        beam=section,
        beam_axial_force=axial_force,
        beam_orientation=matrix[:, 2],
        supports=supports,
    )
