"""Tuning follows the mode that is meant, and says how far its mesh is from converged."""

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main
from tautflex.solvers.modal.natural import solve_modes
from tautflex.solvers.modal.refinement import mesh_errors
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from verification.builders import CABLE, FILM, FRAME


def fixed_film(divisions, stress=(4000.0, 3000.0, 0.0), pattern="alternating"):
    layout = AntennaLayout(1.0, 0.8, divisions, pattern=pattern)
    return build_fixed_film(layout, tf.MembraneSection(FILM, 1e-4), stress)


def test_error_of_the_mesh_against_the_closed_form(verification_row):
    """Film with fixed edges: w^2 = pi^2 (sx m^2/a^2 + sy n^2/b^2)/rho [theory.md 6]; the error falls by four."""
    modes = solve_modes(tf.solve_prestress(fixed_film((8, 6))), 3)
    exact = [0.5 * np.sqrt((4000.0 * m**2 + 3000.0 * n**2 / 0.64) / FILM.density) for m, n in ((1, 1), (2, 1), (1, 2))]
    told = mesh_errors(modes, [0, 1, 2])
    np.testing.assert_allclose(told, modes.frequencies / sorted(exact) - 1.0, rtol=0.05)
    finer = mesh_errors(solve_modes(tf.solve_prestress(fixed_film((16, 12))), 1), [0])
    assert told[0] / finer[0] == pytest.approx(4.0, rel=0.1)
    right = modes.frequencies[0] / min(exact) - 1.0
    verification_row("error of a frequency that the mesh leaves, as told", right, told[0], "closed form of the film")


def test_error_of_other_elements_is_not_told():
    layout = AntennaLayout(1.0, 0.8, (4, 4), element="quad4")
    state = tf.solve_prestress(build_fixed_film(layout, tf.MembraneSection(FILM, 1e-4), (4000.0, 3000.0, 0.0)))
    assert np.isnan(mesh_errors(solve_modes(state, 2), [0, 1])).all()


def flapping():
    """Film that wrinkles, pulled by few cables: its edges between them are free."""
    layout = AntennaLayout(
        2.0, 1.0, (20, 10), frame_length=2.5, frame_width=1.5, cables_per_long_edge=6, cables_per_short_edge=3
    )
    return build_antenna(
        layout,
        tf.MembraneSection(FILM, 1e-4, law="tension-field"),
        tf.CableSection(CABLE, 3.14e-6),
        tf.BeamSection(FRAME, 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=0.6,
        pretension_y=1.0,
    )


@pytest.mark.slow
def test_half_waves_are_followed_where_edges_flap():
    by_number = tf.tune_pretension(flapping(), [2.0])
    assert len(by_number.warnings) == 1
    assert "moves the film's edge" in by_number.warnings[0]
    meant = tf.tune_pretension(flapping(), [2.0], modes=[(1, 1)])
    number = meant.modes[0]
    assert number > 1
    assert f"mode {by_number.modes[0]} at 2 Hz" in by_number.warnings[0]
    modes = solve_modes(meant.state, number)
    assert modes.frequencies[number - 1] == pytest.approx(2.0, rel=1e-8)
    # Its film moves to one side as sin sin does, more than that of any mode below it.
    film = np.unique(meant.state.model.triangles)
    x, y = meant.state.model.nodes[film, :2].T
    sines = np.sin(np.pi * (x + 1.0) / 2.0) * np.sin(np.pi * (y + 0.5))
    shares = np.abs(modes.shapes[:, film, 2] @ sines) / np.linalg.norm(modes.shapes[:, film, 2], axis=1)
    assert shares.argmax() == number - 1


@pytest.mark.slow
def test_published_antenna_is_tuned_in_silence(tmp_path, capsys):
    case = tmp_path / "m2.toml"
    assert main(["init", str(case), "--template", "m2-nearest-node"]) == 0
    capsys.readouterr()
    answers = []
    for mode in ("1", "1,1"):
        assert main(["tune", str(case), "--frequency", "1.0", "--mode", mode, "--json"]) == 0
        answers.append(json.loads(capsys.readouterr().out))
    for key in ("pretension_x", "pretension_y", "frequencies", "mesh_errors"):
        assert answers[0][key] == pytest.approx(answers[1][key], rel=1e-9)
    assert answers[0]["warnings"] == []
    assert answers[0]["modes"] == answers[1]["modes"] == [1]
    assert answers[0]["mesh_errors"] == [pytest.approx(0.129, abs=1e-3)]
    assert main(["tune", str(case), "--frequency", "1.0", "--mode", "first"]) == 2
    assert "half-waves such as 1,1" in capsys.readouterr().err
