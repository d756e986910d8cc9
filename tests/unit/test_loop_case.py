"""Closed loops from a case file: sections, messages, and the commands control, authority and check."""

from __future__ import annotations

import json
import pickle
import re

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from tautflex import CaseError, InputError, plot
from tautflex.case import parse_case, template
from tautflex.case.build import build_state
from tautflex.case.loop import build_law, build_plant, check_loop
from tautflex.cli import main
from verification.builders import FILM_CASE

SLEW = template("control")
TENSION = """
[actuators.tension]
kind = "tension-group"
cables = "y"
limit = 0.3
lag = 0.02
"""
# A film that a force damps; its motion is prescribed.
HELD = f"""{FILM_CASE}
[maneuver]
kind = "stop"
rate = 0.2
duration = 0.1
[actuators.push]
kind = "nodal-force"
near = [0.25, 0.2]
direction = [0.0, 0.0, 1.0]
limit = 1e-3
[sensors.film]
kind = "velocity"
points = [0.25, 0.2]
[sensors.place]
kind = "displacement"
points = [0.25, 0.2]
[controller]
kind = "positive-position-feedback"
gain = 1.0
frequency = 8.0
measurement = "place"
command = "push"
"""


@pytest.fixture(scope="module")
def slew(tmp_path_factory):
    """The template of a closed loop, run through the command line: its file, directory and JSON."""
    folder = tmp_path_factory.mktemp("slew")
    path = folder / "slew.toml"
    assert main(["init", str(path), "--template", "control"]) == 0
    assert main(["check", str(path)]) == 0
    return path, folder / "out"


@pytest.fixture(scope="module")
def small():
    return parse_case(HELD)


@pytest.mark.slow
def test_the_template_through_the_command_line(slew, capsys):
    """Written, checked, run: the hub arrives, the film is quiet, and files and keys are there."""
    path, out = slew
    capsys.readouterr()
    assert main(["control", str(path), "-o", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "completed"
    assert found["warnings"] == []
    assert set(found["settling_time"]) == {"attitude", "surface"}
    assert 0.0 < found["settling_time"]["attitude"] < 0.5
    assert 0.0 < found["settling_time"]["surface"] < 0.5
    assert set(found["energy_by_source"]) == {"torque"}
    files = found["files"]
    assert {"run", "summary", "loop", "modes", "surface", "time_history", "spectrum"} <= set(files)
    assert all((out / name).stat().st_size > 1000 for name in ("run.nc", "loop.png", "summary.json"))
    assert json.loads((out / "summary.json").read_text()) == found
    data = tf.load(out / "run.nc")
    final = 2.0 * np.arcsin(np.linalg.norm(data["attitude"].values[-1, 1:]))
    assert final == pytest.approx(0.5, abs=1e-5)
    assert data["attitude_error"].values[-1] < 1e-5
    # from rest to rest: what wheels put in, the damping took out
    assert found["energy_by_source"]["torque"] == pytest.approx(found["energy_balance"]["loads"], rel=1e-9)
    labels = [axes.get_ylabel() for axes in plot.plot_loop(data).axes]
    assert labels == ["attitude [rad]", "rate [rad/s]", "error [rad]", "command [N m]", "film rms [mm]", "work [J]"]
    # results that are there stay
    assert main(["control", str(path), "-o", str(out)]) == 2
    assert "add --force" in capsys.readouterr().err


def test_one_way_to_a_loop(small):
    """In Python by hand, by one call, and as the command does: to the bit."""
    state = build_state(small)
    plant = build_plant(small, state)
    by_hand = tf.close_loop(plant, build_law(small, plant), end_time=0.3)
    run = tf.control_case(small)
    np.testing.assert_array_equal(run.data["w"], by_hand.data["w"])
    assert parse_case(run.data.attrs["case"]) == small
    assert run.data["source_work"].values[-1, 0] == plant.energy_by_source["push"]
    assert "attitude_error" not in run.data


@pytest.mark.slow
def test_a_reduced_loop_is_the_loop():
    """Reduced and full structure under the template's law on a small mesh; check knows explicit steps too big."""
    small = {
        "mesh": {"divisions": [4, 2]},
        "cables": {"per_long_edge": 5, "per_short_edge": 3},
        "maneuver": {"duration": 0.3, "angle": 0.01},
        "solver": {"end_time": 0.4},
    }
    full = tf.control_case(parse_case(SLEW).replaced(**small)).data
    text = SLEW + '[reduction]\nkind = "modal"\n'
    reduced = tf.control_case(parse_case(text).replaced(**small)).data
    assert "ReducedModel" in reduced.attrs["reduced_model"]
    for name, most in (("command", 1e-3), ("measurement", 1e-3), ("w", 0.05)):
        found, wanted = reduced[name].values[:-1], full[name].values[:-1]
        assert np.sqrt(np.mean((found - wanted) ** 2) / np.mean(wanted**2)) < most
    explicit = parse_case(text.replace("generalized-alpha", "central-difference")).replaced(**small)
    with pytest.raises(InputError, match=r"^solver\.time_step: expected at most the stable step"):
        check_loop(explicit, build_state(explicit))


def test_sections_are_their_classes():
    case = parse_case(SLEW + TENSION)
    assert parse_case(case.to_toml()) == case
    assert pickle.loads(pickle.dumps(case)) == case
    assert case.replaced(controller={"damping": 3.0}).controller.build().damping == 3.0
    hub = case.hub.build()
    assert (hub.mass, hub.tensor.tolist()) == (50.0, np.diag([5.0, 5.0, 8.0]).tolist())
    assert case.actuators["torque"].build() == tf.HubTorque("xyz", momentum=5.0, limit=6.0)
    assert case.actuators["tension"].build() == tf.Actuator(tf.TensionGroup("y"), limit=0.3, lag=0.02)
    assert case.sensors["rate"].build() == tf.Rate(noise=1e-6)


@pytest.mark.parametrize("kind", [kind for kind, cls in parse_case(SLEW).actuators["torque"].registry.items()])
def test_every_effect_is_an_actuator_of_a_case(kind):
    """The signal is the plant's; the keys of the drive stand beside those of the effect."""
    keys = {
        "nodal-force": {"near": [0.2, 0.2], "direction": [0, 0, 1]},
        "edge-force": {"side": "+x", "direction": [0, 0, 1]},
        "stay-cable": {"point": [0.2, 0.2], "anchor": [0.2, 0.2, 1.0]},
        "membrane-temperature": {"expansion": 1e-5},
        "cable-temperature": {"expansion": 1e-6},
        "frame-temperature": {"expansion": 1e-6},
        "solar-pressure": {"direction": [0, 0, -1]},
        "piezo-film": {"coefficient": 1e-11},
        "piezo-pair": {"beams": [0]},
    }.get(kind, {})
    case = parse_case(SLEW, [])
    one = case.replaced(actuators={"own": {"kind": kind, "limit": 0.5, **keys}})
    plant = build_plant(one, build_state(one))
    assert [channel.name for channel in plant.inputs] == ["torque", "own"]


def test_laws_of_a_list_add():
    second = '[[controller]]\nkind = "tension-damping"\ncommands = ["tension"]\nlimit = 0.2\nmodes = 6\nfloor = 1e-7\n'
    text = (SLEW + TENSION).replace("[controller]", "[[controller]]") + second
    case = parse_case(text)
    assert parse_case(case.to_toml()) == case
    state = build_state(case)
    plant = build_plant(case, state)
    laws = build_law(case, plant).laws
    assert [type(law).__name__ for law in laws] == ["PD", "TensionDamping"]
    wrong = parse_case(text.replace('commands = ["tension"]', 'commands = ["torque"]'))
    with pytest.raises(CaseError, match=r"controller\.1\.commands: expected inputs that change the stiffness"):
        build_law(wrong, plant)


QUIET = template("slew")


@pytest.mark.slow
def test_any_law_that_follows_may_stand_behind_a_shaper():
    """A table of its own; read, written, pickled, and tried on the plant by its own keys."""
    case = parse_case(QUIET, ["mesh.divisions=[10,5]", "cables.per_long_edge=11", "cables.per_short_edge=6",
                              "cables.pretension_x=0.59", "cables.pretension_y=1.1"])  # fmt: skip
    assert parse_case(case.to_toml()) == case
    assert pickle.loads(pickle.dumps(case)) == case
    plant = build_plant(case, build_state(case))
    law = build_law(case, plant)
    assert (type(law).__name__, type(law.law).__name__, law.frequencies) == ("ShapedReference", "LQG", (4.43,))
    blind = case.replaced(sensors={"attitude": {"kind": "rate", "noise": 1e-6}})
    with pytest.raises(CaseError, match=r"^controller\.0\.law\.observer: .*unstable observer, perhaps for 'theta_x'"):
        build_law(blind, build_plant(blind, build_state(blind)))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('kind = "lqg"', 'kind = "tension-damping"', r"controller\.0\.law\.kind: expected one of 'pd', .*'tension-dam"),
        ('kind = "lqg"', 'kind = "shaped-reference"', r"controller\.0\.law\.kind: .*got 'shaped-reference'"),
        ('kind = "lqg"', "", r"controller\.0\.law\.kind: missing"),
        ("modes = 30", "modes = 0", r"controller\.0\.law\.modes: expected an integer >= 1, got 0"),
        ('"ZVD"', '"ZVX"', r"controller\.0\.shaper: expected one of 'ZV', 'ZVD'"),
        ("frequencies = [4.43]", "frequencies = []", r"controller\.0\.frequencies: expected at least one"),
        ("[controller.law]", "[controller.low]", r"controller\.0\.(law: missing|low: unknown key)"),
    ],
)
def test_wrong_shapers_are_one_line(old, new, words):
    assert old in QUIET
    with pytest.raises(CaseError, match=words) as caught:
        parse_case(QUIET.replace(old, new, 1))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("actuators.torque.limit=0", "actuators.torque.limit: expected a number > 0, got 0.*; write the"),
        ("actuators.torque.axis=q", "actuators.torque.axis: expected one of 'x', 'y', 'z', 'xyz' .*got 'q'"),
        ("actuators.torque.kind=wheel", "actuators.torque.kind: expected one of 'hub-torque', 'nodal-force'"),
        ("actuators.tension.change=0.1", "actuators.tension.change: unknown key .*; remove it"),
        ("actuators.tension.lag=-1", "actuators.tension.lag: expected a number >= 0, got -1"),
        ("actuators.attitude.kind=hub-torque", "sensors.attitude: expected a name of its own"),
        ("sensors.rate.noise=-1", "sensors.rate.noise: expected a number >= 0"),
        ("sensors.rate.kind=gyro", "sensors.rate.kind: expected one of 'attitude'"),
        ("controller.kind=pid", "controller.kind: expected one of 'pd'.*got 'pid'; did you mean 'pd'"),
        ("controller.stiffness=-1", "controller.stiffness: expected a number >= 0, got -1"),
        ("controller=3", "controller: expected a table of keys and values, or a list of them, got 3"),
        ("controller=[]", r"controller: expected a table of keys and values, or a list of them, got \[\]"),
        ("controller=[3]", "controller: expected tables of keys and values, got 3; write"),
        ("hub.inertia=[1.0,1.0,9.0]", "hub.inertia: expected moments of which none is larger"),
        ("hub.torque=[0,0,1]", "hub.torque: unknown key"),
        ("hub.mass=0", "hub.mass: expected a number > 0"),
        ("loop.interval=0.013", "loop.interval: expected a multiple of solver.time_step = 0.005 s.*interval = 0.015"),
        ("loop.interval=0.001", "loop.interval: expected a multiple .*interval = 0.005"),
        ("solver.adaptive_tolerance=1e-3", "solver.adaptive_tolerance: expected no value beside a .controller."),
        ("solver.method=central-difference", "solver.method: expected an implicit method beside a .controller."),
        ("output.fields=all", "output.fields: expected 'none' beside a .controller., got 'all'; remove it"),
        ("output.every=2", "output.every: expected 1 beside a .controller., got 2"),
        ("coupling.euler=false", "coupling.euler: expected true beside a .controller., got false"),
    ],
)
def test_one_line_before_anything_is_built(change, words):
    with pytest.raises(CaseError, match=words) as caught:
        parse_case(SLEW + TENSION, [change])
    assert "\n" not in str(caught.value)


def test_all_keys_that_a_loop_has_no_use_for_are_told_at_once():
    words = r"output\.every: expected 1 .*, got 2; remove it.*\n.*output\.fields: expected 'none' .*, got 'all'; remove"
    with pytest.raises(CaseError, match=words):
        parse_case(SLEW + TENSION, ["output.fields=all", "output.every=2"])


def test_wheels_need_a_hub():
    text = SLEW[: SLEW.index("[hub]")] + SLEW[SLEW.index("[maneuver]") :]
    with pytest.raises(CaseError, match=r"actuators\.torque\.kind: expected a \[hub\] section beside 'hub-torque'"):
        parse_case(text)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("actuators.tension.cables=[999]", "actuators.tension.cables: "),
        ("actuators.tension.delay=0.003", "actuators.tension.delay: expected whole intervals of 0.02 s"),
        ("sensors.film.points=[3.0,3.0]", r"sensors\.film\.points\.0: expected a point on the film"),
        ("actuators.tension.limit=[0.1,0.2]", "actuators.tension.limit: expected one number, or 1 for .*give one for"),
        (
            "actuators.tension.cables=z",
            r"actuators.tension.cables: expected the axis of some, 'x' \(\d+\), 'y' \(\d+\) here",
        ),
        ("actuators.push={kind='nodal-force',nodes=[9999],direction=[0,0,1]}", "actuators.push.nodes: .*got 9999"),
        ("controller.torque=wheel", "controller.torque: expected the name of an actuator.*got 'wheel'"),
        ("controller.rate=gyro", "controller.rate: expected the name of a sensor.*got 'gyro'"),
        ("actuators.torque.axis=x", "controller.torque: expected 3, as many numbers as of attitude"),
    ],
)
def test_check_tries_the_loop_on_the_structure(change, words, tmp_path, capsys):
    path = tmp_path / "slew.toml"
    path.write_text(f'{SLEW}{TENSION}[sensors.film]\nkind = "displacement"\npoints = [0.7, 0.4]\n', encoding="utf-8")
    assert main(["check", str(path), "--set", change]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert re.search(words, said), said


def test_authority_in_words_and_numbers(tmp_path, capsys):
    path = tmp_path / "slew.toml"
    push = '[actuators.push]\nkind = "nodal-force"\nnear = [0.4, 0.2]\ndirection = [0, 0, 1]\nlimit = 1e-3\n'
    path.write_text(SLEW + TENSION + push, encoding="utf-8")
    assert main(["authority", str(path), "-n", "4", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["inputs"]) == {"tension", "push"}
    assert all(len(one[key]) == 4 for one in found["inputs"].values() for key in ("stiffness", "force"))
    assert max(found["inputs"]["tension"]["stiffness"]) > 0.1
    assert np.abs(found["inputs"]["tension"]["force"]).max() < 1e-5 < np.abs(found["inputs"]["push"]["force"]).max()
    # as the plant tells it
    case = parse_case(SLEW + TENSION + push)
    known = build_plant(case, build_state(case)).authority(4)
    np.testing.assert_allclose(found["inputs"]["push"]["force"], known["force"].sel(input="push"), rtol=1e-9)
    assert main(["authority", str(path), "-n", "4"]) == 0
    printed = capsys.readouterr().out
    assert "change of stiffness [%]" in printed
    assert "note: push: it changes" not in printed
    path.write_text(SLEW, encoding="utf-8")
    assert main(["authority", str(path)]) == 2
    assert "actuators: expected at least one that acts on the structure" in capsys.readouterr().err


def test_commands_refuse_what_is_not_theirs(tmp_path, capsys):
    """`run` has no loop, `control` no prescribed run; bad input leaves no trace."""
    path = tmp_path / "slew.toml"
    path.write_text(SLEW, encoding="utf-8")
    assert main(["run", str(path), "-o", str(tmp_path / "out")]) == 2
    assert "hub: expected no [hub] for a run of a prescribed motion" in capsys.readouterr().err
    path.write_text(FILM_CASE, encoding="utf-8")
    assert main(["control", str(path), "-o", str(tmp_path / "out")]) == 2
    assert "controller: missing, expected a [controller] section" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_loop_that_fails_is_written_as_far_as_it_got(tmp_path, capsys):
    """A law that is not stable turns the hub ever faster: the run until then, what happened, and exit code 1."""
    path = tmp_path / "film.toml"
    path.write_text(SLEW, encoding="utf-8")
    changes = ["controller.stiffness=1e7", "actuators.torque.limit=1e9", "actuators.torque.momentum=1e9"]
    fails = [part for change in changes for part in ("--set", change)]
    assert main(["control", str(path), "-o", str(tmp_path / "out"), "--json", *fails]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "not-converged"
    assert found["message"].startswith("t = ")
    assert (tmp_path / "out" / "run.nc").exists()


def test_a_loop_can_be_interrupted(small):
    def stop(fraction, message):
        if fraction > 0.5:
            raise KeyboardInterrupt

    run = tf.control_case(small, stop)
    assert run.status.value == "interrupted"
    assert 0.1 < run.data["time"].values[-1] < 0.25
    assert run.data.sizes["sample_time"] == run.data.sizes["time"]


class Killed(BaseException):
    """Ends a loop where it stands, as a kill does."""


@pytest.mark.slow
@pytest.mark.parametrize("reduced", [False, True])
def test_a_loop_that_was_killed_goes_on_to_the_bit(reduced, tmp_path, monkeypatch):
    monkeypatch.setattr("tautflex.control.plant._RESERVED", 8)
    changes = [
        "solver.end_time=0.4",
        "sensors.rate.noise=1e-5",
        "sensors.rate.delay=0.015",
        "actuators.torque.lag=0.02",
    ]
    more = ["reduction.count=4", 'reduction.directions=["rx"]', 'solver.method="central-difference"'] if reduced else []
    case = parse_case(SLEW, changes + more)

    def kill(fraction, message):
        if fraction > limits[0]:
            limits.pop(0)
            raise Killed

    limits = [0.3, 0.7]
    while limits:
        with pytest.raises(Killed):
            tf.control_case(case, kill, checkpoint=tmp_path / "kept", seconds=1e-9)
    whole, cut = tf.control_case(case), tf.control_case(case, checkpoint=tmp_path / "kept", seconds=1e-9)
    xr.testing.assert_identical(*(run.data.assign_attrs(statistics="", reduced_model="") for run in (whole, cut)))
    assert whole.energy_balance == cut.energy_balance
    assert whole.stats.steps == cut.stats.steps
    assert list(tmp_path.iterdir()) == []


def test_angle_between_a_hub_and_what_it_follows():
    """A hub that nothing turns is off by the angle of the slew itself."""
    case = parse_case(SLEW, ["controller.stiffness=0.0", "controller.damping=0.0", "controller.inertia=0.0"])
    run = tf.control_case(case.replaced(solver={"end_time": 2.4}, sensors={"rate": {"kind": "rate"}}))
    np.testing.assert_allclose(run.data["attitude_error"].values[-1], 0.5, rtol=1e-9)
    assert run.data.attrs["maneuver_end"] == 2.0


def test_a_law_that_fails_at_once_leaves_its_first_sample(small):
    def broken(time, measurement):
        raise RuntimeError("no")

    plant = build_plant(small, build_state(small))
    with pytest.raises(tf.NotConvergedError, match=r"t = 0 s: the law failed \(RuntimeError: no\)") as caught:
        tf.close_loop(plant, broken, end_time=0.1)
    assert caught.value.result.status.value == "not-converged"
    assert np.isnan(caught.value.result.data["command"].values).tolist() == [[True]]
