"""Text logs of the bank whose headers, cells, times or lines invite a wrong guess."""

import numpy as np

from .case import Case, Is
from .texts import D, fixed, series, table
from .truth import KN, START

TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
BOTH = ("rudder_rad", "heading_rad")
PLACE = ("rudder_rad", "heading_rad", "north_m", "east_m")
GROUND = ("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s")
PLAIN = {"time [s]": "t", "Heading [deg]": "heading", "ROT [deg/min]": "rot_min", "Rudder [deg]": "rudder"}


def log(columns, wanted=TURN, knows=None, side="starboard", time="", edit=None, name="log.csv", loose=0.03, **options):
    """A hostile case of one table: header -> a text of `series`, or a function of the run; `edit` changes its lines."""

    def write(run, folder):
        s = series(run)
        made = {head: s[what] if isinstance(what, str) else list(what(run)) for head, what in columns.items()}
        (path,) = table(folder / name, made, **options)
        if edit is not None:
            encoding = options.get("encoding", "utf-8")
            lines = path.read_bytes().decode(encoding).split("\r\n")
            path.write_bytes("\r\n".join(edit(lines)).encode(encoding))
        return [path]

    return Case(write, True, knows or {}, wanted, side, time, loose=loose)


def part(of, factor=1.0, digits=3):
    """A column of numbers: an attribute of the run times a factor."""
    return lambda r: fixed(factor * getattr(r, of), digits)


def stamps(form, **parts):
    """Times as texts of a form of strftime."""
    moments = lambda r: (np.datetime64(round(1e3 * (START + t)), "ms").item() for t in r.t)  # noqa: E731
    return lambda r: [m.strftime(form)[: parts.get("cut")] for m in moments(r)]


def _every(lines, count, extra):
    """Lines with others put in behind every `count` of them."""
    out = []
    for i, line in enumerate(lines):
        out += [line, *(extra if i and i % count == 0 and i + 3 < len(lines) else ())]
    return out


def _with_gaps(text, column, period):
    """A missing value, as a logger writes it, in one column of some lines."""

    def edit(lines):
        out = []
        for i, line in enumerate(lines):
            cells = line.split(",")
            if i > 3 and i % period == 0 and len(cells) > column:
                cells[column] = text
            out.append(",".join(cells))
        return out

    return edit


def _own_times(lines):
    """Rudder with a time column of its own: half as many samples as of the heading beside it."""
    rows = [line.split(",") for line in lines[1:] if line]
    later = [rows[2 * i][2:] if 2 * i < len(rows) else ["", ""] for i in range(len(rows))]
    return [lines[0], *(",".join([*row[:2], *other]) for row, other in zip(rows, later, strict=True))]


def _hours(run):
    return [f"{(START + t) % 86400 / 3600:.8f}" for t in run.t]


def _reading(value, digits):
    """12.34- , as accounting programs write negative numbers."""
    return f"{abs(value):.{digits}f}{'-' if value < 0 else ''}"


def _degrees(values, letters, width):
    return [f"{letters[int(x < 0)]} {int(abs(x)):0{width}d}° {60 * (abs(x) % 1):08.5f}'" for x in values]


def _mixed_speed(run):
    return [f"{v / KN:.3f} kn" if i % 2 else f"{v:.4f} m/s" for i, v in enumerate(run.sog)]


HOSTILE_CASES: dict[str, Case] = {
    # ---------------------------------------------------------------------------------------- units
    "units of four kinds in one file": log(
        {
            "t_ms": lambda r: [f"{1e3 * t:.0f}" for t in r.t],
            "psi_rad": "psi_rad",
            "r_deg_per_min": "rot_min",
            "delta [mrad]": part("delta", 1e3),
            "SOG (km/h)": part("sog", 3.6),
            "COG (rad)": part("cog", 1.0, 5),
        },
        (*TURN, "surge_m_s", "sway_m_s"),
    ),
    "units behind a slash": log(
        {
            "t / s": "t",
            "ψ / °": "heading",
            "r / (°/min)": "rot_min",
            "δ / °": "rudder",
            "SOG / kn": "sog",
            "COG / °": "cog",
        },
        (*TURN, "surge_m_s", "sway_m_s"),
    ),
    "speed in metres a minute": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Speed over ground [m/min]": part("sog", 60.0),
            "Course over ground [deg]": "cog",
            "Rudder [deg]": "rudder",
        },
        GROUND,
    ),
    "rates in degrees a minute, unsaid": log(
        {"time [s]": "t", "Heading": "heading", "Turn rate": "rot_min", "Rudder angle": "rudder"},
        knows={"Rudder angle": Is("rudder", "deg")},
    ),
    "tenths of degrees": log(
        {
            "time [s]": "t",
            "Heading [0.1 deg]": part("psi", 10 * D, 0),
            "Rudder [0.1deg]": part("delta", 10 * D, 0),
            "ROT [0.1 deg/min]": part("r", 600 * D, 0),
        }
    ),
    "times ten, in words": log(
        {"time [s]": "t", "Heading x10 [deg]": part("psi", 10 * D, 0), "Rudder x10 [deg]": part("delta", 10 * D, 0)},
        BOTH,
        {"Heading x10": Is("heading", "deg", 1, 0.1), "Rudder x10": Is("rudder", "deg", 1, 0.1)},
    ),
    "heading in gon": log(
        {
            "time [s]": "t",
            "Kurs [gon]": lambda r: fixed(r.psi * 200 / np.pi % 400, 3),
            "Ruderlage [°]": "rudder",
            "Drehrate [°/s]": "rot_s",
        },
        TURN,
        {"Kurs": Is("heading", "deg", 1, 0.9)},
    ),
    "two units in one column": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "SOG": _mixed_speed,
            "COG [deg]": "cog",
            "Rudder [deg]": "rudder",
        },
        BOTH,
    ),
    "revolutions a second under RPM": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Rudder [deg]": "rudder", "RPM [1/s]": "rps"},
        (*BOTH, "propeller_rps"),
    ),
    "shaft without unit": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Rudder [deg]": "rudder", "Shaft": "rps", "n": "rps"},
        BOTH,
        {"n": Is("propeller", "rps"), "Shaft": Is("not used")},
    ),
    "positions in radians, unsaid": log(
        {
            "time [s]": "t",
            "Lat": lambda r: fixed(np.radians(r.lat), 10),
            "Lon": lambda r: fixed(np.radians(r.lon), 10),
            "Heading": "psi_rad",
            "Rudder [rad]": "delta_rad",
        },
        PLACE,
        {"Lat": Is("latitude", "rad"), "Lon": Is("longitude", "rad"), "Heading": Is("heading", "rad")},
    ),
    "positions in kilometres, unsaid": log(
        {
            "time [s]": "t",
            "North": part("north", 1e-3, 6),
            "East": part("east", 1e-3, 6),
            "Heading [deg]": "heading",
            "Rudder [deg]": "rudder",
        },
        PLACE,
        {"North": Is("north", "km"), "East": Is("east", "km")},
    ),
    # ---------------------------------------------------------------------------------------- signs
    "heading, plus is port": log(
        {"time [s]": "t", "Heading (+ = Port) [deg]": part("psi", -D, 2), "Rudder [deg]": "rudder"},
        BOTH,
        {"Heading (+ = Port)": Is("heading", "deg", -1)},
    ),
    "yaw counter-clockwise": log(
        {
            "time [s]": "t",
            "Yaw [deg] (ccw +)": part("psi", -D, 2),
            "Yaw rate [deg/s] (ccw +)": part("r", -D, 4),
            "Rudder [deg]": "rudder",
        },
        TURN,
        {"Yaw": Is("heading", "deg", -1), "Yaw (ccw +)": Is("heading", "deg", -1)},
    ),
    "roll, starboard up": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Rudder [deg]": "rudder",
            "Roll (+ = stbd up) [deg]": part("roll", -D),
        },
        (*BOTH, "roll_rad"),
        {"Roll (+ = stbd up)": Is("roll", "deg", -1)},
    ),
    "roll, port up": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Rudder [deg]": "rudder",
            "Roll [deg] port side up positive": "roll",
        },
        (*BOTH, "roll_rad"),
        {"Roll [deg] port side up positive": Is("roll", "deg")},
    ),
    "P(+)/S(-)": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "ROT [deg/min] P(+)/S(-)": part("r", -60 * D, 2),
            "Rudder angle [deg] P(+)/S(-)": part("delta", -D, 2),
        },
        TURN,
        side="port",
    ),
    "signs with side and word": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "ROT deg/min STBD+": "rot_min",
            "RUDDER deg (PORT -VE)": "rudder",
        },
        TURN,
    ),
    "minus is port": log(
        {
            "Zeit [s]": "t",
            "Kurs rw [°]": "heading",
            "Ruder [°] (- = BB)": "rudder",
            "Drehrate [°/min] (+ = BB)": part("r", -60 * D, 2),
        },
        TURN,
        {"Kurs rw": Is("heading", "deg")},
        sep=";",
    ),
    "rudder in per cent to port": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Rudder [%] (+ = Port)": part("delta", -D / 0.35, 1)},
        BOTH,
        {"Rudder [%] (+ = Port)": Is("rudder", "deg", 1, 0.35)},
        "port",
    ),
    "columns to port and to starboard": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Rudder port [deg]": lambda r: fixed(np.maximum(-r.delta, 0) * D, 2),
            "Rudder stbd [deg]": lambda r: fixed(np.maximum(r.delta, 0) * D, 2),
        },
        BOTH,
    ),
    "east and north with other signs": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "South [m]": part("north", -1.0),
            "West [m]": part("east", -1.0),
            "Rudder [deg]": "rudder",
        },
        BOTH,
    ),
    "a heading of half turns": log(
        {
            "time [s]": "t",
            "Heading [deg]": lambda r: fixed((r.psi * D + 180) % 360 - 180, 2),
            "ROT [deg/min]": "rot_min",
            "Rudder [deg]": "rudder",
        },
        TURN,
    ),
    "azimuth pod, full circle": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Pod angle [deg]": lambda r: fixed(r.delta * D % 360, 2)},
        BOTH,
        {"Pod angle": Is("rudder", "deg")},
    ),
    "rudder, full circle": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Rudder [deg]": lambda r: fixed(-r.delta * D % 360, 2)},
        BOTH,
        side="port",
    ),
    "negative behind the number": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Rudder [deg]": lambda r: [_reading(x * D, 2) for x in r.delta]},
        BOTH,
    ),
    # ---------------------------------------------------------------------------------------- twins, set values
    "two gyros with a constant between": log(
        {
            "time [s]": "t",
            "Gyro 1 heading [deg]": "heading",
            "Gyro 2 heading [deg]": lambda r: fixed((r.psi * D + 4) % 360, 2),
            "ROT [deg/min]": "rot_min",
            "Rudder [deg]": "rudder",
        },
        TURN,
        {"Gyro 1 heading": Is("heading", "deg")},
    ),
    "one name twice": log(
        {"time [s]": "t", "Heading [deg]": "heading", "Rudder [deg]": "rudder", "Rudder2 [deg]": "order"},
        BOTH,
        {"Rudder": Is("rudder", "deg")},
        edit=lambda x: [x[0].replace("Rudder2", "Rudder"), *x[1:]],
    ),
    "set values beside measured ones": log(
        {
            "time [s]": "t",
            "Set heading [deg]": lambda r: fixed(0 * r.t + 90),
            "Heading error [deg]": part("psi", D),
            "Heading [deg]": "heading",
            "ROT limit [deg/min]": lambda r: fixed(0 * r.t + 40),
            "Set rudder [deg]": "order",
            "Rudder limit [deg]": lambda r: fixed(0 * r.t + 35),
            "Rudder [deg]": "rudder",
        },
        BOTH,
    ),
    "log speed and a current": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Log [kn]": part("u", 1.0 / KN),
            "Rudder [deg]": "rudder",
            "Speed [kn]": "sog",
            "Course [deg]": "cog",
        },
        BOTH,
        {"Speed": Is("speed_over_ground", "kn"), "Course": Is("course_over_ground", "deg")},
    ),
    "relative wind and drift": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Rel. wind speed [m/s]": lambda r: fixed(9 + np.sin(r.t)),
            "Drift angle [deg]": lambda r: fixed(np.arctan2(r.v, r.u) * D),
            "Rudder rate [deg/s]": lambda r: fixed(np.gradient(r.delta, r.t) * D),
            "Rudder [deg]": "rudder",
        },
        BOTH,
    ),
    # ---------------------------------------------------------------------------------------- times
    "epoch in milliseconds": log(
        {
            "timestamp": lambda r: [f"{1e3 * (START + t):.0f}" for t in r.t],
            **{k: v for k, v in PLAIN.items() if "time" not in k},
        }
    ),
    "epoch in microseconds": log(
        {
            "stamp": lambda r: [f"{1e6 * (START + t):.0f}" for t in r.t],
            **{k: v for k, v in PLAIN.items() if "time" not in k},
        }
    ),
    "Excel days with decimal commas": log(
        {
            "Datum Uhrzeit": lambda r: [f"{(START + t) / 86400 + 25569:.9f}" for t in r.t],
            "Kurs [°]": "heading",
            "Drehrate [°/min]": "rot_min",
            "Ruder [°]": "rudder",
        },
        TURN,
        {"Kurs": Is("heading", "deg")},
        sep=";",
        comma=True,
    ),
    "hours of the day": log({"Time [h]": _hours, **{k: v for k, v in PLAIN.items() if "time" not in k}}),
    "year, month, day, hour, minute, second": log(
        {
            "Year": stamps("%Y"),
            "Month": stamps("%m"),
            "Day": stamps("%d"),
            "Hour": stamps("%H"),
            "Minute": stamps("%M"),
            "Second": stamps("%S.%f", cut=-3),
            "Heading [deg]": "heading",
            "ROT [deg/min]": "rot_min",
            "Rudder [deg]": "rudder",
        }
    ),
    "date, hour with am and pm": log(
        {
            "Date": stamps("%m/%d/%Y"),
            "Time": stamps("%I:%M:%S.%f %p"),
            "Heading [deg]": "heading",
            "Rudder [deg]": "rudder",
        },
        BOTH,
    ),
    "German date with a decimal comma": log(
        {
            "Zeitstempel": lambda r: [x.replace(".", ",") for x in stamps("%d-%m-%Y %H:%M:%S#%f", cut=-3)(r)],
            "Kurs [°]": "heading",
            "Drehrate [°/min]": "rot_min",
            "Ruder [°]": "rudder",
        },
        TURN,
        {"Kurs": Is("heading", "deg")},
        sep=";",
        comma=True,
        edit=lambda x: [line.replace("#", ",") for line in x],
    ),
    "two time columns": log(
        {"Time heading [s]": "t", "Heading [deg]": "heading", "Time rudder [s]": "t", "Rudder [deg]": "rudder"},
        BOTH,
        edit=_own_times,
    ),
    "newest row first": log(PLAIN, edit=lambda x: [x[0], *reversed([line for line in x[1:] if line])]),
    "clock over midnight": log(
        {
            "Time": lambda r: [
                f"{(23 + int(3000 + t) // 3600) % 24:02d}:{int(3000 + t) // 60 % 60:02d}:{t % 60:04.1f}"
                for t in r.t + 480
            ],
            **{k: v for k, v in PLAIN.items() if "time" not in k},
        }
    ),
    # ---------------------------------------------------------------------------------------- layout
    "unit row under the header, commas, semicolons": log(
        {"Zeit": "t", "Kurs": "heading", "Drehrate": "rot_min", "Ruder": "rudder"},
        TURN,
        {"Kurs": Is("heading", "deg")},
        sep=";",
        comma=True,
        units=("s", "°", "°/min", "°"),
    ),
    "two header rows": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "ROT [deg/min]": "rot_min",
            "Angle [deg]": "rudder",
            "Order [deg]": "order",
        },
        (*TURN, "rudder_command_rad"),
        head=(",Gyro,,Rudder,",),
    ),
    "header cells over two lines": log(
        {
            "time [s]": "t",
            '"Heading\r\n[deg]"': "heading",
            '"ROT\r\n[deg/min]"': "rot_min",
            '"Rudder\r\n(+ = Port)\r\n[deg]"': part("delta", -D, 2),
        },
        TURN,
        side="port",
    ),
    "quoted numbers with commas": log(
        {
            "time [s]": "t",
            "Heading [deg]": lambda r: [f'"{x * D % 360:.2f}"'.replace(".", ",") for x in r.psi],
            "Rudder [deg]": lambda r: [f'"{x * D:.2f}"'.replace(".", ",") for x in r.delta],
        },
        BOTH,
    ),
    "semicolons, points and thousands commas": log(
        {
            "time [s]": "t",
            "Heading [deg]": "heading",
            "Easting [m]": lambda r: [f"{612345 + x:,.2f}" for x in r.east],
            "Northing [m]": lambda r: [f"{6031234 + x:,.2f}" for x in r.north],
            "Rudder [deg]": "rudder",
        },
        PLACE,
        sep=";",
    ),
    "UTF-16 without a mark, tabs": log(PLAIN, sep="\t", encoding="utf-16-le"),
    "Shift-JIS, signs in Japanese": log(
        {
            "時間[秒]": "t",
            "船首方位[度]": "heading",
            "回頭角速度[度/分] (左舷+)": part("r", -60 * D, 2),
            "舵角[度] (右舷が正)": "rudder",
        },
        TURN,
        encoding="shift_jis",
    ),
    "Chinese, signs": log(
        {"时间(s)": "t", "艏向(°)": "heading", "转首角速度(°/s)": "rot_s", "舵角(°) 左舵为正": part("delta", -D, 2)},
        TURN,
        encoding="gb18030",
        side="port",
    ),
    "lines of text at the end": log(
        PLAIN, edit=lambda x: [*x[:-1], "", "End of log", f"Rows: {len(x) - 2}", "Checked by: N. N."]
    ),
    "statistics at the end": log(
        PLAIN, edit=lambda x: [*x[:-1], "Average,180.00,1.00,2.00", "Maximum,359.00,90.00,35.00"]
    ),
    "comments and headers in the middle": log(
        PLAIN, edit=lambda x: _every(x, 97, ("# helmsman changed", x[0], "s,deg,deg/min,deg"))
    ),
    "999.9 where nothing is known": log(PLAIN, edit=_with_gaps("999.9", 1, 40)),
    "-9999 where nothing is known": log(PLAIN, edit=_with_gaps("-9999", 3, 50)),
    "32767 where nothing is known": log(PLAIN, edit=_with_gaps("32767", 2, 60)),
    "degrees, minutes and letters": log(
        {
            "time [s]": "t",
            "Position N/S": lambda r: _degrees(r.lat, "NS", 2),
            "Position E/W": lambda r: _degrees(r.lon, "EW", 3),
            "Heading [deg]": "heading",
            "Rudder [deg]": "rudder",
        },
        BOTH,
    ),
    "cut last line": log(PLAIN, edit=lambda x: [*x[:-2], x[-2][:9]]),
}
