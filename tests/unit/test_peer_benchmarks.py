"""Comparison with other codes: our own side of it, a peer that fails, and the page that it writes."""

from __future__ import annotations

import importlib
import json
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

PEERS = Path(__file__).parents[2] / "benchmarks" / "peers"
NAMES = (
    *("film_problem", "spinup_problem", "hub_problem", "film_files", "programs", "pairs"),
    *("film", "spinup", "table", "figure", "run", "accuracy_for_time"),
)


@pytest.fixture
def peers(monkeypatch):
    """Modules of the comparison by name; they are scripts beside each other, not a package."""
    monkeypatch.syspath_prepend(PEERS)
    yield {name: importlib.import_module(name) for name in NAMES}
    for name in NAMES:
        sys.modules.pop(name, None)


def script(folder: Path, text: str) -> Path:
    path = folder / "peer.py"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.slow
def test_our_program_vibrates_at_the_closed_form(peers):
    """A weak blow on the (1,1) shape: half a period is 1/(2 f11), f11 = 1.43 Hz, up to the mesh's error."""
    step, count = 5e-3, 80
    problem = peers["film_problem"].film_problem((16, 8), step, count, 1e-8, speeds=(3e-4, 0.0))
    result = peers["pairs"].run_once(peers["programs"].FILM[0], problem)
    deflection = result["displacement"][:, 2]
    start = problem["velocity"][int(problem["probe"]), 2]
    assert deflection[1] == pytest.approx(start * step, rel=3e-3)
    after = int(np.flatnonzero(deflection[1:] < 0.0)[0])
    crossing = step * (after + deflection[after] / (deflection[after] - deflection[after + 1]))
    frequency = 0.5 * np.sqrt((1e4 / 4.0 + 1e4) / 1530.0)
    assert crossing == pytest.approx(0.5 / frequency, rel=0.02)
    assert result["seconds"] > 0.0
    assert result["clock"][-1] == pytest.approx([count, float(result["seconds"])], rel=0.2)


@pytest.mark.slow
def test_our_beam_lags_behind_its_hub(peers):
    """Quasi-static at first: the tip's lag is 11 rho A L^5 alpha/(120 EI) under a slow angular acceleration alpha."""
    problem = peers["spinup_problem"].spinup_problem(4, 0.02, end=2.0)
    result = peers["pairs"].run_once(peers["programs"].SPINUP[0], problem)
    assert len(result["time"]) == 101
    acceleration = 6.0 / 15.0 * (1.0 - np.cos(2.0 * np.pi * 2.0 / 15.0))
    assert result["lag"][-1] == pytest.approx(-11.0 * 1.2 * 1e5 * acceleration / (120.0 * 1.4e4), rel=0.2)


def test_a_peer_that_fails_is_left_out(peers, tmp_path):
    """The copy of ourselves is compared; the program that fails is named with its last line."""
    program, said = peers["programs"].Program, []
    works = "import sys, numpy as np; np.savez(sys.argv[2], seconds=float(sys.argv[3]), details='{}')"
    ours = program("ours", Path(sys.executable), str(script(tmp_path, works)), ("2.0",))
    slow = program("slow", Path(sys.executable), ours.script, ("6.0",))
    broken = program("broken", Path(sys.executable), ours.script, ("no number",))
    measured = peers["pairs"].compare(ours, (broken, slow), {"nodes": np.zeros(3)}, 2, said.append)
    assert [entry.name for entry in measured] == ["ours", "slow"]
    assert measured[1].ratios == [3.0, 3.0]
    assert sum("broken" in line and "no number" in line for line in said) == 1


def test_what_is_not_installed_is_said_in_one_line(peers, tmp_path):
    program = peers["programs"].Program
    nowhere = program("A", tmp_path / "python", "a.py", remedy="install it")
    empty = program("B", Path(sys.executable), "b.py", needs="no_such_module", remedy="install it too")
    assert nowhere.missing().endswith("install it")
    assert "cannot import no_such_module; install it too" in empty.missing()
    assert peers["programs"].FILM[0].missing() is None


MEASURED = {
    "date": "2026-01-02",
    "command": "run --only size",
    "machine": {"processor": "P", "cores": 2, "system": "S", "python": "3"},
}


def film_results(ratio: float, difference: float) -> dict:
    row = {
        "version": "1",
        "solver": "LU",
        "milliseconds_per_step": 2.0,
        "ratio": 1.0,
        "ratios": [],
        "iterations_per_step": 3.0,
        "factorizations_per_step": 0.5,
        "set_up_seconds": 1.0,
        "error": 1e-7,
        "difference_from_ours": 0.0,
    }
    kratos = row | {"program": "Kratos", "ratio": ratio, "ratios": [ratio], "difference_from_ours": difference}
    return {
        "missing": ["Exudyn: not there"],
        "film": {
            "divisions": [40, 20],
            "element": "triangle3",
            "speed": 0.15,
            "unknowns": 2223,
            "step": 1e-3,
            "count": 2000,
            "tolerance": 1e-5,
            "largest_deflection": 4e-3,
            "first_linear_frequency": 1.4,
            "mean_frequency": 5.0,
            "rows": [row | {"program": "tautflex"}, kratos],
            **MEASURED,
        },
    }


@pytest.mark.parametrize(
    ("ratio", "difference", "verdict"),
    [
        (60.0, 1e-7, "reached (60), answers equal"),
        (40.0, 1e-7, "missed (40), answers equal"),
        (60.0, 1e-3, "reached (60), answers NOT equal"),
    ],
)
def test_the_page_says_what_was_reached(peers, ratio, difference, verdict):
    text = peers["table"].page(film_results(ratio, difference))
    assert f"Target 50 times against Kratos: {verdict}" in text
    assert "- Exudyn: not there" in text
    assert "| program | version | ms per step | times ours | iterations | factorizations | error | from ours |" in text
    assert f"| Kratos | 1 | 2 | **{ratio:.3g}** ({ratio:.3g} to {ratio:.3g}) |" in text


def test_size_study_counts_the_steps_after_the_first_two(peers, tmp_path):
    """Steps of 1, 1, 3, 3 s: the cost is 3 s; a program that fails is left out of the larger mesh."""
    works = (
        "import sys, numpy as np; p = np.load(sys.argv[1]); assert len(p['nodes']) < 40, 'too large'\n"
        "np.savez(sys.argv[2], clock=[[0, 0], [1, 1], [2, 2], [3, 5], [4, 8]], details='{}')"
    )
    said = []
    program = peers["programs"].Program("P", Path(sys.executable), str(script(tmp_path, works)))
    study = peers["film"].size_study((program,), {(4, 4): 4, (8, 8): 4, (9, 9): 4}, 60.0, said.append)
    assert [row["milliseconds_per_step"] for row in study["rows"]] == [3000.0]
    assert study["rows"][0]["unknowns"] == 27
    assert sum("too large" in line for line in said) == 1
    results = film_results(60.0, 1e-7) | {"size": study | MEASURED}
    text = peers["run"].write(results, tmp_path / "page")
    assert "| 4 x 4 | 27 | 4 | 3e+03 |" in text
    assert "Measured on 2026-01-02 by `run --only size` on P, 2 cores, S, Python 3." in text
    assert (tmp_path / "page" / "benchmarks.md").read_text(encoding="utf-8") == text
    assert json.loads((tmp_path / "page" / "benchmarks.json").read_text(encoding="utf-8")) == results
    assert (tmp_path / "page" / "figures" / "cost_against_size.png").stat().st_size > 1000


def test_nodes_are_found_by_their_places(peers):
    """Corners of quadratic triangles keep their places; points in another order get the nodes' numbers."""
    problem = peers["film_problem"].film_problem((4, 2), 1e-3, 1, 1e-5, "triangle6")
    points, triangles = peers["film_files"].corners(problem)
    assert len(points) == 5 * 3
    np.testing.assert_allclose(points[triangles], problem["nodes"][problem["triangles"][:, :3], :2])
    nodes = problem["nodes"][:, :2]
    shuffled = np.random.default_rng(0).permutation(len(nodes))
    place = peers["film_files"].matched(nodes[shuffled], nodes)
    np.testing.assert_array_equal(shuffled[place], np.arange(len(nodes)))
    with pytest.raises(RuntimeError, match="not matched"):
        peers["film_files"].matched(nodes + 0.01, nodes)


def test_beams_are_paired_at_the_error_of_the_peer(peers, monkeypatch):
    """Ours errs by the square of 1/elements and costs elements/step; the peer is as accurate with half the elements."""
    monkeypatch.setattr(peers["spinup"], "OTHER_STEPS", (0.1,))

    def once(program, problem, _timeout):
        refined = int(program.options[0]) * problem["elements"]
        time = np.linspace(0.0, 1.0, 5)
        lag, seconds = -np.sin(time) * (1.0 + 1.0 / refined**2), problem["elements"] / problem["step"]
        details = {"version": "1", "element": "beam"}
        return {"time": time, "lag": lag, "extension": 0.0 * time, "seconds": seconds, "details": details}

    monkeypatch.setattr(peers["pairs"], "run_once", once)
    ours, peer = (
        peers["programs"].Program(name, Path(sys.executable), f"{name}.py", (finer,))
        for name, finer in (("ours", "1"), ("peer", "2"))
    )

    def build(elements: int, step: float) -> dict:
        return {"elements": np.array(elements), "step": np.array(step)}

    found = peers["spinup"].compare_beams(
        (ours, peer), build, 1, [].append, elements=(4, 8), steps=(0.02,), finest=(1000, 0.02)
    )
    errors = {(row["program"], row["elements"]): row["error"] for row in found["rows"]}
    assert errors["ours", 8] == pytest.approx(1 / 64, rel=0.01) == pytest.approx(errors["peer", 4], rel=0.02)
    first, second = found["equal"]
    # The peer's 4 elements cost 4/0.02 and err like our 8, of which those at the largest step are cheapest: 8/0.1.
    assert (first["ours"]["elements"], first["ours"]["step"], first["ratio"]) == (8, 0.1, 2.5)
    assert second["ours"] is None  # the peer's eight err as our sixteen would
    page = peers["table"].page({"spinup": found | MEASURED})
    assert "| peer | 4 | 0.02 | 0.0156 | 200 | 8 | 0.1 | 0.0156 | 80 | **2.5** (2.5 to 2.5) |" in page
    assert "| peer | 8 | 0.02 | 0.00391 | 400 | - | - | - | - | - |" in page


def test_search_stops_beyond_the_target_and_keeps_the_front(peers, tmp_path):
    """Error 1/foretold: settings are tried up to three times the cost of the first within 1 %."""
    module = peers["accuracy_for_time"]
    exact = module.Setting("tautflex", "triangle6", (60, 30), "newmark", 2.5e-4)
    first = sorted(setting.foretold for setting in module.settings(False))[100]
    tried = []

    def runs(setting):
        tried.append(setting)
        off = 0.0 if setting == exact else 0.01 * first / setting.foretold
        return {"seconds": setting.foretold, "record": (np.ones(9) * (1.0 + off)).tolist()}

    rows = module.search(runs, exact, np.inf, False)
    for program in ("tautflex", "DOLFINx, factors kept"):
        reached = min(row["seconds"] for row in rows if row["program"] == program and row["error"] <= 0.01)
        limit = max(setting.foretold for setting in tried if setting.program == program and setting != exact)
        assert reached < limit <= 3.0 * reached
    # Equal costs err equally: of each cost all stay, or one; what is dearer and worse never does.
    best = [row for row in rows if row["program"] == "tautflex" and row["best"]]
    assert all(a["error"] >= b["error"] for a, b in pairwise(best))
    file = peers["figure"].accuracy_figure(rows, 0.01, tmp_path / "figure.png")
    assert file.stat().st_size > 1000


def test_runs_go_on_where_they_stopped(peers, tmp_path, monkeypatch):
    """A run is written down when it is done, a failure with its reason, and neither is run again."""
    module, path = peers["accuracy_for_time"], tmp_path / "kept.json"
    ours = module.Setting("tautflex", "triangle3", (2, 2), "newmark", 2e-3)
    calls = []

    def once(program, problem):
        calls.append(program.options)
        if "wilson" in program.options:
            raise peers["programs"].ProgramFailedError("no convergence")
        return {"seconds": 1.5, "displacement": np.arange(3003.0).reshape(1001, 3)}

    monkeypatch.setattr(module, "run_once", once)
    for _ in range(2):
        runs = module.Runs(path, False)
        assert runs(ours)["record"][:2] == [2.0, 8.0]  # every second step is on the grid of 4 ms
        assert runs(module.replace(ours, method="wilson"))["why"] == "no convergence"
    assert calls == [("newmark",), ("wilson",)]
