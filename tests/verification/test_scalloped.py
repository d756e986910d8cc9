"""Films whose edges are cut along arcs, and form finding, against ellipses, soap films and observed orders."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.structure.antenna import AntennaLayout
from tautflex.structure.scalloped import build_scalloped_antenna

FILM = tf.MembraneSection(tf.Material(3e9, 1420.0, 0.34), 5e-5)
CABLE = tf.CableSection(tf.Material(65e9, 1440.0), 1e-6)
CORD = tf.CableSection(tf.Material(65e9, 1440.0), 5e-7)
TUBE = tf.BeamSection(tf.Material(70e9, 1600.0, 0.3), 1.854e-4, 8.07e-8, 8.07e-8, 1.614e-7)
EQUAL, UNEQUAL = (2e5, 2e5), (2e5, 1.2e5)


def antenna(cells=(8, 6), stress=EQUAL, sag=0.1, corners="straight", **options):
    layout = AntennaLayout(4.0, 3.0, cells, frame_length=4.4, frame_width=3.4, **options)
    return build_scalloped_antenna(layout, FILM, CABLE, CORD, TUBE, membrane_stress=stress, sag=sag, corners=corners)


def cord_tension(model):
    return model.groups[-1].initial[:, 0]


def test_cords_of_equal_resultants_lie_on_circles_under_one_tension(verification_row):
    """A cord of tension T under N [N/m] has the radius T/N; an arc of span L and sag d that of L^2/(8 d) + d/2."""
    radius = 4.0**2 / (8.0 * 0.4) + 0.2
    found = []
    for cells in ((16, 12), (32, 24)):
        model = tf.find_form(antenna(cells))
        edge = np.flatnonzero(np.abs(model.nodes[:, 1] - 1.5) < 0.45)
        edge = edge[np.isin(edge, model.groups[-1].connectivity) & (np.abs(model.nodes[edge, 0]) < 1.6)]
        fitted = np.hypot(model.nodes[edge, 0], model.nodes[edge, 1] - (1.5 - 0.4 + radius))
        found.append(
            [np.abs(fitted / radius - 1.0).max(), np.abs(cord_tension(model)[: cells[0]] / (10 * radius) - 1).max()]
        )
    order = np.log2(np.array(found[0]) / found[1])
    assert np.all(np.array(found[1]) < 1e-4)
    assert np.all(order > 1.85)
    verification_row(
        "scalloped edge: radius and tension of the cord", f"{radius:.4g} m", f"{found[1][0]:.1e} off", "T / N"
    )


@pytest.mark.parametrize("corners", ["straight", "diagonal"])
@pytest.mark.parametrize("element", ["triangle3", "triangle6", "quad4"])
def test_the_whole_film_has_the_chosen_stress(corners, element, verification_row):
    model = tf.find_form(antenna(stress=UNEQUAL, corners=corners, element=element))
    state = tf.solve_prestress(model)
    assert state.relative_residual < 1e-12
    assert state.warnings == ()
    assert state.membrane_stress == pytest.approx(np.tile([*UNEQUAL, 0.0], (len(state.membrane_stress), 1)), abs=1e-2)
    assert state.min_principal_stress > 0.0
    verification_row(f"scalloped film, {corners} corners, {element}: stress", "uniform", "to 1e-7", "find_form")


@pytest.mark.parametrize("corners", ["straight", "diagonal"])
def test_ellipses_are_the_limit_of_the_balanced_shape(corners):
    """Unequal resultants, two arcs on each long edge: nodes on the arcs are out of balance by h^2."""
    off = []
    for cells in ((8, 6), (16, 12), (32, 24)):
        model = antenna(cells, UNEQUAL, corners=corners, cables_per_long_edge=3)
        off.append(np.abs(tf.find_form(model).nodes - model.nodes).max())
    assert np.log2(off[0] / off[1]) > 1.9
    assert np.log2(off[1] / off[2]) > 1.9
    assert off[2] < 2e-4


@pytest.mark.slow
@pytest.mark.parametrize("element", ["triangle3", "quad4", "triangle6"])
def test_frequencies_converge_with_the_mesh(element, verification_row):
    """Ten modes, none of which flaps at the edges, of order 2 or better in meshes that are fine enough to see it."""
    found = []
    for cells in ((12, 8), (24, 16), (48, 32)) if element == "triangle6" else ((24, 16), (48, 32), (96, 64)):
        state = tf.solve_prestress(tf.find_form(antenna(cells, corners="diagonal", element=element)))
        assert state.min_principal_stress > 0.999 * EQUAL[0]
        modes = tf.solve_modes(state, 10)
        # Modes of different symmetry may change places.
        found.append(modes.frequencies[np.argsort(modes.symmetry, kind="stable")])
    change = -np.diff(found, axis=0)
    order = np.log2(change[0] / change[1])
    # Quads come to 2 from both sides, by 0.003.
    assert order.min() > (1.99 if element == "quad4" else 2.0)
    last = np.abs(change[1] / found[2]).max()
    verification_row(
        f"scalloped antenna, {element}: order of ten frequencies",
        "2",
        f"{order.min():.2f} to {order.max():.2f}",
        f"last change {last:.1e}",
    )


def soap_film(rings, around):
    """Catenoid between rings of radius 1 at z = -0.5 and 0.5, started as a cylinder."""
    angle = 2.0 * np.pi * np.arange(around) / around
    height = np.linspace(-0.5, 0.5, rings + 1)
    nodes = np.array([(np.cos(a), np.sin(a), z) for z in height for a in angle])
    number = np.arange((rings + 1) * around).reshape(rings + 1, around)
    a, b = number[:-1], np.roll(number[:-1], -1, axis=1)
    c, d = np.roll(number[1:], -1, axis=1), number[1:]
    triangles = np.concatenate([np.stack(corners, axis=2).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    held = np.concatenate([number[0], number[-1]])
    return tf.Model.from_mesh(
        nodes, triangles=triangles, membrane=FILM, membrane_stress=(1e5, 1e5, 0.0), supports=(tf.Support.pinned(held),),
        membrane_orientation=(0.0, 0.0, 1.0), prestress_mode="uniform",
    )  # fmt: skip


def test_soap_film_between_rings_is_a_catenoid(verification_row):
    """Neck a with a cosh(1 / (2 a)) = 1 [Euler 1744]."""
    from scipy.optimize import brentq

    neck = brentq(lambda a: a * np.cosh(0.5 / a) - 1.0, 0.5, 1.0)
    errors = []
    for rings, around in ((6, 24), (12, 48)):
        model = tf.find_form(soap_film(rings, around))
        middle = np.abs(model.nodes[:, 2]) < 0.02
        errors.append(np.hypot(*model.nodes[middle, :2].T).mean() / neck - 1.0)
    assert abs(errors[1]) < 5e-3
    assert np.log2(errors[0] / errors[1]) > 1.8
    verification_row("soap film between rings: neck", f"{neck:.5f} m", f"{neck * (1 + errors[1]):.5f} m", "catenoid")


def test_cables_cut_into_segments_weigh_and_pull_the_same():
    whole, cut = (tf.find_form(antenna(corners="diagonal", cable_segments=count)) for count in (1, 4))
    assert len(cut.groups[1].connectivity) == 4 * 4
    assert cut.mass == pytest.approx(whole.mass, rel=1e-12)
    assert cut.groups[1].initial[:, 0] == pytest.approx(np.repeat(whole.groups[1].initial[:, 0], 4), rel=1e-9)
    found = [tf.solve_modes(tf.solve_prestress(model), 6).frequencies for model in (whole, cut)]
    assert found[1] == pytest.approx(found[0], rel=1e-4)


def test_template_is_silent_and_its_straps_point_to_the_corners():
    state = tf.solve_prestress(tf.build_model(parse_case(template("scalloped"), ["mesh.divisions=[8, 6]"])))
    assert state.warnings == ()
    ends = state.model.nodes[state.model.groups[1].connectivity]
    # Discrete corners are where arcs of cords meet, a little off those of the film.
    assert np.abs(ends[:, 0, :2]) == pytest.approx(np.tile([2.0, 1.5], (4, 1)), abs=2e-3)
    assert np.abs(ends[:, 1, :2]) == pytest.approx(np.tile([2.2, 1.7], (4, 1)))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"sag": 0.6}, "turns back"),
        ({"sag": 0.0}, "sag"),
        ({"sag": 0.35}, "cut less"),
        ({"stress": (2e5, -1.0)}, "membrane_stress along y"),
        ({"corners": "round"}, "diagonal"),
    ],
)
def test_impossible_cuts_are_refused(options, words):
    with pytest.raises(tf.InputError, match=words):
        antenna(**options)


def test_forms_that_do_not_exist_are_refused():
    model = antenna()
    loose = tuple(replace(group, initial=0.0 * group.initial) for group in model.groups)
    with pytest.raises(tf.InputError, match="got none"):
        tf.find_form(replace(model, groups=loose))
    pushing = (*model.groups[:-1], replace(model.groups[-1], initial=-model.groups[-1].initial))
    with pytest.raises(tf.InputError, match="pull"):
        tf.find_form(replace(model, groups=pushing))
    nodes = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]
    film = tf.MembraneSection(tf.Material(3e9, 1420.0, 0.34), 5e-5)
    hung = {"membrane": film, "membrane_stress": (1e5, 1e5, 0.0), "supports": [tf.Support.pinned([0, 3])]}
    hung |= {"quads": [(1, 2, 5, 4)], "springs": [tf.Spring(pair, (1.0, 1.0, 1.0)) for pair in ((0, 1), (3, 4))]}
    hung |= {"cables": [(0, 3)], "cable": tf.CableSection(tf.Material(65e9, 1440.0), 5e-7)}
    with pytest.raises(tf.InputError, match="springs alone hold"):
        tf.find_form(tf.Model.from_mesh(nodes, **hung))
    # A soap film breaks between rings further apart than 1.3255 radii.
    far = soap_film(8, 16)
    with pytest.raises(tf.NotConvergedError, match="no such shape") as told:
        tf.find_form(replace(far, nodes=far.nodes * (1.0, 1.0, 1.5)), max_iterations=60)
    assert told.value.result.shape == far.nodes.shape


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["cables.pretension_x=1.0"], "cables.pretension_x: expected no value"),
        (["prestress.mode='uniform'"], "prestress: expected nothing stated"),
        (["membrane.edges='cables'"], "edge_cords: expected no such section"),
        (["edge_cords.sag=0.6"], "edge_cords.sag: expected a cut"),
    ],
)
def test_case_files_say_what_does_not_go_together(changes, words):
    with pytest.raises(tf.CaseError, match=words):
        tf.build_model(parse_case(template("scalloped"), changes))
