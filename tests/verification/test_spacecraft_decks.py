"""One spacecraft from two formats: mass, first moments and inertia as stated, rigid motions, the same frequencies."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main
from verification import spacecraft

TAUT = {
    **{kind: {"strain": "green-lagrange"} for kind in ("membrane", "cable", "beam")},
    "cable_tension": 1.0,
    "prestress_mode": "equilibrium",
}
CASE = """schema = 1
[mesh]
file = "{name}.bdf"
unit_length = 0.001
unit_mass = 1000.0
[membrane]
strain = "green-lagrange"
[cables]
pretension_x = 1.0
pretension_y = 1.0
[prestress]
mode = "equilibrium"
"""


@pytest.fixture(scope="module")
def states(tmp_path_factory):
    """Prestressed free spacecraft of the Nastran and of the Abaqus deck."""
    folder = tmp_path_factory.mktemp("spacecraft")
    paths = (spacecraft.nastran(folder, held=False), spacecraft.abaqus(folder))
    meshes = [tf.read_mesh(path, unit_length=1e-3, unit_mass=1e3) for path in paths]
    return [tf.solve_prestress(mesh.model(**TAUT)) for mesh in meshes]


@pytest.mark.parametrize("format", [0, 1], ids=["Nastran", "Abaqus"])
def test_mass_and_inertia_are_the_decks(format, states, verification_row):
    state = states[format]
    assert state.warnings == ()
    motions = state.model.rigid_motions[state.model.free_dofs]
    found = motions.T @ state.system.matrix(state.system.inertia.mass_entries) @ motions
    mass, (x, y, z), inertia = spacecraft.stated()
    assert state.model.mass == pytest.approx(mass, rel=1e-12)
    np.testing.assert_allclose(found[:3, :3], mass * np.eye(3), atol=1e-9 * mass)
    np.testing.assert_allclose(found[:3, 3:], [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found[3:, 3:], inertia, atol=1e-9 * inertia.max())
    frequencies = tf.solve_modes(state, n=7).frequencies
    assert np.abs(frequencies[:6]).max() < 1e-3 < 2.0 < frequencies[6]
    name = ("Nastran", "Abaqus")[format]
    verification_row(
        f"spacecraft from a {name} deck: moment of inertia [kg m^2]", inertia[0, 0], found[3, 3], "by hand"
    )
    verification_row("... its six rigid modes [Hz]", 0.0, f"{np.abs(frequencies[:6]).max():.1e}", "free")


def test_both_formats_are_one_spacecraft(states):
    found = [tf.solve_modes(state, n=12).frequencies[6:] for state in states]
    assert found[1] == pytest.approx(found[0], rel=1e-5)


@pytest.mark.slow
def test_the_case_control_holds_the_hub_or_not(states, tmp_path, capsys):
    """From the command line: the free deck's modes, and the held deck's on the hub that its masses make."""
    wanted = tf.solve_modes(states[0], n=9).frequencies[6:]
    hub = "[hub]\nmass = 1e-6\ninertia = [1e-6, 1e-6, 1e-6]\n"
    found = {}
    for name, extra in (("free", ""), ("held", hub)):
        spacecraft.nastran(tmp_path, held=name == "held")
        (tmp_path / f"{name}.toml").write_text(CASE.format(name=name) + extra, encoding="utf-8")
        assert main(["check", str(tmp_path / f"{name}.toml"), "--json"]) == 0
        capsys.readouterr()
        assert main(["modes", str(tmp_path / f"{name}.toml"), "-n", "9", "--json"]) == 0
        found[name] = json.loads(capsys.readouterr().out)
    assert found["free"]["frequencies"][6:] == pytest.approx(wanted, rel=1e-6)
    assert found["held"]["on_free_hub"][:3] == pytest.approx(wanted, rel=1e-4)
