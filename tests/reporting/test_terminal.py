"""Reports on a narrow terminal: fewer columns, shorter cells, nothing wrapped inside a cell."""

import sys

import pytest

from helmbench.cli._shared import show_text
from helmbench.reporting.tables import Column, field, make_table, markdown
from helmbench.reporting.terminal import fitted

ROWS = [{"method": "output-error", "rank": 1.5, "error": 0.012, "vessels": "a, b | c"} for _ in range(3)]
TABLE = markdown(
    make_table(
        [
            field("method"),
            Column("mean rank", lambda row: str(row["rank"]), lambda row: row["rank"]),
            Column("error", lambda row: str(row["error"]), lambda row: row["error"]),
            field("vessels"),
            field("vessels", "vessels again"),
        ],
        ROWS,
    )
)
TEXT = f"# Title\n\nSome words of a sentence that is longer than forty characters.\n\n{TABLE}\n\n- one item with words"


def test_what_fits_is_unchanged():
    assert fitted(TEXT, 200) == TEXT


@pytest.mark.parametrize("width", [20, 30, 40, 50, 60, 70, 80])
def test_no_line_is_longer_than_the_terminal(width):
    lines = fitted(TEXT, width).split("\n")
    table = [line for line in lines if line.startswith("|")]
    assert max(map(len, table)) <= max(width, 12) and len(table) == 2 + len(ROWS)
    assert len({len(line) for line in table}) == 1 and all(line.endswith("|") for line in table)
    assert all(len(line) <= width for line in lines if not line.startswith("|"))


def test_the_last_columns_go_first_and_are_named():
    text = fitted(TEXT, 40)
    assert "| method       | mean rank | error |" in text and "| output-error |       1.5 | 0.012 |" in text
    assert "Not shown: vessels, vessels again." in text


def test_long_cells_are_shortened_where_few_columns_are_left():
    text = fitted(TEXT, 34)
    assert "Not shown: vessels, vessels again." in text.replace("\n", " ")
    assert "| output-er… |       1.5 | 0.012 |" in text


def test_numbers_stay_at_the_right_and_escaped_bars_inside_their_cell():
    text = fitted(TEXT, 55)
    assert "---: |" in text and r"a, b \| c |" in text and "Not shown: vessels again." in text


def test_only_a_terminal_gets_fewer_columns(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "40")
    show_text(TEXT)
    assert capsys.readouterr().out == TEXT + "\n"
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    show_text(TEXT)
    assert capsys.readouterr().out == fitted(TEXT, 40) + "\n"
