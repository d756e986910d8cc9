"""Random cases through build, prestress and run: numbers or one line, in bearable time; the single finds among them."""

from __future__ import annotations

import os
from contextlib import suppress

import numpy as np
import pytest

import tautflex as tf
from regression.case_generator import CABLES, FILM, FRAME
from regression.fuzz_campaign import campaign
from tautflex.cli import main
from tautflex.files import netcdf

PLAIN = {**FILM, "edges": "fixed", "stress_x": 4e3, "stress_y": 4e3}


def outcome_of(first: int, count: int):
    outcome = campaign("runs", first, count, batch=count)
    assert outcome.failures == []
    assert outcome.inputs == count == outcome.accepted + outcome.refused
    assert outcome.accepted > count // 10, "a campaign of cases that are refused anyway would show nothing"
    return outcome


@pytest.mark.slow
def test_sample_of_random_cases(verification_row):
    outcome = outcome_of(0, 200)
    verification_row("fuzzing: cases through build, prestress and run", "one line", str(outcome), "random cases")


@pytest.mark.campaign
def test_many_random_cases():
    outcome_of(1000, 500)


def test_adaptive_run_that_cannot_keep_its_tolerance_ends():
    """A landing stretched the smallest step a little, whose error was too large for ever."""
    slews = [{"kind": "slew", "angle": 0.1, "duration": 0.01}, {"kind": "slew", "angle": -0.1, "duration": 0.01}]
    solver = {"method": "newmark", "adaptive_tolerance": 1e-9, "time_step": 0.0079431, "min_step": 0.0019858}
    case = tf.Case(
        membrane=PLAIN,
        mesh={"divisions": (3, 3)},
        maneuver={"kind": "sequence", "steps": slews},
        solver={**solver, "end_time": 0.04},
    )
    run = tf.run_case(case)
    assert run.stats.beyond_tolerance > 0
    assert np.isfinite(run.data["kinetic_energy"].values).all()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("method", ["central-difference", "energy-conserving"])
def test_run_that_overflows_ends_in_one_line(method):
    case = tf.Case(
        membrane={**PLAIN, "strain": "green-lagrange"},
        mesh={"divisions": (4, 3)},
        maneuver={"kind": "slew", "angle": 1e29, "duration": 0.01, "axis": (1.0, 0.3, 0.2)},
        solver={"method": method, "time_step": 4e-5, "end_time": 4e-4},
    )
    with pytest.raises(tf.TautflexError) as caught:
        tf.run_case(case)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("density", [1e30, 1e-30])
def test_extreme_densities_end_in_modes_or_one_line(density):
    frame = {**FRAME, "density": density}
    counts = {"per_long_edge": 3, "per_short_edge": 3}
    case = tf.Case(
        membrane={**FILM, "density": 1e15}, cables={**CABLES, **counts}, frame=frame, mesh={"divisions": (2, 2)}
    )
    with suppress(tf.TautflexError):
        assert np.isfinite(tf.solve_modes(tf.solve_prestress(tf.build_model(case)), n=3).frequencies).all()


def test_film_whose_nodes_are_all_held():
    case = tf.Case(membrane=PLAIN, mesh={"divisions": (4, 1)})
    with pytest.raises(tf.PrestressError, match="supports that hold all of them; refine mesh"):
        tf.solve_prestress(tf.build_model(case))


def refused(capsys, *arguments: str) -> str:
    assert main(list(arguments)) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


@pytest.mark.slow
def test_special_deep_and_binary_files_are_no_cases(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "deep.toml").write_text(".".join(["a"] * 10_000) + " = 1\n", encoding="utf-8")
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    (tmp_path / "case.toml").write_text("schema = 1\n", encoding="utf-8")
    before = sorted(tmp_path.iterdir())
    for name, words in {
        "pipe.toml": "got a device or pipe",
        "deep.toml": "at most 20 deep in each other",
        "binary.toml": "expected UTF-8 text, got byte 0x80 at offset 128",
        ".": "got a directory",
    }.items():
        assert words in refused(capsys, "run", str(tmp_path / name), "-o", str(tmp_path / "out"))
    deep = ".".join(["a"] * 10_000) + "=1"
    assert "at most 20 deep" in refused(capsys, "check", str(tmp_path / "case.toml"), "--set", deep)
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.slow
def test_a_case_whose_name_is_no_text_keeps_its_run(tmp_path, capsys):
    name = os.fsdecode(os.fsencode(tmp_path) + b"/f\xff.toml")
    small = {"mesh": {"divisions": (3, 2)}, "solver": {"end_time": 0.01}, "output": {"probes": {"A": (0.1, 0.1)}}}
    with open(name, "w", encoding="utf-8") as file:
        file.write(tf.Case(membrane=PLAIN, **small).to_toml())
    assert main(["run", name, "-o", str(tmp_path / "out"), "--json"]) == 0
    assert netcdf.load(tmp_path / "out" / "run.nc").attrs["title"] == "f\udcff"


WRONG = {
    "no mesh": lambda data: data.drop_vars("node_position"),
    "text for nodes": lambda data: data.assign(triangle=(data["triangle"].dims, np.full(data["triangle"].shape, "x"))),
    "nodes that are not there": lambda data: data.assign(triangle=data["triangle"] + 10**6),
    "a number for a mesh": lambda data: data.assign(cable=((), 0.0)),
    "a mesh of other shape": lambda data: data.isel(corner=slice(0, 2)),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_whole_files_with_wrong_content_are_not_exported(wrong, tmp_path, capsys):
    case = tf.Case(membrane=PLAIN, mesh={"divisions": (3, 2)}, solver={"end_time": 0.01}, output={"fields": "all"})
    netcdf.save(WRONG[wrong](tf.run_case(case).data), tmp_path / "run.nc")
    refused(capsys, "export", str(tmp_path / "run.nc"), "--to", "vtu", "-o", str(tmp_path / "out"))
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_frames_far_beyond_their_film_are_told_in_one_line():
    """A frame of 1e30 m around a film of 1e12 m: its nodes were looked for in nanometres and not found."""
    case = tf.Case(
        schema=1,
        membrane={**FILM, "length": 1235727931616.9138},
        mesh={"divisions": [5, 3]},
        cables={**CABLES, "per_long_edge": 6, "per_short_edge": 4},
        frame={**FRAME, "length": 1e30},
    )
    with suppress(tf.TautflexError):
        tf.build_model(case)


def test_table_of_a_maneuver_whose_gaps_no_spline_tells_apart():
    with pytest.raises(tf.InputError, match="times: expected gaps between rows that a spline can tell apart"):
        tf.Tabulated([0.0, 0.01, 1e15], [0.0, 0.3, 0.1])
