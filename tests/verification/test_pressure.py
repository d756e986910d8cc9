"""Films under pressure: the load itself, Hencky's circular film, the square airbag."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from tautflex import CableSection, InputError, Material, MembraneSection, Model, PressureLoad, Shape, solve_static
from tautflex.mechanics.membrane import principal_resultants
from tautflex.mechanics.system import StructuralSystem
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.model import Support
from tautflex.structure.shapes import QUAD4, TRIANGLE3, TRIANGLE6
from verification.builders import disc_mesh, observed_order, unstressed

Array = NDArray[np.float64]

RADIUS, STIFFNESS, POISSON, PRESSURE = 0.1425, 311488.0, 0.34, 1e5  # circular film: m, N/m, -, Pa
THICKNESS = 1e-3


def tetrahedron() -> Model:
    nodes = np.array([[0.1, 0, 0], [1, 0.2, 0], [0.3, 0.9, 0.1], [0.4, 0.3, 0.8]])
    triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    return Model.from_mesh(nodes, triangles=triangles, membrane=MembraneSection(Material(1.0, 1.0, 0.3), 1.0))


def quarter(divisions: int, side: float, law: str = "tension-field") -> Model:
    """A quarter of one sheet of a square bag: two symmetry planes through the origin, and z = 0 along the seam."""
    line = np.linspace(0.0, side, divisions + 1)
    nodes, triangles = rectangle_mesh(line, line, "alternating")
    x, y = nodes[:, 0], nodes[:, 1]
    supports = [
        Support(tuple(np.flatnonzero(x < 1e-9)), ("x",)),
        Support(tuple(np.flatnonzero(y < 1e-9)), ("y",)),
        Support(tuple(np.flatnonzero(np.maximum(x, y) > side - 1e-9)), ("z",)),
    ]
    section = MembraneSection(Material(588e6, 1000.0, 0.4), 6e-4, "green-lagrange", law)
    return Model.from_mesh(nodes, triangles=triangles, membrane=section, supports=supports)


def disc(rings: int, strain: str) -> Model:
    nodes, triangles = disc_mesh(RADIUS, rings)
    rim = np.arange(len(nodes) - 6 * rings, len(nodes))
    section = MembraneSection(Material(STIFFNESS / THICKNESS, 1000.0, POISSON), THICKNESS, strain)
    return Model.from_mesh(nodes, triangles=triangles, membrane=section, supports=(Support.pinned(rim),))


def test_pressure_on_a_closed_surface_has_no_resultant(verification_row):
    load = PressureLoad(StructuralSystem.from_model(tetrahedron()), 3.0)
    q = 0.2 * np.random.default_rng(0).standard_normal(12)
    force = load.force(q).reshape(4, 3)
    moment = np.cross(tetrahedron().nodes + q.reshape(4, 3), force).sum(axis=0)
    error = max(np.abs(force.sum(axis=0)).max(), np.abs(moment).max()) / np.abs(force).max()
    assert error < 1e-14
    verification_row("pressure in a closed film: resultant and moment / nodal force", 0.0, error, "Gauss's theorem")
    edges = tetrahedron().nodes[1:] - tetrahedron().nodes[0]
    grown = PressureLoad(StructuralSystem.from_model(tetrahedron()), 1.0).work(tetrahedron().nodes.ravel())
    assert grown == pytest.approx(7.0 * abs(np.linalg.det(edges)) / 6.0)  # twice the size, eight times the volume


def held(shape: Shape) -> Model:
    """Rectangular film of any elements, held all around."""
    nodes, elements = rectangle_mesh(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 0.7, 3), shape=shape)
    inside = (nodes[:, 0] % 1.0 > 1e-9) & (nodes[:, 1] % 0.7 > 1e-9)
    section = MembraneSection(Material(1.0, 1.0, 0.3), 1.0)
    edge = Support.pinned(np.flatnonzero(~inside))
    return Model.from_mesh(nodes, surfaces={shape.name: elements}, membrane=section, supports=(edge,))


@pytest.mark.parametrize("shape", [TRIANGLE3, TRIANGLE6, QUAD4], ids=lambda shape: shape.name)
def test_pressure_on_a_curved_film_of_any_shape(shape, verification_row):
    """On ``z = d + b x + c y + e x y + f x^2 + g y^2`` over a rectangle, of which each shape takes its share exactly.

    The normal times dA is ``(-z_x, -z_y, 1) dx dy``; what lies between it and the plane is the integral of z.
    """
    model = held(shape)
    x, y, _ = model.nodes.T
    a, h, p = 1.0, 0.7, 3.0
    d, b, c = 0.2, 0.3, -0.4
    e = 0.0 if shape is TRIANGLE3 else 0.5
    f, g = (0.6, -0.7) if shape is TRIANGLE6 else (0.0, 0.0)
    free = Model(model.nodes, model.groups)
    system = StructuralSystem.from_model(free)
    q = np.zeros((len(x), 3))
    q[:, 2] = d + b * x + c * y + e * x * y + f * x**2 + g * y**2
    load = PressureLoad(system, p)
    total = load.force(q.ravel()).reshape(-1, 3).sum(axis=0)
    exact = p * a * h * np.array([-(b + e * h / 2 + f * a), -(c + e * a / 2 + g * h), 1.0])
    volume = a * h * (d + b * a / 2 + c * h / 2 + e * a * h / 4 + f * a**2 / 3 + g * h**2 / 3)
    error = max(np.abs(total / exact - 1.0).max(), abs(load.work(q.ravel()) / (p * volume) - 1.0))
    assert error < 1e-13
    verification_row(f"pressure on a curved film, {shape.name}: resultant and volume", 0.0, error, "closed form")


@pytest.mark.parametrize("name", ["closed", "held", "held triangle6", "held quad4", "symmetry planes"])
def test_pressure_is_the_gradient_of_its_work(name, verification_row):
    model = {"closed": tetrahedron, "held": lambda: disc(2, "von-karman"), "symmetry planes": lambda: quarter(2, 0.4)}
    model |= {"held triangle6": lambda: held(TRIANGLE6), "held quad4": lambda: held(QUAD4)}
    system = StructuralSystem.from_model(model[name]())
    load, rng, step = PressureLoad(system, 2.0), np.random.default_rng(1), 1e-3
    q = 0.1 * rng.standard_normal(system.size)
    units = np.eye(system.size)
    # Work is cubic and force quadratic, so these differences are exact but for round-off.
    third = [(load.work(q + 2 * step * u) - load.work(q - 2 * step * u)) / (4 * step) for u in units]
    first = [(load.work(q + step * u) - load.work(q - step * u)) / (2 * step) for u in units]
    gradient = (4 * np.array(first) - np.array(third)) / 3
    columns = np.array([(load.force(q + step * u) - load.force(q - step * u)) / (2 * step) for u in units])
    tangent = system.matrix(load.tangent(q)).toarray()
    scale = np.abs(load.force(q)).max()
    error = max(np.abs(load.force(q) - gradient).max() / scale, np.abs(tangent - columns).max() / np.abs(tangent).max())
    assert error < 1e-9
    verification_row(f"follower pressure, {name} edge: force and tangent against differences", 0.0, error, "exact")


def test_pressure_needs_a_film():
    model = Model.from_mesh(np.eye(3)[:2], cables=[[0, 1]], cable=CableSection(Material(1.0, 1.0), 1.0))
    with pytest.raises(InputError, match="pressure: expected a model with a film"):
        PressureLoad(StructuralSystem.from_model(model), 1.0)
    with pytest.raises(InputError, match="pressure"):
        PressureLoad(StructuralSystem.from_model(tetrahedron()), [1.0, 2.0])


def hencky(poisson_ratio: float, terms: int = 60) -> tuple[float, float]:
    """First coefficient b0 and centre deflection w / (a (p a/E h)^(1/3)) of Hencky's power series.

    With N = (Eh/4)(pa/Eh)^(2/3) b(s), s = (r/a)^2: equilibrium and compatibility give s b'' + 2 b' = -2/b^2, the held
    edge 2 b'(1) + (1 - nu) b(1) = 0, and the deflection is the integral of 1/b.
    """

    def series(first: float) -> Array:
        b, square, inverse = np.zeros((3, terms))
        b[0], square[0], inverse[0] = first, first**2, first**-2.0
        for n in range(1, terms):
            b[n] = -2.0 * inverse[n - 1] / (n * (n + 1))
            square[n] = b[: n + 1] @ b[n::-1]
            inverse[n] = -(square[1 : n + 1] @ inverse[n - 1 :: -1]) / square[0]
        return b

    order = np.arange(terms)
    first = brentq(lambda b0: (2 * order + 1 - poisson_ratio) @ series(b0), 1.5, 2.5, xtol=1e-14)
    b, inverse = series(first), np.zeros(terms)
    inverse[0] = 1.0 / first
    for n in range(1, terms):
        inverse[n] = -(b[1 : n + 1] @ inverse[n - 1 :: -1]) / first
    return first, float((inverse / (order + 1)).sum())


def test_hencky_series_has_its_published_coefficients():
    # W. B. Fichter, NASA TP-3658 (1997): b0 for nu = 0.2, 0.3, 0.4.
    assert [round(hencky(nu)[0], 4) for nu in (0.2, 0.3, 0.4)] == [1.6827, 1.7244, 1.7769]


def test_circular_film_under_pressure(verification_row):
    exact = 1e3 * RADIUS * (PRESSURE * RADIUS / STIFFNESS) ** (1 / 3) * hencky(POISSON)[1]
    found = []
    for rings in (5, 10, 20):
        state = unstressed(disc(rings, "von-karman"))
        dead = PressureLoad(state.system, PRESSURE).force(np.zeros(state.system.size))
        q = solve_static(state, -dead, tolerance=1e-10)
        found.append(1e3 * float(state.system.translations(q)[0, 2]))
    order = observed_order(np.array(found) - exact)
    assert found[-1] == pytest.approx(exact, rel=1e-3)
    assert order[-1] == pytest.approx(2.0, abs=0.25)
    case = "circular film, a = 0.1425 m, p = 100 kPa"
    verification_row(f"{case}, dead pressure, von Karman: centre [mm]", exact, found[-1], "Hencky's series")
    verification_row(f"{case}, dead pressure: observed order", 2.0, float(order[-1]), "linear triangles")
    state = unstressed(disc(20, "green-lagrange"))
    q = solve_static(state, pressure=PressureLoad(state.system, PRESSURE), tolerance=1e-10)
    rise = 1e3 * float(state.system.translations(q)[0, 2])
    assert 32.0 < rise < 34.8
    verification_row(f"{case}, follower, Green-Lagrange [mm]", "32 to 34.8", f"{rise:.2f}", "mem4py tutorial", "")


def test_square_airbag(verification_row):
    """Diagonal 1.2 m, h = 0.6 mm, E = 588 MPa, nu = 0.4, p = 5 kPa, inflated from flat in one step."""
    rises = []
    for divisions in (4, 8, 16):
        state = unstressed(quarter(divisions, 0.6 / np.sqrt(2.0)))
        q = solve_static(state, pressure=PressureLoad(state.system, 5e3), tolerance=1e-8)
        rises.append(1e3 * float(state.system.translations(q)[0, 2]))
        values = principal_resultants(state.system, state.system.stress(q))
        least = values[:, 0].min() / values[:, 1].max()
        assert least > -1e-3
        case = f"square airbag, quarter sheet of {divisions} x {divisions} cells: centre rise [mm]"
        verification_row(case, 217.0, rises[-1], "Contri & Schrefler 1988")
    assert rises[-1] == pytest.approx(217.0, rel=5e-3)
    verification_row("square airbag, least / largest principal resultant", "> -1e-3", f"{least:.0e}", "required", "")
    # Without the law the compressed film props the bag: it stays flatter on the same mesh.
    state = unstressed(quarter(8, 0.6 / np.sqrt(2.0), law="elastic"))
    q = solve_static(state, pressure=PressureLoad(state.system, 5e3), tolerance=1e-8)
    elastic = 1e3 * float(state.system.translations(q)[0, 2])
    assert elastic < 0.9 * rises[1]
    verification_row("square airbag, elastic law, 8 x 8 cells [mm]", "< 217", f"{elastic:.0f}", "counter-example", "")
