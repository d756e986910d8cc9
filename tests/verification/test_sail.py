"""The sail that `tautflex init` writes: its mesh, the pull of its cords, its symmetry."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import template_files
from tautflex.cli import main

EXAMPLE = Path(__file__).parents[2] / "examples" / "sail_mesh.py"


def test_the_example_writes_the_mesh_of_the_template():
    own = runpy.run_path(str(EXAMPLE))
    assert own["abaqus"](own["sail"](2.0, 8.0, 0.05, 12)) == template_files("sail")["sail.inp"]


def test_cords_hold_a_uniform_film_and_pull_at_the_corners(tmp_path, verification_row, capsys):
    file = tmp_path / "sail.toml"
    assert main(["init", str(file), "--template", "sail"]) == 0
    assert main(["check", str(file)]) == 0
    assert "warning" not in capsys.readouterr().out
    case = tf.load_case(file)
    state = tf.solve_prestress(tf.build_model(case))
    assert state.min_principal_resultant == pytest.approx(0.4 / 8.0, rel=1e-3)
    # Two cords of 0.4 N meet in each corner, 30 degrees less half the arc from the boom; nothing else is unbalanced.
    half_arc = np.arcsin(0.5 * 2.0 * np.sqrt(3.0) / 8.0)
    pull = 2.0 * 0.4 * np.cos(np.pi / 6.0 - half_arc)
    verification_row("Pull of a sail's corner on its boom [N]", pull, state.residual, "two cords")
    assert state.residual == pytest.approx(pull, rel=2e-3)
    frequencies = tf.solve_modes(state, n=6).frequencies
    np.testing.assert_allclose(frequencies[[1, 4]], frequencies[[2, 5]], rtol=1e-6)  # a third of a turn changes nothing
