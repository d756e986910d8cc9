"""Whatever the package gives back prints as a short card with the numbers that a user wants."""

import re

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case
from tautflex.text import card, shown, span
from verification.builders import FILM_CASE, antenna


@pytest.fixture(scope="module")
def made():
    case = parse_case(FILM_CASE)
    model = antenna((20.0, 20.0))
    state = tf.solve_prestress(model)
    film = tf.solve_prestress(tf.build_model(case))
    options = {"time_step": 0.01, "end_time": 0.1, "probes": {"A": (0.2, 0.1)}, "fields": "all"}
    run = tf.simulate(film, initial_velocity=lambda x, y: 0.01 + 0 * x, **options)
    rom = tf.reduce(film, tf.ModalBasis(count=2))
    many = np.linspace(0.0, 1.0, 1000)
    return {
        "case": case,
        "model": model,
        "state": state,
        "modes": tf.solve_modes(state, n=30),
        "run": run,
        "rom": rom,
        "hyper": tf.hyper_reduce(film, run),
        "problem": tf.TransientProblem(state, tf.Stop(0.1, 1.0), inputs=[tf.CableTension(lambda t: 0.0)], **options),
        "hub": tf.FreeHub(1.0, (1, 1, 1), torque=lambda time, state: (0, 0, 0)),
        "spinning": tf.solve_spinning_modes(film, (0.1, 0, 0), n=4),
        "tuned": tf.tune_pretension(tf.build_model(case), [30.0], tolerance=1e-3),
        "system": state.system,
        "linear": state.linear,
        "damping": tf.Modal(0.01, 3).matrix(film.linear),
        "ratios": tf.Modal((0.01,) * 100),
        "vectors": rom.basis,
        "pod": tf.PodBasis(run),
        "table": tf.TimeTable(many, many),
        "tabulated": tf.Tabulated(many, many),
        "force": tf.NodalForce(list(range(1000)), (0, 0, 1)),
        "pressure": tf.PressureLoad(film, 2.0),
        "group": model.groups[0],
        "block": state.system.blocks[0],
        "support": tf.Support.clamped(range(1000)),
        "statistics": run.stats,
        "mesh": tf.MeshData(model.nodes, model.triangles, model.cables, model.beams),
    }


def test_cards_are_short_and_name_no_addresses(made):
    for name, thing in made.items():
        text = repr(thing)
        assert text.startswith(type(thing).__name__), name
        assert len(text) <= 1000, name
        assert text.count("\n") <= 12, name
        assert " at 0x" not in text, name


def test_cards_tell_the_numbers(made):
    model, state, modes, run = (made[name] for name in ("model", "state", "modes", "run"))
    text = repr(model)
    for words in (f"nodes      {len(model.nodes)}", str(len(model.free_dofs)), f"{model.mass:.4g} kg", "34 cables"):
        assert words in text
    assert f"{state.min_principal_resultant:.4g} N/m" in repr(state)
    assert "stable" in repr(state)
    assert f"30, {modes.frequencies[0]:.4g} to {modes.frequencies[-1]:.4g} Hz" in repr(modes)
    assert f"mode 1   {modes.frequencies[0]:.4g} Hz" in repr(modes)
    largest = float(abs(run.data.w.sel(probe="A")).max())
    for words in ("completed, reached 0.1 s", "10 steps", "11 instants, 11 fields", f"{largest:.4g} m"):
        assert words in repr(run)
    assert "Wilson-theta" in repr(made["problem"])
    assert "10 of 0.01 s to 0.1 s" in repr(made["problem"])
    assert "length = 1.0, width = 0.8" in repr(made["case"])


@pytest.mark.jax
def test_a_batch_names_its_plant(made):
    assert f"{len(made['model'].nodes)} nodes" in repr(tf.Batch(made["state"]))


def test_warnings_stand_on_the_card():
    state = tf.solve_prestress(antenna((20.0, 20.0), mode="uniform"), check=False)
    run = tf.simulate(state, tf.Stop(1.0, 0.05), time_step=0.01, end_time=0.1, probes={"A": (0.0, 0.4)})
    assert ("warning 1" in repr(run)) == bool(run.data.attrs["warnings"])
    assert run.data.attrs["warnings"]


def test_long_cards_say_what_they_leave_out():
    text = card(3, {f"line {k}": "x" * 200 for k in range(40)} | {"empty": ""})
    assert text.count("\n") == 11
    assert text.endswith("... and 30 more")
    assert "empty" not in text
    assert max(map(len, text.split("\n"))) <= 82
    assert shown(list(range(1000))).endswith("...")
    assert span([], "Hz") == ""
    assert span([1.0, 1.0], "Hz") == "1 Hz"
    assert re.fullmatch(r"1 to 2\.5 Hz", span([2.5, 1.0], "Hz"))
