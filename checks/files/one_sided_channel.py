"""Check `one_sided_channel`."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.signals import sensor_sd
from ...models.linear_algebra import lstsq
from ..base import FileCheck
from ..fault import Fault, exact
from ..integrity.ratios import TURN, over_windows

if TYPE_CHECKING:
    from ...datasets.record import Record

CHANNEL = "yaw_rate_rad_s"
WHOLE, LOST = 1.3, 0.5
"""Factor by which the scale of the right side may differ from one, and scale below which the other side is wrong."""
TURNS, USUAL = 0.4, 0.95
"""Share of the usual turn in a window, which is this quantile of all, from which a window turns to a side."""
CLEAR = 10.0
"""Standard deviations of the heading's noise that the turn in a window must exceed."""
FEWEST, MANOEUVRES = 30, 0.1
"""Samples and windows below which nothing is compared, and share of the windows that must turn to each side."""
EXPLAINED, BETTER = 0.25, 0.5
"""Share of the yaw rate's spread that two scales may leave, and share of what one scale leaves that they may."""


class _Sides(NamedTuple):
    """Scales of the yaw rate in turns to starboard and to port."""

    starboard: float
    port: float


class OneSidedChannel(FileCheck):
    """The yaw rate is right in turns to one side, and lost, or without its sign, in turns to the other:
    recorded = s r with s = 1 for one sign of r and s < 0.5 for the other, as the heading shows."""

    id = "one_sided_channel"
    rank = 20
    separate_by = "the raw output of the sensor, and the type of number (signed or unsigned) that the logger reads"

    def find(self, record: Record) -> list[Fault]:
        sides = _sides(record) if record.has(*TURN) else None
        if sides is None:
            return []
        (low, wrong), (high, right) = sorted(zip(sides, sides._fields, strict=True))
        if not (low < LOST and 1.0 / WHOLE < high < WHOLE):
            return []
        how = "its sign is lost" if low < -LOST else "one side of it is lost"
        said = (
            f"{CHANNEL} is {low:.3g} times what the heading shows in turns to {wrong}, and {high:.3g} times in turns "
            f"to {right}: {how}; leave the column out, the heading remains, or export it again as a signed number"
        )
        sizes = (exact("starboard", sides.starboard, "1"), exact("port", sides.port, "1"))
        return [Fault(said, (CHANNEL,), sizes, blanks=((CHANNEL, 0, record.n),))]


def _sides(record: Record) -> _Sides | None:
    """Scales of the yaw rate to each side, where they describe it and one scale does not; None else.

    An offset is estimated along: it, too, makes turns to one side too small.
    """
    heading, rate = record.heading_unwrapped(), record.column(CHANNEL)
    known = np.isfinite(heading) & np.isfinite(rate)
    if known.sum() < FEWEST:
        return None
    turned, given = over_windows(record.time_s[known], heading[known], rate[known])
    if turned.size < FEWEST:
        return None
    least = max(TURNS * float(np.quantile(np.abs(turned), USUAL)), CLEAR * np.sqrt(2.0) * sensor_sd(heading[known]))
    if min(np.mean(turned > least), np.mean(turned < -least)) < MANOEUVRES:
        return None
    clear = np.abs(turned) > least
    return _fitted(turned[clear], given[clear])


def _fitted(turned: np.ndarray, given: np.ndarray) -> _Sides | None:
    """Scales of the changes (M,) that the yaw rate gives over those of the heading, rad."""
    offset = np.ones(turned.size)
    one = np.stack([turned, offset], axis=1)
    two = np.stack([np.maximum(turned, 0.0), np.minimum(turned, 0.0), offset], axis=1)
    left, before = (float(np.std(given - x @ lstsq(x, given))) for x in (two, one))
    if not left < min(EXPLAINED * float(np.std(given)), BETTER * before):
        return None
    starboard, port, _ = lstsq(two, given).tolist()
    return _Sides(starboard, port)
