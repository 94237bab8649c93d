"""The table writer: HTML, Markdown, CSV, terminal."""

import csv
import html
import io
import math
import re
import sys
import types

import pandas as pd
import pytest

from helmbench.reporting import tables
from helmbench.reporting.numbers import number
from helmbench.reporting.tables import Cell, Column, Table, field, make_table

from ..support.hostile_texts import HOSTILE

ROWS = [
    {"name": "a|b", "error": 0.123456, "note": "<b>"},
    {"name": "c", "error": math.inf, "note": ""},
    {"name": "d", "error": None, "note": "x" * 60},
]
COLUMNS = [field("name"), Column("error", lambda row: number(row["error"]), lambda row: row["error"]), field("note")]


@pytest.fixture
def table():
    return make_table(COLUMNS, ROWS, "Errors", kind=lambda row: row["name"])


def test_columns_that_say_nothing_are_left_out():
    found = make_table(COLUMNS, [{"name": "a", "error": None, "note": ""}])
    assert found.columns == ("name",)


def test_html_shows_the_text_and_sorts_by_the_value(table):
    text = str(tables.html(table))
    assert "&lt;b&gt;" in text and "<b>" not in text
    assert re.findall(r'data-key="([^"]*)" class="number"', text) == ["0.123456", "1e999", ""]
    assert 'data-kind="a|b"' in text and text.count("<tr") == 4 and text.count(" long") == 1
    cells = [html.unescape(cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", text)]
    assert cells == [cell.text for row in table.rows for cell in row]


def test_markdown_has_one_line_a_row_and_the_same_bars_in_each(table):
    lines = tables.markdown(table).splitlines()
    assert len(lines) == 5 and {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {4}
    assert lines[2].startswith("| a\\|b | 0.123 | &lt;b&gt;") and re.fullmatch(r"\| -+ \| -+: \| -+ \|", lines[1])


def test_csv_holds_the_values(table):
    rows = list(csv.DictReader(io.StringIO(tables.csv(table))))
    assert [row["error"] for row in rows] == ["0.123456", "inf", ""] and rows[0]["name"] == "a|b"


def test_csv_of_a_frame_is_that_of_pandas():
    frame = pd.DataFrame(
        {"a": [1, 2], "b": [0.1, math.nan], "c": ["x,y", None], "d": [True, False], "e": [1e-17, 3.0], "f": [None, 2]}
    )
    assert tables.csv(tables.from_frame(frame)) == frame.to_csv(index=False, lineterminator="\n")


def test_the_terminal_aligns_columns(table):
    lines = tables.console(table, indent="  ").splitlines()
    assert lines[0] == "  name  error  note" and lines[1] == "  a|b   0.123  <b>" and lines[2] == "  c       inf"


def test_the_terminal_leaves_out_empty_titles():
    found = Table(("", ""), ((Cell("a"), Cell("bb")), (Cell("aaa"), Cell("b"))))
    assert tables.console(found) == "a    bb\naaa  b"


def test_ready_made_markdown_is_taken_as_it_is():
    column = Column("x", lambda row: row, markdown=lambda row: f"[{row}]({row}.md)")
    found = make_table([column], ["page"])
    assert ">page<" in tables.html(found) and "[page](page.md)" in tables.markdown(found)
    assert tables.csv(found) == "x\npage\n"


@pytest.mark.parametrize(
    "text", ["=1+2", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "\uff1d1+2", "\uff20SUM(A1)", "\uff0d2"]
)
def test_a_text_is_no_formula_in_csv(text):
    found = tables.csv(Table(("a", "b"), ((Cell(text), Cell("x", text)),)))
    assert list(csv.reader(io.StringIO(found)))[1] == ["'" + text.replace("\r", " ")] * 2


@pytest.mark.parametrize(
    ("before", "after"), [("x", ";=1"), ("5", ";\t @A"), ("x", "\n-2+3"), ("x;y", "\t+1"), ("x", "; \uff1d1")]
)
def test_no_part_of_a_text_is_a_formula_where_semicolons_separate(before, after):
    ((_, cell),) = csv.reader(
        io.StringIO(tables.csv(Table(("a", "b"), ((Cell("1"), Cell(before + after)),))).partition("\n")[2])
    )
    assert cell == f"{before}{after[0]}'{after[1:]}"


@pytest.mark.parametrize(("cell", "value"), [(Cell("-1.5"), "-1.5"), (Cell("x", -1.5), "-1.5"), (Cell("-inf"), "-inf")])
def test_numbers_stay_numbers_in_csv(cell, value):
    assert tables.csv(Table(("a",), ((cell,),))).splitlines()[1] == value


def test_foreign_texts_are_no_markup_in_markdown():
    assert tables.in_markdown("a\n# b [c](d) <i> `e` *f*") == r"a \# b \[c\](d) \<i\> \`e\` \*f\*"
    assert "](" not in tables.markdown(Table(("a",), ((Cell("[x](javascript:y)"),),)))


def test_hostile_texts_are_one_cell_of_a_table():
    """In Markdown a row has the bars of its cells alone, read as GitHub does; no form has a tag that is not its own."""
    unescaped = re.compile(r"\\.|\|")
    for text in (
        *(text for texts in HOSTILE.values() for text in texts),
        "a|b",
        "a\\|b",
        "\\\\|",
        "`a|b`",
        "[a](b)",
        "![a](b)",
    ):
        table = Table(("a", "b"), ((Cell(text), Cell("x")),))
        _, _, *rows = tables.markdown(table).split("\n")
        bars = [found for found in unescaped.findall(rows[0]) if found == "|"]
        assert len(rows) == 1 and len(bars) == 3 and "](" not in rows[0], text
        assert not re.search(r"<[a-zA-Z/!?]", rows[0])
        tags = [
            re.findall(r"<[^>]*>", tables.html(Table(("a", "b"), ((Cell(t), Cell("x")),))))
            for t in ("x" * len(text), text)
        ]
        assert [re.split("[ >]", tag)[0] for tag in tags[0]] == [re.split("[ >]", tag)[0] for tag in tags[1]], text


@pytest.mark.parametrize(
    ("width", "kept", "left_out"), [(200, 3, ""), (20, 2, "Not shown: note."), (3, 1, "error, note")]
)
def test_a_terminal_shows_the_columns_that_it_has_room_for_and_names_the_others(
    table, monkeypatch, width, kept, left_out
):
    monkeypatch.setenv("COLUMNS", str(width))
    whole = tables.console(table, fit=True)
    assert whole == tables.console(table)
    monkeypatch.setattr(sys, "stdout", types.SimpleNamespace(isatty=lambda: True))
    first, *lines = tables.console(table, fit=True).splitlines()
    assert first.split() == ["name", "error", "note"][:kept] and left_out in lines[-1]
