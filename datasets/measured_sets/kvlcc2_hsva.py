"""Set `kvlcc2-hsva`: free-running zigzags of the 7 m KVLCC2 model (HSVA 2006, SIMMAN 2008)."""

from __future__ import annotations

import numpy as np

from ..geometry import body_velocities
from .base import Columns, Dataset, MeasuredRun

HSVA_HEADER_LINES = 4


def _read_hsva(content: bytes) -> Columns:
    """One free-running zigzag of the 7 m KVLCC2 model.

    Columns (N, 12): time s; x0, y0 m; psi deg; dx0/dt, dy0/dt m/s (earth-fixed); yaw rate deg/s; roll deg; rudder deg
    (positive to port); propeller 1/s; thrust N; torque N m. Velocities are turned into body axes:
    u = x0' cos psi + y0' sin psi, v = -x0' sin psi + y0' cos psi.
    """
    lines = content.decode("cp1252").splitlines()[HSVA_HEADER_LINES:]
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
    url=(
        "https://raw.githubusercontent.com/martinlarsalbert/System-identification-of-Vessel-Manoeuvring-Models/"
        "4b7ce53f0cc8ac159126fdda7d45e30c540be2d8/data/01_raw/kvlcc2_hsva/raw_data"
    ),
    folder="kvlcc2/hsva",
    citation="HSVA 2006, free-running model tests of KVLCC2; SIMMAN 2008 workshop",
    runs=dict(_hsva_run(stem, sha256) for stem, sha256 in HSVA_SHA256.items()),
    read=_read_hsva,
    notes="model scale, 7 m; measured rudder; the execute lags the nominal heading by up to 2.5 deg",
    positive_rudder="port",
    vessel="kvlcc2-l7",
)
