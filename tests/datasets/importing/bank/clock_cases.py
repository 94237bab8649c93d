"""Logs of the bank with clocks that differ, names over several cells, several times in a table, and several runs.

`questions` is how many are needed, `first_s` when the record begins after the run, `start` what it states of that.
"""

from dataclasses import replace

import numpy as np

from .case import Case, Is
from .texts import D, fixed, iso, series, table
from .truth import KN, START

LEAP = 18.0
"""GPS time minus UTC at the time of the runs, s."""
GPS_EPOCH, WEEK = 315964800.0, 604800.0
PLACED = ("rudder_rad", "heading_rad", "north_m", "east_m")
TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
UTC, UNKNOWN, NONE = "start_utc", "start_of_unknown_zone", ""


def _at(run, shift=0.0):
    """The run's times by a clock that is ahead of UTC."""
    return replace(run, t=run.t + shift)


def _every(run, step):
    """Every few samples of a run."""
    return replace(run, **{name: values[::step] for name, values in vars(run).items()})


def _stamps(run, shift=0.0, form="%Y/%m/%d %H:%M:%S", digits=3):
    moments = np.round(START + shift + run.t, 6)
    whole = np.floor(moments).astype(np.int64)
    texts = [w.astype("datetime64[s]").item().strftime(form) for w in whole]
    return [f"{text}{f'{m - w:.{digits}f}'[1:]}" for text, m, w in zip(texts, moments, whole, strict=True)]


def _pilot(run, folder, zone="Z", shift=0.0, name="pilot.csv", header="Time"):
    s = series(_at(run, shift))
    stamps = [text + zone for text in s["iso"]]
    return table(folder / name, {header: stamps, "Heading [deg]": s["heading"], "Rudder [deg]": s["rudder"]})


def _positions(run):
    return {"latitude(deg)": fixed(run.lat, 9), "longitude(deg)": fixed(run.lon, 9), "height(m)": fixed(31 + 0 * run.t)}


def _blank(path, names, columns, head=(), sep="  "):
    lines = [*head, sep.join(names), *(sep.join(row) for row in zip(*columns, strict=True))]
    path.write_text("\n".join(lines) + "\n")
    return [path]


def _rtklib(scale="GPST", shift=LEAP, zone="Z", pilot=0.0, weeks=False):
    def write(run, folder):
        coarse, s = _every(run, 2), _positions(_every(run, 2))
        gps = START + shift + coarse.t - GPS_EPOCH
        time = [fixed(gps // WEEK, 0), fixed(gps % WEEK, 3)] if weeks else [_stamps(coarse, shift)]
        quality = [["1"] * coarse.t.size, fixed(12 + 0 * coarse.t, 0)]
        names = [f"%  {scale}", *s, "Q", "ns"]
        head = ["% program   : RTKPOST ver.2.4.3", "% pos mode  : kinematic"]
        return [*_blank(folder / "rover.pos", names, [*time, *s.values(), *quality], head),
                *_pilot(run, folder, zone, pilot)]  # fmt: skip

    return write


def _slip(names, stamp, extra=()):
    """Blanks between cells, one name for several cells of the time."""

    def write(run, folder):
        columns = [stamp(run), fixed(run.delta * D, 2), fixed(run.psi * D % 360.0, 2), fixed(run.cog * D, 2)]
        return _blank(
            folder / "ship.txt", [*names, "Rudder(deg)", "Heading(deg)", "COG(deg)"], [*columns, *extra], (), " "
        )

    return write


def _two_rates(names):
    """The speed at half the rate, with a time of its own that ends earlier."""

    def write(run, folder):
        s, slow = series(run), series(_every(run, 2))
        rest = [""] * (run.t.size - len(slow["t"]))
        columns = dict(zip(names, (s["t"], slow["t"] + rest), strict=True))
        first, second = names
        made = {first: columns[first], "Heading [deg]": s["heading"], "Rudder [deg]": s["rudder"],
                second: columns[second], "Surge [m/s]": slow["u"] + rest}  # fmt: skip
        return table(folder / "rates.txt", made, "\t")

    return write


def _copied_time(run, folder):
    s = series(run)
    made = {"Time": s["iso"], "Heading [deg]": s["heading"], "Elapsed time [s]": fixed(run.t + 7.0, 2),
            "ROT [deg/min]": s["rot_min"], "Rudder [deg]": s["rudder"]}  # fmt: skip
    return table(folder / "copied.csv", made)


def _scales(run, folder):
    s = series(run)
    made = {"t model [s]": fixed(run.t / 5.0, 3), "Heading [deg]": s["heading"], "t ship [s]": s["t"]}
    return table(folder / "scales.csv", made | {"COG [deg]": s["cog"], "Rudder [deg]": s["rudder"]})


def _weeks(week="GPS week", second="TOW [s]", size=1.0):
    def write(run, folder):
        s, gps = series(run), START + LEAP + run.t - GPS_EPOCH
        made = {week: fixed(gps // WEEK, 0), second: fixed(gps % WEEK * size, 3)}
        return table(folder / "gps.csv", made | {"Heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"],
                                                 "Rudder [deg]": s["rudder"]})  # fmt: skip

    return write


def _date_parts(run, folder):
    """A receiver's date and time in parts with nanoseconds, and the seconds of the GPS week beside them."""
    s, moments = series(run), [w.astype("datetime64[s]").item() for w in np.floor(START + run.t).astype(np.int64)]
    made = {"iTOW [ms]": fixed(1e3 * ((START + LEAP + run.t - GPS_EPOCH) % WEEK), 0)}
    made |= {n: [str(getattr(m, n)) for m in moments] for n in ("year", "month", "day", "hour", "minute", "second")}
    made |= {"nano [ns]": fixed(1e9 * (run.t % 1.0), 0), "Heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"]}
    return table(folder / "pvt.csv", made | {"Rudder [deg]": s["rudder"]})


def _seconds_of_week(head=(), name="GPS seconds of week [s]", utc=True):
    """Positions by seconds of the week, heading and rudder with a date."""

    def write(run, folder):
        gps = (START + LEAP + run.t - GPS_EPOCH) % WEEK
        made = {name: fixed(gps, 3), "Lat [deg]": fixed(run.lat, 9), "Lon [deg]": fixed(run.lon, 9)}
        return [*table(folder / "track.csv", made, head=head), *(_pilot(run, folder) if utc else [])]

    return write


def _stated(note):
    """Dates without a zone below a line that states the scale."""

    def write(run, folder):
        s = series(_at(run, LEAP))
        made = {
            "Epoch": s["iso"],
            "Heading [deg]": s["heading"],
            "ROT [deg/min]": s["rot_min"],
            "Rudder [deg]": s["rudder"],
        }
        return table(folder / "stated.csv", made, head=(note,))

    return write


def _two_clocks(ahead=47.3, zone="Z"):
    """The bridge in UTC, and the rudder by a clock that is ahead; both have the heading."""

    def write(run, folder):
        s, own = series(run), series(_at(run, ahead))
        bridge = {"Time": [x + zone for x in s["iso"]], "Heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"]}
        rudder = {
            "PC time": own["iso"],
            "Rudder [deg]": own["rudder"],
            "Gyro heading [deg]": fixed(run.psi * D % 360, 1),
        }
        return [*table(folder / "rudder_logger.csv", rudder, ";"), *table(folder / "bridge.csv", bridge)]

    return write


def _stopwatch(run, folder):
    """Positions by a stopwatch that was started later, heading and rudder with a date."""
    later = run.t >= 12.0
    lat, lon = fixed(run.lat[later], 8), fixed(run.lon[later], 8)
    made = {"Time [s]": fixed(run.t[later] - 12.0, 1), "Lat [deg]": lat, "Lon [deg]": lon}
    return [*table(folder / "track.csv", made), *_pilot(run, folder)]


def _rudder_apart(run, folder):
    """Rudder and heading in files that both begin at 0, and share nothing."""
    s = series(run)
    return [*table(folder / "rudder.csv", {"Time [s]": s["t"], "Rudder [deg]": s["rudder"]}),
            *table(folder / "gyro.csv", {"Time [s]": fixed(run.t, 1), "Heading [deg]": s["heading"]})]  # fmt: skip


def _appended(run, folder, stamps=None):
    """The run twice."""
    s, t = series(run), stamps or fixed(run.t, 2)
    made = {"Time [s]" if stamps is None else "Time": t + t, "Heading [deg]": s["heading"] * 2,
            "ROT [deg/min]": s["rot_min"] * 2, "Rudder [deg]": s["rudder"] * 2}  # fmt: skip
    return table(folder / "runs.csv", made)


def _bridge(time, run):
    """The columns of a bridge log, with what its time is called."""
    s = series(run)
    return {time: s["t"], "Heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"], "Rudder [deg]": s["rudder"]}


def _short_first(run, folder):
    """Twelve rows of another run above the run."""
    made = _bridge("Time [s]", run)
    times = made["Time [s]"]
    return table(folder / "runs.csv", {name: texts[200:212] + texts for name, texts in made.items()} |
                 {"Time [s]": times[:12] + times})  # fmt: skip


def _summer_time(run, folder):
    """A clock that is set back an hour in the middle."""
    s, half = series(run), run.t.size // 2 + 9
    back = series(replace(run, t=run.t - 3600.0))["iso"]
    made = {"Time": s["iso"][:half] + back[half:], "Heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"]}
    return table(folder / "back.csv", made | {"Rudder [deg]": s["rudder"]})


def _comma_header(run, folder):
    """A header with commas above columns with tabs."""
    s = series(run)
    names = "//  Datetime [UTC], Longitude [deg], Latitude [deg], Heading [deg], Rudder [deg]"
    rows = zip([x + "Z" for x in s["iso"]], s["lon"], s["lat"], s["heading"], s["rudder"], strict=True)
    path = folder / "nav.r2rnav"
    path.write_text("\n".join(["// Product: bestres", names, *("\t".join(row) for row in rows)]) + "\n")
    return [path]


def _idle_file(run, folder):
    """A file of no use beside the log."""
    made = _bridge("time [s]", run)
    pump = {"time [s]": made["time [s]"], "Pump pressure [bar]": fixed(3 + 0 * run.t)}
    return [*table(folder / "log.csv", made), *table(folder / "pump.csv", pump)]


def _missing_name(run, folder):
    """Five columns under four names, and no cell tells which has none."""
    s = series(run)
    rows = zip(s["t"], s["rudder"], s["heading"], s["cog"], fixed(run.sog / KN, 2), strict=True)
    path = folder / "four.csv"
    path.write_text("\n".join(["time [s],Rudder [deg],Heading [deg],COG [deg]", *map(",".join, rows)]) + "\n")
    return [path]


def _apart(zone, shift):
    return Case(_rtklib(zone=zone, pilot=shift), True, {}, PLACED, questions=0, start=UTC, loose=0.05)


CLOCK_CASES: dict[str, Case] = {
    "GPST in one name of two cells, and UTC": Case(_rtklib(), True, {}, PLACED, questions=0, start=UTC, loose=0.05),
    "GPS week and seconds in one name, and UTC": Case(
        _rtklib(weeks=True), True, {}, PLACED, questions=0, start=UTC, loose=0.05
    ),
    "the same program with UTC": Case(_rtklib("UTC", 0.0), True, {}, PLACED, questions=0, start=UTC, loose=0.05),
    "GPST and a clock without zone that shows UTC": _apart("", 0.0),
    "GPST and a clock without zone that shows GPS time": _apart("", LEAP),
    "GPST and a clock without zone that shows Central European time": _apart("", 3600.0),
    "GPST and a clock with its zone": Case(
        _rtklib(zone="+01:00", pilot=3600.0), True, {}, PLACED, questions=0, start=UTC, loose=0.05
    ),
    "date and clock under one name, blanks": Case(
        _slip(["DateTime"], _stamps), True, {}, ("rudder_rad", "heading_rad"), questions=0, start=UNKNOWN
    ),
    "date, clock and half of the day under two names": Case(
        _slip(["Date", "Time"], lambda r: [x + " AM" for x in _stamps(r, form="%m/%d/%Y %H:%M:%S")]),
        True,
        {},
        ("rudder_rad", "heading_rad"),
        questions=0,
        start=UNKNOWN,
    ),
    "date, clock and zone under one name": Case(
        _slip(["Timestamp"], lambda r: [x + " +01:00" for x in _stamps(r, 3600.0, "%Y-%m-%d %H:%M:%S")]),
        True,
        {},
        ("rudder_rad", "heading_rad"),
        questions=0,
        start=UTC,
    ),
    "date and clock without any name": Case(
        _slip([], lambda r: _stamps(r, form="%Y-%m-%d %H:%M:%S")),
        True,
        {},
        ("rudder_rad", "heading_rad"),
        questions=0,
        start=UNKNOWN,
    ),
    "a name is missing, nothing tells which": Case(_missing_name, True, refused="nothing tells which column has none"),
    "header with commas, columns with tabs": Case(_comma_header, True, {}, PLACED, questions=0, start=UTC),
    "two times, numbered": Case(
        _two_rates(("Time 1 - default sample rate [s]", "Time 2 - slow sample rate [s]")),
        True,
        {},
        ("rudder_rad", "heading_rad", "surge_m_s"),
        questions=0,
    ),
    "two times of one name": Case(
        _two_rates(("Time [s]", "Time [s] ")), True, {}, ("rudder_rad", "heading_rad", "surge_m_s"), questions=0
    ),
    "a second time that is a copy": Case(_copied_time, True, {}, TURN, questions=0, start=UNKNOWN),
    "times of model and ship": Case(
        _scales, True, {}, ("rudder_rad", "heading_rad"), whole={"scale": "ship"}, questions=1
    ),
    "GPS week and seconds": Case(_weeks(), False, {}, TURN, questions=0, start=UTC),
    "GPS week and milliseconds": Case(_weeks("Week", "iTOW [ms]", 1e3), False, {}, TURN, questions=0, start=UTC),
    "seconds of the week, and UTC": Case(_seconds_of_week(), True, {}, PLACED, questions=0, start=UTC, loose=0.05),
    "seconds of the week under a date, and UTC": Case(
        _seconds_of_week(("Date of mission: 2026-03-14",), "TIME"), True, {}, PLACED, questions=0, start=UTC, loose=0.05
    ),
    "parts of a date with nanoseconds, GPS seconds beside": Case(
        _date_parts, True, {}, TURN, questions=0, start=UTC, within_s=0.01
    ),
    "a line states GPS time": Case(_stated("# Time system: GPS"), True, {}, TURN, questions=0, start=UTC),
    "no line states the scale": Case(_stated("# Trial 3"), True, {}, TURN, questions=0, start=UNKNOWN, first_s=LEAP),
    "two clocks, the heading in both": Case(_two_clocks(), True, {}, TURN, questions=0, start=UTC, loose=0.05),
    "two clocks, neither with a zone": Case(
        _two_clocks(zone=""), True, {}, TURN, questions=0, start=UNKNOWN, first_s=47.3, loose=0.05
    ),
    "a stopwatch for the positions": Case(
        _stopwatch, True, {}, PLACED, questions=0, start=UTC, first_s=12.0, within_s=2.0, loose=0.06, seconds=240.0
    ),
    "rudder and heading apart, without dates": Case(
        _rudder_apart, True, {"clock": Is("0")}, ("rudder_rad", "heading_rad"), questions=1
    ),
    "a run twice, the time starts again": Case(_appended, True, {}, TURN, questions=0, records=2),
    "a run twice, the time of day starts again": Case(
        lambda r, f: _appended(r, f, [x[11:] for x in iso(r)]), True, {}, TURN, questions=0, records=2
    ),
    "a few rows of another run first": Case(_short_first, True, {}, TURN, questions=0, records=2),
    "the clock is set back an hour": Case(_summer_time, True, {}, TURN, questions=0, records=2, start=UNKNOWN),
    "a file of no use": Case(_idle_file, True, {}, TURN, questions=0, said="pump.csv: no column of this file is used"),
}
