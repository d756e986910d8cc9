"""Studies: points and their files, what is refused and what is labelled, and the Dataset in the end."""

from __future__ import annotations

import json
import tomllib
import warnings

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from tautflex.case import STUDY, Case, parse_case, template, template_files
from tautflex.case.prepared import structure_key
from tautflex.cli import main
from tautflex.study import work
from tautflex.study.axes import unit_of, values_of, with_keys
from tautflex.study.measures import UNITS, flattened
from tautflex.study.points import Grid
from tautflex.study.sections import Span
from tautflex.study.store import Store, case_key
from tautflex.study.sweep import make_plan
from unit.study_cases import FILM, film_study


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def swept(folder):
    return tf.sweep(film_study(names=()), folder)


def test_shape_units_and_files(swept, folder):
    assert dict(swept.sizes) == {"maneuver.rate": 3, "damping.beta": 2}
    assert (swept["status"] == "completed").all()
    assert swept["probes.A.amplitude"].dims == ("maneuver.rate", "damping.beta")
    units = {name: swept[name].attrs.get("units") for name in swept.variables}
    assert units["probes.A.amplitude"] == units["surface.rms_max"] == "m"
    assert (units["maneuver.rate"], units["damping.beta"]) == ("rad/s", "s")
    assert units["energy_balance.maneuver"] == "J"
    assert all(name in units for name in ("natural_frequencies.9", "min_principal_resultant", "surface.settling_time"))
    assert tf.load(folder / "study.nc").drop_attrs().equals(swept.drop_attrs())
    head, *rows = (folder / "table.csv").read_text(encoding="utf-8").splitlines()
    assert head.startswith("maneuver.rate [rad/s],damping.beta [s],probes.A.amplitude [m]")
    assert len(rows) == 6
    assert len(list(folder.glob("points/*/*.json"))) == 6


def test_a_point_is_the_run_of_its_case(swept):
    """Points that share a structure share what is made of it; the numbers are those of a run alone, to the digit."""
    case = parse_case(FILM, ["maneuver.rate=0.2", "damping.beta=0.002"])
    run = tf.run_case(case)
    point = swept.sel({"maneuver.rate": 0.2, "damping.beta": 0.002})
    assert float(point["probes.A.amplitude"]) == float(np.abs(run.data["w"].sel(probe="A")).max())
    assert float(point["energy_balance.strain"]) == run.energy_balance["strain"]
    assert float(point["time_error"]) == run.error
    state = tf.solve_prestress(tf.build_model(case))
    np.testing.assert_allclose(point["natural_frequencies.0"], tf.solve_modes(state, n=10).frequencies[0], rtol=1e-12)


def test_finished_points_are_looked_up(swept, folder, monkeypatch):
    monkeypatch.setattr(work, "simulated", lambda *given: pytest.fail("performed again"))
    again = tf.sweep(film_study(names=()), folder)
    assert again.attrs["resumed"] == 6
    assert again.drop_attrs().equals(swept.drop_attrs())


def test_more_values_use_the_points_that_are_there(swept, folder):
    plan = make_plan(film_study((0.05, 0.1, 0.2, 0.3), names=()), folder)
    assert (plan.resumed, len(plan.todo)) == (6, 2)


def test_points_of_one_structure_are_together(tmp_path):
    """The structure is what takes long: whatever the order of the axes, it is made once for all its points."""
    axes = {"damping.beta": [0.0, 1e-3, 2e-3], "membrane.stress_x": [4000.0, 4400.0]}
    plan = make_plan(film_study(axes=axes), tmp_path)
    assert plan.structures() == [[0, 2, 4], [1, 3, 5]]
    assert [number for chunk in plan.chunks(2) for number in chunk] == [0, 2, 4, 1, 3, 5]


def test_damaged_points_are_computed_again(tmp_path):
    first = tf.sweep(film_study((0.1,)), tmp_path)
    cut, empty = tmp_path.glob("points/*/*.json")
    cut.write_bytes(cut.read_bytes()[:40])
    empty.write_bytes(b"")
    again = tf.sweep(film_study((0.1,)), tmp_path)
    assert again.attrs["resumed"] == 0
    assert again.drop_attrs().equals(first.drop_attrs())


def test_failed_points_are_labelled_and_the_others_done(tmp_path):
    """A negative damping is no case; a frame rate of 1e9 rad/s breaks the run itself."""
    study = film_study(axes={"damping.beta": [0.0, -1.0], "maneuver.rate": [0.1, 1e9]})
    found = tf.sweep(study, tmp_path)
    assert found["status"].sel({"damping.beta": 0.0, "maneuver.rate": 0.1}) == "completed"
    assert (found["status"].sel({"damping.beta": -1.0}) == "invalid").all()
    assert "damping.beta" in str(found["message"].values[1, 0])
    broken = found.isel({"damping.beta": 0, "maneuver.rate": 1})
    assert str(broken["status"].values) in ("invalid", "not-converged")
    assert str(broken["message"].values)
    assert np.isnan(found["probes.A.amplitude"].values[1]).all()
    assert tf.sweep(study, tmp_path).drop_attrs().equals(found.drop_attrs())


def test_what_breaks_for_no_known_reason_is_tried_again(tmp_path, monkeypatch):
    study = film_study((0.1,))
    with monkeypatch.context() as patch:
        patch.setattr(work, "measures_of", lambda *given: [][0])
        found = tf.sweep(study, tmp_path)
    assert (found["status"] == "failed").all()
    assert "IndexError" in str(found["message"].values.ravel()[0])
    assert (tf.sweep(study, tmp_path)["status"] == "completed").all()


def test_interruption_keeps_what_is_finished(tmp_path):
    def stop(fraction: float, message: str) -> None:
        if fraction > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tf.sweep(film_study(), tmp_path, progress=stop)
    assert len(list(tmp_path.glob("points/*/*.json"))) == 3
    found = tf.sweep(film_study(), tmp_path)
    assert found.attrs["resumed"] == 3
    assert found.drop_attrs().equals(tf.sweep(film_study(), tmp_path / "fresh").drop_attrs())


def test_axes_that_change_together_are_one_dimension(tmp_path):
    rates, spans = [0.1, 0.2], [0.05, 0.1]
    study = film_study(axes={"maneuver.rate": rates, "maneuver.duration": spans},
                       zip=[["maneuver.rate", "maneuver.duration"]])  # fmt: skip
    found = tf.sweep(study, tmp_path)
    assert dict(found.sizes) == {"maneuver.rate": 2}
    assert found["maneuver.duration"].dims == ("maneuver.rate",)
    head = (tmp_path / "table.csv").read_text(encoding="utf-8").partition("\n")[0]
    assert head.startswith("maneuver.rate [rad/s],maneuver.duration [s],probes.A.amplitude [m]")
    alone = tf.run_case(parse_case(FILM, ["maneuver.rate=0.2", "maneuver.duration=0.1"]))
    assert float(found["probes.A.amplitude"][1]) == float(np.abs(alone.data["w"]).max())


@pytest.mark.slow
def test_records_are_whole_runs(tmp_path):
    study = film_study((0.1,), measures={"names": ["probes.A.amplitude"], "records": True})
    found = tf.sweep(study, tmp_path)
    for path in tmp_path.glob("points/*/*.nc"):
        amplitude = float(np.abs(tf.load(path)["w"]).max())
        assert amplitude in found["probes.A.amplitude"].values
        path.unlink()
    assert tf.sweep(study, tmp_path).attrs["resumed"] == 0


@pytest.mark.slow
def test_texts_and_lists_as_values(tmp_path):
    study = film_study(axes={"maneuver.axis": [[1, 0, 0], [0, 1, 0]], "coupling.euler": [True, False]})
    found = tf.sweep(study, tmp_path)
    assert found["maneuver.axis"].values.tolist() == ["[1, 0, 0]", "[0, 1, 0]"]
    assert tf.load(tmp_path / "study.nc").drop_attrs().equals(found.drop_attrs())
    tf.plot.plot_study(found)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"axes": {"maneuver.rat": [0.1]}}, "axes.maneuver.rat: unknown key .* did you mean 'rate'"),
        ({"axes": {"manoeuvre.rate": [0.1]}}, "did you mean 'maneuver'"),
        ({"axes": {"maneuver.rate": []}}, "axes.maneuver.rate: expected a list of values .* got an empty list"),
        ({"axes": {"maneuver.rate": 0.1}}, "axes.maneuver.rate: expected a list of values"),
        ({"axes": {"maneuver.rate": {"from": 0.1, "to": 0.2}}}, "axes.maneuver.rate.count: missing"),
        ({"axes": {}}, "axes: missing"),
        ({"axes": {"maneuver.rate.x": [0.1]}}, "one inside 'rate', a value"),
        ({"axes": {"masses.0.mass": [0.1]}}, "masses"),
        ({"axes": {"maneuver": [{}], "maneuver.rate": [0.1]}}, "expected no axis inside another"),
        ({"axes": {"maneuver.rate": ["fast", "slow"]}}, "expected at least one valid point, got none: maneuver.rate"),
        ({"zip": [["maneuver.rate", "damping.beta"]]}, "equally many values .* 3 of maneuver.rate, 2 of damping.beta"),
        ({"zip": [["maneuver.rat", "damping.beta"]]}, "zip.maneuver.rat: unknown key .* did you mean 'maneuver.rate'"),
        ({"measures": {"names": ["probes.B.amplitude"]}}, "did you mean 'probes.A.amplitude'"),
        ({"measures": {"names": ["settling_time.attitude"]}}, "measures.names: expected measures of the run's JSON"),
        ({"engine": {"kind": "bach"}}, "engine.kind: expected one of"),
        ({"engine": {"kind": "batch"}, "measures": {}}, "engine.kind: expected measures.names of probes alone"),
        ({"engine": {"kind": "batch"}, "axes": {"solver.end_time": [0.2]}}, "engine.kind: expected axes of numbers"),
        ({"engine": {"kind": "serial", "scheduler": "tcp://a:1"}}, "scheduler: expected none"),
        ({"base": "nowhere.toml"}, "base: nowhere.toml: no such file"),
    ],
)  # fmt: skip
def test_refused_before_anything_runs(tmp_path, more, words):
    with pytest.raises(tf.CaseError, match=words) as caught:
        tf.sweep(film_study(**more), tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"version": "0.0.1", "code": "other"}, r"got those of version 0\.0\.1; choose another folder, or --force"),
        ([], r"got no such file or a damaged one \(TypeError\); --force"),
        (None, r"code\.json: expected the version .* \(FileNotFoundError\); --force .* computes others anew"),
    ],
)
def test_points_of_another_or_an_unknown_version_are_refused(tmp_path, said, words):
    tf.sweep(film_study((0.1,)), tmp_path)
    mark = tmp_path / "points" / "code.json"
    mark.unlink()
    if said is not None:
        mark.write_text(json.dumps(said), encoding="utf-8")
    with pytest.raises(tf.CaseError, match=words):
        tf.sweep(film_study((0.1,)), tmp_path)
    assert tf.sweep(film_study((0.1,)), tmp_path, force=True).attrs["resumed"] == 2


def test_no_scheduler_at_the_address(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    from tautflex.study.engines import dask

    monkeypatch.setattr(dask, "_PATIENCE", "1s")
    with pytest.raises(tf.InputError, match=r"expected a Dask scheduler at tcp://127\.0\.0\.1:9, got no answer"):
        tf.sweep(film_study((0.1,)), tmp_path, scheduler="tcp://127.0.0.1:9")
    assert not list(tmp_path.iterdir())


def test_keys_cover_the_case_its_files_and_the_code(tmp_path, monkeypatch):
    """A table that changes under its name is another case, and motion alone no other structure."""
    table = tmp_path / "slew.csv"
    table.write_text("time,rate\n0,0.1\n1,0.0\n", encoding="utf-8")
    text = FILM.replace('kind = "stop"\nrate = 0.1\nduration = 0.05', f'kind = "tabulated"\nfile = "{table}"')
    case = parse_case(text)
    before = case_key(case)
    assert case_key(parse_case(text)) == before
    table.write_text("time,rate\n0,0.2\n1,0.0\n2,0.0\n", encoding="utf-8")
    assert case_key(case) != before
    stop = parse_case(FILM)
    assert structure_key(stop) == structure_key(case)
    assert structure_key(stop.replaced(membrane={"stress_x": 4001.0})) != structure_key(stop)
    assert structure_key(stop.replaced(reduction={"count": 5})) != structure_key(stop)


def test_a_half_written_point_is_none(tmp_path):
    store = Store(tmp_path)
    store.write("ab12", {"status": "completed", "message": "", "measures": {}})
    assert store.read("ab12")["status"] == "completed"
    assert store.read("ab13") is None
    store.path("ab13").write_bytes(store.path("ab12").read_bytes())  # of another point
    assert store.read("ab13") is None
    assert Store(tmp_path, records=True).read("ab12") is None


def test_sections_that_no_axis_changes_are_checked_once():
    """The cases are those of whole tables, defaults that depend on an axis of another section too."""
    base = {"membrane": {"length": 2.0, "width": 1.0, "thickness": 1e-4, "youngs_modulus": 3.5e9,
                         "poisson_ratio": 0.34, "density": 1530.0, "edges": "fixed", "stress_x": 4e3, "stress_y": 4e3},
            "mesh": {"divisions": [6, 4]}, "prestress": {}, "solver": {"time_step": 1e-3}}  # fmt: skip
    steps = [[{"membrane.edges": "fixed"}, {"membrane.edges": "scalloped", "edge_cords.area": 1e-6,
              "edge_cords.youngs_modulus": 1e9, "edge_cords.density": 1e3,
              "edge_cords.sag": 0.1, "frame.length": 2.5, "frame.width": 1.5,
              "frame.youngs_modulus": 3e9, "frame.poisson_ratio": 0.3, "frame.density": 1e3, "frame.area": 1e-4,
              "frame.inertia_y": 1e-7, "frame.inertia_z": 1e-7, "frame.torsion_constant": 1e-7,
              "cables.youngs_modulus": 1e9, "cables.area": 1e-6, "cables.density": 1e3, "cables.per_long_edge": 3,
              "cables.per_short_edge": 3}]]  # fmt: skip
    points = Grid(base, steps)
    assert [points.case(number).prestress.mode for number in (0, 1)] == ["uniform", "equilibrium"]
    for number in (0, 1):
        whole = Case(**with_keys(base, points.values(number)))
        assert points.case(number) == whole
        assert case_key(points.case(number)) == case_key(whole)
    assert points.case(0).solver is points.case(1).solver


def many_axes(*lengths):
    """Study whose amplitude counts the points; the first one failed."""
    names, count = ["maneuver.duration", "maneuver.rate", "damping.beta", "damping.alpha"], int(np.prod(lengths))
    dims = names[: len(lengths)]
    values, status = np.arange(float(count)), np.full(count, "completed", dtype="U9")
    values[0], status[0] = np.nan, "failed"
    variables = {"probes.A.amplitude": (dims, values.reshape(lengths)), "status": (dims, status.reshape(lengths))}
    coordinates = {name: np.arange(1.0, length + 1) for name, length in zip(dims, lengths, strict=True)}
    return xr.Dataset(variables, coordinates)


@pytest.mark.parametrize(
    ("lengths", "titles"),
    [
        ((3,), [""]),
        ((3, 2), ["probes.A.amplitude"]),
        ((3, 2, 2), [f"probes.A.amplitude\nmaneuver.duration = {n}" for n in (1, 2, 3)]),
        ((30, 2, 2), [f"probes.A.amplitude\nmaneuver.duration = {n}" for n in range(1, 31, 3)]),
        ((2, 1, 2, 2), [f"probes.A.amplitude\nmaneuver.duration = {n}\nmaneuver.rate = 1" for n in (1, 2)]),
    ],
)
def test_figures_of_one_axis_and_more(lengths, titles):
    """Lines, maps, and maps of slices, at most twelve, on one scale; every panel has room for its axes."""
    study = many_axes(*lengths)
    figure = tf.plot.plot_study(study)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # "axes sizes collapsed to zero"
        figure.canvas.draw()
    panels = [panel for panel in figure.axes if panel.get_visible() and panel.get_label() != "<colorbar>"]
    assert [panel.get_title() for panel in panels] == titles
    assert min(panel.get_position().width * figure.get_figwidth() for panel in panels) > 0.6
    if len(lengths) > 1:
        scales = {shades.get_clim() for panel in panels for shades in panel.collections}
        assert scales == {(1.0, np.prod(lengths) - 1.0)}
        names = list(study["status"].dims)
        for ticks, name in ((panels[0].get_yticks(), names[-2]), (panels[0].get_xticks(), names[-1])):
            if study[name].dtype.kind == "f":
                assert ticks[0] == study[name].values[0]
                assert set(ticks) <= set(study[name].values)


def test_values_and_keys():
    even = values_of(Span(**{"from": 0.1, "to": 0.3, "count": 3}))
    assert (even[0], even[2]) == (0.1, 0.3)
    np.testing.assert_allclose(even, [0.1, 0.2, 0.3], rtol=1e-15)
    np.testing.assert_allclose(values_of(Span(**{"from": 1, "to": 100, "count": 3, "spacing": "log"})), [1, 10, 100])
    values = {"a": {"b": 1}, "c": [{"d": 1}, {"d": 2}]}
    assert with_keys(values, {"a.b": 2, "c.1.d": 3, "e.f": 4}) == {
        "a": {"b": 2}, "c": [{"d": 1}, {"d": 3}], "e": {"f": 4}
    }  # fmt: skip
    assert values == {"a": {"b": 1}, "c": [{"d": 1}, {"d": 2}]}
    assert (unit_of("cables.pretension_x"), unit_of("maneuver.duration"), unit_of("x.y")) == ("N", "s", "")
    assert flattened({"a": {"b": [1, None]}, "c": "text", "seconds": 2.0}) == {"a.b.0": 1.0, "a.b.1": None}


def test_every_measure_has_its_unit(swept):
    known = {name for name in swept.data_vars if name not in ("status", "message")}
    assert all(swept[name].attrs["units"] for name in known)
    assert len(UNITS) == 20


def test_the_template_is_a_study_of_its_case(tmp_path, capsys):
    assert main(["init", str(tmp_path / "s.toml"), "--template", "study"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"s.toml", *template_files(STUDY)}
    study = tf.load_study(tmp_path / "s.toml")
    assert study.count == 12
    assert set(tomllib.loads(template(STUDY))) == {"schema", "base", "axes", "measures", "engine", "design"}
    capsys.readouterr()
    assert main(["sweep", str(tmp_path / "s.toml"), "-o", str(tmp_path / "out"), "--dry-run", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["points"], answer["done"], answer["failed"]) == (12, 0, 0)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_command(tmp_path, capsys):
    (tmp_path / "film.toml").write_text(FILM, encoding="utf-8")
    study = tmp_path / "s.toml"
    study.write_text('base = "film.toml"\n[axes]\n"damping.beta" = [0.0, -1.0]\n', encoding="utf-8")
    asked = "--workers", "1", "--json", "--format", "png", "--format", "pdf"
    assert main(["sweep", str(study), "-o", str(tmp_path / "out"), *asked]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert {name: answer[name] for name in ("points", "done", "failed", "resumed")} == {
        "points": 2, "done": 1, "failed": 1, "resumed": 0
    }  # fmt: skip
    assert set(answer["files"]) == {"study", "table", "sweep.png", "sweep.pdf"}
    assert all((tmp_path / "out" / name).is_file() for name in ("study.nc", "table.csv", "sweep.png", "sweep.pdf"))
    assert main(["sweep", str(study), "--workers", "0"]) == 2
    assert "--workers: expected a number >= 1" in capsys.readouterr().err


def test_the_page_of_the_docs_has_the_keys():
    from pathlib import Path

    from tautflex.case.help.reference import markdown
    from tautflex.study.reference import study_reference

    page = (Path(__file__).parents[2] / "docs" / "studies.md").read_text(encoding="utf-8")
    assert markdown(study_reference(), whole=False) in page, "put in what `tautflex keys study --markdown` prints"
