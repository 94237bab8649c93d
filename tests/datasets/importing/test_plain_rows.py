"""Logs whose rows are plain are read at once: the same cells, numbers, line numbers and faults as line by line."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helmbench.datasets.arrow_csv import arrow_texts
from helmbench.datasets.importing import clock
from helmbench.datasets.importing import text as text_logs
from helmbench.datasets.importing.cells import GAPS, Texts, decorated, numbers_of
from helmbench.datasets.importing.text import read_text
from helmbench.models.errors import BadInput

HEADER = "time [s],heading [deg],rudder [deg],note"
CELLS = ["1.5", "-0.25", "+5", ".5", "5.", "1e3", "1E-2", "007", "0x1f", "1_000", "1d5", "inf", "-inf", "1e999", "nan",
         "NaN", "+nan", "", " ", " 2 ", "\t3", "-", "--", "n/a", "NULL", "...", "*", "?", "12.5 P", "3 kn",
         "54.5N", "abc", "12-",
         "'1'", "1'000", "9" * 40, "0." + "1" * 60, "1 234", "2024-05-03", "12:00:01", "1:2",
         "#", "%", "// x", "!", "(1)"]  # fmt: skip
COMMAS = [
    "1,5",
    "12,345",
    "1.234,5",
    "0,5",
    "012,345",
    "1234,567",
    ",5",
    "5,",
    "1,2,3",
    "1.5",
    "7",
    "-3,25",
    "1,5e3",
    "-1,5-",
    "",
]

ROWS = ["1", "1,2", "1,2,3,4,5", "1,2,3,ok,", ",,,", " , ,,", ",", "", "   ", HEADER, "s,deg,deg,-", "# note",
        ";x,1,2,3", '"1",2,3,ok', "1,2,3,\u00e4", "1,2,3,\x0b", "1,2,3,\x1c4", "1,2," + "9" * 6000 + ",ok",
        "a,b,c,d"]  # fmt: skip
STAMPS = ["2024-02-30 00:00:00", "2023-02-29T00:00:00", "2024-13-01T00:00:00", "2024-01-01T24:00:00",
          "2024-01-00T00:00:00", "2024-01-01T00:00:60", "2024-01-01T00:00:00z", "2024/01/01 00:00:00",
          "2024-01-01T00:00:00.", "0000-01-01 00:00:00", "2024-01-01T00:00:00,5", "2024-01-01",
          "2024-01-01T00:00:00+01:00", "2024-01-01T0a:00:00"]  # fmt: skip


def facts(text, fewest, monkeypatch):
    """All that a table says, with each text and number; or the refusal."""
    monkeypatch.setattr(text_logs, "FEWEST_BYTES", fewest)
    try:
        table = read_text(text, "utf-8", Path("log.csv"))
    except BadInput as error:
        return str(error)
    columns = [
        (c.name, c.unit, c.known, c.style, list(c.values), c.numbers.tobytes(), c.cells.unit, c.cells.positive,
         c.missing, c.bad.tolist(), c.first(5), c.numeric, c.texts.unique(), c.texts.coded()[1].tolist(),
         c.at([0, 3])[1])
        for c in table.columns if c.texts is not None
    ]  # fmt: skip
    return columns, table.rows.tolist(), table.faults, table.done, table.notes


def check_same(text, monkeypatch):
    assert facts(text, 0, monkeypatch) == facts(text, math.inf, monkeypatch)


def log(cells, separator=",", end="\n", header=HEADER):
    rows = [
        [f"{0.5 * i}", f"{i % 7}.25", cell, "ok"]
        for i, cell in enumerate([*["1.25", "-3.5"] * 8, *cells, *["2.5"] * 4])
    ]
    return end.join([header.replace(",", separator), *(separator.join(row) for row in rows)]) + end


def reads_plain(text, monkeypatch):
    """Whether all rows of a text are read at once."""
    seen = []
    real = text_logs._plain_rows
    monkeypatch.setattr(text_logs, "_plain_rows", lambda *given: seen.append(real(*given)) or seen[-1])
    facts(text, 0, monkeypatch)
    return bool(seen) and seen[-1] is not None


@pytest.mark.parametrize("cell", CELLS)
def test_a_cell_is_read_as_line_by_line(monkeypatch, cell):
    check_same(log([cell]), monkeypatch)
    check_same(log([cell] * 30), monkeypatch)


@pytest.mark.parametrize("separator", [";", "\t", "|", ",", " "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\n\n", " \n", "{}\n"])
def test_separators_and_line_ends(monkeypatch, separator, end):
    check_same(log(["1.0", "", "nan"], separator, end.format(separator)), monkeypatch)


@pytest.mark.parametrize("cell", COMMAS)
def test_decimal_commas_and_thousands(monkeypatch, cell):
    rows = [f"{i},5;{i % 7},25;{c};ok" for i, c in enumerate([*["1,25"] * 8, cell, *["2,5"] * 4])]
    check_same("\n".join([HEADER.replace(",", ";"), *rows]), monkeypatch)


@pytest.mark.parametrize("row", ROWS)
@pytest.mark.parametrize("last", [False, True])
def test_rows_that_are_none_of_the_data(monkeypatch, row, last):
    text = log([])
    check_same(text + row + ("" if last else "\n" + "99,1,2,ok\n"), monkeypatch)


def test_plain_logs_are_read_at_once(monkeypatch):
    assert reads_plain(log(["1.0", "", "n/a", "-"]), monkeypatch)
    assert reads_plain("\n\n# by hand\n" + log(["1"]) + "99,1\n", monkeypatch)
    assert reads_plain(log(["1"], ";", ";\r\n"), monkeypatch)
    assert not reads_plain(log(['"1"']), monkeypatch)
    assert not reads_plain(log(["1"]) + HEADER + "\n" + "99,1,2,ok\n", monkeypatch)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from([*CELLS, *COMMAS, "1.5", "2.5", "3.25"]), min_size=1, max_size=40))
def test_texts_of_arrow_are_the_same_numbers(cells):
    for style in ("point", "comma", "open"):
        plain, careful = Texts.of_arrow(arrow_texts(cells)), Texts(cells)
        assert numbers_of(plain, style).tobytes() == numbers_of(careful, style).tobytes()
        one, other = (decorated(texts, "rudder", style) for texts in (plain, careful))
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            assert one.numbers.tobytes() == other.numbers.tobytes() and one.unit == other.unit
    np.testing.assert_array_equal(plain.among(GAPS), careful.among(GAPS))


@pytest.mark.parametrize("mark", ["T", " "])
@pytest.mark.parametrize("zone", ["", "Z"])
@pytest.mark.parametrize("decimals", [0, 1, 3, 6, 9])
def test_even_stamps_are_those_of_each_text(rng, mark, zone, decimals):
    moments = rng.integers(-8e9, 7e9, 200).astype("datetime64[s]")
    ends = ["." + "".join(map(str, rng.integers(0, 10, decimals))) if decimals else "" for _ in moments]
    texts = [str(moment).replace("T", mark) + end + zone for moment, end in zip(moments, ends, strict=True)]
    found = Texts.of_arrow(arrow_texts(texts)).moments()
    assert found is not None
    assert found.tobytes() == clock._moments(Texts(texts), "iso").tobytes()


@pytest.mark.parametrize("stamp", STAMPS)
def test_other_stamps_are_the_same_by_arrow(stamp):
    texts = [stamp] * 3
    found, careful = (clock._moments(own, "iso") for own in (Texts.of_arrow(arrow_texts(texts)), Texts(texts)))
    assert found.tobytes() == careful.tobytes()
