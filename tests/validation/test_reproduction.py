"""The reproduction of the paper: scores over its tables, and its conclusions on computed numbers.

All runs of section 4 and that of Table 3, in the published reading, with a time step of 2.5 ms (a test of
``test_paper.py`` shows what that changes).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tautflex import build_model, solve_modes, solve_prestress
from tautflex.paper.cases.catalogue import FITTED_MESHES, catalogue, mesh_name, model_case
from tautflex.paper.cases.normal_modes import antenna_modes, antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS, run_name
from tautflex.paper.comparison import build_rows, make_plan, summarize
from tautflex.paper.engine import results
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import response
from tautflex.paper.tables.rows import mean_log_ratio

pytestmark = pytest.mark.slow
TABLES = ("2", "3", "4", "6", "7", "8", "9")
RATES, DURATIONS = ("pi_100", "pi_5", "pi_2"), (0.1, 1.0, 2.0)
FASTEST = ("M1", "pi_2", 0.1)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    trends = [run_name(model, rate, 0.1) for model in MODELS for rate in RATES]
    trends += [run_name(model, "pi_5", duration) for model in MODELS for duration in DURATIONS]
    needed = {spec.name for spec in make_plan(TABLES, trends, quick=True).specs}
    specs = [
        replace(spec, case=spec.case.replaced(solver={"time_step": 2.5e-3}))
        for name, spec in catalogue("published").items()
        if name in needed
    ]
    return results(specs, tmp_path_factory.mktemp("runs"), workers=2)


@pytest.fixture(scope="module")
def plan():
    return make_plan(TABLES, quick=True)


@pytest.fixture(scope="module")
def modes(plan):
    return antenna_modes([*plan.antennas, *(antenna_name(model) for model in MODELS)])


@pytest.fixture(scope="module")
def rows(plan, runs, modes):
    return build_rows(plan, runs, modes)


@pytest.fixture(scope="module")
def answer(runs):
    """Response frequency [Hz] and amplitude [mm] of a run, bins as in Tables 6, 8 and 9."""
    padded = published.about(6)["padded_duration"]
    return lambda *run: (lambda found: (found[0], found[2]))(response(runs[run_name(*run)], padded))


def test_scores_over_the_twenty_numbers(rows, verification_row):
    found = {row.quantity: row.ours for row in summarize(rows)}
    assert sum(not row.repeats for number in "6789" for row in rows["published", number]) >= 20
    for quantity, limit in (("response frequency", 0.09), ("amplitude", 0.08)):
        score = found[f"mean |log ratio|, {quantity}"]
        assert score <= limit
        words = f"Tables 6 to 9, mean |log ratio| of ten numbers: {quantity}"
        verification_row(words, "0", f"{score:.3f}", "paper, Tables 6 to 9", error=f"{score:.3f}")
    assert found["mean |difference|"] <= 1.3  # Table 2 [%]


def test_the_softest_antenna_in_the_fastest_stop(rows, verification_row):
    """The worst entry of the first reading, whose cables hold the film's edge: 1.34 Hz for 2.38."""
    for row in rows["published", "8"]:
        if row.case.startswith("M1, pi/2"):
            assert abs(row.difference) < 0.12
            words = f"M1 stopped from pi/2 rad/s, m2-paper: {row.quantity} [{row.unit}]"
            words += ", chaotic: 2.29 to 2.57 by round-off" if "frequency" in row.quantity else ""
            verification_row(words, row.paper, row.ours, "paper, Table 8")


@pytest.mark.parametrize("cells", FITTED_MESHES)
def test_tensions_are_fitted_to_table_2_on_every_mesh(cells):
    """Changing either of the two by a hundredth does not bring Table 2 closer."""
    printed = np.array([row["frequency"] for row in published.table(2)])

    def difference(x=1.0, y=1.0):
        case = model_case("M2", divisions=cells)
        fitted = case.prestress.resultant_per_pretension
        case = case.replaced(prestress={"resultant_per_pretension": (x * fitted[0], y * fitted[1])})
        return np.abs(solve_modes(solve_prestress(build_model(case)), n=10).frequencies / printed - 1.0).mean()

    assert difference() < 0.021
    assert difference() < min(difference(0.99), difference(1.01), difference(y=0.98), difference(y=1.02)) + 1e-4


def test_other_meshes_and_methods_agree(rows, tmp_path, verification_row):
    """Three runs from linear to strongly nonlinear; all ten of every mesh are on the page of the reproduction."""
    chosen = [("M3", "pi_100", 0.1), ("M1", "pi_50", 0.1), FASTEST]
    names = [run_name(*run) for run in chosen]
    others = {f"{cells[0]} x {cells[1]} cells": [mesh_name(name, cells) for name in names] for cells in FITTED_MESHES}
    del others["20 x 10 cells"]
    others["generalized-alpha"] = [f"{name}/generalized-alpha, steps of 2.5 ms" for name in names]
    known = catalogue("published")
    specs = [known[name] for listed in others.values() for name in listed]
    specs = [replace(spec, case=spec.case.replaced(solver={"time_step": 2.5e-3})) for spec in specs]
    found = results(specs, tmp_path, workers=2)
    printed = [next(row for row in _PRINTED if _same(row, run)) for run in chosen]
    for words, listed in others.items():
        ratios = [
            (f / row["response_frequency"], a / row["amplitude"])
            for name, row in zip(listed, printed, strict=True)
            for f, _, a in (response(found[name], row["padded_duration"]),)
        ]
        for quantity, values, limit in zip(("frequency", "amplitude"), np.log(ratios).T, (0.12, 0.1), strict=True):
            score = float(np.abs(values).mean())
            assert score < limit
            verification_row(f"m2-paper, three runs, {words}: {quantity}", "0", f"{score:.3f}", "paper, Tables 6 to 9")


_PRINTED = [row for number in published.RESPONSE_TABLES for row in published.table(number)]


def _same(row, run):
    return (row["model"], row["rate_name"], row["duration"]) == run


def test_every_published_number_is_listed_with_its_gap(rows):
    for number in published.RESPONSE_TABLES:
        listed = rows["published", str(number)]
        for quantity in ("response frequency", "amplitude"):
            printed = [row[quantity.replace(" ", "_")] for row in published.table(number)]
            assert [row.paper for row in listed if row.quantity == quantity] == printed
        assert all(row.ours is not None and row.difference is not None for row in listed)


def test_large_gaps_are_explained(rows):
    listed = [row for number in "6789" for row in rows["published", number]]
    quantities = ("response frequency", "amplitude")
    worst = [row for row in listed if row.quantity in quantities and abs(row.log_ratio) > 0.2]
    assert len(worst) <= 2
    assert all(row.note for row in worst)


def test_scores_follow_from_the_rows(rows):
    """The score is the mean over unrepeated rows, recomputed here by hand."""
    listed = [row for number in "6789" for row in rows["published", number] if not row.repeats]
    ratios = [abs(row.log_ratio) for row in listed if row.quantity == "amplitude"]
    assert len(ratios) == 10
    assert mean_log_ratio(listed, "amplitude") == pytest.approx(sum(ratios) / 10, rel=1e-12)


def test_table_3_is_led_by_the_mode_of_one_by_two_half_waves(rows):
    table = rows["published", "3"]
    first = next(row for row in table if row.quantity == "MAC")
    assert first.note.endswith("(1,2)")
    assert first.ours > 70.0


@pytest.mark.parametrize("model", MODELS)
def test_amplitude_and_frequency_rise_with_the_rate(answer, model):
    """Conclusion 1: the larger the velocity and acceleration, the larger amplitude and frequency."""
    found = [answer(model, rate, 0.1) for rate in RATES]
    amplitudes = [amplitude for _, amplitude in found]
    assert amplitudes == sorted(amplitudes)
    assert len(set(amplitudes)) == 3
    frequencies = [frequency for frequency, _ in found]
    assert frequencies == sorted(frequencies)


@pytest.mark.parametrize("model", MODELS)
def test_amplitude_falls_with_the_duration(answer, model):
    """Conclusion 1: at the same velocity a shorter stop (larger acceleration) gives more amplitude and frequency."""
    found = [answer(model, "pi_5", duration) for duration in DURATIONS]
    amplitudes = [amplitude for _, amplitude in found]
    assert amplitudes == sorted(amplitudes, reverse=True)
    assert found[0][0] >= max(found[1][0], found[2][0])


@pytest.mark.parametrize(("rate", "duration"), [("pi_100", 0.1), ("pi_5", 0.1), ("pi_5", 1.0), ("pi_5", 2.0)])
def test_stiffer_antennas_respond_faster_and_less(answer, rate, duration):
    """Conclusion 2: frequency rises and amplitude falls with the fundamental frequency."""
    frequencies, amplitudes = zip(*(answer(model, rate, duration) for model in MODELS), strict=True)
    assert list(frequencies) == sorted(frequencies)
    assert list(amplitudes) == sorted(amplitudes, reverse=True)


@pytest.mark.parametrize(("rate", "duration"), [("pi_5", 0.1), ("pi_5", 1.0)])
def test_coupling_is_stronger_for_softer_antennas(answer, modes, rate, duration):
    """Conclusion 3: the increment over the dominant mode, relative to it, grows as the antenna gets softer."""
    increments = []
    for model in MODELS:
        own = modes[antenna_name(model)]
        natural = frequency_of(own, dominant_mode(own))
        increments.append(answer(model, rate, duration)[0] / natural - 1.0)
    assert increments[0] > increments[1] > increments[2]


def test_the_initial_velocity_counts_more_than_the_duration(answer):
    """Table 9: of two stops with the same acceleration the faster one swings further."""
    assert answer("M1", "pi_5", 1.0)[1] > 1.2 * answer("M1", "pi_50", 0.1)[1]
