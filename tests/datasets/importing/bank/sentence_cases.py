"""Logs of the bank in sentences and messages: every kind of NMEA 0183 that is read, NMEA 2000 as text, ROS 1 bags."""

import json
import struct

import numpy as np

from .case import Case, Is
from .other_cases import ais, clock, heading, nmea, place, rmc, rudder, sentence, tag, turn
from .texts import D
from .truth import KN, START

TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
TRACK = ("rudder_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
PLACE = ("rudder_rad", "heading_rad", "north_m", "east_m")


def magnetic(run, i, variation=2.1):
    return f"{(run.psi[i] * D - variation) % 360:.2f}"


def true(run, i):
    return f"{run.psi[i] * D % 360:.2f}"


def zda(run, i):
    return sentence(f"GPZDA,{clock(run, i)},14,03,2026,00,00")


def gga(run, i, quality=1):
    return sentence(f"GPGGA,{clock(run, i)},{place(run, i)},{quality},09,0.9,12.0,M,40.0,M,,")


def gll(run, i):
    return sentence(f"GPGLL,{place(run, i)},{clock(run, i)},A,A")


def vtg(run, i):
    speed, course = run.sog[i], run.cog[i] * D
    return sentence(f"GPVTG,{course:.2f},T,{(course - 2.1) % 360:.2f},M,{speed / KN:.3f},N,{speed * 3.6:.3f},K,A")


def vbw(run, i):
    ground = f"{run.u[i] / KN:.3f},{run.v[i] / KN:.3f},A"
    return sentence(f"VDVBW,{run.u[i] / KN + 1.0:.3f},{run.v[i] / KN - 0.5:.3f},A,{ground}")


def rpm(run, i):
    return sentence(f"ERRPM,S,0,{60 * run.rps[i]:.2f},85.0,A")


def both_rudders(run, i):
    return sentence(f"ERRSA,{run.delta[i] * D:.2f},A,{run.delta[i] * D + 0.3:.2f},A")


def pashr(run, i):
    own = f"{clock(run, i)},{true(run, i)},T,{run.roll[i] * D:.3f},0.10,0.02,0.050,0.050,0.040,1,0"
    return sentence(f"PASHR,{own}")


def plain(body):
    """A kind of sentence of which each line is the same text with numbers of the run."""
    return lambda run, i: sentence(body(run, i))


hdm = plain(lambda r, i: f"HCHDM,{magnetic(r, i)},M")
hdg = plain(lambda r, i: f"HCHDG,{(r.psi[i] * D - 3.1) % 360:.2f},1.0,E,2.1,E")
hdg_west = plain(lambda r, i: f"HCHDG,{(r.psi[i] * D + 5.5) % 360:.2f},1.5,W,4.0,W")
ths = plain(lambda r, i: f"GNTHS,{true(r, i)},A")
vhw = plain(lambda r, i: f"VWVHW,{true(r, i)},T,{magnetic(r, i)},M,{r.u[i] / KN:.3f},N,{r.u[i] * 3.6:.3f},K")
mwv = plain(lambda r, i: "WIMWV,214.8,R,9.3,M,A")
own_make = plain(lambda r, i: f"PXYZQ,{i},1.0")


def lines(*makers, every=1):
    """One sentence of each maker for every sample; the first one only for every few of them."""
    return lambda run, i: [make(run, i) for k, make in enumerate(makers) if k or i % every == 0]


def canboat(name, head, message, scale):
    """Lines of canboat's analyzer; `message` writes one."""

    def write(run, folder):
        out = [*head]
        for i, t in enumerate(run.t):
            moment = str(np.datetime64(round(1e3 * (START + t)), "ms"))
            for pgn, source, fields in (
                (127250, 10, {"Heading": round(run.psi[i] % (2 * np.pi) * scale, 5), "Reference": "True"}),
                (127251, 10, {"SID": 1, "Rate": round(run.r[i] * scale, 7)}),
                (
                    127245,
                    20,
                    {"Instance": 0, "Direction Order": "No Order", "Position": round(run.delta[i] * scale, 5)},
                ),
                (130306, 30, {"Wind Speed": 7.5, "Reference": "Apparent"}),
            ):
                out.append(json.dumps(message(moment, pgn, source, fields)))
        (folder / name).write_text("\n".join(out))
        return [folder / name]

    return write


def _message(moment, pgn, source, fields):
    return {
        "timestamp": moment + "Z",
        "prio": 2,
        "src": source,
        "dst": 255,
        "pgn": pgn,
        "description": "x",
        "fields": fields,
    }


def _old_message(moment, pgn, source, fields):
    made = {key.replace(" ", "").lower() if key == "Rate" else key: value for key, value in fields.items()}
    return {
        "timestamp": moment.replace("T", "-"),
        "prio": "2",
        "src": str(source),
        "dst": "255",
        "pgn": str(pgn),
        "fields": made,
    }


def _named_message(moment, pgn, source, fields):
    made = {k: {"value": 0, "name": v} if isinstance(v, str) else v for k, v in fields.items()}
    return _message(moment, pgn, source, made)


def n2k(name, line):
    """Messages of NMEA 2000 as lines of text: heading, rate of turn, rudder."""

    def write(run, folder):
        out = []
        for i, t in enumerate(run.t):
            head = struct.pack("<BHhhB", 255, round(run.psi[i] % (2 * np.pi) / 1e-4), 0x7FFF, 0x7FFF, 0xFC)
            spin = struct.pack("<BihB", 255, round(run.r[i] / 3.125e-8), -1, 255)
            helm = struct.pack("<BBhhH", 0, 0xF8, 0x7FFF, round(run.delta[i] / 1e-4), 0xFFFF)
            moment = str(np.datetime64(round(1e3 * (START + t)), "ms"))
            out += [line(moment, pgn, source, data) for pgn, source, data in
                    ((127250, 10, head), (127251, 10, spin), (127245, 20, helm))]  # fmt: skip
        (folder / name).write_text("\n".join(out))
        return [folder / name]

    return write


def _ydvr(moment, pgn, source, data):
    return f"{moment[11:]} R {0x08000000 | pgn << 8 | source:08X} {' '.join(f'{b:02X}' for b in data)}"


def _actisense(moment, pgn, source, data):
    return f"{moment}Z,2,{pgn},{source},255,{len(data)},{','.join(f'{b:02x}' for b in data)}"


def ros1(run, folder):
    """A ROS 1 bag with an odometry in an ENU frame and a rudder with a stamp, by the writer of rosbags."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kinds = store.types
    header, stamp = kinds["std_msgs/msg/Header"], kinds["builtin_interfaces/msg/Time"]
    vector, point = kinds["geometry_msgs/msg/Vector3"], kinds["geometry_msgs/msg/Point"]
    turned, pose, twist = (kinds[f"geometry_msgs/msg/{name}"] for name in ("Quaternion", "Pose", "Twist"))
    none, still = np.zeros(36), vector(0.0, 0.0, 0.0)
    with Writer(folder / "trial.bag") as writer:
        odom = writer.add_connection("/odometry", "nav_msgs/msg/Odometry", typestore=store)
        helm = writer.add_connection("/rudder_angle", "geometry_msgs/msg/Vector3Stamped", typestore=store)
        for i, t in enumerate(run.t):
            ns, yaw = round(1e9 * START) + round(1e9 * t), np.pi / 2 - run.psi[i]
            head = header(i, stamp(ns // 10**9, ns % 10**9), "map_enu")
            spin = turned(0.0, 0.0, float(np.sin(yaw / 2)), float(np.cos(yaw / 2)))
            where = pose(point(float(run.east[i]), float(run.north[i]), 0.0), spin)
            moving = twist(vector(float(run.u[i]), float(-run.v[i]), 0.0), vector(0.0, 0.0, float(-run.r[i])))
            message = kinds["nav_msgs/msg/Odometry"](
                head, "base_flu", kinds["geometry_msgs/msg/PoseWithCovariance"](where, none),
                kinds["geometry_msgs/msg/TwistWithCovariance"](moving, none),
            )  # fmt: skip
            writer.write(odom, ns, store.serialize_ros1(message, "nav_msgs/msg/Odometry"))
            angle = kinds["geometry_msgs/msg/Vector3Stamped"](head, vector(float(run.delta[i]), still.y, still.z))
            writer.write(helm, ns, store.serialize_ros1(angle, "geometry_msgs/msg/Vector3Stamped"))
    return [folder / "trial.bag"]


SENTENCE_CASES: dict[str, Case] = {
    "HDM, variation in RMC": Case(
        nmea("hdm.log", lines(rmc, hdm, turn, rudder, every=2)), True, wanted=TRACK, loose=0.06
    ),
    "HDG to east": Case(nmea("hdg.log", lines(hdg, turn, rudder), tag), True, wanted=TURN),
    "HDG to west": Case(nmea("hdgw.log", lines(hdg_west, turn, rudder), tag), True, wanted=TURN),
    "THS and RPM": Case(nmea("ths.log", lines(ths, turn, rudder, rpm), tag), False, wanted=(*TURN, "propeller_rps")),
    "VBW, over ground and through the water": Case(
        nmea("vbw.log", lines(heading, turn, rudder, vbw), tag), True, wanted=(*TURN, "surge_m_s", "sway_m_s")
    ),
    "GLL and ZDA": Case(nmea("gll.log", lines(zda, gll, heading, turn, rudder)), False, wanted=(*PLACE, TURN[2])),
    "GGA, VTG, no stamps": Case(nmea("gga.log", lines(gga, vtg, heading, turn, rudder)), False, wanted=TRACK),
    "GGA of quality 0": Case(
        nmea("gga0.log", lambda r, i: [gga(r, i, int(i % 7 > 0)), heading(r, i), turn(r, i), rudder(r, i)]),
        True,
        wanted=PLACE,
    ),
    "PASHR with roll": Case(
        nmea("pashr.log", lines(pashr, turn, rudder)), True, {"roll": Is("roll", "deg")}, wanted=(*TURN, "roll_rad")
    ),
    "VHW, speed through the water": Case(nmea("vhw.log", lines(vhw, turn, rudder), tag), True, wanted=TURN),
    "two rudders in one sentence": Case(
        nmea("rsa.log", lines(heading, turn, both_rudders), tag),
        True,
        {"rudder, starboard or single": Is("rudder", "deg")},
        TURN,
    ),
    "AIS, wind and sentences of one maker": Case(
        nmea(
            "many.log", lambda r, i: [heading(r, i), turn(r, i), rudder(r, i), mwv(r, i), own_make(r, i), *ais(i)], tag
        ),
        True,
        wanted=TURN,
    ),
    "talkers of an integrated bridge": Case(
        nmea(
            "in.log",
            lambda r, i: [sentence(f"IN{line[3:-3]}") for line in (heading(r, i), turn(r, i), rudder(r, i))],
            tag,
        ),
        True,
        wanted=TURN,
    ),
    "canboat in SI units": Case(
        canboat("si.json", ['{"version":"6.0.1","units":"si","showLookupValues":false}'], _message, 1.0),
        True,
        wanted=TURN,
    ),
    "canboat, old stamps and texts": Case(canboat("old.json", (), _old_message, D), True, wanted=TURN),
    "canboat, lookups with names": Case(
        canboat("nv.json", ['{"version":"6.0.1","units":"std","showLookupValues":true}'], _named_message, D),
        True,
        wanted=TURN,
    ),
    "YDVR": Case(n2k("ydvr.txt", _ydvr), False, wanted=TURN),
    "Actisense text": Case(n2k("plain.txt", _actisense), False, wanted=TURN),
    "ROS 1 bag": Case(
        ros1, True, {"vector.x": Is("rudder", "rad")}, (*TURN, "surge_m_s", "sway_m_s", "north_m", "east_m")
    ),
}
