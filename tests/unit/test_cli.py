"""Commands that succeed, or fail honestly: JSON keys, exit codes, files, interrupted and failed runs."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from tautflex import load_case
from tautflex.cli import main
from tautflex.cli.options import flowing
from tautflex.cli.runs.run import default_directory
from tautflex.files import netcdf

# A square film under equal stress has f_mn = sqrt(m^2 + n^2)/(2 a) sqrt(stress/density). Rotation about x
# excites shapes that are antisymmetric in y, first of all (1,2).
FILM = """
schema = 1
[membrane]
length = 1.0
width = 1.0
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1500.0
edges = "fixed"
stress_x = 15000.0
stress_y = 15000.0
[mesh]
divisions = [8, 8]
[maneuver]
kind = "stop"
rate = 0.01
duration = 0.1
[solver]
time_step = 0.01
end_time = 2.0
[output]
probes = { A = [0.0, 0.25] }
fields = [0.0, 0.1]
"""
F11, F12 = (math.sqrt(waves) / 2.0 * math.sqrt(15000.0 / 1500.0) for waves in (2.0, 5.0))


@pytest.fixture
def film(tmp_path, monkeypatch):
    """The film's case file, in an empty working directory."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "film.toml"
    path.write_text(FILM, encoding="utf-8")
    return path


@pytest.fixture
def answer(capsys):
    """Return a function that runs a command with --json and returns its exit code and its one object."""

    def run(*arguments):
        capsys.readouterr()
        code = main([*map(str, arguments), "--json"])
        captured = capsys.readouterr()
        assert captured.err == ""
        return code, json.loads(captured.out)

    return run


def test_package_runs_as_a_module():
    done = subprocess.run([sys.executable, "-m", "tautflex", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == tf.__version__


def test_check_counts_nodes_and_weighs(film, answer):
    code, found = answer("check", film)
    assert code == 0
    assert found["ok"] is True
    assert found["nodes"] == 81
    assert (found["dofs"], found["unknowns"]) == (3 * 81, 3 * 49)
    assert found["mass"] == pytest.approx(1500.0 * 1e-4, rel=1e-12)  # density x thickness x area
    np.testing.assert_allclose(found["mass_center"], np.zeros(3), atol=1e-12)
    np.testing.assert_allclose(found["inertia"], found["mass"] / 12.0 * np.diag([1.0, 1.0, 2.0]), atol=1e-12)
    assert found["warnings"] == []


def test_modes_of_the_square_film(film, answer):
    code, found = answer("modes", film, "-n", "3", "-o", "figures")
    assert code == 0
    assert found["frequencies"][0] == pytest.approx(F11, rel=0.03)  # coarse mesh
    assert found["labels"][0] == [1, 1]
    assert len(found["frequencies"]) == len(found["labels"]) == 3
    assert found["prestress"]["min_principal_resultant"] == pytest.approx(15000.0 * 1e-4, rel=1e-12)
    for path in found["files"].values():
        assert (film.parent / path).stat().st_size > 1000


@pytest.mark.slow
def test_run_writes_what_it_says(film, answer):
    code, found = answer("run", film, "-o", "out", "--set", "damping.alpha=0.1")
    assert code == 0
    assert found["status"] == "completed"
    assert found["steps"] >= 200
    assert found["back_substitutions"] >= found["steps"]
    assert found["factorizations"] >= 1
    assert set(found["probes"]["A"]) >= {"amplitude", "dominant_frequency", "bin_width"}
    assert found["probes"]["A"]["dominant_frequency"] == pytest.approx(F12, abs=0.2)  # half a bin
    assert found["probes"]["A"]["amplitude"] > 0.0
    assert found["probes"]["A"]["bin_width"] == pytest.approx(1 / 2.56)  # 201 samples padded to 256 of 0.01 s
    of_film = tf.surface(netcdf.load(film.parent / "out" / "run.nc"))
    after = of_film.sel(time=slice(tf.maneuver_end(netcdf.load(film.parent / "out" / "run.nc")), None))
    assert set(found["surface"]) == {"rms", "rms_max", "tilt", "settling_time"}
    assert found["surface"]["rms"] == float(of_film.rms[-1])
    assert found["surface"]["rms_max"] == float(after.rms.max()) > found["surface"]["rms"]
    assert found["surface"]["tilt"] == [float(of_film.tilt_x[-1]), float(of_film.tilt_y[-1])]
    assert json.loads((film.parent / "out" / "summary.json").read_text(encoding="utf-8")) == found
    assert {"run", "summary"} < set(found["files"])
    for path in found["files"].values():
        assert (film.parent / path).is_file()
    data = netcdf.load(film.parent / "out" / "run.nc")
    assert data.sizes["time"] == 201
    assert data.attrs["status"] == "completed"
    stored = film.parent / "stored.toml"
    stored.write_text(data.attrs["case"], encoding="utf-8")
    assert load_case(stored) == load_case(film, ["damping.alpha=0.1"])


@pytest.mark.slow
def test_interrupted_run_is_kept_and_labelled(film, answer, monkeypatch):
    @contextmanager
    def impatient():
        def progress(fraction, message):
            if 0.3 < fraction < 1.0:
                raise KeyboardInterrupt

        yield progress

    monkeypatch.setattr("tautflex.cli.runs.run.progress_bar", impatient)
    code, found = answer("run", film, "-o", "out")
    assert code == 130
    assert found["status"] == "interrupted"
    data = netcdf.load(film.parent / "out" / "run.nc")
    assert data.attrs["status"] == "interrupted"
    assert 0.5 < float(data.time[-1]) < 2.0


@pytest.mark.slow
def test_run_that_does_not_converge_is_kept_and_exits_with_1(film, answer):
    impossible = [
        "maneuver.rate=30.0",
        "solver.method=energy-conserving",
        "solver.time_step=0.1",
        "solver.max_halvings=0",
    ]
    code, found = answer("run", film, "-o", "out", *(part for key in impossible for part in ("--set", key)))
    assert code == 1
    assert found["status"] == "not-converged"
    assert netcdf.load(film.parent / "out" / "run.nc").attrs["status"] == "not-converged"


@pytest.mark.slow
def test_run_without_motion_has_no_frequency(film, answer):
    still = ["--set", 'maneuver={kind="none"}', "--set", "solver.end_time=0.2"]
    code, found = answer("run", film, "-o", "out", *still)
    assert code == 0
    assert found["probes"]["A"]["amplitude"] == 0.0
    assert found["probes"]["A"]["dominant_frequency"] is None


def test_tune_hits_the_frequency_and_writes_the_case(film, answer):
    assert main(["init", "m2.toml", "--template", "m2-nearest-node"]) == 0
    code, found = answer("tune", "m2.toml", "--frequency", "2.0", "-o", "tuned.toml")
    assert code == 0
    assert found["frequencies"][0] == pytest.approx(2.0, abs=1e-4)
    assert found["pretension_x"] / found["pretension_y"] == pytest.approx(0.59, rel=1e-9)
    code, again = answer("modes", "tuned.toml")
    assert code == 0
    assert again["frequencies"] == pytest.approx(found["frequencies"], rel=1e-6)
    before, after = Path("m2.toml").read_text().splitlines(), Path("tuned.toml").read_text().splitlines()
    changed = [one for one, other in zip(before, after, strict=True) if one != other]
    assert [line.split()[0] for line in changed] == ["pretension_x", "pretension_y"]


def test_a_tuned_case_elsewhere_names_its_mesh_from_there(film, answer):
    assert main(["init", "sail.toml", "--template", "sail"]) == 0
    Path("other").mkdir()
    changes = ["--set", "maneuver.kind=none", "--set", "damping.alpha=0.5"]
    assert answer("tune", "sail.toml", "--frequency", "1.0", "-o", "other/tuned.toml", *changes)[0] == 0
    case = load_case("other/tuned.toml")
    assert (Path(case.mesh.file).resolve(), case.maneuver.kind, case.damping.alpha) == (
        Path("sail.inp").resolve(),
        "none",
        0.5,
    )


def test_init_run_line_works_as_printed(film, capsys):
    assert main(["init", "m2.toml"]) == 0
    assert "tautflex run m2.toml" in capsys.readouterr().out


@pytest.mark.slow
def test_cards_name_the_results(film, capsys):
    assert main(["run", "film.toml"]) == 0
    card = capsys.readouterr().out
    for words in ("completed", "probe A", "natural frequencies", "run.nc"):
        assert words in card
    assert main(["modes", "film.toml", "-n", "2"]) == 0
    assert "(1,1)" in capsys.readouterr().out
    assert main(["check", "film.toml", "--set", "output.probe_reading=nearest-node"]) == 0
    assert "is valid" in capsys.readouterr().out


def test_default_directory_is_named_like_the_case_in_the_current_folder(tmp_path):
    assert default_directory(tmp_path / "m2.toml") == Path("m2")
    assert default_directory(tmp_path / "m2") == Path("m2-run")


def test_a_paragraph_of_help_is_one_line_that_the_terminal_wraps():
    told = flowing("First.\n\n    Second, which goes\n    on.\n\n    Examples:\n\n    a").split("\n\n")
    assert told == ["First.", "Second, which goes on.", "Examples:", "a"]


def test_help_does_not_load_the_numerics():
    """Start-up stays fast because none of the heavy libraries are imported for `--help`."""
    code = "import sys; from tautflex.cli import main; main(['--help']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split("\n")[-2].split())
    assert "tautflex.cli.runs.run" in loaded
    # Of xarray there is a place-holder; what it is made of comes with its first use.
    assert loaded.isdisjoint({"numba", "numpy", "scipy", "matplotlib", "pandas", "pydantic"})


@pytest.mark.slow
def test_a_refused_case_waits_for_neither_datasets_nor_figures():
    code = "import sys, tautflex.case; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert {"xarray", "pandas", "matplotlib", "scipy.interpolate"}.isdisjoint(loaded)


def test_an_interrupt_that_was_met_inside_of_exec_leaves_the_exit_code(tmp_path):
    """Python otherwise kills itself by SIGINT in the end, whatever the code is."""
    text = """
import tautflex.cli
def main():
    try:
        exec("raise KeyboardInterrupt")
    except KeyboardInterrupt:
        return 143
tautflex.cli.main = main
"""
    (tmp_path / "sitecustomize.py").write_text(text, encoding="utf-8")
    places = os.pathsep.join([str(tmp_path), str(Path(tf.__file__).parents[1])])
    done = subprocess.run([sys.executable, "-m", "tautflex"], env=os.environ | {"PYTHONPATH": places}, check=False)
    assert done.returncode == 143
