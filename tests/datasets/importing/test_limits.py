"""Lines, cells and columns that no log has are refused before they are taken apart word by word."""

from io import BytesIO
from pathlib import Path

import pandas as pd
import pytest

from helmbench.datasets.importing import binary_tables
from helmbench.datasets.importing.sources import read_raw
from helmbench.models.errors import BadInput

ROWS = "\n".join(f"{i},{i % 7},{i % 5},{i % 3}" for i in range(50))
EXTREMES = {
    "a cell of digits": ("time,rudder,heading,speed\n0," + "1" * 40_000 + f",0,0\n{ROWS}", "row 2: a cell of 40000"),
    "brackets": ("time," + "[" * 200_000 + f",heading,speed\n{ROWS}", "row 1: a cell of 200000"),
    "pairs of brackets": ("time,r " + "(" * 100_000 + ")" * 100_000 + f",heading,speed\n{ROWS}", "a cell of 200000"),
    "columns": (",".join(f"c{i}" for i in range(200_000)) + "\n1,2,3\n", "row 1: 200000 cells"),
    "columns by spaces": (" ".join(["x"] * 200_000) + "\n1 2 3\n", "row 1: 200000 cells"),
    "keys of JSON": ("{" + ", ".join(f'"k{i}": {i}' for i in range(400_000)) + "}", "no JSON objects"),
    "a quoted cell": ('time,rudder\n"' + "a b " * 50_000 + f'",2\n{ROWS}', "row 2: .* cells|row 2: a cell of"),
    "quotes": ("time,rudder\n" + '"' * 400_000 + f"\n{ROWS}", "row 2: a cell of 400000"),
}


@pytest.mark.parametrize("name", EXTREMES)
def test_what_no_log_has_is_refused(name, tmp_path):
    text, said = EXTREMES[name]
    file = tmp_path / "log.csv"
    file.write_text(text)
    with pytest.raises(BadInput, match=said):
        read_raw(file)


def test_a_long_comment_is_cut_and_the_log_is_read(tmp_path):
    file = tmp_path / "log.csv"
    file.write_text("# " + "(" * 100_000 + f"\ntime [s],rudder [deg],heading [deg],speed [m/s]\n{ROWS}")
    (table,) = read_raw(file)
    assert [column.name for column in table.columns] == ["time", "rudder", "heading", "speed"] and table.n == 50


def test_a_parquet_file_of_more_cells_than_a_log_has_is_refused_as_such(tmp_path, monkeypatch):
    monkeypatch.setattr(binary_tables, "MOST_CELLS", 99)
    packed = BytesIO()
    pd.DataFrame({"time": range(50), "heading": range(50)}).to_parquet(packed)
    with pytest.raises(BadInput, match="more than 99 cells; cut it into parts"):
        binary_tables.read_arrow(packed.getvalue(), tmp_path / "log.parquet")


@pytest.mark.parametrize(("name", "kind"), [("raw-ardupilot", ".bin"), ("raw-px4", ".ulg")])
def test_a_damaged_log_that_its_library_reads_without_end_is_refused_before_the_limit_of_time(name, kind, tmp_path):
    (kept,) = (Path(__file__).parents[2] / "helmbench" / "fuzz" / "corpus" / name).iterdir()
    (tmp_path / f"log{kind}").write_bytes(kept.read_bytes())
    with pytest.raises(BadInput, match="log that can be read"):
        read_raw(tmp_path / f"log{kind}")
