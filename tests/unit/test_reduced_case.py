"""`[reduction]` in a case file."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tautflex import Case, CaseError, load_case
from tautflex.case import template
from tautflex.cli import main

M2_TEMPLATE = template("m2-nearest-node")


@pytest.fixture
def reduced_case(tmp_path):
    path = tmp_path / "m2.toml"
    text = M2_TEMPLATE.replace("# [reduction]", "[reduction]").replace('# directions = ["rx"]', 'directions = ["rx"]')
    path.write_text(text.replace("# count = 24", "count = 6"), encoding="utf-8")
    return path


def test_the_template_shows_a_section_that_works(reduced_case):
    basis = load_case(reduced_case).reduction.build()
    assert (basis.directions, basis.count) == (("rx",), 6)
    assert Case.model_validate(_without(load_case(reduced_case))).reduction is None


def _without(case):
    values = case.model_dump(by_alias=True, exclude_none=True)
    del values["reduction"]
    return values


@pytest.mark.slow
def test_run_from_the_command_line(reduced_case, tmp_path, capsys):
    code = main(["run", str(reduced_case), "-o", str(tmp_path / "out"), "--set", "solver.end_time=0.5", "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert code == 0
    assert summary["status"] == "completed"
    assert "6 natural modes" in summary["reduced_model"]
    assert 0.0 < summary["probes"]["A"]["amplitude"] < 1e-3
    import tautflex as tf

    data = tf.load(tmp_path / "out" / "run.nc")
    assert np.isfinite(data.min_principal_resultant).sum() == data.sizes["check_time"]
    assert "[reduction]" in data.attrs["case"]


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("membrane.law=tension-field", "membrane.law = 'elastic'"),
        ("cables.slack=true", "cables.slack = false"),
        ("solver.adaptive_tolerance=1e-4", "adaptive_tolerance"),
        ("reduction.threshold=0.001", "count = 6"),
        ("reduction.directions=['w']", "directions"),
        ("reduction.count=0", "count"),
    ],
)
def test_contradictions_are_one_line(reduced_case, override, words):
    with pytest.raises(CaseError, match=words):
        load_case(reduced_case, [override])
