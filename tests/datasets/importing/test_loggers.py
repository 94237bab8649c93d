"""What devices and people write: times, tables in long form, names, places and files, a small log each."""

import datetime
import struct

import numpy as np
import openpyxl
import pytest
import scipy.io
from numpy.testing import assert_allclose

import helmbench

pytestmark = pytest.mark.usefixtures("logs_read_here")
N = 200
TIME = 0.5 * np.arange(N)
HEADING, YAW_RATE = 90.0 + 40.0 * np.sin(TIME / 8.0), 5.0 * np.cos(TIME / 8.0)
RUDDER = 20.0 * np.cos(TIME / 8.0 + 0.6)
"""deg, deg/s; positive to starboard."""
START = datetime.datetime(2026, 5, 3, 23, 59, 10)
SHIP = {"heading [deg]": HEADING, "yaw rate [deg/s]": YAW_RATE, "rudder [deg]": RUDDER}
ANGLES = ("heading", "yaw_rate", "rudder")


def written(path, columns, sep=","):
    """A table of numbers and texts."""
    texts = [[value if isinstance(value, str) else f"{value:.9g}" for value in values] for values in columns.values()]
    path.write_text("\n".join([sep.join(columns), *(sep.join(row) for row in zip(*texts, strict=True))]), "utf-8")
    return path


def lines(path, texts):
    path.write_text("\n".join(texts), "utf-8")
    return path


def draft_of(path):
    return helmbench.draft_import([path])


def quantities_of(draft):
    return {row.column: row.quantity for row in draft.columns}


def assert_is_the_ship(record, shown=TIME):
    assert_allclose(record.time_s - record.time_s[0], shown - shown[0], atol=1e-6)
    assert_allclose(np.degrees(record.column("heading_rad")), HEADING, atol=0.01)
    assert_allclose(np.degrees(record.column("yaw_rate_rad_s")), YAW_RATE, atol=0.01)
    assert_allclose(np.degrees(record.rudder()), RUDDER, atol=0.01)


def stamps(form):
    return [(START + datetime.timedelta(seconds=t)).strftime(form) for t in TIME]


# ------------------------------------------------------------------------------------------------ times


@pytest.mark.parametrize(
    "name, texts",
    [
        ("日時", [text[:-7] + text[-7:-5] + "秒" for text in stamps("%Y年%m月%d日 %H時%M分%S.%f")]),
        ("", [f"0 days 00:{int(t // 60):02d}:{t % 60:09.6f}" for t in TIME]),
        ("Time", [text[:-5] for text in stamps("%M:%S.%f")]),
        ("Time", [text[:-5] for text in stamps("%I:%M:%S.%f")]),
        ("Date/Time", [text[:-5] for text in stamps("%d/%m/%Y %H:%M:%S.%f")]),
        ("time_ms", [str((60_000 + 500 * i) % 65536) for i in range(N)]),
        ("Time of day [s]", [86_350.0 + t if t < 50.0 else t - 50.0 for t in TIME]),
    ],
    ids=["Japanese", "pandas", "minutes past the hour", "twelve hours", "day at midnight", "16 bits", "seconds of day"],
)
def test_forms_of_a_time(tmp_path, name, texts):
    draft = draft_of(written(tmp_path / "log.csv", {name: texts, **SHIP}))
    assert draft.questions == ()
    (record,) = draft.import_log().records
    assert_is_the_ship(record)


def test_a_day_that_changes_at_midnight_tells_its_place_in_the_date(tmp_path):
    (record,) = helmbench.import_log([written(tmp_path / "a.csv", {"t": stamps("%d/%m/%Y %H:%M:%S"), **SHIP})]).records
    assert record.meta.extra["start_of_unknown_zone"].startswith("2026-05-03T23:59:10")


def test_a_run_that_starts_again_is_no_clock_that_goes_on(tmp_path):
    twice = {name: np.concatenate([values, values]) for name, values in SHIP.items()}
    path = written(tmp_path / "twice.csv", {"t [s]": np.concatenate([TIME, TIME]), **twice})
    assert len(helmbench.import_log([path]).records) == 2


def test_of_a_local_and_a_utc_time_the_latter_is_taken(tmp_path):
    local = [(START + datetime.timedelta(hours=2, seconds=t)).isoformat() for t in TIME]
    utc = [(START + datetime.timedelta(seconds=t)).isoformat() for t in TIME]
    (record,) = helmbench.import_log(
        [written(tmp_path / "a.csv", {"Local Time": local, "UTC Time": utc, **SHIP})]
    ).records
    assert record.meta.extra["start_utc"].startswith("2026-05-03T23:59:10")


def test_a_gap_in_the_time_does_not_hide_the_side_of_a_yaw_rate(tmp_path):
    shown = np.where(TIME > 20.0, TIME + 3600.0, TIME)
    columns = {"t [s]": shown, **SHIP, "yaw rate [deg/s]": -YAW_RATE}
    (row,) = [r for r in draft_of(written(tmp_path / "a.csv", columns)).columns if r.quantity == "yaw_rate"]
    assert (row.sign, row.questions) == ("positive to port", ())


# ------------------------------------------------------------------------------------------------ long form


@pytest.mark.parametrize(
    "header, row",
    [
        ("timestamp,path,value,source", "{t},{path},{si:.9g},n2k.4"),
        ("time;sensor;value;unit", "{t};{name};{deg:.9g};{unit}"),
    ],
    ids=["paths of Signal K", "sensors with units"],
)
def test_values_in_rows_of_their_own(tmp_path, header, row):
    kinds = [
        ("navigation.headingTrue", "Heading", "deg", HEADING),
        ("navigation.rateOfTurn", "Rate of turn", "deg/s", YAW_RATE),
        ("steering.rudderAngle", "Rudder angle", "deg", RUDDER),
    ]
    rows = [
        row.format(t=f"2026-03-14T10:{int(t // 60):02d}:{t % 60:04.1f}Z", path=path, name=name, unit=unit,
                   deg=values[i], si=np.radians(values[i]))
        for i, t in enumerate(TIME) for path, name, unit, values in kinds
    ]  # fmt: skip
    draft = draft_of(lines(tmp_path / "long.csv", [header, *rows]))
    assert draft.questions == ()
    assert_is_the_ship(draft.import_log().records[0])


def test_servos_of_one_table_are_told_apart(tmp_path):
    """Four fins in turn: values of different fins are not one rudder."""
    fins = (0.0 * RUDDER, RUDDER, 0.0 * RUDDER + 1.0, -RUDDER)
    stamp = [f"{1773480413.0 + t:.1f}" for t in TIME]
    rows = [f"{t},{fin},{np.radians(own[i]):.6f}" for i, t in enumerate(stamp) for fin, own in enumerate(fins)]
    lines(tmp_path / "ServoPosition.csv", ["timestamp,id,value (rad)", *rows])
    written(tmp_path / "state.csv", {"timestamp": stamp, **{k: v for k, v in SHIP.items() if "rudder" not in k}})
    draft = helmbench.draft_import([tmp_path / "ServoPosition.csv", tmp_path / "state.csv"])
    (question,) = [q for q in draft.questions if q.id == "rudder"]
    assert "id 1" in question.text and "id 3" in question.text and "value" not in question.text


# ------------------------------------------------------------------------------------------------ names and cells


@pytest.mark.parametrize(
    "name, values, quantity",
    [
        ("r' [-]", 0.1 * YAW_RATE, "not used"),
        ("Delta [s]", 0.0 * TIME + 0.5, "not used"),
        ("Rudder PORT [deg]", 0.0 * TIME, "not used"),
        ("Magnetic heading [deg]", HEADING - 4.0, "not used"),
        ("GyroY [deg/s]", 0.1 * YAW_RATE, "not used"),
        ("x_east [m]", 3.0 * TIME, "east"),
        ("vx_east [m/s]", 0.0 * TIME + 3.0, "velocity_east"),
        ("SMG [kn]", 0.0 * TIME + 3.0, "speed_over_ground"),
    ],
)
def test_a_further_column_that_asks_nothing(tmp_path, name, values, quantity):
    draft = draft_of(written(tmp_path / "log.csv", {"t [s]": TIME, **SHIP, name: values}))
    assert draft.questions == ()
    assert draft.columns[-1].quantity == quantity


def test_a_speed_called_v_is_no_sway(tmp_path):
    draft = draft_of(written(tmp_path / "log.csv", {"t [s]": TIME, **SHIP, "V [m/s]": 6.0 + 0.1 * YAW_RATE}))
    (question,) = draft.questions
    assert [answer.key for answer in question.answers][:2] == ["speed_over_ground", "speed_through_water"]


@pytest.mark.parametrize(
    "header, rudder",
    [
        ("Rudder [% of 35 deg]", RUDDER / 0.35),
        ("Ruderlage (°) BB negativ / StB positiv", RUDDER),
        ("delta_r_act [deg]", RUDDER),
        ("Roerhoek [graden]", RUDDER),
    ],
)
def test_what_the_header_of_a_rudder_states(tmp_path, header, rudder):
    columns = {k: v for k, v in SHIP.items() if "rudder" not in k}
    draft = draft_of(written(tmp_path / "log.csv", {"t [s]": TIME, **columns, header: rudder}, sep=";"))
    assert draft.questions == ()
    assert_is_the_ship(draft.import_log().records[0])


def test_a_heading_in_radians_that_goes_beyond_a_turn_is_not_taken_for_degrees(tmp_path):
    turning = 5.0 + 0.05 * TIME + 0.2 * np.sin(TIME / 8.0)
    draft = draft_of(
        written(tmp_path / "log.csv", {"t [s]": TIME, "heading": turning, "rudder [rad]": np.radians(RUDDER)})
    )
    (row,) = [row for row in draft.columns if row.quantity == "heading"]
    assert row.unit in ("", "rad") and draft.questions


def test_an_east_in_a_name_with_underscores_says_from_where_a_yaw_counts(tmp_path):
    columns = {"t [s]": TIME, "yaw_enu_rad": np.radians(90.0 - HEADING), "rudder [deg]": RUDDER}
    (record,) = helmbench.import_log([written(tmp_path / "log.csv", columns)]).records
    assert_allclose(np.degrees(record.column("heading_rad")) % 360.0, HEADING, atol=0.01)


@pytest.mark.parametrize("name", ["Compass heading [deg]", "HDG [deg]"])
def test_a_heading_beside_a_variation_may_be_magnetic(tmp_path, name):
    columns = {"t [s]": TIME, name: HEADING - 8.0, "Variation [deg]": 0.0 * TIME + 8.0, "rudder [deg]": RUDDER}
    draft = draft_of(written(tmp_path / "log.csv", columns))
    assert {answer.key for answer in draft.questions[0].answers} >= {"heading", "heading_magnetic"}


def test_the_deviation_of_a_compass_is_that_of_each_heading(tmp_path):
    deviation = 10.0 * np.sin(np.radians(HEADING))
    stated = {"Deviation [deg]": deviation, "Variation [deg]": 0.0 * TIME + 8.0}
    columns = {"t [s]": TIME, "Magnetic heading [deg]": HEADING - deviation - 8.0, "rudder [deg]": RUDDER} | stated
    draft = draft_of(written(tmp_path / "log.csv", columns))
    draft = draft.answer({question.id: "east" for question in draft.questions})
    assert_allclose(np.degrees(draft.import_log().records[0].column("heading_rad")), HEADING, atol=0.01)


def test_degrees_and_minutes_in_columns_of_their_own(tmp_path):
    minutes = 25.0 + 0.003 * TIME
    place = {"Lat [deg]": 0.0 * TIME + 54.0, "Lat [min]": minutes, "Lon [deg]": 0.0 * TIME + 10.0, "Lon [min]": minutes}
    letters = {**dict(list(place.items())[:2]), "N/S": ["S"] * N, **dict(list(place.items())[2:]), "E/W": ["W"] * N}
    for columns, sign in ((place, 1.0), (letters, -1.0)):
        (record,) = helmbench.import_log([written(tmp_path / "log.csv", {"t [s]": TIME, **SHIP, **columns})]).records
        north, east = record.column("north_m"), record.column("east_m")
        assert sign * (north[-1] - north[0]) == pytest.approx(0.003 * TIME[-1] * 1855.4, rel=2e-3)
        assert sign * (east[-1] - east[0]) > 50.0


def test_a_latitude_and_a_longitude_in_one_cell(tmp_path):
    places = [f"54° {25.0 + 0.003 * t:.5f}' N 010° {18.0 + 0.001 * t:.5f}' E" for t in TIME]
    draft = draft_of(written(tmp_path / "log.csv", {"t [s]": TIME, **SHIP, "Position": places}))
    (record,) = draft.import_log().records
    assert draft.questions == ()
    assert record.column("north_m")[-1] - record.column("north_m")[0] == pytest.approx(
        0.003 * TIME[-1] * 1855.4, rel=2e-3
    )


# ------------------------------------------------------------------------------------------------ files


def test_sheets_with_equal_headers_are_runs(tmp_path):
    book = openpyxl.Workbook()
    book.active.title = "Notes"
    book.active.append(["Ship", "X"])
    book.active.append(["Length [m]", 120.0])
    for number in (1, 2):
        sheet = book.create_sheet(f"Zigzag {number}")
        sheet.append(["Time [s]", *SHIP])
        for row in zip(TIME, *(number * values for values in SHIP.values()), strict=True):
            sheet.append([float(value) for value in row])
    book.save(tmp_path / "trials.xlsx")
    draft = draft_of(tmp_path / "trials.xlsx")
    assert draft.questions == ()
    first, second = draft.import_log().records
    assert_is_the_ship(first)
    assert_allclose(second.rudder(), 2.0 * first.rudder(), atol=1e-6)


def test_a_matrix_with_the_names_of_its_columns(tmp_path):
    names = np.empty((1, 4), object)
    names[0, :] = ["t [s]", *SHIP]
    scipy.io.savemat(tmp_path / "log.mat", {"data": np.column_stack([TIME, *SHIP.values()]), "names": names})
    assert_is_the_ship(helmbench.import_log([tmp_path / "log.mat"]).records[0])


def test_a_classic_netcdf_file_by_climate_and_forecast_conventions(tmp_path):
    units = {"heading": "degrees", "yaw_rate": "degree s-1", "rudder": "degrees"}
    with scipy.io.netcdf_file(tmp_path / "log.nc", "w") as file:
        file.createDimension("time", N)
        series = {"time": TIME, **dict(zip(ANGLES, SHIP.values(), strict=True))}
        for name, values in series.items():
            variable = file.createVariable(name, "d", ("time",))
            variable[:] = values
            variable.units = units.get(name, "seconds since 2026-03-14 10:12:07")
    (record,) = helmbench.import_log([tmp_path / "log.nc"]).records
    assert_is_the_ship(record)
    assert record.meta.extra["start_utc"].startswith("2026-03-14T10:12:07")


def test_a_damaged_netcdf_file_is_refused(tmp_path):
    (tmp_path / "a.nc").write_bytes(b"CDF\x01\x00\x00")
    with pytest.raises(helmbench.BadInput, match="netCDF"):
        draft_of(tmp_path / "a.nc")


def test_frames_as_candump_prints_them_on_a_terminal(tmp_path):
    pytest.importorskip("nmea2000")
    texts = []
    for i, t in enumerate(TIME):
        frames = {
            0x09F11204: struct.pack("<BHhhB", i, round(1e4 * np.radians(HEADING[i])), 32767, 32767, 0xFC),
            0x09F11304: struct.pack("<BiBH", i, round(np.radians(YAW_RATE[i]) / 3.125e-8), 255, 65535),
            0x09F10D07: struct.pack("<BBhhH", 0, 0xF8, 32767, round(1e4 * np.radians(RUDDER[i])), 65535),
        }
        texts += [
            f" ({1773480413 + t:.6f})  can0  {key:08X}   [8]  {data.hex(' ').upper()}" for key, data in frames.items()
        ]
    assert_is_the_ship(helmbench.import_log([lines(tmp_path / "can.txt", texts)]).records[0])


def test_messages_as_mission_planner_writes_them(tmp_path):
    texts = []
    for i, t in enumerate(TIME):
        yaw, rate = np.radians((HEADING[i] + 180.0) % 360.0 - 180.0), np.radians(YAW_RATE[i])
        head = f"2026-03-14T10:{int(t // 60):02d}:{t % 60:06.3f},FE,1C,{i % 256:X},0,0,1,1"
        texts.append(
            f"{head},1E,mavlink_attitude_t,time_boot_ms,{500 * i},roll,0,pitch,0,yaw,{yaw:.6f},yawspeed,{rate:.6f},,"
        )
        texts.append(f"{head},24,mavlink_servo_output_raw_t,servo1_raw,{1500 + 10 * RUDDER[i]:.0f},port,0,,")
    draft = draft_of(lines(tmp_path / "tlog.csv", texts))
    found = quantities_of(draft)
    assert (found["yaw"], found["yawspeed"]) == ("heading", "yaw_rate")
    (question,) = draft.questions
    assert question.id == "rudder" and question.without == "none" and "servo1_raw" in question.text


def test_a_joint_is_called_as_its_name_says(tmp_path):
    named = {"header.stamp.sec": TIME // 1.0, "header.stamp.nanosec": 1e9 * (TIME % 1.0)}
    ship = {k: v for k, v in SHIP.items() if "rudder" not in k}
    columns = named | ship | {"name[0]": ["rudder_joint"] * N, "position[0]": np.radians(RUDDER)}
    assert_is_the_ship(helmbench.import_log([written(tmp_path / "joints.csv", columns)]).records[0])


def test_a_roll_of_unknown_sign_is_asked_and_need_not_be_answered(tmp_path):
    draft = draft_of(written(tmp_path / "log.csv", {"t [s]": TIME, **SHIP, "roll [deg]": 0.3 * YAW_RATE}))
    (question,) = draft.questions
    assert (question.about, question.without) == ("sign", "not used")
    (record,) = draft.answer({question.id: question.without}).import_log().records
    assert "roll_rad" not in record.channels
