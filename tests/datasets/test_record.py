"""Record: validation, immutability, rudder sign, heading, new records from old ones."""

import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pandas as pd
import pytest

from helmbench.datasets.columns import CANONICAL
from helmbench.datasets.record import Record, RecordMeta
from helmbench.models.errors import BadInput


@pytest.fixture
def record() -> Record:
    time = np.arange(12) * 0.5
    channels = {"rudder_rad": 0.1 * np.sin(time), "heading_rad": 0.2 * np.cos(time), "sway_m_s": np.full(12, np.nan)}
    return Record(time, channels, name="trial", meta=RecordMeta(positive_rudder="port", extra={"tank": 3}))


def test_canonical_names_are_those_of_the_interface():
    interface = (
        "time_s, rudder_command_rad, rudder_rad, propeller_rps, propeller_thrust_N, thrust_port_N, "
        "thrust_starboard_N, heading_rad, yaw_rate_rad_s, surge_m_s, sway_m_s, north_m, east_m, roll_rad, "
        "roll_rate_rad_s, wind_speed_m_s, wind_direction_rad, current_speed_m_s, current_direction_rad"
    )
    assert ", ".join(CANONICAL) == interface


def test_sizes_and_columns(record):
    assert (len(record), record.n, record.dt) == (12, 12, 0.5)
    assert record.has("time_s", "rudder_rad") and not record.has("rudder_rad", "north_m")
    assert record.column("time_s") is record.time_s
    assert record.column("heading_rad")[0] == 0.2
    with pytest.raises(BadInput, match=r"^trial: column north_m: no such column; it has rudder_rad, heading_rad"):
        record.column("north_m")


@pytest.mark.parametrize(
    ("time", "channels", "message"),
    [
        ([0.0, 1.0, 1.0], {}, r"bad: column time_s: time does not increase from sample 1 \(1 s\) to the next \(1 s\)"),
        ([0.0, 2.0, 1.0], {}, r"sample 1 \(2 s\) to the next \(1 s\)"),
        ([0.0, np.nan, 1.0], {}, "column time_s: time is not finite"),
        ([0.0, 1.0, np.inf], {}, "column time_s: time is not finite"),
        ([], {}, "at least one sample"),
        ([[0.0, 1.0]], {}, r"shape \(N,\)"),
        ([0.0, 1.0], {"heading_rad": [1.0]}, r"column heading_rad: shape \(1,\) where time has 2 samples"),
        ([0.0, 1.0], {"heading_rad": 1.0}, r"column heading_rad: shape \(\)"),
        ([0.0, 1.0], {"heading_deg": [1.0, 2.0]}, "column heading_deg: unknown channel; known are rudder_command_rad"),
        ([0.0, 1.0], {"time_s": [1.0, 2.0]}, "column time_s: unknown channel"),
    ],
)
def test_bad_samples_are_refused(time, channels, message):
    with pytest.raises(BadInput, match=message):
        Record(np.array(time, dtype=float), channels, name="bad")


def test_bad_side_is_refused():
    with pytest.raises(BadInput, match="positive_rudder is 'left'; give 'port' or 'starboard'"):
        RecordMeta(positive_rudder="left")


def test_nothing_in_it_can_be_changed(record):
    source = np.arange(12.0)
    copy = record.with_channels(north_m=source)
    source[:] = -1.0
    assert copy.column("north_m")[3] == 3.0
    with pytest.raises(ValueError, match="read-only"):
        copy.column("north_m")[0] = 5.0
    with pytest.raises(ValueError, match="read-only"):
        record.time_s[0] = 5.0
    with pytest.raises(TypeError):
        record.channels["north_m"] = source
    with pytest.raises(FrozenInstanceError):
        record.name = "other"
    assert not record.has("north_m")


def test_integers_and_lists_become_float64():
    record = Record(np.arange(3), {"rudder_rad": [1, 2, 3]})
    assert record.time_s.dtype == record.column("rudder_rad").dtype == np.float64


def test_pickle_keeps_everything_read_only(record):
    copy = pickle.loads(pickle.dumps(record))
    assert copy.equals(record)
    assert not copy.time_s.flags.writeable and not copy.column("rudder_rad").flags.writeable


def test_slice_counts_samples(record):
    part = record.slice(2, -3)
    np.testing.assert_array_equal(part.time_s, record.time_s[2:-3])
    np.testing.assert_array_equal(part.column("rudder_rad"), record.column("rudder_rad")[2:-3])
    assert (part.name, part.meta) == (record.name, record.meta)
    assert record.slice(None, None).equals(record)
    with pytest.raises(BadInput, match="at least one sample"):
        record.slice(5, 5)


def test_with_channels_replaces_adds_and_leaves_out(record):
    changed = record.with_channels(heading_rad=np.zeros(12), east_m=np.ones(12), sway_m_s=None)
    assert list(changed.channels) == ["rudder_rad", "heading_rad", "east_m"]
    assert changed.column("heading_rad").sum() == 0.0 and changed.column("east_m").sum() == 12.0
    assert record.column("heading_rad")[0] == 0.2


def test_turning_flips_both_rudders_and_nothing_else(record):
    record = record.with_channels(rudder_command_rad=np.linspace(0.0, 1.0, 12))
    turned = record.turned("starboard")
    assert turned.meta.positive_rudder == "starboard"
    for name in ("rudder_rad", "rudder_command_rad"):
        np.testing.assert_array_equal(turned.column(name), -record.column(name))
    assert not np.signbit(turned.column("rudder_command_rad")[0]), "zero must not become minus zero"
    np.testing.assert_array_equal(turned.column("heading_rad"), record.column("heading_rad"))
    assert turned.turned("port").equals(record)
    assert record.turned("port").equals(record)


def test_turning_without_a_known_sign_only_states_it(record):
    unknown = replace(record, meta=replace(record.meta, positive_rudder=None))
    turned = unknown.turned("starboard")
    assert turned.meta.positive_rudder == "starboard"
    np.testing.assert_array_equal(turned.column("rudder_rad"), record.column("rudder_rad"))
    with pytest.raises(BadInput, match="positive_rudder is 'left'"):
        record.turned("left")


def test_rudder_prefers_the_measured_one(record):
    command = np.linspace(0.0, 1.0, 12)
    both = record.with_channels(rudder_command_rad=command)
    np.testing.assert_array_equal(both.rudder(), record.column("rudder_rad"))
    np.testing.assert_array_equal(both.with_channels(rudder_rad=None).rudder(), command)
    with pytest.raises(BadInput, match="trial: column rudder_rad: no rudder in this record"):
        record.with_channels(rudder_rad=None).rudder()


def test_heading_is_unwrapped_across_gaps():
    heading = np.linspace(0.0, 20.0, 101)
    wrapped = np.mod(heading + np.pi, 2 * np.pi) - np.pi
    wrapped[[0, 15, 16, 100]] = np.nan
    record = Record(np.arange(101.0), {"heading_rad": wrapped})
    unwrapped = record.heading_unwrapped()
    known = np.isfinite(wrapped)
    np.testing.assert_array_equal(np.isnan(unwrapped), ~known)
    np.testing.assert_allclose(unwrapped[known], heading[known], atol=1e-12)


def test_uniform_and_step():
    time = np.arange(20) * 0.05
    assert Record(time, {}).uniform()
    jitter = time.copy()
    jitter[7] += 0.01
    record = Record(jitter, {})
    assert not record.uniform() and record.uniform(tolerance=0.25)
    assert record.dt == pytest.approx(0.05)
    assert not Record(np.delete(time, 5), {}).uniform()
    single = Record(np.array([3.0]), {})
    assert single.uniform() and np.isnan(single.dt)


def test_equals_sees_every_difference(record):
    assert record.equals(replace(record))
    assert not record.equals(replace(record, name="other"))
    assert not record.equals(replace(record, time_s=record.time_s + 1.0))
    assert not record.equals(replace(record, meta=RecordMeta()))
    assert not record.equals(record.with_channels(sway_m_s=None))
    assert not record.equals(record.with_channels(sway_m_s=np.zeros(12)))


# tables, slices by time, and what a record shows of itself


@pytest.fixture
def frame():
    return pd.DataFrame({"time_ms": [0.0, 500.0, 1000.0], "rudder_deg": [0, 10, -10], "surge_kn": [5.0, None, 7.0]})


def test_a_table_is_read_like_a_file(frame):
    record = Record.from_dataframe(frame, "mine", RecordMeta(vessel="own"))
    assert (record.name, record.meta.vessel, record.dt) == ("mine", "own", 0.5)
    np.testing.assert_allclose(record.column("rudder_rad"), np.deg2rad([0, 10, -10]))
    np.testing.assert_allclose(record.column("surge_m_s"), np.array([5.0, np.nan, 7.0]) * 1852 / 3600)


def test_a_record_goes_through_a_table_unchanged(frame):
    record = Record.from_dataframe(frame)
    table = record.to_dataframe()
    assert list(table) == ["time_s", "rudder_rad", "surge_m_s"]
    assert Record.from_dataframe(table).equals(record)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"draught_m": [1, 2, 3]}, "draught_m: unknown column"),
        ({"rudder_rad": [0.0, 0.1, 0.2]}, "the same quantity as rudder_deg"),
        ({"surge_kn": ["five", "six", "seven"]}, "surge_kn: type .* where numbers should be"),
        ({"surge_kn": [5.0, np.inf, 7.0]}, "mine: row 2, column surge_kn: infinite value"),
        ({"time_ms": [0.0, 0.0, 1.0]}, "time does not increase"),
        ({"time_ms": [0.0, np.nan, 1.0]}, "time is not finite"),
    ],
)
def test_a_table_with_a_fault_is_refused(frame, change, told):
    with pytest.raises(BadInput, match=told):
        Record.from_dataframe(frame.assign(**change), "mine")
    with pytest.raises(BadInput, match="time_s: missing column"):
        Record.from_dataframe(frame[["rudder_deg"]])
    with pytest.raises(BadInput, match=r"frame is \[1, 2\]; give a pandas DataFrame"):
        Record.from_dataframe([1, 2])


def test_samples_between_two_times():
    record = Record(np.arange(10.0), {"rudder_rad": np.arange(10.0)})
    assert record.between(2.0, 4.0).time_s.tolist() == [2.0, 3.0, 4.0]
    assert record.between(2.5, 4.5).time_s.tolist() == [3.0, 4.0]
    assert record.between(stop_s=1.0).n == 2 and record.between(8.0).n == 2 and record.between().equals(record)
    with pytest.raises(BadInput, match=r"no sample between 2\.1 and 2\.9 s; the record runs from 0 to 9 s"):
        record.between(2.1, 2.9)


def test_a_record_tells_its_extent():
    record = Record([0.0, 0.5, 1.0], {"yaw_rate_rad_s": [0.0, 1.0, 2.0], "rudder_rad": [0.0, 0.0, 0.0]}, "mine")
    assert repr(record) == "<Record 'mine': 3 samples, 0 to 1 s every 0.5 s; rudder_rad, yaw_rate_rad_s>"
    assert "median step 0.75 s" in repr(Record([0.0, 0.5, 1.5], {}))
    assert repr(Record([2.0], {})) == "<Record 'record': 1 samples, 2 to 2 s; no channels>"


def test_a_figure_shows_angles_in_degrees_and_headings_without_jumps():
    heading = np.deg2rad([350.0, 10.0, np.nan, 30.0])
    record = Record(np.arange(4.0), {"heading_rad": heading, "surge_m_s": np.ones(4)})
    top, bottom = record.plot().axes
    np.testing.assert_allclose(top.lines[0].get_ydata(), [350.0, 370.0, np.nan, 390.0])
    assert (top.get_ylabel(), bottom.get_ylabel()) == ("heading\n[deg]", "surge\n[m/s]")
    assert len(record.plot(["surge_m_s"]).axes) == 1
    with pytest.raises(BadInput, match="no such column"):
        record.plot(["sway_m_s"])
    with pytest.raises(BadInput, match="no channel to draw"):
        Record([0.0, 1.0], {}).plot()


def test_a_table_for_notebooks_counts_gaps():
    record = Record([0.0, 1.0, 2.0], {"yaw_rate_rad_s": np.deg2rad([1.0, np.nan, 3.0])}, "<i>")
    table = record._repr_html_()
    cells = "".join(f"<td>{text}</td>" for text in ("yaw rate", "deg/s", "1", "2", "3", "1"))
    assert f"<tr>{cells}</tr>" in table and "&lt;i&gt;" in table


@pytest.mark.parametrize("zone", [None, "UTC", "durations"])
def test_the_index_of_a_table_may_be_the_time(zone):
    """Moments or durations count from the first; a time column goes before the index."""
    steps = pd.to_timedelta([0.0, 0.5, 1.5], unit="s")
    index = steps if zone == "durations" else pd.Timestamp("2026-03-01T12:00", tz=zone) + steps
    frame = pd.DataFrame({"rudder_deg": [1.0, 2.0, 3.0]}, index=index)
    assert Record.from_dataframe(frame).time_s.tolist() == [0.0, 0.5, 1.5]
    assert Record.from_dataframe(frame.assign(time_s=[1.0, 2.0, 3.0])).time_s.tolist() == [1.0, 2.0, 3.0]
    with pytest.raises(BadInput, match="does not increase"):
        Record.from_dataframe(frame.iloc[::-1])
