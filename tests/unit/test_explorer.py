"""Pages to explore: what they are made from, what stands in, and what they refuse."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case
from tautflex.cli import main
from tautflex.motion.fixed_axis import Slew
from tautflex.pages.board import board_of
from tautflex.pages.explorable import explorable
from tautflex.pages.played import Turn, played
from unit.test_report import data_of
from verification.builders import FILM_CASE
from verification.dynamic_cases import small_antenna

BASIS = tf.ModalBasis(directions=("rx",), count=3)
HUB = tf.FreeHub(20.0, (3.0, 4.0, 5.0), axes="x")


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


def test_what_nobody_gave_has_a_stand_in_that_is_told(state):
    given = explorable(state)
    assert given.hub.axes == "x"
    assert set(given.actuators) == {"tension_x", "tension_y"}
    own = float(given.hub.tensor[0, 0])
    assert given.law.inertia == pytest.approx(1.5 * own)
    assert given.law.stiffness == pytest.approx(4.0 * given.law.inertia)
    told = "; ".join(given.remarks)
    for word in ("wheel", "tension", "ModalBasis", "a hub that turns about x", "damping", "attitude control", "slew"):
        assert word in told
    assert all(drive.limit > 0.0 for drive in given.actuators.values())


def test_what_is_given_stays(state):
    rom, law, slew = tf.reduce(state, BASIS), tf.PD(3.0, 2.0), tf.Slew(-0.2, 1.0, "versine")
    wheel = tf.HubTorque("xyz", limit=(1.0, 2.0, 3.0))
    asked = {"actuators": {"wheel": wheel}, "damping": tf.Rayleigh(0.1, 1e-4), "law": law, "slew": slew}
    given = explorable(rom, tf.FreeHub(20.0, (3.0, 4.0, 5.0)), **asked)
    assert (given.rom, given.law, given.slew, given.damping) == (rom, law, slew, asked["damping"])
    assert given.torque == tf.HubTorque("x", limit=1.0)
    assert given.remarks == ["the hub turns about x alone"]
    assert explorable(rom, slew=tf.Slew(0.2, 1.0, axis=(0.0, 0.0, -2.0))).hub.axes == "z"


def test_a_case_gives_what_it_has():
    given = explorable(parse_case(FILM_CASE))
    assert list(given.probes) == ["A"]
    assert given.actuators == {}  # there are no cables


@pytest.mark.parametrize("shaper", ["none", "ZV", "ZVD"])
def test_a_slew_is_its_sliders(shaper):
    turn = Turn.of(tf.Slew(-0.3, 1.0, "versine"), 0, shaper, 2.0, 0.01)
    maneuver = turn.maneuver(0)
    assert maneuver.end == pytest.approx(1.0 + turn.delay)
    assert turn.delay == pytest.approx({"none": 0.0, "ZV": 0.25, "ZVD": 0.5}[shaper], rel=1e-3)
    again = Turn.of(maneuver, 0, "ZV", 9.0, 0.5)
    assert again.duration == pytest.approx(1.0, rel=1e-12)
    known = {"duration": 1.0} | ({"shaper": "none", "frequency": 2.0, "ratio": 0.01} if shaper == "none" else {})
    assert again._replace(**known) == turn


def test_a_played_run_is_that_of_the_law(state):
    """Against the law, maneuver and loop of the control room."""
    rom, law = tf.reduce(state, BASIS), tf.PD(12.0, 8.0, 3.5)
    board = board_of(explorable(rom, HUB, damping=tf.Rayleigh(0.1, 1e-3), law=law))
    gains = {"stiffness": 12.0, "damping": 8.0, "inertia": 3.5}
    found = played(board.plant, Turn(0.4, 0.3, "minimum-jerk", "none", 1.0, 0.0), gains, 50)
    expected = board.plant.run(law, Slew(0.4, 0.3, "minimum-jerk"), end_time=0.5)[0][:, 0]
    assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()


def test_command_writes_a_page(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "film.toml").write_text(FILM_CASE, encoding="utf-8")
    assert main(["explore", "film.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["megabytes"] < 2.0
    data = data_of(tmp_path / "explorer.html")
    assert data["title"] == "Explorer: film"
    assert data["mesh"]["probes"]["names"] == ["A"]
    assert data["readings"] == ["attitude", "rate", "rms", "w"]
    assert main(["explore", "film.toml"]) == 2
    assert "--force" in capsys.readouterr().err
    assert main(["explore", "film.toml", "-o", "again.html", "--set", "membrane.law=tension-field"]) == 2
    said = capsys.readouterr().err
    assert "film.toml: law: expected elastic film and cables" in said


def test_wrong_pages_are_named(state, tmp_path):
    rom, page = tf.reduce(state, BASIS), tmp_path / "a.html"
    wild = tf.PD(1e7, 1e7)
    taken = {"hand": tf.Actuator(effect=tf.NodalForce([3], direction=(0, 0, 1)))}
    for arguments, options, text in (
        ((small_antenna(), page), {}, "model: expected a case, a prestressed state or a reduced model"),
        ((rom, tmp_path / "a.pdf"), {}, "path: expected a name that ends with .html"),
        ((rom, page), {"law": wild}, "law: expected a loop that is stable"),
        ((rom, page), {"slew": tf.Slew(4.0, 1.0)}, "slew: expected an angle within half a turn"),
        ((rom, page), {"law": 3.0}, "law: expected a PD"),
        ((rom, page), {"actuators": taken}, "actuators: expected names that do not begin with"),
        ((rom, page), {"title": 3}, "title: expected a text"),
    ):
        with pytest.raises(tf.InputError, match=f"^{text}"):
            tf.explore(*arguments, **options)
    assert not page.exists()
