"""How the yaw rate answers the rudder, without a hull model: how clearly, to which side, and how late.

In every hull the rudder acts on the yaw acceleration: r' = a r + c r |r| + b delta(t - lag) + d, at any speed.  A
rudder that was recorded late shows a motion that comes before its order, and no hull can do that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import RUDDERS
from ...datasets.signals import sensor_sd
from ...models.linear_algebra import lstsq, pinv
from ..base import Fault, FileCheck, exact
from ..integrity.averages import swing

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
FOLLOWED, CLOSE, STEADY = 0.22, 0.7, 0.95
"""Correlation of the yaw rate with an earlier rudder from which it follows it, whatever waves do to its rate: of
samples, and of few means; and of means that are not taken about theirs from which it is in proportion to it."""
SMALL = float(np.deg2rad(1.2))
"""Rudder angle, rad, that makes no manoeuvre."""
TURN = 20.0
"""Times the rudder's angle by which the heading swings, from which the rudder cannot have been so small."""
MEANS, COARSER = 200, (100, 50)
"""Means over equal stretches of a record, of which slopes are taken; and fewer, over which waves cancel."""
FEWEST = 20
"""Samples with yaw rate and rudder below which a record is not used."""
SHOWN = 3.0
"""Times its noise that the slope of the yaw rate must be for it to say anything of a rudder that does nothing."""
FARTHEST = 0.1
"""Share of a record's duration up to which lags are tried, to each side."""


class RudderResponse(FileCheck):
    """The yaw rate does not answer the rudder, or answers before it: r' = a r + c r |r| + b delta(t - lag) + d has no
    b, or a negative lag; or the ship turns by far more than so small an angle makes it."""

    id, where, rank, unit = "rudder_response", "rudder", 110, "s"
    separate_by = "the clocks of the steering gear and of the yaw-rate sensor, and the list of channels"

    def find(self, record: Record) -> list[Fault]:
        if not any(map(record.has, RUDDERS)):
            return []
        rudder = record.rudder()
        known = rudder[np.isfinite(rudder)]
        most = float(np.max(np.abs(known))) if known.size else 0.0
        name = next(filter(record.has, RUDDERS))
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
        means = means_of(record)
        if means is None or not shows_motion(means):
            return []
        answer = response(means)
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
        faint = abs(answer.z_best) < FAINT and answer.share_best < NONE
        if faint and not (_followed(record) or any(_shown_by(record, count) for count in COARSER)):
            share = answer.share_best
            said = f"{name} explains {100.0 * share:.1f} % of the yaw acceleration: it is not what turns the ship"
            return [Fault(said, (name,), (exact("share", share, "1"),), standing=True)]
        return []


def _shown_by(record: Record, count: int) -> bool:
    """Whether so many means show clearly that the yaw rate answers the rudder, goes with it, or is in proportion to it,
    as in a steady turn."""
    means = means_of(record, count)
    if means is None:
        return False
    if abs(response(means).z_best) > FAINT or _goes_with(means.rudder, means.rate) > CLOSE:
        return True
    sizes = float(np.linalg.norm(means.rudder) * np.linalg.norm(means.rate))
    return abs(float(means.rudder @ means.rate)) > STEADY * sizes > 0.0


def _followed(record: Record) -> bool:
    """Whether the yaw rate goes with the rudder some time before."""
    if not record.has("yaw_rate_rad_s"):
        return False
    x, y = record.rudder(), record.column("yaw_rate_rad_s")
    known = np.isfinite(x) & np.isfinite(y)
    return _goes_with(x[known], y[known]) > FOLLOWED


def _goes_with(rudder: np.ndarray, rate: np.ndarray) -> float:
    """Largest correlation of a yaw rate (N,) with the rudder (N,) by up to a quarter of the record before."""
    x, y = rudder - np.mean(rudder), rate - np.mean(rate)
    lags = range(0, max(x.size // 4, 1), max(x.size // 200, 1))
    size = max(float(np.std(x) * np.std(y)) * x.size, 1e-300)
    return max(abs(float(x[: x.size - k] @ y[k:])) for k in lags) / size


# ---- the answer
class Response(NamedTuple):
    """b in its standard deviations (starboard positive), share of the remaining square that the rudder takes off, of
    the record as it is; and the same at the lag (s) from order to motion that fits best."""

    z: float
    share: float
    lag_s: float
    z_best: float
    share_best: float
    step_s: float


class Means(NamedTuple):
    """Means of a record over equal stretches: slopes of the yaw rate (M,), yaw rate and rudder between them (M,), the
    step, s, and the standard deviation of the slopes that the noise of the sensor makes."""

    slope: np.ndarray
    rate: np.ndarray
    rudder: np.ndarray
    step_s: float
    noise: float


def response(means: Means) -> Response:
    """The answer of the yaw rate to the rudder."""
    z, share = fitted(means, 0)
    farthest = max(int(FARTHEST * means.slope.size), 1)
    tried = {k: fitted(means, k) for k in range(-farthest, farthest + 1)}
    best = max(tried, key=lambda k: tried[k][1])
    return Response(z, share, best * means.step_s, *tried[best], means.step_s)


def means_of(record: Record, most: int = MEANS) -> Means | None:
    """Means of yaw rate (or of the heading's slope) and rudder over at most so many equal stretches of the record; None
    of one that has too few samples with both."""
    time = record.time_s
    if record.has("yaw_rate_rad_s"):
        rate = record.column("yaw_rate_rad_s")
    elif record.has("heading_rad"):
        rate = np.gradient(record.heading_unwrapped(), time)
    else:
        return None
    rudder, noise = record.rudder(), sensor_sd(rate)
    known = np.isfinite(rate) & np.isfinite(rudder)
    if known.sum() < FEWEST:
        return None
    count = min(most, int(known.sum()) // 2)
    rate = np.interp(time, time[known], median_of_three(rate[known]))
    rudder = np.interp(time, time[known], rudder[known])
    even = np.linspace(time[0], time[-1], count * max(record.n // count, 1) + 1)[:-1]
    means = [
        np.interp(even, t, a).reshape(count, -1).mean(axis=1) for t, a in ((time, rate), (time[known], rudder[known]))
    ]
    step = float((time[-1] - time[0]) / count)
    of_rate, of_rudder = (0.5 * (a[1:] + a[:-1]) for a in means)
    noise *= np.sqrt(2.0 / max(record.n // count, 1)) / step
    return Means(np.diff(means[0]) / step, of_rate, of_rudder, step, float(noise))


def median_of_three(values: np.ndarray) -> np.ndarray:
    """Values (N,) without single ones that stand out."""
    inner = np.median(np.stack([values[:-2], values[1:-1], values[2:]]), axis=0)
    return np.concatenate([values[:1], inner, values[-1:]])


def fitted(means: Means, shift: int) -> tuple[float, float]:
    """z and share of the rudder shifted by so many steps, beside a constant: columns are without their means (Frisch
    and Waugh 1933)."""
    m = means.slope.size
    own = slice(max(shift, 0), m + min(shift, 0))
    earlier = slice(max(-shift, 0), m - max(shift, 0))
    r = means.rate[own]
    columns = np.column_stack([means.rudder[earlier], r, r * np.abs(r), means.slope[own]])
    columns -= columns.mean(axis=0)
    phi, y = columns[:, :3] / np.maximum(np.linalg.norm(columns[:, :3], axis=0), 1e-300), columns[:, 3]
    b = lstsq(phi, y)
    error = y - phi @ b
    without = y - phi[:, 1:] @ lstsq(phi[:, 1:], y)
    inverse, free = pinv(phi.T @ phi), max(y.size - phi.shape[1] - 1, 1)
    sd = float(np.sqrt(max(inverse[0, 0], 0.0) * (error @ error) / free))
    share = 1.0 - float(error @ error) / max(float(without @ without), 1e-300)
    return float(b[0] / max(sd, 1e-300)), share


def shows_motion(means: Means) -> bool:
    """Whether what the yaw rate leaves of its own slopes stands far above what the noise of its sensor makes them."""
    r = means.rate / max(float(np.max(np.abs(means.rate))), 1e-300)
    phi = np.column_stack([r, r * np.abs(r), np.ones(r.size)])
    left = means.slope - phi @ lstsq(phi, means.slope)
    return float(np.std(left)) > SHOWN * means.noise
