"""Films under pressure: the load itself, Hencky's circular film, the square airbag, free edges."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from tautflex import (
    CableSection,
    InputError,
    Material,
    MembraneSection,
    Model,
    PressureLoad,
    Shape,
    build_model,
    solve_prestress,
    solve_static,
)
from tautflex.case import parse_case, template
from tautflex.errors import MeshError, NotConvergedError
from tautflex.mechanics.membrane import principal_resultants
from tautflex.mechanics.system import StructuralSystem
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.model import Support
from tautflex.structure.orientation import facing
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


def test_free_edges_have_an_unsymmetric_load_stiffness(verification_row):
    """The derivative of the force is exact there too, and no potential has it."""
    system = StructuralSystem.from_model(Model(held(QUAD4).nodes, held(QUAD4).groups))
    load, rng = PressureLoad(system, 2.0), np.random.default_rng(3)
    q = 0.1 * rng.standard_normal(system.size)
    columns = np.array([(load.force(q + 1e-3 * u) - load.force(q - 1e-3 * u)) / 2e-3 for u in np.eye(system.size)]).T
    tangent = system.matrix(load.tangent(q)).toarray()
    error = np.abs(tangent - columns).max() / np.abs(tangent).max()
    assert error < 1e-11
    assert np.abs(tangent - tangent.T).max() > 0.1 * np.abs(tangent).max()
    verification_row("follower pressure, free edge: tangent against differences of the force", 0.0, error, "exact")


@pytest.mark.parametrize("shape", [TRIANGLE3, TRIANGLE6, QUAD4], ids=lambda shape: shape.name)
def test_elements_listed_the_other_way_round_do_not_turn_the_pressure(shape, verification_row):
    model = held(shape)
    (group,) = model.groups
    mirrored = {TRIANGLE3: [0, 2, 1], TRIANGLE6: [0, 2, 1, 5, 4, 3], QUAD4: [0, 3, 2, 1]}[shape]
    elements = group.connectivity.copy()
    elements[1] = elements[1, mirrored]
    mixed = Model.from_mesh(
        model.nodes, surfaces={shape.name: elements}, membrane=group.section, supports=model.supports
    )
    forces = [PressureLoad(system, 3.0) for system in map(StructuralSystem.from_model, (model, mixed))]
    q = 0.1 * np.random.default_rng(2).standard_normal(len(model.free_dofs))
    wanted, found = (load.force(q) for load in forces)
    error = float(np.abs(found - wanted).max() / np.abs(wanted).max())
    assert error < 1e-14
    verification_row(f"pressure with one clockwise {shape.name}: force against none", 0.0, error, "same surface")


def test_pieces_of_film_face_each_its_own_way():
    """A side that three elements share parts them: nobody can say which two go on in each other."""
    nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], dtype=float)
    film = Model.from_mesh(
        nodes, triangles=[[0, 1, 2], [0, 1, 3], [1, 0, 4]], membrane=MembraneSection(Material(1.0, 1.0, 0.3), 1.0)
    )
    np.testing.assert_array_equal(facing(film.nodes, film.surfaces), [1.0, 1.0, 1.0])
    two = Model.from_mesh(
        nodes[:4], triangles=[[0, 1, 2], [0, 1, 3]], membrane=MembraneSection(Material(1.0, 1.0, 0.3), 1.0)
    )
    np.testing.assert_array_equal(facing(two.nodes, two.surfaces), [1.0, -1.0])


def test_a_film_with_one_side_is_refused():
    angle = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    across = np.column_stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)])
    middle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(12)])
    nodes = np.concatenate([middle + 0.2 * across, middle - 0.2 * across])
    quads = [[i, i + 1, 12 + i + 1, 12 + i] for i in range(11)] + [[11, 12, 0, 23]]
    strip = Model.from_mesh(nodes, quads=quads, membrane=MembraneSection(Material(1.0, 1.0, 0.3), 1.0))
    with pytest.raises(MeshError, match=r"expected two sides.*cut the strip open"):
        PressureLoad(StructuralSystem.from_model(strip), 1.0)


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


# Pressure [Pa] and largest deflection [m] of the package's antenna in equilibrium, found by another way: the force on
# the last shape as a dead load, until nothing changes.
ANTENNA = ((9e-6, 3.9459e-07), (1e-3, 4.3843e-05), (0.1, 4.0588e-03), (1.0, 1.73751e-02))


def test_antenna_under_pressure(verification_row):
    """Its film's edges hang in cables: free edges, on which the follower force has no potential."""
    state = solve_prestress(build_model(parse_case(template("m2-nearest-node"), ["prestress.mode=equilibrium"])))
    for pressure, expected in ANTENNA:
        q = solve_static(state, pressure=PressureLoad(state.system, pressure))
        found = float(np.abs(state.system.translations(q)[:, 2]).max())
        assert found == pytest.approx(expected, rel=2e-5)
        verification_row(f"antenna under {pressure:g} Pa: largest deflection [m]", expected, found, "fixed point")


def long_strip(pretension: float = 3000.0, clockwise: bool = False) -> tuple[Model, float]:
    """Film strip 5 m wide between held long edges, its ends free to move out of the plane; stiffness E h/(1 - nu^2)."""
    young, nu, thickness, count = 1.5e9, 0.3, 1.5e-3, 24
    nodes, triangles = rectangle_mesh(np.linspace(-2.5, 2.5, count + 1), np.array([0.0, 5.0 / count]))
    if clockwise:
        triangles[1::2] = triangles[1::2, [0, 2, 1]]
    ends = Support(tuple(np.flatnonzero(np.abs(nodes[:, 0]) > 2.5 - 1e-9)), ("x", "y", "z"))
    plane = Support(tuple(range(len(nodes))), ("y",))
    section = MembraneSection(Material(young, 1200.0, nu), thickness, "green-lagrange")
    stress = (pretension / thickness, nu * pretension / thickness, 0.0)
    model = Model.from_mesh(
        nodes, triangles=triangles, membrane=section, membrane_stress=stress, supports=(ends, plane)
    )
    return model, young * thickness / (1.0 - nu**2)


@pytest.mark.parametrize("clockwise", [False, True], ids=["counter-clockwise", "half of the elements clockwise"])
def test_strip_with_two_free_edges(clockwise, verification_row, monkeypatch):
    """Shallow parabola w = p a^2 / 2N with N = N0 + E h/(1 - nu^2) (p a / N)^2 / 6; Newton on the follower force."""
    pressure, half = 500.0, 2.5
    model, stiffness = long_strip(clockwise=clockwise)
    tension = brentq(lambda n: n - 3000.0 - stiffness * (pressure * half / n) ** 2 / 6.0, 3000.0, 1e7)
    exact, state = pressure * half**2 / (2.0 * tension), solve_prestress(model)
    tangents, derivative = [], PressureLoad.tangent
    monkeypatch.setattr(PressureLoad, "tangent", lambda self, q: tangents.append(q) or derivative(self, q))
    q = solve_static(state, pressure=PressureLoad(state.system, pressure), tolerance=1e-8)
    found = float(state.system.translations(q)[:, 2].max())
    assert found == pytest.approx(exact, rel=2e-3)
    assert found == pytest.approx(0.1604, rel=5e-4)
    case = "strip, 5 m wide, 500 Pa, two free edges" + ", half of the elements clockwise" * clockwise
    verification_row(f"{case}: rise [m]", exact, found, "shallow parabola (exact for small rise: 0.1601)")
    assert len(tangents) <= 10  # of which the first and the last ask whether these shapes are stable
    left = [float(np.linalg.norm(point - q)) for point in tangents[2:-1]]
    order = np.log(left[-1] / left[-2]) / np.log(left[-2] / left[-3])
    assert order > 1.7
    verification_row(f"{case}: order of Newton's last steps", "2", f"{order:.1f}", "exact tangent", "")


@pytest.mark.parametrize("pressure", [5.0, 5e4])
def test_a_strip_without_pretension_is_inflated(pressure):
    """From flat: N^3 = E h/(1 - nu^2) (p a)^2 / 6; the arc is not shallow at the higher pressure."""
    model, stiffness = long_strip(0.0)
    state = unstressed(model)
    q = solve_static(state, pressure=PressureLoad(state.system, pressure))
    rise = float(state.system.translations(q)[:, 2].max())
    exact = pressure * 2.5**2 / 2.0 / (stiffness * (pressure * 2.5) ** 2 / 6.0) ** (1 / 3)
    assert rise == pytest.approx(exact, rel=3e-3 if pressure < 10.0 else 0.05)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"tolerance": np.nan}, "tolerance: expected a finite number, got nan"),
        ({"tolerance": 0.0}, "tolerance: expected a number > 0 and < 1, got 0.0"),
        ({"tolerance": "small"}, "tolerance: expected a finite number, got 'small'"),
        ({"start": np.zeros(3)}, r"start: expected shape \(.*\), got \(3,\)"),
        ({"load": [1.0, 2.0]}, r"load: expected shape .*, got \(2,\)"),
        ({"load": "heavy"}, "load: expected an array of numbers, got 'heavy'"),
        ({"extra": [1.0]}, "extra: expected shape"),
        ({"forces": [[0.0, 0.0, 1.0]]}, "forces: expected shape"),
        ({"steps": 0}, "steps: expected an integer >= 1, got 0"),
        ({"pressure": 1.0}, r"pressure: expected a load on the film of this state, got 1.0; give PressureLoad"),
    ],
)
def test_bad_arguments_of_statics_are_named(arguments, words):
    state = unstressed(disc(2, "von-karman"))
    with pytest.raises(InputError, match=words):
        solve_static(state, **arguments)


def test_numbers_that_are_none_are_named():
    state = unstressed(disc(2, "von-karman"))
    for name in ("load", "start"):
        with pytest.raises(InputError, match=f"{name}: expected finite numbers, got nan"):
            solve_static(state, **{name: np.full(state.system.size, np.nan)})
    with pytest.raises(InputError, match="pressure: expected finite numbers, got nan"):
        PressureLoad(state.system, np.nan)
    with pytest.raises(InputError, match="pressure: expected an array of numbers, got 'high'"):
        PressureLoad(state.system, "high")
    assert np.array_equal(PressureLoad(state, 1.0).pressure, PressureLoad(state.system, 1.0).pressure)
    with pytest.raises(InputError, match=r"system: expected a prestressed state, got Model; solve_prestress\(model\)"):
        PressureLoad(state.model, 1.0)
    with pytest.raises(InputError, match="pressure: expected a load on the film of this state, got one on another"):
        solve_static(state, pressure=PressureLoad(unstressed(disc(3, "von-karman")).system, 1.0))
    with pytest.raises(InputError, match=r"state: expected a prestressed state, got Model; solve_prestress\(model\)"):
        solve_static(state.model)


@pytest.mark.parametrize("name", ["load", "start", "pressure"])
def test_forces_beyond_floating_point_numbers_are_said(name):
    """An error of ours, and no warning of numpy's, which the tests would raise."""
    state = unstressed(disc(2, "von-karman"))
    huge = np.full(state.system.size, 1e200)
    given = {name: PressureLoad(state.system, 1e200) if name == "pressure" else huge}
    with pytest.raises(NotConvergedError, match="leave the range of numbers; check the units of load, pressure"):
        solve_static(state, **given)
