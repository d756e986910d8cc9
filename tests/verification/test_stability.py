"""States that do not stay: strings and films spun beyond their frequency or pushed together, against closed forms."""

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main
from tautflex.solvers.static.stability import find_instability
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from verification.builders import CABLE, FILM_CASE, line_elements, line_nodes

AREA, ELEMENTS = 1e-6, 16


def string(tension=2.0, length=1.0, held=("y",), check=True):
    """String along x between two pins; all nodes are held in the given directions."""
    supports = [tf.Support.pinned([0, ELEMENTS])]
    if held:
        supports.append(tf.Support(tuple(range(ELEMENTS + 1)), held))
    model = tf.Model.from_mesh(
        line_nodes(length, ELEMENTS),
        cables=line_elements(ELEMENTS),
        cable=tf.CableSection(CABLE, AREA),
        cable_tension=tension,
        supports=supports,
    )
    return tf.solve_prestress(model, check=check)


def square(half_waves, tension=2.0, length=1.0):
    """Squared angular frequency of the string's mesh [rad^2/s^2]: linear elements with consistent mass."""
    cosine = np.cos(half_waves * np.pi / ELEMENTS)
    return tension / (CABLE.density * AREA) * 6.0 * (1.0 - cosine) / (2.0 + cosine) * (ELEMENTS / length) ** 2


def lowest(tension=2.0, length=1.0):
    return float(np.sqrt(square(1, tension, length)))


def steady(rate):
    return tf.SpinUp(rate=rate, duration=1.0, initial_rate=rate)


def found(state, rate, damping=None):
    motion = steady(rate).start()
    q = np.zeros(state.system.size)
    return find_instability(state, q, motion, tf.Coupling(), damping or tf.Rayleigh())


@pytest.mark.parametrize("size", [1.0, 1e3])
def test_string_spun_beyond_its_frequency_grows(size, verification_row):
    """In one plane Coriolis forces do nothing: s = sqrt(W^2 - w^2), at 120 rad/s and at 4e-3 rad/s alike."""
    tension = 2.0 if size == 1.0 else 2e-3
    state, natural = string(tension, size), lowest(tension, size)
    assert found(state, 0.999 * natural) is None
    for ratio in (1.001, 1.5):
        unstable = found(state, ratio * natural)
        assert unstable.rate == pytest.approx(natural * np.sqrt(ratio**2 - 1.0), rel=1e-6)
        np.testing.assert_allclose(
            state.system.translations(unstable.shape)[:, 2], np.sin(np.pi * np.arange(17) / 16), atol=1e-6
        )
        assert f"{unstable.rate:.3g} 1/s, most at node 8 " in unstable.text
    title = f"string of {size:g} m spun at 1.5 of its frequency: growth rate [1/s]"
    verification_row(title, natural * np.sqrt(1.25), unstable.rate, "sqrt(W² - w²), consistent mass")


def test_coriolis_force_holds_a_string_that_may_move_both_ways():
    """Seen from outside it is a string at rest: l = i (W +- w), though the potential falls both ways."""
    natural = lowest()
    assert found(string(held=()), 1.5 * natural) is None
    assert found(string(held=("y",)), 1.5 * natural) is not None


def test_damping_slows_the_growth(verification_row):
    """l^2 + a l - s^2 = 0."""
    natural = lowest()
    free, alpha = natural * np.sqrt(1.5**2 - 1.0), 80.0
    unstable = found(string(), 1.5 * natural, tf.Rayleigh(alpha, 0.0))
    expected = -0.5 * alpha + np.sqrt(0.25 * alpha**2 + free**2)
    assert unstable.rate == pytest.approx(expected, rel=1e-6)
    verification_row("the same with damping: growth rate [1/s]", expected, unstable.rate, "root of l² + a l - s²")


@pytest.mark.parametrize("reduced", [False, True])
def test_run_leaves_an_unstable_equilibrium_as_told(reduced):
    """w = a cosh(s t) from an imperfection; without one the run stays where it is, but says so."""
    natural = lowest()
    rate, state = 1.2 * natural, string()
    growth = natural * np.sqrt(1.2**2 - 1.0)
    plant = tf.reduce(state, tf.ModalBasis(directions=("z",), count=3)) if reduced else state
    question = {"time_step": 0.002 / growth, "end_time": 6.0 / growth, "probes": {"middle": (0.5, 0.0, 0.0)}}
    question |= {"method": tf.Newmark()}
    still = tf.simulate(plant, steady(rate), **question).data
    assert np.abs(still["w"]).max() < 1e-12
    assert any(f"at {growth:.3g} 1/s" in text for text in still.attrs["warnings"])
    moved = tf.simulate(plant, steady(rate), **question, initial_imperfection=1e-9).data
    np.testing.assert_allclose(moved["w"][:, 0], 1e-9 * np.cosh(growth * moved["time"]), rtol=1e-4)


def test_imperfection_of_a_stable_state_is_the_first_mode():
    state, natural = string(), lowest()
    question = {"time_step": 1e-4, "end_time": 0.02, "probes": {"middle": (0.5, 0.0, 0.0)}}
    data = tf.simulate(state, **question, initial_imperfection=1e-8, method=tf.Newmark()).data
    np.testing.assert_allclose(data["w"][:, 0], 1e-8 * np.cos(natural * data["time"]), atol=1e-10)
    assert data.attrs["warnings"] == []
    with pytest.raises(tf.InputError, match="initial_imperfection: expected"):
        tf.simulate(state, **question, initial_imperfection=-1.0)


def test_film_spun_beyond_its_frequency_grows(verification_row):
    """In-plane motion is stiff, so that transverse motion is on its own: s = sqrt(W^2 - w11^2) [theory.md 6].

    Without the inertial load, which would push the film together at the edges far from the axis.
    """
    natural = np.pi * np.sqrt((4000.0 / 1.0**2 + 3000.0 / 0.8**2) / 1530.0)
    section = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4)
    layout = AntennaLayout(1.0, 0.8, (8, 8), element="triangle6")
    state = tf.solve_prestress(build_fixed_film(layout, section, (4000.0, 3000.0, 0.0)))
    question = {"time_step": 1e-3, "end_time": 2e-3, "coupling": tf.Coupling(inertial_load=False)}
    data = tf.simulate(state, steady(1.2 * natural), **question).data
    text = next(text for text in data.attrs["warnings"] if "unstable" in text)
    expected, told = natural * np.sqrt(1.2**2 - 1.0), float(text.split("fastest at ")[1].split()[0])
    assert told == pytest.approx(expected, rel=0.01)
    verification_row("film spun at 1.2 of its frequency: growth rate as told [1/s]", expected, told, "sqrt(W² - w11²)")
    assert "spin more slowly" in text
    calm = tf.simulate(state, steady(0.95 * natural), **question).data
    assert not any("unstable" in text for text in calm.attrs["warnings"])


def test_string_that_is_pushed_grows_without_any_spin(verification_row):
    """Fastest in the shape of most half-waves, s^2 = 2/(rho A) ..., as many shapes as the mesh has."""
    state = string(tension=-2.0, check=False)
    unstable = found(state, 0.0)
    expected = np.sqrt(square(ELEMENTS - 1))
    assert unstable.rate == pytest.approx(expected, rel=1e-9)
    verification_row("string pushed by 2 N: growth rate [1/s]", expected, unstable.rate, "mesh's shortest wave")
    assert f"{ELEMENTS - 1} motion(s)" in unstable.text
    assert "its prestress pushes" in unstable.text


@pytest.mark.slow
def test_command_line_tells_before_the_run(tmp_path, capsys):
    natural = np.pi * np.sqrt((4000.0 / 1.0**2 + 3000.0 / 0.8**2) / 1530.0)
    case = tmp_path / "film.toml"
    turning = f'[maneuver]\nkind = "spin-up"\nrate = {2 * natural}\ninitial_rate = {2 * natural}\nduration = 0.1\n'
    case.write_text(FILM_CASE + turning, encoding="utf-8")
    for command in (["check", str(case)], ["run", str(case), "-o", str(tmp_path / "out")]):
        assert main([*command, "--json", "--set", "solver.initial_imperfection=1e-6"]) == 0
        said = [text for text in json.loads(capsys.readouterr().out)["warnings"] if "unstable" in text]
        assert len(said) == 1
        assert f"spin of {2 * natural:.3g} rad/s" in said[0]


def column(ratio):
    """Cantilever column under a part of Euler's load pi^2 EI / (4 L^2), straight."""
    section = tf.BeamSection(tf.Material(2e11, 7800.0, 0.3), 1e-3, 2e-7, 1e-7, 2e-7)
    nodes = line_nodes(10.0, ELEMENTS)
    model = tf.Model.from_mesh(nodes, beams=line_elements(ELEMENTS), beam=section, supports=(tf.Support.clamped([0]),))
    forces = np.zeros_like(nodes)
    forces[-1, 0] = -ratio * np.pi**2 * 2e11 * 1e-7 / (4.0 * 10.0**2)
    return tf.solve_prestress(model), forces


def test_static_equilibrium_of_a_buckled_column_is_told(verification_row):
    """Newton's method stays on the straight branch beyond Euler's load, and says that no column does."""
    state, forces = column(0.999)
    tf.solve_static(state, forces=forces)
    state, forces = column(1.001)
    with pytest.warns(tf.UnstableWarning, match=r"falls in 1 direction\(s\), most at node 16 \(10, 0, 0\) m"):
        q = tf.solve_static(state, forces=forces)
    assert np.abs(state.system.translations(q)[:, 1:]).max() == 0.0
    state, forces = column(2.5)  # I_z = 2 I_y: the stiffer way falls too
    with pytest.warns(tf.UnstableWarning, match=r"falls in 2 direction\(s\)"):
        tf.solve_static(state, forces=forces)
    shown = ("warned beyond 1", "silent at 0.999, warned at 1.001", "π² EI / (4 L²)", "below 0.001")
    verification_row("dead load on a straight cantilever column, of Euler's load", *shown)


@pytest.mark.jax
@pytest.mark.slow
@pytest.mark.parametrize("reduced", [False, True])
def test_batch_tells_which_starts_are_unstable(reduced):
    """Spun beyond their frequencies, w sqrt(tension), strings leave the start at sqrt(W^2 - tension w^2)."""
    state, natural = string(), lowest()
    plant = tf.reduce(state, tf.ModalBasis(directions=("z",), count=3)) if reduced else state
    batch, question = tf.Batch(plant), {"time_step": 1e-5, "end_time": 2e-5, "method": tf.Newmark()}
    tensions, rate = np.array([0.8, 0.63, 1.0, 0.5]), 0.8 * natural
    warned = batch.simulate({"tension_x": tensions}, steady(rate), **question).attrs["warnings"]
    text = next(text for text in warned if "unstable" in text)
    assert text.startswith("2 of 4 runs start from an unstable equilibrium; motion leaves that of run 3 ")
    assert f" at {natural * np.sqrt(0.8**2 - 0.5):.3g} 1/s" in text
    calm = batch.simulate({"tension_x": tensions}, steady(0.7 * natural), **question).attrs["warnings"]
    assert not any("unstable" in text for text in calm)
