"""Check `rudder_response`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import Fault, FileCheck, exact
from ..integrity.averages import swing
from ..integrity.steering import motion_shows, response

if TYPE_CHECKING:
    from ...datasets.record import Record

CLEAR = 8.0
"""Standard deviations by which the rudder must act at the lag that fits best."""
BETTER, UNLIKE = 0.5, 0.75
"""Share of what is left at lag zero that may be left at the best lag, and the most that the rudder explains at zero."""
EARLY = 0.035
"""Share of the record by which the motion may come after its order."""
STEPS = 3
"""Steps of the means by which the motion must come before its order."""
FAINT, NONE = 5.0, 0.25
"""Standard deviations, and share of the yaw acceleration, below which the rudder does nothing at any lag."""
FOLLOWED = 0.22
"""Correlation of the yaw rate with an earlier rudder from which it follows it, whatever waves do to its rate."""
SMALL = float(np.deg2rad(1.2))
"""Rudder angle, rad, that makes no manoeuvre."""
TURN = 20.0
"""Times the rudder's angle by which the heading swings, from which the rudder cannot have been so small."""


class RudderResponse(FileCheck):
    """The yaw rate does not answer the rudder, or answers before it: r' = a r + c r |r| + b delta(t - lag) + d has no
    b, or a negative lag; or the ship turns by far more than so small an angle makes it."""

    id, where, rank, unit = "rudder_response", "rudder", 110, "s"
    separate_by = "the clocks of the steering gear and of the yaw-rate sensor, and the list of channels"

    def find(self, record: Record) -> list[Fault]:
        if not (record.has("rudder_rad") or record.has("rudder_command_rad")):
            return []
        rudder = record.rudder()
        known = rudder[np.isfinite(rudder)]
        most = float(np.max(np.abs(known))) if known.size else 0.0
        name = "rudder_rad" if record.has("rudder_rad") else "rudder_command_rad"
        if most < SMALL:
            return [self._small(record, name, most)]
        return self._answer(record, name) if np.ptp(known) > 0.0 else []

    def _small(self, record: Record, name: str, most: float) -> Fault:
        """An angle that makes no manoeuvre: radians under a name in degrees, where the ship turns all the same."""
        turned = swing(record)
        said = f"{name} never exceeds {np.rad2deg(most):.2g} deg: no manoeuvre"
        much = turned > max(TURN * most, SMALL)
        if much:
            said += f", though the heading swings by {np.rad2deg(turned):.3g} deg; radians under a name in degrees?"
        return Fault(said, (name,), (exact("largest", most, "rad"),), much, standing=much)

    def _answer(self, record: Record, name: str) -> list[Fault]:
        answer = response([record])
        if answer is None or not motion_shows(record):
            return []
        better = answer.share < UNLIKE and 1.0 - answer.share_best < BETTER * (1.0 - answer.share)
        clear, said = better and abs(answer.z_best) > CLEAR, ""
        if clear and answer.z * answer.z_best > 0.0 and answer.lag_s > EARLY * float(np.ptp(record.time_s)):
            said = (
                f"the yaw rate answers {name} only {answer.lag_s:.3g} s later, of which it then explains "
                f"{100.0 * answer.share_best:.0f} %: a late clock, or orders that were not carried out"
            )
        elif clear and answer.lag_s < -STEPS * answer.step_s:
            said = (
                f"the yaw rate comes {-answer.lag_s:.3g} s before {name}, of which it explains "
                f"{100.0 * answer.share_best:.0f} % there and {100.0 * answer.share:.0f} % at its own time: "
                "a late clock"
            )
        if said:
            return [Fault(said, (name, "yaw_rate_rad_s"), (exact("lag", answer.lag_s, "s"),), standing=True)]
        if abs(answer.z_best) < FAINT and answer.share_best < NONE and not _followed(record):
            share = answer.share_best
            said = f"{name} explains {100.0 * share:.1f} % of the yaw acceleration: it is not what turns the ship"
            return [Fault(said, (name,), (exact("share", share, "1"),), standing=True)]
        return []


def _followed(record: Record) -> bool:
    """Whether the yaw rate goes with the rudder some time before, by up to a quarter of the record."""
    if not record.has("yaw_rate_rad_s"):
        return False
    x, y = record.rudder(), record.column("yaw_rate_rad_s")
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known] - np.mean(x[known]), y[known] - np.mean(y[known])
    lags = range(0, max(x.size // 4, 1), max(x.size // 200, 1))
    size = max(float(np.std(x) * np.std(y)) * x.size, 1e-300)
    return any(abs(float(x[: x.size - k] @ y[k:])) > FOLLOWED * size for k in lags)
