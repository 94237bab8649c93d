"""Set `esso-osaka`: a 3 m model of Esso Osaka in a pond, with measured wind (Wakita et al. 2022)."""

from __future__ import annotations

import numpy as np

from .base import Columns, Dataset, MeasuredRun

FOLDERS = {"zigzag": "zigzag", "turn": "turning", "random": "random"}
"""Kind of run -> folder in which the set publishes it."""


def _read(content: bytes) -> Columns:
    """One run.

    Columns (N, 13): time s; x m, u m/s, y m, v m/s at midship; heading rad, yaw rate rad/s; propeller 1/s; rudder rad
    (the order, positive to starboard); speed m/s and direction rad of the relative and of the true wind.
    """
    lines = [line for line in content.decode("utf-8-sig").splitlines()[1:] if line.strip(", ")]
    rows = np.loadtxt(lines, delimiter=",")
    time, north, surge, east, sway, heading, yaw_rate, turns, rudder, _, _, wind, wind_from = rows.T
    channels = {
        "rudder_command_rad": rudder,
        "propeller_rps": turns,
        "heading_rad": heading,
        "yaw_rate_rad_s": yaw_rate,
        "surge_m_s": surge,
        "sway_m_s": sway,
        "north_m": north,
        "east_m": east,
        "wind_speed_m_s": wind,
        "wind_direction_rad": wind_from,
    }
    return time, channels


SHA256 = {
    "random_31-Jul-2020_14_52_18": "a28c7b140a499a9d8c2c53d958320d4ad71233b7f6b2195f83fb76e9f16e87cc",
    "turn_14-Oct-2020_14_17_39": "9e1062eee2ede637f199dd83f8380be1cea746be69d0df5d7ece6d6683ffacee",
    "turn_14-Oct-2020_14_56_07": "d65279df69e217b72ab4249ccad5565425cfbc3e58dc507ce3fe149bb8cbbe09",
    "zigzag_31-Jul-2020_13_42_53": "17eef92785876f90d15bdbce18e381b3afed3f032bacdff4f702e6ab5f1d7ed7",
    "zigzag_31-Jul-2020_13_50_28": "e04f52593cc350281dc2d0b39750a48253fff9e35b3be11d28fc8fa157bbdffa",
    "zigzag_31-Jul-2020_13_57_45": "6047e035a67745103aa56924e500c3eeb4486f82476e6933e563ca9589db4b68",
    "zigzag_31-Jul-2020_14_03_39": "d6b7e81950d278c77b21f05f58c8b67a86a1e0f6d43ec57781bb8b9620e01480",
    "zigzag_31-Jul-2020_14_10_05": "b59c883731ee5f32ef896c80abf11ade212b815001e32d7b2c109d0bd9e27ed2",
}
ESSO_OSAKA = Dataset(
    url=("https://raw.githubusercontent.com/NAOE-5thLab/FRT-DS-ESSO/e694dfd62932bff755f3bc975b5863d649023bc0/data"),
    folder="esso_osaka",
    citation="Wakita et al. 2022, doi 10.1007/s00773-021-00867-1; free-running tests of a 3 m Esso Osaka model",
    runs={
        stem: MeasuredRun(f"{stem}.csv", sha256, stem.partition("_")[0], FOLDERS[stem.partition("_")[0]])
        for stem, sha256 in SHA256.items()
    },
    read=_read,
    notes="3 m model, free running from rest in a pond; the rudder is the order",
    positive_rudder="starboard",
    vessel="esso-osaka-l3",
    licence="CC BY-NC 4.0",
    known="velocities and heading lag the positions by about .93 s; positions sometimes freeze",
)
