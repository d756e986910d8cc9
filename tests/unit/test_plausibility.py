"""Doubts: each with the right number, and none where all is well."""

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main
from tautflex.solvers.plausibility import doubts_about_maneuver, doubts_about_structure, measure
from tautflex.structure.mesh import rectangle_mesh
from verification.builders import CABLE, FILM, FILM_CASE, FRAME, line_elements, line_nodes


def film(stress=(4e5, 3e5, 0.0), thickness=1e-4, extra=None, **given):
    """Film of 1 m x 0.8 m with fixed edges; ``extra`` adds triangles between its nodes and new ones."""
    nodes, triangles = rectangle_mesh(np.linspace(-0.5, 0.5, 6), np.linspace(-0.4, 0.4, 5))
    edge = np.flatnonzero((np.abs(nodes[:, 0]) > 0.499) | (np.abs(nodes[:, 1]) > 0.399))
    if extra is not None:
        nodes, triangles = np.concatenate([nodes, extra[0]]), np.concatenate([triangles, extra[1]])
    return tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=tf.MembraneSection(FILM, thickness),
        membrane_stress=stress,
        supports=(tf.Support.pinned(edge),),
        **given,
    )


def string(tension=2.0, **given):
    return tf.Model.from_mesh(
        line_nodes(1.0, 16),
        cables=line_elements(16),
        cable=tf.CableSection(CABLE, 1e-6),
        cable_tension=tension,
        supports=(tf.Support.pinned([0, 16]), tf.Support(tuple(range(17)), ("y",))),
        **given,
    )


def only(texts, part):
    found = [text for text in texts if part in text]
    assert len(found) == 1, texts
    return found[0]


def test_prestrain():
    """Biaxial stress s stretches a film by s (1 - nu)/E."""
    stress = 0.02 * 3.5e9 / (1.0 - 0.34)
    state = tf.solve_prestress(film((stress, stress, 0.0)))
    assert "the prestrain is 2.0% in membrane 0 at (-0.367, -0.333, 0) m" in only(state.warnings, "prestrain")
    assert tf.solve_prestress(film((0.4 * stress, 0.4 * stress, 0.0))).warnings == ()


def test_strain_and_slope_of_a_run():
    """A string displaced by 0.2 m sin(pi x): steepest at its ends, where the mean slope of an element is 0.624."""
    state = tf.solve_prestress(string())
    question = {"time_step": 1e-9, "end_time": 2e-9}
    said = tf.simulate(state, **question, initial_imperfection=0.2).data.attrs["warnings"]
    slope = 0.2 * 16 * np.sin(np.pi / 16)
    told = only(said, "slope")
    assert f"the slope reached {slope:.2f} at t = 0 s in cable " in told
    assert "strain = 'green-lagrange'" in told
    strain = 0.5 * slope**2 + 2.0 / (CABLE.youngs_modulus * 1e-6)
    assert f"the strain reached {strain:.1%} at t = 0 s in cable " in only(said, "strain reached")
    small = tf.simulate(state, **question, initial_imperfection=0.05).data.attrs["warnings"]
    assert small == []


def test_rotation_of_beams():
    """First mode of a cantilever: the tip turns by 1.3765 of its deflection over the length."""
    model = tf.Model.from_mesh(
        line_nodes(1.0, 10),
        beams=line_elements(10),
        beam=tf.BeamSection(FRAME, 1e-4, 1e-9, 8e-9, 1e-9),
        supports=(tf.Support.clamped([0]),),
    )
    state = tf.solve_prestress(model)
    question = {"time_step": 1e-9, "end_time": 2e-9}
    said = tf.simulate(state, **question, initial_imperfection=0.2).data.attrs["warnings"]
    assert f"the rotation reached {0.2 * 1.3765:.2f} at t = 0 s in beam 9 at (0.95, 0, 0) m" in only(said, "rotation")
    assert tf.simulate(state, **question, initial_imperfection=0.1).data.attrs["warnings"] == []


def test_slope_of_a_film_that_is_pushed_at_its_edge():
    """All free nodes 0.01 m above the edge: the steepest triangles rise so along both sides of their cells."""
    system = tf.solve_prestress(film()).system
    full = np.zeros(system.model.dof_count)
    full[system.model.translation_dofs[:, 2]] = 0.01
    found = measure(system, full[system.model.free_dofs])["slope"]
    assert found.value == pytest.approx(0.01 / 0.2 * np.sqrt(2.0))


def test_imbalance_is_a_doubt_unless_it_was_chosen():
    """A string whose halves pull with 2 N and 1 N: 1 N of 2 N is left."""
    tension = np.where(np.arange(16) < 8, 2.0, 1.0)
    told = only(tf.solve_prestress(string(tension)).warnings, "balance")
    assert "1 N, 50% of the largest force" in told
    chosen = tf.solve_prestress(string(tension, prestress_mode="uniform"))
    assert chosen.warnings == ()
    assert chosen.notes == (told,)
    assert tf.solve_prestress(string(np.where(np.arange(16) < 8, 2.0, 1.92))).warnings == ()


def test_turn_in_a_step():
    """A slew's rate has its largest value, 2 angle/duration for the versine, in the middle."""
    told = only(doubts_about_maneuver(tf.Slew(1.0, 0.1), 0.03), "in a time_step")
    assert "by up to 0.6 rad in a time_step of 0.03 s" in told
    assert "time_step = 0.005 s" in told
    assert doubts_about_maneuver(tf.Slew(1.0, 0.1), 0.024) == []
    assert "2 rad in a time_step" in doubts_about_maneuver(tf.SpinUp(20.0, 0.1), 0.1)[0]
    for lost in (tf.Slew(1e29, 5.0), tf.SpinUp(1e5, 1.0)):
        with pytest.raises(tf.InputError, match="maneuver: expected angles that arithmetic resolves to 1e-06 rad"):
            doubts_about_maneuver(lost, 1e-3, 1e5)
    state = tf.solve_prestress(string())
    with pytest.raises(tf.InputError, match="got 1e\\+29 rad in all"):
        tf.simulate(state, tf.Slew(1e29, 1.0), time_step=1e-3, end_time=2e-3)


def test_input_faster_than_the_steps():
    """A sine of a few steps a period lies 1 - cos(pi/n) beside its chords; its aliases are told too."""
    state = tf.solve_prestress(string())

    def told(force, step=1e-3, **given):
        question = {"time_step": step, "end_time": 20 * step, "inputs": [tf.NodalForce([8], force, **given)]}
        return [text for text in tf.simulate(state, **question).data.attrs["warnings"] if "changes faster" in text]

    def wave(frequency):
        return lambda time: (0.0, 0.0, 1e-6 * np.sin(2.0 * np.pi * frequency * time))

    assert told(wave(100.0)) == []
    assert told((0.0, 0.0, 1e-6)) == []
    assert "NodalForce number 1" in only(told(wave(300.0)), "changes faster")
    text = only(told(wave(1000.0)), "changes faster")  # zero at every step's end
    better = float(text.split("time_step = ")[1].split()[0])
    assert told(wave(1000.0), better) == []
    assert 1.0 - np.cos(np.pi * 1000.0 * better) < 0.03

    def jump(time):
        return (0.0, 0.0, 1e-6 if time >= 5.5e-3 else 0.0)

    assert "list its jumps as breaks" in only(told(jump), "changes faster")
    assert told(jump, breaks=(5.5e-3,)) == []
    table = tf.TimeTable([0.0, 1e-4, 2e-4], [[0, 0, 0], [0, 0, 1e-6], [0, 0, 0]])
    assert told(table) == []  # steps go onto every row
    chance = np.random.default_rng(1)
    assert "no step follows it" in only(told(lambda time: 1e-6 * chance.standard_normal(3)), "changes faster")


def test_angle_of_a_maneuver():
    assert "by 90 rad, 14.3 revolutions, until t = 5 s" in only(doubts_about_maneuver(tf.Slew(90.0, 5.0)), "degrees")
    assert "90 degrees are 1.571" in doubts_about_maneuver(tf.Slew(-90.0, 5.0, "bang-bang"))[0]
    for fine in (tf.Slew(2.0 * np.pi, 5.0), tf.Stop(0.5 * np.pi, 2.0), tf.SpinUp(3.0, 2.0), tf.AtRest()):
        assert doubts_about_maneuver(fine) == []
    state = tf.solve_prestress(string())
    said = tf.simulate(state, tf.Slew(7.0, 1.0), time_step=1e-3, end_time=2e-3).data.attrs["warnings"]
    assert "7 rad" in only(said, "degrees")


def test_thickness_of_a_plate():
    """The span is the shorter side, however the film lies."""
    assert "0.1 m thick, 12.5% of its shorter span of 0.8 m" in only(
        doubts_about_structure(film(thickness=0.1)), "thick"
    )
    assert doubts_about_structure(film(thickness=0.008)) == []


def test_nodes_at_one_place_that_are_not_joined():
    """A second film that hangs on one node of the first, and meets another one without being joined to it."""
    corner, meets = np.array([0.5, -0.4, 0.0]), np.array([0.5, 0.4, 0.0])
    extra = np.array([meets, [0.9, 0.0, 0.0]])
    model = film(extra=(extra, [[25, 31, 30]]))
    assert np.allclose(model.nodes[25], corner)
    told = only(doubts_about_structure(model), "same place")
    assert "nodes 29 and 30 lie at the same place (0.5, 0.4, 0) m but are not joined (1 such pair(s))" in told


@pytest.mark.parametrize("twice", [[0, 5, 6], [6, 0, 5]])
def test_film_elements_given_twice(twice):
    told = only(doubts_about_structure(film(extra=(np.zeros((0, 3)), [twice]))), "on top")
    assert "film elements 0 and 40 lie on top of each other" in told


def test_film_elements_that_overlap():
    """One large triangle over the whole film shares three of its nodes."""
    told = only(doubts_about_structure(film(extra=(np.zeros((0, 3)), [[0, 25, 29]]))), "on top")
    assert "and 40 lie on top of each other" in told


def test_cables_given_twice():
    model = string()
    twice = np.concatenate([model.cables, [[4, 3]]])
    model = tf.Model.from_mesh(
        model.nodes, cables=twice, cable=tf.CableSection(CABLE, 1e-6), cable_tension=1.0, supports=model.supports
    )
    assert "cables 3 and 16 both join nodes [3, 4]" in only(doubts_about_structure(model), "both join")


def test_probe_beside_the_structure():
    """Read at a corner 4.6 m away; at most one element away is what the reading is there for."""
    state = tf.solve_prestress(film())
    question = {"time_step": 1e-3, "end_time": 2e-3, "probe_reading": "nearest-node"}
    said = tf.simulate(state, **question, probes={"A": (3.5, 3.9)}).data.attrs["warnings"]
    assert f"probe A is read {np.hypot(3.0, 3.5):.3g} m away" in only(said, "probe A")
    assert tf.simulate(state, **question, probes={"A": (0.42, 0.33)}).data.attrs["warnings"] == []


@pytest.mark.slow
@pytest.mark.parametrize(("pull_x", "pull_y"), [(0.59, 1.0), (3.1, 3.7)])
def test_published_antennas_are_fine(tmp_path, capsys, pull_x, pull_y):
    """M2 and M3 of the paper: what their case chooses is noted once, nothing is warned of."""
    case = tmp_path / "case.toml"
    assert main(["init", str(case), "--template", "m2-nearest-node"]) == 0
    tensions = ["--set", f"cables.pretension_x={pull_x}", "--set", f"cables.pretension_y={pull_y}"]
    capsys.readouterr()
    assert main(["check", str(case), "--json", *tensions]) == 0
    checked = json.loads(capsys.readouterr().out)
    assert checked["warnings"] == []
    assert len(checked["notes"]) == 2
    only(checked["notes"], "balance")
    assert "probe A is read 0.121 m away, at node (0.8, 0.5)" in only(checked["notes"], "probe A")
    run = ["run", str(case), "-o", str(tmp_path / "out"), "--json", "--set", "solver.end_time=1.5"]
    assert main([*run, "--set", "maneuver.rate=0.0628", *tensions]) == 0
    assert json.loads(capsys.readouterr().out)["warnings"] == []


def test_command_line_tells_of_a_case(tmp_path, capsys):
    case = tmp_path / "film.toml"
    case.write_text(FILM_CASE + '[maneuver]\nkind = "slew"\nangle = 90.0\nduration = 10.0\n', encoding="utf-8")
    assert main(["check", str(case), "--json", "--set", "membrane.thickness=0.1"]) == 0
    said = json.loads(capsys.readouterr().out)
    only(said["warnings"], "90 rad")
    only(said["warnings"], "0.1 m thick, 12.5%")
    assert said["notes"] == []


def film_of(stress, rise=0.0, cable=True):
    """Film held at its edges, with this stress [Pa] and rise, from which a taut cable may hang."""
    nodes, triangles = rectangle_mesh(np.linspace(-0.5, 0.5, 5), np.linspace(-0.4, 0.4, 4))
    nodes = nodes.copy()
    nodes[:, 2] = rise * (nodes[:, 0] ** 2 + nodes[:, 1] ** 2)
    edge = np.flatnonzero((np.abs(nodes[:, 0]) > 0.499) | (np.abs(nodes[:, 1]) > 0.399))
    more = {}
    if cable:
        nodes, edge = np.vstack([nodes, [0.5, 0.0, 1.0]]), np.append(edge, len(nodes))
        more = {"cables": [[int(edge[0]), len(nodes) - 1]], "cable_tension": 1.0}
        more["cable"] = tf.CableSection(tf.Material(1e9, 1000.0), 1e-6)
    return tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4),
        membrane_stress=stress,
        supports=(tf.Support.pinned(edge),),
        prestress_mode="uniform",
        **more,
    )


def test_film_without_tension_is_told():
    """A taut cable beside it makes no tension in the film; its interior nodes, each for itself, move freely."""
    loose = tf.solve_prestress(film_of((0.0, 0.0, 0.0)))
    (told,) = loose.warnings
    assert "24 of 24 film elements have no tension" in told
    assert "6 motion(s)" in told
    assert "stress_x" in told and "membrane_stress" in told  # noqa: PT018 - both ways to say it
    # Roots of the round-off of stiffness in the plane, whose frequencies are ten million times as high.
    assert np.all(np.abs(tf.solve_modes(loose, 6).frequencies) < 1e-3)
    assert tf.solve_prestress(film_of((0.0, 0.0, 0.0), cable=False), check=False).warnings == loose.warnings


@pytest.mark.parametrize(("stress", "rise"), [((4e3, 4e3, 0.0), 0.0), ((4e3, 0.0, 0.0), 0.0), ((0.0, 0.0, 0.0), 0.3)])
def test_film_that_tension_or_its_shape_holds_is_left_alone(stress, rise):
    state = tf.solve_prestress(film_of(stress, rise))
    assert not [text for text in state.warnings if "tension" in text]
    assert tf.solve_modes(state, 1).frequencies[0] > 0.1
