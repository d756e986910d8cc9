"""Prestressed states against statics, closed forms and invariance."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import (
    BeamSection,
    CableSection,
    Coupling,
    InputError,
    Material,
    MembraneSection,
    Model,
    NotConvergedError,
    PrestressError,
    solve_modes,
    solve_prestress,
    tune_pretension,
)
from tautflex.mechanics.membrane import principal_resultants
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.model import Support
from verification.builders import CABLE, FILM, THICKNESS, antenna
from verification.dynamic_cases import small_antenna

FILM_SECTION = MembraneSection(FILM, THICKNESS)
CABLE_SECTION = CableSection(CABLE, 3.14e-6)


@pytest.mark.parametrize("support", ["corners", "all", "axis", "short-side", "free"])
def test_cables_at_every_edge_node_make_the_film_uniform(support, verification_row):
    resultants = np.array([0.59, 1.0])
    strain = "green-lagrange" if support == "free" else "von-karman"
    state = solve_prestress(antenna(tuple(resultants), (12, 6), support=support, strain=strain))
    found = state.membrane_stress * THICKNESS
    np.testing.assert_allclose(found, np.tile([*resultants, 0.0], (len(found), 1)), atol=1e-9)
    assert state.min_principal_resultant == pytest.approx(0.59, rel=1e-9)
    assert state.min_principal_stress == pytest.approx(0.59 / THICKNESS, rel=1e-9)
    assert state.residual < 1e-9
    assert state.unstable_modes == 0
    tension = state.cable_tension  # final, so as given: corner cables half
    np.testing.assert_allclose(np.unique(tension.round(9)), [0.59 / 12, 1 / 12, 0.59 / 6, 1 / 6], atol=1e-9)
    error = float(np.abs(found - [*resultants, 0.0]).max())
    verification_row(f"equilibrium mode, support {support}: film resultant - T/spacing [N/m]", 0.0, error, "statics")


def test_axial_force_of_a_free_frame_follows_from_a_cut(verification_row):
    """Cutting the antenna across: two frame sides carry the film's pull in compression, half each."""
    state = solve_prestress(antenna((0.59, 1.0), (10, 5), support="free", strain="green-lagrange"))
    nodes, beams = state.model.nodes, state.model.beams
    along_x = np.abs(np.diff(nodes[beams][:, :, 0], axis=1)[:, 0]) > 1e-9
    force = state.beam_axial_force
    # A cut x = const crosses 1 m of film; the corner cables stand at the film's corners, inside the frame's.
    np.testing.assert_allclose(force[along_x], -0.5 * 0.59 * 1.0, rtol=1e-9)
    np.testing.assert_allclose(force[~along_x], -0.5 * 1.0 * 2.0, rtol=1e-9)
    verification_row("free antenna, axial force of the long sides [N]", -0.295, force[along_x][0], "cut")
    verification_row("free antenna, axial force of the short sides [N]", -1.0, force[~along_x][0], "cut")


def test_free_antenna_has_six_rigid_modes(verification_row):
    for scale in (0.1, 1.0, 10.0):
        resultants = (0.59 * scale, 1.0 * scale)
        state = solve_prestress(antenna(resultants, (20, 10), support="free", strain="green-lagrange"))
        assert state.residual < 1e-9
        modes = solve_modes(state, 8)
        rigid = float(np.abs(modes.frequencies[:6]).max())
        assert rigid < 1e-3
        assert modes.frequencies[6] > 0.1
        case = f"free antenna, Nx = {resultants[0]:g} N/m: largest of six rigid frequencies [Hz]"
        verification_row(case, "< 1e-3", f"< {10 ** np.ceil(np.log10(rigid)):.0e}", "rigid-body invariance", "")
        # The six vectors are the rigid motions: what is left of these outside their span vanishes.
        mass = state.system.inertia.mass_matrix
        motions = state.model.rigid_motions
        outside = motions - modes.vectors[:6].T @ (modes.vectors[:6] @ (mass @ motions))
        left = np.sqrt(np.diag(outside.T @ (mass @ outside)) / np.diag(motions.T @ (mass @ motions)))
        assert left.max() < 1e-3


@pytest.mark.parametrize(
    ("film", "frame", "largest"),
    [("green-lagrange", "von-karman", 0.02), ("von-karman", "von-karman", 0.2)],
)
def test_leaving_out_second_order_terms_gives_spurious_rigid_stiffness(film, frame, largest, verification_row):
    """Why the frame's bending needs second-order terms: without them free flight is not free."""
    model = antenna((5.9, 10.0), (10, 5), support="free", strain=film, beam_strain=frame)
    state = solve_prestress(model, check=False)
    rigid = float(np.abs(solve_modes(state, 8).frequencies[:6]).max())
    assert rigid > largest
    case = f"free antenna with {frame} frame and {film} film: largest of six rigid frequencies [Hz]"
    verification_row(case, "> 5e-3 (spurious)", f"{rigid:.3g}", "counter-example", "")


def strip(mode: str, poisson_ratio: float = 0.0, divisions: int = 4) -> Model:
    """Film strip 1 m x 0.2 m held at x = 0, pulled at x = 1 by two cables of 0.25 m to fixed points."""
    material = Material(3.5e9, 1530.0, poisson_ratio)
    x = np.linspace(0.0, 1.0, divisions + 1)
    nodes = np.array([[a, b, 0.0] for a in x for b in (0.0, 0.2)] + [[1.25, 0.0, 0.0], [1.25, 0.2, 0.0]])
    triangles = []
    for i in range(divisions):
        a = 2 * i
        triangles += [[a, a + 2, a + 3], [a, a + 3, a + 1]]
    last = 2 * divisions
    return Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=MembraneSection(material, THICKNESS),
        cables=[[last, last + 2], [last + 1, last + 3]],
        cable=CABLE_SECTION,
        cable_tension=0.3,
        supports=[
            Support((0, 1), ("x", "z")),
            Support((0,), ("y",)),
            Support.pinned([last + 2, last + 3]),
        ],
        prestress_mode=mode,
    )


def test_cables_shortened_against_a_strip_in_series(verification_row):
    """Two springs in series: of the tension between rigid ends, k_f/(k_f + k_c) is left."""
    film = 3.5e9 * THICKNESS * 0.2 / 1.0
    cables = 2.0 * 133e9 * 3.14e-6 / 0.25
    exact = 0.3 * film / (film + cables)
    state = solve_prestress(strip("initial-strain"), check=False)
    np.testing.assert_allclose(state.cable_tension, exact, rtol=1e-9)
    found = state.membrane_stress * THICKNESS
    np.testing.assert_allclose(found[:, 0], 2.0 * exact / 0.2, rtol=1e-9)
    assert np.abs(found[:, 1:]).max() < 1e-9 * found[0, 0]
    verification_row(
        "film strip and cables in series, tension left [N]", exact, state.cable_tension[0], "T k_f/(k_f+k_c)"
    )


def test_shortened_cables_relax_on_the_antenna(verification_row):
    """Rigid frame, no Poisson effect, cables at the corners: their mean follows the same two springs.

    The film's mean strain is the mean displacement of its corners, whatever its diagonal; little tension is
    left because the cables are far stiffer than the film.
    """
    layout = AntennaLayout(2.0, 1.0, (1, 1), "alternating", 2.5, 1.5, 2, 2, "equal", "all")
    model = build_antenna(
        layout,
        MembraneSection(Material(3.5e9, 1530.0, 0.0), THICKNESS),
        CABLE_SECTION,
        BeamSection(Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=0.4,
        pretension_y=0.7,
        prestress_mode="initial-strain",
    )
    state = solve_prestress(model, check=False)
    pulls_along_x = np.abs(np.diff(model.nodes[model.cables], axis=1)[:, 0, 0]) > 0.1
    cable = 133e9 * 3.14e-6 / 0.25
    for axis, tension, width, half in (("x", 0.4, 1.0, 1.0), ("y", 0.7, 2.0, 0.5)):
        film = 3.5e9 * THICKNESS * (0.5 * width) / half
        exact = tension * film / (film + cable)
        mean = state.cable_tension[pulls_along_x == (axis == "x")].mean()
        assert mean == pytest.approx(exact, rel=1e-9)
        case = f"initial-strain mode, part of the tension left along {axis}"
        verification_row(case, film / (film + cable), mean / tension, "k_f/(k_f+k_c)")


def test_few_cables_on_free_edges_are_refused():
    with pytest.raises(PrestressError) as caught:
        solve_prestress(antenna((0.59, 1.0), (20, 10), cables=(5, 3)))
    text = str(caught.value)
    state = solve_prestress(antenna((0.59, 1.0), (20, 10), cables=(5, 3)), check=False)
    values = principal_resultants(state.system, state.system.initial_stress)[:, 0]
    worst = int(np.argmin(values))
    centre = state.model.nodes[state.model.triangles[worst]].mean(axis=0)
    # Compression sits between the point cables, along the edges.
    assert min(1.0 - abs(centre[0]), 0.5 - abs(centre[1])) < 0.1
    assert values[worst] < -0.1
    assert f"film element {worst} at ({centre[0]:.3g}, {centre[1]:.3g}, 0) m is compressed" in text
    assert f"{values[worst]:.3g} N/m" in text
    assert "add cables along that edge" in text
    assert f"{state.unstable_modes} negative eigenvalue(s)" in text
    # A flat film: all negative eigenvalues are those of its transverse unknowns.
    transverse = state.system.place[state.model.translation_dofs[np.unique(state.model.triangles), 2]]
    stiffness = state.system.matrix(state.tangent_entries).toarray()[np.ix_(transverse, transverse)]
    assert state.unstable_modes == int(np.sum(np.linalg.eigvalsh(stiffness) < -1e-6))
    assert len(state.warnings) == 2


def test_compressive_stress_is_refused():
    with pytest.raises(PrestressError, match=r"compressed.*-2 N/m.*positive stress_x, stress_y"):
        solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (4, 2)), FILM_SECTION, (3e4, -2e4, 0.0)))
    # Tension in x and y does not help against more shear: s2 = 1 - 1.5 N/m.
    with pytest.raises(PrestressError, match=r"-0\.5 N/m \(16 of 16 elements\)"):
        solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (4, 2)), FILM_SECTION, (1e4, 1e4, 1.5e4)))


def test_no_prestress_is_refused():
    with pytest.raises(PrestressError, match=r"expected some tension, got none.*singular.*give cable pretension"):
        solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (4, 2)), FILM_SECTION, (0.0, 0.0, 0.0)))


def test_slack_cable_is_refused():
    model = antenna((0.59, 1.0), (4, 2), mode="uniform")
    tension = model.groups[1].initial.copy()
    tension[3] = -0.2
    nodes = model.nodes
    slack = Model.from_mesh(
        nodes,
        triangles=model.triangles,
        membrane=FILM_SECTION,
        membrane_stress=(5900.0, 10000.0, 0.0),
        cables=model.cables,
        cable=CABLE_SECTION,
        cable_tension=tension[:, 0],
        beams=model.beams,
        beam=model.groups[2].section,
        supports=model.supports,
    )
    with pytest.raises(PrestressError, match=r"cable 3 at \(.*\) m is slack, tension -0\.2 N \(1 of 16 cables\)"):
        solve_prestress(slack)
    assert solve_prestress(slack, check=False).cable_tension[3] == pytest.approx(-0.2)


def test_pull_that_nothing_answers_is_refused():
    """A cable that pulls a flat, transversely free film out of its plane has no equilibrium on this shape."""
    nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [1, 1, 0.5]]
    model = Model.from_mesh(
        np.array(nodes, dtype=float),
        triangles=[[0, 1, 3], [0, 3, 2]],
        membrane=FILM_SECTION,
        cables=[[3, 4]],
        cable=CABLE_SECTION,
        cable_tension=0.5,
        supports=[Support.pinned([0, 1, 2, 4])],
        prestress_mode="equilibrium",
    )
    with pytest.raises(PrestressError, match=r"imbalance of 0\.5 N.*add supports or change their directions"):
        solve_prestress(model)


def test_uniform_mode_reports_the_imbalance_of_the_papers_tensions(verification_row):
    """0.59 N and 1 N per cable every 0.2 m, film at 0.707 and 0.547 of them: by hand, node by node."""
    tension, resultant = np.array([0.59, 1.0]), np.array([0.707 * 0.59, 0.547 * 1.0])
    layout = AntennaLayout(2.0, 1.0, (10, 5), "regular", 2.5, 1.5, 11, 6, "equal", "corners")
    model = build_antenna(
        layout,
        FILM_SECTION,
        CABLE_SECTION,
        BeamSection(Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=tension[0],
        pretension_y=tension[1],
        membrane_stress=(*(resultant / THICKNESS), 0.0),
        prestress_mode="uniform",
    )
    state = solve_prestress(model)
    force = state.system.translations(state.reference_force)
    nodes = model.nodes
    film = np.unique(model.triangles)
    x, y = nodes[film, 0], nodes[film, 1]
    ends, sides = np.abs(x) > 0.999, np.abs(y) > 0.499
    # f_int: the film resists (+), the cable resists moving inwards (-); corners have half the film's share.
    expected = np.zeros((len(film), 3))
    expected[:, 0] = np.sign(x) * ends * (resultant[0] * 0.2 * np.where(sides, 0.5, 1.0) - tension[0])
    expected[:, 1] = np.sign(y) * sides * (resultant[1] * 0.2 * np.where(ends, 0.5, 1.0) - tension[1])
    np.testing.assert_allclose(force[film], expected, atol=1e-12)
    # The frame carries nothing in this mode, so a cable's full pull is left at its frame node.
    assert state.residual == pytest.approx(1.0, rel=1e-12)
    # It is also the largest force of any element.
    assert state.relative_residual == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(state.cable_tension[:22], 1.0)
    np.testing.assert_allclose(state.beam_axial_force, 0.0)
    verification_row("paper's tensions as given, largest imbalance [N]", 1.0, state.residual, "by hand, node by node")
    corner = np.abs(force[film][ends & sides][:, 1]).max()
    verification_row("paper's tensions as given, imbalance of a film corner along y [N]", 0.9453, corner, "by hand")


def test_frequencies_follow_the_square_root_of_the_tension(verification_row):
    first = solve_modes(solve_prestress(antenna((0.59, 1.0), (10, 5), support="all")), 6).frequencies
    for scale in (0.25, 4.0):
        model = antenna((0.59 * scale, 1.0 * scale), (10, 5), support="all")
        scaled = solve_modes(solve_prestress(model), 6).frequencies
        np.testing.assert_allclose(scaled, first * np.sqrt(scale), rtol=1e-8)
        by_method = antenna((0.59, 1.0), (10, 5), support="all").with_pretension_scaled(scale, scale)
        np.testing.assert_allclose(solve_modes(solve_prestress(by_method), 6).frequencies, scaled, rtol=1e-8)
    verification_row("antenna, f1 at four times the tension / f1", 2.0, scaled[0] / first[0], "f ~ √T")


def test_tuning_one_target(verification_row):
    model = antenna((0.3, 0.5), (10, 5))
    before = solve_modes(solve_prestress(model), 1).frequencies[0]
    result = tune_pretension(model, [1.0])
    assert result.frequencies[0] == pytest.approx(1.0, rel=1e-6)
    assert result.scale_x == result.scale_y
    # Frame and cables barely take part, so the scale is the square of the ratio of frequencies.
    assert result.scale_x == pytest.approx(before**-2, rel=2e-3)
    again = solve_prestress(model.with_pretension_scaled(result.scale_x, result.scale_y))
    assert solve_modes(again, 1).frequencies[0] == pytest.approx(1.0, rel=1e-6)
    verification_row("tuning f1 to 1 Hz [Hz]", 1.0, result.frequencies[0], "target")


def test_tuning_two_targets(verification_row):
    wanted = solve_modes(solve_prestress(antenna((0.5, 1.3), (10, 5))), 4).frequencies
    result = tune_pretension(antenna((0.59, 1.0), (10, 5)), [wanted[0], wanted[1]])
    np.testing.assert_allclose(result.frequencies[:2], wanted[:2], rtol=1e-6)
    # The round trip finds the tensions that made these frequencies.
    assert result.scale_x == pytest.approx(0.5 / 0.59, rel=1e-6)
    assert result.scale_y == pytest.approx(1.3 / 1.0, rel=1e-6)
    verification_row("tuning two modes, recovered Nx [N/m]", 0.5, 0.59 * result.scale_x, "round trip")
    verification_row("tuning two modes, recovered Ny [N/m]", 1.3, 1.0 * result.scale_y, "round trip")


def test_tuning_refuses_bad_targets():
    model = antenna((0.59, 1.0), (4, 2))
    with pytest.raises(InputError, match=r"expected one or two targets, got 3"):
        tune_pretension(model, [1.0, 2.0, 3.0])
    with pytest.raises(InputError, match=r"frequencies: expected a number > 0, got -1"):
        tune_pretension(model, [-1.0])
    with pytest.raises(
        InputError, match=r"modes: expected 2 different mode number\(s\) from 1, or half-waves \(m, n\), got \[1, 1\]"
    ):
        tune_pretension(model, [1.0, 2.0], modes=[1, 1])
    # f2 < f1 cannot be had: mode numbers follow the order of the frequencies.
    with pytest.raises(NotConvergedError, match=r"target \[2\.0, 1\.0\] Hz.*choose film modes or one target"):
        tune_pretension(model, [2.0, 1.0], max_iterations=5)


def test_a_load_below_the_round_off_of_the_prestress_has_an_equilibrium():
    """The published reading's cables pull with newtons; a spin of 1e-5 rad/s loads it with 1e-9 N."""
    state = solve_prestress(small_antenna())
    deflections = [
        np.abs(spinning_equilibrium(state, tf.Stop(rate=rate, duration=1.0).start(), Coupling())).max() / rate**2
        for rate in (1e-3, 1e-5)
    ]
    assert deflections[1] == pytest.approx(deflections[0], rel=1e-4)
