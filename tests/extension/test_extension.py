"""The promise: one file of at most 80 lines that imports only tautflex adds a thing of any kind, everywhere."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case
from tautflex.case.plugins import load_plugin
from tautflex.case.registry import CONTROLLERS, DAMPINGS, INPUTS, MANEUVERS, METHODS, SENSORS
from tautflex.case.sections.control import Controller, Sensor
from tautflex.cli import main
from tautflex.elements.element import ELEMENTS
from tautflex.elements.laws.law import LAWS
from tautflex.structure.materials import LAW_NAMES
from tautflex.structure.shapes import SHAPES
from verification.builders import FILM_CASE

HERE = Path(__file__).parent
FILES = sorted(path for path in HERE.glob("*.py") if not path.name.startswith("test_"))
# The file of each section that needs one.
SECTIONS = {
    "maneuver_coning": '[maneuver]\nkind = "coning"\nrate = 0.3\ntransverse_rate = 0.2\nconing_rate = 7.0\n',
    "method_backward_euler": '[maneuver]\nkind = "stop"\nrate = 0.5\nduration = 0.1\n',
    "input_tap": '[inputs.knock]\nkind = "tap"\nnear = [0.1, 0.0]\nimpulse = 1e-5\n',
    "damping_two_ratios": '[maneuver]\nkind = "stop"\nrate = 0.5\nduration = 0.1\n'
    '[damping]\nkind = "two-ratios"\nratio = 0.02\nlow = 1.0\nhigh = 5.0\n',
    "law_worn": '[maneuver]\nkind = "stop"\nrate = 0.5\nduration = 0.1\n',
    "element_quad8": '[maneuver]\nkind = "stop"\nrate = 0.5\nduration = 0.1\n',
}
OVERRIDES = {
    "method_backward_euler": ["solver.method=backward-euler"],
    "law_worn": ["membrane.law=worn"],
    "element_quad8": ["mesh.element=quad8", "mesh.divisions=[3,2]"],
}


@pytest.fixture(scope="module", autouse=True)
def plugins():
    """What the files register is forgotten behind these tests, for those that follow in the same process."""
    tables = [
        ELEMENTS,
        LAWS,
        SHAPES,
        *(one._classes for one in (MANEUVERS, METHODS, INPUTS, DAMPINGS, SENSORS, CONTROLLERS)),
    ]
    before, names = [dict(table) for table in tables], {kind: list(known) for kind, known in LAW_NAMES.items()}
    for path in FILES:
        load_plugin(path)
    yield
    for table, kept in zip(tables, before, strict=True):
        table.clear()
        table.update(kept)
    LAW_NAMES.update(names)


def case_of(name: str, *overrides: str) -> tf.Case:
    return parse_case(FILM_CASE + SECTIONS[name], [*OVERRIDES.get(name, []), *overrides])


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_each_is_small_and_knows_only_the_public_names(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 80
    for node in ast.walk(ast.parse(text)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module] if isinstance(node, ast.ImportFrom) else []
        for name in names:
            assert name in ("tautflex", "numpy", "dataclasses", "typing", "collections.abc", "__future__")


@pytest.mark.parametrize("name", SECTIONS)
@pytest.mark.slow
def test_each_runs_from_a_case_file_as_in_python(name, tmp_path, capsys):
    path = tmp_path / "case.toml"
    path.write_text(case_of(name).to_toml(), encoding="utf-8")
    plugin = ["--plugin", str(HERE / f"{name}.py")]
    assert main(["check", str(path), *plugin, "--json"]) == 0
    assert main(["run", str(path), "-o", str(tmp_path / "out"), *plugin, "--json"]) == 0
    capsys.readouterr()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "completed"
    assert summary["probes"]["A"]["amplitude"] > 1e-6
    data = tf.run_case(tf.load_case(path)).data
    np.testing.assert_array_equal(tf.load(tmp_path / "out" / "run.nc")["w"], data["w"])


@pytest.mark.parametrize("name", [name for name in SECTIONS if name != "law_worn"])
def test_reduced_models_take_it_too(name):
    """Nearly all modes across the small film, and what follows them: the reduced run is the full one."""
    full = tf.run_case(case_of(name)).data["w"]
    reduced = tf.run_case(case_of(name, "reduction.threshold=1e-9")).data["w"]
    assert float(np.abs(reduced - full).max()) < 0.02 * float(np.abs(full).max())


def test_sensor_and_law_from_outside():
    """A film that is let go, and pushed back to a dead zone by a law and a sensor of a user's own."""
    state = tf.solve_prestress(tf.build_model(parse_case(FILM_CASE)))
    sensor = Sensor(kind="edge-mean", x=0.0).build()
    law = Controller(kind="dead-zone", push=1e-3, zone=1e-6).build()
    node = int(np.argmin(np.linalg.norm(state.model.nodes, axis=1)))
    push = {"push": tf.NodalForce([node], (0.0, 0.0, 0.0)).prepare(state.system)}
    plant = tf.linearize(state, push, {"film": sensor}, modes=4).selected(["push[2]"], ["film"])
    spec = tf.LoopSpec((tf.Channel("film", "m"),), (tf.Channel("push", "N"),), 1e-3, 0, plant)
    discrete, x, memory = plant.discretize(1e-3), np.zeros(8), law.start(spec)
    x[0] = 1e-4
    commands = []
    for step in range(2000):
        memory, u = law.act(memory, discrete.C @ x, tf.Reference.rest(step * 1e-3, 0))
        commands.append(u[0])
        x = discrete.A @ x + discrete.B @ u
    assert {*np.abs(commands)} == {0.0, 1e-3}
    with pytest.raises(tf.CaseError, match=r"^push: expected a number > 0, got -1\.0"):
        Controller(kind="dead-zone", push=-1.0, zone=0.0)


@pytest.mark.slow
def test_sensor_law_and_actuator_from_outside_in_a_case(tmp_path, capsys):
    """The same through the command line, which knows them by their files."""
    path = tmp_path / "film.toml"
    sections = """[maneuver]
kind = "stop"
rate = 0.5
duration = 0.1
[actuators.push]
kind = "nodal-force"
near = [0.0, 0.0]
direction = [0.0, 0.0, 1.0]
[sensors.film]
kind = "edge-mean"
bias = 1e-6
[controller]
kind = "dead-zone"
push = 1e-3
zone = 1e-9
"""
    path.write_text(FILM_CASE + sections, encoding="utf-8")
    files = [
        part for name in ("controller_dead_zone", "sensor_edge_mean") for part in ("--plugin", str(HERE / f"{name}.py"))
    ]
    assert main(["control", str(path), "-o", str(tmp_path / "out"), "--json", *files]) == 0
    capsys.readouterr()
    commands = tf.load(tmp_path / "out" / "run.nc")["command"].values[:-1]
    assert {*np.abs(commands).ravel()} <= {0.0, 1e-3}
    assert np.abs(commands).max() == 1e-3


def test_coning_turns_the_frame_as_it_says():
    coning = MANEUVERS["coning"](rate=0.3, transverse_rate=0.2, coning_rate=7.0)
    motion = coning.segments()[0].motion
    assert motion(0.0).angular_velocity.tolist() == coning.start().angular_velocity.tolist()
    step = 1e-6
    slope = (motion(0.4 + step).angular_velocity - motion(0.4 - step).angular_velocity) / (2.0 * step)
    np.testing.assert_allclose(motion(0.4).angular_acceleration, slope, atol=1e-8)
    data = tf.run_case(case_of("maneuver_coning")).data
    assert "Coning" in data.attrs["maneuver"]


def test_backward_euler_is_of_first_order():
    method = METHODS["backward-euler"]()
    state = tf.solve_prestress(tf.build_model(parse_case(FILM_CASE)))
    (frequency,) = tf.solve_modes(state, n=1).frequencies
    shape = tf.solve_modes(state, n=1).shapes

    def error(step: float) -> float:
        end = 0.25 / float(frequency)
        run = tf.simulate(
            state,
            method=method,
            time_step=end / step,
            end_time=end,
            probes={"A": (0.0, 0.0)},
            initial_velocity=1e-6 * np.asarray(shape[0]) / np.abs(shape[0]).max(),
        )
        peak = 1e-6 / (2.0 * np.pi * float(frequency))
        return abs(abs(float(run.data["w"].isel(time=-1, probe=0))) - peak) / peak

    coarse, fine = error(100), error(200)
    assert coarse / fine == pytest.approx(2.0, rel=0.05)


def test_a_tap_brings_its_impulse():
    tap = INPUTS["tap"](nodes=(3, 4), impulse=1e-3, begin=0.1, duration=0.2)
    times = np.linspace(0.1, 0.3, 2001)
    whole = 2.0 * np.trapezoid([tap.force(time)[2] for time in times], times)
    assert whole == pytest.approx(1e-3, rel=1e-6)


def test_two_ratios_are_those_of_the_modes():
    state = tf.solve_prestress(tf.build_model(parse_case(FILM_CASE)))
    low, high = (float(value) for value in tf.solve_modes(state, n=2).frequencies)
    damping = DAMPINGS["two-ratios"](ratio=0.02, low=low, high=high)
    found = tf.solve_spinning_modes(state, np.zeros(3), n=2, damping=damping)
    np.testing.assert_allclose(found.damping_ratios, 0.02, rtol=1e-9)


def test_worn_film_vibrates_more_slowly():
    """Half of the stress is half of the tension; frequencies of a membrane go with its root."""
    worn = tf.solve_modes(tf.solve_prestress(tf.build_model(case_of("law_worn"))), n=3).frequencies
    whole = tf.solve_modes(tf.solve_prestress(tf.build_model(parse_case(FILM_CASE))), n=3).frequencies
    np.testing.assert_allclose(worn, np.sqrt(0.5) * whole, rtol=1e-9)


def test_worn_film_keeps_its_energy_as_half_of_an_elastic_one():
    """The energy-conserving method knows no closed form for a law from outside, and finds the right answer."""
    options = ["solver.method=energy-conserving", "solver.end_time=0.1"]
    half = ["membrane.youngs_modulus=1.75e9", "membrane.stress_x=2000.0", "membrane.stress_y=1500.0"]
    worn = tf.run_case(case_of("law_worn", *options)).data
    elastic = tf.run_case(parse_case(FILM_CASE + SECTIONS["law_worn"], [*options, *half])).data
    for name in ("w", "strain_energy", "kinetic_energy"):
        scale = 1e-9 * float(np.abs(elastic[name]).max())
        np.testing.assert_allclose(worn[name], elastic[name], rtol=0.0, atol=scale)


def test_quad8_converges_as_a_quadratic_element():
    tension = np.array([4000.0, 3000.0]) / 1530.0
    exact = 0.5 * float(np.sqrt(tension[0] / 1.0**2 + tension[1] / 0.8**2))

    def error(cells: int) -> float:
        case = case_of("element_quad8", f"mesh.divisions=[{cells},{cells}]")
        (found,) = tf.solve_modes(tf.solve_prestress(tf.build_model(case)), n=1).frequencies
        return float(found) / exact - 1.0

    assert error(8) < 2e-5
    assert np.log2(error(4) / error(8)) == pytest.approx(4.0, abs=0.2)


@pytest.mark.slow
def test_an_element_is_drawn_and_exported(tmp_path, capsys):
    path = tmp_path / "case.toml"
    path.write_text(case_of("element_quad8", "output.fields=[0.1]").to_toml(), encoding="utf-8")
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--json"]) == 0
    assert {"shapes", "modes"} <= set(json.loads(capsys.readouterr().out)["files"])
    assert main(["export", str(tmp_path / "out" / "run.nc"), "--to", "vtu", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["files"]) == 2


NOTHING = """import tautflex as tf
@tf.register
class Nothing:
    pass
"""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (NOTHING, ["Nothing", "a subclass of one of tf.Element, tf.Law, tf.Maneuver"]),
        ("import tautflex as tf\ntf.register(3)\n", ["expected a class", "got 3"]),
        ("import nowhere\n", ["ModuleNotFoundError", "nowhere", "in line 1"]),
        ("import sys\nsys.exit(0)\n", ["SystemExit: 0 in line 2"]),
        ("def broken(:\n", ["SyntaxError"]),
        (
            "import tautflex as tf\n@tf.register\nclass Stop(tf.Maneuver):\n    def start(self): ...\n"
            "    def segments(self): ...\n",
            ["Stop", "dataclass"],
        ),
        (
            "import dataclasses\nimport tautflex as tf\n@tf.register\n@dataclasses.dataclass(frozen=True)\n"
            "class Stop(tf.Maneuver):\n    def start(self): ...\n    def segments(self): ...\n",
            ["expected a new name of a maneuver", "'stop'"],
        ),
    ],
)
def test_files_that_do_not_work_are_one_line(text, words, tmp_path, capsys):
    path = tmp_path / "mine.py"
    path.write_text(text, encoding="utf-8")
    assert main(["keys", "--plugin", str(path)]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    for word in ("--plugin", "mine.py", *words):
        assert word in message
    assert MANEUVERS["stop"] is tf.Stop


def test_a_plugin_that_is_not_there(capsys):
    assert main(["keys", "--plugin", "nowhere.py"]) == 2
    assert "--plugin: nowhere.py: no such file" in capsys.readouterr().err


@pytest.mark.slow
def test_a_case_file_alone_imports_nothing_and_an_installed_package_is_found(tmp_path):
    """In processes of their own, where nothing is registered yet."""
    case = tmp_path / "case.toml"
    case.write_text(FILM_CASE + SECTIONS["maneuver_coning"], encoding="utf-8")
    package = tmp_path / "site" / "coning-1.0.dist-info"
    package.mkdir(parents=True)
    source = (HERE / "maneuver_coning.py").read_text(encoding="utf-8")
    (tmp_path / "site" / "coning.py").write_text(source, encoding="utf-8")
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: coning\nVersion: 1.0\n", encoding="utf-8")
    (package / "entry_points.txt").write_text("[tautflex.plugins]\nconing = coning\n", encoding="utf-8")

    def load(*paths: Path) -> subprocess.CompletedProcess[str]:
        places = os.pathsep.join([*map(str, paths), str(Path(tf.__file__).parents[1])])
        code = f"import tautflex as tf; print(tf.load_case({str(case)!r}).maneuver.build())"
        command = [sys.executable, "-c", code]
        environment = {**os.environ, "PYTHONPATH": places}
        return subprocess.run(command, capture_output=True, text=True, env=environment, check=False)

    alone, installed = load(), load(tmp_path / "site")
    assert "expected one of 'stop'" in alone.stderr
    assert installed.stdout == "Coning(rate=0.3, transverse_rate=0.2, coning_rate=7.0)\n"


@pytest.mark.jax
def test_a_batch_varies_its_numbers():
    pytest.importorskip("jax")
    rom = tf.reduce(tf.solve_prestress(tf.build_model(parse_case(FILM_CASE))))
    options = {"time_step": 5e-3, "end_time": 0.1, "probes": {"A": (0.2, 0.1)}, "tolerance": 1e-10}
    make, stop, ratios = DAMPINGS["two-ratios"], tf.Stop(0.5, 0.02), [0.01, 0.1]
    many = tf.Batch(rom).simulate({"damping.ratio": ratios}, stop, damping=make(0.02, 1.0, 5.0), **options)
    for run, ratio in enumerate(ratios):
        one = tf.simulate(rom, stop, damping=make(ratio, 1.0, 5.0), **options).data["w"].values
        np.testing.assert_allclose(many["w"].isel(run=run).values, one, atol=1e-8 * np.abs(one).max())


SHAKY = """import tautflex as tf
from dataclasses import dataclass
@tf.register
@dataclass(frozen=True)
class {name}(tf.Maneuver):
    def start(self):
        return tf.AtRest().start()
    def segments(self):
        return (tf.Segment(0.0, float("inf"), lambda time: {motion}),)
"""


@pytest.mark.parametrize(("motion", "words"), [("1 / 0", "ZeroDivisionError"), ("None", "AttributeError")])
def test_a_class_that_misbehaves_in_a_run_is_one_line(motion, words, tmp_path, capsys):
    name = f"Shaky{words[:4]}"
    (tmp_path / "shaky.py").write_text(SHAKY.format(name=name, motion=motion), encoding="utf-8")
    case = f'{FILM_CASE}[maneuver]\nkind = "{name.lower().replace("shaky", "shaky-")}"\n'
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    given = [str(tmp_path / "case.toml"), "--plugin", str(tmp_path / "shaky.py"), "-o", str(tmp_path / "out")]
    assert main(["run", *given]) == 2
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert "--plugin" in said
    assert words in said
    assert "shaky.py" in said
    assert not (tmp_path / "out").exists()


def test_files_of_one_name_in_two_folders_are_two_plugins(tmp_path):
    """The second does not take the place of the first: a name that both register is refused."""
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "same.py").write_text(SHAKY.format(name="Twofold", motion="None"), encoding="utf-8")
    load_plugin(tmp_path / "a" / "same.py")
    with pytest.raises(tf.CaseError, match="'twofold'"):
        load_plugin(tmp_path / "b" / "same.py")
