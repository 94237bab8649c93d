"""A page of blocks in every medium: order, what is folded, what says nothing, what is foreign."""

import re
from html import unescape

import numpy as np
import pytest

from helmbench.models.errors import BadInput
from helmbench.reporting.media import html, markdown, notebook, terminal
from helmbench.reporting.open.views import view_of
from helmbench.reporting.page import (
    FAIR,
    QUESTIONS,
    Drawing,
    Note,
    Section,
    Verdict,
    items,
    overlays,
    pairs,
    result_page,
)
from helmbench.reporting.plots import svg
from helmbench.reporting.runs import RecordRuns, figure_of, key_of, lines_of
from helmbench.reporting.tables import Column, make_table

FOREIGN = "<b>*a*</b>"


def record(name, role):
    time = np.arange(60.0)
    heading = np.deg2rad(175.0 + time)
    measured = {"heading_rad": np.arctan2(np.sin(heading), np.cos(heading))}
    runs = {name: {"heading_rad": heading + 0.01 + 4.0 * np.pi} for name in ("base model", "extended model")}
    return RecordRuns(name, role, time, np.zeros(60), measured, runs)


@pytest.fixture(scope="module")
def page():
    first, each = overlays([record("trained", "train"), record("kept", "held_out")])
    table = make_table([Column("name", lambda row: row), Column("length", lambda row: str(len(row)), len)], ["a", "bc"])
    drawn = Drawing("line", "A line", lambda: svg(lambda figure: figure.subplots().plot([1, 2], [3, 4])))
    return result_page(
        "Result", "of a test", Verdict(FAIR, "It is so.", ("Because.", FOREIGN), "named"), doubts=["a doubt"],
        seen=[first, table], changed=[items(["alone", ("a cause", "its size")]), Note("how to read it")],
        remains=[None, items([]), Note("nothing to read")], following=["Sail on.", drawn],
        details=[
            Section("Facts", (pairs([("a name", "a value")]),)), Section("Nothing", (items([]), Note("of it"))), each,
        ],
    )  # fmt: skip


def test_parts_that_say_nothing_are_left_out(page):
    assert [(part.title, part.folded) for part in page.parts] == [
        (QUESTIONS[0], False), (QUESTIONS[1], False), (QUESTIONS[3], False),
        ("Facts", True), ("Every record, with errors", True),
    ]  # fmt: skip


def test_every_medium_begins_with_the_sentence_and_says_what_is_open(page):
    shown = {"html": html(page), "notebook": notebook(page), "terminal": terminal(page)}
    shown["markdown"] = markdown(page, "Title", "A note.", {"line": "line.svg"})
    for text in shown.values():
        assert "Named. It is so." in text and "a doubt" in text
        places = [text.index(said) for said in ("It is so.", "bc", "a cause", "Sail on.")]
        assert places == sorted(places)
    assert shown["terminal"].splitlines()[:2] == ["Result: Named. It is so.", "doubtful: a doubt"]
    assert all(FOREIGN not in shown[medium] for medium in ("html", "notebook"))
    assert FOREIGN in shown["terminal"] and r"\*a\*" in shown["markdown"]


def test_what_is_folded_is_on_pages_alone(page):
    folded = "a value"
    assert folded not in terminal(page) and folded not in notebook(page)
    assert re.search(rf"<details.*{folded}", html(page), re.DOTALL)
    assert re.search(rf"<details>.*{folded}.*</details>", markdown(page, "", "", {}), re.DOTALL)


def test_series_are_not_published(page):
    text = markdown(page, "", "", {"line": "line.svg"})
    assert "![A line](line.svg)" in text and "kept" not in text and "<svg" not in text
    assert html(page).count("<svg") == 1 + 1 + 2  # the held-out record, the line; each record with its errors


def test_a_page_as_plain_values_has_the_same_parts(page):
    view = view_of(page)
    assert [part["title"] for part in view["parts"]] == [*QUESTIONS[:2], QUESTIONS[3], "Facts"]
    assert [block["kind"] for block in view["parts"][0]["blocks"]] == ["runs", "table"]
    assert [trace["record"] for trace in view["traces"]] == ["trained", "kept"]
    assert view["told"] == ["Because.", FOREIGN, "a doubt"]


def test_headings_are_continuous_and_begin_together(page):
    lines = lines_of(page.records()[0], "heading_rad")
    assert np.ptp(np.diff(lines.measured)) < 1e-9 and lines.unit == "deg"
    np.testing.assert_allclose(lines.errors["base model"], -np.rad2deg(0.01), atol=1e-9)


def test_the_last_run_is_drawn_solid(page):
    (_, first, _), (name, base, dashed), (last, extended, solid) = key_of(page.records())
    assert (name, last, dashed, solid) == ("base model", "extended model", True, False)
    assert len({first, base, extended}) == 3 and f"border-color:{extended}" in unescape(html(page))


def test_a_figure_is_of_the_held_out_record_or_of_the_named_one(page):
    titles = [figure_of(page.records(), name, "result").get_suptitle() for name in (None, "trained")]
    assert titles == ["free runs along kept", "free runs along trained"]
    with pytest.raises(BadInput, match="the result has no such record"):
        figure_of(page.records(), "other", "result")
