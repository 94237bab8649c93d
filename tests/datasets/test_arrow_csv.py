"""CSV by Arrow: the same numbers, texts and refusals as the readers and writers that look at each cell."""

import builtins
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helmbench.datasets import arrow_csv, io
from helmbench.datasets.arrow_csv import columns_of_numbers, short_text, write_csv
from helmbench.datasets.record import Record
from helmbench.models.errors import BadInput

NAMES = ["time_s", "rudder_rad", "heading_rad"]
CELLS = ["", "0", "-0.0", "nan", "NaN", "-nan", "+nan", "inf", "-Infinity", "nan(1)", "1e999", "1e-400", "5e-324",
         " 1.5", "1.5 ", "\t2", "007", "0x1f", "1_000", "1,5", "1d5", "+5", ".5", "5.", "1e", "-", "n/a", '"1.5"',
         '1"5', "'1'",
         "\u0661", "\u00a01", "0." + "1" * 400, "9" * 400, "12345678901234567890.123456789", "#", "1 2"]  # fmt: skip
ENDS = ["\n", "\r\n", "\r", "\n\n", " \n", ",\n", ";\n"]


def outcome(path, monkeypatch, fewest):
    """The columns that are read, or the refusal, where files of `fewest` bytes are read by Arrow."""
    monkeypatch.setattr(io, "FEWEST_BYTES", fewest)
    try:
        return {name: values.tobytes() for name, values in canonical_gaps(io.read_table(path)).items()}
    except BadInput as error:
        return str(error)


def canonical_gaps(columns):
    return {name: np.where(np.isnan(values), np.nan, values) for name, values in columns.items()}


def write_rows(path, rows, end="\n", delimiter=","):
    text = end.join(delimiter.join(row) for row in [NAMES, *rows]) + end
    path.write_bytes(text.encode())


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("cell", CELLS)
def test_a_cell_is_read_as_by_the_careful_reader(tmp_path, monkeypatch, cell, delimiter):
    path = tmp_path / "trial.csv"
    for place in range(3):
        write_rows(
            path, [["0", "1", "2"], [*["3"] * place, cell, *["4"] * (2 - place)], ["5", "6", "7"]], "\n", delimiter
        )
        assert outcome(path, monkeypatch, 0) == outcome(path, monkeypatch, math.inf)


@pytest.mark.parametrize("end", ENDS)
def test_line_ends_and_trailing_separators(tmp_path, monkeypatch, end):
    path = tmp_path / "trial.csv"
    write_rows(path, [["0", "1", "2"], ["1", "", ""], ["2", "3", "4"]], end)
    assert outcome(path, monkeypatch, 0) == outcome(path, monkeypatch, math.inf)


@pytest.mark.parametrize("row", [["1"], ["1", "2"], ["1", "2", "3", "4"], ["1", "2", "3", ""], [""], ["", "", ""]])
def test_rows_of_another_length(tmp_path, monkeypatch, row):
    path = tmp_path / "trial.csv"
    write_rows(path, [["0", "1", "2"], row, ["2", "3", "4"]])
    assert outcome(path, monkeypatch, 0) == outcome(path, monkeypatch, math.inf)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(allow_infinity=False), min_size=1, max_size=30))
def test_numbers_are_written_and_read_as_the_same(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("written") / "trial.csv"
    columns = {name: np.array(values) for name in NAMES}
    assert write_csv(columns, path)
    header, *lines = path.read_text().split("\n")
    assert header == ",".join(NAMES)
    assert lines == [*(",".join([short_text(value)] * 3) for value in values), ""]
    found = columns_of_numbers(path.read_bytes()[len(header) :], NAMES, ",")
    assert found is not None
    assert {k: v.tobytes() for k, v in canonical_gaps(found).items()} == {
        k: v.tobytes() for k, v in canonical_gaps(columns).items()
    }


@pytest.mark.parametrize("size", [10.0**e for e in range(-12, 19)])
def test_every_size_is_written_as_python_does(tmp_path, rng, size):
    values = np.concatenate([size * rng.uniform(-1.0, 1.0, 200), [size, -size, np.nextafter(size, 0.0)]])
    write_csv({"time_s": values, "rudder_rad": np.round(values)}, tmp_path / "trial.csv")
    expected = [
        f"{short_text(a)},{short_text(b)}" for a, b in zip(values.tolist(), np.round(values).tolist(), strict=True)
    ]
    assert (tmp_path / "trial.csv").read_text().splitlines()[1:] == expected


def test_long_records_are_the_same_without_arrow(tmp_path, monkeypatch, rng):
    n = max(arrow_csv.FEWEST_ROWS, 12_000)
    channels = {"rudder_rad": rng.normal(size=n), "heading_rad": np.where(rng.random(n) < 0.1, np.nan, rng.random(n))}
    record = Record(np.arange(n) * 0.1, channels, name="trial")
    io.write_record(record, tmp_path / "fast.csv")
    assert (tmp_path / "fast.csv").stat().st_size > arrow_csv.FEWEST_BYTES
    read = io.read_table(tmp_path / "fast.csv")
    monkeypatch.setattr(builtins, "__import__", without_arrow(builtins.__import__))
    assert arrow_csv.arrow() is None
    io.write_record(record, tmp_path / "careful.csv")
    assert (tmp_path / "fast.csv").read_bytes() == (tmp_path / "careful.csv").read_bytes()
    careful = io.read_table(tmp_path / "careful.csv")
    for name, values in careful.items():
        np.testing.assert_array_equal(read[name], values)


def without_arrow(real):
    def load(name, *rest, **more):
        if name.startswith("pyarrow"):
            raise ImportError(name)
        return real(name, *rest, **more)

    return load
