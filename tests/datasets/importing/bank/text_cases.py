"""Text logs of the bank; the hostile ones hold what invites a wrong guess."""

import numpy as np

from .case import Case, Is
from .texts import D, fixed, series, table, texts

ALL = ("rudder_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
TURN = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
RATE = ("rudder_rad", "yaw_rate_rad_s")


def _dm(values, digits):
    return [f"{'-' if x < 0 else ''}{int(abs(x)):0{digits}d}{60 * (abs(x) % 1):08.5f}" for x in values]


def _grouped(values, sign=","):
    return [f'"{x:,.2f}"'.replace(",", sign) for x in values]


def _sided(values, port="P", starboard="S"):
    return [f"{abs(x):.2f} {starboard if x >= 0 else port}" for x in values]


def _with_sidecar(run, folder):
    (folder / "beside.yaml").write_text(
        "rot: deg/min\nrudder: {unit: deg, positive: port}\nyaw: {convention: counterclockwise from east, unit: rad}\n"
    )
    s = series(run)
    columns = {"time [s]": s["t"], "yaw": fixed(np.pi / 2 - run.psi, 5), "rot": s["rot_min"]}
    return table(folder / "beside.csv", columns | {"rudder": fixed(-run.delta * D, 2)})


TEXT_CASES: dict[str, Case] = {
    "plain": Case(
        texts(
            "plain.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "Heading [deg]": s["heading"],
                "ROT [deg/min]": s["rot_min"],
                "Rudder angle [deg]": s["rudder"],
                "SOG [kn]": s["sog"],
                "COG [deg]": s["cog"],
                "Latitude [deg]": s["lat"],
                "Longitude [deg]": s["lon"],
            },
        ),
        False,
        wanted=ALL,
    ),
    "no units, all channels": Case(
        texts(
            "bare.csv",
            lambda s, r: {
                "Timestamp": s["iso"],
                "Heading": s["heading"],
                "ROT": s["rot_min"],
                "Rudder": s["rudder"],
                "SOG": s["sog"],
                "COG": s["cog"],
                "Lat": s["lat"],
                "Lon": s["lon"],
            },
        ),
        True,
        {"Rudder": Is("rudder", "deg")},
        ALL,
    ),
    "rate of turn without unit or heading, positions": Case(
        texts(
            "rot.csv",
            lambda s, r: {
                "Time": s["iso"],
                "ROT": s["rot_s"],
                "Rudder angle": s["rudder"],
                "Lat": s["lat"],
                "Lon": s["lon"],
            },
        ),
        True,
        {"ROT": Is("yaw_rate", "deg/s")},
        RATE,
    ),
    "yaw rate alone": Case(
        texts(
            "alone.csv",
            lambda s, r: {"t [s]": s["t"], "yaw_rate": fixed(-r.r, 6), "rudder [deg]": fixed(-r.delta * D, 2)},
        ),
        True,
        {"yaw_rate": Is("yaw_rate", "rad/s", -1)},
        RATE,
        side="port",
    ),
    "speed without unit or positions": Case(
        texts(
            "speed.csv",
            lambda s, r: {
                "time_s": s["t"],
                "Heading (deg)": s["heading"],
                "Speed": fixed(r.sog * 3.6, 2),
                "Rudder (deg)": s["rudder"],
                "COG (deg)": s["cog"],
            },
        ),
        True,
        {"Speed": Is("speed_over_ground", "km/h")},
        ("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s"),
    ),
    "rudder in per cent": Case(
        texts(
            "percent.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "Heading [deg]": s["heading"],
                "Rudder [%]": fixed(r.delta * D / 0.35, 1),
            },
        ),
        True,
        {"Rudder": Is("rudder", "deg", 1, 0.35)},
        ("rudder_rad", "heading_rad"),
    ),
    "rudder in per cent, unsaid": Case(
        texts(
            "percent2.csv",
            lambda s, r: {"time [s]": s["t"], "Heading [deg]": s["heading"], "Rudder": fixed(r.delta * D / 0.35, 1)},
        ),
        True,
        {"Rudder": Is("rudder", "deg", 1, 0.35)},
        ("rudder_rad", "heading_rad"),
    ),
    "thousands commas": Case(
        texts(
            "grid.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "Heading [deg]": s["heading"],
                "Rudder [deg]": s["rudder"],
                "Easting [m]": _grouped(612345.0 + r.east),
                "Northing [m]": _grouped(6031234.0 + r.north),
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "thousands commas, whole numbers": Case(
        texts(
            "grid2.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "Heading [deg]": s["heading"],
                "Rudder [deg]": s["rudder"],
                "Easting [mm]": [f'"{round(1e3 * x):,}"' for x in 612.0 + r.east],
                "Northing [mm]": [f'"{round(1e3 * x):,}"' for x in 431.0 + r.north],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "rudder, plus is port": Case(
        texts(
            "port.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "Heading [deg]": s["heading"],
                "Rudder (+ = Port) [deg]": fixed(-r.delta * D, 2),
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad"),
        side="port",
    ),
    "signs in German": Case(
        texts(
            "Schiff.csv",
            lambda s, r: {
                "Zeit [s]": s["t"],
                "Drehrate [°/min] (Bb+)": fixed(-60 * r.r * D, 2),
                "Ruderlage [°] (Stb+/Bb-)": s["rudder"],
            },
            sep=";",
            comma=True,
            encoding="cp1252",
        ),
        True,
        wanted=RATE,
    ),
    "port negative": Case(
        texts(
            "neg.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "ROT [deg/min] (port negative)": s["rot_min"],
                "Rudder [deg] (stbd negative)": fixed(-r.delta * D, 2),
            },
        ),
        True,
        wanted=RATE,
        side="port",
    ),
    "ASCII spellings": Case(
        texts(
            "ascii.csv",
            lambda s, r: {
                "time_s": s["t"],
                "heading_deg": s["heading"],
                "yaw_rate_deg_s_1": s["rot_s"],
                "rudder_deg": s["rudder"],
                "sog_km_h_1": fixed(r.sog * 3.6, 3),
                "cog_deg": s["cog"],
            },
        ),
        True,
        wanted=(*TURN, "surge_m_s", "sway_m_s"),
    ),
    "index column without a name": Case(
        texts(
            "frame.csv",
            lambda s, r: {
                "": [str(i) for i in range(r.t.size)],
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "rot [deg/s]": s["rot_s"],
                "rudder [deg]": s["rudder"],
            },
        ),
        True,
        wanted=TURN,
    ),
    "header one name short": Case(
        texts(
            "r.txt",
            lambda s, r: {
                "time_s heading_deg rot_deg_s rudder_deg": [
                    " ".join(row)
                    for row in zip(
                        map(str, range(1, r.t.size + 1)), s["t"], s["heading"], s["rot_s"], s["rudder"], strict=True
                    )
                ]
            },
        ),
        True,
        wanted=TURN,
    ),
    "ddmm.mmm as numbers": Case(
        texts(
            "nmea_like.csv",
            lambda s, r: {
                "Time": s["iso"],
                "Lat": _dm(r.lat, 2),
                "Lon": _dm(r.lon, 3),
                "HDT": s["heading"],
                "SOG [kn]": s["sog"],
                "COG": s["cog"],
                "Rudder angle": s["rudder"],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m"),
    ),
    "yaw counts from east, positions": Case(
        texts(
            "enu.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "yaw [rad]": fixed((np.pi / 2 - r.psi + np.pi) % (2 * np.pi) - np.pi, 5),
                "yaw_rate [rad/s]": fixed(-r.r, 6),
                "rudder [deg]": s["rudder"],
                "lat [deg]": s["lat"],
                "lon [deg]": s["lon"],
            },
        ),
        True,
        wanted=TURN,
    ),
    "yaw counts from east, alone": Case(
        texts(
            "enu2.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "yaw [deg]": fixed(90.0 - r.psi * D, 3),
                "yaw_rate [deg/s]": fixed(-r.r * D, 5),
                "rudder [deg]": s["rudder"],
            },
        ),
        True,
        {"yaw": Is("heading", "deg", -1, 1.0, np.pi / 2)},
        TURN,
    ),
    "x and y without frame": Case(
        texts(
            "xy.csv",
            lambda s, r: {
                "t [s]": s["t"],
                "x [m]": s["east"],
                "y [m]": s["north"],
                "heading [deg]": s["heading"],
                "rudder [deg]": s["rudder"],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "x, y and yaw without frame": Case(
        texts(
            "xyz.csv",
            lambda s, r: {
                "t [s]": s["t"],
                "x [m]": s["east"],
                "y [m]": s["north"],
                "yaw [rad]": fixed(np.pi / 2 - r.psi, 5),
                "rudder [rad]": s["delta_rad"],
            },
        ),
        True,
        {"x": Is("east", "m"), "y": Is("north", "m"), "yaw": Is("heading", "rad", -1, 1.0, np.pi / 2)},
        ("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "sway positive to port": Case(
        texts(
            "sway.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "surge [m/s]": s["u"],
                "sway [m/s]": fixed(-r.v, 4),
                "rudder [deg]": s["rudder"],
                "lat [deg]": s["lat"],
                "lon [deg]": s["lon"],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m"),
    ),
    "sway and roll, unsaid": Case(
        texts(
            "sway2.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "u [m/s]": s["u"],
                "v [m/s]": fixed(-r.v, 4),
                "rudder [deg]": s["rudder"],
                "roll [deg]": fixed(-r.roll * D, 3),
            },
        ),
        True,
        {"v": Is("sway", "m/s", -1), "roll": Is("roll", "deg", -1)},
        ("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s", "roll_rad"),
    ),
    "wrong unit in the header": Case(
        texts(
            "wrong.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "ROT [deg/s]": s["rot_min"],
                "rudder [deg]": s["rudder"],
            },
        ),
        True,
        {"ROT": Is("yaw_rate", "deg/min")},
        TURN,
    ),
    "letters of the side": Case(
        texts(
            "letters.csv",
            lambda s, r: {
                "Time": s["iso"],
                "Heading": s["heading"],
                "ROT [deg/min]": _sided(60 * r.r * D),
                "Rudder [deg]": _sided(r.delta * D),
            },
        ),
        True,
        wanted=TURN,
    ),
    "side in a column of its own": Case(
        texts(
            "beside.csv",
            lambda s, r: {
                "Time": s["iso"],
                "Heading": s["heading"],
                "Rudder [deg]": fixed(np.abs(r.delta) * D, 2),
                "Side": ["S" if x >= 0 else "P" for x in r.delta],
                "Lat": fixed(np.abs(r.lat), 8),
                "N/S": ["N"] * r.t.size,
                "Lon": fixed(np.abs(r.lon), 8),
                "E/W": ["E"] * r.t.size,
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "milliseconds, unsaid": Case(
        texts(
            "ms.csv",
            lambda s, r: {
                "t": [f"{1e3 * x:.0f}" for x in r.t],
                "heading [deg]": s["heading"],
                "rot [deg/s]": s["rot_s"],
                "rudder [deg]": s["rudder"],
            },
        ),
        True,
        wanted=TURN,
        time="milliseconds",
    ),
    "speed, unsaid, with positions": Case(
        texts(
            "v.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "Speed": fixed(r.sog * 3.6, 3),
                "COG [deg]": s["cog"],
                "lat": s["lat"],
                "lon": s["lon"],
                "rudder [deg]": s["rudder"],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m"),
    ),
    "whole numbers of hundredths": Case(
        texts(
            "cdeg.csv",
            lambda s, r: {
                "time_ms": [f"{1e3 * x:.0f}" for x in r.t],
                "heading [0.01 deg]": [f"{x:.0f}" for x in 100 * (r.psi * D % 360)],
                "rudder [cdeg]": [f"{x:.0f}" for x in 100 * r.delta * D],
                "lat_degE7": [f"{x:.0f}" for x in 1e7 * r.lat],
                "lon_degE7": [f"{x:.0f}" for x in 1e7 * r.lon],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "rudder order against the rudder": Case(
        texts(
            "order.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "rudder [deg]": s["rudder"],
                "rudder order [deg]": fixed(-r.order * D, 2),
            },
        ),
        True,
        wanted=("rudder_rad", "rudder_command_rad", "heading_rad"),
    ),
    "longitude to the west": Case(
        texts(
            "west.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "rudder [deg]": s["rudder"],
                "Lat [°N]": s["lat"],
                "Lon [°W]": fixed(-r.lon, 8),
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad", "north_m", "east_m"),
    ),
    "units in the lines above": Case(
        texts(
            "notes.csv",
            lambda s, r: {
                "time": s["t"],
                "heading": s["heading"],
                "yawrate": s["rot_min"],
                "rudder": fixed(-r.delta * D, 2),
            },
            head=("# time in s", "# yawrate in deg/min", "# rudder in deg, positive to port", "# heading in deg"),
        ),
        True,
        wanted=TURN,
        side="port",
    ),
    "two rudders": Case(
        texts(
            "twin.csv",
            lambda s, r: {
                "time [s]": s["t"],
                "heading [deg]": s["heading"],
                "Rudder port [deg]": s["rudder"],
                "Rudder stbd [deg]": fixed(r.delta * D * 0.7 + 1.0, 2),
            },
        ),
        True,
        {"Rudder port": Is("rudder", "deg")},
        ("rudder_rad", "heading_rad"),
    ),
    "day and month": Case(
        texts(
            "date.csv",
            lambda s, r: {
                "Date": ["05/03/2026"] * r.t.size,
                "Time": [f"{10 + int(x) // 3600:02d}:{int(x) // 60 % 60:02d}:{x % 60:04.1f}" for x in r.t],
                "Heading [deg]": s["heading"],
                "Rudder [deg]": s["rudder"],
            },
        ),
        True,
        wanted=("rudder_rad", "heading_rad"),
        time="month first",
    ),
    "cryptic names": Case(
        texts(
            "ch.csv",
            lambda s, r: {"t [s]": s["t"], "CH1": s["heading"], "CH2": s["rudder"], "CH3": fixed(7 + np.sin(r.t), 2)},
        ),
        True,
        {"CH1": Is("heading", "deg"), "CH2": Is("rudder", "deg")},
        ("rudder_rad", "heading_rad"),
    ),
    "a file beside the log": Case(
        _with_sidecar,
        True,
        wanted=TURN,
        side="port",
    ),
    "no names at all": Case(
        texts(
            "nameless.dat",
            lambda s, r: {
                s["t"][0]: s["t"][1:],
                **{f"{x[0]} {i}".split(" ")[0] + "0" * i: x[1:] for i, x in enumerate((s["heading"], s["rudder"]), 1)},
            },
            sep="\t",
        ),
        True,
        {"column 2": Is("heading", "deg"), "column 3": Is("rudder", "deg")},
        ("rudder_rad", "heading_rad"),
        time="column 1: seconds",
    ),
    "no time, a rate in the notes": Case(
        texts(
            "rate.csv",
            lambda s, r: {"heading [deg]": s["heading"], "rudder [deg]": s["rudder"]},
            head=("# sampling rate: 2 Hz",),
        ),
        False,
        wanted=("rudder_rad", "heading_rad"),
    ),
    "no time at all": Case(
        texts("rows.csv", lambda s, r: {"heading [deg]": s["heading"], "rudder [deg]": s["rudder"]}),
        True,
        wanted=("rudder_rad", "heading_rad"),
        time="0.5",
    ),
    "row of units": Case(
        texts(
            "units.txt",
            lambda s, r: {
                "time": s["t"],
                "HDG": s["heading"],
                "ROT": s["rot_min"],
                "RUD": s["rudder"],
                "RPM": s["rpm"],
            },
            sep="\t",
            units=("s", "deg", "deg/min", "deg", "1/min"),
            encoding="utf-16",
        ),
        False,
        wanted=(*TURN, "propeller_rps"),
    ),
    "German": Case(
        texts(
            "Messung.csv",
            lambda s, r: {
                "Datum": [f"{x[8:10]}.{x[5:7]}.{x[:4]}" for x in s["iso"]],
                "Uhrzeit": [x[11:].replace(".", ",") for x in s["iso"]],
                "Kurs [°]": s["heading"],
                "Drehrate [°/min]": s["rot_min"],
                "Ruderlage [°]": s["rudder"],
                "Fahrt über Grund [kn]": s["sog"],
                "Kurs über Grund [°]": s["cog"],
                "Breite [°]": s["lat"],
                "Länge [°]": s["lon"],
            },
            sep=";",
            comma=True,
            encoding="cp1252",
        ),
        False,
        wanted=ALL,
    ),
    "French": Case(
        texts(
            "mesure.csv",
            lambda s, r: {
                "Temps [s]": s["t"],
                "Cap [°]": s["heading"],
                "Taux de giration [°/min]": s["rot_min"],
                "Angle de barre [°] (tribord +)": s["rudder"],
                "Vitesse fond [nœuds]": s["sog"],
                "Route fond [°]": s["cog"],
                "Nord [m]": [f"{x:,.2f}".replace(",", "\u202f").replace(".", ",") for x in 6031234.0 + r.north],
                "Est [m]": [f"{x:,.2f}".replace(",", "\u202f").replace(".", ",") for x in 612345.0 + r.east],
            },
            sep=";",
            comma=True,
        ),
        False,
        {"Vitesse fond": Is("speed_over_ground", "kn")},
        ALL,
    ),
    "Spanish": Case(
        texts(
            "prueba.csv",
            lambda s, r: {
                "Hora": s["iso"],
                "Rumbo (grados)": s["heading"],
                "Velocidad de giro (grados/min)": s["rot_min"],
                "Ángulo de timón (grados)": s["rudder"],
                "Velocidad sobre el fondo (nudos)": s["sog"],
                "Rumbo sobre el fondo (grados)": s["cog"],
                "Latitud": s["lat"],
                "Longitud": s["lon"],
            },
            sep=";",
            comma=True,
            encoding="latin-1",
        ),
        False,
        wanted=ALL,
    ),
    "Norwegian": Case(
        texts(
            "proeve.csv",
            lambda s, r: {
                "Tid": s["iso"],
                "Gyrokurs [grader]": s["heading"],
                "Svinghastighet [grader/min]": s["rot_min"],
                "Rorvinkel [grader] (styrbord positiv)": s["rudder"],
                "Fart over grunn [knop]": s["sog"],
                "Kurs over grunn [grader]": s["cog"],
                "Breddegrad": s["lat"],
                "Lengdegrad": s["lon"],
            },
            sep=";",
            comma=True,
        ),
        False,
        wanted=ALL,
    ),
    "Japanese": Case(
        texts(
            "shiken.csv",
            lambda s, r: {
                "時刻": s["iso"],
                "船首方位[度]": s["heading"],
                "回頭角速度[度/秒]": s["rot_s"],
                "舵角[度]": s["rudder"],
                "対地速力[ノット]": s["sog"],
                "対地針路[度]": s["cog"],
                "緯度": s["lat"],
                "経度": s["lon"],
            },
            encoding="shift_jis",
        ),
        False,
        wanted=ALL,
    ),
    "Chinese": Case(
        texts(
            "shiyan.csv",
            lambda s, r: {
                "时间": s["iso"],
                "艏向(度)": s["heading"],
                "转首角速度(度/秒)": s["rot_s"],
                "舵角(度)": s["rudder"],
                "对地航速(节)": s["sog"],
                "对地航向(度)": s["cog"],
                "纬度": s["lat"],
                "经度": s["lon"],
            },
            encoding="gb18030",
        ),
        False,
        wanted=ALL,
    ),
    "unit behind every number": Case(
        texts(
            "unit.csv",
            lambda s, r: {
                "Time": s["iso"],
                "Heading": [f"{x}°" for x in s["heading"]],
                "Rate of turn": [f"{x} °/min" for x in s["rot_min"]],
                "Rudder": [f"{x} deg" for x in s["rudder"]],
                "SOG": [f"{x} kn" for x in s["sog"]],
                "COG": [f"{x}°" for x in s["cog"]],
            },
        ),
        False,
        wanted=(*TURN, "surge_m_s", "sway_m_s"),
    ),
    "basin": Case(
        texts(
            "basin.dat",
            lambda s, r: {
                "": [
                    "".join(f"{float(x):14.5f}" for x in row)
                    for row in zip(
                        s["t"],
                        s["north"],
                        s["east"],
                        s["heading"],
                        s["u"],
                        s["v"],
                        s["rot_s"],
                        s["rudder"],
                        strict=True,
                    )
                ]
            },
            head=(
                "# TOWING TANK",
                "# column 1: time [s]",
                "# column 2: x0 [m]",
                "# column 3: y0 [m]",
                "# column 4: heading [deg]",
                "# column 5: u [m/s]",
                "# column 6: v [m/s]",
                "# column 7: yaw rate [deg/s]",
                "# column 8: rudder angle [deg]",
            ),
        ),
        False,
        wanted=ALL,
    ),
}
