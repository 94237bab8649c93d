"""Raw logs of different make, written from a record; each function returns its files."""

import datetime
from pathlib import Path

import numpy as np
import openpyxl
import pyproj
import scipy.io

from helmbench.datasets.record import Record

START = datetime.datetime(2026, 3, 14, 9, 26, 53, 500000, tzinfo=datetime.UTC)
PLACE = (54.42, 10.31)
KN = 1852.0 / 3600.0


def columns(record: Record) -> dict[str, np.ndarray]:
    """What loggers show of a record: degrees, knots, positions, course over ground."""
    psi, u, v = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    to_north, to_east = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    plane = pyproj.Proj(f"+proj=aeqd +lat_0={PLACE[0]} +lon_0={PLACE[1]} +ellps=WGS84")
    lon, lat = plane(record.column("east_m"), record.column("north_m"), inverse=True)
    return {
        "time": record.time_s,
        "heading": np.degrees(psi) % 360.0,
        "rate": np.degrees(record.column("yaw_rate_rad_s")),
        "rudder": np.degrees(record.rudder()),
        "sog": np.hypot(u, v) / KN,
        "cog": np.degrees(np.arctan2(to_east, to_north)) % 360.0,
        "lat": lat,
        "lon": lon,
    }


def moment(seconds: float, start: datetime.datetime = START) -> datetime.datetime:
    return start + datetime.timedelta(seconds=float(seconds))


def bridge(record: Record, folder: Path) -> list[Path]:
    """ISO time, knots, degrees per minute, positions in degrees, columns that are no channel."""
    c = columns(record)
    lines = ["Timestamp,Heading,ROT [deg/min],Rudder angle,SOG [kn],COG,Latitude,Longitude,Depth,Remark"]
    for i, t in enumerate(c["time"]):
        stamp = moment(t).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        lines.append(
            f"{stamp},{c['heading'][i]:.2f},{60 * c['rate'][i]:.2f},{c['rudder'][i]:.2f},{c['sog'][i]:.3f},"
            f"{c['cog'][i]:.2f},{c['lat'][i]:.8f},{c['lon'][i]:.8f},23.4,{'pilot aboard' if i == 3 else ''}"
        )
    path = folder / "bridge.csv"
    path.write_text("\n".join(lines), "utf-8")
    return [path]


def survey(record: Record, folder: Path) -> list[Path]:
    """UTF-16, tabs, comment lines, a row of units, degrees and minutes."""
    c = columns(record)

    def dm(angle: float, letters: str) -> str:
        size = abs(angle)
        return f"{int(size):02d}°{60 * (size % 1):010.7f}'{letters[0 if angle >= 0 else 1]}"

    lines = [
        "// Survey export 4.2",
        "// Vessel: X",
        "Date\tUTC Time\tLat\tLon\tSOG\tCourse over ground\tGyro Heading\tRate of Turn\tRudder Angle\tHDOP",
    ]
    lines.append("-\thh:mm:ss\tdms\tdms\tkts\tdeg\tdeg\tdeg/s\tdeg\t-")
    for i, t in enumerate(c["time"]):
        now = moment(t)
        values = [
            now.strftime("%d/%m/%Y"),
            now.strftime("%H:%M:%S.%f")[:-3],
            dm(c["lat"][i], "NS"),
            dm(c["lon"][i], "EW"),
        ]
        values += [f"{c[name][i]:.4f}" for name in ("sog", "cog", "heading", "rate", "rudder")]
        lines.append("\t".join([*values, "0.8"]))
    path = folder / "survey.txt"
    path.write_bytes("\r\n".join(lines).encode("utf-16"))
    return [path]


def _sentence(body: str) -> str:
    check = 0
    for letter in body:
        check ^= ord(letter)
    return f"${body}*{check:02X}"


def autopilot(record: Record, folder: Path) -> list[Path]:
    """NMEA 0183: RMC every second, HDT, ROT and RSA at every sample; a broken line and sentences of other kinds."""
    c = columns(record.turned("starboard"))
    every = max(1, round(1.0 / record.dt))
    lines, first = [], None

    def dm(angle: float, digits: int, letters: str) -> str:
        return f"{int(abs(angle)):0{digits}d}{60 * (abs(angle) % 1):010.7f},{letters[0 if angle >= 0 else 1]}"

    for i, t in enumerate(c["time"]):
        now = moment(t)
        if i % every == 0:
            first = t if first is None else first
            place = f"{dm(c['lat'][i], 2, 'NS')},{dm(c['lon'][i], 3, 'EW')}"
            clock, date = now.strftime("%H%M%S.%f")[:-4], now.strftime("%d%m%y")
            lines.append(_sentence(f"GPRMC,{clock},A,{place},{c['sog'][i]:.3f},{c['cog'][i]:.2f},{date},2.1,E"))
        lines.append(_sentence(f"HEHDT,{c['heading'][i]:.2f},T"))
        lines.append(_sentence(f"TIROT,{60 * c['rate'][i]:.2f},A"))
        lines.append(_sentence(f"ERRSA,{c['rudder'][i]:.2f},A,,V"))
        lines += [_sentence("SDDBT,77.1,f,23.5,M,12.8,F")] if i % every == 0 else []
    lines[50] = lines[50][:-4] + "*00"
    path = folder / "autopilot.log"
    path.write_text("\r\n".join(lines), "ascii")
    return [path]


def basin(record: Record, folder: Path) -> list[Path]:
    """Model basin: a list of the columns in comment lines, numbers in columns of fixed width."""
    names = {"time [s]": record.time_s, "x0 [m]": record.column("north_m"), "y0 [m]": record.column("east_m")}
    names |= {"heading [deg]": np.degrees(record.heading_unwrapped()), "u [m/s]": record.column("surge_m_s")}
    names |= {"v [m/s]": record.column("sway_m_s"), "yaw rate [deg/s]": np.degrees(record.column("yaw_rate_rad_s"))}
    names |= {"rudder angle [deg]": np.degrees(record.rudder()), "propeller revs [rps]": np.full(record.n, 10.23)}
    lines = ["# TOWING TANK, free running test", "# model 1:45.7   date 14.03.2026"]
    lines += [f"# column {i}: {name}" for i, name in enumerate(names, start=1)]
    lines += ["".join(f"{value:16.7f}" for value in row) for row in zip(*names.values(), strict=True)]
    path = folder / "basin_20_20.dat"
    path.write_text("\n".join(lines), "cp1252")
    return [path]


GERMAN = (
    "Datum",
    "Uhrzeit",
    "Kurs [°]",
    "Drehrate [°/min]",
    "Ruderlage [°]",
    "Fahrt über Grund [kn]",
    "Kurs über Grund [°]",
    "Breite [°]",
    "Länge [°]",
    "Bemerkung",
)


def german(record: Record, folder: Path) -> list[Path]:
    """German CSV: semicolons, decimal commas, Windows-1252, day before month."""
    c = columns(record)
    lines = [";".join(GERMAN)]
    for i, t in enumerate(c["time"]):
        now = moment(t)
        values = [c["heading"][i], 60 * c["rate"][i], c["rudder"][i], c["sog"][i], c["cog"][i]]
        texts = [now.strftime("%d.%m.%Y"), now.strftime("%H:%M:%S,%f")[:-3], *(f"{x:.3f}" for x in values)]
        texts += [f"{c['lat'][i]:.8f}", f"{c['lon'][i]:.8f}", ""]
        lines.append(";".join(text.replace(".", ",") if k > 1 else text for k, text in enumerate(texts)))
    path = folder / "Messung.csv"
    path.write_bytes("\r\n".join(lines).encode("cp1252"))
    return [path]


def german_excel(record: Record, folder: Path) -> list[Path]:
    """German workbook: title lines, a row of units, cells with date and time."""
    c = columns(record)
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Messwerte"
    sheet.append(["Erprobungsfahrt", "14.03.2026"])
    sheet.append([])
    sheet.append(
        [
            "Zeit",
            "Steuerkurs",
            "Drehrate",
            "Ruderwinkel",
            "Geschwindigkeit über Grund",
            "Kurs über Grund",
            "Breite",
            "Länge",
        ]
    )
    sheet.append(["", "Grad", "Grad/s", "Grad", "Knoten", "Grad", "Grad", "Grad"])
    for i, t in enumerate(c["time"]):
        values = [c[name][i] for name in ("heading", "rate", "rudder", "sog", "cog", "lat", "lon")]
        sheet.append([moment(t).replace(tzinfo=None), *map(float, values)])
    book.create_sheet("Notizen").append(["alles in Ordnung"])
    path = folder / "Erprobung.xlsx"
    book.save(path)
    return [path]


def auv_topics(record: Record, folder: Path) -> list[Path]:
    """A CSV file for each topic of an AUV, each with its own clock and rate: fin, attitude, navigation."""
    epoch = START.timestamp()
    fine = _at(record, np.arange(0.0, record.time_s[-1], record.dt / 2.0))
    coarse = _at(record, np.arange(1.0, record.time_s[-1] - 2.0, 2.0 * record.dt))
    paths = [folder / name for name in ("fin.csv", "attitude.csv", "navigation.csv")]
    _write(
        paths[0],
        {"stamp": epoch + record.time_s, "fin_angle_rad": record.rudder(), "yaw_rad": record.heading_unwrapped()},
    )
    psi, rate = fine.heading_unwrapped(), fine.column("yaw_rate_rad_s")
    _write(
        paths[1],
        {"stamp": epoch + 3.37 + fine.time_s, "yaw_rad": _wrapped(psi), "yaw_rate_rad_s": rate, "pitch_rad": 0 * psi},
    )
    names = ("surge_m_s", "sway_m_s", "north_m", "east_m", "heading_rad")
    _write(paths[2], {"time_s": coarse.time_s - 1.0, **{name: coarse.column(name) for name in names}})
    return paths


def _at(record: Record, time: np.ndarray) -> Record:
    channels = {name: np.interp(time, record.time_s, _unwrapped(record, name)) for name in record.channels}
    return Record(time, channels, record.name, record.meta)


def _unwrapped(record: Record, name: str) -> np.ndarray:
    return record.continuous(name)


def _wrapped(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def _write(path: Path, table: dict[str, np.ndarray]) -> None:
    rows = [
        ",".join(f"{value:.10g}" if abs(value) < 1e6 else f"{value:.4f}" for value in row)
        for row in zip(*table.values(), strict=True)
    ]
    path.write_text("\n".join([",".join(table), *rows]) + "\n", "utf-8")


def matlab(record: Record, folder: Path) -> list[Path]:
    """A structure of arrays with the usual symbols, and their units."""
    series = {
        "t": record.time_s,
        "psi": np.degrees(record.heading_unwrapped()),
        "r": np.degrees(record.column("yaw_rate_rad_s")),
    }
    series |= {"delta": np.degrees(record.rudder()), "u": record.column("surge_m_s"), "v": record.column("sway_m_s")}
    units = {"t": "s", "psi": "deg", "r": "deg/s", "delta": "deg", "u": "m/s", "v": "m/s"}
    path = folder / "trial.mat"
    scipy.io.savemat(path, {"run": series, "units": units, "ship": "X"}, oned_as="column")
    return [path]


def epoch_ms(record: Record, folder: Path) -> list[Path]:
    """Milliseconds since 1970, names of a database without units."""
    c = columns(record)
    stamp = np.round(1e3 * (START.timestamp() + c["time"]))
    rows = [
        f"{stamp[i]:.0f}|{c['heading'][i]:.3f}|{c['rate'][i]:.4f}|{c['rudder'][i]:.3f}|{c['sog'][i]:.4f}|{c['cog'][i]:.3f}|"
        f"{c['lat'][i]:.8f}|{c['lon'][i]:.8f}"
        for i in range(record.n)
    ]
    path = folder / "export.txt"
    header = "timestamp|hdg|rot|rudder_angle|sog_kn|cog|gps_lat|gps_lon"
    path.write_text("\n".join([header, *rows]), "utf-8")
    return [path]


def midnight(record: Record, folder: Path) -> list[Path]:
    """Time of day without a date, full seconds only, over midnight."""
    c = columns(record)
    start = datetime.datetime(2026, 3, 14, 23, 58, 30, tzinfo=datetime.UTC)
    lines = ["Time;Yaw (deg);Yaw rate (deg/s);Helm angle (deg);Surge (m/s);Sway (m/s)"]
    for i, t in enumerate(c["time"]):
        values = [
            c["heading"][i],
            c["rate"][i],
            c["rudder"][i],
            record.column("surge_m_s")[i],
            record.column("sway_m_s")[i],
        ]
        lines.append(";".join([moment(t, start).strftime("%H:%M:%S"), *(f"{x:.5f}" for x in values)]))
    path = folder / "night.csv"
    path.write_text("\n".join(lines), "utf-8")
    return [path]


def sheets(record: Record, folder: Path) -> list[Path]:
    """A workbook with a sheet for each instrument, serial days, different rates."""
    c = columns(record)
    serial = START.timestamp() / 86400.0 + 25569.0 + c["time"] / 86400.0
    book = openpyxl.Workbook()
    book.remove(book.active)
    parts = {
        "Gyro": (1, {"Heading [deg]": c["heading"], "ROT [deg/min]": 60 * c["rate"]}),
        "Steering": (1, {"Rudder [deg]": c["rudder"]}),
        "GPS": (2, {"Lat [deg]": c["lat"], "Lon [deg]": c["lon"], "SOG [kn]": c["sog"], "COG [deg]": c["cog"]}),
    }
    for title, (every, table) in parts.items():
        sheet = book.create_sheet(title)
        sheet.append(["Time", *table])
        for i in range(0, record.n, every):
            sheet.append([float(serial[i]), *(float(values[i]) for values in table.values())])
    path = folder / "instruments.xlsx"
    book.save(path)
    return [path]


MAKERS = (bridge, survey, autopilot, basin, german, german_excel, auv_topics, matlab, epoch_ms, midnight, sheets)
LOGS = {maker.__name__: maker for maker in MAKERS}
