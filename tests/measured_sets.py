"""Measured sets of the development data that the package does not read itself, as records."""

import numpy as np

from helmbench.datasets.measured import data_dir
from helmbench.datasets.record import Record, RecordMeta

SCALE = 320.0 / 7.0
"""Full scale over model scale of the KVLCC2 runs."""
MARIN_STEP_S = 0.135264
"""Sampling step at full scale: the file's stamps have three digits and repeat."""


def marin(names=("zz_-10", "zz_-20", "zz_10", "zz_20")):
    """KVLCC2 free-running at MARIN, at model scale; velocities turned into body axes."""
    folder = data_dir() / "kvlcc2" / "marin"
    return [_marin(folder / f"MARIN_FREE_KVLCC2_{name}_m.dat", name) for name in names]


def _marin(path, name):
    lines = (line.split() for line in path.read_text(encoding="utf-8").splitlines()[3:])
    rows = np.array([[float(x) for x in line] for line in lines if len(line) == 11])
    _, x, y, _, psi, north_rate, east_rate, _, rate, rudder, _ = rows.T
    psi, rate, rudder, root = np.deg2rad(psi), np.deg2rad(rate), np.deg2rad(rudder), np.sqrt(SCALE)
    channels = {
        "rudder_rad": rudder,
        "heading_rad": psi,
        "yaw_rate_rad_s": rate * root,
        "surge_m_s": (north_rate * np.cos(psi) + east_rate * np.sin(psi)) / root,
        "sway_m_s": (-north_rate * np.sin(psi) + east_rate * np.cos(psi)) / root,
        "north_m": x / SCALE,
        "east_m": y / SCALE,
    }
    time = MARIN_STEP_S * np.arange(len(rows)) / root
    return Record(time, channels, name, RecordMeta(positive_rudder="port"))


def esso_osaka():
    """The 3 m Esso Osaka model in a pond, all runs."""
    return [_esso(path) for path in sorted((data_dir() / "esso_osaka").glob("*.csv"))]


def _esso(path):
    rows = np.genfromtxt(path, delimiter=",", skip_header=1)
    time, north, surge, east, sway, psi, rate, _, rudder = rows[np.isfinite(rows[:, 0])].T[:9]
    channels = {
        "rudder_command_rad": rudder,
        "heading_rad": psi,
        "yaw_rate_rad_s": rate,
        "surge_m_s": surge,
        "sway_m_s": sway,
        "north_m": north,
        "east_m": east,
    }
    return Record(time, channels, path.stem, RecordMeta(positive_rudder="starboard"))


def blueboat():
    """Files of the BlueBoat runs, in the record format."""
    return sorted((data_dir() / "blueboat").glob("*.csv"))
