"""Logs of the bank in formats of one make each, and of several files."""

import json
import struct
from pathlib import Path

import numpy as np
import openpyxl
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

from .case import Case, Is
from .texts import D, fixed, series, table
from .truth import KN, START, Run

ALL = ("rudder_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")


def sentence(body: str) -> str:
    check = 0
    for letter in body:
        check ^= ord(letter)
    return f"${body}*{check:02X}"


def place(run: Run, i: int) -> str:
    lat, lon = run.lat[i], run.lon[i]
    return f"{int(lat):02d}{60 * (lat % 1):010.7f},N,{int(lon):03d}{60 * (lon % 1):010.7f},E"


def clock(run: Run, i: int) -> str:
    text = str(np.datetime64(round(1e3 * (START + run.t[i])), "ms"))
    return text[11:].replace(":", "")


def rmc(run: Run, i: int, status="A") -> str:
    speed, course = run.sog[i] / KN, run.cog[i] * D
    return sentence(f"GPRMC,{clock(run, i)},{status},{place(run, i)},{speed:.3f},{course:.2f},140326,2.1,E")


def nmea(name: str, lines, stamp=lambda run, i: ""):
    def write(run: Run, folder: Path) -> list[Path]:
        out = [f"{stamp(run, i)}{line}" for i in range(run.t.size) for line in lines(run, i)]
        (folder / name).write_bytes("\r\n".join(out).encode())
        return [folder / name]

    return write


def heading(run, i, talker="HE", off=0.0):
    return sentence(f"{talker}HDT,{(run.psi[i] * D + off) % 360:.2f},T")


def rudder(run, i):
    return sentence(f"ERRSA,{run.delta[i] * D:.2f},A,,V")


def port_rudder(run, i):
    return sentence(f"ERRSA,,V,{run.delta[i] * D:.2f},A")


def turn(run, i):
    return sentence(f"TIROT,{60 * run.r[i] * D:.2f},A")


def bad(run, i):
    return [rudder(run, i)[:-2] + "00"] if i % 90 == 0 else []


def ais(i):
    return ["!" + sentence("AIVDM,1,1,,A,13aEOK?P00PD2wVMdLDRhgvL289?,0")[1:]] if i % 10 == 0 else []


def tag(run, i):
    return f"\\s:GP0001,c:{round(1e3 * (START + run.t[i]))}*00\\"


def bracket(run, i):
    return f"[{series(run)['iso'][i].replace('T', ' ')}] " if i == 0 else f"[{_iso(run, i)}] "


def _iso(run, i):
    return str(np.datetime64(round(1e3 * (START + run.t[i])), "ms")).replace("T", " ")


def vdr(run: Run, folder: Path) -> list[Path]:
    lines = ["Time,Talker,Sentence,Data"]
    for i in range(run.t.size):
        lines += [
            f"{_iso(run, i)},{line[1:3]},{line[3:6]},{line[7:-3]}"
            for line in (heading(run, i), turn(run, i), rudder(run, i))
        ]
    (folder / "vdr.csv").write_text("\n".join(lines))
    return [folder / "vdr.csv"]


def talkers(run: Run, folder: Path) -> list[Path]:
    """Rows of three instruments in one table."""
    s, lines = series(run), ["time,talker,heading [deg],rot [deg/min],rudder [deg],lat [deg],lon [deg]"]
    for i in range(run.t.size):
        lines.append(f"{s['iso'][i]},HE,{s['heading'][i]},,,,")
        lines.append(f"{s['iso'][i]},TI,,{s['rot_min'][i]},,,")
        lines.append(f"{s['iso'][i]},RC,,,{s['rudder'][i]},,")
        lines.append(f"{s['iso'][i]},GP,{(run.psi[i] * D + 0.3) % 360:.2f},,,{s['lat'][i]},{s['lon'][i]}")
    (folder / "talkers.csv").write_text("\n".join(lines))
    return [folder / "talkers.csv"]


def long_form(run: Run, folder: Path) -> list[Path]:
    s, lines = series(run), ["Timestamp;Signal;Value;Unit"]
    for i in range(run.t.size):
        for name, key, unit in (
            ("Heading", "heading", "deg"),
            ("Rate of turn", "rot_min", "deg/min"),
            ("Rudder", "rudder", "deg"),
        ):
            lines.append(f"{s['iso'][i]};{name};{s[key][i]};{unit}")
    (folder / "long.csv").write_text("\n".join(lines))
    return [folder / "long.csv"]


def ros_topics(frame: str, sign: int):
    """Two topics: IMU with a quaternion and nanoseconds, and the rudder."""

    def write(run: Run, folder: Path) -> list[Path]:
        yaw = run.psi if sign > 0 else np.pi / 2 - run.psi
        ns = [str(round(1e9 * START) + round(1e9 * t)) for t in run.t]
        none = fixed(0 * yaw, 1)
        imu = {
            "header.stamp.sec": [x[:-9] for x in ns],
            "header.stamp.nanosec": [str(int(x[-9:])) for x in ns],
            "header.frame_id": [frame] * run.t.size,
            "orientation.x": none,
            "orientation.y": none,
            "orientation.z": fixed(np.sin(yaw / 2), 8),
            "orientation.w": fixed(np.cos(yaw / 2), 8),
            "angular_velocity.x": none,
            "angular_velocity.z": fixed(sign * run.r, 7),
            "linear_acceleration.x": none,
        }
        table(folder / "imu-data.csv", imu)
        table(folder / "rudder.csv", {"stamp": ns, "rudder_angle_rad": fixed(run.delta, 6)})
        return [folder / "imu-data.csv", folder / "rudder.csv"]

    return write


def workbook(run: Run, folder: Path) -> list[Path]:
    """Merged headers over a row of names and one of units."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Sea trial 2026"])
    sheet.append([])
    sheet.append(["Time", "Position", None, "Gyro", None, "Steering gear", None])
    sheet.append([None, "Latitude", "Longitude", "Heading", "Rate of turn", "Rudder angle", "Rudder order"])
    sheet.append(["s", "deg", "deg", "deg", "deg/min", "deg", "deg"])
    for a, b in (("B3", "C3"), ("D3", "E3"), ("F3", "G3")):
        sheet.merge_cells(f"{a}:{b}")
    columns = (run.t, run.lat, run.lon, run.psi * D % 360, 60 * run.r * D, run.delta * D, run.order * D)
    for row in zip(*columns, strict=True):
        sheet.append(list(map(float, row)))
    book.save(folder / "trial.xlsx")
    return [folder / "trial.xlsx"]


def matlab(run: Run, folder: Path) -> list[Path]:
    content = {"time": run.t, "heading": run.psi * D % 360, "yaw_rate": run.r * D, "rudder_angle": run.delta * D}
    units = {"time": "s", "heading": "deg", "yaw_rate": "deg/s", "rudder_angle": "deg"}
    scipy.io.savemat(folder / "run.mat", {"log": content, "units": units}, oned_as="column")
    return [folder / "run.mat"]


def matlab_73(run: Run, folder: Path) -> list[Path]:
    import h5py

    with h5py.File(folder / "run73.mat", "w", userblock_size=512) as file:
        group = file.create_group("log")
        for name, values in (
            ("time", run.t),
            ("heading", run.psi * D % 360),
            ("yaw_rate", run.r),
            ("rudder_angle", run.delta * D),
        ):
            group[name] = values[None, :]
        units = file.create_group("units")
        for name, text in (("time", "s"), ("heading", "deg"), ("yaw_rate", "rad/s"), ("rudder_angle", "deg")):
            units[name] = np.array([[ord(letter)] for letter in text], dtype=np.uint16)
            units[name].attrs["MATLAB_class"] = np.bytes_("char")
    data = bytearray((folder / "run73.mat").read_bytes())
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64"
    data[:512] = head.ljust(124) + b"\x00\x02IM" + bytes(384)
    (folder / "run73.mat").write_bytes(bytes(data))
    return [folder / "run73.mat"]


def hdf5(run: Run, folder: Path) -> list[Path]:
    import h5py

    with h5py.File(folder / "log.h5", "w") as file:
        for name, values, unit in (
            ("t", run.t, "s"),
            ("heading", run.psi * D, "deg"),
            ("rate_of_turn", 60 * run.r * D, "deg/min"),
            ("rudder", run.delta * D, "deg"),
        ):
            file[name] = values
            file[name].attrs["units"] = unit
    return [folder / "log.h5"]


def parquet(run: Run, folder: Path) -> list[Path]:
    stamps = pa.array(
        np.array([np.datetime64(round(1e3 * (START + t)), "ms") for t in run.t]), pa.timestamp("ms", tz="UTC")
    )
    fields = [pa.field("timestamp", stamps.type)] + [
        pa.field(name, pa.float64(), metadata={"unit": unit})
        for name, unit in (("heading", "deg"), ("rot", "deg/min"), ("rudder", "deg"))
    ]
    columns = [stamps, *(pa.array(x) for x in (run.psi * D % 360, 60 * run.r * D, run.delta * D))]
    pq.write_table(pa.Table.from_arrays(columns, schema=pa.schema(fields)), folder / "log.parquet")
    return [folder / "log.parquet"]


def gpx(run: Run, folder: Path) -> list[Path]:
    points = "".join(
        f'<trkpt lat="{run.lat[i]:.8f}" lon="{run.lon[i]:.8f}"><time>{_iso(run, i).replace(" ", "T")}Z</time></trkpt>'
        for i in range(0, run.t.size, 2)
    )
    text = f'<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>{points}</trkseg></trk></gpx>'
    (folder / "track.gpx").write_text(text)
    s = series(run)
    table(
        folder / "pilot.csv",
        {"UTC": [f"{x}Z" for x in s["iso"]], "Heading [deg]": s["heading"], "Rudder [deg]": s["rudder"]},
    )
    return [folder / "track.gpx", folder / "pilot.csv"]


def expedition(run: Run, folder: Path) -> list[Path]:
    names = ("Utc", "BSP", "HDG", "COG", "SOG", "Lat", "Lon", "Rudder", "Heel")
    lines = ["!Boat," + ",".join(names), "!boat," + ",".join(map(str, range(len(names)))), "!v11.10.18"]
    days = START / 86400.0 + 25569.0 + run.t / 86400.0
    columns = (
        days,
        run.u / KN,
        run.psi * D % 360,
        run.cog * D,
        run.sog / KN,
        run.lat,
        run.lon,
        run.delta * D,
        -run.roll * D,
    )
    for row in zip(*columns, strict=True):
        lines.append("0," + ",".join(f"{i},{x:.10f}" for i, x in enumerate(row)))
    (folder / "log.csv").write_text("\n".join(lines))
    return [folder / "log.csv"]


def candump(run: Run, folder: Path) -> list[Path]:
    lines = []
    for i, t in enumerate(run.t):
        messages = (
            ("09F1120A", struct.pack("<BHhhB", 255, round(run.psi[i] % (2 * np.pi) / 1e-4), 0x7FFF, 0x7FFF, 0xFC)),
            ("09F1130A", struct.pack("<BihB", 255, round(run.r[i] / 3.125e-8), -1, 255)),
            ("09F10D14", struct.pack("<BBhhH", 0, 0xF8, 0x7FFF, round(run.delta[i] / 1e-4), 0xFFFF)),
            ("09F8011E", struct.pack("<ii", round(run.lat[i] * 1e7), round(run.lon[i] * 1e7))),
        )
        lines += [f"({START + t:.6f}) can0 {name}#{data.hex().upper()}" for name, data in messages]
    (folder / "candump.log").write_text("\n".join(lines))
    return [folder / "candump.log"]


def canboat(run: Run, folder: Path) -> list[Path]:
    lines = ['{"version":"5.0.0","units":"std","showLookupValues":false}']
    for i in range(run.t.size):
        for pgn, source, fields in (
            (127250, 10, {"Heading": round(float(run.psi[i] * D % 360), 2), "Reference": "True"}),
            (127251, 10, {"Rate": round(float(run.r[i] * D), 5)}),
            (127245, 20, {"Instance": 0, "Position": round(float(run.delta[i] * D), 2)}),
        ):
            lines.append(
                json.dumps(
                    {
                        "timestamp": _iso(run, i).replace(" ", "T") + "Z",
                        "prio": 2,
                        "src": source,
                        "dst": 255,
                        "pgn": pgn,
                        "fields": fields,
                    }
                )
            )
    (folder / "n2k.json").write_text("\n".join(lines))
    return [folder / "n2k.json"]


def ulog(run: Run, folder: Path) -> list[Path]:
    """A PX4 log by the description of its format: attitude, rates, a servo."""
    topics = (
        (
            "vehicle_attitude",
            "uint64_t timestamp;float[4] q;",
            lambda i: struct.pack("<4f", np.cos(run.psi[i] / 2), 0, 0, np.sin(run.psi[i] / 2)),
        ),
        ("vehicle_angular_velocity", "uint64_t timestamp;float[3] xyz;", lambda i: struct.pack("<3f", 0, 0, run.r[i])),
        (
            "actuator_servos",
            "uint64_t timestamp;float[2] control;",
            lambda i: struct.pack("<2f", run.delta[i] * D / 35.0, 0.1),
        ),
    )
    out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)

    def add(kind: bytes, body: bytes) -> bytes:
        return struct.pack("<H", len(body)) + kind + body

    out += add(b"B", bytes(40))
    for name, fields, _ in topics:
        out += add(b"F", f"{name}:{fields}".encode())
    for number, (name, _, _) in enumerate(topics):
        out += add(b"A", struct.pack("<BH", 0, number) + name.encode())
    for i, t in enumerate(run.t):
        for number, (_, _, body) in enumerate(topics):
            out += add(b"D", struct.pack("<HQ", number, round(1e6 * (t + 5.0))) + body(i))
    (folder / "flight.ulg").write_bytes(out)
    return [folder / "flight.ulg"]


def ardupilot(run: Run, folder: Path) -> list[Path]:
    """A dataflash log by the description of its format: attitude, gyro, servo outputs."""
    kinds = (
        (130, "ATT", "Qff", "TimeUS,Roll,Yaw"),
        (131, "IMU", "Qf", "TimeUS,GyrZ"),
        (132, "RCOU", "QHH", "TimeUS,C1,C3"),
    )
    out = b""

    def fmt(number, length, name, kind, labels):
        return b"\xa3\x95\x80" + struct.pack(
            "<BB4s16s64s", number, length, name.encode(), kind.encode(), labels.encode()
        )

    out += fmt(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    for number, name, kind, labels in kinds:
        out += fmt(number, 3 + struct.calcsize("<" + kind), name, kind, labels)
    for i, t in enumerate(run.t):
        us = round(1e6 * (t + 3.0))
        out += b"\xa3\x95\x82" + struct.pack("<Qff", us, run.roll[i] * D, run.psi[i] * D % 360)
        out += b"\xa3\x95\x83" + struct.pack("<Qf", us, run.r[i])
        out += b"\xa3\x95\x84" + struct.pack("<QHH", us, round(1500 + run.delta[i] * D / 35.0 * 400), 1600 + i % 2)
    (folder / "log.bin").write_bytes(out)
    return [folder / "log.bin"]


def bag(run: Run, folder: Path) -> list[Path]:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    header, stamp = kinds["std_msgs/msg/Header"], kinds["builtin_interfaces/msg/Time"]
    vector, turned, number = (
        kinds[f"{name}"]
        for name in ("geometry_msgs/msg/Vector3", "geometry_msgs/msg/Quaternion", "std_msgs/msg/Float64")
    )
    with Writer(folder / "bag", version=9) as writer:
        imu = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
        rud = writer.add_connection("/rudder_angle_rad", "std_msgs/msg/Float64", typestore=store)
        none = np.zeros(9)
        for i, t in enumerate(run.t):
            ns = round(1e9 * START) + round(1e9 * t)
            head = header(stamp(ns // 10**9, ns % 10**9), "imu_ned")
            spin = turned(0.0, 0.0, float(np.sin(run.psi[i] / 2)), float(np.cos(run.psi[i] / 2)))
            message = kinds["sensor_msgs/msg/Imu"](
                head, spin, none, vector(0.0, 0.0, float(run.r[i])), none, vector(0.0, 0.0, 0.0), none
            )
            writer.write(imu, ns, store.serialize_cdr(message, "sensor_msgs/msg/Imu"))
            writer.write(rud, ns, store.serialize_cdr(number(float(run.delta[i])), "std_msgs/msg/Float64"))
    return [folder / "bag"]


OTHER_CASES: dict[str, Case] = {
    "NMEA 0183": Case(
        nmea("a.log", lambda r, i: [*([rmc(r, i)] if i % 2 == 0 else []), heading(r, i), turn(r, i), rudder(r, i)]),
        False,
        wanted=ALL,
        loose=0.06,
    ),
    "NMEA with TAG blocks": Case(
        nmea("tag.log", lambda r, i: [heading(r, i), turn(r, i), rudder(r, i)], tag), False, wanted=TURN
    ),
    "NMEA, stamps in brackets, AIS, bad sentences": Case(
        nmea("mixed.log", lambda r, i: [heading(r, i), turn(r, i), rudder(r, i), *bad(r, i), *ais(i)], bracket),
        True,
        wanted=TURN,
    ),
    "two gyros that agree": Case(
        nmea("two.log", lambda r, i: [heading(r, i), heading(r, i, "GP", 0.2), turn(r, i), rudder(r, i)], tag),
        True,
        wanted=TURN,
    ),
    "two gyros that do not": Case(
        nmea("two2.log", lambda r, i: [heading(r, i), heading(r, i, "GP", 7.0), turn(r, i), rudder(r, i)], tag),
        True,
        {"true heading": Is("not used")},
        TURN,
    ),
    "void positions, port rudder": Case(
        nmea(
            "void.log",
            lambda r, i: [
                *([rmc(r, i, "V" if 20 < i < 60 else "A")] if i % 2 == 0 else []),
                heading(r, i),
                turn(r, i),
                port_rudder(r, i),
            ],
        ),
        True,
        wanted=TURN,
        loose=0.06,
    ),
    "VDR with a column of talkers": Case(vdr, True, wanted=TURN),
    "rows of several talkers": Case(
        talkers, True, wanted=("rudder_rad", "heading_rad", "yaw_rate_rad_s", "north_m", "east_m")
    ),
    "long form": Case(long_form, True, wanted=TURN),
    "ROS topics, NED": Case(ros_topics("imu_ned", 1), True, wanted=TURN),
    "ROS topics, ENU": Case(ros_topics("imu_enu", -1), True, wanted=TURN),
    "ROS topics, frame unsaid": Case(
        ros_topics("imu_link", -1), True, {"yaw of orientation": Is("heading", "rad", -1, 1.0, np.pi / 2)}, TURN
    ),
    "workbook with merged headers": Case(
        workbook,
        True,
        wanted=("rudder_rad", "rudder_command_rad", "heading_rad", "yaw_rate_rad_s", "north_m", "east_m"),
    ),
    "MAT": Case(matlab, False, wanted=TURN),
    "MAT 7.3": Case(matlab_73, False, wanted=TURN),
    "HDF5": Case(hdf5, False, wanted=TURN),
    "Parquet": Case(parquet, False, wanted=TURN),
    "GPX and a pilot's log": Case(gpx, False, wanted=("rudder_rad", "heading_rad", "north_m", "east_m")),
    "Expedition": Case(
        expedition,
        True,
        {"Heel": Is("roll", "deg", -1)},
        ("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m", "roll_rad"),
    ),
    "NMEA 2000, candump": Case(
        candump, False, wanted=("rudder_rad", "heading_rad", "yaw_rate_rad_s", "north_m", "east_m")
    ),
    "NMEA 2000, canboat": Case(canboat, False, wanted=TURN),
    "PX4": Case(ulog, True, {"servo 0": Is("rudder", "deg", 1, 35.0)}, TURN),
    "ArduPilot": Case(ardupilot, True, {"output 1": Is("rudder", "deg", 1, 35.0 / 400.0)}, TURN),
    "ROS 2 bag": Case(bag, False, {"data": Is("rudder", "rad")}, TURN),
}
