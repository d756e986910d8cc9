"""Maneuvers in case files: every kind, its keys, its words, its tables, its mistakes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tautflex import AtRest, BaseAcceleration, Case, CaseError, Sequence, Slew, SpinUp, Stop, Tabulated, load_case
from tautflex.case import Maneuver, parse_case
from tautflex.case.build import build_maneuver
from tautflex.cli import main
from verification.builders import FILM_CASE

# text of the section, the maneuver it means, how it is described
GOOD = {
    "none": ('kind = "none"', AtRest(), "no maneuver"),
    "stop": ('kind = "stop"\nrate = 0.5\nduration = 0.1', Stop(0.5, 0.1), "stop from 0.5 rad/s in 0.1 s"),
    "spin-up": (
        'kind = "spin-up"\nrate = 2\nduration = 3\nprofile = "linear"\ninitial_rate = 1.0\naxis = [0, 0, 1]',
        SpinUp(2.0, 3.0, "linear", (0.0, 0.0, 1.0), initial_rate=1.0),
        "spin-up from 1 to 2 rad/s in 3 s",
    ),
    "slew": (
        'kind = "slew"\nangle = 0.35\nduration = 2.0\norigin = [0, 0.1, 0]',
        Slew(0.35, 2.0, origin=(0.0, 0.1, 0.0)),
        "versine slew by 0.35 rad (20.1°) in 2 s",
    ),
    "shaped slew": (
        'kind = "slew"\nangle = -0.35\nduration = 2.0\nprofile = "input-shaped"\nfrequency = 1.5\n'
        'damping_ratio = 0.01\nshaper = "ZV"\nbase = "versine"',
        Slew(-0.35, 2.0, "input-shaped", frequency=1.5, damping_ratio=0.01, shaper="ZV", base="versine"),
        "input-shaped slew by -0.35 rad (-20.1°) in 2 s",
    ),
    "table": (
        'kind = "tabulated"\ntimes = [0, 1, 2]\nrates = [0, 0.2, 0]',
        Tabulated([0, 1, 2], [0, 0.2, 0]),
        "tabulated motion (3 rows)",
    ),
    "table of vectors": (
        'kind = "tabulated"\ntimes = [0, 1]\nrates = [[0, 0, 0.1], [0, 0.2, 0]]\n'
        "accelerations = [0, 1]\naxis = [0, 0, 1]",
        Tabulated([0, 1], [[0, 0, 0.1], [0, 0.2, 0]], accelerations=[0, 1], axis=(0.0, 0.0, 1.0)),
        "tabulated motion (2 rows)",
    ),
    "table of attitudes": (
        'kind = "tabulated"\ntimes = [0, 1, 2]\nends = "rest"\n'
        "quaternions = [[1, 0, 0, 0], [0.99, 0.1, 0, 0], [0.95, 0.3, 0, 0]]",
        Tabulated([0, 1, 2], quaternions=[[1, 0, 0, 0], [0.99, 0.1, 0, 0], [0.95, 0.3, 0, 0]], ends="rest"),
        "tabulated motion (3 rows)",
    ),
    "base acceleration": (
        'kind = "base-acceleration"\nacceleration = 0.05\nprofile = "half-sine"\nduration = 0.5\naxis = [0, 0, 2]',
        BaseAcceleration(0.05, 0.5, "half-sine", (0.0, 0.0, 2.0)),
        "half-sine base acceleration of 0.05 m/s^2 for 0.5 s",
    ),
    "thrust": (
        'kind = "base-acceleration"\nacceleration = 0.05',
        BaseAcceleration(0.05),
        "constant base acceleration of 0.05 m/s^2",
    ),
    "sequence": (
        'kind = "sequence"\n[[maneuver.steps]]\nkind = "slew"\nangle = 0.2\nduration = 1.0\nprofile = "bang-bang"\n'
        'hold = 0.5\n[[maneuver.steps]]\nkind = "spin-up"\nrate = 0.4\nduration = 2.0\n'
        '[[maneuver.steps]]\nkind = "stop"\nrate = 0.4\nduration = 1.0',
        Sequence((Slew(0.2, 1.0, "bang-bang"), SpinUp(0.4, 2.0), Stop(0.4, 1.0)), (0.5, 0.0)),
        "bang-bang slew by 0.2 rad (11.5°) in 1 s, then spin-up from 0 to 0.4 rad/s in 2 s, "
        "then stop from 0.4 rad/s in 1 s",
    ),
}


def case_of(section: str) -> Case:
    return parse_case(f"{FILM_CASE}[maneuver]\n{section}\n")


@pytest.mark.parametrize("name", GOOD)
def test_each_kind_means_its_maneuver(name):
    section, expected, words = GOOD[name]
    case = case_of(section)
    built = build_maneuver(case)
    assert repr(built) == repr(expected)
    for one, other in zip(built.segments(), expected.segments(), strict=True):
        assert (one.start, one.end) == (other.start, other.end)
        here, there = one.motion(one.start + 0.1), other.motion(one.start + 0.1)
        np.testing.assert_array_equal(here.angular_velocity, there.angular_velocity)
        np.testing.assert_array_equal(here.origin_acceleration, there.origin_acceleration)
    assert case.maneuver.describe() == words
    assert parse_case(case.to_toml()) == case


STEP = 'kind = "sequence"\n[[maneuver.steps]]\n'
BAD = {
    "unknown kind": ('kind = "loop"', ["maneuver.kind", "'loop'", "'base-acceleration'"]),
    "stop without rate": (
        'kind = "stop"\nduration = 1.0',
        ["maneuver.rate: missing", "before t = 0 [rad/s]", "add it"],
    ),
    "spin-up without rate": ('kind = "spin-up"\nduration = 1.0', ["maneuver.rate: missing", "to reach"]),
    "slew without angle": ('kind = "slew"\nduration = 1.0', ["maneuver.angle: missing", "'slew'", "[rad]"]),
    "slew with rate": (
        'kind = "slew"\nangle = 1.0\nduration = 1.0\nrate = 2.0',
        ["maneuver.rate", "no value with kind = 'slew'", "got 2.0", "remove it or set kind = 'stop'"],
    ),
    "rest with a rate": ('kind = "none"\nrate = 2.0', ["maneuver.rate", "kind = 'none'", "got 2.0", "'stop'"]),
    "rest about an axis": ('kind = "none"\naxis = [0, 1, 0]', ["maneuver.axis", "kind = 'none'", "[0, 1, 0]"]),
    "stop with an angle": ('kind = "stop"\nrate = 1\nduration = 1\nangle = 1', ["maneuver.angle", "set kind = 'slew'"]),
    "origin of a translation": (
        'kind = "base-acceleration"\nacceleration = 1\norigin = [0, 1, 0]',
        ["maneuver.origin", "'base-acceleration'"],
    ),
    "axis without direction": (
        'kind = "slew"\nangle = 1\nduration = 1\naxis = [0, 0, 0]',
        ["maneuver.axis", "non-zero"],
    ),
    "profile of a slew": (
        'kind = "slew"\nangle = 1\nduration = 1\nprofile = "linear"',
        ["maneuver.profile", "'versine', 'bang-bang'", "kind = 'slew'", "got 'linear'"],
    ),
    "profile of a stop": ('kind = "stop"\nrate = 1\nduration = 1\nprofile = "linear"', ["maneuver.profile", "'stop'"]),
    "unknown profile": (
        'kind = "slew"\nangle = 1\nduration = 1\nprofile = "s"',
        ["maneuver.profile", "'versine'", "'s'"],
    ),
    "shaping without a mode": (
        'kind = "slew"\nangle = 1\nduration = 1\nprofile = "input-shaped"',
        ["maneuver.frequency: missing", "[Hz]", "tautflex modes"],
    ),
    "shaper without shaping": (
        'kind = "slew"\nangle = 1\nduration = 1\nshaper = "ZV"',
        ["maneuver.shaper", "profile = 'versine'", "got 'ZV'", "'input-shaped'"],
    ),
    "shaper too long": (
        'kind = "slew"\nangle = 1\nduration = 1\nprofile = "input-shaped"\nfrequency = 0.5',
        ["maneuver.duration", "2 s", "0.5 Hz", "got 1 s"],
    ),
    "pulse without length": (
        'kind = "base-acceleration"\nacceleration = 1\nprofile = "half-sine"',
        ["maneuver.duration: missing", "half-sine"],
    ),
    "cut-off with length": (
        'kind = "base-acceleration"\nacceleration = 1\nduration = 2\nprofile = "cut-off"',
        ["maneuver.duration", "'cut-off'", "got 2"],
    ),
    "no table": ('kind = "tabulated"', ["maneuver.file: missing", "slew.csv"]),
    "times alone": ('kind = "tabulated"\ntimes = [0, 1]', ["maneuver.rates: missing", "quaternions"]),
    "rates alone": ('kind = "tabulated"\nrates = [0, 1]', ["maneuver.file: missing", "times"]),
    "file and numbers": (
        'kind = "tabulated"\nfile = "a.csv"\ntimes = [0, 1]\nrates = [0, 1]',
        ["maneuver.file", "beside times", "a.csv", "keep"],
    ),
    "rows": ('kind = "tabulated"\ntimes = [0, 1]\nrates = [0, 1, 2]', ["maneuver.rates", "2 rows", "got 3"]),
    "rates of text": ('kind = "tabulated"\ntimes = [0, 1]\nrates = ["a", "b"]', ["maneuver.rates", "'a'", "number"]),
    "falling times": ('kind = "tabulated"\ntimes = [0, 2, 1]\nrates = [0, 1, 2]', ["maneuver.times", "1 s after 2 s"]),
    "no such file": ('kind = "tabulated"\nfile = "a.csv"', ["maneuver.file", "'a.csv': no such file", "relative"]),
    "no steps": ('kind = "sequence"', ["maneuver.steps: missing", "[[maneuver.steps]]"]),
    "empty steps": ('kind = "sequence"\nsteps = []', ["maneuver.steps", "at least one"]),
    "steps of a slew": (
        'kind = "slew"\nangle = 1\nduration = 1\n[[maneuver.steps]]\nkind = "stop"\nrate = 1\nduration = 1',
        ["maneuver.steps", "kind = 'slew'", "set kind = 'sequence'"],
    ),
    "sequence with a rate": (
        STEP + 'kind = "slew"\nangle = 1\nduration = 1\nrate = 3',
        ["maneuver.steps.0.rate", "got 3"],
    ),
    "sequence in a sequence": (STEP + 'kind = "sequence"', ["maneuver.steps.0.kind", "'sequence'", "'slew'"]),
    "step without kind": (STEP + "angle = 1", ["maneuver.steps.0.kind: missing", "'slew'"]),
    "negative hold": (STEP + 'kind = "slew"\nangle = 1\nduration = 1\nhold = -1', ["maneuver.steps.0.hold", ">= 0"]),
    "hold at the end": (
        STEP + 'kind = "slew"\nangle = 1\nduration = 1\nhold = 1',
        ["maneuver.steps", "no hold", "got 1"],
    ),
    "hold outside": ('kind = "slew"\nangle = 1\nduration = 1\nhold = 1', ["maneuver.hold", "unknown key"]),
    "jump of the rate": (
        STEP + 'kind = "spin-up"\nrate = 1\nduration = 1\n[[maneuver.steps]]\nkind = "stop"\nrate = 2\nduration = 1',
        ["maneuver.steps", "step 2", "[1.0, 0.0, 0.0] rad/s", "[2.0, 0.0, 0.0]"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_mistakes_are_one_line_that_names_the_key(name):
    section, words = BAD[name]
    with pytest.raises(CaseError) as caught:
        build_maneuver(case_of(section))
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message


KEYS = {key for kind in Maneuver.kinds() for key in Maneuver.of_kind(kind).model_fields} - {"kind"}
numbers = st.integers(-3, 3) | st.floats() | st.sampled_from([1e-320, 1e-200, 1e200, 10**400])
anything = st.recursive(
    numbers | st.booleans() | st.text(max_size=4) | st.sampled_from(["versine", "slew", "ZV", "rest", "nowhere.csv"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["kind", "rate", "hold"]), inner),
    max_leaves=8,
)


@given(
    kind=st.sampled_from(["stop", "spin-up", "slew", "tabulated", "base-acceleration", "sequence"]),
    values=st.dictionaries(st.sampled_from(sorted(KEYS)), anything, max_size=4),
    sensible=st.booleans(),
)
@settings(max_examples=300, deadline=None)
@pytest.mark.slow
def test_no_maneuver_section_raises_anything_but_a_one_line_case_error(kind, values, sensible):
    """Sections of random values, half of them on top of what the kind needs."""
    needed = {"rate": 0.5, "duration": 1.0, "angle": 0.3, "acceleration": 0.1, "times": [0, 1], "rates": [0, 1]}
    wanted = {"tabulated": ("times", "rates")}.get(
        kind, [name for name, key in Maneuver.of_kind(kind).model_fields.items() if key.is_required()]
    )
    base = {name: needed[name] for name in wanted if name in needed} if sensible else {}
    built, told = None, ()
    try:
        built = build_maneuver(Case(**_film(), maneuver={"kind": kind, **base, **values}))
    except CaseError as error:
        told = error.problems
    assert not any("\n" in problem for problem in told)
    assert all("maneuver" in problem for problem in told)
    assert bool(told) == (built is None)
    assert built is None or built.segments()[-1].end == np.inf


TABLE = "# slew about x\n time , rate,note\n0,0,begin\n0.1,0.3,turn\n\n0.1,0.3,again\n0.2,0.0,\n"


def test_a_table_beside_the_case_file_is_found(tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "slew.csv").write_text("\ufeff" + TABLE, encoding="utf-8")
    path = tmp_path / "there" / "case.toml"
    path.write_text(f'{FILM_CASE}[maneuver]\nkind = "tabulated"\nfile = "slew.csv"\n', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    case = load_case("there/case.toml")
    built = build_maneuver(case)
    assert repr(built) == repr(Tabulated([0.0, 0.1, 0.1, 0.2], [0.0, 0.3, 0.3, 0.0]))
    assert built.segments()[1].motion(0.15).angular_velocity[0] == pytest.approx(0.15)
    assert case.maneuver.describe() == "tabulated motion (slew.csv)"
    # An override is typed where the program runs.
    (tmp_path / "other.csv").write_text("time,rate_x,rate_y,rate_z\n0,0,1,0\n1,0,0,2\n", encoding="utf-8")
    other = build_maneuver(load_case("there/case.toml", ["maneuver.file=other.csv"]))
    np.testing.assert_allclose(other.start().angular_velocity, [0.0, 1.0, 0.0])
    steps = f'{FILM_CASE}[maneuver]\nkind = "sequence"\n[[maneuver.steps]]\nkind = "tabulated"\nfile = "slew.csv"\n'
    path.write_text(steps, encoding="utf-8")
    assert len(build_maneuver(load_case(path)).segments()) == 3


def test_every_column_of_a_table_is_read(tmp_path):
    path = tmp_path / "all.csv"
    path.write_text(
        "q_w,q_x,q_y,q_z,acceleration_x,acceleration_y,acceleration_z,time\n1,0,0,0,1,2,3,0\n0.9,0.1,0,0,4,5,6,1\n",
        encoding="utf-8",
    )
    built = build_maneuver(Case(**_film(), maneuver={"kind": "tabulated", "file": str(path)}))
    np.testing.assert_array_equal(built.accelerations, [[1, 2, 3], [4, 5, 6]])
    assert built.quaternions.shape == (2, 4)
    assert built.rates is None


def _film() -> dict:
    return parse_case(FILM_CASE).model_dump(by_alias=True, exclude_none=True, include={"membrane", "mesh"})


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ["column time", "got nothing", "time,rate"]),
        (b"0,0\n1,1\n", ["column time", "got 0, 0"]),
        (b"time,rate\n0,0\n1\n", ["2 cells in row 3", "got 1"]),
        (b"time,rate\n0,0\n1,fast\n", ["row 3, column rate", "'fast'"]),
        (b"time,rate\n0,0\n1,nan\n", ["rates", "finite"]),
        (b"time,speed\n0,0\n1,1\n", ["rates: missing", "quaternions"]),
        (b"time,rate\n", ["times", "at least 2", "got 0"]),
        (b"time,rate\n0,\xff\n", ["UTF-8", "0xff at offset 12"]),
        (b'time,rate\n0,"0\n1,1\n', ["row 2"]),
    ],
)
def test_damaged_tables_are_one_line_errors(tmp_path, content, words):
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    case = Case(**_film(), maneuver={"kind": "tabulated", "file": str(path)})
    with pytest.raises(CaseError) as caught:
        build_maneuver(case)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("maneuver.")
    for word in words:
        assert word in str(caught.value)


def test_a_directory_is_no_table(tmp_path):
    with pytest.raises(CaseError, match=r"maneuver\.file: .*expected a CSV file.*got a directory"):
        build_maneuver(Case(**_film(), maneuver={"kind": "tabulated", "file": str(tmp_path)}))


@pytest.mark.slow
def test_run_and_check_take_every_new_kind(tmp_path, capsys):
    section = GOOD["sequence"][0].replace("duration = 1.0", "duration = 0.1").replace("2.0", "0.05")
    path = tmp_path / "case.toml"
    path.write_text(f"{FILM_CASE}[maneuver]\n{section}\n", encoding="utf-8")
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--json"]) == 0
    capsys.readouterr()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "completed"
    assert summary["probes"]["A"]["amplitude"] > 1e-7
    assert summary["maneuver"].startswith("bang-bang slew by 0.2 rad (11.5°) in 0.1 s, then spin-up")
    path.write_text(f'{FILM_CASE}[maneuver]\nkind = "tabulated"\nfile = "gone.csv"\n', encoding="utf-8")
    assert main(["check", str(path)]) == 2
    assert "no such file" in " ".join(capsys.readouterr().err.split())
