"""Files as identibench's ship set has them, made of simulated runs of another ship."""

import h5py
import numpy as np

import helmbench

FIXED = {"n": 60.0, "Vw": 8.0, "p": 0.0, "phi": 0.02}
MANOEUVRES = {
    "train": ("zigzag:20/20", "prbs:20deg/40s"),
    "valid": ("zigzag:15/15",),
    "test": ("zigzag:10/10", "turn:20"),
    "test_ood": ("turn:35:port",),
}


def columns_of(record, direction=0.7, sign=1.0):
    """Column -> (N,): both rudders apart by .1 rad, the wind from one direction over the earth."""
    record = record.turned("port")
    alpha = sign * (direction - record.column("heading_rad"))
    rudder = record.rudder()
    fixed = {name: np.full(record.n, value) for name, value in FIXED.items()}
    return fixed | {
        "deltal": rudder + 0.05,
        "deltar": rudder - 0.05,
        "alpha_x": np.cos(alpha),
        "alpha_y": np.sin(alpha),
        "u": record.column("surge_m_s"),
        "v": record.column("sway_m_s"),
        "r": record.column("yaw_rate_rad_s"),
        "time": record.time_s,
    }


def write_columns(path, columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file.create_dataset(name, data=np.asarray(values), dtype="f4")


def write_ship(root, sign=1.0):
    """The set below a root of identibench's data, as if identibench had prepared it."""
    for part, texts in MANOEUVRES.items():
        for number, text in enumerate(texts):
            record = helmbench.simulate("mariner", text, dt_s=1.0, duration_s=420.0)
            write_columns(root / "ship" / part / f"{part}_{number}.hdf5", columns_of(record, sign=sign))
    (root / "ship" / ".prepared").write_text("1")
    return root
