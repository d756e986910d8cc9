"""Readers meet damaged and hostile files: only tautflex errors, no crash, no hang, no flood of memory.

Longer campaigns run by hand, see `fuzz_campaign.py`.
"""

from __future__ import annotations

import warnings

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import tautflex as tf
from regression import mesh_files
from regression.fuzz_campaign import PLAIN, TARGETS, attempt, campaign
from tautflex.case import parse_case, template
from tautflex.files.mesh.abaqus import read_abaqus
from tautflex.files.mesh.nastran import read_nastran

M2_TEMPLATE = template("m2-nearest-node")

pytestmark = pytest.mark.campaign
COUNTS = {"case": 150, "abaqus": 150, "nastran": 150, "results": 150, "gmsh": 6}
READERS = {"case": "case reader", "results": "result reader", "gmsh": "Gmsh reader (in its own process)"}
EXPECTED, SOURCE = "only tautflex errors", "mutations of valid files"


@pytest.mark.parametrize("name", COUNTS)
def test_mutations_of_valid_files(name, verification_row):
    if name == "gmsh" and not mesh_files.gmsh_starts():
        pytest.skip("needs Gmsh, of the extra tautflex[mesh]")
    outcome = campaign(name, 0, COUNTS[name], batch=COUNTS[name])
    assert outcome.failures == []
    assert outcome.inputs == COUNTS[name] == outcome.accepted + outcome.refused
    verification_row(f"fuzzing: {READERS.get(name, f'{name.title()} mesh reader')}", EXPECTED, str(outcome), SOURCE)


@pytest.mark.parametrize("name", ["case", "abaqus", "nastran", "results"])
def test_samples_themselves_are_read(name, tmp_path):
    """A mutation campaign over files that are refused anyway would show nothing."""
    target = TARGETS[name]
    first = target.samples()[0]
    assert attempt(target, first, tmp_path / f"sample{target.suffix}")


SCALARS = st.one_of(
    st.none().map(lambda _: "''"),
    st.booleans().map(lambda flag: str(flag).lower()),
    st.integers().map(str),
    st.floats().map(repr),
    st.text(max_size=8).map(lambda text: "'" + "".join(c for c in text if c.isprintable() and c != "'") + "'"),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4).map(lambda items: f"[{', '.join(items)}]")
        | st.dictionaries(st.from_regex(r"[a-z]{1,3}", fullmatch=True), inner, max_size=2).map(
            lambda table: "{ " + ", ".join(f"{key} = {value}" for key, value in table.items()) + " }"
        )
    ),
    max_leaves=6,
)
KEYS = sorted({line.partition("=")[0].strip() for line in M2_TEMPLATE.splitlines() if "=" in line and line[0] != "#"})
SECTIONS = [line.strip("[]") for line in M2_TEMPLATE.splitlines() if line.startswith("[")]


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(changes=st.lists(st.tuples(st.sampled_from(SECTIONS), st.sampled_from(KEYS), VALUES), min_size=1, max_size=4))
def test_any_value_under_any_key_of_a_case(changes):
    overrides = [f"{section}.{key}={value}" for section, key, value in changes]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for text in (M2_TEMPLATE, PLAIN.decode()):
            problems = ()
            try:
                case = parse_case(text, overrides)
            except tf.CaseError as error:
                problems = error.problems
            else:
                assert parse_case(case.to_toml()) == case
            assert not any("\n" in problem for problem in problems)


ABAQUS_LINES = ["*NODE", "*ELEMENT, TYPE=S3", "*ELEMENT, TYPE=T3D2", "*NSET, NSET=a", "*ELSET, ELSET=a, GENERATE"]
NASTRAN_NAMES = ["GRID", "GRID*", "CTRIA3", "CROD", "CBAR", "SPC1", "SPC", "+", "*", "CONROD", "BEGIN BULK", "ENDDATA"]
FIELDS = st.one_of(
    st.integers(-3, 9).map(str), st.sampled_from(["", "a", "THRU", "1.5", "1.-3", "nan"]), st.text(max_size=4)
)
ROWS = st.lists(FIELDS, max_size=9).map(",".join)


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(lines=st.lists(st.sampled_from([*ABAQUS_LINES, "*BOUNDARY", "**", "*PART"]) | ROWS, max_size=12))
def test_any_lines_of_abaqus(lines):
    _only_mesh_errors(read_abaqus, "\n".join(lines))


@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    lines=st.lists(st.tuples(st.sampled_from(NASTRAN_NAMES), ROWS).map(",".join) | st.text(max_size=90), max_size=12)
)
def test_any_cards_of_nastran(lines):
    _only_mesh_errors(read_nastran, "\n".join(lines))


def _only_mesh_errors(reader, text):
    message = ""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            reader(text)
        except tf.MeshError as error:
            message = str(error)
    assert "\n" not in message
