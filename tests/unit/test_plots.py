import subprocess
import sys
from unittest import mock

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

from tautflex import InputError, plot
from tautflex.plot.style import styled


def drawn(figure):
    """Render a figure and check that it shows something and that no text leaves it; return its texts."""
    original, shown = Text.draw, {}

    def record(text, renderer, *args):
        if text.get_visible() and text.get_text().strip():
            shown[text] = text.get_window_extent(renderer)
        return original(text, renderer, *args)

    with mock.patch.object(Text, "draw", record):  # labels of ticks out of range exist and are not drawn
        figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
    assert np.mean(np.any(pixels < 250, axis=2)) > 0.02
    width, height = figure.bbox.size
    outside = [
        str(text)
        for text, box in shown.items()
        if box.x0 < -1 or box.y0 < -1 or box.x1 > width + 1 or box.y1 > height + 1
    ]
    assert shown
    assert outside == []
    return [text.get_text() for text in shown]


def test_the_style_can_be_entered_again_and_within_itself(antenna_modes):
    before = matplotlib.rcParams["font.size"]
    for _ in range(2):
        with styled:
            plot.plot_modes(antenna_modes, count=1)
            assert matplotlib.rcParams["font.size"] == 9
    assert matplotlib.rcParams["font.size"] == before


def test_a_notebook_shows_a_figure_as_a_picture(antenna_modes):
    """Also where pyplot was never imported, as in a cell that ends with ``tf.plot.plot_modes(modes)``."""
    assert plot.plot_modes(antenna_modes, count=1)._repr_png_().startswith(b"\x89PNG")


def test_modes(antenna_modes):
    texts = drawn(plot.plot_modes(antenna_modes, count=4))
    assert "mode 4   1.99 Hz   (1,2) SA" in texts
    assert "mode 1   1.00 Hz   (1,1) SS" in texts
    assert not any(text.startswith("mode 5") for text in texts)


def test_modes_without_label_symmetry_cables_or_frame(antenna_modes):
    bare = antenna_modes.drop_vars(["cable", "beam"]).assign(
        label_m=("mode", [0] * 6), label_n=("mode", [0] * 6), symmetry=("mode", ["--"] * 6)
    )
    assert "mode 2   1.25 Hz" in drawn(plot.plot_modes(bare, count=2))


def test_cables_alone_are_drawn(antenna_modes):
    assert "mode 1   1.00 Hz   (1,1) SS" in drawn(plot.plot_modes(antenna_modes.drop_vars("triangle"), count=1))


def test_surface_marks_the_level_and_starts_from_a_plane():
    time = 0.01 * np.arange(400)
    found = {name: ("time", np.zeros(400)) for name in ("surface_tilt_x", "surface_tilt_y", "surface_piston")}
    found["surface_rms"] = ("time", np.where(time > 0.0, 1e-3 * np.exp(-time), 0.0))
    run = xr.Dataset(found, coords={"time": time}, attrs={"maneuver_end": 1.0, "surface_tolerance": 5e-5})
    texts = drawn(plot.plot_surface(run))
    assert "rms about the best plane [mm]" in texts
    assert {"0.05 mm", "maneuver ends at 1 s"} <= set(texts)
    assert "0.02 mm" in drawn(plot.plot_surface(run, 2e-5))
    with pytest.raises(InputError, match="tolerance: expected"):
        plot.plot_surface(run, 0.0)
    with pytest.raises(InputError, match="run: expected one of a structure with film"):
        plot.plot_surface(run.assign(surface_rms=run["surface_rms"] + np.nan))


def test_shapes_share_one_scale(antenna_run):
    figure = plot.plot_shapes(antenna_run, times=[0.0, 0.15, 0.79])
    texts = drawn(figure)
    times = [text for text in texts if text.startswith("$t$")]
    assert times == ["$t$ = 0 s", "$t$ = 0.15 s", "$t$ = 0.8 s"]
    assert any("[mm]" in text and "1000" in text for text in texts)
    drawn_fields = antenna_run["displacement"].sel(field_time=[0.0, 0.15, 0.8])
    largest = 1e3 * float(np.abs(drawn_fields).max())
    assert figure.axes[-1].get_xlim() == pytest.approx((-largest, largest))


def test_shapes_choose_a_readable_factor(antenna_run):
    huge = antenna_run.assign(displacement=40 * antenna_run["displacement"])
    assert any("20" in text for text in drawn(plot.plot_shapes(huge, times=[0.8])) if "drawn" in text)
    resting = antenna_run.assign(displacement=0 * antenna_run["displacement"])
    drawn(plot.plot_shapes(resting, times=[0.8]))


def test_history_shows_the_record_in_millimetres_and_the_end_of_the_maneuver(antenna_run):
    figure = plot.plot_time_history(antenna_run, ["B"])
    texts = drawn(figure)
    assert "displacement $w$ [mm]" in texts
    assert "time $t$ [s]" in texts
    assert "maneuver ends at 1 s" in texts
    line = figure.axes[0].lines[0]
    np.testing.assert_allclose(line.get_ydata(), 1e3 * antenna_run["w"].sel(probe="B"))


def test_history_compares_runs(antenna_run):
    texts = drawn(plot.plot_time_history({"M1": antenna_run, "M2": 2 * antenna_run}, ["A"], span=(0, 3)))
    assert {"M1", "M2"} <= set(texts)


def test_maneuver_that_never_ends_is_not_marked(antenna_run):
    spinning = antenna_run.assign(angular_velocity=antenna_run["angular_velocity"] * 0 + 0.6)
    assert not any("maneuver" in text for text in drawn(plot.plot_time_history(spinning)))


def test_spectrum_marks_the_peak_and_natural_frequencies(antenna_run, antenna_modes):
    figure = plot.plot_spectrum(antenna_run, ["A"], natural_frequencies=antenna_modes["frequency"])
    texts = drawn(figure)
    assert "point A: peak 2.014 Hz, bins of 0.061 Hz" in texts  # 33 bins of 1/16.384 s
    assert {"1", "2", "3", "4-6"} <= set(texts)
    with pytest.raises(InputError, match="natural_frequencies: expected"):
        plot.plot_spectrum(antenna_run, ["A"], natural_frequencies=antenna_modes)
    still = antenna_run.assign(w=0 * antenna_run["w"])
    assert "point A" in drawn(plot.plot_spectrum(still, ["A"]))
    turning = drawn(plot.plot_spectrum(antenna_run.assign_attrs(maneuver_end=1e3), ["A"]))
    assert {"point A", "during the maneuver"} <= set(turning)


def test_scalogram(antenna_run):
    short = antenna_run.isel(time=slice(None, None, 20))
    texts = drawn(plot.plot_scalogram(short, "A"))
    assert "frequency $f$ [Hz]" in texts
    assert "amplitude of $w$ at A [mm]" in texts
    liveliest = short["probe"].values[int(np.abs(short["w"]).max("time").values.argmax())]
    assert f"amplitude of $w$ at {liveliest} [mm]" in drawn(plot.plot_scalogram(short))


def test_supports_are_drawn(antenna_modes):
    corners = antenna_modes["beam"].values.ravel()[:4]
    held = plot.plot_modes(
        antenna_modes.drop_vars("held", errors="ignore").assign(held=("held_node", corners)), count=1
    )
    drawn(held)
    marks = [line for line in held.axes[0].lines if line.get_marker() == "^"]
    assert [len(line.get_data_3d()[0]) for line in marks] == [4]


@pytest.mark.slow
def test_files_are_written_and_equal_figures_give_equal_files(antenna_run, tmp_path):
    first = plot.save_time_history(antenna_run, tmp_path / "one" / "history.v1", formats=("png", "pdf", "svg"))
    assert [path.name for path in first] == ["history.v1.png", "history.v1.pdf", "history.v1.svg"]
    assert first[0].read_bytes().startswith(b"\x89PNG")
    assert first[1].read_bytes().startswith(b"%PDF")
    assert b"<svg" in first[2].read_bytes()
    again = plot.save_time_history(antenna_run, tmp_path / "two" / "history", formats=("png", "pdf", "svg"))
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in again]


def test_saving_needs_a_known_format_and_leaves_nothing(antenna_run, tmp_path):
    with pytest.raises(InputError, match="formats"):
        plot.save_spectrum(antenna_run, tmp_path / "spectrum", formats=("png", "bmp"))
    assert list(tmp_path.iterdir()) == []


def test_global_settings_are_left_alone(antenna_run):
    before = dict(matplotlib.rcParams)
    plot.plot_time_history(antenna_run)
    assert dict(matplotlib.rcParams) == before


@pytest.mark.slow
def test_matplotlib_is_imported_only_when_used():
    code = "import sys, tautflex.plot; assert 'matplotlib' not in sys.modules; tautflex.plot.plot_modes; "
    code += "assert 'matplotlib' in sys.modules and 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda run: plot.plot_time_history(run, ["C"]), "'A', 'B'"),
        (lambda run: plot.plot_time_history(run, component="x"), "component"),
        (lambda run: plot.plot_time_history(run, span=(2, 1)), "span"),
        (lambda run: plot.plot_shapes(run, times=[9.0]), "times"),
        (lambda run: plot.plot_shapes(run, magnification=0.0), "magnification"),
        (lambda run: plot.plot_shapes(run.drop_dims("field_time")), "fields"),
        (lambda run: plot.plot_modes(run), "solve_modes"),
        (lambda run: plot.plot_scalogram(run, "C"), "'A', 'B'"),
    ],
)
def test_what_is_missing_is_named(call, words, antenna_run):
    with pytest.raises(InputError, match=words):
        call(antenna_run)
