"""Sets `kvlcc2-hsva` and `kvlcc2-marin`: free-running tests of KVLCC2 at HSVA and MARIN (SIMMAN 2008), for its 7 m
model."""

from __future__ import annotations

import numpy as np

from ..geometry import body_velocities
from .base import Columns, Dataset, MeasuredRun

URL = (
    "https://raw.githubusercontent.com/martinlarsalbert/System-identification-of-Vessel-Manoeuvring-Models/"
    "4b7ce53f0cc8ac159126fdda7d45e30c540be2d8/data/01_raw"
)
SCALE = 320.0 / 7.0
"""Length of the ship over that of the 7 m model; MARIN's files hold full-scale values."""
STEP_S = 0.135264
"""MARIN's time step at full scale; the time column has three digits only, so that its stamps repeat."""


def _read_hsva(content: bytes) -> Columns:
    """One free-running zigzag of the 7 m KVLCC2 model.

    Columns (N, 12): time s; x0, y0 m; psi deg; dx0/dt, dy0/dt m/s (earth-fixed); yaw rate deg/s; roll deg; rudder deg
    (positive to port); propeller 1/s; thrust N; torque N m. Velocities are turned into body axes:
    u = x0' cos psi + y0' sin psi, v = -x0' sin psi + y0' cos psi.
    """
    lines = content.decode("cp1252").splitlines()[4:]
    time, north, east, psi, north_rate, east_rate, yaw_rate, roll, rudder, propeller, thrust = np.loadtxt(lines).T[:11]
    psi, yaw_rate, roll, rudder = np.deg2rad([psi, yaw_rate, roll, rudder])
    surge, sway = body_velocities(north_rate, east_rate, psi)
    channels = {
        "rudder_rad": rudder,
        "propeller_rps": propeller,
        "heading_rad": psi,
        "yaw_rate_rad_s": yaw_rate,
        "surge_m_s": surge,
        "sway_m_s": sway,
        "north_m": north,
        "east_m": east,
        "roll_rad": roll,
        "propeller_thrust_N": thrust,
    }
    return time, channels


def _hsva_run(stem: str, sha256: str) -> tuple[str, MeasuredRun]:
    rudder, heading = (int(part) for part in stem.split("_")[1:3])
    side = ":port" if stem.endswith("_P") else ""
    return stem, MeasuredRun(f"HSVA_CPMC_KVLCC2_{stem}.dat", sha256, f"zigzag:{rudder}/{heading}{side}")


HSVA_SHA256 = {
    "Z_05_01": "169305b6aa1a2dee0c1a498708228fde1db04f0e0a913ad31c3186e99fb61766",
    "Z_10_05": "db2b9921264d4a2b998d259d001adb016c7368dd7ac1772dbeb96037875469b3",
    "Z_10_10_P": "fd3a1508e2c6f5fda46145a104c227789fbfa6a1847dd33723510872307467c4",
    "Z_10_10_S": "8b83dc0d1eea93f96a60d1a5d8d60f8b23c2f55b356d8b45d3f9a1cbdf94fb90",
    "Z_15_01": "3e5de380bf7a6b10fe2c650edeae01fdc8df5361e27a40ff0aa1b184cb629b6f",
    "Z_15_05": "d9e4c4669fabe7c05c6c701909f904564fd2a5a6454bbec6bf4ae5921000b140",
    "Z_20_05": "671b46a1f98e35b1b15d1aede74f909b8d3e2a4f1cb81cb69b476eb382bb4e76",
    "Z_20_10_S": "5fdf062d6077f3ed7da1ef89354d335d3a4fb89f5be4b2c448d77490ee0f01f4",
    "Z_25_05": "f9ea9d7e22e89e02fbd82be2d6e61c9b36424a9a2b54b43143775397e047e518",
    "Z_35_05": "6c2be03f2d6cdaf512c191b232352d040e8d7e64c286a2d4cac2de293dcc4796",
}
KVLCC2_HSVA = Dataset(
    url=f"{URL}/kvlcc2_hsva/raw_data",
    folder="kvlcc2/hsva",
    citation="HSVA 2006, free-running model tests of KVLCC2; SIMMAN 2008 workshop",
    runs=dict(_hsva_run(stem, sha256) for stem, sha256 in HSVA_SHA256.items()),
    read=_read_hsva,
    notes="model scale, 7 m; measured rudder; the execute lags the nominal heading by up to 2.5 deg",
    positive_rudder="port",
    vessel="kvlcc2-l7",
)


def _read_marin(content: bytes) -> Columns:
    """One run, scaled to the 7 m model by Froude's law.

    Columns (N, 11), full scale: time s; x0, y0 m; roll, heading deg; dx0/dt, dy0/dt m/s (earth-fixed); roll rate, yaw
    rate deg/s; rudder deg (positive to port); propeller 1/min.  Lengths are divided by the scale, times and speeds by
    its root, rates multiplied by its root.  The first row appears twice.
    """
    lines = content.decode("cp1252").splitlines()[3:]
    _, north, east, roll, heading, north_rate, east_rate, roll_rate, yaw_rate, rudder, turns = np.loadtxt(lines)[1:].T
    root = np.sqrt(SCALE)
    psi, roll, rudder = np.deg2rad(heading), np.deg2rad(roll), np.deg2rad(rudder)
    north_rate, east_rate = north_rate / root, east_rate / root
    surge, sway = body_velocities(north_rate, east_rate, psi)
    channels = {
        "rudder_rad": rudder,
        "propeller_rps": turns * root / 60.0,
        "heading_rad": psi,
        "yaw_rate_rad_s": np.deg2rad(yaw_rate) * root,
        "surge_m_s": surge,
        "sway_m_s": sway,
        "north_m": north / SCALE,
        "east_m": east / SCALE,
        "roll_rad": roll,
        "roll_rate_rad_s": np.deg2rad(roll_rate) * root,
    }
    return np.arange(north.size) * STEP_S / root, channels


def _marin_run(stem: str, sha256: str) -> tuple[str, MeasuredRun]:
    kind, _, angle = stem.partition("_")
    side, size = (":port" if angle.startswith("-") else ""), angle.removeprefix("-")
    manoeuvre = f"zigzag:{size}/{size}{side}" if kind == "zz" else f"turn:{size}{side}"
    return stem, MeasuredRun(f"MARIN_FREE_KVLCC2_{stem}_m.dat", sha256, manoeuvre)


MARIN_SHA256 = {
    "tc_-35": "65b54ac82aa6b48e5851f7898a6349688ed3391c86c7ff79eeaa758125fb815d",
    "tc_35": "9bba1c548ed2972f24249d862f254cfe3d0cb68475078cde0e9b5f9f2ead5b7f",
    "zz_-10": "b4de80bc3fbcd60cb4b2ea25a08a6831c7008fb0150425cfc8ad3690766da241",
    "zz_-20": "6db9f281ee2c1f35b7b2b28925710280d14126e60e444f53e2ca6ad7d4aaefd0",
    "zz_10": "80fe4bc493d5fe0923ee7fb7581c8351bac35c9c4201fb48c4cae52deb6c166a",
    "zz_20": "62af7e3af28c99e35aa363caf618e5a70588f9c8742b0bc4df9ac9d802c16be3",
}
KVLCC2_MARIN = Dataset(
    url=f"{URL}/kvlcc2",
    folder="kvlcc2/marin",
    citation="MARIN 2007, free-running model tests of KVLCC2; SIMMAN 2008 workshop",
    runs=dict(_marin_run(stem, sha256) for stem, sha256 in MARIN_SHA256.items()),
    read=_read_marin,
    notes="full-scale values of the files scaled to 7 m; time from the sample number",
    positive_rudder="port",
    vessel="kvlcc2-l7",
    known="the yaw rate carries a bias of .030 to .040 deg/s that differs from run to run; tc_-35 has a bad tail",
)
