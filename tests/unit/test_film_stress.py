"""Stress of the film that a page evaluates, against the structure itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex.mechanics.membrane import principal_values
from tautflex.pages.board import board_of
from tautflex.pages.encode import unpacked
from tautflex.pages.explorable import explorable
from tautflex.pages.film_stress import film_data, film_stress
from tautflex.reduction.polynomial.monomials import monomials
from verification.dynamic_cases import small_antenna


@pytest.fixture(scope="module")
def boards():
    """Of a flat film, and of a curved one, which bends and pulls at once."""
    flat = small_antenna()
    nodes = flat.nodes.copy()
    nodes[:, 2] = 0.05 * nodes[:, 0] ** 2 + 0.03 * nodes[:, 0] * nodes[:, 1]
    curved = tf.reduce(tf.solve_prestress(replace(flat, nodes=nodes), check=False), tf.ModalBasis(count=3))
    return {"flat": board_of(explorable(tf.solve_prestress(flat))), "curved": board_of(explorable(curved))}


def motion(board, size):
    """z of a motion under a pull along x, the displacement that it stands for, and the stress that pulls."""
    plant, rom = board.plant, board.plant.rom
    eta = 1e-4 * size * np.random.default_rng(3).normal(size=rom.size) * rom.basis.amplitude / rom.basis.amplitude.max()
    value, frame = np.zeros(sum(each.size for each in plant.inputs)), np.zeros(12)
    if len(plant.rom.state.model.nodes[:, 2].nonzero()[0]) == 0:  # what acts is of the first degree alone
        value[1:3], frame[[4, 8]] = size * np.array([0.02, -0.01]), -0.1 * size
    z = np.concatenate([eta, monomials(eta), value, frame])
    vectors, columns = plant.moved_by()
    return z, vectors.T @ z, {number: column @ value for number, column in columns.items()}


def exact(board, q, change):
    """Smaller principal resultants of the full structure [N/m]."""
    system = board.plant.rom.state.system
    workspace = system.workspace()
    workspace.change_initial_stress(change)
    workspace.strain_energy(q)
    return np.concatenate(
        [principal_values(workspace.stress[k]) * system.blocks[k].size[:, None] for k in system.block_index("membrane")]
    )[:, 0]


@pytest.mark.parametrize("kind", ["flat", "curved"])
def test_stress_is_that_of_the_structure_to_the_second_degree(boards, kind, monkeypatch, verification_row):
    monkeypatch.setattr("tautflex.pages.film_stress._WEAK", 0.0)
    board, errors = boards[kind], []
    first, rest = motion(board, 1.0)[0], exact(board, 0.0 * motion(board, 1.0)[1], {})
    film = film_stress(board.plant, np.maximum(np.abs(first), 1e-6))
    for size in (1.0, 0.3, 0.15):
        z, q, change = motion(board, size)
        errors.append(np.abs(film.least(z) - exact(board, q, change)).max() / np.abs(rest).max())
    assert np.abs(film.least(first) - rest).max() > 0.2 * np.abs(rest).max(), "the motion changes the stress"
    assert film.area.sum() == pytest.approx(1.0)
    if kind == "flat":  # von Karman strain is of the second degree
        verification_row("stress of a flat film by its polynomial", 0.0, errors[0], "the structure")
        assert errors[0] < 1e-10
        return
    order = np.log2(errors[1] / errors[2])
    verification_row("stress of a curved film by its polynomial: order of its error", 3.0, order, "the structure")
    assert order == pytest.approx(3.0, abs=0.3)


def test_what_pages_watch_has_the_least_tension(boards, monkeypatch):
    """Of few elements, in few fields and as short integers, as the page has it."""
    monkeypatch.setattr("tautflex.pages.film_stress._MOST", 8)
    board = boards["flat"]
    sizes = np.abs(motion(board, 2.0)[0])
    data, film = film_data(board.plant, board.drawing, sizes), film_stress(board.plant, sizes)
    whole = np.array([film.least(z) for z in unpacked(data["check"]["z"])])
    assert data["elements"] <= 8 < data["whole"] == film.element.max() + 1
    pushed = whole.min(axis=1) < 0.0
    assert 0 < pushed.sum() < len(pushed), "some motions compress the film"
    found = unpacked(data["check"]["least"])[pushed]
    assert found == pytest.approx(whole.min(axis=1)[pushed], abs=0.02 * film.level.max())
    triangle = unpacked(data["triangle"])
    assert len(triangle) == len(board.drawing.triangles)
    assert set(triangle) == set(range(data["elements"] + 1))
