"""The example of an antenna with two wings, read from its deck: mass, inertia, rigid motions, commands."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CELLS = along, across = 4, 2


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("two_wings", EXAMPLES / "two_wings.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def folder(example, tmp_path_factory):
    """The example's deck with a held and with a free hub, and its cases."""
    path = tmp_path_factory.mktemp("wings")
    for name, held in (("held", True), ("free", False)):
        (path / f"{name}.bdf").write_text(example.deck(CELLS, held=held), encoding="utf-8")
        (path / f"{name}.toml").write_text(example.CASE.format(file=f"{name}.bdf"), encoding="utf-8")
    (path / "loop.toml").write_text((example.CASE + example.LOOP).format(file="held.bdf"), encoding="utf-8")
    return path


def stated():
    """Mass [kg] and moments of inertia about the hub [kg m^2], shape (3,), of what the deck states, by hand."""
    per_area, per_length, tube = 1420.0 * 5e-5, 1600.0 * 5e-7, 1600.0 * np.pi * (0.015**2 - 0.014**2)
    x, y = np.linspace(0.6, 2.4, along + 1), np.linspace(-0.4, 0.4, across + 1)
    # Of one wing: mass, and sums of mass times x^2 and y^2, for film, booms, cables along y and along x, bodies.
    film = per_area * np.array([1.8 * 0.8, 0.8 * (2.4**3 - 0.6**3) / 3.0, 1.8 * 0.8**3 / 12.0])
    booms = tube * np.array([6.0, 2.0 * (2.5**3 - 0.5**3) / 3.0 + 2.5**2 + 0.5**2, 4.0 * 0.25 + 2.0 / 12.0])
    up = per_length * np.array([0.2 * len(x), 0.2 * (x**2).sum(), 2.0 * len(x) * (0.5**3 - 0.4**3) / 3.0])
    side = len(y) * (0.6**3 - 0.5**3 + 2.5**3 - 2.4**3) / 3.0
    flat = per_length * np.array([0.2 * len(y), side, 0.2 * (y**2).sum()])
    tips = 0.1 * np.array([1.0, 2.5**2, 0.5**2])
    mass, xx, yy = 2.0 * (film + booms + up + flat + tips)
    zz = 0.2 * 0.02**2
    # Sections of linear beams resist twist alone: 8 m of them along x, 4 m along y.
    twist = 1600.0 * 0.5 * np.pi * (0.015**4 - 0.014**4) * np.array([8.0, 4.0, 0.0])
    return mass, np.array([yy + zz, xx + zz, xx + yy]) + 4.0 * np.array([2e-5, 3e-5, 4e-5]) + twist


def test_mass_inertia_and_rigid_motions_are_the_decks(folder, verification_row):
    state = tf.solve_prestress(tf.build_model(tf.load_case(folder / "free.toml")))
    assert state.warnings == ()
    motions = state.model.rigid_motions[state.model.free_dofs]
    found = motions.T @ state.system.matrix(state.system.inertia.mass_entries) @ motions
    mass, inertia = stated()
    assert np.diag(found) == pytest.approx([*[mass] * 3, *inertia], rel=1e-9)
    assert state.model.mass == pytest.approx(mass)
    # Both wings lie the same way about the hub: all products vanish, and of the centre only the bodies' height is left.
    assert found[3:, 3:] == pytest.approx(np.diag(inertia), abs=1e-12)
    frequencies = tf.solve_modes(state, n=7).frequencies
    assert np.abs(frequencies[:6]).max() < 1e-3 < 3.0 < frequencies[6]
    verification_row("two wings from one deck: mass [kg]", f"{mass:.6f}", f"{found[0, 0]:.6f}", "by hand")
    verification_row("... its six rigid modes [Hz]", 0.0, f"{np.abs(frequencies[:6]).max():.1e}", "free")


@pytest.mark.parametrize(("strain", "name"), [(None, "free"), ("corotational", "free"), ("corotational", "held")])
def test_frames_that_pull_at_two_links(strain, name, folder):
    """Frames linked at two nodes, which the cables pull against each other: arms turn these forces, or it is told."""
    model, links = tf.build_model(tf.load_case(folder / f"{name}.toml")), []
    for link in model.links:
        x = model.nodes[link.nodes[0], 0]
        ends = [int(np.argmin(np.linalg.norm(model.nodes - (x, side * 0.4, 0.0), axis=1))) for side in (-1, 1)]
        links.append(tf.RigidLink(link.reference, ends))
    groups = tuple(
        replace(group, section=replace(group.section, strain=strain))
        if strain and group.section.kind == "beam"
        else group
        for group in model.groups
    )
    state = tf.solve_prestress(replace(model, links=tuple(links), groups=groups))
    told = any("do not turn with them" in text for text in state.warnings)
    assert told == (strain is not None and name == "free")
    if name == "free":
        rigid = np.abs(tf.solve_modes(state, n=7).frequencies)
        assert rigid[6] > 3.0
        assert 0.1 < rigid[:6].max() < 1.0 if told else rigid[:6].max() < 1e-3


def test_modes_on_the_hub_are_those_of_the_free_spacecraft(folder, capsys):
    case = tf.load_case(folder / "loop.toml")
    free = tf.build_model(tf.load_case(folder / "free.toml"))
    body = tf.PointMass(0, case.hub.mass, case.hub.inertia)
    wanted = tf.solve_modes(tf.solve_prestress(replace(free, masses=(*free.masses, body))), n=12).frequencies[6:]
    assert main(["modes", str(folder / "loop.toml"), "-n", "6", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["on_free_hub"]
    # Linear beams have no rotary inertia in bending, the hub turns them with it.
    assert found == pytest.approx(wanted, rel=1e-5)


@pytest.mark.slow
def test_commands(folder, capsys):
    for name in ("free", "held", "loop"):
        assert main(["check", str(folder / f"{name}.toml"), "--json"]) == 0
    capsys.readouterr()
    fast = ["--set", "solver.time_step=0.01"]
    assert main(["run", str(folder / "held.toml"), *fast, "-o", str(folder / "open"), "--json"]) == 0
    assert main(["control", str(folder / "loop.toml"), *fast, "-o", str(folder / "closed"), "--json"]) == 0
    capsys.readouterr()
    turned = tf.load(folder / "closed" / "run.nc").attitude.values[-1]
    assert 2.0 * np.arctan2(turned[1:], turned[0]) == pytest.approx([0.0, 0.1, 0.0], abs=2e-3)
    # Both wings answer alike, one up and one down.
    for name in ("open", "closed"):
        w = tf.load(folder / name / "run.nc").w.values
        assert np.abs(w).max() > 1e-4
        assert w[:, 0] == pytest.approx(-w[:, 1], abs=1e-6)
