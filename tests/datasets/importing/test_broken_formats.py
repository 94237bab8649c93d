"""Broken files of the formats that state what they hold: one clear line, or their sound part."""

import numpy as np
import pytest

from helmbench.datasets.importing.sources import MOST_TABLES, read_raw
from helmbench.models.errors import BadInput

from .bank.format_cases import FORMAT_CASES, novatel
from .bank.truth import sail

HEAD = "#INSPVAA,COM1,0,60.0,FINESTEERING,{week},{second},0,0,0;2409,1.0,54.4,10.3,30,1,2,0,0,0,60,INS_SOLUTION_GOOD"
BROKEN = {
    "JSON without numbers": ('{"a": "b"}\n' * 9, "no JSON objects with a time and numbers"),
    "JSON without end": ("[" * 100_000, "no JSON objects"),
    "JSON of deep objects": (('{"a":' * 5000 + "1" + "}" * 5000 + "\n") * 9, "no JSON objects"),
    "JSON of whole numbers without end": (('{"t": ' + "9" * 5000 + ', "v": 1}\n') * 9, "no JSON objects"),
    "JSON of many keys": ("\n".join(f'{{"t": {i}, "k{i}": {i}}}' for i in range(999)), "objects with 1000 keys"),
    "TCX with entities": ('<!DOCTYPE x [<!ENTITY a "b">]><TrainingCenterDatabase/>', "declares entities"),
    "TCX cut": ("<TrainingCenterDatabase><Track><Trackpoint>", "not a TCX file that can be read"),
    "TCX without points": ("<TrainingCenterDatabase/>", "no track in the TCX file"),
    "LabVIEW without rows": ("LabVIEW Measurement\n***End_of_Header***\n", "no rows of numbers found"),
    "MOOS without numbers": ("%% LOGSTART 1\n1.0 A B text\n", "no variable of the MOOS log holds numbers"),
    "InfluxDB without values": ("#datatype,string\n,result,table\n,,0\n", "no block with times and values"),
    "dataflash without known messages": (
        "FMT, 1, 2, XYZ, Q, TimeUS\nFMT, 1, 2, XYW, Q, TimeUS\nFMT, 1, 2, XYV, Q, TimeUS\nXYZ, 1\n" * 2,
        "no message of the log can be used",
    ),
    "Hypack without records": ("FTP NEW 2\nEOH\nGYR 1 nonsense 3\n", "no record of the file can be used"),
    "TOA5 without rows": ('"TOA5","a"\n"TIMESTAMP","Heading"\n', "no rows of numbers found"),
    "Tecplot without rows": ('VARIABLES = "t", "psi"\nZONE I=0\n', "no rows of numbers found"),
    "named values of no column": ("a=1 b=2\n" * 2 + "a=1 b=x\n" * 9, "no rows of numbers found"),
    "a table on its side without rows": ("path," + ",".join(map(str, range(0, 900, 30))) + "\nb,1,2,3\n", "no row has"),
    "NovAtel of a week that no calendar has": (
        "\n".join(novatel(HEAD[1:].format(week="9e99", second="nan")) for _ in range(9)),
        "the sentences have no time",
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_is_refused_in_one_line(name, tmp_path):
    text, said = BROKEN[name]
    (tmp_path / "log.txt").write_text(text)
    with pytest.raises(BadInput, match=said) as refused:
        read_raw(tmp_path / "log.txt")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "name", ["JSON, topics with units", "MOOS", "dataflash as text", "Hypack RAW", "NovAtel INSPVAS and RSA"]
)
def test_what_is_sound_of_a_damaged_file_is_read(name, tmp_path, rng):
    (file,) = FORMAT_CASES[name].write(sail(rng, seconds=60.0), tmp_path)
    whole = read_raw(file)
    lines = file.read_text().splitlines()
    damaged = [line[: len(line) // 2] if i > 20 and i % 40 == 0 else line for i, line in enumerate(lines)]
    file.write_text("\n".join(damaged))
    read = read_raw(file)
    assert [table.sheet for table in read] == [table.sheet for table in whole]
    assert all(0.85 * one.n <= other.n <= one.n for one, other in zip(whole, read, strict=True))


def test_a_position_without_a_solution_is_a_gap(tmp_path):
    good = [novatel(HEAD[1:].format(week=2409, second=i)) for i in range(20)]
    lost = [novatel(line[1:].split("*")[0].replace("INS_SOLUTION_GOOD", "INS_ALIGNING")) for line in good[:5]]
    (tmp_path / "span.txt").write_text("\n".join([*lost, *good[5:]]))
    (table,) = read_raw(tmp_path / "span.txt")
    assert np.isnan(table.column("latitude").numbers).tolist() == [True] * 5 + [False] * 15


def test_a_sentence_of_novatel_with_a_wrong_checksum_is_left_out_unless_all_are_wrong(tmp_path):
    lines = [novatel(HEAD[1:].format(week=2409, second=i)) for i in range(20)]
    bad = [line[:-8] + "00000000" for line in lines]
    for written, rows, faults in (([*lines[:10], *bad[10:12], *lines[12:]], 18, 2), (bad, 20, 0)):
        (tmp_path / "span.txt").write_text("\n".join(written))
        (table,) = read_raw(tmp_path / "span.txt")
        assert (table.n, len(table.faults)) == (rows, faults)


def test_of_many_tables_those_with_the_most_rows_are_read(tmp_path):
    lines = [f"{k}.0 VAR_{i} s {k}" for i in range(MOST_TABLES + 50) for k in range(4 if i % 2 else 5)]
    (tmp_path / "many.alog").write_text("%% LOGSTART 1\n" + "\n".join(lines))
    tables = read_raw(tmp_path / "many.alog")
    assert len(tables) == MOST_TABLES and sum(table.n == 5 for table in tables) == MOST_TABLES // 2 + 25


def test_a_rectangle_of_numbers_that_are_no_times_is_no_table_on_its_side(tmp_path):
    (tmp_path / "log.csv").write_text(
        "t,1,2,3,4,5,6,7,8,9,10,11,12\n" + "\n".join(f"{i}," + "5," * 11 + "6" for i in range(30))
    )
    (table,) = read_raw(tmp_path / "log.csv")
    assert table.n >= 30
