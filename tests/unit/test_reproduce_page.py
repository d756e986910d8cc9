import base64
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from tautflex import InputError
from tautflex.paper.page import reasons, words
from tautflex.paper.page.agreement import comparison, listing, sorted_rows
from tautflex.paper.page.compose import build_page
from tautflex.paper.page.markdown import marked, percent, quantity_text
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import case_words
from tautflex.paper.tables.rows import Row
from tautflex.plot.style import new_figure, save_figure

VOID = {"meta", "img", "br", "hr", "link", "input"}
RATIO = {"response frequency": 1.1, "amplitude": 0.7}  # of the made-up results to the published values


class Checked(HTMLParser):
    """Reads a page; notes what it refers to, and that every tag that opens also closes."""

    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.ids, self.words, self.tables = [], [], [], [], 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.links += [values[name] for name in ("src", "href", "data", "srcset", "action") if name in values]
        self.ids += [values["id"]] if "id" in values else []
        self.tables += tag == "table"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def cells(table):
    """Cells of a table in Markdown, line by line."""
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.split("\n")]


def response_rows(variant="published", factor=1.0):
    rows = []
    for number in published.RESPONSE_TABLES:
        for row in published.table(number):
            case = case_words(row["model"], row["rate_name"], row["duration"])
            for quantity, unit in (("response frequency", "Hz"), ("amplitude", "mm")):
                paper = row[quantity.replace(" ", "_")]
                ours = factor * RATIO[quantity] * paper
                repeats = str(row.get("repeats", ""))
                rows.append(Row(str(number), case, quantity, paper, ours, unit, "", variant, repeats))
    return rows


def extra_rows():
    rows = [
        Row("2", f"mode {row['mode']}", "natural frequency", row["frequency"], 1.01 * row["frequency"], "Hz")
        for row in published.table(2)
    ]
    rows += [Row("3", "rank 1", "number of the normal mode", 4, 4, "1"), Row("3", "rank 1", "MAC", 76.28, 89.1, "%")]
    rows += [Row("4", "M1", "natural frequency of the dominant mode", 0.94, 0.987, "Hz", "a | <note> & more")]
    for case, value in (("M1, pi/5 rad/s, T = 1 s", -2.5), ("M3, pi/5 rad/s, T = 1 s", 1.5)):
        rows.append(Row("compression", case, "smallest principal resultant", None, value, "N/m"))
        rows.append(Row("compression", case, "time of first compression", None, 0.07 if value < 0 else None, "s"))
    case = "M1, pi/5 rad/s, T = 0.1 s"
    rows.append(Row("ablation", f"{case}: everything", "response frequency", None, 1.7166, "Hz"))
    for quantity, value in (
        ("rise over the dominant mode", 0.75),
        ("rise from geometric nonlinearity", 0.7375),
        ("rise from G and K_T", 0.0125),
    ):
        rows.append(Row("ablation", case, quantity, None, value, "Hz"))
    rows.append(Row("convergence", "M2, mode 1", "10 x 5", None, 1.05, "Hz", "", "consistent"))
    for case, frequency, amplitude in (
        ("12 x 6 cells", 0.06, 0.05),
        ("20 x 10 cells", 0.11, 0.1),
        ("half", 0.07, 0.05),
    ):
        rows.append(Row("convergence", case, "Tables 6 to 9, response frequency", None, frequency, "1"))
        rows.append(Row("convergence", case, "Tables 6 to 9, amplitude", None, amplitude, "1"))
    return rows


@pytest.fixture
def rows():
    others = [*response_rows("nearest-node", factor=0.5), *response_rows("consistent", factor=2.0)]
    return [*response_rows(), *others, *extra_rows()]


@pytest.fixture
def written(rows, tmp_path):
    figures = {}
    for number in ("3", "12a"):
        figure = new_figure(3.5, 2.0)
        figure.add_subplot().plot([0, 1])
        figures[number] = save_figure(figure, tmp_path / "figures" / f"figure_{number}", ("pdf", "png"))
    summary = {"quick": True, "seconds": 12.3, "versions": {"tautflex": "9.8.7", "absent": ""}}
    return build_page({"all": rows}, figures, summary, tmp_path / "results", tmp_path / "docs")


def test_files_stand_where_they_are_wanted(written, tmp_path):
    assert written == [tmp_path / "results" / "reproduction.html", tmp_path / "docs" / "reproduction.md"]
    alone = build_page({"all": response_rows()}, {}, {}, tmp_path / "alone")
    assert [path.parent for path in alone] == [tmp_path / "alone"] * 2


def test_html_parses_and_needs_nothing_from_elsewhere(written):
    text = written[0].read_text(encoding="utf-8")
    page = Checked(text)
    assert page.open == []
    assert page.links
    for link in page.links:
        assert link.startswith(("#", "data:image/png;base64,"))
    assert {link[1:] for link in page.links if link.startswith("#")} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert "<script" not in text
    assert "url(" not in text
    assert "@import" not in text
    assert "prefers-color-scheme:dark" in text
    assert 'name="viewport"' in text


def test_html_holds_the_figures_themselves(written, tmp_path):
    pictures = [link for link in Checked(written[0].read_text(encoding="utf-8")).links if link.startswith("data:")]
    expected = [(tmp_path / "figures" / f"figure_{number}.png").read_bytes() for number in ("3", "12a")]
    assert [base64.b64decode(picture.partition(",")[2]) for picture in pictures] == expected


def test_every_table_and_number_is_on_both_pages(written, rows):
    html, markdown = (path.read_text(encoding="utf-8") for path in written)
    page = Checked(html)
    words = " ".join(page.words)
    assert page.tables == 7 + 2 + 1 + 2  # of the paper; ablation in two parts; compression; convergence of two
    for text in (words, markdown):
        for number in ("2", "3", "4", "6", "7", "8", "9"):
            assert f"Table {number}: " in text
        for title in ("What each term does", "Compression of the film", "Convergence in mesh and time step"):
            assert title in text
        for row in rows:
            assert quantity_text(row.ours, row.unit) in text
            assert quantity_text(row.paper, row.unit) in text
        assert "M1, π/2 rad/s, T = 0.1 s" in text
        assert "This is the quick form." in text
        assert "tautflex 9.8.7" in text
        assert "absent" not in text
    assert "a | <note> & more" in words
    assert "a \\| <note> & more" in markdown


def test_markdown_links_figures_from_where_it_stands(written, tmp_path):
    markdown = written[1].read_text(encoding="utf-8")
    links = re.findall(r"!\[[^\]]*\]\(<([^>]+)>\)", markdown)
    assert [(tmp_path / "docs" / link).resolve().name for link in links] == ["figure_3.png", "figure_12a.png"]
    assert all((tmp_path / "docs" / link).is_file() for link in links)


def test_words_take_their_numbers_from_the_rows(rows):
    found = sorted_rows(rows)
    scores = dict(words.scores(found))
    assert "0.095 over 10 entries" in scores["Response frequencies:"]  # log 1.1
    # log 0.55, log 2.2
    assert "The first reading: 0.598. The consistent variant: 0.788." in scores["Response frequencies:"]
    assert "0.357 over 10 entries" in scores["Amplitudes:"]  # -log 0.7
    assert "1.00 %, the largest +1.0 %" in scores["Table 2:"]
    why = dict(reasons.explanations(found))
    follows = why["What follows."]
    assert (
        "0.7500 Hz above the dominant mode; geometric nonlinearity switched off lowers it by 0.7375 Hz"
        in why["Where the rise in frequency comes from."]
    )
    assert "1 of 2 runs, in 1 of the 1 of M1, down to −2.5 N/m (M1, π/5 rad/s, T = 1 s)" in why["Wrinkling."]  # noqa: RUF001
    assert "ours 2.6226 Hz, paper 2.3842 Hz" in why["M1 stopped from π/2 rad/s."]
    assert "In the first reading, where they have it, it is 1.3113 Hz." in why["M1 stopped from π/2 rad/s."]
    assert "on every mesh within a mean |log ratio| of 0.060 to 0.110 in frequency and 0.050 to 0.100" in follows
    assert "with other steps and another method within a mean |log ratio| of 0.070 to 0.070" in follows
    assert "Ours is 0.9870 Hz." in why["M1's dominant mode."]
    assert "0.5 times 1.99 Hz is 0.995 Hz" in why["M1's dominant mode."]
    assert "0.0953674 Hz in Tables 6, 8, 9; 0.0610352 Hz in Table 7" in why["FFT bins."]
    assert "89.10 %, paper 76.28 %" in why["Dominant shape (Table 3)."]


def test_a_frequency_that_other_solvers_change_is_called_chaotic(rows):
    reason, quantity = "M1 stopped from π/2 rad/s.", "M1, pi/2 rad/s, T = 0.1 s, response frequency"
    assert "chaotic" not in dict(reasons.explanations(sorted_rows(rows)))[reason]
    others = {"steps of 2.5 ms": 2.4, "generalized-alpha": 2.3, "8 x 4 cells": 9.0}
    more = [Row("convergence", words, quantity, None, value, "Hz") for words, value in others.items()]
    assert "2.3000 to 2.4000 Hz with other steps" in dict(reasons.explanations(sorted_rows([*rows, *more])))[reason]


def test_gaps_are_listed_worst_first_and_once(rows):
    changed = [replace(row, ours=0.5 * row.paper) if row.table == "9" and row.unit == "mm" else row for row in rows]
    gaps = words.largest_gaps(sorted_rows(changed))
    assert len(gaps) == 10  # every amplitude; the repeated one of Table 8 once
    assert all(lead.startswith("Table 9") and "−50.0 %" in text for lead, text in gaps[:2])  # noqa: RUF001


def test_trends_are_read_off_the_results(rows):
    turned = [replace(row, ours=9 * row.ours) if row.case.startswith("M2, pi/100") else row for row in rows]
    before, after = (dict(words.trends(sorted_rows(some)))["Table 6:"] for some in (rows, turned))
    assert "frequencies yes (1.049, 2.203, 4.301 Hz); amplitudes yes" in before
    assert "frequencies no" in after
    assert "amplitudes no" in after


def test_page_without_results_explains_without_numbers():
    assert words.scores({}) == []
    assert words.trends({}) == []
    assert words.largest_gaps({}) == []
    assert all(text and not re.search(r"\b(None|nan)\b", text) for _, text in reasons.explanations({}))


def test_other_readings_stand_beside():
    rows = response_rows()[:2]
    others = {
        "first reading": response_rows("nearest-node", factor=0.5)[:1],
        "consistent variant": response_rows("consistent", factor=1.1)[:2],
    }
    header, rule, first, second = cells(comparison(rows, others))
    beside = ["first reading", "difference", "consistent variant", "difference"]
    assert header == ["case", "quantity", "ours", "paper", "difference", *beside]
    assert rule == ["---", "---", *["---:"] * 7]
    assert first[4:] == ["+10.0 % *(!)*", "0.5245", "−45.0 % **(!!)**", "1.1540", "+21.0 % **(!!)**"]  # noqa: RUF001
    assert second[5:7] == ["–", "–"]  # noqa: RUF001
    assert "consistent variant" not in comparison(rows)


def test_listing_puts_a_unit_where_it_belongs():
    rows = [
        Row("convergence", "M2: natural frequency", "10 x 5", None, 1.0, "Hz"),
        Row("convergence", "M2: natural frequency", "change", None, 2.0, "%"),
        Row("convergence", "M2: amplitude", "10 x 5", None, 0.25, "mm", "no limit"),
    ]
    (table,) = listing(rows)
    assert cells(table) == [
        ["case", "10 x 5", "change [%]", "note"],
        ["---", "---:", "---:", "---"],
        ["M2: natural frequency", "1.0000 Hz", "2.00", ""],
        ["M2: amplitude", "0.2500 mm", "", "no limit"],
    ]


@pytest.mark.parametrize(
    ("difference", "text"),
    [(0.0499, "+5.0 %"), (-0.2, "−20.0 % *(!)*"), (0.201, "+20.1 % **(!!)**"), (None, "–")],  # noqa: RUF001
)
def test_gaps_are_marked_by_their_size(difference, text):
    assert marked(difference) == text
    assert percent(-1e-6) == "0.0 %"


def test_numbers_are_written_as_the_paper_prints_them():
    assert quantity_text(1.14441, "Hz") == "1.1444"
    assert quantity_text(-1e-7, "Hz") == "0.0000"
    assert quantity_text(-2.5, "N/m") == "−2.5"  # noqa: RUF001
    assert quantity_text(0.0, "s") == "0"
    assert quantity_text(float("nan"), "Hz") == quantity_text(None, "Hz") == "–"  # noqa: RUF001


def test_a_peak_of_another_mode_is_not_called_softening(rows):
    reason = "Where the rise in frequency comes from."
    assert "as softening" not in dict(reasons.explanations(sorted_rows(rows)))[reason]
    case = "M2, pi/5 rad/s, T = 1 s"
    rows += [
        Row("ablation", case, "rise over the dominant mode", None, 0.07, "Hz"),
        Row("ablation", case, "rise from geometric nonlinearity", None, -0.38, "Hz"),
    ]
    text = dict(reasons.explanations(sorted_rows(rows)))[reason]
    assert "In 1 of the 2 cases (M2, π/5 rad/s, T = 1 s)" in text


def test_missing_picture_is_an_input_error(rows, tmp_path):
    with pytest.raises(InputError, match="absent"):
        build_page({"all": rows}, {"3": [tmp_path / "absent.png"]}, {}, tmp_path)
