"""Set `kvlcc2-marin`: free-running zigzags and turning circles of KVLCC2 (MARIN, SIMMAN 2008), at model scale."""

from __future__ import annotations

import numpy as np

from ..geometry import body_velocities
from .base import Columns, Dataset, MeasuredRun

HEADER_LINES = 3
SCALE = 320.0 / 7.0
"""Length of the ship over that of the 7 m model; the files hold full-scale values."""
STEP_S = 0.135264
"""Time step at full scale; the time column has three digits only, so that its stamps repeat."""


def _read(content: bytes) -> Columns:
    """One run, scaled to the 7 m model by Froude's law.

    Columns (N, 11), full scale: time s; x0, y0 m; roll, heading deg; dx0/dt, dy0/dt m/s (earth-fixed); roll rate, yaw
    rate deg/s; rudder deg (positive to port); propeller 1/min.  Lengths are divided by the scale, times and speeds by
    its root, rates multiplied by its root.  The first row appears twice.
    """
    lines = content.decode("cp1252").splitlines()[HEADER_LINES:]
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


def _run(stem: str, sha256: str) -> tuple[str, MeasuredRun]:
    kind, _, angle = stem.partition("_")
    side, size = (":port" if angle.startswith("-") else ""), angle.removeprefix("-")
    manoeuvre = f"zigzag:{size}/{size}{side}" if kind == "zz" else f"turn:{size}{side}"
    return stem, MeasuredRun(f"MARIN_FREE_KVLCC2_{stem}_m.dat", sha256, manoeuvre)


SHA256 = {
    "tc_-35": "65b54ac82aa6b48e5851f7898a6349688ed3391c86c7ff79eeaa758125fb815d",
    "tc_35": "9bba1c548ed2972f24249d862f254cfe3d0cb68475078cde0e9b5f9f2ead5b7f",
    "zz_-10": "b4de80bc3fbcd60cb4b2ea25a08a6831c7008fb0150425cfc8ad3690766da241",
    "zz_-20": "6db9f281ee2c1f35b7b2b28925710280d14126e60e444f53e2ca6ad7d4aaefd0",
    "zz_10": "80fe4bc493d5fe0923ee7fb7581c8351bac35c9c4201fb48c4cae52deb6c166a",
    "zz_20": "62af7e3af28c99e35aa363caf618e5a70588f9c8742b0bc4df9ac9d802c16be3",
}
KVLCC2_MARIN = Dataset(
    url=(
        "https://raw.githubusercontent.com/martinlarsalbert/System-identification-of-Vessel-Manoeuvring-Models/"
        "4b7ce53f0cc8ac159126fdda7d45e30c540be2d8/data/01_raw/kvlcc2"
    ),
    folder="kvlcc2/marin",
    citation="MARIN 2007, free-running model tests of KVLCC2; SIMMAN 2008 workshop",
    runs=dict(_run(stem, sha256) for stem, sha256 in SHA256.items()),
    read=_read,
    notes="full-scale values of the files scaled to 7 m; time from the sample number",
    positive_rudder="port",
    vessel="kvlcc2-l7",
    known="the yaw rate carries a bias of .030 to .040 deg/s that differs from run to run; tc_-35 has a bad tail",
)
