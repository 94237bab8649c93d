"""Wrong and implausible files: every one ends in one clear line that says what to do, and nothing is written."""

import re
from dataclasses import replace

import numpy as np
import openpyxl
import pytest
import yaml

from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.models.model import model_to_json, resolve

DEG = 180.0 / np.pi


@pytest.fixture(scope="module")
def run():
    """A zigzag of the 7 m KVLCC2 model, all channels."""
    return generate(Case("kvlcc2-l7", "zigzag:20/20", "low", duration_s=100.0, dt_s=0.5))


@pytest.fixture(scope="module")
def full_scale():
    return generate(Case("mariner", "zigzag:20/20", "low", duration_s=400.0, dt_s=1.0))


def record_file(record, path, vessel=None, **factors):
    """The record as a CSV file whose named columns are multiplied; its sidecar names the vessel, or none."""
    names = ["time_s", *record.channels]
    columns = {name: record.column(name) * factors.get(name, 1.0) for name in names}
    table_file(columns, path)
    side = {"positive_rudder": record.meta.positive_rudder} | ({"vessel": vessel} if vessel else {})
    path.with_suffix(".yaml").write_text(yaml.safe_dump(side), "utf-8")
    return path


def table_file(columns, path):
    rows = (",".join(f"{value:.10g}" for value in row) for row in zip(*columns.values(), strict=True))
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", "utf-8")
    return path


def refused(arguments, capsys):
    """The one line that a command ends with: status 2, no traceback."""
    capsys.readouterr()
    status = status_of([str(argument) for argument in arguments])
    lines = capsys.readouterr().err.strip().splitlines()
    assert status == 2, lines
    assert lines[-1].startswith("helmbench: ") and not any("Traceback" in line for line in lines)
    return lines[-1]


EXCHANGED = {
    "identify kvlcc2-l7 --model run.csv": "run.csv: is a record or another table, not a model; a model is a vessel id",
    "identify kvlcc2-l7 --model nomoto-1": "kvlcc2-l7: is a model, not a record; give the files of records here",
    "identify nomoto-1 --model nomoto-1": "nomoto-1: is a model, not a record",
    "identify model.json --model nomoto-1": "model.json: is JSON, such as a model, not a record",
    "identify log.xlsx --model nomoto-1": "log.xlsx: is a workbook .*'helmbench import log.xlsx -o log-record.csv'",
    "validate run.csv kvlcc2-l7": "run.csv: is a record or another table, not a model",
    "diagnose --model run.csv --train kvlcc2-l7": "run.csv: is a record or another table, not a model",
    "calibrate --model kvlcc2-l7 --train model.json": "model.json: is JSON, such as a model, not a record",
    "check kvlcc2-l7": "kvlcc2-l7: is a model, not a record",
    "check log.xlsx": "log.xlsx: is a workbook or a binary log, not a record",
    "simulate zigzag:20/20 --manoeuvre kvlcc2-l7": "'zigzag:20/20' is a manoeuvre, not a model; first the vessel",
}


@pytest.mark.parametrize("arguments", EXCHANGED)
def test_exchanged_arguments_and_raw_logs_are_told(arguments, run, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    record_file(run, tmp_path / "run.csv")
    model_to_json(resolve("response-1"), "model.json")
    openpyxl.Workbook().save("log.xlsx")
    assert re.search(EXCHANGED[arguments], refused(arguments.split(), capsys))


# ------------------------------------------------------------------------------------------------ records

SPEEDS, PLACES = ("surge_m_s", "sway_m_s"), ("north_m", "east_m")
UNITS = {
    "degrees[?] then call the column rudder_deg": {"rudder_rad": DEG, "rudder_command_rad": DEG},
    "beyond 1.6 rad; check the column": {"rudder_rad": 5000.0},
    "degrees per second[?] then call the column yaw_rate_deg_s": {"yaw_rate_rad_s": DEG},
    "degrees per minute in yaw_rate_rad_s[?]": {"yaw_rate_rad_s": 60.0 * DEG},
    "per minute in yaw_rate_rad_s[?]": {"yaw_rate_rad_s": 60.0},
    "degrees in heading_rad[?]": {"heading_rad": DEG},
    "; knots in speed columns[?]": dict.fromkeys(SPEEDS, 3600.0 / 1852.0),
    "named knots[?]": dict.fromkeys(SPEEDS, 1852.0 / 3600.0),
    "km/h in speed columns[?]": dict.fromkeys(SPEEDS, 3.6),
    "centimetres per second in speed columns[?]": dict.fromkeys(SPEEDS, 100.0),
    "centimetres in position columns[?]": dict.fromkeys(PLACES, 100.0),
    "feet in position columns[?]": dict.fromkeys(PLACES, 1.0 / 0.3048),
    "kilometres in position columns[?]": dict.fromkeys(PLACES, 1e-3),
    "milliseconds in time_s[?]": {"time_s": 1000.0},
    "stays at .* while the rudder moves": {"yaw_rate_rad_s": 1e-12},
}


@pytest.mark.parametrize("command", ["identify", "validate"])
@pytest.mark.parametrize("said", UNITS)
def test_numbers_in_another_unit_are_refused(said, command, run, tmp_path, capsys):
    path = record_file(run, tmp_path / "run.csv", **UNITS[said])
    out = tmp_path / "out"
    more = ["--model", "kvlcc2-l7", "--method", "ls", "-o", out]
    arguments = ["identify", path, *more] if command == "identify" else ["validate", "kvlcc2-l7", path, "-o", out]
    line = refused(arguments, capsys)
    assert re.search(said, line), line
    assert not out.exists()


def test_a_record_of_another_ship_is_refused(run, full_scale, tmp_path, capsys):
    path = record_file(run, tmp_path / "run.csv", vessel="kvlcc2-l7")
    line = refused(["diagnose", "--model", "s175", "--train", path, "-o", tmp_path / "out"], capsys)
    assert "is a record of kvlcc2-l7 (7 m), the model s175 is 175 m long; give the model of kvlcc2-l7" in line


def test_a_record_of_another_scale_is_refused(run, full_scale, tmp_path, capsys):
    small, large = record_file(run, tmp_path / "small.csv"), record_file(full_scale, tmp_path / "large.csv")
    line = refused(["validate", "mariner", small], capsys)
    assert "times smaller than mariner" in line and "scale the record by Froude's law" in line
    line = refused(["validate", "mariner-model", large], capsys)
    assert "times larger than mariner-model" in line or "above 10 times" in line


def test_the_same_run_is_refused_twice_and_on_both_sides(run, tmp_path, capsys):
    one, other = record_file(run, tmp_path / "one.csv"), record_file(run, tmp_path / "other.csv")
    fit = ["--model", "kvlcc2-l7", "--method", "ls", "-o", tmp_path / "out.json"]
    assert "holds the same samples as" in refused(["identify", one, other, *fit], capsys)
    assert "is both a training record and held out" in refused(["identify", one, "--validate", other, *fit], capsys)


def test_a_part_of_a_training_record_is_not_held_out(run, tmp_path, capsys):
    whole, part = record_file(run, tmp_path / "whole.csv"), tmp_path / "part.csv"
    record_file(replace(run.slice(40, 140), time_s=run.time_s[:100]), part)
    line = refused(["identify", whole, "--validate", part, "--model", "kvlcc2-l7", "--method", "ls", "-o", "x"], capsys)
    assert "part: shares 100 of its 100 samples with the training record whole" in line
    line = refused(["diagnose", "--model", "kvlcc2-l7", "--train", part, "--held-out", whole, "-o", "x"], capsys)
    assert "whole: shares 100 of its 201 samples with the training record part" in line


def test_positions_that_turn_against_the_heading_are_refused_or_told(run, tmp_path, capsys):
    bare = run.with_channels(surge_m_s=None, sway_m_s=None)
    path = record_file(bare, tmp_path / "run.csv", east_m=-1.0)
    line = refused(["validate", "kvlcc2-l7", path], capsys)
    assert "the track turns against the heading; mirrored axes? as if east_m has the other sign" in line
    swapped = run.with_channels(north_m=run.column("east_m"), east_m=run.column("north_m"))
    path = record_file(swapped, tmp_path / "swapped.csv")
    assert status_of(["validate", "kvlcc2-l7", str(path)]) == 0
    assert "as if north_m and east_m are exchanged" in capsys.readouterr().out
    assert status_of(["check", str(record_file(bare, tmp_path / "mirror.csv", north_m=-1.0))]) == 1
    assert "the track turns against the heading, as if north_m has the other sign" in capsys.readouterr().out


def test_velocities_of_an_antenna_are_told(run, tmp_path, capsys):
    sway = run.column("sway_m_s") + 3.0 * run.column("yaw_rate_rad_s")
    path = record_file(run.with_channels(sway_m_s=sway, north_m=None, east_m=None), tmp_path / "run.csv")
    assert status_of(["validate", "kvlcc2-l7", str(path)]) == 0
    assert "m ahead of midship; an antenna's velocities?" in capsys.readouterr().out


HEADERS = {
    "sog_kn": "column sog_kn: unknown column; speed over ground? accepted: time_s",
    "rot_deg_min": "column rot_deg_min: unknown column; yaw rate? accepted: time_s",
    "cog_deg": "column cog_deg: unknown column; course over ground?",
    "heading_grad": "unknown unit 'grad'",
    "headng_deg": "did you mean heading_deg?",
}


@pytest.mark.parametrize("name", HEADERS)
def test_hints_for_columns_never_name_another_quantity(name, run, tmp_path, capsys):
    path = table_file({"time_s": run.time_s, "rudder_rad": run.rudder(), name: run.time_s}, tmp_path / "run.csv")
    assert HEADERS[name] in refused(["check", path], capsys)


def test_what_is_doubtful_but_usable_stays_on_the_page(run, tmp_path, capsys):
    frozen, jumped = run.column("yaw_rate_rad_s").copy(), run.column("north_m").copy()
    frozen[60:100], jumped[120:] = frozen[60], jumped[120:] + 40.0
    changed = run.with_channels(yaw_rate_rad_s=frozen, north_m=jumped)
    path, out = record_file(changed, tmp_path / "run.csv"), tmp_path / "out"
    assert status_of(["validate", "kvlcc2-l7", str(path), "-o", str(out)]) == 0
    page, text = (out / "validation.html").read_text("utf-8"), capsys.readouterr().out
    for place in (page, text):
        assert "yaw_rate_rad_s repeats one value" in place and "north_m" in place


# ------------------------------------------------------------------------------------------------ raw logs


def log(run, **changed):
    """Columns of a raw log; keys replace or, with None, remove some."""
    u, v, psi = run.column("surge_m_s"), run.column("sway_m_s"), run.heading_unwrapped()
    columns = {
        "Time [s]": run.time_s,
        "Heading [deg]": np.degrees(psi) % 360.0,
        "Yaw rate [deg/s]": np.degrees(run.column("yaw_rate_rad_s")),
        "Rudder [deg]": np.degrees(run.rudder()),
        "Surge [m/s]": u,
        "Sway [m/s]": v,
        "North [m]": run.column("north_m"),
        "East [m]": run.column("east_m"),
    } | changed
    return {name: values for name, values in columns.items() if values is not None}


def text_of(columns, separator=",", comma=False):
    rows = [
        separator.join(f"{x:.6f}" if isinstance(x, float) else str(x) for x in row)
        for row in zip(*columns.values(), strict=True)
    ]
    text = "\n".join([separator.join(columns), *(row.replace(".", ",") if comma else row for row in rows)])
    return text.encode()


def with_rows(text, every, change):
    lines = text.decode().splitlines()
    return "\n".join(change(line) if i and i % every == 0 else line for i, line in enumerate(lines)).encode()


def renamed(run, old, new):
    return {new if name == old else name: values for name, values in log(run).items()}


def speeds(run, factor):
    return {"Surge [m/s]": factor * run.column("surge_m_s"), "Sway [m/s]": factor * run.column("sway_m_s")}


def places(run, factor):
    return {"North [m]": factor * run.column("north_m"), "East [m]": factor * run.column("east_m")}


def mathematical(run):
    return {"Heading [deg]": -np.degrees(run.heading_unwrapped()) % 360.0, "Yaw rate [deg/s]": None}


RUDDER = "Rudder [deg]"
RAW = {
    "the file is empty": lambda r: b"",
    "a binary file of unknown kind": lambda r: bytes(range(256)) * 20,
    "an Excel file of the old form": lambda r: b"\xd0\xcf\x11\xe0" + bytes(600),
    "a PDF; export the log as CSV": lambda r: b"%PDF-1.4 " + bytes(600),
    "a damaged file of gzip": lambda r: b"\x1f\x8b\x08" + bytes(600),
    "a damaged archive": lambda r: b"PK\x03\x04" + bytes(600),
    "not a workbook that can be read": lambda r: b"PK\x03\x04[Content_Types].xml" + bytes(600),
    "not an HDF5 file that can be read": lambda r: b"MATLAB 7.3 MAT-file" + bytes(600),
    "not a MAT file that can be read": lambda r: b"MATLAB 5.0 MAT-file" + bytes(600),
    "no rows of numbers found": lambda r: b"minutes of the meeting\nall were present\nnothing was decided\n" * 20,
    "starts as utf-16 text but is damaged": lambda r: b"\xff\xfe" + b"\x00\xd8\x00\x00" * 40,
    "No column looks like a time": lambda r: text_of(no_time(r)),
    "'Rudder' is in rpm: how many degrees are one of it[?]": lambda r: text_of(renamed(r, RUDDER, "Rudder [rpm]")),
    "deg cannot be[.] What is its unit[?]": lambda r: text_of(log(r, **{"Rudder [deg]": 3e3 * r.rudder()})),
    "no number in the whole column": lambda r: text_of(log(r, **{RUDDER: ["hard to port"] * r.n})),
    "time goes back": lambda r: text_of(log(r, **{"Time [s]": unsorted(r.time_s)})),
    "repeat the time": lambda r: text_of(log(r, **{"Time [s]": np.repeat(r.time_s[::100], 100)[: r.n]})),
    "rows have no time of the form": lambda r: with_rows(text_of(log(r)), 5, lambda line: "?" + line),
    "cells under 8 columns": lambda r: with_rows(text_of(log(r)), 5, lambda line: line + ",1,2"),
    "decimal commas cannot be told from the commas": lambda r: text_of(log(r), ",", comma=True),
    "Which way does 'Heading' count[?] it turns against North, East": lambda r: text_of(log(r, **mathematical(r))),
    "Surge. says m/s, but the speed of North, East is 0[.]5": lambda r: text_of(log(r, **speeds(r, 1.9438))),
    "East is 10. times as fast": lambda r: text_of(log(r, **places(r, 100.0), **{"Sway [m/s]": None})),
    "the sentences have no time": lambda r: b"\n".join(b"$HEHDT,%d.0,T" % (i % 360) for i in range(200)),
    "no NMEA sentence that can be used": lambda r: b"\n".join(b"$SDDBT,77.1,f,23.5,M,12.8,F" for i in range(200)),
    "3 samples; a record needs 10": lambda r: b"\n".join(text_of(log(r)).splitlines()[:4]),
}  # fmt: skip


def unsorted(time):
    """Times (N,) of which every second one is earlier than the one before."""
    return np.where(np.arange(time.size) % 2, time - 2.0 * (time[1] - time[0]), time)


def no_time(run):
    """A log without a time, its columns in an order that looks like none."""
    columns = log(run, **{"Time [s]": None})
    return {"Remark": np.array(["ok"] * run.n), **columns}


@pytest.mark.parametrize("said", RAW)
def test_raw_logs_that_cannot_be_records_are_refused(said, run, tmp_path, capsys):
    path, out = tmp_path / "log.csv", tmp_path / "out.csv"
    path.write_bytes(RAW[said](run))
    line = refused(["import", path, "--yes", "-o", out], capsys)
    assert re.search(said, line) and "log" in line, line
    assert sorted(tmp_path.iterdir()) == [path]


def test_two_loggers_without_a_common_time_are_refused(run, tmp_path, capsys):
    columns = log(run)
    one = table_file({k: columns[k] for k in ("Time [s]", "Rudder [deg]")}, tmp_path / "a.csv")
    other = table_file({k: columns[k] for k in ("Time [s]", "Heading [deg]")}, tmp_path / "b.csv")
    line = refused(["import", one, other, "--yes", "-o", tmp_path / "out.csv"], capsys)
    assert "By how much is the clock of b.csv off that of a.csv" in line and "clock_offset_s" in line


MAPS = {
    "needs a unit of rudder, which are rad, deg": {"unit": "kn"},
    "needs one of rudder": {"to": "helm"},
    "unknown key": {"units": "deg"},
    "the mapping needs column 'Helm'": {"column": "Helm"},
}


@pytest.mark.parametrize("said", MAPS)
def test_mappings_that_cannot_be_used_are_refused(said, run, tmp_path, capsys):
    path, out = table_file(log(run), tmp_path / "log.csv"), tmp_path / "out.csv"
    column = {"column": "Rudder", "to": "rudder", "unit": "deg"} | MAPS[said]
    table = {"file": "log.csv", "time": {"columns": ["Time"], "form": "seconds"}, "columns": [column]}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({"version": 1, "tables": [table]}), "utf-8")
    assert said in refused(["import", path, "--map", tmp_path / "map.yaml", "-o", out], capsys)
    assert not out.exists()


def test_files_that_are_not_there_or_given_twice(run, tmp_path, capsys):
    path, out = table_file(log(run), tmp_path / "log.csv"), tmp_path / "out.csv"
    assert "no such file" in refused(["import", tmp_path / "none.csv", "--yes", "-o", out], capsys)
    assert "is a directory" in refused(["import", tmp_path, "--yes", "-o", out], capsys)
    assert "given twice" in refused(["import", path, path, "--yes", "-o", out], capsys)
    assert "the mapping is not confirmed" in refused(["import", path, "-o", out], capsys)
    assert not out.exists()


def test_all_faults_of_a_file_are_told_at_once(run, tmp_path, capsys):
    text = with_rows(text_of(log(run, **{"Time [s]": unsorted(run.time_s)})), 5, lambda line: line + ",1")
    path = tmp_path / "log.csv"
    path.write_bytes(text)
    assert status_of(["import", str(path), "--yes", "-o", str(tmp_path / "out.csv")]) == 2
    said = capsys.readouterr().err
    assert (
        "cells under 8 columns" in said and "time goes back" in said and said.strip().splitlines()[-1].count("(2)") == 1
    )


def test_nothing_is_replaced_unless_told_so(run, tmp_path, capsys):
    path, out = table_file(log(run), tmp_path / "log.csv"), tmp_path / "out.csv"
    assert status_of(["import", str(path), "--yes", "-o", str(out)]) == 0
    assert "exists already" in refused(["import", path, "--yes", "-o", out], capsys)
    assert status_of(["import", str(path), "--yes", "--force", "-o", str(out)]) == 0
    record = record_file(run, tmp_path / "run.csv")
    simulate = ["simulate", "mariner", "--manoeuvre", "zigzag:20/20", "--duration", "20", "-o", out]
    assert "exists already" in refused(simulate, capsys)
    folder = tmp_path / "page"
    assert status_of(["validate", "kvlcc2-l7", str(record), "-o", str(folder)]) == 0
    assert "validation.json: exists already" in refused(["validate", "kvlcc2-l7", record, "-o", folder], capsys)


def test_a_workbook_without_numbers_is_refused(tmp_path, capsys):
    book = openpyxl.Workbook()
    book.active.append(["only", "words"])
    book.save(tmp_path / "log.xlsx")
    line = refused(["import", tmp_path / "log.xlsx", "--yes", "-o", tmp_path / "out.csv"], capsys)
    assert "no sheet holds rows of numbers; sheets: Sheet" in line
