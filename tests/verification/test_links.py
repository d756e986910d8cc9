"""Links and springs: closed forms, the same structure without them, and all solvers on a linked one [theory.md 16]."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tautflex as tf
from tautflex import Attachment, DistributingLink, LinkEquation, MeshError, PointMass, RigidLink, Spring, Support, Tie
from tautflex.mechanics.loads.pressure import nodal_load
from tautflex.solvers.modal.refinement import mesh_errors

ALUMINIUM = tf.BeamSection(tf.Material(7e10, 2700.0, 0.33), 1e-4, 8.33e-10, 8.33e-10, 1.4e-9)
LINE = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
CHAIN = [(i, i + 1) for i in range(10)]
FILM = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4)


def mast(nodes: Any = LINE, beams: Any = CHAIN, held: Any = (0,), **given: Any) -> tf.Model:
    supports = [Support.clamped(held)] if held else []
    return tf.Model.from_mesh(nodes, beams=beams, beam=ALUMINIUM, supports=supports, **given)


def frequencies(model: tf.Model, n: int = 3) -> np.ndarray:
    return np.asarray(tf.solve_modes(tf.solve_prestress(model), n=n).frequencies)


def sheet(cells: tuple[int, int], start: float, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and triangles of a film of width 1 m."""
    nx, ny = cells
    x, y = np.linspace(start, start + length, nx + 1), np.linspace(0.0, 1.0, ny + 1)
    nodes = np.array([(a, b, 0.0) for a in x for b in y])
    corner = [(i * (ny + 1) + j) for i in range(nx) for j in range(ny)]
    triangles = [t for k in corner for t in ((k, k + ny + 1, k + ny + 2), (k, k + ny + 2, k + 1))]
    return nodes, np.array(triangles)


def two_sheets(apart: bool, **given: Any) -> tf.Model:
    """A film held at both short edges, of one mesh or of two whose common edge is tied."""
    one, other = sheet((3, 3), 0.0, 1.0), sheet((2, 3), 1.0, 0.7)
    if apart:
        nodes = np.concatenate([one[0], other[0]])
        triangles = np.concatenate([one[1], other[1] + len(one[0])])
        pairs = [(len(one[0]) - 4 + k, len(one[0]) + k) for k in range(4)]
        given["links"] = [Tie(a, [b]) for a, b in pairs]
    else:
        nodes = np.concatenate([one[0], other[0][4:]])
        triangles = np.concatenate([one[1], other[1] + len(one[0]) - 4])
    ends = np.flatnonzero((nodes[:, 0] == 0.0) | (nodes[:, 0] > 1.699)).tolist()
    return tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=FILM,
        membrane_stress=(4e4, 3e4, 5e3),
        supports=[Support.pinned(ends)],
        **given,
    )


@pytest.mark.parametrize(
    ("links", "nodes", "beams", "expected", "tolerance"),
    [
        # Cases a05 and n04 of other programs' files.
        ([RigidLink(5, range(6, 11))], LINE, CHAIN, 8.438, 1e-4),
        ([RigidLink(10, [11])], np.vstack([LINE, [1.5, 0.0, 0.0]]), [*CHAIN[:-1], (9, 11)], 3.655, 3e-4),
    ],
)
def test_rigid_parts(links: Any, nodes: Any, beams: Any, expected: float, tolerance: float) -> None:
    assert frequencies(mast(nodes, beams, links=links))[0] == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize("axes", [None, [[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]]])
def test_hinge_in_a_clamped_beam(axes: Any) -> None:
    """Two cantilevers of half the length: four times their first frequency, whichever way the hinge's axes lie."""
    nodes = np.vstack([LINE, LINE[5]])
    beams = [*CHAIN[:4], (4, 11), *CHAIN[5:]]
    hinge = Tie(5, [11], ("x", "y", "z", "rx"), axes)
    found = frequencies(mast(nodes, beams, held=(0, 10), links=[hinge]))
    assert found[:2] == pytest.approx([32.8943, 32.8943], rel=1e-4)


def test_tied_films_are_one_film() -> None:
    whole, parts = (frequencies(two_sheets(apart), 6) for apart in (False, True))
    assert parts == pytest.approx(whole, rel=1e-10)


def test_mesh_errors_of_tied_films_are_those_of_one_film() -> None:
    whole, parts = (
        mesh_errors(tf.solve_modes(tf.solve_prestress(two_sheets(apart)), n=6), [0, 1, 2]) for apart in (False, True)
    )
    assert np.all(whole > 0.01)
    assert parts == pytest.approx(whole, rel=1e-6)


def test_tied_beams_are_one_beam() -> None:
    nodes = np.vstack([LINE[:6], LINE[5:]])
    beams = [(i, i + 1) for i in range(5)] + [(6 + i, 7 + i) for i in range(5)]
    for link in (Tie(5, [6]), RigidLink(5, [6]), RigidLink(6, [5])):
        assert frequencies(mast(nodes, beams, links=[link]), 6) == pytest.approx(frequencies(mast(), 6), rel=1e-8)


def test_links_of_links_lead_to_the_first() -> None:
    through = [RigidLink(7, [8, 9]), RigidLink(9, [10]), RigidLink(5, [6, 7])]
    whole = [RigidLink(5, range(6, 11))]
    assert frequencies(mast(links=through)) == pytest.approx(frequencies(mast(links=whole)), rel=1e-9)


def test_offset_mass_obeys_the_parallel_axis_theorem() -> None:
    """A body on a rigid arm is the same body with that offset; the free structure has its mass, centre and inertia."""
    arm, inertia = np.array([0.2, 0.3, -0.1]), np.diag([0.02, 0.03, 0.04])
    nodes = np.vstack([LINE, LINE[10] + arm])
    linked = mast(nodes, held=(), masses=[PointMass(11, 2.5, inertia)], links=[RigidLink(10, [11])])
    offset = mast(held=(), masses=[PointMass(10, 2.5, inertia, arm)])
    one, other = tf.solve_prestress(linked), tf.solve_prestress(offset)
    assert one.system.inertia.mass_matrix.toarray() == pytest.approx(other.system.inertia.mass_matrix.toarray())
    rigid = tf.solve_modes(one, n=8).frequencies
    assert np.all(rigid[:6] < 1e-3)
    # The highest frequency is 2000 times these: round-off of their squares is 1e-9.
    assert rigid[6:] == pytest.approx(tf.solve_modes(other, n=8).frequencies[6:], rel=1e-8)
    inside, motions = one.system.inertia, linked.rigid_motions[linked.free_dofs]
    place = LINE[10] + arm
    about_origin = inertia + 2.5 * (place @ place * np.eye(3) - np.outer(place, place))
    about_origin[1:, 1:] += 0.27 / 3.0 * np.eye(2)
    # The polar inertia rho (I_y + I_z) of the beam's twist, and its sections' inertia in bending motions.
    found = motions.T @ inside.mass_matrix @ motions
    assert linked.mass == pytest.approx(2.77)
    assert found[:3, :3] == pytest.approx(2.77 * np.eye(3))
    assert found[3:, 3:] == pytest.approx(about_origin, abs=2e-5)


def test_force_on_a_rigid_arm_is_force_and_moment() -> None:
    """Closed form of a cantilever under end force and moment F a: w = F L^3 / 3 EI + F a L^2 / 2 EI."""
    nodes = np.vstack([LINE, [1.5, 0.0, 0.0]])
    state = tf.solve_prestress(mast(nodes, links=[RigidLink(10, [11])]))
    bending, moved = 7e10 * 8.33e-10, lifted(state, 11, 0.01)
    tip, slope = 0.01 * (1.0 / 3.0 + 0.25) / bending, 0.01 * (0.5 + 0.5) / bending
    assert moved[10] == pytest.approx(tip, rel=1e-4)
    assert moved[11] == pytest.approx(tip + 0.5 * slope, rel=1e-4)


def test_free_linked_nodes_of_film_need_no_rotation() -> None:
    """Links of two or three film nodes whose rotation about their line, or at one place, nothing feels."""
    nodes, triangles = sheet((4, 4), 0.0, 1.0)
    edge = np.flatnonzero((nodes[:, 0] == 0.0) | (nodes[:, 0] == 1.0)).tolist()
    given = {"triangles": triangles, "membrane": FILM, "membrane_stress": (4e4, 4e4, 0.0)}
    for link, size in ((RigidLink(11, [12]), 4), (RigidLink(7, [11, 12]), 3)):
        model = tf.Model.from_mesh(nodes, **given, supports=[Support.pinned(edge)], links=[link])
        free = 3 * (len(nodes) - len(edge))
        assert len(model.free_dofs) == free - 3 * len(link.nodes) + (2 if size == 4 else 3)
        assert np.all(frequencies(model) > 1.0)


def test_distributing_link_moves_as_the_nodes_do_on_average() -> None:
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.6, 0.5]])
    sides = [(0, 1), (1, 2), (2, 3), (3, 0)]
    body = PointMass(4, 3.0, 0.1)
    model = mast(corners, sides, held=(), masses=[body], links=[DistributingLink(4, range(4), [1.0, 2.0, 3.0, 1.0])])
    rigid, free = model.rigid_motions, model.free_dofs
    assert model.expansion @ rigid[free] == pytest.approx(rigid)
    assert np.all(frequencies(model, 7)[:6] < 1e-3)
    assert frequencies(model, 7)[6] > 1.0
    with pytest.raises(MeshError, match=r"links\[0\].*in a line"):
        mast(corners, sides, masses=[body], links=[DistributingLink(4, [0, 1])])


def test_cable_ends_anywhere_on_an_edge() -> None:
    """A cable that ends between two nodes of an edge holds both by their shares, and rigid motions stay free."""
    nodes, triangles = sheet((2, 2), 0.0, 1.0)
    nodes = np.vstack([nodes, [1.0, 0.65, 0.0], [1.5, 0.65, 0.0]])
    cable = tf.CableSection(tf.Material(1e9, 1440.0), 1e-6)
    left = np.flatnonzero(nodes[:, 0] == 0.0).tolist()
    model = tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=FILM,
        membrane_stress=(4e4, 4e4, 0.0),
        cables=[(9, 10)],
        cable=cable,
        cable_tension=2.0,
        supports=[Support.pinned([*left, 10])],
        links=[Attachment([9])],
    )
    row = model.expansion[[model.translation_dofs[9, 2]]].toarray().ravel()
    assert row[model.free_places[model.translation_dofs[[7, 8], 2]]] == pytest.approx([0.7, 0.3])
    assert np.count_nonzero(row) == 2
    assert frequencies(model)[0] > 0.0
    with pytest.raises(MeshError, match=r"links\[0\]: expected node 10 on the film"):
        tf.Model.from_mesh(nodes, triangles=triangles, membrane=FILM, links=[Attachment([9, 10])])


def test_cables_that_end_between_the_nodes_of_a_film_pull_it_whole() -> None:
    """Across every column of cells the film carries the pull of the cables that end on its edge."""
    nodes, triangles = sheet((8, 8), 0.0, 1.0)
    ends = np.array([[1.0, y, 0.0] for y in (0.17, 0.4, 0.61, 0.83)])
    places = len(nodes) + np.arange(4)
    nodes = np.concatenate([nodes, ends, ends + np.array([0.5, 0.0, 0.0])])
    model = tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=FILM,
        membrane_stress=(8e4, 0.0, 0.0),
        cables=np.column_stack([places, places + 4]),
        cable=tf.CableSection(tf.Material(1.3e11, 1440.0, 0.3), 1e-6),
        cable_tension=2.0,
        supports=[Support.pinned([*range(9), *(places + 4)])],
        links=[Attachment(places.tolist())],
    )
    state = tf.solve_prestress(model, check=False)  # unpulled corners of the edge are pressed
    stress, column = state.membrane_stress[:, 0], (8 * nodes[triangles].mean(axis=1)[:, 0]).astype(int)
    for k in range(8):
        assert 1e-4 * stress[column == k].mean() == pytest.approx(8.0, rel=1e-9)


def lifted(state: tf.PrestressedState, node: int, force: float) -> np.ndarray:
    """Deflections of all nodes under a force on one."""
    forces = np.zeros((len(state.model.nodes), 3))
    forces[node, 2] = force
    return np.asarray(state.system.translations(tf.solve_static(state, -nodal_load(state.system, forces)))[:, 2])


def test_springs_to_the_frame_and_between_nodes() -> None:
    """A spring at the tip adds to the 3 EI / L^3 of a cantilever, wherever its other end is held."""
    bending = 7e10 * 8.33e-10
    high = np.vstack([LINE, [1.0, 0.0, 0.5], [1.2, 0.0, 0.5]])
    beams = [*CHAIN, (11, 12)]
    wanted = 1e-3 / (3.0 * bending + 100.0)
    upright = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    for spring in (
        Spring((10,), (0.0, 0.0, 100.0)),
        Spring((10,), (100.0, 0.0, 0.0), upright),
        Spring((10, 11), 100.0),
        Spring((11, 10), (0.0, 0.0, 100.0, 0.0, 0.0, 0.0)),
    ):
        model = mast(high, beams, held=(0, 11, 12), springs=[spring])
        assert lifted(tf.solve_prestress(model), 10, 1e-3)[10] == pytest.approx(wanted, rel=1e-6)


def test_springs_with_arms_leave_rigid_motions_free() -> None:
    nodes = np.vstack([LINE, [1.2, 0.5, 0.3]])
    beams = [*CHAIN, (10, 11)]
    springs = [Spring((3, 11), np.full(6, 50.0), place=0.4), Spring((0, 11), 80.0)]
    found = frequencies(mast(nodes, beams, held=(), springs=springs), 7)
    assert np.all(found[:6] < 1e-3)
    assert found[6] > 1.05 * frequencies(mast(nodes, beams, held=()), 7)[6]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"links": [RigidLink(0, [10]), Tie(5, [10])]}, r"links\[1\]: expected x of node 10 to follow one link"),
        ({"links": [RigidLink(5, [0])]}, r"links\[0\]: expected x of node 0 to follow the link alone.*support"),
        ({"links": [Tie(5, [6]), Tie(6, [5])]}, r"following itself"),
        ({"links": [Tie(5, [11])]}, r"links\[0\]: expected node numbers in 0\.\.10, got 11"),
        ({"links": [Attachment([5])]}, r"links\[0\]: expected node 5 on the film"),
        ({"springs": [Spring((5, 12), 1.0)]}, r"springs\[0\]: expected node numbers"),
    ],
)
def test_refused_by_name(given: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        mast(**given)


def test_pieces_that_only_links_join() -> None:
    apart = LINE + np.where(np.arange(11)[:, None] > 5, [0.0, 0.1, 0.0], 0.0)
    beams = [(i, i + 1) for i in range(5)] + [(6 + i, 7 + i) for i in range(4)]
    with pytest.raises(MeshError, match="2 pieces"):
        mast(apart, beams)
    assert frequencies(mast(apart, beams, links=[RigidLink(5, [6])]))[0] == pytest.approx(8.2, rel=0.1)


def test_links_that_hold_a_free_structure_are_told() -> None:
    apart = mast(held=(), links=[LinkEquation([(10, "y", 1.0), (5, "y", -1.0)])])
    assert apart.rigid_freedom == 5
    assert any("hold the structure against 1 rigid motion" in text for text in tf.solve_prestress(apart).warnings)
    rigid = mast(held=(), links=[RigidLink(5, [10])])
    assert rigid.rigid_freedom == 6
    assert not tf.solve_prestress(rigid).warnings
    assert mast(held=(), springs=[Spring([3], np.ones(6))]).rigid_freedom == 0


def test_turns_of_links_beyond_small_ones_are_told() -> None:
    """A tip moment that turns the linked end by 0.5 rad."""
    nodes = np.vstack([LINE, [1.0, 0.3, 0.0]])
    state = tf.solve_prestress(mast(nodes, links=[RigidLink(10, [11])]))
    for force, told in ((1.0, False), (60.0, True)):
        push = tf.NodalForce([11], force=(force, 0.0, 0.0))
        run = tf.simulate(state, None, time_step=5e-3, end_time=0.1, inputs=[push], probes={"tip": LINE[10]})
        assert any("turn of a link" in text for text in run.warnings) == told
