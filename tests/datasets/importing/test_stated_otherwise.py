"""What a file states in a second place: units in groups, factors, references, instances, receivers without a fix."""

import json
from decimal import Decimal

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

import helmbench

pytestmark = pytest.mark.usefixtures("logs_read_here")
N = 60
TIME = 0.5 * np.arange(N)
HEADING, RUDDER = 90.0 + 20.0 * np.sin(TIME / 5.0), 20.0 * np.cos(TIME / 5.0)


def draft(path):
    return helmbench.draft_import([path], positive_rudder="starboard")


def columns(path):
    """Name -> (quantity, unit) of the columns that are used."""
    used = [one for one in draft(path).columns if one.quantity != "not used"]
    return {one.column: (one.quantity, one.unit) for one in used}


def text(tmp_path, header, *rows, name="log.csv", time=TIME):
    lines = [",".join(f"{value:.6g}" for value in row) for row in zip(time, HEADING, RUDDER, strict=True)]
    (tmp_path / name).write_text("\n".join([header, *rows, *lines]), "utf-8")
    return tmp_path / name


def stored(path, groups):
    """An HDF5 file: group -> name -> (values, attributes)."""
    with h5py.File(path, "w") as file:
        for group, own in groups.items():
            for name, (values, attributes) in own.items():
                file.create_dataset(f"{group}/{name}", data=values).attrs.update(attributes)
    return path


def test_units_of_hdf5_are_those_of_their_own_group(tmp_path):
    clock = {"time": (TIME, {"units": "s"})}
    gps = {**clock, "sog": (np.full(N, 15.0), {"units": "kn"})}
    own = {**clock, "heading": (HEADING, {"units": "deg"}), "rudder": (np.radians(RUDDER), {"units": "rad"}),
           "sog": (np.full(N, 7.7), {"units": "m/s"})}  # fmt: skip
    found = draft(stored(tmp_path / "log.h5", {"gps": gps, "ship": own})).columns
    assert {one.table.partition("[")[2].rstrip("]"): one.unit for one in found if one.column == "sog"} == {
        "gps": "kn",
        "ship": "m/s",
    }


def test_units_of_a_structure_are_not_those_of_another(tmp_path):
    own = {"time": TIME, "rudder": RUDDER, "units": {"time": "s", "rudder": "deg"}}
    other = {"time": TIME, "heading": HEADING, "rudder": np.radians(RUDDER),
             "units": {"time": "s", "heading": "deg", "rudder": "rad"}}  # fmt: skip
    savemat(tmp_path / "log.mat", {"logger": own, "plant": other})
    found = draft(tmp_path / "log.mat").columns
    assert sorted(one.unit for one in found if one.column == "rudder") == ["deg", "rad"]


def test_packed_numbers_are_unpacked(tmp_path):
    packed = np.round(RUDDER / 0.5 - 8.0).astype(np.int16)
    packed[5] = -999
    ship = {
        "time": (TIME, {"units": "s"}),
        "heading": (HEADING, {"units": "deg"}),
        "rudder": (packed, {"units": "deg", "scale_factor": 0.5, "add_offset": 4.0, "_FillValue": np.int16(-999)}),
    }
    values = draft(stored(tmp_path / "log.h5", {"ship": ship})).series("log.h5 [ship]", "rudder")[1]
    assert np.flatnonzero(np.isnan(values)).tolist() == [5]
    assert np.delete(values, 5) == pytest.approx(np.delete(RUDDER, 5), abs=0.26)


@pytest.mark.parametrize(
    ("header", "factor"),
    [("[1/10 s]", 0.1), ("[0.1 s]", 0.1), ("[100 ms]", 0.1), ("[s/10]", 0.1), ("[ds]", 0.1), ("[cs]", 0.01),
     ("[10 ms]", 0.01), ("[s]", 1.0), ("(0.1 s)", 0.1)],
)  # fmt: skip
def test_a_time_in_parts_of_a_second(tmp_path, header, factor):
    path = text(tmp_path, f"Time {header},Heading [deg],Rudder [deg]", time=5.0 * np.arange(N))
    (record,) = draft(path).import_log().records
    assert record.dt == pytest.approx(5.0 * factor)


@pytest.mark.parametrize("header", ["Time [7 s]", "Time step", "Time index", "Time"])
def test_a_time_whose_unit_is_not_known_is_asked(tmp_path, header):
    path = text(tmp_path, f"{header},Heading [deg],Rudder [deg]", time=5.0 * np.arange(N))
    assert [question.about for question in draft(path).questions if question.about == "time"] == ["time"]


def test_a_row_of_units_against_the_header_is_asked(tmp_path):
    path = text(tmp_path, "t [s],Heading [deg],Rudder [deg]", "s,deg,rad")
    assert [q.about for q in draft(path).questions] == ["unit"]
    same = text(tmp_path, "t [s],Heading [deg],Rudder [deg]", "s,deg,degrees", name="same.csv")
    assert columns(same)["Rudder"] == ("rudder", "deg")


@pytest.mark.parametrize(("header", "asked"), [("Transverse speed stern [m/s]", True), ("Engine rpm", False)])
def test_words_that_change_the_meaning(tmp_path, header, asked):
    """The sway of the stern is asked; revolutions of an engine are no propeller's."""
    lines = [f"{t:g},{h:.4f},{r:.4f},{3.0 + r / 50.0:.4f}" for t, h, r in zip(TIME, HEADING, RUDDER, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"t [s],Heading [deg],Rudder [deg],{header}", *lines]), "utf-8")
    found = draft(path)
    assert bool(found.questions) == asked
    assert asked or next(one for one in found.columns if "ngine" in one.column).quantity == "not used"


@pytest.mark.parametrize("name", ["Heading (math, 0=East) [deg]", "Heading (0 = East, CCW) [deg]"])
def test_a_heading_from_east_counts_from_there(tmp_path, name):
    """Whatever is asked of it: with the answer 'heading' it counts counterclockwise from east."""
    path = text(tmp_path, f't [s],"{name}",Rudder [deg]')
    found = draft(path)
    while found.questions:
        first = found.questions[0]
        wanted = ("heading", "counterclockwise from east")
        found = found.answer({first.id: next((a.key for a in first.answers if a.key in wanted), first.answers[0].key)})
    heading = found.import_log().records[0].heading_unwrapped()
    expected = np.radians(90.0 - HEADING)
    assert np.diff(heading) == pytest.approx(np.diff(expected), abs=1e-4)
    assert np.remainder(heading[0] - expected[0] + np.pi, 2.0 * np.pi) == pytest.approx(np.pi, abs=1e-4)


@pytest.mark.parametrize(("low", "used"), [(0.0, False), (2.5, False), (-50.0, True)])
def test_a_rudder_in_per_cent_or_volts_that_stays_on_one_side_is_not_used(tmp_path, low, used):
    rudder = low + (50.0 if low <= 0.0 else 1.0) * (1.0 + RUDDER / 20.0)
    lines = [f"{t:g},{h:.4f},{r:.4f}" for t, h, r in zip(TIME, HEADING, rudder, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([f"t [s],Heading [deg],Rudder [{'V' if low > 0.0 else '%'}]", *lines]), "utf-8")
    found = next(one for one in draft(path).columns if one.column == "Rudder")
    assert (found.quantity == "rudder") == used and (used or "amidships is not stated" in found.why)


def canboat(tmp_path, **fields):
    """A heading, and a rudder of two instances, with fields beside."""
    lines = []
    for t, h, r in zip(TIME, HEADING, RUDDER, strict=True):
        stamp = f"2026-03-01-10:00:{t:06.3f}"
        lines.append({"timestamp": stamp, "src": 1, "pgn": 127250, "fields": {"Heading": round(h, 2), **fields}})
        for instance, angle in ((0, r), (1, -r)):
            own = {"Instance": instance, "Position": round(angle, 2)}
            lines.append({"timestamp": stamp, "src": 2, "pgn": 127245, "fields": own})
    path = tmp_path / "log.json"
    path.write_text("\n".join(json.dumps(line) for line in lines), "utf-8")
    return path


@pytest.mark.parametrize(
    ("reference", "quantity"),
    [("Magnetic", "heading_magnetic"), ({"value": 1, "name": "Magnetic"}, "heading_magnetic"), (1, "heading_magnetic"),
     ({"value": 0, "name": "True"}, "heading"), ("True", "heading"), (0, "heading")],
)  # fmt: skip
def test_the_north_of_a_heading_of_nmea_2000(tmp_path, reference, quantity):
    found = draft(canboat(tmp_path, Reference=reference))
    assert [one.quantity for one in found.columns if "heading" in one.column] == [quantity]
    assert any("both a rudder" in question.text for question in found.questions)


def nmea(sentence):
    total = 0
    for letter in sentence:
        total ^= ord(letter)
    return f"${sentence}*{total:02X}"


@pytest.mark.parametrize("mode", ["N", "A"])
def test_a_speed_without_a_fix_is_no_measurement(tmp_path, mode):
    lines = []
    for t, h, r in zip(TIME, HEADING, RUDDER, strict=True):
        stamp = f"2026-03-01T10:00:{t:06.3f}Z"
        own = "N" if mode == "N" and 10.0 <= t < 20.0 else "A"
        for sentence in (f"HEHDT,{h:.2f},T", f"IIRSA,{r:.2f},A,,V", f"GPVTG,{h:.1f},T,,M,12.0,N,22.2,K,{own}"):
            lines.append(f"{stamp} {nmea(sentence)}")
    (tmp_path / "log.txt").write_text("\n".join(lines), "utf-8")
    found = draft(tmp_path / "log.txt")
    table = next(one.table for one in found.columns if one.column == "speed over ground")
    lost = np.isnan(found.series(table, "speed over ground")[1])
    assert lost.sum() == (20 if mode == "N" else 0)


def test_two_times_of_different_length_are_asked(tmp_path):
    lines = [f"{t:g},{5.0 * t:g},{h:.4f},{r:.4f}" for t, h, r in zip(TIME, HEADING, RUDDER, strict=True)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t a [s],t b [s],Heading [deg],Rudder [deg]", *lines]), "utf-8")
    (question,) = draft(path).questions
    assert "do not last equally long" in question.text
    key = next(answer.key for answer in question.answers if answer.key.startswith("t b"))
    assert draft(path).answer({question.id: key}).import_log().records[0].dt == pytest.approx(2.5)


@pytest.mark.parametrize("zone", ["", "Z"])
def test_a_clock_in_utc_and_one_of_unknown_zone_are_not_joined(tmp_path, zone):
    """With both in UTC they are, as no channel is in both, and the heading does not follow the rudder."""
    rudder = 20.0 * np.sign(np.sin(TIME**1.5))
    for name, column, values in (("gyro", "Heading [deg]", HEADING), ("rudder", "Rudder [deg]", rudder)):
        own = "Z" if name == "gyro" else zone
        lines = [f"2026-03-14T10:00:{t:06.3f}{own},{v:.4f}" for t, v in zip(TIME, values, strict=True)]
        (tmp_path / f"{name}.csv").write_text("\n".join([f"Time,{column}", *lines]), "utf-8")
    paths = [tmp_path / "gyro.csv", tmp_path / "rudder.csv"]
    found = helmbench.draft_import(paths, positive_rudder="starboard")
    if zone:
        assert found.import_log().records[0].n > 50
    else:
        with pytest.raises(helmbench.BadInput, match="One of them states no offset from UTC"):
            found.import_log()


def test_numbers_of_lines_beside_sentences_are_no_time(tmp_path):
    pairs = zip(HEADING, RUDDER, strict=True)
    sentences = [text for h, r in pairs for text in (f"HEHDT,{h:.2f},T", f"IIRSA,{r:.2f},A,,V")]
    lines = [f"{k}: {nmea(sentence)}" for k, sentence in enumerate(sentences, start=1)]
    (tmp_path / "log.txt").write_text("\n".join(lines), "utf-8")
    with pytest.raises(helmbench.BadInput, match="time"):
        draft(tmp_path / "log.txt")


def test_an_hour_without_rows_is_told(tmp_path):
    """As where a local clock goes to summer time."""
    path = text(tmp_path, "t [s],Heading [deg],Rudder [deg]", time=TIME + np.where(TIME > 15.0, 3599.5, 0.0))
    faults = [fault for fault in draft(path).import_log().report.faults if "no row for" in fault.message]
    assert len(faults) == 1 and "3600 s" in faults[0].message


def test_columns_of_parquet_of_every_type_are_named(tmp_path):
    frame = pd.DataFrame({"Heading [deg]": HEADING, "Rudder [deg]": [Decimal(f"{r:.3f}") for r in RUDDER]})
    frame["mode"] = pd.Categorical(["auto"] * N)
    frame["pair"] = [[1.0, 2.0]] * N
    frame.insert(0, "elapsed", pd.to_timedelta(TIME, unit="s"))
    frame.to_parquet(tmp_path / "log.parquet")
    found = draft(tmp_path / "log.parquet")
    told = {one.column: one.quantity for one in found.columns}
    assert told == {
        "elapsed": "time",
        "Heading [deg]": "heading",
        "Rudder [deg]": "rudder",
        "mode": "not used",
        "pair": "not used",
    }
    assert found.import_log().records[0].dt == pytest.approx(0.5)


@pytest.mark.parametrize(("per_second", "form"), [(1e3, "milliseconds"), (1e6, "microseconds")])
def test_a_unit_of_time_that_no_log_has_is_asked(per_second, form, tmp_path):
    path = text(tmp_path, "time [s],heading [deg],rudder [deg]", time=per_second * TIME)
    found = draft(path)
    (question,) = (one for one in found.questions if one.about == "time")
    assert "no log is written" in question.text
    assert {"seconds", form} <= {answer.key for answer in question.answers}


@pytest.mark.parametrize("first", ["", "#"])
def test_a_row_of_units_with_nothing_over_the_time(tmp_path, first):
    path = tmp_path / "log.csv"
    rows = (
        f"2026-03-04 10:00:{t:04.1f};{h:.2f};{r:.1f};{60.0 + t:.1f};12.5"
        for t, h, r in zip(TIME, HEADING, RUDDER, strict=True)
    )
    path.write_text(
        "\n".join(["Time;Heading;Rudder;Propeller.1.RPM;Wind.1.Speed", f"{first};deg;deg;%;kn", *rows]), "utf-8"
    )
    assert columns(path) == {
        "Time": ("time", "iso"), "Heading": ("heading", "deg"), "Rudder": ("rudder", "deg"),
        "Wind.1.Speed": ("wind_speed", "kn"),
    }  # fmt: skip


def test_the_axes_and_the_time_step_above_a_table_of_codes(tmp_path):
    yaw, rate = np.radians(HEADING - 90.0), 4.0 * np.cos(TIME / 5.0)
    north, east = np.cumsum(np.cos(yaw)), np.cumsum(np.sin(yaw))
    legend = ["; AXES: X FORWARD, Y PORT, Z UP", "; CH1 rudder angle [deg] positive = port",
              "; CH2 Rate gyro Z [deg/s]", "; Sample interval 0.5 s",
              "SAMPLE,CH1,CH2,PSI [deg],XO [m],YO [m],VM [m/s]"]  # fmt: skip
    rows = np.column_stack([-RUDDER, -rate, -np.degrees(yaw), north, -east, 0.02 * rate])
    lines = [f"{i}," + ",".join(f"{x:.6f}" for x in row) for i, row in enumerate(rows)]
    path = tmp_path / "run.out"
    path.write_text("\n".join([*legend, *lines]), "utf-8")
    (found,) = helmbench.import_log([path]).records
    assert found.meta.positive_rudder == "port"
    np.testing.assert_allclose(found.time_s, TIME)
    truth = {"heading_rad": yaw, "yaw_rate_rad_s": np.radians(rate), "north_m": north, "east_m": east}
    for channel, values in truth.items():
        np.testing.assert_allclose(found.column(channel), values, atol=1e-5, err_msg=channel)


def test_the_whole_of_per_cent_is_stated_in_a_comment(tmp_path):
    path = text(tmp_path, "time [s],heading [deg],rudder [%]", name="log.csv")
    path.write_text(f"# rudder: 100 % = 45 deg starboard\n{path.read_text('utf-8')}", "utf-8")
    (found,) = helmbench.import_log([path], positive_rudder="starboard").records
    np.testing.assert_allclose(np.degrees(found.rudder()), 0.45 * RUDDER, atol=1e-3)


def test_x_and_y_in_degrees_are_no_metres(tmp_path):
    rows = np.column_stack([4.0 * TIME, 10.3 + 1e-4 * TIME, 54.42 + 0.0 * TIME, HEADING, RUDDER])
    path = tmp_path / "log.csv"
    lines = [",".join(f"{x:.6f}" for x in row) for row in rows]
    path.write_text("\n".join(["time [s],X,Y,heading [deg],rudder [deg]", *lines]), "utf-8")
    assert columns(path)["X"] == ("longitude", "deg") and columns(path)["Y"] == ("latitude", "deg")


@pytest.mark.parametrize("form", ["HDG:{:05.1f} RUD:{}{:04.1f} ROT:{:+06.1f}", "hdg={:.1f} rud={}{:.1f} rot={:.2f}"])
def test_lines_of_names_and_values_with_sides(tmp_path, form):
    rates = 60.0 * np.gradient(HEADING, TIME)
    lines = [
        f"[10:00:{t:06.3f}] " + form.format(h, "R" if r >= 0.0 else "L", abs(r), rate)
        for t, h, r, rate in zip(TIME, HEADING, RUDDER, rates, strict=True)
    ]
    path = tmp_path / "capture.log"
    path.write_text("\n".join(["*** capture started ***", *lines]), "utf-8")
    rudder = next(one for one in draft(path).columns if one.column.lower() == "rud")
    assert (rudder.quantity, rudder.sign) == ("rudder", "positive to starboard") and rudder.smallest < -19.0


def test_messages_of_nmea_2000_as_actisense_prints_them(tmp_path):
    lines = []
    for t, h, r in zip(TIME, HEADING, RUDDER, strict=True):
        stamp = f"A1000{t:06.3f}"
        own = (round(np.radians(x) * 1e4).to_bytes(2, "little", signed=x is r).hex().upper() for x in (h, r))
        lines += [f"{stamp} 23FF2 1F112 01{next(own)}FF7FFF7FFC", f"{stamp} 2CFF2 1F10D 00F8FF7F{next(own)}FFFF"]
    path = tmp_path / "n2k.txt"
    path.write_text("\n".join(lines), "utf-8")
    (found,) = helmbench.import_log([path], positive_rudder="starboard").records
    np.testing.assert_allclose(np.degrees(found.column("heading_rad")), HEADING, atol=0.01)
    np.testing.assert_allclose(found.time_s, TIME, atol=1e-6)


@pytest.mark.parametrize("units", ["SI, rad", ""])
def test_series_with_a_time_each_are_asked_together(tmp_path, units):
    yaw = np.radians(HEADING)
    series = {"psi": yaw, "r": np.gradient(yaw, TIME), "u": 7.0 + 0.1 * np.sin(TIME / 5.0), "delta": np.radians(RUDDER)}
    log = {name: {"Time": TIME, "Data": values} for name, values in series.items()}
    savemat(tmp_path / "run.mat", {"log": log, "meta": {"frame": "NED", **({"units": units} if units else {})}})
    found = draft(tmp_path / "run.mat")
    asked = [question for question in found.questions if question.about in ("unit", "columns")]
    assert len(asked) == (0 if units else 1)
    if not units:
        assert all(name in asked[0].text for name in ("delta is rudder", "u is surge"))
    assert {one.column: one.unit for one in found.columns if one.column in ("psi", "delta")} == {
        "psi": "rad",
        "delta": "rad",
    }


def test_a_rudder_that_is_stuck_beside_one_that_moves_is_not_used(tmp_path, rng):
    stuck = -2.0 + 0.05 * rng.standard_normal(N)
    rows = np.column_stack([TIME, HEADING, stuck, RUDDER])
    lines = [",".join(f"{x:.4f}" for x in row) for row in rows]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],heading [deg],rudder port [deg],rudder stbd [deg]", *lines]))
    assert "rudder stbd" in columns(tmp_path / "log.csv") and "rudder port" not in columns(tmp_path / "log.csv")
