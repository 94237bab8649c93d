"""The parts of an import: times, cells, names, clocks, positions, manoeuvres."""

import re

import numpy as np
import pyproj
import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.geometry import body_velocities, on_plane
from helmbench.datasets.importing.cells import Texts, decorated, numbers_of, table_style
from helmbench.datasets.importing.clock import guess_form, seconds, spread
from helmbench.datasets.importing.clocks import estimate_offset
from helmbench.datasets.importing.convert import Stream
from helmbench.datasets.importing.headers import read_header, west_or_south
from helmbench.datasets.importing.moments import moment
from helmbench.datasets.importing.names import named
from helmbench.datasets.importing.raw import RawColumn
from helmbench.datasets.importing.reading import frame_stated
from helmbench.datasets.importing.segments import cut, find_segments
from helmbench.datasets.record import Record

NOON = 1773489600.0  # 2026-03-14 12:00 UTC

TIMES = {
    "iso": ["2026-03-14T12:00:00Z", "2026-03-14T12:00:00.500Z", "2026-03-14T12:00:01Z"],
    "iso with a zone": ["2026-03-14T13:00:00+01:00", "2026-03-14T13:00:00.5+01:00", "2026-03-14T13:00:01+01:00"],
    "day first": ["14.03.2026 12:00:00", "14.03.2026 12:00:00,5", "14.03.2026 12:00:01"],
    "month first": ["03/14/2026 12:00:00 PM", "03/14/2026 12:00:00.5 PM", "03/14/2026 12:00:01 PM"],
    "excel": ["46095.5", "46095.500005787", "46095.500011574"],
    "datenum": ["740055.5", "740055.500005787", "740055.500011574"],
    "epoch s": ["1773489600", "1773489600.5", "1773489601"],
    "epoch ms": ["1773489600000", "1773489600500", "1773489601000"],
}


@pytest.mark.parametrize("said", TIMES)
def test_times_with_a_date(said):
    column = RawColumn("time", "", tuple(TIMES[said]))
    form = guess_form(column, "")
    assert form is not None and form.forms[0] == " ".join(said.split()[: 1 if said.startswith("iso") else 2])
    assert seconds([column], form.forms[0]) - NOON == pytest.approx([0.0, 0.5, 1.0], abs=2e-3)


def test_a_clock_goes_on_after_midnight():
    clock = RawColumn("time", "", ("23:59:59", "23:59:59.5", "00:00:00", "0:00:01"))
    assert guess_form(clock, "").forms == ("clock",)
    assert np.diff(seconds([clock], "clock")) == pytest.approx([0.5, 0.5, 1.0])
    date = RawColumn("date", "", ("14.03.2026",) * 4)
    assert np.diff(seconds([date, clock], "day first")) == pytest.approx([0.5, 0.5, 1.0])
    digits = RawColumn("utc", "", np.array([235958.0, 235959.0, 0.0, 1.0]))
    assert np.diff(seconds([digits], "hhmmss")) == pytest.approx([1.0, 1.0, 1.0])


def test_stamps_of_full_seconds_are_spread_and_others_are_not():
    coarse = np.floor(np.arange(0.3, 30.0, 0.25))
    even, told = spread(coarse)
    assert np.diff(even) == pytest.approx(np.full(coarse.size - 1, 0.25)) and "0.25 s apart" in told
    repeated = np.array([0.0, 1.0, 1.0, 2.0, 3.0])
    assert spread(repeated)[0] is repeated


def test_numbers_with_commas_and_thousands():
    assert numbers_of(Texts(["1,5", "-2,25", "3"])).tolist() == [1.5, -2.25, 3.0]
    assert numbers_of(Texts(["1.234,5", "-2,25", "0,0"])).tolist() == [1234.5, -2.25, 0.0]
    assert numbers_of(Texts(["1.5", "2.5", "1,234,567"])).tolist() == [1.5, 2.5, 1234567.0]
    assert numbers_of(Texts(["612.345", "612.346"]), "comma").tolist() == [612345.0, 612346.0]
    assert numbers_of(Texts(["5\u202f998\u202f123,5", "1'234,5", "\u22122,5"])).tolist() == [5998123.5, 1234.5, -2.5]
    assert table_style([["612,345"], ["1.5"]]) == "point" and table_style([["612,345"], ["1,5"]]) == "comma"
    assert table_style([["612,345"], ["7"]]) == "open" and table_style([["12.345"], ["7"]]) == "point"


def test_letters_at_numbers():
    rudder = decorated(Texts(["12.5 P", "S 3", "0", "Stb 4"]), "Rudder", "point")
    assert rudder is not None and rudder.numbers.tolist() == [-12.5, 3.0, 0.0, 4.0] and rudder.positive == "starboard"
    place = decorated(Texts(["54.5S", "54.6 S"]), "Latitude", "point")
    assert place is not None and place.numbers.tolist() == [-54.5, -54.6] and place.positive == "east"
    speed = decorated(Texts(["12.5 kn", "3 kn"]), "SOG", "point")
    assert speed is not None and speed.unit == "kn"
    assert decorated(Texts(["12.5 apples", "3 apples"]), "SOG", "point") is None


@pytest.mark.parametrize(
    ("name", "quantities"),
    [
        ("Ruderlage", ("rudder",)),
        ("Kurs über Grund", ("course_over_ground",)),
        ("RudderOrder", ("rudder_command",)),
        ("舵角指令", ("rudder_command",)),
        ("船首方位", ("heading",)),
        ("Ángulo de timón", ("rudder",)),
        ("Kurs", ("heading", "course_over_ground")),
        ("heading_setpoint", ()),
        ("Apparent wind speed", ()),
        ("HDOP", ()),
    ],
)
def test_names_of_columns(name, quantities):
    assert named(read_header(name).words).may_be == quantities


@pytest.mark.parametrize(
    ("text", "dimension", "unit", "positive"),
    [
        ("Rudder (+ = Port)", "angle", None, "port"),
        ("Rudder [deg, +Port]", "angle", "deg", "port"),
        ("Ruder [°] (Stb+/Bb-)", "angle", "deg", "starboard"),
        ("ROT (port negative) [deg/min]", "angular rate", "deg/min", "starboard"),
        ("Rudder P/S [deg]", "angle", "deg", ""),
        ("Rudder Port [deg]", "angle", "deg", ""),
        ("舵角(右+)[deg]", "angle", "deg", "starboard"),
        ("ROT [deg s⁻¹]", "angular rate", "deg/s", ""),
        ("Heading, deg", "angle", "deg", ""),
        ("yaw rate (ccw) [rad/s]", "angular rate", "rad/s", "port"),
    ],
)
def test_what_a_header_states(text, dimension, unit, positive):
    header = read_header(text)
    found = header.unit(dimension)[0]
    assert (found.name if found else None) == unit and header.positive == positive


@pytest.mark.parametrize(
    ("text", "words", "turned"),
    [
        ("Latitude (S)", ("latitude",), True),
        ("Lat S [deg]", ("lat",), True),
        ("Lon W", ("lon",), True),
        ("Longitude [°E]", ("longitude",), False),
        ("Breite [° N]", ("breite",), False),
        ("Latitude [deg]", ("latitude",), False),
        ("Latitude N/S", ("latitude", "n", "s"), False),
        ("Position E [m]", ("position", "e"), False),
        ("GPS N [m]", ("gps", "n"), False),
    ],
)
def test_the_letter_of_a_hemisphere(text, words, turned):
    assert read_header(text).words == words and west_or_south(text, "") is turned


@pytest.mark.parametrize("text", ["Hdg (M) [deg]", "Hdg [deg M]", "Heading [°M]", "Heading (mag)"])
def test_a_direction_from_magnetic_north_is_no_true_heading(text):
    assert named(read_header(text).words).may_be == ("heading_magnetic",)


def test_a_letter_for_metres_is_no_direction():
    assert read_header("Rudder angle (M) [deg]").words == ("rudder", "angle")
    assert read_header("Head [m]").words == ("head",) and read_header("Heading [deg T]").words == ("heading",)


@pytest.mark.parametrize(
    ("again", "refused"),
    [
        ("t [s],heading [deg],rot [deg/min],rudder [deg]", False),
        ("t,heading,rot,rudder", False),
        ("t [s],heading [deg],rot [deg/s],rudder [deg]", True),
        ("t [s],rudder [deg],heading [deg],rot [deg/min]", True),
        ("s,deg,deg/s,deg", True),
    ],
)
def test_a_header_within_the_data_is_the_first_one_or_refused(again, refused, tmp_path, capsys):
    rows = [f"{0.5 * i},{10 + i % 7},{i % 5 - 2},{i % 3 - 1}" for i in range(60)]
    lines = ["t [s],heading [deg],rot [deg/min],rudder [deg]", *rows[:30], again, *rows[30:]]
    (tmp_path / "log.csv").write_text("\n".join(lines), "utf-8")
    status_of(["import", str(tmp_path / "log.csv"), "--yes", "-o", str(tmp_path / "out.csv")])
    said = capsys.readouterr().err
    assert ("row 32: a second header" in said and "cut the file in two there" in said) is refused


def test_a_stated_unit_that_the_heading_contradicts_is_asked(tmp_path):
    run = generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=100.0, dt_s=0.5))
    psi, rate = np.degrees(run.heading_unwrapped()), 60.0 * np.degrees(run.column("yaw_rate_rad_s"))
    rows = zip(run.time_s, psi % 360.0, rate, np.degrees(run.rudder()), strict=True)
    text = "\n".join(
        ["t [s],heading [deg],rot [deg/s],rudder [deg]", *(",".join(f"{x:.5f}" for x in row) for row in rows)]
    )
    (tmp_path / "log.csv").write_text(text, "utf-8")
    with pytest.raises(helmbench.BadInput, match="what is its unit"):
        helmbench.import_log(tmp_path / "log.csv")
    draft = helmbench.draft_import(tmp_path / "log.csv")
    (question,) = draft.questions
    assert [answer.key for answer in question.answers] == ["deg/min", "deg/s", "not used"]
    assert draft.to_dict()["questions"][0]["id"] == question.id and question.text in draft.summary()
    found = draft.answer({question.id: "deg/min"}).import_log()
    assert found.record.column("yaw_rate_rad_s") == pytest.approx(run.column("yaw_rate_rad_s"), abs=1e-6)
    assert "<table" in found._repr_html_() and draft.series("log.csv", "rot")[1] == pytest.approx(rate, abs=1e-5)
    with pytest.raises(helmbench.BadInput, match="no answer"):
        draft.answer({question.id: "furlongs"})


def test_commas_that_may_be_thousands_or_decimals_are_asked(tmp_path):
    rows = [f"{0.5 * i:.1f};{i % 7};{112 + i % 9},{345 + i % 7}".replace(".", ",") for i in range(60)]
    text = "\n".join(["t [s];Heading [deg];Northing [m]", *rows])
    (tmp_path / "log.csv").write_text(text.replace(",0;", ";").replace(",5;", ";"), "utf-8")
    questions = {q.id: q for q in helmbench.draft_import(tmp_path / "log.csv").questions}
    question = questions["log.csv/Northing/numbers"]
    assert [answer.key for answer in question.answers] == ["thousands", "decimals", "not used"]
    assert "factor: 0.001" in question.answers[1].line


def wavy(time):
    return 0.5 * np.sin(0.11 * time) + 0.3 * np.sin(0.031 * time + 1.0)


def test_clock_offsets_are_found_to_their_standard_error(rng):
    errors = []
    for _ in range(12):
        true = rng.uniform(-20.0, 20.0)
        t1, t2 = np.arange(0.0, 400.0, 0.5), np.arange(0.0, 400.0, 0.2)
        first = Stream("a", "a", True, t1, {"heading": wavy(t1) + rng.normal(0.0, 2e-3, t1.size)}, t1)
        second = Stream("b", "b", True, t2, {"heading": wavy(t2 + true) + rng.normal(0.0, 2e-3, t2.size)}, t2)
        found = estimate_offset([first], [second])
        assert found is not None and found.quantity == "turn" and found.correlation > 0.999
        errors.append((found.seconds - true) / found.stderr)
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) < 2.5


def test_positions_on_the_plane_keep_their_distances():
    lat, lon = np.radians([54.0, 54.1, np.nan, 54.0]), np.radians([10.0, 10.0, 10.0, 10.2])
    north, east, plane = on_plane(lat, lon)
    assert north[1] == pytest.approx(11132.0, rel=2e-3) and east[1] == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(north[2]) and east[3] == pytest.approx(13110.0, rel=2e-3)
    assert plane.scale_error < 1e-5 and 0.0 < plane.convergence_rad < 0.01


@pytest.mark.parametrize("size", [1e-4, 1e-2, 1.0])
def test_positions_on_a_plane_are_those_of_proj(size, rng):
    place = rng.uniform([-1.2, -3.1], [1.2, 3.1])
    lat, lon = (place[:, None] + size * rng.uniform(-0.2, 0.2, (2, 50))).clip(-1.5, 3.14)
    north, east, plane = on_plane(lat, lon)
    project = pyproj.Proj(proj="aeqd", lat_0=np.degrees(lat[0]), lon_0=np.degrees(lon[0]), ellps="WGS84")
    peer_east, peer_north = project(np.degrees(lon), np.degrees(lat))
    assert np.abs(north - peer_north).max() < 1e-4 and np.abs(east - peer_east).max() < 1e-4
    factors = [project.get_factors(*place) for place in np.degrees(np.column_stack([lon, lat]))]
    scale = max(f.tissot_semimajor for f in factors) - 1.0
    convergence = max(abs(np.radians(f.meridian_convergence)) for f in factors)
    assert plane.scale_error == pytest.approx(scale, rel=0.02, abs=1e-7)
    assert plane.convergence_rad == pytest.approx(convergence, rel=0.02, abs=1e-6)


MOMENTS = {
    "2026-03-14T12:00:00.25Z": 0.25,
    "20260314 120001": 1.0,
    "2026/03/14 13:30:00,5+01:30": 0.5,
    "2026-03-14 09:30-0230": 0.0,
    "14.03.2026 12:00:00 UTC": 0.0,
    "14/3/26 12:00:02 PM": 2.0,
    "14-Mar-2026 12:00": 0.0,
    "14.03.2026, 12:00:60": 60.0,
    "14.03.2026": -43200.0,
    "31.02.2026 12:00": np.nan,
    "03.14.2026 12:00": np.nan,
    "14.03.2026 24:00": np.nan,
    "14.03.2026 12:00 CET": np.nan,
    "noon": np.nan,
}


@pytest.mark.parametrize("text", MOMENTS)
def test_moments_of_many_forms(text):
    assert moment(text) - NOON == pytest.approx(MOMENTS[text], nan_ok=True)


def test_month_before_day():
    assert moment("3/14/2026 12:00", month_first=True) == NOON and np.isnan(moment("14/3/2026", month_first=True))


def test_velocities_in_body_axes():
    surge, sway = body_velocities(np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.array([0.0, 0.0]))
    assert (surge.tolist(), sway.tolist()) == ([1.0, 0.0], [0.0, 1.0])


def joined(*runs):
    """One long record of runs, each after half a minute of straight course."""
    parts = {name: [] for name in ("rudder_rad", "heading_rad", "yaw_rate_rad_s")}
    for run in runs:
        straight = {"rudder_rad": 0.0, "yaw_rate_rad_s": 0.0}
        last = parts["heading_rad"][-1][-1] if parts["heading_rad"] else 0.0
        for name, series in parts.items():
            shift = last if name == "heading_rad" else 0.0
            lead = np.full(60, straight.get(name, shift))
            series += [lead, run.column(name) + shift]
    channels = {name: np.concatenate(series) for name, series in parts.items()}
    meta = runs[0].meta
    return Record(0.5 * np.arange(channels["rudder_rad"].size), channels, "long", meta)


def test_manoeuvres_are_found_from_the_rudder():
    texts = ("zigzag:20/20", "turn:35:port", "zigzag:10/10:port")
    runs = [generate(Case("kvlcc2-l7", text, duration_s=120.0, dt_s=0.5)) for text in texts]
    found = find_segments(joined(*runs))
    assert [s.kind for s in found if s.kind != "straight"] == ["zigzag", "turn", "zigzag"]
    shown = [re.findall(r"\d+", s.text) for s in found if s.kind != "straight"]
    sailed = [re.findall(r"\d+", text) for text in texts]
    assert [len(numbers) for numbers in shown] == [len(numbers) for numbers in sailed]
    assert all(abs(int(a) - int(b)) <= 1 for x, y in zip(shown, sailed, strict=True) for a, b in zip(x, y, strict=True))
    assert [":port" in s.text for s in found if s.kind != "straight"] == [":port" in text for text in texts]
    parts = cut(joined(*runs))
    assert all(part.time_s[0] == 0.0 and part.meta.manoeuvre == segment.text for segment, part in parts)
    assert len({part.name for _, part in parts}) == len(parts)


@pytest.mark.parametrize(
    ("lines", "frame"),
    [
        (("Coordinate system: ENU",), "enu"),
        (("body frame NED", "world frame: ENU"), ""),
        (("AXES: X FORWARD, Y PORT, Z UP",), "nwu"),
        (("axes: x east, y north, z up",), "enu"),
        (("ship axes, z pointing down",), "ned"),
        (("all angles to port positive, x ahead, y to port",), "nwu"),
        (("x [m], y [m]", "run 12"), ""),
    ],
)
def test_lines_that_state_to_where_axes_point(lines, frame):
    assert frame_stated(lines) == frame
