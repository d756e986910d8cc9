"""Campbell figure, and what `tautflex modes` does about spin and participation."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from tautflex import InputError
from tautflex.cli import main
from tautflex.plot.campbell import branch_name, plot_campbell, save_campbell
from unit.test_plots import drawn

# Square film under equal stress, f_11 = sqrt(2)/2 sqrt(stress/density) = 2.236 Hz.
FILM = """
schema = 1
[membrane]
length = 1.0
width = 1.0
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1500.0
edges = "fixed"
stress_x = 15000.0
stress_y = 15000.0
[mesh]
divisions = [6, 6]
"""


@pytest.fixture
def film(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "film.toml"
    path.write_text(FILM, encoding="utf-8")
    return path


@pytest.fixture
def table() -> xr.Dataset:
    """Three branches, two of which cross; the lowest ends in growth."""
    rate = np.linspace(-1.0, 2.0, 7)
    frequency = np.column_stack([1.0 - 0.25 * rate**2, 1.5 + 0.2 * rate, 1.9 - 0.1 * rate])
    growth = np.zeros_like(frequency)
    frequency[-1, 0], growth[-1, 0] = 0.0, 0.4
    label = np.array([[[1, 1], [2, 1], [0, 0]]] * 7)
    label[-1, 1] = [1, 2]
    dims = ("rate", "branch")
    return xr.Dataset(
        {
            "frequency": (dims, frequency),
            "growth_rate": (dims, growth),
            "label_m": (dims, label[:, :, 0]),
            "label_n": (dims, label[:, :, 1]),
        },
        {"rate": rate, "branch": [1, 2, 3]},
        {"axis": (0.0, 0.6, 0.8)},
    )


def texts_of(figure) -> list[str]:
    figure.canvas.draw()
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_figure_names_branches_and_orders(table):
    figure = plot_campbell(table, orders=(1, 2))
    texts = texts_of(figure)
    assert {"1 (1,1)", "2 (2,1) to (1,2)", "3", "1/rev", "2/rev"} == set(texts)
    assert "(0, 0.6, 0.8)" in figure.axes[0].get_xlabel()
    assert figure.axes[0].get_legend().get_texts()[0].get_text() == "unstable"
    orders = [line for line in figure.axes[0].lines if line.get_linestyle() == ":"]
    for order, line in enumerate(orders, start=1):
        np.testing.assert_allclose(line.get_ydata(), order * np.abs(line.get_xdata()) / (2.0 * np.pi))
    places = sorted(text.get_position()[1] for text in figure.axes[0].texts if "/rev" not in text.get_text())
    assert np.diff(places).min() > 0.05  # names do not overlap
    assert places[0] >= 0.0


@pytest.mark.parametrize("dpi", [100, 150, 200])
def test_names_at_the_ends_stay_in_the_picture(table, dpi):
    """As pages and files draw it, also names that tell of a change of shape and of shapes without half-waves."""
    labels = table["label_m"].values.copy()
    labels[-1, :2], labels[0, 2] = 0, 12
    figure = plot_campbell(table.assign(label_m=(("rate", "branch"), labels)))
    figure.set_dpi(dpi)
    assert {"1 (1,1) to mixed", "2 (2,1) to mixed"} <= set(drawn(figure))


def test_lost_branch_is_not_joined(table):
    links = np.ones(table["frequency"].shape)
    links[4, 1] = 0.2
    figure = plot_campbell(table.assign(mac=(("rate", "branch"), links)), orders=())
    lengths = [len(line.get_xdata()) for line in figure.axes[0].lines if line.get_linestyle() == "-"]
    assert sorted(length for length in lengths if length > 2) == [3, 4, 7, 7]


def test_figure_needs_no_labels_or_growth(table):
    bare = table.drop_vars(["label_m", "label_n", "growth_rate"])
    assert branch_name(bare, 1) == "2"
    assert plot_campbell(bare, orders=()).axes[0].get_legend() is None


def test_figure_is_written(table, tmp_path):
    files = save_campbell(table, tmp_path / "campbell")
    assert [path.name for path in files] == ["campbell.png", "campbell.pdf"]
    assert all(path.stat().st_size > 5000 for path in files)


def test_figure_refuses_what_is_no_table(table):
    with pytest.raises(InputError, match="campbell"):
        plot_campbell(table.isel(rate=0))
    with pytest.raises(InputError, match="orders"):
        plot_campbell(table, orders=(0,))


def test_command_tabulates_draws_and_exports(film, capsys):
    words = "modes film.toml -n 3 --campbell 0:2:3 --axis z --rate 1.0 -o out --participation a.json --point 0,0,-0.5"
    assert main([*words.split(), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    many = found["campbell"]
    assert many["rates"] == [0.0, 1.0, 2.0]
    assert many["axis"] == [0.0, 0.0, 1.0]
    assert np.shape(many["frequencies"]) == (3, 3)
    np.testing.assert_allclose(many["frequencies"][0], found["frequencies"], rtol=1e-6)
    assert many["stable"] == [True] * 3
    np.testing.assert_allclose(found["spinning"]["frequencies"], np.sort(many["frequencies"][1]), rtol=1e-9)
    assert {"modes.png", "campbell.png", "a.json"} == set(found["files"])
    for path in found["files"].values():
        assert (film.parent / path).stat().st_size > 500
    stored = json.loads((film.parent / "a.json").read_text(encoding="utf-8"))
    assert stored["point"] == [0.0, 0.0, -0.5] == found["participation"]["point"]
    assert stored["frequency"] == found["frequencies"]
    assert stored["rigid_mass"][2][2] == pytest.approx(0.15, rel=1e-12)


def test_command_warns_of_growth_and_compression(film, capsys):
    """Little tension and a fast spin about an edge of the film press one side of it together."""
    words = "modes film.toml -n 3 --campbell 0:20:2 --axis z --set maneuver.kind=stop"
    words += " --set maneuver.rate=1.0 --set maneuver.duration=1.0 --set maneuver.origin=[5.0,0.0,0.0]"
    assert main(words.split()) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "warning: unstable at 20 rad/s" in printed
    assert "warning: compressed film at 20 rad/s" in printed
    assert "'tension-field'" in printed
    assert "grows" in printed


def test_command_prints_tables(film, capsys):
    words = "modes film.toml -n 12 --campbell 0:3:2 --axis 0,0.6,0.8 --rate -1 --participation a.csv"
    assert main(words.split()) == 0
    printed = capsys.readouterr().out
    for part in ("spinning at -1 rad/s about (0, 0.6, 0.8)", "branches 1 to", "to 12", "free mass", "a.csv"):
        assert part in printed
    assert "…" not in printed


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--campbell 0:2", "start:stop:count"),
        ("--campbell 0:2:1", "start:stop:count"),
        ("--campbell 1:1:5", "start:stop:count"),
        ("--campbell 0:nan:5", "start:stop:count"),
        ("--axis z", "--campbell or --rate"),
        ("--rate 1 --axis q", "x, y, z or three numbers"),
        ("--rate 1 --axis 1,2", "three numbers"),
        ("--rate 1 --axis 0,0,0", "non-zero length"),
        ("--rate 1 --axis 0,0,inf", "finite"),
        ("--rate inf", "--rate"),
        ("--participation a.txt", ".json"),
        ("--participation missing/a.json", "existing directory"),
        ("--point 0,0,1", "--participation"),
        ("--participation a.json --point 1", "three numbers"),
        ("--rate 1 -n 100000", "refine"),
    ],
)
def test_bad_options_are_named_and_leave_no_file(options, words, film, capsys):
    assert main(["modes", "film.toml", *options.split()]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.out == ""
    assert [path.name for path in film.parent.iterdir()] == ["film.toml"]
