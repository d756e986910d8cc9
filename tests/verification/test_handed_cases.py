"""Files that users handed in as they were read wrongly, in `handed`: each at its right value, by command or reader.

Pressure on a film with free edges and slack cables without a loss of energy, handed in with them, have no files: their
values stand in `test_pressure.py` and `test_energy_conserving.py`.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

import tautflex as tf
from regression import mesh_files
from tautflex.cli import main
from tautflex.files.mesh import abaqus, nastran
from verification import decks

FOLDER = Path(__file__).with_name("handed")
CANTILEVER = [8.2236, 8.2236]
# Case and mesh that takes the place of its own, first frequencies as stated with the files [Hz], and how exactly [Hz].
CASES = {
    "a01_set_scope": ("case.toml", "", CANTILEVER, 5e-5),
    "a01_set_scope, all nodes in the part's set": ("case.toml", "mast_all.inp", CANTILEVER, 5e-5),
    "a02_reference_point": ("case.toml", "", CANTILEVER, 5e-5),
    "a04_op_new": ("case.toml", "", CANTILEVER, 5e-5),
    "m01_two_wings": ("case.toml", "", [2.0569] * 4, 5e-5),  # of 2 m: 8.2236 / 4, two elements each
    "n01_conm2": ("run.toml", "", [1.3147], 5e-5),
    "n01_conm2, CMASS": ("run.toml", "mast_cmass.bdf", [1.3147], 5e-5),
    "n02_grdset": ("case.toml", "", [5.7710], 5e-5),
    "n02_grdset, written out": ("case.toml", "beam_written_out.bdf", [5.7710], 5e-5),
    "n03_spc_selection": ("case.toml", "", CANTILEVER, 5e-5),
    "n04_offsets": ("case.toml", "", [3.655], 1e-3),
    "n04_pin_flags": ("case.toml", "", [32.894], 1e-3),
}
MESHES = {
    "a03_transform/mast.inp": [8.2236, 36.062],
    "a03_transform/mast_global.inp": [8.2236, 36.062],
    "a05_constraints/equation.inp": [8.2236, 19.726],
    "a05_constraints/mpc.inp": [8.4336, 8.4336],
    "a05_constraints/rigid_body.inp": [8.438, 8.438],
    "a06_mass/mast.inp": [1.3147],
    "n05_dropped_link/portal_strut_as_cbar.bdf": [5.789],
    "n06_replication/mast.bdf": CANTILEVER,
    "n08_cord_unused/mast.bdf": CANTILEVER,
    "n08_cord_unused/mast_cord_used.bdf": CANTILEVER,
}


@pytest.fixture
def command(capsys):
    """Return a function that runs a command and gives its status and what it prints as JSON."""

    def run(*words):
        status = main([*map(str, words), "--json"])
        return status, json.loads(capsys.readouterr().out or "{}")

    return run


@pytest.mark.parametrize("name", CASES)
def test_cases(name, command, verification_row, monkeypatch):
    case, mesh, wanted, exactly = CASES[name]
    monkeypatch.chdir(FOLDER / name.partition(",")[0])
    status, said = command("modes", case, "-n", 4, *(("--set", f"mesh.file={mesh}") if mesh else ()))
    assert status == 0
    verification_row(
        f"handed case {name}: first frequency [Hz]", wanted[0], said["frequencies"][0], "as stated", exactly
    )
    assert said["frequencies"][: len(wanted)] == pytest.approx(wanted, abs=exactly)


@pytest.mark.parametrize("name", MESHES)
def test_meshes_with_the_sections_of_the_mast(name, verification_row):
    wanted, found = MESHES[name], decks.frequencies(tf.read_mesh(FOLDER / name))
    verification_row(f"handed mesh {name}: last frequency [Hz]", wanted[-1], found[len(wanted) - 1], "as stated", 5e-4)
    assert found[: len(wanted)] == pytest.approx(wanted, abs=5e-4)


def test_what_else_was_stated():
    """Masses, the hinged beam under half the Euler load, the replicated mast, all quads of a film."""
    mast = tf.read_mesh(FOLDER / "n01_conm2" / "mast.bdf")
    assert mast.model(beam=decks.TUBE).mass == pytest.approx(2.77)
    for file in ("beam.bdf", "beam_written_out.bdf"):
        loaded = decks.frequencies(tf.read_mesh(FOLDER / "n02_grdset" / file), beam_axial_force=-71.94)
        assert loaded[0] == pytest.approx(4.0807, abs=2e-4)
    mesh = tf.read_mesh(FOLDER / "n06_replication" / "mast.bdf")
    assert (len(mesh.nodes), len(mesh.beams)) == (11, 10)
    film = tf.read_mesh(FOLDER / "n09_quads" / "film.bdf")
    assert film.model(membrane_stress=(1e6, 1e6, 0.0)).mass == pytest.approx(1530.0 * 1e-4)


def test_a_link_that_is_not_read_is_refused_by_name():
    with pytest.raises(tf.MeshError, match=r"line 31 \('CBEAM3'\): not read here"):
        tf.read_mesh(FOLDER / "n05_dropped_link" / "portal.bdf")


@pytest.mark.skipif(not mesh_files.gmsh_starts(), reason="needs Gmsh, of the extra tautflex[mesh]")
def test_quads_in_no_group():
    mesh = tf.read_mesh(FOLDER / "g02_quads_in_no_group" / "mixed.msh")
    assert mesh.model(membrane=decks.FILM).mass / (1530.0 * 1e-4) == pytest.approx(5.0)


def test_a_film_that_is_held_everywhere(tmp_path, capsys):
    shutil.copy(FOLDER / "c01_all_nodes_held" / "case.toml", tmp_path)
    path = str(tmp_path / "case.toml")
    for words in (["check", path], ["modes", path, "-n", "3"], ["run", path, "-o", str(tmp_path / "out")]):
        assert main(words) == 2
        said = capsys.readouterr().err
        assert "supports that hold all of them; refine mesh.divisions" in said
        assert said.count("\n") == 1


def test_the_page_says_of_every_word_what_becomes_of_it():
    """Cards and keywords of these files stand in one of the tables that docs/meshes.md is made of."""
    for suffix, words in ((".bdf", nastran.WORDS), (".inp", abaqus.WORDS)):
        table = words.markdown()
        for path in FOLDER.rglob(f"*{suffix}"):
            lines = path.read_text(encoding="utf-8").splitlines()
            if suffix == ".bdf":
                begin = lines.index("BEGIN BULK") + 1
                found = {re.split(r"[,\s]", line)[0] for line in lines[begin:] if line[:1].isalpha()}
            else:
                found = {line.split(",")[0].strip("*").upper() for line in lines if re.match(r"\*\w", line)}
            assert found
            for word in found:
                assert f"`{word}`" in table
