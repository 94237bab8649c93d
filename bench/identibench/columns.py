"""What the columns of identibench's files mean as channels of a record.

Columns under helmbench's own names (`datasets.columns`) mean what they mean there.  The others are those of
identibench's ship set, a simulated patrol ship in wind and waves: Baier & Staab 2022, doi 10.18419/darus-2905.

Known, from the authors' own propulsion model (github.com/AlexandraBaier/deepsysid, models/hybrid/physical.py) and
metric (metrics/trajectory.py): n is in 1/min and the same for both propellers, deltal and deltar are the angles of the
left and the right rudder in rad, u and v are m/s, p and r rad/s and phi rad in body axes; the step is 1 s.

Assumed: a positive rudder steers to port, since there a positive angle pushes the stern to the positive side of y, 25 m
behind the centre of gravity.  One rudder stands for both, at their mean angle.  Vw is in m/s.  alpha_x and alpha_y are
cosine and sine of the wind's angle of attack; which of the two is which does not matter here (`method`).  They are no
channel: no record of the set has a heading, so that nothing says where the wind comes from.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...datasets.columns import CANONICAL
from ...datasets.record import Record, RecordMeta
from ...models.errors import BadInput

SHIP_INPUTS = ("n", "deltal", "deltar", "Vw")
SHIP_OUTPUTS = ("alpha_x", "alpha_y", "u", "v", "p", "r", "phi")
SHIP_STEP_S = 1.0
SHIP_POSITIVE_RUDDER = "port"
WIND_ANGLE = ("alpha_x", "alpha_y")
RATE = "fs"
"""Attribute of a file: samples in a second."""
SIDE = "positive_rudder"
"""Attribute of a file that `export_problems` wrote."""

MEANINGS: Mapping[str, tuple[str, float]] = {
    "n": ("propeller_rps", 1.0 / 60.0),
    "deltal": ("rudder_rad", 0.5),
    "deltar": ("rudder_rad", 0.5),
    "Vw": ("wind_speed_m_s", 1.0),
    "u": ("surge_m_s", 1.0),
    "v": ("sway_m_s", 1.0),
    "p": ("roll_rate_rad_s", 1.0),
    "r": ("yaw_rate_rad_s", 1.0),
    "phi": ("roll_rad", 1.0),
    **{name: (name, 1.0) for name in CANONICAL if name != "time_s"},
}
"""Column -> the channel to which it adds, and its factor."""


def check_columns(names: Sequence[str]) -> None:
    """BadInput for a column of which nothing is known here."""
    unknown = [name for name in names if name not in MEANINGS and name not in WIND_ANGLE]
    if unknown:
        hint = "known are the columns of identibench's ship set and those of helmbench's records"
        raise BadInput("a column that helmbench cannot read", column=unknown[0], hint=hint)


def step_of(attributes: Mapping[str, object], names: Sequence[str]) -> float:
    """Step of a file, s: from its attribute `fs`; 1 s for the ship set, whose files have none."""
    rate = attributes.get(RATE)
    if rate is not None:
        return 1.0 / float(np.asarray(rate).item())
    if set(names) <= {*SHIP_INPUTS, *SHIP_OUTPUTS}:
        return SHIP_STEP_S
    raise BadInput(f"a file has no attribute {RATE}", hint="it says how many samples a second the file has")


def side_of(attributes: Mapping[str, object], names: Sequence[str]) -> str | None:
    """The side to which a positive rudder steers, as the file says it or as the ship set has it; None: not known."""
    side = attributes.get(SIDE, SHIP_POSITIVE_RUDDER if set(names) & {"deltal", "deltar"} else None)
    return None if side is None else str(side)


def record_of(columns: Mapping[str, np.ndarray], step_s: float, name: str, meta: RecordMeta) -> Record:
    """Columns (N,) of a file as a record; columns of the wind's angle are left out."""
    channels: dict[str, np.ndarray] = {}
    for column, values in columns.items():
        if column in MEANINGS:
            channel, factor = MEANINGS[column]
            channels[channel] = channels.get(channel, 0.0) + factor * np.asarray(values, float)
    return Record(step_s * np.arange(len(next(iter(columns.values())))), channels, name, meta)
