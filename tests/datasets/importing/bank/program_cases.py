"""Logs as programs and instruments write them: one question for all that one thing leaves open, none for what the file
or the motion tells."""

import math
from pathlib import Path

import numpy as np
import openpyxl

from .case import Case, Is
from .texts import D, fixed, iso, series, table, texts
from .truth import START, Run

TURN, STEER = ("rudder_rad", "heading_rad", "yaw_rate_rad_s"), ("rudder_rad", "heading_rad")
TRACK = ("north_m", "east_m")
FROM_EAST = {"sign": -1, "offset": math.pi / 2.0}
MATHEMATICAL = {
    "X": Is("east", "m"), "Y": Is("north", "m"), "yaw": Is("heading", "deg", **FROM_EAST),
    "Rotation 3": Is("heading", "deg", **FROM_EAST), "rate": Is("yaw_rate", "deg/s", -1),
}  # fmt: skip
SI = {
    "x": Is("north", "m"), "y": Is("east", "m"), "psi": Is("heading", "rad"), "r": Is("yaw_rate", "rad/s"),
    "u": Is("surge", "m/s"), "v": Is("sway", "m/s"), "delta": Is("rudder", "rad"),
}  # fmt: skip


def _orcaflex(s, run):
    return {
        "Time (s)": s["t"], "X (m)": s["east"], "Y (m)": s["north"],
        "Rotation 3 (deg)": fixed(90.0 - run.psi * D), "x velocity (m/s)": s["u"], "y velocity (m/s)": fixed(-run.v, 4),
        "z angular velocity (deg/s)": fixed(-run.r * D, 4), "Rudder angle (deg)": fixed(-run.delta * D),
    }  # fmt: skip


def _flow(s, run):
    twice = {"Yaw": ("deg", fixed(run.psi * D)), "Yaw Rate": ("deg/s", s["rot_s"]), "Velocity[i]": ("m/s", s["u"]),
             "Velocity[j]": ("m/s", s["v"]), "Rudder Angle": ("deg", s["rudder"])}  # fmt: skip
    named = {f"Ship {n} Monitor: Ship {n} Monitor ({unit})": cells for n, (unit, cells) in twice.items()}
    return {"Physical Time: Physical Time (s)": s["t"], **named}


def _recorder(s, run):
    return {"Time[s]": s["t"], "CH1[deg]": s["rudder"], "CH2[deg]": fixed(run.psi * D), "CH3[deg/s]": s["rot_s"]}


def _motion_sensor(s, run):
    seconds = run.t + START % 60.0
    return {
        "PacketCounter": [str(i) for i in range(run.t.size)],
        "UTC_Nano": [str(round(1e9 * (x % 1.0))) for x in seconds], "UTC_Hour": ["9"] * run.t.size,
        "UTC_Minute": [str(26 + int(x // 60)) for x in seconds], "UTC_Second": [str(int(x % 60)) for x in seconds],
        "Gyr_Z": fixed(-run.r, 6), "Yaw": fixed((90.0 - run.psi * D + 180.0) % 360.0 - 180.0),
        "Rudder (deg)": s["rudder"],
    }  # fmt: skip


def _servo(run: Run, folder: Path) -> list[Path]:
    s, stamps, n = series(run), fixed(START + run.t, 3), run.t.size
    state = {"timestamp": stamps, "entity": ["Navigation"] * n, "psi (rad)": s["psi_rad"], "r (rad/s)": s["r_rad"],
             "latitude (deg)": s["lat"], "longitude (deg)": s["lon"]}  # fmt: skip
    servo = {"timestamp": stamps, "entity": ["Rudder Servo"] * n, "value (rad)": s["delta_rad"]}
    return table(folder / "EstimatedState.csv", state) + table(folder / "SetServo.csv", servo)


def _durations(s, run):
    return {"Time": [f"{t} sec" for t in s["t"]], "x": s["north"], "y": s["east"], "psi": fixed(run.psi, 5),
            "u": s["u"], "v": s["v"], "r": s["r_rad"], "delta": s["delta_rad"]}  # fmt: skip


def _german(s, run):
    return {"Zeit": s["t"], "Ruder [Grad]": s["rudder"], "Kurs [Grad]": fixed(run.psi * D, 3),
            "Drehrate [Grad/s]": fixed(run.r * D, 5), "X_Pos [m]": s["north"], "Y_Pos [m]": s["east"]}  # fmt: skip


def _survey(s, run):
    return {"Time": s["iso"], "Easting": fixed(run.east + 584000.0, 2), "Northing": fixed(run.north + 6030000.0, 2),
            "Gyro": s["heading"], "ROT": s["rot_min"], "Rud": s["rudder"]}  # fmt: skip


def _north_east(s, run):
    return {"t": s["t"], "pos_n": s["north"], "pos_e": s["east"], "psi": s["psi_rad"], "r": s["r_rad"],
            "delta": s["delta_rad"], "thrust": fixed(12.0 + 0.0 * run.t)}  # fmt: skip


def _bridge(s, run):
    stamps = [text.replace("-", "").replace(":", "").replace("T", "")[:14] for text in iso(run)]
    return {"UTC": stamps, "GYRO_HDT": s["heading"], "GYRO_ROT": s["rot_min"], "RUDDER_RSA_STBD": s["rudder"],
            "GPS_SOG": s["sog"], "GPS_COG": s["cog"], "ANEMO_MWV_SPD": fixed(5.0 + np.sin(run.t))}  # fmt: skip


def _labels(s, run):
    return {"Time": s["iso"], 'heading {sensor="gyro"}': s["heading"], 'rudder_angle {sensor="rfu"}': s["rudder"],
            'rate_of_turn {sensor="gyro"}': s["rot_min"]}  # fmt: skip


def _quoted(run: Run, folder: Path) -> list[Path]:
    s = series(run)
    names = '"Time Step" "heading [deg]" "yaw-rate [deg/s]" "rudder-angle [deg]" "flow-time"'
    rows = zip(s["heading"], s["rot_s"], s["rudder"], s["t"], strict=True)
    lines = ['"report-file"', names, f"({names})", *(f"{i} {' '.join(row)}" for i, row in enumerate(rows, start=1))]
    (folder / "motion.out").write_text("\n".join(lines) + "\n", "utf-8")
    return [folder / "motion.out"]


def _serial(run: Run, folder: Path) -> list[Path]:
    s = series(run)
    clock = [text[11:] for text in s["iso"]]
    rows = zip(clock, s["heading"], s["rot_s"], s["rudder"], strict=True)
    lines = [f"{t} -> HDG:{heading},GZ:{rate},RUD:{rudder}" for t, heading, rate, rudder in rows]
    (folder / "serial.txt").write_text("\n".join(lines) + "\n", "utf-8")
    return [folder / "serial.txt"]


def _trial(run: Run, folder: Path) -> list[Path]:
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (["SEA TRIAL"], ["Hull No.", "4711", None, "Date", "14.03.2026"], []):
        sheet.append(row)
    sheet.append(["Time (min:sec)", "Rudder angle", "Heading (°)"])
    for t, angle, psi in zip(run.t, run.delta * D, run.psi * D % 360.0, strict=True):
        sheet.append([f"{int(t // 60):02d}:{t % 60:04.1f}", f"{'S' if angle >= 0.0 else 'P'} {abs(angle):.1f}", psi])
    book.save(folder / "trial.xlsx")
    return [folder / "trial.xlsx"]


def _cameras(s, run):
    return {"Time": s["t"], "Ship X": fixed(1e3 * run.north), "Ship Y": fixed(1e3 * run.east),
            "Ship Z": fixed(np.sin(run.t)), "Heading [deg]": s["heading"], "Rudder [deg]": s["rudder"]}  # fmt: skip


def _electronic_chart(s, run):
    return {"Date Time": s["iso"], "HDG(T)": s["heading"], "SPD(OG)": s["sog"], "CRS(OG)": s["cog"],
            "RUD(ACT)": s["rudder"]}  # fmt: skip


def _receiver(s, run):
    return {"UTC": s["iso"], "Lat [deg]": s["lat"], "Lon [deg]": s["lon"], "Course [deg]": fixed(run.cog * D, 3),
            "ROT [deg/min]": fixed(60.0 * run.r * D, 3), "Rudder [deg]": s["rudder"]}  # fmt: skip


def _state(s, run):
    return {"time (s)": s["t"], "xg (m)": s["north"], "yg (m)": s["east"], "psi (deg)": fixed(run.psi * D, 3),
            "vx (m/s)": s["u"], "vy (m/s)": s["v"], "r (deg/s)": s["rot_s"], "del (deg)": s["rudder"]}  # fmt: skip


def _over_ground(s, run):
    speeds = {"vx (m/s)": fixed(run.north_speed, 4), "vy (m/s)": fixed(run.east_speed, 4)}
    return {name: cells for name, cells in _state(s, run).items() if name not in speeds} | speeds


def log(name, make, wanted, questions, knows=(), side="starboard", **options):
    """A case that needs so many questions; `make` writes it, or gives its columns."""
    write = make if make.__code__.co_varnames[:2] == ("run", "folder") else texts(name, make, **options)
    return Case(write, True, dict(knows), wanted, side, questions=questions)


CHANNELS = ['"CH1","RUDDER ANGLE"', '"CH2","GYRO COMPASS"', '"CH3","YAW RATE"']
PROGRAM_CASES = {
    "axes x east, y north, z up": log("history.txt", _orcaflex, (*TURN, *TRACK), 1, MATHEMATICAL, "port", sep="\t"),
    "a flow program's monitors": log("monitors.csv", _flow, (*TURN, "surge_m_s", "sway_m_s"), 1, {
        "Ship Yaw Monitor: Ship Yaw Monitor": Is("heading", "deg")}),
    "names of channels above the header": log("0001.csv", _recorder, TURN, 0, head=["RECORDER", *CHANNELS]),
    "the frame above the header": log("mt.txt", _motion_sensor, TURN, 0, sep="\t", head=["// Coordinate system: ENU"]),
    "a servo named in a column of texts": log("", _servo, TURN, 0),
    "times with their unit, columns without": log("run.csv", _durations, (*TURN, *TRACK, "sway_m_s"), 2, SI),
    "a course that is the integral of the rate": log("famos.csv", _german, (*TURN, *TRACK), 0, sep=";"),
    "a survey without units": log("line.csv", _survey, (*TURN, *TRACK), 1, {
        "Easting": Is("east", "m"), "Northing": Is("north", "m"), "Rud": Is("rudder", "deg")}),
    "north and east without units": log("state.csv", _north_east, (*TURN, *TRACK), 1, SI | {
        "pos_n": Is("north", "m"), "pos_e": Is("east", "m")}),
    "names of instrument and sentence": log("vdr.csv", _bridge, TURN, 1, {
        "RUDDER_RSA_STBD": Is("rudder", "deg"), "GPS_SOG": Is("speed_over_ground", "kn")}),
    "names with labels": log("panel.csv", _labels, TURN, 0, {
        'rudder_angle {sensor="rfu"}': Is("rudder", "deg")}, quote=True),
    "names in quotes over spaces": log("", _quoted, TURN, 0),
    "names and values in each line": log("", _serial, STEER, 1, {"RUD": Is("rudder", "deg")}),
    "minutes and seconds under a title with a date": log("", _trial, STEER, 0),
    "positions in millimetres": log("zigzag.tsv", _cameras, (*STEER, *TRACK), 1, {
        "Ship X": Is("north", "m", 1, 1e-3), "Ship Y": Is("east", "m", 1, 1e-3)}, sep="\t"),
    "a course that goes along the track": log("gps.csv", _receiver, ("rudder_rad", "yaw_rate_rad_s", "north_m"), 0),
    "velocities of the ship's axes": log("tc.out", _state, (*TURN, *TRACK, "surge_m_s", "sway_m_s"), 1, {
        "xg": Is("north", "m"), "yg": Is("east", "m")}, sep="\t"),
    "velocities over ground": log("zz.out", _over_ground, (*TURN, *TRACK), 1, {
        "xg": Is("north", "m"), "yg": Is("east", "m")}, sep="\t"),
    "a chart's names in brackets": log("chart.csv", _electronic_chart, STEER, 1, {
        "RUD(ACT)": Is("rudder", "deg"), "SPD(OG)": Is("speed_over_ground", "kn")}),
}  # fmt: skip
