"""Case files: the template, round trips, defaults, overrides, and garbage."""

from __future__ import annotations

import math
import pickle
import tomllib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter

import tautflex
from regression.case_generator import FILM
from tautflex import Case, CaseError, load_case
from tautflex.case import (
    TEMPLATES,
    Cables,
    Coupling,
    Damping,
    Frame,
    Maneuver,
    Membrane,
    Mesh,
    Output,
    Prestress,
    Solver,
    parse_case,
    template,
)
from tautflex.case.messages import show

M2_TEMPLATE = template("m2-nearest-node")

FIXED = {**FILM, "edges": "fixed", "stress_x": 4000.0, "stress_y": 5000.0}


@pytest.mark.parametrize("name", ["m2-nearest-node", "m2-paper"])
def test_template_states_the_numbers_of_the_paper(name):
    case = parse_case(template(name))
    # Tables 1 and 4 of the paper
    assert (case.membrane.length, case.membrane.width, case.membrane.thickness) == (2.0, 1.0, 1e-4)
    assert (case.membrane.youngs_modulus, case.membrane.poisson_ratio, case.membrane.density) == (
        3.5e9,
        0.34,
        1530.0,
    )
    assert case.cables is not None
    assert (case.cables.youngs_modulus, case.cables.area, case.cables.density) == (133e9, 3.14e-6, 1440.0)
    assert (case.cables.pretension_x, case.cables.pretension_y) == (0.59, 1.0)
    assert case.frame is not None
    assert (case.frame.length, case.frame.width, case.frame.area) == (2.5, 1.5, 5.24e-4)
    assert (case.frame.inertia_y, case.frame.inertia_z) == (4.81e-7, 2.69e-7)
    assert case.frame.torsion_constant == pytest.approx(case.frame.inertia_y + case.frame.inertia_z)
    assert case.maneuver.rate == pytest.approx(math.pi / 5, rel=1e-15)
    assert case.solver.method == "wilson-theta"
    assert case.output.probes == {"A": (0.7036, 0.4267)}


def test_the_default_template_carries_nothing_that_only_a_table_explains():
    """Cables and film in balance, all of the load, one damping for all kinds; cables per length of edge as printed."""
    case, paper = parse_case(template()), parse_case(template("m2-paper"))
    assert case.prestress.mode == "equilibrium"
    assert case.coupling.inertial_load is True
    assert (case.damping.alpha, case.damping.beta) == (0.001, 0.001)
    assert case.cables.area * case.cables.per_long_edge == pytest.approx(3.14e-6 * 11, rel=0.1)
    assert case.maneuver == paper.maneuver
    assert case.membrane == paper.membrane
    assert paper.coupling.inertial_load == 0.5
    assert paper.damping.beta == {"membrane": 0.001, "cable": 0.0, "frame": 0.001}


@pytest.mark.parametrize("name", TEMPLATES)
def test_template_survives_a_round_trip(name):
    case = parse_case(template(name))
    assert parse_case(case.to_toml()) == case
    assert all(len(line) <= 120 for line in template(name).splitlines())


def test_numbers_by_kind_of_element_are_tables():
    """In a section of their own as well; what is wrong names the kind."""
    inline = parse_case(M2_TEMPLATE, ["damping.beta={ membrane = 1e-3, frame = 2e-3 }"])
    beta, rest = {"membrane": 1e-3, "frame": 2e-3}, {"kind": "rayleigh", "alpha": 0.001}
    assert inline.damping.model_dump() == rest | {"beta": beta}
    values = tomllib.loads(M2_TEMPLATE)
    assert Case(**values | {"damping": {"alpha": 0.001, "beta": beta}}) == inline
    load = parse_case(M2_TEMPLATE, ["coupling.inertial_load={ cable = 0.5 }"]).coupling
    assert load.build() == tautflex.Coupling(inertial_load={"cable": 0.5})
    for setting, words in (
        (
            "damping.beta={ film = 1e-3 }",
            "damping.beta: expected kinds of element, each once, of membrane, cable",
        ),
        ("damping.alpha={ cable = -1.0 }", "damping.alpha.cable: expected a number >= 0, got -1.0"),
        ("damping.beta={ cable = true }", "damping.beta.cable: expected a number, got true"),
        ("coupling.inertial_load=-0.5", "coupling.inertial_load: expected a number >= 0, got -0.5"),
        ("coupling.inertial_load={ cables = 1 }", "coupling.inertial_load: expected kinds of element, each once"),
    ):
        with pytest.raises(CaseError) as caught:
            parse_case(M2_TEMPLATE, [setting])
        assert words in str(caught.value)


def test_case_built_in_code_equals_the_same_file(tmp_path):
    case = Case(schema=1, membrane=FIXED, mesh={"divisions": (4, 2)})
    path = tmp_path / "film.toml"
    path.write_text(case.to_toml(), encoding="utf-8")
    assert load_case(path) == case


def test_case_travels_to_other_processes():
    """Sections of classes are made on the fly; worker processes make them again."""
    case = parse_case(M2_TEMPLATE, ["reduction.count=6", "solver.method=newmark"])
    assert pickle.loads(pickle.dumps(case)) == case


def test_cases_written_by_earlier_versions_are_read():
    """They state the axis of a frame that does not turn, and a damping without kind."""
    maneuver = {"kind": "none", "axis": [1.0, 0.0, 0.0], "origin": [0.0, 0.0, 0.0]}
    case = Case(membrane=FIXED, maneuver=maneuver, damping={"alpha": 0.1, "beta": 0.0})
    assert case == Case(membrane=FIXED, damping={"alpha": 0.1})
    thrust = {"kind": "base-acceleration", "acceleration": 0.1, "origin": [0.0, 0.0, 0.0]}
    assert Case(membrane=FIXED, maneuver=thrust).maneuver.acceleration == 0.1


def test_default_prestress_mode_follows_the_edges():
    assert Case(membrane=FIXED).prestress.mode == "uniform"
    template = tomllib.loads(M2_TEMPLATE)
    del template["prestress"]
    assert Case(**template).prestress.mode == "equilibrium"


def test_case_is_frozen():
    case = Case(membrane=FIXED)
    with pytest.raises(ValueError, match="frozen"):
        case.membrane.thickness = 2e-4  # type: ignore[misc]


def test_integers_are_numbers_but_truth_values_are_not():
    assert Case(membrane={**FIXED, "length": 2}).membrane.length == 2.0
    with pytest.raises(CaseError, match=r"membrane\.length: expected a number, got true"):
        Case(membrane={**FIXED, "length": True})


@pytest.mark.parametrize(
    ("override", "read"),
    [
        ("membrane.thickness=2e-4", lambda case: case.membrane.thickness == 2e-4),
        ("frame.support=short-side", lambda case: case.frame.support == "short-side"),
        ('frame.support="all"', lambda case: case.frame.support == "all"),
        ("mesh.divisions=[20, 10]", lambda case: case.mesh.divisions == (20, 10)),
        ("output.probes.B=[0, 0]", lambda case: set(case.output.probes) == {"A", "B"}),
        ("coupling.euler=false", lambda case: case.coupling.euler is False),
        ("output.fields=all", lambda case: case.output.fields == "all"),
    ],
)
def test_override_changes_one_key(override, read):
    assert read(parse_case(M2_TEMPLATE, [override]))


SLEW = """
schema = 1
[maneuver]
kind = "slew"
angle_deg = 30
duration = 2.0
[membrane]
""" + "\n".join(f"{name} = {value!r}" for name, value in FIXED.items())


def test_keys_in_radians_can_be_given_in_degrees():
    case = parse_case(SLEW)
    assert case.maneuver.angle == pytest.approx(math.pi / 6, rel=1e-15)
    assert parse_case(SLEW, ["maneuver.angle=0.2"]).maneuver.angle == 0.2
    hub = {"mass": 1.0, "inertia": [1.0, 1.0, 1.0], "angular_velocity_deg": [90, 0, -180]}
    turning = Case(**tomllib.loads(SLEW) | {"maneuver": {}, "hub": hub}).hub.angular_velocity
    assert turning == pytest.approx((math.pi / 2, 0.0, -math.pi))
    with pytest.raises(CaseError, match=r"maneuver.angle_deg: expected no value beside angle, got 30; keep one"):
        parse_case(SLEW.replace("duration", "angle = 0.1\nduration"))
    with pytest.raises(CaseError, match=r"maneuver.duration_deg: unknown key"):
        parse_case(SLEW.replace("duration", "duration_deg"))
    with pytest.raises(CaseError, match=r"maneuver.angle: expected a number, got true"):
        parse_case(SLEW.replace("= 30", "= true"))


def test_an_override_of_the_kind_takes_out_the_keys_of_the_other():
    stop = parse_case(SLEW, ["maneuver.rate=0.3", "maneuver.kind=stop"]).maneuver
    assert (stop.kind, stop.rate, stop.duration) == ("stop", 0.3, 2.0)
    with pytest.raises(CaseError, match=r"maneuver.angle: expected no value with kind = 'stop'"):
        parse_case(SLEW, ["maneuver.angle=0.2", "maneuver.rate=0.3", "maneuver.kind=stop"])


def test_an_override_without_value_takes_the_key_out():
    assert parse_case(SLEW, ["maneuver="]).maneuver.kind == "none"
    with pytest.raises(CaseError, match=r"maneuver.duration: missing"):
        parse_case(SLEW, ["maneuver.duration="])
    with pytest.raises(CaseError, match=r"--set: maneuver.duratoin: .* did you mean 'duration'\?"):
        parse_case(SLEW, ["maneuver.duratoin="])


def told(text, *overrides):
    """Keys of the lines that a case is refused with; every line is one problem and names the case."""
    with pytest.raises(CaseError) as caught:
        parse_case(text, overrides)
    assert str(caught.value).split("\n") == list(caught.value.problems)
    return [line.removeprefix("case: ").partition(": ")[0] for line in caught.value.problems]


@pytest.mark.parametrize(
    ("overrides", "keys"),
    [
        (  # keys that do not exist; the missing ones that they stand for are not told
            ["maneuver.duratoin=1", "maneuver.duration=", "solver.time_stp=1", "membrane.foo=1", "fram.x=1"],
            ["fram", "membrane.foo", "maneuver.duratoin", "solver.time_stp"],
        ),
        (  # wrong types, ranges, choices and lengths
            ["membrane.thickness=x", "mesh.divisions=[1,2,3]", "damping.alpha=-1", "solver.method=newmrk"],
            ["membrane.thickness", "mesh.divisions", "damping.alpha", "solver.method"],
        ),
        (["maneuver.duration=-1", "maneuver.angle=x"], ["maneuver.angle", "maneuver.duration"]),  # of one section
        (["maneuver.axis=3", "maneuver.angle_deg=x"], ["maneuver.angle", "maneuver.axis"]),
        (["mesh.file=true", "mesh.divisions=[3,2]"], ["mesh.file"]),  # whether there may be divisions is not known
        (["solver.end_time=-1", "solver.time_step=1"], ["solver.end_time"]),  # their order says nothing then
        (["maneuver.kind=stop", "maneuver.angle=1"], ["maneuver.angle"]),  # rate, which a stop needs, is of no use
        (["hub.mass=-1", "hub.inertia=[1,2,30]", "hub.axes=3"], ["hub.axes", "hub.mass", "hub.inertia"]),
        (["inputs.a.kind=pressur", "inputs.b.kind=pressure"], ["inputs.a.kind", "inputs.b.pressure"]),
        (["output.probes.A=[9,9]", "output.probes.B=[8,8]"], ["output.probes.A", "output.probes.B"]),
        (["membrane.edges=cables", "output.probes.A=[9,9]"], ["cables", "frame", "output.probes.A"]),
        (  # what a misspelt key is meant for is there for the others
            ["solver.adaptive_tolerence=1e-4", "solver.min_step=1e-5", "hubb.mass=-1"],
            ["hubb", "solver.adaptive_tolerence"],
        ),
        (["cables.area=1", "frame.area=1"], ["cables", "frame"]),  # not what those sections lack
        (["schema=", "maneuver.duration=0"], ["schema", "maneuver.duration"]),
        (["schema=2", "maneuver.duration=0"], ["schema"]),  # another format has other keys
    ],
)
def test_all_independent_problems_are_told_at_once(overrides, keys):
    assert told(SLEW, *overrides) == keys


def test_changes_that_cannot_be_made_are_told_together():
    with pytest.raises(CaseError) as caught:
        parse_case(SLEW.replace("angle_deg = 30", ""), ["maneuver:1", "mesh.x.y", "membrane.x=", "damping.alpha=-1"])
    places = ["--set", "--set", "--set", "case"]  # not the missing angle: the first may be meant to state it
    assert [line.partition(":")[0] for line in caught.value.problems] == places


def test_problems_survive_pickling_and_a_place_in_front():
    error = pickle.loads(pickle.dumps(CaseError("a: wrong", "b: wrong").behind("case: ")))
    assert error.problems == ("case: a: wrong", "case: b: wrong")
    assert isinstance(error, CaseError)


def test_later_override_wins():
    case = parse_case(M2_TEMPLATE, ["damping.alpha=1", "damping.alpha=2"])
    assert case.damping.alpha == 2.0


def test_replaced_validates_again():
    case = parse_case(M2_TEMPLATE)
    tuned = case.replaced(cables={"pretension_x": 1.5})
    assert tuned.cables is not None
    assert tuned.cables.pretension_x == 1.5
    assert tuned.cables.pretension_y == 1.0
    with pytest.raises(CaseError, match=r"cables\.pretension_x"):
        case.replaced(cables={"pretension_x": -1.0})


def test_replaced_takes_sections_out():
    case = parse_case(M2_TEMPLATE, ["hub.mass=20", "hub.inertia=[4,5,6]"])
    assert case.replaced(hub=None).hub is None
    assert case.replaced(task=None) == case
    for wrong, words in (({"membrane": None}, "membrane: missing"), ({"hub": 3}, "hub: expected a table")):
        with pytest.raises(CaseError, match=words):
            case.replaced(**wrong)
    with pytest.raises(CaseError, match="nonsense: unknown key"):
        case.replaced(nonsense=None)


def test_file_with_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "bom.toml"
    path.write_bytes(b"\xef\xbb\xbf" + M2_TEMPLATE.encode())
    assert load_case(path) == parse_case(M2_TEMPLATE)


def test_misspelt_required_key_is_named_before_the_missing_one():
    film = {**FIXED, "thicknes": 1e-4}
    del film["thickness"]
    with pytest.raises(CaseError, match=r"membrane\.thicknes: unknown key .* did you mean 'thickness'"):
        Case(membrane=film)


def test_memory_guard_counts_the_history_too(monkeypatch):
    monkeypatch.setattr("tautflex.case.memory.available_bytes", lambda: 10_000_000)
    small = Case(membrane=FIXED, mesh={"divisions": (4, 2)}, output={"probes": {"A": (0, 0)}})
    # 10 000 stored steps of 16 numbers of 8 bytes fit into 10 MB, a hundred times as many do not.
    assert small.output.every == 1
    with pytest.raises(CaseError, match=r"output\.every: expected a history that fits"):
        small.replaced(solver={"time_step": 1e-5})
    assert small.replaced(solver={"time_step": 1e-5}, output={"every": 100}).output.every == 100


def test_every_key_offers_an_example_that_validates():
    """The messages offer these examples as remedies, so they must work."""
    for section in (Membrane, Cables, Frame, Mesh, Prestress, Maneuver, Damping, Coupling, Solver, Output):
        for name, field in section.model_fields.items():
            assert field.description, name
            assert field.examples, name
            TypeAdapter(field.rebuild_annotation()).validate_python(field.examples[0])


def test_values_are_shown_on_one_short_line():
    assert show("a\nb") == r"'a\nb'"
    assert len(show(10**5000)) <= 60
    assert len(show("x" * 1000)) <= 60


def attempt(make):
    """Return the case, or the message of its CaseError, a line for a problem; any other exception fails the test."""
    try:
        return make(), ""
    except CaseError as error:
        if str(error).split("\n") != list(error.problems):
            pytest.fail(f"a problem has several lines: {error.problems}")
        return None, str(error)


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.dates(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3),
    max_leaves=6,
)
keys = st.sampled_from(
    [
        f"{section}.{key}"
        for section, table in tomllib.loads(M2_TEMPLATE).items()
        if isinstance(table, dict)
        for key in table
    ]
)


@given(key=keys, value=anything)
@settings(max_examples=300, deadline=None)
def test_no_value_of_any_key_raises_anything_but_a_one_line_case_error(key, value):
    values = tomllib.loads(M2_TEMPLATE)
    section, name = key.split(".")
    values[section][name] = value
    case, message = attempt(lambda: Case(**values))
    # The message may name another section: a shorter film leaves a probe outside.
    assert bool(message) == (case is None)
    assert case is not None or any(name in message for name in values)
    assert case is None or parse_case(case.to_toml()) == case


@given(content=st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace")))
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_garbage_files_raise_only_case_errors(tmp_path, content):
    path = tmp_path / "garbage.toml"
    path.write_bytes(content)
    with pytest.raises(CaseError) as caught:
        load_case(path)
    assert str(caught.value).split("\n") == list(caught.value.problems)


@given(cut=st.integers(0, len(M2_TEMPLATE)), junk=st.text(max_size=10))
@settings(max_examples=150, deadline=None)
def test_damaged_templates_load_or_raise_case_errors(cut, junk):
    text = M2_TEMPLATE[:cut] + junk + M2_TEMPLATE[cut + len(junk) :]
    case, _ = attempt(lambda: parse_case(text))
    assert case is None or parse_case(case.to_toml()) == case


@given(override=st.text(max_size=30))
@settings(max_examples=200, deadline=None)
def test_garbage_overrides_load_or_raise_case_errors(override):
    case, _ = attempt(lambda: parse_case(M2_TEMPLATE, [override]))
    assert case is None or parse_case(case.to_toml()) == case
