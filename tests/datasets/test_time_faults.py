"""Times that rise but are not those of one run are told, whatever reads them, and never become a record."""

import datetime
import tracemalloc

import numpy as np
import pandas as pd
import pytest

import helmbench
from helmbench.datasets.time_faults import time_fault
from helmbench.models.errors import BadInput

N = 600
TIME = 0.5 * np.arange(N)
RUDDER = 20.0 * np.sign(np.sin(TIME / 25.0))
LATER = np.exp(-TIME[:40] / 4.0)
HEADING = np.cumsum(0.02 * np.convolve(RUDDER, LATER / LATER.sum())[:N])
"""The yaw rate follows the rudder in some seconds."""
WRONG = {
    "a clock that was set": (np.where(np.arange(N) < 300, TIME, 1.39e9 + TIME), "jumps by 16088 days"),
    "a date that changed with day and month exchanged": (TIME + 2592000.0 * (TIME > 100.0), "jumps by 30 days"),
    "milliseconds": (1000.0 * TIME, "steps of 500 s"),
    "milliseconds since 1970": (1.7e12 + 1000.0 * TIME, r"a time of 1\.7e\+12 s"),
    "steps of 1e-6": (2e-6 * TIME, "steps of 1e-06 s"),
    "1e308": (1e305 * (1.0 + TIME), r"a time of 3\.005e\+307 s"),
}


def frame(time):
    return pd.DataFrame({"time_s": time, "rudder_deg": RUDDER, "heading_deg": HEADING})


@pytest.mark.parametrize(("time", "told"), WRONG.values(), ids=WRONG)
def test_records_with_such_times_are_refused_in_one_line(tmp_path, time, told):
    frame(time).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(BadInput, match=rf"a\.csv: row \d+, column time_s: .*{told}"):
        helmbench.read_record(tmp_path / "a.csv")
    for make in (lambda: helmbench.Record.from_dataframe(frame(time)), lambda: helmbench.check(tmp_path / "a.csv")):
        with pytest.raises(BadInput, match=told):
            make()


@pytest.mark.parametrize("step", [1e-3, 0.5, 60.0])
def test_usual_steps_and_a_gap_of_hours_are_no_fault(step):
    time = step * np.arange(N)
    assert time_fault(time) is None
    assert time_fault(1.7e9 + np.where(np.arange(N) < 99, time, time + 80000.0)) is None


@pytest.mark.parametrize("unit", ["s", "ms", "ns"])
def test_dates_of_pandas_are_named_with_what_to_write(unit):
    stamps = pd.Series(pd.Timestamp("2024-05-03") + pd.to_timedelta(TIME, unit="s")).astype(f"datetime64[{unit}]")
    for times in (stamps, stamps.dt.tz_localize("UTC"), stamps - stamps.iloc[0]):
        with pytest.raises(BadInput, match=r"column time_s: type .* where numbers should be; .*total_seconds"):
            helmbench.Record.from_dataframe(frame(times))


def stamps(start, form):
    return [(start + datetime.timedelta(seconds=float(s))).strftime(form)[:-3] for s in TIME]


def log(path, times, unit=""):
    table = pd.DataFrame({f"time{unit}": times, "rudder [deg]": RUDDER, "heading [deg]": HEADING % 360.0})
    table.to_csv(path, index=False)
    return path


def test_samples_before_a_gps_clock_was_set_are_left_out_and_told(tmp_path):
    times = stamps(datetime.datetime(2024, 5, 3, 12), "%Y-%m-%d %H:%M:%S.%f")
    times[:40] = stamps(datetime.datetime(1980, 1, 6), "%Y-%m-%d %H:%M:%S.%f")[:40]
    found = helmbench.import_log(log(tmp_path / "log.csv", times))
    assert found.records[0].n == N - 40 and found.records[0].time_s[-1] == pytest.approx(TIME[-1] - 20.0)
    assert "40 samples before its clock was set, 44.3 years earlier" in str(found.report)


def test_midnight_tells_the_day_from_the_month(tmp_path):
    times = stamps(datetime.datetime(2024, 5, 3, 23, 58), "%m/%d/%Y %H:%M:%S.%f")
    found = helmbench.import_log(log(tmp_path / "log.csv", times)).records[0]
    assert found.n == N and found.time_s == pytest.approx(TIME - TIME[0])


@pytest.mark.parametrize(
    ("times", "unit", "told"),
    [
        ((1000.0 * TIME).astype(int), " [s]", "steps of 500 s"),
        (2e-6 * TIME, " [s]", "steps of 1e-06 s"),
        (1e305 * (1.0 + TIME), " [s]", "time"),
    ],
    ids=["milliseconds", "microseconds", "1e305"],
)
def test_such_logs_are_not_imported(tmp_path, times, unit, told):
    with pytest.raises(BadInput, match=told):
        helmbench.import_log(log(tmp_path / "log.csv", times, unit))


def test_neither_a_jump_nor_a_short_step_takes_gigabytes(tmp_path):
    one = log(tmp_path / "a.csv", np.where(np.arange(N) < 300, TIME, 1.39e9 + TIME), " [s]")
    two = tmp_path / "b.csv"
    pd.DataFrame({"time [s]": [0.0, 1.0, *(1.39e9 + TIME[2:])], "speed [kn]": 10.0 + HEADING}).to_csv(two, index=False)
    tracemalloc.start()
    for paths, step in (([one, two], None), (log(tmp_path / "c.csv", TIME, " [s]"), 1e-6)):
        with pytest.raises(BadInput):
            helmbench.import_log(paths, step_s=step)
    assert tracemalloc.get_traced_memory()[1] < 1e8
    tracemalloc.stop()
