"""Cells with letters: sides and units behind a number, hemispheres, clocks in words, and what AIS sends for a rate."""

import datetime
import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

import helmbench

pytestmark = pytest.mark.usefixtures("logs_read_here")
N = 240
TIME = np.arange(float(N))
YAW_RATE = 0.4 * np.cos(TIME / 20.0)
HEADING = 90.0 + 8.0 * np.sin(TIME / 20.0)
RUDDER = 12.0 * np.cos(TIME / 20.0 + 0.5)
"""deg/s, deg, deg; positive to starboard."""


def write(tmp_path, header, *columns, encoding="utf-8"):
    path = tmp_path / "log.csv"
    path.write_bytes("\n".join([header, *map(";".join, zip(*columns, strict=True))]).encode(encoding))
    return path


def record(path):
    (found,) = helmbench.import_log([path], positive_rudder="starboard").records
    return found


def sided(values, starboard, port, form="{:.1f}{}"):
    return [form.format(abs(value), starboard if value >= 0.0 else port) for value in values]


def plain(values):
    return [f"{value:.2f}" for value in values]


@pytest.mark.parametrize(
    ("starboard", "port", "name"),
    [(" E", " B", "Ángulo de timón"), ("°S", "°P", "Rudder"), (" п/б", " л/б", "Положение руля"),
     (" Stb", " Bb", "Ruderlage"), (" T", " B", "Angle de barre"), (" deg S", " deg P", "Rudder")],
)  # fmt: skip
def test_a_rudder_with_the_letters_of_its_side(tmp_path, starboard, port, name):
    unit = "" if {"°", "d"} & {*starboard} else " [deg]"
    path = write(
        tmp_path, f"time [s];heading [deg];{name}{unit}", plain(TIME), plain(HEADING), sided(RUDDER, starboard, port)
    )
    found = record(path)
    assert_allclose(np.degrees(found.column("rudder_rad")), RUDDER, atol=0.06)


def test_a_rate_with_its_unit_and_side(tmp_path):
    rates = sided(60.0 * YAW_RATE, "°/min S", "°/min P")
    path = write(
        tmp_path,
        "time [s];Heading;Rate of Turn;rudder [deg]",
        plain(TIME),
        [f"{h:.2f}°T" for h in HEADING],
        rates,
        plain(RUDDER),
    )
    assert_allclose(np.degrees(record(path).column("yaw_rate_rad_s")), YAW_RATE, atol=0.002)


@pytest.mark.parametrize(
    ("form", "names", "encoding"),
    [
        ("59°{:06.3f}'с.ш.|28°06,000'в.д.", "Широта;Долгота", "cp1251"),
        ("59-{:07.4f}N|028-06.0000E", "Lat;Lon", "utf-8"),
    ],
)
def test_degrees_and_minutes_with_their_hemispheres(tmp_path, form, names, encoding):
    cells = [form.format(30.0 + t / 300.0).replace(".", ",", form.count(",") and 1).split("|") for t in TIME]
    latitudes, longitudes = zip(*cells, strict=True)
    header = (
        "time [s];Широта;Долгота;heading [deg];rudder [deg]"
        if encoding == "cp1251"
        else "time [s];Lat;Lon;heading [deg];rudder [deg]"
    )
    found = record(
        write(tmp_path, header, plain(TIME), latitudes, longitudes, plain(HEADING), plain(RUDDER), encoding=encoding)
    )
    north = found.column("north_m")
    assert_allclose(north - north[0], 1857.0 * TIME / 300.0, atol=3.0)


def test_the_letter_s_is_south_of_a_latitude_and_starboard_of_a_speed_sideways(tmp_path):
    sway = sided(0.3 * np.cos(TIME / 20.0), " S", " P", "{:.2f}{}")
    header = "time [s];Lat;Lon;heading [deg];rudder [deg];surge [m/s];Lateral speed [m/s]"
    columns = ([f"{33.0 + t / 1e4:.5f} deg S" for t in TIME], [f"{71.0 + t / 1e5:.5f} deg W" for t in TIME])
    found = record(
        write(tmp_path, header, plain(TIME), *columns, plain(HEADING), plain(RUDDER), plain(11.2 + 0.01 * RUDDER), sway)
    )
    north = found.column("north_m")
    assert north[-1] < north[0] - 1000.0
    assert_allclose(found.column("sway_m_s"), 0.3 * np.cos(TIME / 20.0), atol=0.006)


def clock(second, form):
    hour, minute = 11 + int(second + 3500) // 3600, int(second + 3500) // 60 % 60
    return form.format(
        hour=hour,
        twelve=(hour - 1) % 12 + 1,
        half="p" if hour > 11 else "a",
        minute=minute,
        second=int(second + 3500) % 60,
    )


@pytest.mark.parametrize(
    ("form", "header"),
    [("{twelve}:{minute:02}:{second:02} {half}. m.", "Hora"), ("{hour}h{minute:02}m{second:02}s", "Heure"),
     ("{hour} h {minute:02} min {second:02}", "Heure"),
     ("14/07/2026 {hour}h{minute:02}min{second:02}", "Date et heure"),
     ("2026-07-14 {hour}:{minute:02}:{second:02}.000000000 +0200 CEST", "time")],
)  # fmt: skip
def test_clocks_as_people_write_them(tmp_path, form, header):
    times = [clock(t, form) for t in TIME]
    found = record(write(tmp_path, f"{header};heading [deg];rudder [deg]", times, plain(HEADING), plain(RUDDER)))
    assert_allclose(found.column("time_s"), TIME)


def test_the_indicator_of_ais_is_no_rate(tmp_path):
    rates = 60.0 * YAW_RATE
    sent = np.round(4.733 * np.sign(rates) * np.sqrt(np.abs(rates)))
    sent[5], sent[9] = -128, 127
    rows = [{"MMSI": 211000000, "time_s": t, "TrueHeading": round(h, 1), "RateOfTurn": int(r), "Sog": 12.3, "Cog": 91.5}
            for t, h, r in zip(TIME, HEADING, sent, strict=True)]  # fmt: skip
    path = tmp_path / "ais.jsonl"
    path.write_text("\n".join(map(json.dumps, rows)), "utf-8")
    (found,) = helmbench.import_log([path]).records
    made = np.degrees(found.column("yaw_rate_rad_s"))
    assert np.flatnonzero(np.isnan(made)).tolist() in ([5, 9], [])
    assert_allclose(np.delete(made, [5, 9]), np.delete(YAW_RATE, [5, 9]), atol=0.03)


@pytest.mark.parametrize(
    ("header", "ahead"),
    [("Time (UTC+2)", 2.0), ("Zeit (MESZ)", 2.0), ("time [GMT-3:30]", -3.5), ("UTC+5.5", 5.5), ("time UTC", 0.0)],
)
def test_a_zone_in_the_header_is_taken_off(tmp_path, header, ahead):
    times = [f"2026-07-14 10:{int(t) // 60:02}:{int(t) % 60:02}" for t in TIME]
    found = record(write(tmp_path, f"{header};heading [deg];rudder [deg]", times, plain(HEADING), plain(RUDDER)))
    start = datetime.datetime.fromisoformat(found.meta.extra["start_utc"])
    assert start == datetime.datetime(2026, 7, 14, 10, tzinfo=datetime.UTC) - datetime.timedelta(hours=ahead)


@pytest.mark.parametrize(("date", "asked"), [("311226", False), ("20261231", False), ("120326", True)])
def test_a_date_and_a_clock_in_digits(tmp_path, date, asked):
    seconds = 86400 - 2 * N + 4 * TIME if date == "311226" else 36000 + 4 * TIME
    clocks = [f"{int(s) // 3600 % 24:02}{int(s) // 60 % 60:02}{int(s) % 60:02}.00" for s in seconds]
    dates = ["010127" if s >= 86400 else date for s in seconds]
    minutes = 3.0001 + TIME * 4.0 * 6.0 / 1852.0
    place = ([f"23{minute:07.4f}" for minute in minutes], ["N"] * N, ["04306.0000"] * N, ["W"] * N)
    speeds = plain(np.full(N, 11.66) + 0.01 * RUDDER)
    header = "date;utc;lat;ns;lon;ew;hdt;rudder [deg];sog"
    path = write(tmp_path, header, dates, clocks, *place, plain(HEADING), plain(RUDDER), speeds)
    draft = helmbench.draft_import([path], positive_rudder="starboard")
    assert [question.about for question in draft.questions] == ["time"] * asked
    assert next(one.unit for one in draft.columns if one.column == "sog") == "kn"
    if not asked:
        (found,) = draft.import_log().records
        assert found.column("time_s")[-1] == 4.0 * TIME[-1]


@pytest.mark.parametrize(
    ("header", "first", "asked"),
    [("Time (mm:ss)", 600, False), ("Time", 0, False), ("Time", 600, True), ("Time", 1500, False)],
)
def test_a_clock_of_two_parts_is_of_minutes_and_seconds_where_every_row_has_another(tmp_path, header, first, asked):
    times = [f"{int(first + t) // 60:02}:{int(first + t) % 60:02}" for t in TIME]
    draft = helmbench.draft_import(
        [write(tmp_path, f"{header};heading [deg];rudder [deg]", times, plain(HEADING), plain(RUDDER))],
        positive_rudder="starboard",
    )
    assert [question.about for question in draft.questions] == ["time"] * asked
    if not asked:
        assert_allclose(draft.import_log().records[0].time_s, TIME)


def test_points_of_a_database_are_positions(tmp_path):
    points = [f"POINT({28.2 + t / 1e5:.7f} {43.1:.7f})" for t in TIME]
    stamps = [f"2026-07-14 10:{int(t) // 60:02}:{int(t) % 60:02}+00" for t in TIME]
    path = write(tmp_path, "ts;geom;heading [deg];rudder [deg]", stamps, points, plain(HEADING), plain(RUDDER))
    found = record(path)
    assert_allclose(found.column("east_m")[-1], 0.8135 * TIME[-1], rtol=0.01)
    assert found.meta.extra["start_utc"].startswith("2026-07-14T10:00:00")


def test_pages_of_a_print_with_lines_below_their_headers(tmp_path):
    head = ["  TIME      HDG    RUDDER", "  UTC       DEG     DEG", "--------  ------  ------"]
    rows = zip(TIME, HEADING, RUDDER, strict=True)
    lines = [f"10:{int(t) // 60:02}:{int(t) % 60:02}  {h:6.2f}  {r:6.2f}" for t, h, r in rows]
    parts = [[f"   M/V EXAMPLE  DATA  PAGE {k // 60 + 1}", *head, *lines[k : k + 60]] for k in range(0, N, 60)]
    pages = [line for part in parts for line in part]
    path = tmp_path / "print.txt"
    path.write_text("\n".join(pages), "utf-8")
    assert_allclose(np.degrees(record(path).rudder()), RUDDER, atol=0.006)


def test_words_behind_a_unit_belong_to_the_name(tmp_path):
    header = "time [s];heading (degrees true);Helm angle (degrees right rudder);Speed (mph over ground)"
    path = write(tmp_path, header, plain(TIME), plain(HEADING), plain(RUDDER), plain(10.0 + 0.0 * TIME))
    units = {one.column.partition(" ")[0]: (one.quantity, one.unit) for one in helmbench.draft_import([path]).columns}
    assert units["Speed"] == ("speed_over_ground", "mph") and units["Helm"] == ("rudder", "deg")


def test_a_rudder_whose_cells_are_no_numbers_stops_the_import(tmp_path):
    path = write(
        tmp_path, "time [s];heading [deg];Rudder", plain(TIME), plain(HEADING), [f"about {r:.0f}!" for r in RUDDER]
    )
    with pytest.raises(helmbench.BadInput, match="column Rudder: no number: 'about 1"):
        helmbench.import_log([path])
    draft = helmbench.draft_import([path])
    draft.write_mapping(tmp_path / "map.yaml")
    text = (tmp_path / "map.yaml").read_text("utf-8")
    assert "rudder_rad" not in helmbench.import_log([path], mapping=tmp_path / "map.yaml").record.channels, text


def test_objects_in_a_list_and_a_page_of_html(tmp_path):
    rows = [{"time_s": t, "heading_deg": h, "rudder_deg": r, "engines": [{"rpm": 90.0 + r}]}
            for t, h, r in zip(TIME, HEADING, RUDDER, strict=True)]  # fmt: skip
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, rows)), "utf-8")
    assert record(tmp_path / "log.jsonl").has("propeller_rps")
    (tmp_path / "log.xls").write_text("<html><table><tr><td>1</td></tr></table></html>", "utf-8")
    with pytest.raises(helmbench.BadInput, match="a page of HTML"):
        helmbench.draft_import([tmp_path / "log.xls"])


def test_a_clock_that_jumps_within_even_steps_is_told(tmp_path):
    times = plain(TIME + 7.0 * (TIME > 100.0))
    path = write(tmp_path, "time [s];heading [deg];rudder [deg]", times, plain(HEADING), plain(RUDDER))
    (fault,) = helmbench.import_log([path], positive_rudder="starboard").report.faults
    assert "no row for 8 s before this one" in fault.message


def test_a_year_and_the_day_of_it(tmp_path):
    days = [f"{73.0 + t / 86400.0:.8f}" for t in TIME]
    path = write(
        tmp_path, "Year;DayOfYear;heading [deg];rudder [deg]", ["2026"] * N, days, plain(HEADING), plain(RUDDER)
    )
    found = record(path)
    assert_allclose(found.time_s, TIME, atol=2e-3)
    assert found.meta.extra["start_of_unknown_zone"].startswith("2026-03-14T00:00:00")
