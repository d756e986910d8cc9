import numpy as np
import pytest

from tautflex import InputError, dominant_frequency
from tautflex.paper.cases.catalogue import catalogue
from tautflex.paper.cases.run_names import DURATIONS, MODELS, RATES, run_name
from tautflex.paper.figures.histories import about_equilibrium
from tautflex.paper.figures.index import FIGURES, save_figures
from tautflex.paper.figures.trends import DURATION_TREND, RATE_TREND
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import response
from unit.test_plots import drawn

PAPER_ORDER = ["3", "4", "5a", "5b", "5c", "6", "7", "8", "9a", "9b", "10", "11", "12a", "12b", "13a", "13b"]
DRAWINGS = ("3", "4", "7")  # shapes in space, without axes


@pytest.fixture
def modes(antenna_modes):
    return dict.fromkeys(MODELS, antenna_modes)


@pytest.fixture
def runs(antenna_run):
    """Each run with an amplitude of its own, so that curves can be told apart."""
    short = antenna_run.isel(time=slice(None, None, 20))
    names = sorted({name for figure in FIGURES.values() for name in figure.needs})
    return {name: short.assign(w=(1 + k) * short["w"]) for k, name in enumerate(names)}


def test_every_figure_of_the_paper_is_there_in_its_order():
    assert list(FIGURES) == PAPER_ORDER


def test_every_run_that_a_figure_needs_is_in_the_catalogue():
    known = set(catalogue("published"))
    assert {name for figure in FIGURES.values() for name in figure.needs} <= known


@pytest.mark.parametrize("number", PAPER_ORDER)
@pytest.mark.slow
def test_figure_draws_whole_with_units(number, runs, modes):
    needed = {name: runs[name] for name in FIGURES[number].needs}  # and no run that it does not declare
    figure = FIGURES[number].draw(needed, modes)
    texts = drawn(figure)  # fails if any text leaves the page
    if number in DRAWINGS:
        assert any("displacement" in text for text in texts)
        return
    axes = figure.axes[0]
    # Panels one below the other share theirs.
    for label in (
        figure.axes[0].get_xlabel() or figure.axes[-1].get_xlabel(),
        axes.get_ylabel() or figure.get_supylabel(),
    ):
        assert label.endswith("]")
        assert "[" in label
    if number[-1] in "abc":
        assert axes.get_title(loc="left").startswith(f"({number[-1]})")
    assert figure.get_size_inches()[0] == pytest.approx(3.5)  # one column


def test_figure_4_has_the_twelve_panels_of_the_paper(runs, modes):
    texts = drawn(FIGURES["4"].draw(runs, modes))
    titles = [text for text in texts if text.startswith("(")]
    assert [title[1] for title in titles] == list("abcdefghijkl")
    assert titles[0].endswith("uniform rotation")
    assert titles[1].endswith("= 0 s")
    assert titles[-1].endswith("= 1.85 s")
    assert any("1000" in text and "[mm]" in text for text in texts)


def test_figure_4_says_which_instant_is_missing(runs, modes):
    name = FIGURES["4"].needs[0]
    late = runs[name].isel(field_time=slice(None, -3))
    with pytest.raises(InputError, match=r"t = 1\.55 s"):
        FIGURES["4"].draw({name: late}, modes)


def test_figure_7_names_the_mode_it_resembles(runs, modes):
    texts = drawn(FIGURES["7"].draw(runs, modes))  # the field of the run is exactly the shape of mode 4
    assert any("MAC with mode 4: 100.0 %" in text for text in texts)


def test_histories_show_the_records(runs, modes):
    figure = FIGURES["8"].draw(runs, modes)
    panels = {text.get_text(): axes for axes in figure.axes for text in axes.texts if text.get_text() in MODELS}
    assert list(panels) == list(MODELS)  # one below the other
    for model, axes in panels.items():
        expected = 1e3 * runs[run_name(model, "pi_100", 0.1)]["w"].sel(probe="A")
        np.testing.assert_allclose(axes.lines[0].get_ydata(), expected)


def test_details_are_scaled_to_the_slower_stops(runs, modes):
    slow = max(float(np.abs(runs[run_name("M3", "pi_5", T)]["w"].sel(probe="A")).max()) for T in (1.0, 2.0))
    axes = FIGURES["9b"].draw(runs, modes).axes[0]
    assert axes.get_ylim() == pytest.approx((-1.2e3 * slow, 1.2e3 * slow))


def stated(places, along):
    """Where models that stand side by side are meant to be."""
    near = np.asarray(list(along))
    return [float(near[np.abs(np.log(near / x)).argmin()]) for x in places]


@pytest.mark.parametrize(("number", "quantity"), [("12a", "response_frequency"), ("13b", "amplitude")])
def test_trends_mark_the_published_values(number, quantity, runs, modes):
    axes = FIGURES[number].draw(runs, modes).axes[0]
    open_markers = [line for line in axes.lines if line.get_markerfacecolor() == "none"]
    along = RATES.values() if number == "12a" else DURATIONS
    found = {
        pair for line in open_markers for pair in zip(stated(line.get_xdata(), along), line.get_ydata(), strict=True)
    }
    drawn_at = [tuple(pair) for line in open_markers for pair in zip(*line.get_data(), strict=True)]
    assert len(set(drawn_at)) == len(drawn_at)
    expected = set()
    for table in (6, 7, 8, 9):
        for row in published.table(table):
            if number == "12a" and row["duration"] == 0.1:
                expected.add((row["rate"], row[quantity]))
            if number == "13b" and row["rate"] == RATES["pi_5"]:
                expected.add((row["duration"], row[quantity]))
    assert found == expected


def test_trends_follow_the_runs(runs, modes):
    axes = FIGURES["13a"].draw(runs, modes).axes[0]
    ours = [line for line in axes.lines if line.get_linestyle() == "-"]
    for line, cases in zip(ours, RATE_TREND.values(), strict=True):
        expected = [1e3 * np.abs(runs[name]["w"].sel(probe="A")).max() for name in cases.values()]
        np.testing.assert_allclose(
            (stated(line.get_xdata(), RATES.values()), line.get_ydata()), (list(cases), expected)
        )


def test_trend_frequencies_use_the_bins_of_the_table_that_prints_the_run(runs, modes):
    record = runs[DURATION_TREND["M3"][1.0]]
    axes = FIGURES["12b"].draw(runs, modes).axes[0]
    ours = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert ours[2].get_ydata()[1] == pytest.approx(round(ours[2].get_ydata()[1] * 16.384) / 16.384)  # Table 7
    assert ours[0].get_ydata()[1] == pytest.approx(round(ours[0].get_ydata()[1] * 10.48576) / 10.48576)  # Table 9
    alone = dominant_frequency(record["w"].sel(probe="A"), length=16.384, after=1.0).frequency
    assert response(record, 16.384)[0] == alone


def test_vibration_about_the_equilibrium_has_no_mean_on_either_side(antenna_run):
    record = about_equilibrium(antenna_run["w"], 1.0)
    assert record.dims == antenna_run["w"].dims
    for part in (record.sel(time=slice(0.0, 0.999)), record.sel(time=slice(1.0, None))):
        np.testing.assert_allclose(part.mean("time"), 0.0, atol=1e-12)
    whole = about_equilibrium(antenna_run["w"], None)
    np.testing.assert_allclose(whole.mean("time"), 0.0, atol=1e-12)


@pytest.mark.slow
def test_files_are_written_in_every_format(runs, modes, tmp_path):
    written = save_figures(["5a"], runs, modes, tmp_path / "figures")
    assert [path.name for path in written["5a"]] == ["figure_5a.pdf", "figure_5a.svg", "figure_5a.png"]
    assert all(path.stat().st_size > 1000 for path in written["5a"])


def test_missing_runs_and_unknown_figures_are_named(modes, tmp_path):
    with pytest.raises(InputError, match="published/M2/pi_5/T1"):
        save_figures(["5b"], {}, modes, tmp_path)
    with pytest.raises(InputError, match="'9a', '9b'"):
        save_figures(["14"], {}, modes, tmp_path)
