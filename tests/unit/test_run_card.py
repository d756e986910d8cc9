"""What `tautflex run` and `control` print of a run: tolerances beside what they decide, no rounding errors."""

from pathlib import Path

import pytest

from tautflex.case.sections.dynamic import Output
from tautflex.cli.cards import list_files, show_run

SUMMARY = {
    "status": "completed",
    "message": "The run reached its end time.",
    "steps": 10,
    "back_substitutions": 12,
    "seconds": 0.1,
    "factorizations": 1,
    "natural_frequencies": [1.0, 2.0],
    "probes": {},
    "surface": {"rms": 1e-6, "rms_max": 3e-5, "tilt": [-2e-19, 5e-7], "settling_time": 0.5},
    "time_error": None,
    "settling_time": {"attitude": None, "surface": 0.5},
    "energy_by_source": {"wheel": 1.0},
    "energy_balance": {"damping": 0.0, "method": 0.0, "kinetic": 0.0, "strain": 0.0},
    "maneuver": "slew",
    "warnings": [],
    "files": {},
}


@pytest.fixture
def told(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    show_run(Path("slew.toml"), SUMMARY, Output(surface_tolerance=4e-5, attitude_tolerance=0.002))
    return capsys.readouterr().out


def test_what_settles_is_told_with_its_tolerance(told):
    assert "settled to 40 µm after 0.5 s" in told
    assert "attitude not settled (to 0.002 rad), surface 0.5 s (to 40 µm)" in told


def test_rounding_errors_of_a_tilt_are_zero(told):
    assert " 0 µrad about x and 0.5 µrad about y" in told


def test_files_of_this_folder_are_told_by_their_names(capsys):
    list_files({"policy": "policy.npz"})
    assert capsys.readouterr().out == "Wrote policy.npz.\n"
