"""Logs of the bank in further formats of instruments and programs, each written from the public description of it."""

import json
import zlib

import numpy as np
import openpyxl
import scipy.io

from .case import Case, Is
from .other_cases import heading, rudder, sentence, turn
from .texts import D, fixed, series, table
from .truth import KN, START

TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
BOTH = ("rudder_rad", "heading_rad")
PLACE = (*BOTH, "north_m", "east_m")
GROUND = (*TURN, "surge_m_s", "sway_m_s")
WEEK, OF_WEEK = divmod(START - 315964800.0 + 18.0, 604800.0)
"""GPS week and its second of the first sample: 18 leap seconds."""


def log(name, lines, wanted=TURN, questions=0, knows=None, end="\n", encoding="utf-8", **options):
    """A case of a text file: `lines` gives its lines from the run."""

    def write(run, folder):
        (folder / name).write_bytes(end.join(lines(run)).encode(encoding))
        return [folder / name]

    return Case(write, False, knows or {}, wanted, questions=questions, **options)


def stamp(run, i, zone="Z"):
    return str(np.datetime64(round(1e3 * (START + run.t[i])), "ms")) + zone


def rows(of):
    """Lines of every sample: `of` gives those of one."""
    return lambda run: [line for i in range(run.t.size) for line in of(run, i)]


# ------------------------------------------------------------------------------------------------ JSON


def _topics(run, i):
    values = (
        ("ship/nav/heading", run.psi[i] * D % 360, "deg"),
        ("ship/nav/rate_of_turn", 60 * run.r[i] * D, "deg/min"),
        ("ship/steering/rudder_angle", run.delta[i] * D, "deg"),
        ("ship/nav/sog", run.sog[i] / KN, "kn"),
        ("ship/nav/cog", run.cog[i] * D, "deg"),
    )
    return [json.dumps({"ts": stamp(run, i), "topic": t, "value": round(v, 4), "unit": u}) for t, v, u in values]


def _nested(run, i):
    own = {
        "attitude": {"heading_deg": run.psi[i] * D % 360, "yaw_rate_deg_s": run.r[i] * D},
        "steering": {"rudder_angle_deg": run.delta[i] * D},
    }
    return [json.dumps({"time": stamp(run, i), "data": own})]


def _with_units(run, i):
    values = {
        "heading": {"value": run.psi[i] * D % 360, "unit": "deg"},
        "rot": {"value": 60 * run.r[i] * D, "unit": "deg/min"},
        "rudder": {"value": run.delta[i], "unit": "rad"},
    }
    return [f"{stamp(run, i)} {json.dumps(values)}"]


def _payloads(run, i):
    own = (
        ("bridge/gyro", {"heading_deg": run.psi[i] * D % 360, "rot_deg_min": 60 * run.r[i] * D}),
        ("bridge/rudder", {"rudder_angle_deg": run.delta[i] * D}),
    )
    return [json.dumps({"timestamp": START + run.t[i], "topic": t, "payload": json.dumps(p)}) for t, p in own]


def _kinds(run, i):
    return [
        json.dumps({"t": START + run.t[i], "heading_deg": run.psi[i] * D % 360, "rot_deg_s": run.r[i] * D}),
        json.dumps({"t": START + run.t[i] + 0.1, "rudder_deg": run.delta[i] * D}),
    ]


def _document(run):
    rows = [
        {
            "time": stamp(run, i),
            "heading_deg": run.psi[i] * D % 360,
            "rot_deg_s": run.r[i] * D,
            "rudder_deg": run.delta[i] * D,
        }
        for i in range(run.t.size)
    ]
    return [json.dumps({"vessel": "X", "samples": rows}, indent=1)]


def _columns(run):
    s = {"time_s": run.t, "heading_deg": run.psi * D, "yaw_rate_deg_s": run.r * D, "rudder_deg": run.delta * D}
    return [json.dumps({"meta": {"name": "zigzag"}, "data": {name: list(values) for name, values in s.items()}})]


def _delta(run, i):
    values = [
        {"path": "navigation.headingTrue", "value": run.psi[i] % (2 * np.pi)},
        {"path": "navigation.rateOfTurn", "value": run.r[i]},
        {"path": "navigation.position", "value": {"latitude": run.lat[i], "longitude": run.lon[i]}},
    ]
    own = [{"path": "steering.rudderAngle", "value": run.delta[i]}]
    source = {"label": "can0", "type": "NMEA2000", "pgn": 127245, "src": "204"}
    updates = [
        {"$source": "n2k.1", "timestamp": stamp(run, i), "values": values},
        {"source": source, "timestamp": stamp(run, i), "values": own},
    ]
    return [json.dumps({"context": "vessels.self", "updates": updates})]


def _multiplexed(run, i):
    return [f"{round(1e3 * (START + run.t[i]))};I;{line}" for line in _delta(run, i)]


def _batch(run):
    paths = {
        "steering.rudderAngle": run.delta,
        "navigation.headingTrue": run.psi % (2 * np.pi),
        "navigation.rateOfTurn": run.r,
        "navigation.speedOverGround": run.sog,
        "navigation.courseOverGroundTrue": run.cog,
    }
    lines = [",".join(["path", *(str(round(1e3 * (START + t))) for t in run.t)])]
    return lines + [",".join([name, *fixed(values, 6)]) for name, values in paths.items()]


def _senml(run):
    out = [{"bn": "ship/", "bt": START, "n": "x", "v": 0.0}]
    for i, t in enumerate(run.t):
        out += [
            {"n": "heading", "u": "deg", "v": run.psi[i] * D % 360, "t": t},
            {"n": "rate_of_turn", "u": "deg/min", "v": 60 * run.r[i] * D, "t": t},
            {"n": "rudder", "u": "deg", "v": run.delta[i] * D, "t": t},
        ]
    return [json.dumps(out)]


def _lists(run):
    """A document with a list for every signal."""
    signals = {"heading_deg": run.psi * D % 360, "rateOfTurn_deg_min": 60 * run.r * D, "rudder_deg": run.delta * D}
    times = [round(1e3 * (START + t)) for t in run.t]
    return [
        json.dumps(
            {k: [{"ts": t, "value": f"{x:.4f}"} for t, x in zip(times, v, strict=True)] for k, v in signals.items()}
        )
    ]


def _ros(run, i):
    own = {
        "header": {
            "stamp": {"sec": int(START + run.t[i]), "nanosec": round(run.t[i] % 1 * 1e9)},
            "frame_id": "imu_ned",
        },
        "orientation": [0.0, 0.0, np.sin(run.psi[i] / 2), np.cos(run.psi[i] / 2)],
        "angular_velocity": {"x": 0.0, "y": 0.0, "z": run.r[i]},
        "rudder_angle_rad": run.delta[i],
    }
    return [json.dumps(own)]


# ------------------------------------------------------------------------------------------------ data bases, robots


def _line_protocol(run, i):
    time = f"{round(1e3 * (START + run.t[i]))}000000"
    return [
        f"gyro,host=a heading_deg={run.psi[i] * D % 360:.3f},rot_deg_min={60 * run.r[i] * D:.3f} {time}",
        f"rudder,host=b angle_deg={run.delta[i] * D:.3f},ok=true {time}",
    ]


def _subscriber(run, i):
    """Time, topic and value without a header, as an MQTT subscriber prints them."""
    values = (
        ("ship/heading_deg", run.psi[i] * D % 360),
        ("ship/rudder_angle_deg", run.delta[i] * D),
        ("ship/rate_of_turn_deg_min", 60 * run.r[i] * D),
    )
    return [f"{stamp(run, i)} {topic} {value:.3f}" for topic, value in values]


def _sparse(run):
    """Sensors with times of their own in one table."""
    out = ["time [s],heading [deg],rot [deg/min],rudder [deg]"]
    for i, t in enumerate(run.t):
        out += [
            f"{t:.2f},{run.psi[i] * D % 360:.3f},{60 * run.r[i] * D:.3f},",
            f"{t + 0.1:.2f},,,{run.delta[i] * D:.3f}",
        ]
    return out


def _mavlink_json(run, i):
    attitude = {"roll": run.roll[i], "yaw": (run.psi[i] + np.pi) % (2 * np.pi) - np.pi, "yawspeed": run.r[i]}
    place = {
        "lat": round(1e7 * run.lat[i]),
        "lon": round(1e7 * run.lon[i]),
        "vx": round(100 * run.north_speed[i]),
        "vy": round(100 * run.east_speed[i]),
    }
    own = (("ATTITUDE", attitude), ("GLOBAL_POSITION_INT", place), ("STEERING", {"rudder_deg": run.delta[i] * D}))
    return [json.dumps({"meta": {"type": kind, "timestamp": START + run.t[i]}, "data": data}) for kind, data in own]


def _mavlink_text(run, i):
    yaw, before = (run.psi[i] + np.pi) % (2 * np.pi) - np.pi, stamp(run, i, "").replace("T", " ")
    return [
        f"{before}: ATTITUDE {{roll : {run.roll[i]:.6f}, yaw : {yaw:.6f}, yawspeed : {run.r[i]:.6f}}}",
        f"{before}: STEERING {{rudder_angle_deg : {run.delta[i] * D:.3f}, mode : AUTO}}",
    ]


def _influx(run):
    head = [
        "#group,false,false,true,true,false,false,true,true",
        "#datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,dateTime:RFC3339,double,string,string",
        "#default,_result,,,,,,,",
    ]
    out = []
    fields = (("heading_deg", run.psi * D % 360), ("rot_deg_min", 60 * run.r * D), ("rudder_deg", run.delta * D))
    for k, (name, values) in enumerate(fields):
        out += [*head, ",result,table,_start,_stop,_time,_value,_field,_measurement"]
        ends = f"{stamp(run, 0)},{stamp(run, -1)}"
        out += [f",,{k},{ends},{stamp(run, i)},{v:.4f},{name},bridge" for i, v in enumerate(values)]
        out.append("")
    return out


def _pivoted(run):
    out = [
        "#group,false,false,false,false,false,false",
        "#datatype,string,long,dateTime:RFC3339,double,double,double",
        "#default,,,,,,",
        ",result,table,_time,heading_deg,rot_deg_min,rudder_deg",
    ]
    columns = zip(run.psi * D % 360, 60 * run.r * D, run.delta * D, strict=True)
    return out + [f",,0,{stamp(run, i)},{a:.3f},{b:.3f},{c:.3f}" for i, (a, b, c) in enumerate(columns)]


def _alog(run):
    head = ["%" * 60, "%% LOG FILE:       ./run.alog", f"%% LOGSTART           {START}", "%" * 60]
    out = []
    for i, t in enumerate(run.t):
        values = {
            "NAV_X": run.east,
            "NAV_Y": run.north,
            "NAV_HEADING": run.psi * D % 360,
            "NAV_SPEED": run.sog,
            "RUDDER_ANGLE": run.delta * D,
        }
        out += [f"{t:<15.5f} {name:<20} uSimMarine      {v[i]:.5f}" for name, v in values.items()]
        out += [f"{t:<15.5f} MODE                 pHelmIvP        ACTIVE:ZIGZAG"]
    return head + out


def _dataflash(run):
    out = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 130, 27, ATT, Qcccc, TimeUS,DesRoll,Roll,DesYaw,Yaw",
        "FMT, 131, 45, IMU, QBfff, TimeUS,I,GyrX,GyrY,GyrZ",
        "FMT, 133, 19, RCOU, QHH, TimeUS,C1,C3",
        "PARM, 1200, SERVO1_FUNCTION, 26, 0",
        "MSG, 1300, ArduRover V4.5.1",
    ]
    for i, t in enumerate(run.t):
        us = round(1e6 * (3.0 + t))
        out += [
            f"ATT, {us}, 0.00, {run.roll[i] * D:.2f}, 0.00, {run.psi[i] * D % 360:.2f}",
            f"IMU, {us}, 0, 0.001, 0.002, {run.r[i]:.6f}",
            f"RCOU, {us}, {round(1500 + run.delta[i] * D / 35 * 400)}, 1620",
        ]
    return out


def _quaternions(run):
    """The CSV of a topic of PX4, with numbers in brackets."""
    yaw, roll = run.psi / 2, run.roll / 2
    parts = np.stack(
        [np.cos(roll) * np.cos(yaw), np.sin(roll) * np.cos(yaw), np.sin(roll) * np.sin(yaw), np.cos(roll) * np.sin(yaw)]
    )
    out = ["timestamp,q[0],q[1],q[2],q[3],rudder [rad]"]
    for i, t in enumerate(run.t):
        out.append(",".join([f"{round(1e6 * (3.0 + t))}", *fixed(parts[:, i], 8), f"{run.delta[i]:.5f}"]))
    return out


def _mavlink(run):
    out = [
        "timestamp,ATTITUDE.roll,ATTITUDE.yaw,ATTITUDE.yawspeed,GLOBAL_POSITION_INT.lat,GLOBAL_POSITION_INT.lon,"
        "GLOBAL_POSITION_INT.vx,GLOBAL_POSITION_INT.vy,GLOBAL_POSITION_INT.hdg,NAMED.rudder_deg"
    ]
    for i, t in enumerate(run.t):
        yaw = (run.psi[i] + np.pi) % (2 * np.pi) - np.pi
        speed = f"{round(100 * run.north_speed[i])},{round(100 * run.east_speed[i])}"
        place = f"{round(1e7 * run.lat[i])},{round(1e7 * run.lon[i])},{speed},{round(100 * (run.psi[i] * D % 360))}"
        out += [
            f"{START + t:.3f},{run.roll[i]:.6f},{yaw:.6f},{run.r[i]:.6f},,,,,,",
            f"{START + t + 0.02:.3f},,,,{place},",
            f"{START + t + 0.05:.3f},,,,,,,,,{run.delta[i] * D:.3f}",
        ]
    return out


def _ublox(run):
    out = [
        "iTOW,year,month,day,hour,min,sec,nano,fixType,lon,lat,hMSL,velN,velE,gSpeed,headMot,rudder [deg],heading [deg]"
    ]
    for i, t in enumerate(run.t):
        moment = np.datetime64(round(1e3 * (START + t)), "ms").item()
        date = f"{moment:%Y,}{moment.month},{moment.day},{moment.hour},{moment.minute},{moment.second}"
        place = f"{round(1e7 * run.lon[i])},{round(1e7 * run.lat[i])},31200"
        speed = f"{round(1e3 * run.north_speed[i])},{round(1e3 * run.east_speed[i])},{round(1e3 * run.sog[i])}"
        own = f"{round(1e5 * run.cog[i] * D)},{run.delta[i] * D:.2f},{run.psi[i] * D % 360:.2f}"
        week = round(1e3 * (OF_WEEK + t))
        out.append(f"{week},{date},{1000 * moment.microsecond},3,{place},{speed},{own}")
    return out


# ------------------------------------------------------------------------------------------------ sentences


def named(run, i):
    """Instrument, stamp and channel before the sentences."""
    before = stamp(run, i, "").replace("-", "/").replace("T", " ")
    roll = run.roll[i] * D
    attitude = sentence(f"PHTRO,0.10,M,{abs(roll):.3f},{'T' if roll > 0 else 'B'}")
    speed = sentence(f"PHSPD,{run.u[i]:.3f},{run.v[i]:.3f},0.001")
    return [
        *(f"MRU {before} PHINS {line}" for line in (heading(run, i), attitude, speed)),
        f"RUD {before} AUX {rudder(run, i)}",
    ]


def _fields(run):
    """Sentences as a quoted cell of a CSV file, with the date and the time in cells of their own."""
    out = ["date,time,port,sentence"]
    for i in range(run.t.size):
        date, time = stamp(run, i, "").split("T")
        out += [
            f'{date},{time},COM{k},"{line}"' for k, line in enumerate((heading(run, i), turn(run, i), rudder(run, i)))
        ]
    return out


def behind(run, i):
    """The stamp behind the checksum, as a day of the year."""
    moment = np.datetime64(round(1e3 * (START + run.t[i])), "ms").item()
    return [
        f"{line},{moment:%Y:%j:%H:%M:%S}.{moment.microsecond // 1000:03d}"
        for line in (heading(run, i), turn(run, i), rudder(run, i))
    ]


def _strays(run):
    """Two single sentences of other talkers, with sums that are right, among those of the gyro."""
    lines = [
        f"{stamp(run, i)} {line}" for i in range(run.t.size) for line in (heading(run, i), turn(run, i), rudder(run, i))
    ]
    strays = [f"{stamp(run, 50)} {heading(run, 50, 'GE')}", f"{stamp(run, 70)} {heading(run, 70, 'HA', 40.0)}"]
    return [*lines[:150], strays[0], *lines[150:210], strays[1], *lines[210:]]


def novatel(text):
    sum_ = zlib.crc32(text.encode(), 0xFFFFFFFF) ^ 0xFFFFFFFF
    return f"{'%' if text.startswith('INSPVASA') else '#'}{text}*{sum_:08x}"


def span(run, i):
    second = OF_WEEK + run.t[i]
    motion = (
        f"{run.north_speed[i]:.4f},{run.east_speed[i]:.4f},0.001,{run.roll[i] * D:.6f},0.1,{run.psi[i] * D % 360:.6f}"
    )
    ins = f"{WEEK:.0f},{second:.6f},{run.lat[i]:.10f},{run.lon[i]:.10f},31.2,{motion},INS_SOLUTION_GOOD"
    return [
        novatel(f"INSPVASA,{WEEK:.0f},{second:.3f};{ins}"),
        rudder(run, i),
        *([novatel(f"INSPVASA,{WEEK:.0f},{second:.3f};{ins}")[:-1] + "g"] if i % 97 == 5 else []),
    ]


def best(run, i):
    head = f"COM1,0,60.0,FINESTEERING,{WEEK:.0f},{OF_WEEK + run.t[i]:.3f},00000000,0000,16248"
    deviations = '0.9,1.2,1.8,"",0.0,0.0,21,21,21,21,00,02,11,01'
    return [
        novatel(
            f"BESTPOSA,{head};SOL_COMPUTED,SINGLE,{run.lat[i]:.10f},{run.lon[i]:.10f},31.2,40.1,WGS84,{deviations}"
        ),
        novatel(
            f"BESTVELA,{head};SOL_COMPUTED,DOPPLER_VELOCITY,0.0,0.0,{run.sog[i]:.4f},{run.cog[i] * D:.4f},0.001,0.0"
        ),
        novatel(f'HEADINGA,{head};SOL_COMPUTED,NARROW_INT,2.0,{run.psi[i] * D % 360:.4f},0.1,0.0,0.3,0.4,"1",9,9,9,9'),
        rudder(run, i),
    ]


def orders(run, i):
    """A rudder order beside the rudder, by ROR and by an autopilot's HTD."""
    order = run.order[i] * D
    side = "L" if order < 0 else "R"
    return [
        f"{stamp(run, i)} {line}"
        for line in (
            heading(run, i),
            turn(run, i),
            rudder(run, i),
            sentence(f"SGROR,{order:.1f},A,,V,B"),
            sentence(f"AGHTD,V,{abs(order):.1f},{side},H,R,35.0,,,,,,,T,A,A,,{run.psi[i] * D % 360:.1f}"),
        )
    ]


# ------------------------------------------------------------------------------------------------ survey programs


def _hypack(run):
    moment = np.datetime64(round(1e3 * START), "ms").item()
    out = [
        "FTP NEW 2",
        "VER 23.0.0.0",
        'INF "" "Ship" "Proj" "Area" 0.0 0.0 1500.0',
        'DEV 0 100 "GPS NMEA-0183"',
        'DEV 1 16 "Gyro"',
        'DEV 2 512 "MRU"',
        'DEV 3 32 "Rudder angle deg stbd+"',
        f"TND {moment:%H:%M:%S} {moment:%m/%d/%Y} 0",
        "EOH",
    ]
    for i, t in enumerate(run.t):
        at = START % 86400 + t
        out += [
            f"POS 0 {at:.3f} {585218.09 + run.east[i]:.2f} {6031284.79 + run.north[i]:.2f}",
            f"GYR 1 {at + 0.01:.3f} {run.psi[i] * D % 360:.2f}",
            f"HCP 2 {at + 0.02:.3f} 0.00 {run.roll[i] * D:.2f} 0.10",
            f"EC1 3 {at + 0.03:.3f} {run.delta[i] * D:.2f}",
        ]
    return out


def _sbet(run, folder):
    rows = np.zeros((run.t.size, 17))
    wander = np.full(run.t.size, 0.3)
    x = run.north_speed * np.cos(wander) + run.east_speed * np.sin(wander)
    y = run.east_speed * np.cos(wander) - run.north_speed * np.sin(wander)
    values = {
        0: OF_WEEK + run.t,
        1: np.radians(run.lat),
        2: np.radians(run.lon),
        4: x,
        5: y,
        7: run.roll,
        9: run.psi + wander,
        10: wander,
        16: run.r,
    }
    for place, own in values.items():
        rows[:, place] = own
    (folder / "sbet.out").write_bytes(rows.astype("<f8").tobytes())
    s = series(run)
    pilot = {
        "GPS seconds of week [s]": fixed(OF_WEEK + run.t),
        "Rudder [deg]": s["rudder"],
        "Heading [deg]": s["heading"],
    }
    return [folder / "sbet.out", *table(folder / "pilot.csv", pilot)]


def _pospac(run):
    names = ("TIME", "EASTING", "NORTHING", "ROLL", "HEADING", "EAST_V", "NORTH_V", "RUDDER")
    units = "(time in Sec, position in Meters, orientation angles and SD in Degrees, velocity in Meter/Sec)"
    columns = (
        OF_WEEK + run.t,
        585218.0 + run.east,
        6031284.0 + run.north,
        run.roll * D,
        run.psi * D % 360,
        run.east_speed,
        run.north_speed,
        run.delta * D,
    )
    body = [" ".join(f"{x:14.5f}" for x in row) for row in zip(*columns, strict=True)]
    return [
        " POS Export Utility",
        " Copyright (C)",
        " ",
        f" {units}",
        "",
        " ".join(f"{n:>14}" for n in names),
        "",
        *body,
    ]


def _r2r(run):
    head = [
        "// Cruise: XX2603   Product: bestres",
        "//  Datetime [UTC], Longitude [deg], Latitude [deg], Instantaneous "
        "Speed-over-ground [m/s], Heading [deg], Rudder [deg]",
    ]
    s = series(run)
    columns = zip(s["lon"], s["lat"], fixed(run.sog), s["heading"], s["rudder"], strict=True)
    return head + ["\t".join([stamp(run, i), *row]) for i, row in enumerate(columns)]


def _tcx(run, folder):
    points = "".join(
        f"<Trackpoint><Time>{stamp(run, i)}</Time><Position><LatitudeDegrees>{run.lat[i]:.8f}</LatitudeDegrees>"
        f"<LongitudeDegrees>{run.lon[i]:.8f}</LongitudeDegrees></Position></Trackpoint>"
        for i in range(run.t.size)
    )
    (folder / "track.tcx").write_text(
        '<?xml version="1.0"?><TrainingCenterDatabase xmlns="http://www.garmin.com/xmlschemas/TrainingCenterDatabase/v2">'
        f"<Activities><Activity><Lap><Track>{points}</Track></Lap></Activity></Activities></TrainingCenterDatabase>"
    )
    s = series(run)
    pilot = {
        "UTC": [stamp(run, i) for i in range(run.t.size)],
        "Heading [deg]": s["heading"],
        "Rudder [deg]": s["rudder"],
    }
    return [folder / "track.tcx", *table(folder / "pilot.csv", pilot)]


# ------------------------------------------------------------------------------------------------ measuring programs


def _lvm(columns="One", comma=False, labels=True):
    """A LabVIEW file with a time column, one for every channel, or none."""

    def lines(run):
        n, dt = run.t.size, run.t[1]
        series_ = [run.psi * D, run.r * D, run.delta * D]
        names = ["Heading", "Yaw rate", "Rudder"] if labels else ["Heading (deg)", "Yaw rate (deg/s)", "Rudder (deg)"]
        head = [
            "LabVIEW Measurement\t",
            "Writer_Version\t2",
            "Separator\tTab",
            f"Decimal_Separator\t{',' if comma else '.'}",
            "Multi_Headings\tNo",
            f"X_Columns\t{columns}",
            "Time_Pref\tRelative",
            "***End_of_Header***\t",
            "\t",
            "Channels\t3\t\t\t",
            f"Samples\t{n}\t{n}\t{n}\t",
            *(["Y_Unit_Label\tdeg\tdeg/s\tdeg\t"] if labels else []),
            "X0\t0.0\t0.0\t0.0\t",
            f"Delta_X\t{dt}\t{dt}\t{dt}\t",
            "***End_of_Header***\t\t\t\t",
        ]
        titles = {
            "One": ["X_Value", *names],
            "No": ["X_Value", *names],
            "Multi": [x for name in names for x in ("X_Value", name)],
        }[columns]
        out = []
        for i, t in enumerate(run.t):
            own = [f"{v[i]:.6f}" for v in series_]
            cells = {"One": [f"{t:.6f}", *own], "No": ["", *own], "Multi": [x for v in own for x in (f"{t:.6f}", v)]}[
                columns
            ]
            out.append("\t".join(cells).replace(".", "," if comma else "."))
        return [*head, "\t".join([*titles, "Comment"]), *out]

    return lines


def _degrees(run):
    out = ["TIME;HDG;COG;SOG;ROT;RUDDER"]
    for i in range(run.t.size):
        moment = np.datetime64(round(1e3 * (START + run.t[i])), "ms").item()
        course = f"{run.psi[i] * D % 360:05.1f}°T;{run.cog[i] * D:05.1f}°T;{run.sog[i] / KN:.2f}kn"
        out.append(f"{moment:%d.%m.%Y %H:%M:%S.%f};{course};{60 * run.r[i] * D:.1f}°/min;{run.delta[i] * D:.1f}°")
    return out


def _fortran(run):
    out = [
        "   TIME            HEADING          YAW RATE        RUDDER ANGLE",
        "    (s)             (deg)           (deg/s)           (deg)",
    ]
    columns = zip(run.t, run.psi * D % 360, run.r * D, run.delta * D, strict=True)
    return out + ["".join(f"{x: 17.8E}" for x in row).replace("E", "D") for row in columns]


def _touching(run):
    """Numbers without a space between them where one is negative, under names with spaces."""
    out = [f"{'Time s':>10}{'Heading deg':>12}{'ROT deg/s':>10}{'Rudder deg':>12}"]
    columns = zip(run.t, run.psi * D % 360, run.r * D, run.delta * D, strict=True)
    return out + [f"{a:10.2f}{b:12.3f}{c:10.6f}{d:12.8f}" for a, b, c, d in columns]


def _minutes(run):
    out = ["Time [s];Latitude;Longitude;Heading [deg];Rudder [deg]"]
    for i, t in enumerate(run.t):
        lat, lon = run.lat[i], run.lon[i]
        place = f"{int(lat):02d}-{60 * (lat % 1):08.5f} N;{int(lon):03d}-{60 * (lon % 1):08.5f} E"
        out.append(f"{t};{place};{run.psi[i] * D % 360:.2f};{run.delta[i] * D:.2f}")
    return out


def _two_tables(run):
    s = series(run)
    first = [",".join(row) for row in zip(s["t"], s["heading"], s["rudder"], strict=True)]
    second = [",".join(row) for row in zip(s["t"], s["north"], s["east"], s["rot_s"], strict=True)]
    return [
        "Steering",
        "Time [s],Heading [deg],Rudder [deg]",
        *first,
        "",
        "Navigation",
        "Time [s],North [m],East [m],ROT [deg/s]",
        *second,
    ]


def _near_empty(run, folder):
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (
        ["Trial 3"],
        ["Time", "Heading", "ROT", "Rudder", "Remark"],
        ["s", "deg", "deg/s", "deg"],
        [None, None, None, None, "start of run"],
        ["x"],
    ):
        sheet.append(row)
    for row in zip(run.t, run.psi * D % 360, run.r * D, run.delta * D, strict=True):
        sheet.append([float(x) for x in row])
    book.save(folder / "trial.xlsx")
    return [folder / "trial.xlsx"]


def _stacked(run, folder):
    """Two tables below each other in one sheet."""
    book = openpyxl.Workbook()
    sheet = book.active
    for names, columns in (
        (["Time [s]", "Heading [deg]", "Rudder [deg]"], (run.t, run.psi * D % 360, run.delta * D)),
        (["t [s]", "North [m]", "East [m]", "ROT [deg/s]"], (run.t, run.north, run.east, run.r * D)),
    ):
        sheet.append(["Table"])
        sheet.append(names)
        for row in zip(*columns, strict=True):
            sheet.append([float(x) for x in row])
        sheet.append([])
    book.save(folder / "stacked.xlsx")
    return [folder / "stacked.xlsx"]


def _simulink(run, folder):
    signals = np.zeros((2,), dtype=[("values", object), ("dimensions", object), ("label", object)])
    signals[0] = (run.psi * D, 1.0, "heading [deg]")
    signals[1] = (np.column_stack([run.r * D, run.delta * D]), 2.0, "yaw rate [deg/s], rudder [deg]")
    structure = {"time": run.t, "signals": signals, "blockName": "model/Scope"}
    scipy.io.savemat(folder / "scope.mat", {"ScopeData": structure})
    return [folder / "scope.mat"]


# ------------------------------------------------------------------------------------------------ programs


def _toa5(run):
    """A logger of Campbell Scientific: the station, the names, the units, the way of sampling."""
    head = ['"TOA5","Vessel","CR1000","1031","CR1000.Std.26","CPU:Helm.CR1","4062","Helm"',
            '"TIMESTAMP","RECORD","Heading_Avg","YawRate_Avg","RudderAngle_Smp","BattV_Min"',
            '"TS","RN","deg","deg/s","deg","Volts"', '"","","Avg","Avg","Smp","Min"']  # fmt: skip
    own = zip(run.t, run.psi * D % 360, run.r * D, run.delta * D, strict=True)
    return head + [
        f'"{stamp(run, i, "").replace("T", " ")}",{i},{p:.2f},{r:.4f},{d:.2f},12.6'
        for i, (_, p, r, d) in enumerate(own)
    ]


def _tecplot(run):
    """Names in quotes, cut over two lines, above the begin of the zone."""
    head = ['TITLE = "zigzag"', 'VARIABLES = "Time [s]" "Heading [deg]"', '"Yaw rate [deg/s]" "Rudder [deg]"',
            f'ZONE T="run 1", I={run.t.size}, F=POINT']  # fmt: skip
    own = zip(run.t, run.psi * D, run.r * D, run.delta * D, strict=True)
    return head + [" ".join(f"{x:.6E}" for x in row) for row in own]


def _named_values(run, i):
    heading, rate, rudder = run.psi[i] * D % 360, run.r[i] * D, run.delta[i] * D
    return [
        f"ts={stamp(run, i)} level=info msg=helm hdg_deg={heading:.2f} rot_deg_s={rate:.4f} rudder_deg={rudder:.2f}"
    ]


def _flow(run):
    """Monitors of a program that simulates flows: each name stands twice."""
    names = (("Heading", "deg"), ("Yaw Rate", "radian/s"), ("Rudder Angle", "deg"), ("Surge Velocity", "m/s"))
    twice = [f'"{name} Monitor: {name} Monitor ({unit})"' for name, unit in names]
    own = zip(run.t, run.psi * D, run.r, run.delta * D, run.u, strict=True)
    head = ",".join(['"Physical Time: Physical Time (s)"', *twice])
    return [head, *(",".join(f"{x:.8g}" for x in row) for row in own)]


def _tenths(run):
    """AIS as a service exports it: speeds in tenths of knots as whole numbers, nothing says so."""
    head = "MMSI,LAT,LON,SPEED,HEADING,COURSE,STATUS,TIMESTAMP"
    own = zip(run.lat, run.lon, run.sog / KN, run.psi * D % 360, run.cog * D, strict=True)
    return [head] + [
        f"219012345,{a:.7f},{o:.7f},{10 * s:.0f},{h:.1f},{c:.1f},0,{stamp(run, i, '')}"
        for i, (a, o, s, h, c) in enumerate(own)
    ]


def _utc_behind(run):
    own = zip(run.psi * D % 360, run.delta * D, strict=True)
    rows_ = [f"{stamp(run, i, '').replace('T', ' ')} UTC,{h:.2f},{d:.2f}" for i, (h, d) in enumerate(own)]
    return ["TIMESTAMP,HEADING [deg],RUDDER [deg]", *rows_]


FORMAT_CASES: dict[str, Case] = {
    "Campbell Scientific TOA5": log("CR1000_Helm.dat", _toa5, end="\r\n"),
    "Tecplot": log("zigzag.plt", _tecplot),
    "named values": log("helm.log", rows(_named_values)),
    "names that stand twice": log("monitors.csv", _flow, (*TURN, "surge_m_s")),
    "AIS, tenths of knots": log("track.csv", _tenths, ("heading_rad", "north_m", "east_m", "surge_m_s"), loose=0.06),
    "UTC behind the stamps": log("track.csv", _utc_behind, BOTH, start="start_utc"),
    "JSON, topics with units": log("mqtt.ndjson", rows(_topics), GROUND),
    "JSON, nested objects": log("nested.jsonl", rows(_nested)),
    "JSON, values with units, stamp before": log("stamped.log", rows(_with_units)),
    "JSON, topics with payloads of text": log("payload.jsonl", rows(_payloads)),
    "JSON, objects of two kinds": log("kinds.jsonl", rows(_kinds)),
    "JSON, a document of rows": log("document.json", _document),
    "JSON, a document of columns": log("columns.json", _columns),
    "JSON, SenML": log("senml.json", _senml),
    "JSON, a list for every signal": log("lists.json", _lists),
    "JSON, ROS with an array": log("ros.jsonl", rows(_ros)),
    "Signal K, deltas": log("signalk.log", rows(_delta), (*TURN, "north_m", "east_m")),
    "Signal K, multiplexed log": log("skserver-raw.log", rows(_multiplexed), (*TURN, "north_m", "east_m")),
    "Signal K, a column for every time": log("batch.csv", _batch, GROUND),
    "InfluxDB, long": log("influx.csv", _influx),
    "InfluxDB, a column for every field": log("pivot.csv", _pivoted),
    "InfluxDB, line protocol": log("points.lp", rows(_line_protocol)),
    "topics without a header": log("subscriber.txt", rows(_subscriber)),
    "sensors in rows of their own": log("sparse.csv", _sparse),
    "MAVLink as JSON": log("flight.json", rows(_mavlink_json), GROUND, loose=0.06),
    "MAVLink as text": log("flight.txt", rows(_mavlink_text)),
    "MOOS": log("run.alog", _alog, PLACE),
    "dataflash as text": log(
        "00000042.log", _dataflash, questions=1, knows={"output 1": Is("rudder", "deg", 1, 0.0875)}, end="\r\n"
    ),
    "topic of PX4 as CSV": log("17_05_vehicle_attitude_0.csv", _quaternions, BOTH),
    "MAVLink as CSV": log("flight.csv", _mavlink, GROUND, loose=0.06),
    "u-blox NAV-PVT": log("UBX-NAV-PVT.csv", _ublox, PLACE),
    "names before the sentences, iXblue": log("nav.raw", rows(named), (*BOTH, "roll_rad", "surge_m_s")),
    "sentences in a field of CSV": log("fields.csv", _fields),
    "day of the year behind the sentences": log("behind.log", rows(behind)),
    "NovAtel INSPVAS and RSA": log("span.gps", rows(span), (*PLACE, "surge_m_s", "sway_m_s"), end="\r\n", loose=0.06),
    "NovAtel BESTPOS, BESTVEL, HEADING": log("best.gps", rows(best), (*PLACE, "surge_m_s", "sway_m_s"), loose=0.06),
    "stray sentences of other talkers": log("stray.log", _strays),
    "rudder orders of ROR and HTD": log("ror.log", rows(orders), (*TURN, "rudder_command_rad")),
    "Hypack RAW": log("line.RAW", _hypack, PLACE, end="\r\n"),
    "SBET and a pilot's log": Case(_sbet, False, wanted=GROUND, questions=0),
    "POSPac text": log("export.txt", _pospac, (*PLACE, "surge_m_s", "sway_m_s", "roll_rad"), end="\r\n"),
    "R2R navigation": log("best.r2rnav", _r2r, PLACE),
    "TCX and a pilot's log": Case(_tcx, False, wanted=PLACE, questions=0),
    "LabVIEW, one time column": log("one.lvm", _lvm(), end="\r\n"),
    "LabVIEW, units in the names": log("names.lvm", _lvm(labels=False), end="\r\n"),
    "LabVIEW, times of every channel, decimal commas": log("multi.lvm", _lvm("Multi", comma=True), end="\r\n"),
    "LabVIEW, no times": log("no.lvm", _lvm("No"), end="\r\n"),
    "degree signs of Windows": log("ecdis.csv", _degrees, GROUND, encoding="cp1252", loose=0.06),
    "Fortran exponents": log("run.dat", _fortran),
    "fixed width, numbers that touch": log("fixed.dat", _touching),
    "degrees-minutes with a hyphen": log("place.csv", _minutes, PLACE),
    "two tables in one file": log("two.csv", _two_tables, (*TURN, "north_m", "east_m")),
    "near-empty rows under the header": Case(_near_empty, False, wanted=TURN, questions=0),
    "two tables in one sheet": Case(_stacked, False, wanted=(*TURN, "north_m", "east_m"), questions=0),
    "Simulink, structure with time": Case(_simulink, False, wanted=TURN, questions=0),
}
