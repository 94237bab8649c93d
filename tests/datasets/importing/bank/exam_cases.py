"""Logs by which an examiner found errors of the import: frames, units of messages, rows that are no samples, names that
are listed above the data, and compressed files."""

import gzip
import json
import zipfile
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather
import scipy.io

from .case import Case, Is
from .texts import D, fixed, iso, series, table, texts
from .truth import KN, START, Run

PLACED = ("rudder_rad", "heading_rad", "yaw_rate_rad_s", "north_m", "east_m")

NUMBERED = ("TEST 4711", "CHANNELS 4", "  1  TIME       s", "  2  HEADING    deg", "  3  YAW RATE   deg/s",
            "  4  RUDDER     deg", "END")  # fmt: skip
BEHIND_A_WORD = ("Versuch 88", "Kanal 1: Zeit [s]", "Kanal 2: Steuerkurs [Grad]", "Kanal 3: Gierrate [Grad/s]",
                 "Kanal 4: Ruderwinkel [Grad]", "")  # fmt: skip
IN_ONE_LINE = ("RUN: A-0032", "FS = 2 Hz",
               "CHANNELS: SAMPLE, HEADING (deg), YAW RATE (deg/s), RUDDER (deg, + to starboard)")  # fmt: skip
"""Lines above the data that name its columns."""


def _messages(factor: float, digits: int):
    """Messages of canboat without its first line, which states the units."""

    def write(run: Run, folder: Path) -> list[Path]:
        def line(i: int, source: int, pgn: int, **fields) -> str:
            own = {name: round(float(value), digits) for name, value in fields.items()}
            entry = {"timestamp": f"{stamps[i]}Z", "src": source, "pgn": pgn, "fields": own}
            return json.dumps(entry)

        stamps = iso(run)
        out = []
        for i in range(run.t.size):
            out.append(line(i, 3, 127250, Heading=factor * (run.psi[i] % (2.0 * np.pi))))
            out.append(line(i, 3, 127251, Rate=factor * run.r[i]))
            out.append(line(i, 7, 127245, Position=factor * run.delta[i]))
        (folder / "analyzer.json").write_text("\n".join(out))
        return [folder / "analyzer.json"]

    return write


def _plotted(s, run):
    """A topic of ROS as PlotJuggler exports it: a yaw from east in a quaternion, which the positions tell."""
    half = (np.pi / 2.0 - run.psi) / 2.0
    zero = ["0"] * run.t.size
    return {
        "__time": fixed(START + run.t), "/imu/data/orientation/x": zero, "/imu/data/orientation/y": zero,
        "/imu/data/orientation/z": fixed(np.sin(half), 8), "/imu/data/orientation/w": fixed(np.cos(half), 8),
        "/imu/data/angular_velocity/z": fixed(-run.r, 6), "/gps/fix/latitude": s["lat"], "/gps/fix/longitude": s["lon"],
        "/rudder/angle_deg/data": s["rudder"],
    }  # fmt: skip


def _autopilot(run: Run, folder: Path) -> list[Path]:
    """Messages of ArduPilot, a file each: microseconds since the start, a GPS week, flags that never change."""
    s, n = series(run), run.t.size
    since_start = [str(81_234_567 + round(1e6 * t)) for t in run.t]
    week_ms = [str(round(1e3 * ((START - 315964800.0 + 18.0) % 604800.0 + t))) for t in run.t]
    gps = {"TimeUS": since_start, "I": ["0"] * n, "Status": ["4"] * n, "GMS": week_ms, "GWk": ["2409"] * n,
           "Lat": s["lat"], "Lng": s["lon"], "Yaw": ["0"] * n, "U": ["1"] * n}  # fmt: skip
    steer = {"timestamp": fixed(START + run.t), "Heading [deg]": s["heading"], "Rudder [deg]": s["rudder"]}
    return table(folder / "GPS.csv", gps) + table(folder / "STEER.csv", steer)


def _of_fields(run: Run, folder: Path) -> list[Path]:
    """A long form whose values are named by a message and a field of it."""
    s = series(run)
    values = {("Vessel Heading", "Heading"): (s["heading"], "deg"), ("Rate of Turn", "Rate"): (s["rot_s"], "deg/s"),
              ("Rudder", "Position"): (s["rudder"], "deg"), ("COG & SOG, Rapid Update", "COG"): (s["cog"], "deg"),
              ("COG & SOG, Rapid Update", "SOG"): (fixed(run.sog), "m/s")}  # fmt: skip
    stamps = [text.replace("T", "-") for text in s["iso"]]
    rows = [
        f"{stamps[i]};{message};{field};{cells[i]};{unit}"
        for i in range(run.t.size)
        for (message, field), (cells, unit) in values.items()
    ]
    (folder / "n2k.csv").write_text("\n".join(["Timestamp;Name;Field;Value;Unit", *rows]))
    return [folder / "n2k.csv"]


def _rate_of_file(run: Run, folder: Path) -> list[Path]:
    content = {"fs": 2.0, "run": 7, "heading_deg": run.psi * D, "r_degs": run.r * D, "rudder_deg": run.delta * D}
    scipy.io.savemat(folder / "run.mat", content)
    return [folder / "run.mat"]


def _feather(run: Run, folder: Path) -> list[Path]:
    columns = {"time_s": run.t, "heading_deg": run.psi * D, "rot_deg_s": run.r * D, "rudder_deg": run.delta * D}
    pyarrow.feather.write_feather(pa.table(columns), folder / "run.feather")
    return [folder / "run.feather"]


def _bridge(s, run=None) -> dict[str, list[str]]:
    return {"time_s": s["t"], "heading_deg": s["heading"], "rot_deg_min": s["rot_min"], "rudder_deg": s["rudder"]}


def _gzip(run: Run, folder: Path) -> list[Path]:
    (path,) = table(folder / "run.csv", _bridge(series(run)))
    (folder / "run.csv.gz").write_bytes(gzip.compress(path.read_bytes()))
    return [folder / "run.csv.gz"]


def _zip(run: Run, folder: Path) -> list[Path]:
    s = series(run)
    gyro = table(folder / "gyro.csv", {"utc": s["iso"], "heading_deg": s["heading"], "rot_deg_min": s["rot_min"]})
    helm = table(folder / "helm.csv", {"utc": s["iso"], "rudder_deg": s["rudder"]})
    with zipfile.ZipFile(folder / "both.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("readme.txt", "Two loggers of one run.\n")
        for path in (*gyro, *helm):
            archive.write(path, f"trial/{path.name}")
    return [folder / "both.zip"]


def _lines(name: str, head, columns, width: int = 11):
    """Numbers of fixed width below some lines."""

    def write(run: Run, folder: Path) -> list[Path]:
        rows = zip(*columns(series(run), run), strict=True)
        lines = [*head, *("".join(f"{cell:>{width}}" for cell in row) for row in rows)]
        (folder / name).write_text("\n".join(lines) + "\n")
        return [folder / name]

    return write


def _tank(s, run):
    return [s["t"], fixed(run.psi * D), s["rot_s"], s["rudder"]]


def _with_statistics(s, run):
    """Statistics above the data and below them."""
    above = {"name": ["min", "max"], "Time [s]": ["0.00", "240.00"], "Heading [deg]": ["0.1", "359.8"],
             "Yaw rate [deg/s]": ["-9.0", "9.0"], "Rudder [deg]": ["-25.0", "25.0"]}  # fmt: skip
    data = [[""] * run.t.size, s["t"], s["heading"], s["rot_s"], s["rudder"]]
    below = ["Mean", "", "180.0", "0.1", "0.2"]
    return {name: above[name] + own + [last] for name, own, last in zip(above, data, below, strict=True)}


def _with_dropouts(s, run):
    lost = {*range(100, 120), *range(200, 205)}
    cells = {name: own if name == "time_s" else ["0.0" if i in lost else x for i, x in enumerate(own)]
             for name, own in _bridge(s).items()}  # fmt: skip
    return cells | {"sog_kn": ["0.0" if i in lost else x for i, x in enumerate(s["sog"])]}


def _with_spikes(s, run):
    """A heading that jumps in some rows, a rate with a bias."""
    heading = [str(float(7 * i % 360)) if i % 60 == 31 else x for i, x in enumerate(s["heading"])]
    return _bridge(s) | {"heading_deg": heading}


def _nested(run: Run, folder: Path) -> list[Path]:
    s = series(run)
    rows = [
        {"ts": round(1e3 * (START + t)),
         "nav": {"heading_deg": float(s["heading"][i]), "rot_deg_min": float(s["rot_min"][i])},
         "steering": {"rudder_deg": float(s["rudder"][i]), "order_deg": float(s["order"][i])}}
        for i, t in enumerate(run.t)
    ]  # fmt: skip
    (folder / "log.jsonl").write_text("\n".join(map(json.dumps, rows)))
    return [folder / "log.jsonl"]


def _units_apart(run: Run, folder: Path) -> list[Path]:
    units = {"time": "s", "heading": "deg", "rot": "deg/s", "rudder": "deg"}
    data = {"time": run.t.tolist(), "heading": (run.psi * D).tolist(), "rot": (run.r * D).tolist(),
            "rudder": (run.delta * D).tolist()}  # fmt: skip
    (folder / "log.json").write_text(json.dumps({"meta": {"ship": "X", "units": units}, "data": data}))
    return [folder / "log.json"]


def _pairs(run: Run, folder: Path) -> list[Path]:
    """Series of pairs of value and time, as Grafana answers."""
    named = {"heading_deg": run.psi * D, "rot_deg_s": run.r * D, "rudder_deg": run.delta * D}
    stamps = [round(1e3 * (START + t)) for t in run.t]
    answer = [
        {"target": name, "datapoints": [[round(float(v), 4), t] for v, t in zip(own, stamps, strict=True)]}
        for name, own in named.items()
    ]
    (folder / "panel.json").write_text(json.dumps(answer))
    return [folder / "panel.json"]


def _rows_of_database(run: Run, folder: Path) -> list[Path]:
    s = series(run)
    rows = [[round(1e3 * (START + t)), float(s["heading"][i]), float(s["rot_s"][i]), float(s["rudder"][i])]
            for i, t in enumerate(run.t)]  # fmt: skip
    names = ["time", "heading_deg", "rot_deg_s", "rudder_deg"]
    (folder / "query.json").write_text(json.dumps({"results": [{"series": [{"columns": names, "values": rows}]}]}))
    return [folder / "query.json"]


def _engine(s, run):
    rng = np.random.default_rng(4)
    numbers = {"lube_oil_temp_C": 72.0, "fuel_flow_l_h": 820.0, "exhaust_temp_C": 350.0, "tank level [%]": 40.0}
    return {"time": s["t"]} | {name: fixed(size + rng.normal(0.0, 1.0, run.t.size)) for name, size in numbers.items()}


def _swinging(s, run):
    """A course that has no rate beside it; only the track tells whether it is that of the bow."""
    return {"time [s]": s["t"], "lat [deg]": s["lat"], "lon [deg]": s["lon"], "course [deg]": s["heading"],
            "rudder [deg]": s["rudder"]}  # fmt: skip


def _spoken(run: Run, folder: Path) -> list[Path]:
    """Lines of a program's log, with units behind the numbers."""
    s = series(run)
    cells = zip([text.replace("T", " ") for text in s["iso"]], s["heading"], s["rot_min"], s["rudder"], strict=True)
    lines = [f"{t} INFO nav: hdg={a}deg rot={b}deg/min rudder={c}deg" for t, a, b, c in cells]
    (folder / "nav.log").write_text("\n".join(lines))
    return [folder / "nav.log"]


def _dotted(s, run):
    """German dates and times of day, both with dots."""
    dates = [f"{text[8:10]}.{text[5:7]}.{text[2:4]}" for text in s["iso"]]
    clocks = [text[11:19].replace(":", ".") for text in s["iso"]]
    return {"Datum": dates, "Zeit": clocks, "Steuerkurs [Grad]": s["heading"], "Ruder [Grad]": s["rudder"],
            "Drehrate [Grad/min]": s["rot_min"]}  # fmt: skip


EXAM_CASES: dict[str, Case] = {
    "messages of canboat in radians, which no line states": Case(_messages(1.0, 4), True, questions=0),
    "messages of canboat in degrees, which no line states": Case(_messages(D, 1), False, questions=0),
    "a sway to port under the name of a record": Case(
        texts("run.csv", lambda s, run: {
            "time_s": s["t"], "north_m": s["north"], "east_m": s["east"], "heading_deg": s["heading"],
            "surge_ms": s["u"], "sway_ms": fixed(-run.v, 4), "rudder_deg": s["rudder"]}),
        True, {"sway_ms": Is("sway", "m/s", -1)}, (*PLACED[:2], "sway_m_s"), questions=1),
    "a quaternion in paths with slashes": Case(texts("plot.csv", _plotted), True, wanted=PLACED, questions=0),
    "messages of an autopilot with flags that never change": Case(
        _autopilot, True, wanted=("rudder_rad", "heading_rad", "north_m", "east_m"), questions=0),
    "a long form of messages and their fields": Case(
        _of_fields, True, wanted=(*PLACED[:3], "surge_m_s", "sway_m_s"), questions=0),
    "a sampling rate beside the arrays": Case(_rate_of_file, True, questions=0),
    "a table of Arrow": Case(_feather, False, questions=0),
    "a file of gzip": Case(_gzip, False, questions=0),
    "two loggers in an archive": Case(_zip, True, questions=0),
    "names listed with numbers and units": Case(
        _lines("4711.dat", NUMBERED, _tank), True, questions=0),
    "names listed with their number behind a word": Case(
        _lines("v88.asc", BEHIND_A_WORD, _tank), True, questions=0),
    "names in one line and a rate of samples": Case(
        _lines("A32.txt", IN_ONE_LINE, lambda s, run: [[str(i) for i in range(run.t.size)], *_tank(s, run)[1:]]), True,
        questions=0),
    "names that touch": Case(
        _lines("run17.out", (" RUN 17", "     T(S)HEADING(DEG)ROT(DEG/S)RUDDER(DEG)"), _tank), True, questions=0),
    "rows of statistics": Case(texts("st.csv", _with_statistics), True, questions=0),
    "rows of zeros where nothing was received": Case(texts("zeros.csv", _with_dropouts), True, questions=0),
    "a heading with spikes": Case(
        texts("sp.csv", _with_spikes), True, wanted=("rudder_rad", "yaw_rate_rad_s"), questions=0, loose=0.4),
    "a comment that states the side": Case(
        texts("c.csv", lambda s, run: _bridge(s) | {"rudder_deg": fixed(-run.delta * D)},
              head=("# logger v2.1", "# rudder: positive = port")), True, side="port", questions=0),
    "a comment that states the other side": Case(
        texts("c.csv", _bridge, head=("# logger v2.1", "# rudder: positive = port")), True, questions=1),
    "west and a yaw against the clock": Case(
        texts("nwu.csv", lambda s, run: {
            "time [s]": s["t"], "north [m]": s["north"], "west [m]": fixed(-run.east),
            "yaw [deg, counterclockwise from north]": fixed(-run.psi * D), "r [deg/s]": fixed(-run.r * D, 4),
            "rudder [deg]": s["rudder"]}), True, wanted=PLACED, questions=0),
    "a roll to the side that goes down": Case(
        texts("roll.csv", lambda s, run: _bridge(s) | {"roll [deg, + = port side down]": fixed(-run.roll * D)}),
        True, wanted=("rudder_rad", "heading_rad", "roll_rad"), questions=0),
    "dates of a language that writes the day first": Case(
        texts("vaart.csv", lambda s, run: {
            "Tijdstip": [f"04-03-2026 {text[11:]}" for text in s["iso"]], "Voorliggende koers (°)": s["heading"],
            "Bochtsnelheid (°/min)": s["rot_min"], "Roerstand (°)": s["rudder"]},
            sep=";", comma=True), True, questions=0),
    "an order within an object": Case(
        _nested, False, wanted=(*PLACED[:3], "rudder_command_rad"), questions=0),
    "units in an object of their own": Case(_units_apart, True, questions=0),
    "series of pairs": Case(_pairs, True, questions=0),
    "rows below the names of a database": Case(_rows_of_database, True, questions=0),
    "tenths of a degree that no one states": Case(
        texts("tenths.csv", lambda s, run: {
            "Time [s]": s["t"], "HDG": fixed(10.0 * (run.psi * D % 360.0), 0), "Rudder [deg]": s["rudder"]}),
        True, {"HDG": Is("heading", "deg", factor=0.1)}, ("rudder_rad", "heading_rad"), questions=None),
    "units behind the numbers of a program's log": Case(_spoken, True, questions=0),
    "times of day with dots": Case(texts("fahrt.csv", _dotted, sep=";"), True, questions=0),
    "receivers with numbers": Case(
        texts("two.csv", lambda s, run: {
            "time_s": s["t"], "gps1_lat": s["lat"], "gps1_lon": s["lon"], "gps2_lat": fixed(run.lat + 1e-5, 8),
            "gps2_lon": fixed(run.lon + 1e-5, 8), "gps1_sog_kn": s["sog"], "gps1_cog_deg": s["cog"],
            "hdg_deg": s["heading"], "rudder_deg": s["rudder"]}),
        True, wanted=("rudder_rad", "heading_rad", "north_m", "east_m", "surge_m_s"), questions=0),
    "velocities of which north and east are exchanged": Case(
        texts("vel.csv", lambda s, run: {
            "time [s]": s["t"], "Vn [m/s]": fixed(run.east_speed, 4), "Ve [m/s]": fixed(run.north_speed, 4),
            "Heading [deg]": s["heading"], "Rudder [deg]": s["rudder"]}),
        True, {"Heading": Is("heading", "deg")}, refused="are north and east exchanged?"),
    "a log of an engine": Case(texts("er.csv", _engine), True, refused="nothing tells how the ship turns"),
    "a course that is the heading by its track": Case(
        texts("course.csv", _swinging), True, wanted=("rudder_rad", "heading_rad", "north_m", "east_m"), questions=0),
    "speeds with the sides in their names": Case(
        texts("dvl.csv", lambda s, run: {
            "Timestamp": s["iso"], "Heading [deg]": s["heading"], "BT Vel Fwd [m/s]": s["u"],
            "BT Vel Stbd [m/s]": s["v"], "Rudder [deg]": s["rudder"]}),
        True, {"BT Vel Stbd": Is("sway", "m/s")}, ("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s"), questions=1),
    "a yaw rate that the answer for the yaw contradicts": Case(
        texts("e.csv", lambda s, run: {
            "time_s": s["t"], "yaw_rad": fixed(np.pi / 2.0 - run.psi, 5), "yaw_rate_rad_s": fixed(-run.r, 6),
            "propeller_rps": s["rps"], "roll_rad": fixed(run.roll, 5), "rudder_deg": s["rudder"]}),
        True, {"yaw_rad": Is("heading", "rad", -1, offset=np.pi / 2.0), "yaw_rate_rad_s": Is("yaw_rate", "rad/s", -1)},
        questions=2),
    "knots of a speed whose name says surge last": Case(
        texts("sp.csv", lambda s, run: _bridge(s) | {"speed surge [kn]": fixed(run.u / KN)}), False,
        wanted=("rudder_rad", "heading_rad", "surge_m_s"), questions=0),
}  # fmt: skip
"""Name -> case; all are imported with no more questions than it says."""
