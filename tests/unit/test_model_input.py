"""What `Model.from_mesh`, sections and layouts say about unusable input."""

from __future__ import annotations

import numpy as np
import pytest

from tautflex import (
    BeamSection,
    CableSection,
    InputError,
    Material,
    MembraneSection,
    MeshError,
    Model,
    solve_modes,
    solve_prestress,
)
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.model import Support

MATERIAL = Material(3.5e9, 1530.0, 0.34)
FILM = MembraneSection(MATERIAL, 1e-4)
CABLE = CableSection(MATERIAL, 3e-6)
BEAM = BeamSection(MATERIAL, 5e-4, 4e-7, 3e-7, 7e-7)
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TWO = [[0, 1, 2], [0, 2, 3]]


def film(nodes=SQUARE, triangles=TWO, **options) -> Model:
    return Model.from_mesh(nodes, triangles=triangles, membrane=FILM, **options)


def message(kind: type[Exception], call) -> str:
    with pytest.raises(kind) as caught:
        call()
    return str(caught.value)


def test_disconnected_mesh():
    nodes = np.vstack([SQUARE, SQUARE[:3] + 5.0])
    text = message(MeshError, lambda: film(nodes, [*TWO, [4, 5, 6]]))
    assert "expected one connected structure, got 2 pieces" in text
    assert "3 node(s), e.g. node 4" in text
    assert "merge duplicate nodes, join the pieces with cables or beams, or hold each of them" in text
    # A cable that joins them is enough.
    joined = film(nodes, [*TWO, [4, 5, 6]], cables=[[2, 4]], cable=CABLE)
    assert len(joined.cables) == 1


def test_degenerate_triangle():
    nodes = np.vstack([SQUARE, [0.5, 0.5, 0.0]])
    text = message(MeshError, lambda: film(nodes, [*TWO, [0, 4, 2]]))
    assert "triangles: element 2 (nodes [0, 4, 2]) is degenerate" in text
    assert "merge its duplicate nodes" in text
    assert "element 0 (nodes [0, 0, 1])" in message(MeshError, lambda: film(SQUARE, [[0, 0, 1], [1, 2, 3]]))


@pytest.mark.parametrize("bad", [4, -1])
def test_node_number_out_of_range(bad):
    text = message(MeshError, lambda: film(SQUARE, [[0, 1, 2], [0, 2, bad]]))
    assert f"triangles: expected node numbers in 0..3, got {bad} in row 1; count nodes from 0" in text


@pytest.mark.parametrize(("value", "shown"), [(np.nan, "nan"), (np.inf, "inf")])
def test_node_positions_that_are_not_finite(value, shown):
    nodes = SQUARE.copy()
    nodes[2, 1] = value
    text = message(MeshError, lambda: film(nodes))
    assert f"nodes: expected finite numbers, got {shown} at index (2, 1)" in text


def test_node_positions_in_the_plane_only():
    text = message(MeshError, lambda: film(SQUARE[:, :2]))
    assert "nodes: expected shape (any, 3), got (4, 2)" in text


def test_unused_node():
    text = message(MeshError, lambda: film(np.vstack([SQUARE, [9.0, 9.0, 9.0]])))
    assert "node 4 belongs to no element (1 such node(s)); remove unused nodes or connect them" in text


@pytest.mark.parametrize("kind", ["cables", "beams"])
def test_line_without_length(kind):
    nodes = np.vstack([SQUARE, SQUARE[2]])
    section = {"cables": {"cable": CABLE}, "beams": {"beam": BEAM}}[kind]
    text = message(MeshError, lambda: film(nodes, **{kind: [[1, 4], [2, 4]]}, **section))
    assert f"{kind}: element 1 (nodes [2, 4]) has length 0 m; remove it or separate its nodes" in text


def test_no_elements():
    text = message(MeshError, lambda: Model.from_mesh(SQUARE))
    assert "expected at least one element, got none; give triangles, cables or beams" in text


def test_connectivity_of_wrong_shape_or_type():
    text = message(MeshError, lambda: film(SQUARE, [[0, 1, 2, 3]]))
    assert "triangles: expected an integer array of shape (any, 3), got shape (1, 4)" in text
    text = message(MeshError, lambda: film(SQUARE, np.array(TWO, dtype=float)))
    assert "triangles: expected an integer array" in text
    assert "float64" in text


def test_missing_or_wrong_section():
    text = message(InputError, lambda: Model.from_mesh(SQUARE, triangles=TWO))
    assert "triangles: expected a MembraneSection, got None" in text
    text = message(InputError, lambda: film(cables=[[0, 2]], cable=FILM))
    assert "cables: expected a CableSection" in text


def test_prestress_that_is_not_finite():
    text = message(InputError, lambda: film(membrane_stress=(1.0, np.nan, 0.0)))
    assert "membrane_stress: expected finite numbers, got nan" in text
    text = message(InputError, lambda: film(cables=[[0, 2]], cable=CABLE, cable_tension=np.inf))
    assert "cable_tension: expected finite numbers, got inf" in text


def test_support_that_does_not_exist():
    text = message(MeshError, lambda: film(supports=[Support.pinned([0, 7])]))
    assert "supports: expected node numbers in 0..3, got 7" in text
    text = message(InputError, lambda: film(supports=[Support((0,), ("x", "up"))]))
    assert "directions: expected one of 'x', 'y', 'z', 'rx', 'ry', 'rz', got 'up'" in text


def test_unknown_prestress_mode():
    text = message(InputError, lambda: film(prestress_mode="magic"))
    assert "prestress_mode: expected one of 'equilibrium', 'uniform', 'initial-strain', got 'magic'" in text


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf, "thick", None])
@pytest.mark.parametrize(
    ("name", "build"),
    [
        ("thickness", lambda v: MembraneSection(MATERIAL, v)),
        ("area", lambda v: CableSection(MATERIAL, v)),
        ("inertia_y", lambda v: BeamSection(MATERIAL, 1.0, v, 1.0, 1.0)),
        ("torsion_constant", lambda v: BeamSection(MATERIAL, 1.0, 1.0, 1.0, v)),
        ("density", lambda v: Material(1e9, v)),
        ("youngs_modulus", lambda v: Material(v, 1e3)),
        ("length", lambda v: AntennaLayout(v, 1.0, (2, 2))),
    ],
)
def test_values_that_must_be_positive(name, build, value):
    text = message(InputError, lambda: build(value))
    assert text.startswith(f"{name}: expected a")
    assert f"got {value!r}" in text


@pytest.mark.parametrize("value", [-1.0, 0.5, 0.7, np.nan])
def test_poisson_ratio_out_of_range(value):
    text = message(InputError, lambda: Material(1e9, 1e3, value))
    assert text.startswith("poisson_ratio: expected a")


def test_unknown_strain():
    text = message(InputError, lambda: MembraneSection(MATERIAL, 1e-4, "hencky"))
    assert "strain: expected one of 'von-karman', 'green-lagrange', got 'hencky'" in text


def antenna(**options) -> Model:
    values = {"frame_length": 2.5, "frame_width": 1.5, **options}
    layout = AntennaLayout(2.0, 1.0, (4, 2), **values)
    return build_antenna(layout, FILM, CABLE, BEAM, pretension_x=1.0, pretension_y=1.0)


def test_layouts_that_cannot_be_built():
    text = message(InputError, lambda: antenna(frame_width=None))
    assert "frame_length, frame_width: expected both or neither" in text
    text = message(InputError, lambda: antenna(frame_width=0.9))
    assert "expected a frame larger than the film on both sides; enlarge the frame" in text
    text = message(InputError, lambda: antenna(frame_width=None, frame_length=None))
    assert "use build_fixed_film instead" in text
    text = message(MeshError, lambda: antenna(cables_per_long_edge=6))
    assert "divisions: expected at least 5" in text
    assert "got 4; refine the mesh or use fewer cables" in text
    text = message(InputError, lambda: antenna(support="middle"))
    assert "support: expected one of 'corners'" in text
    text = message(InputError, lambda: AntennaLayout(2.0, 1.0, (4, 0)))
    assert "divisions: expected two integers >= 1, got (4, 0)" in text
    text = message(InputError, lambda: antenna(pattern="union-jack"))
    assert "pattern: expected one of 'alternating', 'regular', got 'union-jack'" in text


def test_more_modes_than_unknowns():
    state = solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (2, 2)), FILM, (1e4, 1e4, 0.0)))
    for n in (0, 3):
        text = message(InputError, lambda n=n: solve_modes(state, n))
        assert f"n: expected 1 to 2 modes, got {n}; refine the mesh for more" in text
