"""Set `blueboat`: a BlueBoat, an unmanned surface vessel of two propellers steered by their difference of force."""

from __future__ import annotations

import csv
import io

import numpy as np

from .base import Columns, Dataset, MeasuredRun

FULL_DIFFERENCE_N = 110.5
"""Difference of force between the two propellers that stands for a rudder angle of 1 rad."""
COLUMNS = (
    "time_s",
    "rudder_command_rad",
    "heading_deg",
    "yaw_rate_rad_s",
    "surge_m_s",
    "sway_m_s",
    "north_m",
    "east_m",
)
MEASURED = ("yaw", "yaw_rate", "surge", "sway", "x_ned", "y_ned")
"""Columns of the published files that are taken over: heading deg, yaw rate rad/s, speeds m/s, positions m."""


def convert(content: bytes) -> bytes:
    """The published file (columns of the logger) as a table of `COLUMNS` with seven digits.

    Raises
    ------
    KeyError, ValueError : the content is not a published file.
    """
    rows = list(csv.DictReader(io.StringIO(content.decode("utf-8"))))
    stamps_ms = np.array([float(row["original_timestamp"]) for row in rows])
    left, right = (np.array([float(row[f"{side}_force"]) for row in rows]) for side in ("left", "right"))
    taken = [np.array([float(row[name]) for row in rows]) for name in MEASURED]
    table = np.column_stack([(stamps_ms - stamps_ms[0]) / 1000.0, (left - right) / FULL_DIFFERENCE_N, *taken])
    lines = [",".join(COLUMNS), *(",".join(f"{value:.7g}" for value in row) for row in table)]
    return ("\n".join(lines) + "\n").encode("ascii")


def _read(content: bytes) -> Columns:
    """One run, from the table that `convert` makes: (N, 8) with a header."""
    time, command, heading, *rest = np.loadtxt(io.BytesIO(content), delimiter=",", skiprows=1).T
    channels = dict(zip(COLUMNS[3:], rest, strict=True))
    channels = {"rudder_command_rad": command, "heading_rad": np.unwrap(np.deg2rad(heading)), **channels}
    return time, channels


RUNS = {
    "train-0": (224, "abd567031f8c931fa012dea005cdeee826f5545909bfe69f96172240be557d4b"),
    "train-1": (225, "8a4d4740c2df4411af58ece07fbd5680fd98859b6f730428427154cb558915c3"),
    "train-2": (220, "af12ad766e08ffcb2e6bbc97a9051689cfa42bbf44484538d757b58b61fc0f1f"),
    "heldout-0": (234, "bd535e9a9700c6e9b7b3eb9b2bedfa2111f7df33855b00b3ff201064282aa886"),
}
"""Run -> number of the published file, SHA-256 of the converted table."""
BLUEBOAT = Dataset(
    url=(
        "https://raw.githubusercontent.com/jankristia/BlueBoatSystemIdentification/"
        "fd6d9f37ae138a96b7f99f836894aee28e0684a8"
    ),
    folder="blueboat",
    citation="jankristia, BlueBoatSystemIdentification; runs of a BlueBoat USV with differential thrust",
    runs={
        stem: MeasuredRun(f"{stem}.csv", sha256, "", "sorted_data", f"fixed_{number:08d}.csv")
        for stem, (number, sha256) in RUNS.items()
    },
    read=_read,
    notes=f"rudder angle = (left - right force) / {FULL_DIFFERENCE_N} N; speeds derived from the positions",
    positive_rudder="starboard",
    convert=convert,
    known="left and right are exchanged; the compass deviates by about 5 deg; surge and sway come from the positions",
)
