"""Logs of the bank in which something is chosen: a vessel, a scale, what steers, the order of two rudders."""

from pathlib import Path

import numpy as np

from .case import Case, Is
from .texts import D, fixed, iso, series, table, texts
from .truth import KN, Run

TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
TRACK = ("heading_rad", "north_m", "east_m", "surge_m_s", "sway_m_s")
SCALE = 36.0
OTHERS = (("219000001", "NORD", 0.02), ("219000003", "SUND", -0.05))


def _ais_row(run: Run, i: int, who: tuple[str, str, float]) -> list[str]:
    """A row of AIS: of another vessel shifted and on a course of its own, with a heading that is not available."""
    mmsi, name, away = who
    s = series_of(run, i)
    if away:
        s |= {
            "lat": f"{run.lat[0] + away + 1e-6 * i:.6f}",
            "cog": "360.0",
            "heading": "511",
            "rot": "-128",
            "sog": "102.3",
        }
    return [mmsi, s["time"], s["lat"], s["lon"], s["sog"], s["cog"], s["heading"], s["rot"], name]


def series_of(run: Run, i: int) -> dict[str, str]:
    return {
        "time": iso(run)[i], "lat": f"{run.lat[i]:.7f}", "lon": f"{run.lon[i]:.7f}", "sog": f"{run.sog[i] / KN:.2f}",
        "cog": f"{run.cog[i] * D:.2f}", "heading": f"{run.psi[i] * D % 360.0:.2f}", "rot": f"{run.r[i] * D * 60:.2f}",
    }  # fmt: skip


def _ais(header: str, blocks: bool):
    def write(run: Run, folder: Path) -> list[Path]:
        whose = [("219000002", "OST", 0.0), *OTHERS]
        times = range(0, run.t.size, 4)
        rows = [(k, i) for k in range(3) for i in times] if blocks else [(k, i) for i in times for k in range(3)]
        lines = [header, *(",".join(_ais_row(run, i, whose[k])) for k, i in rows)]
        (folder / "ais.csv").write_text("\n".join(lines) + "\n", "utf-8")
        return [folder / "ais.csv"]

    return write


def _swarm(run: Run, folder: Path) -> list[Path]:
    """Two boats that a vague column tells apart, the other one going astern along the same track."""
    head = "t [s],id,north [m],east [m],heading [deg],yaw rate [deg/s],rudder [deg]"
    rows = []
    for i, t in enumerate(run.t):
        for boat, k in (("2", i), ("1", run.t.size - 1 - i)):
            own = (run.north[k], run.east[k], run.psi[k] * D % 360.0, run.r[k] * D, run.delta[k] * D)
            rows.append(f"{t:.2f},{boat}," + ",".join(f"{x:.4f}" for x in own))
    (folder / "swarm.csv").write_text("\n".join([head, *rows]) + "\n", "utf-8")
    return [folder / "swarm.csv"]


def _two_rudder_files(run: Run, folder: Path) -> list[Path]:
    s = series(run)
    table(folder / "pilot.csv", {"Time [UTC]": s["iso"], "Heading [deg]": s["heading"], "Rudder [deg]": s["order"]})
    table(folder / "gear.csv", {"Time [UTC]": s["iso"], "Rudder [deg]": s["rudder"]})
    return [folder / "pilot.csv", folder / "gear.csv"]


def _equal_headers(run: Run, folder: Path) -> list[Path]:
    s, half = series(run), run.t.size // 2
    columns = {"Time": s["iso"], "Heading": s["heading"], "Rudder": s["rudder"]}
    for name, part in (("a.csv", slice(None, half)), ("b.csv", slice(half, None))):
        table(folder / name, {key: values[part] for key, values in columns.items()})
    return [folder / "a.csv", folder / "b.csv"]


def _smooth(values: np.ndarray) -> np.ndarray:
    """Values (N,) whose steps take three samples."""
    return np.convolve(np.concatenate([values[:1], values, values[-1:]]), np.full(3, 1.0 / 3.0), "valid")


ROOT = SCALE**0.5
CHOICE_CASES: dict[str, Case] = {
    "AIS, three vessels in turn": Case(
        _ais("MMSI,BaseDateTime,LAT,LON,SOG,COG,Heading,ROT,VesselName", blocks=False),
        True, wanted=TRACK, whole={"vessel": "219000002"}, questions=1,
    ),
    "AIS, three vessels one after another": Case(
        _ais("mmsi,timestamp,latitude,longitude,sog,cog,heading,rot,shipname", blocks=True),
        True, wanted=(*TRACK, "yaw_rate_rad_s"), whole={"vessel": "219000002"}, questions=1,
    ),
    "two boats by a vague id": Case(_swarm, True, wanted=(*TURN, "north_m"), whole={"vessel": "2"}, questions=1),
    "no rudder": Case(
        texts("bridge.csv", lambda s, r: {
            "Time": s["iso"], "Lat": s["lat"], "Lon": s["lon"], "Heading [deg]": s["heading"],
            "ROT [deg/min]": s["rot_min"], "Drift angle [deg]": fixed(-np.arctan2(r.v, r.u) * D),
            "Air": fixed(-1.0 + 2.0 * np.sin(r.t / 90.0), 2),
        }),
        True, wanted=("heading_rad", "yaw_rate_rad_s", "north_m", "east_m"), questions=0,
    ),
    "positions alone": Case(
        texts("track.csv", lambda s, r: {"time": s["iso"], "latitude": s["lat"], "longitude": s["lon"]}),
        True, wanted=("north_m", "east_m"), questions=0,
    ),
    "axes of a track, which tell its velocities": Case(
        texts("state.csv", lambda s, r: {
            "t [s]": s["t"], "x (m)": s["north"], "y (m)": s["east"], "psi (rad)": s["psi_rad"],
            "r (rad/s)": s["r_rad"],
            "vx (m/s)": fixed(r.north_speed, 4), "vy (m/s)": fixed(r.east_speed, 4), "p (rad/s)": fixed(0.0 * r.t, 1),
            "u (m/s)": s["u"], "v (m/s)": s["v"], "rudder (rad)": s["delta_rad"],
        }),
        True, {"x": Is("north", "m")}, (*TURN, "north_m", "east_m", "surge_m_s", "sway_m_s"), questions=1,
    ),
    "a rudder without a name": Case(
        texts("boat.csv", lambda s, r: {
            "Time": s["iso"], "Heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"], "XQ4 [deg]": s["rudder"],
            "Air": fixed(-1.0 + 2.0 * np.sin(r.t / 90.0), 2),
        }),
        True, {"XQ4": Is("rudder", "deg")}, TURN, questions=1,
    ),
    "two propellers in newtons": Case(
        texts("twin.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "yaw rate [deg/s]": s["rot_s"],
            "thruster_port [N]": fixed(40.0 + 50.0 * r.delta, 5), "thruster_stbd [N]": fixed(40.0 - 50.0 * r.delta, 5),
        }),
        True, wanted=("thrust_port_N", "thrust_starboard_N", "rudder_command_rad", "heading_rad"), questions=0,
    ),
    "two propellers by their pulses": Case(
        texts("twin.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "yaw rate [deg/s]": s["rot_s"],
            "motor_left_pwm": fixed(1600.0 + 400.0 * r.delta, 0), "motor_right_pwm": fixed(1600.0 - 400.0 * r.delta, 0),
        }),
        True, wanted=("thrust_port_N", "thrust_starboard_N", "rudder_command_rad", "heading_rad"), questions=0,
    ),
    "two propellers by the yaw rate alone": Case(
        texts("rover.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "yaw rate [deg/s]": s["rot_s"],
            "C1": fixed(1600.0 + 400.0 * r.delta, 0), "C3": fixed(1600.0 - 400.0 * r.delta, 0),
        }),
        True, wanted=("thrust_port_N", "thrust_starboard_N", "rudder_command_rad", "heading_rad"),
        whole={"propellers": "C1, C3"}, questions=1,
    ),
    "the rudder is the order": Case(
        texts("pilot.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"],
            "Rudder [deg]": s["order"], "Rudder FB [deg]": s["rudder"],
        }),
        True, wanted=(*TURN, "rudder_command_rad"), questions=0,
    ),
    "order and answer, two rudders": Case(
        texts("pilot.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"],
            "Rudder port [deg]": s["rudder"], "Rudder stbd [deg]": fixed(r.delta * D + 0.05, 2),
            "Rudder set [deg]": s["order"],
        }),
        True, wanted=(*TURN, "rudder_command_rad"), questions=0,
    ),
    "the order is called the answer": Case(
        texts("pilot.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"],
            "Rudder order [deg]": s["rudder"], "Rudder [deg]": s["order"],
        }),
        True, {"Rudder order": Is("rudder", "deg"), "Rudder": Is("rudder_command", "deg")},
        (*TURN, "rudder_command_rad"), questions=1,
    ),
    "a smooth order and its answer": Case(
        texts("pilot.csv", lambda s, r: {
            "time [s]": s["t"], "heading [deg]": s["heading"], "ROT [deg/min]": s["rot_min"],
            "Rudder [deg]": fixed(_smooth(r.order) * D, 2), "Rudder reply [deg]": s["rudder"],
        }),
        True, wanted=(*TURN, "rudder_command_rad"), questions=0, loose=0.06,
    ),
    "two files that each call it rudder": Case(
        _two_rudder_files, True, wanted=("rudder_rad", "rudder_command_rad", "heading_rad"), questions=0
    ),
    "two scales by their names": Case(
        texts("tank.csv", lambda s, r: {
            "T_ms [s]": s["t"], "T_fs [s]": fixed(r.t * ROOT, 3), "psi [deg]": s["heading"],
            "R_ms [deg/s]": s["rot_s"], "R_fs [deg/min]": fixed(60.0 * r.r * D / ROOT, 4), "U_ms [m/s]": s["u"],
            "U_fs [kn]": fixed(r.u * ROOT / KN), "delta [deg]": s["rudder"],
        }, head=("psi positive to starboard",)),
        True, wanted=(*TURN, "surge_m_s"), whole={"scale": "model"}, questions=1,
    ),
    "two scales, the time of the model without a mark": Case(
        texts("tank.csv", lambda s, r: {
            "Time [s]": s["t"], "Heading [deg]": s["heading"], "r (ship) [deg/s]": fixed(r.r * D / ROOT, 5),
            "r (model) [deg/s]": s["rot_s"], "u (ship) [m/s]": fixed(r.u * ROOT, 4), "u (model) [m/s]": s["u"],
            "rudder [deg]": s["rudder"],
        }),
        True, wanted=(*TURN, "surge_m_s"), whole={"scale": "model"}, questions=1,
    ),
    "two scales by factors alone": Case(
        texts("tank.csv", lambda s, r: {
            "t [s]": s["t"], "time 2 [s]": fixed(r.t * ROOT, 3), "Heading [deg]": s["heading"],
            "yaw rate [deg/s]": s["rot_s"], "yaw rate 2 [deg/s]": fixed(r.r * D / ROOT, 5), "surge [m/s]": s["u"],
            "surge 2 [m/s]": fixed(r.u * ROOT, 4), "rudder [deg]": s["rudder"],
        }),
        True, wanted=(*TURN, "surge_m_s"), whole={"scale": "model"}, questions=1,
    ),
    "one answer for files with equal headers": Case(
        _equal_headers, True, {"Rudder": Is("rudder", "deg")}, ("rudder_rad", "heading_rad"), questions=1
    ),
    "one answer for one doubt": Case(
        texts("doubt.csv", lambda s, r: {
            "time [s]": s["t"], "Zork heading [deg]": s["heading"], "Zork rot [deg/min]": s["rot_min"],
            "Zork rudder [deg]": s["rudder"],
        }),
        True, {"Zork heading": Is("heading", "deg")}, TURN, questions=1,
    ),
    "names of messages": Case(
        texts("messages.csv", lambda s, r: {
            "time [s]": s["t"], "ATT/heading [deg]": s["heading"], "ATT/rot [deg/min]": s["rot_min"],
            "GEAR/rudder [deg]": s["rudder"], "GEAR/rudder cmd [deg]": s["order"],
        }),
        True, wanted=(*TURN, "rudder_command_rad"), questions=0,
    ),
}  # fmt: skip
