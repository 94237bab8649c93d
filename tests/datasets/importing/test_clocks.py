"""Clocks of several loggers, GPS time, names over several cells, and maps that are read again."""

import datetime

import numpy as np
import pytest

import helmbench
from helmbench.datasets.importing.clocks import align, offset_by_motion, on_dates
from helmbench.datasets.importing.convert import Stream
from helmbench.datasets.importing.layout import other_separator, place_names
from helmbench.datasets.importing.moments import leap_seconds, start_of_week, utc_of_gps, week_stated

from .bank.truth import START, sail


def _utc(*parts):
    return datetime.datetime(*parts, tzinfo=datetime.UTC).timestamp()


def _stream(name, time, **quantities):
    return Stream(name, name, False, time, quantities, np.arange(time.size))


def _dated(stream, zoned, shift=0.0):
    own = {"dated": True, "zoned": zoned, "time": stream.time + START + shift}
    return Stream(**(vars(stream) | own))


@pytest.mark.parametrize(
    ("moment", "ahead"), [((1980, 6, 1), 0), ((2016, 12, 31, 23, 59, 59), 17), ((2017, 1, 1), 18), ((2030, 1, 1), 18)]
)
def test_leap_seconds_are_those_of_the_date(moment, ahead):
    assert leap_seconds(_utc(*moment)) == ahead


def test_a_gps_week_and_its_seconds_are_utc():
    """The line `obs start : 2026/03/14 10:00:18.0 GPST (week2409 554418.0s)` of RTKLIB."""
    time = utc_of_gps(np.array([start_of_week(2409) + 554418.0, np.nan]))
    assert time[0] == _utc(2026, 3, 14, 10) and np.isnan(time[1])


@pytest.mark.parametrize(
    ("note", "week"),
    [("(week2409 554418.0s)", 2409), ("Date of Mission: 2026-03-14", 2409), ("2026-03-13", None), ("trial 3", None)],
)
def test_the_week_is_that_of_a_date_on_whose_day_the_seconds_lie(note, week):
    assert week_stated([note], np.array([554418.0, 554419.0])) == week


@pytest.mark.parametrize(
    ("names", "row", "found"),
    [
        (["DateTime", "Rudder"], "2026-03-14 10:00:00 3", ("DateTime date", "DateTime clock", "Rudder")),
        (["Date", "Time", "Rudder"], "14.03.2026 10:00:00 3", ("Date", "Time", "Rudder")),
        (["Time", "Rudder"], "10:00:00 AM 3", ("Time date", "Time clock", "Rudder")),
        (["GPST", "Rudder"], "2409 554418.0 3", ("GPST week", "GPST seconds of week", "Rudder")),
        (["Date", "Time", "Rudder"], "14.03.2026 10:00:00 UTC 3", ("Date Time", "Rudder")),
        (["Date", "Time", "Rudder"], "14.03.2026 10:00:00 CEST 3", ("Date", "Time", "zone", "Rudder")),
    ],
)
def test_names_stand_over_the_cells_of_date_and_clock(names, row, found):
    rows = [row.replace("554418", f"55441{k}").split() for k in range(8)]
    placed = place_names(names, rows, len(names))
    assert placed is not None and placed.names == found


def test_a_missing_name_that_nothing_places_is_refused():
    with pytest.raises(helmbench.BadInput, match="3 names over 4 columns"):
        place_names(["Time", "Rudder", "Heading"], [["0.0", "1.0", "2.0", "3.0"], ["0.5", "1.1", "2.1", "3.1"]], 3)


@pytest.mark.parametrize(
    "line", ["Time [s], Heading [deg], Rudder [deg]", "time;heading;rudder", "time heading rudder"]
)
def test_a_header_with_another_separator_is_cut_by_it(line):
    assert len(other_separator([line], 3)) == 3


@pytest.mark.parametrize("ahead", [0.0, 18.0, -41.0])
def test_the_course_tells_the_offset_of_the_heading(rng, ahead):
    run = sail(rng)
    track = _stream("track", run.t, north=run.north, east=run.east)
    found = offset_by_motion([track], [_stream("gyro", run.t + ahead, heading=run.psi)], 120.0)
    assert found is not None and found.sharp and found.seconds == pytest.approx(-ahead, abs=2.0)


def test_a_heading_that_does_not_belong_to_the_course_tells_no_offset(rng):
    run = sail(rng)
    other = np.radians(30.0) * np.sin(run.t**1.5 / 40.0)
    track = _stream("track", run.t, north=run.north, east=run.east)
    assert offset_by_motion([track], [_stream("gyro", run.t, heading=other)], 120.0) is None


@pytest.mark.parametrize("shift", [0.0, 18.0, 7200.0])
def test_a_clock_without_zone_is_set_to_utc_by_the_motion(rng, shift):
    run = sail(rng)
    track = _dated(_stream("track", run.t, north=run.north, east=run.east), True)
    pilot = _dated(_stream("pilot", run.t, heading=run.psi, rudder=run.delta), False, shift)
    streams, _, faults, asked = align([pilot, track])
    assert not asked and {s.label: s.shift_s for s in streams} == {"track": 0.0, "pilot": -shift}
    assert bool(faults) == bool(shift)


def test_a_clock_that_nothing_tells_is_asked(rng):
    run = sail(rng)
    pilot = _dated(_stream("pilot", run.t, heading=run.psi, rudder=run.delta), True)
    wind = _dated(_stream("wind", run.t, wind_speed=5.0 + np.sin(run.t)), False)
    question = align([pilot, wind])[3][0]
    assert question.id == "wind/clock" and [answer.key for answer in question.answers] == ["0", "-18", "18"]


def test_seconds_of_the_week_are_put_on_the_week_of_another_file():
    time = np.arange(0.0, 100.0)
    dated = _dated(_stream("pilot", time, rudder=time), True)
    week = Stream(
        **(vars(_stream("gps", time + (START + 18.0 - 315964800.0) % 604800.0)) | {"period_s": 604800.0, "gps": True})
    )
    placed = on_dates([dated, week])[1]
    assert placed.dated and placed.zoned and placed.time[0] == pytest.approx(dated.time[0])


def test_the_draft_of_a_clock_takes_its_answer(tmp_path):
    time = 0.5 * np.arange(200)
    for name, column, values in (
        ("a", "Rudder [deg]", np.sign(np.sin(time / 9.0))),
        ("b", "Heading [deg]", time**1.5 % 9),
    ):
        lines = [f"{t:g},{v:.3f}" for t, v in zip(time, values, strict=True)]
        (tmp_path / f"{name}.csv").write_text("\n".join([f"Time [s],{column}", *lines]), "utf-8")
    paths = [tmp_path / "a.csv", tmp_path / "b.csv"]
    draft = helmbench.draft_import(paths, positive_rudder="starboard")
    assert [question.id for question in draft.questions] == ["b.csv/clock"]
    draft.write_mapping(tmp_path / "map.yaml")
    text = (tmp_path / "map.yaml").read_text("utf-8")
    assert "# ASKED: By how much is the clock of b.csv off" in text and "clock_offset_s: 0" in text
    text = text.replace("- file: b.csv\n", "- file: b.csv\n    clock_offset_s: 7\n")
    (tmp_path / "map.yaml").write_text(text, "utf-8")
    record = helmbench.import_log(paths, mapping=tmp_path / "map.yaml", positive_rudder="starboard").record
    assert record.n == 186


def test_the_draft_of_tables_without_a_rudder_is_read_again(tmp_path):
    rows = [f"{k / 2:g},{name},{value}" for k in range(60) for name, value in (("hdg", k % 50), ("depth", 9 + k % 3))]
    path = tmp_path / "long.csv"
    path.write_text("\n".join(["time [s],signal,value", *rows]), "utf-8")
    draft = helmbench.draft_import(path)
    draft.write_mapping(tmp_path / "map.yaml")
    again = helmbench.draft_import(path, mapping=tmp_path / "map.yaml")
    assert [q.id for q in again.questions] == [q.id for q in draft.questions]


@pytest.mark.parametrize("rate", [0.0, 0.003, -0.004])
def test_a_clock_that_goes_fast_or_slow_is_set_at_every_time(rng, rate):
    run = sail(rng, seconds=1500.0)
    noise = 2e-3 * rng.standard_normal((2, run.t.size))
    base = _stream("rudder.csv", run.t, rudder=run.delta, heading=run.psi + noise[0])
    own = _stream("gyro.csv", (1.0 + rate) * run.t - 7.0, heading=run.psi + noise[1])
    (_, set_), done, faults, asked = align([base, own])
    assert not faults and not asked and (f"{100.0 * abs(rate):.2g} %" in done[0]) == (rate != 0.0)
    assert set_.time == pytest.approx(run.t, abs=0.15)
    assert set_.on_clock(own.time) == pytest.approx(set_.time, abs=1e-9)
