"""Checks of channels that are made from each other, and of a rudder that carries another sensor's noise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import RUDDERS, TRACK, TURN
from ...datasets.geometry import velocity_over_ground
from ...datasets.signals import bridged, integral, white_noise
from ..base import Fault, FileCheck, exact
from ..integrity.runs import never_changes
from .repeats import stamps

if TYPE_CHECKING:
    from ...datasets.record import Record

SHARED = 0.3
"""Correlation from which noise is said to be shared."""
CLEAR = 6.0
"""The same in standard deviations."""
DEPENDENT = 2.31
"""Variance of the correlation of two white noises' third differences, times their number."""
BESIDE = -0.75
"""Correlation of third differences of white noise a sample apart: what two series share at one instant has it too."""
UNLIKE = 0.15
"""Share of the correlation by which that a sample apart may differ from it, beyond three standard deviations."""
MOST = 0.9
"""Share of the samples in which a rate has to be near a difference quotient: in coarse steps both are often equal."""
WANDER = 0.2
"""Share of the wander that independent noise would give, below which one channel is made from the other."""


def shared_noise(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Correlation at lag zero of the noise of two series (N,), and the same in standard deviations; 0 where either
    shows no noise, or where they do not go together at one instant.

    A ship that answers its rudder, or a helmsman who answers the sea, within a sampling step correlates them before or
    after it as well.
    """
    if not (white_noise(one) > 0.0 and white_noise(other) > 0.0):
        return 0.0, 0.0
    a, b = np.diff(one, 3), np.diff(other, 3)
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 30:
        return 0.0, 0.0
    a, b = _clipped(a, known), _clipped(b, known)
    size = float(np.sqrt((a @ a) * (b @ b)))
    if not size > 0.0:
        return 0.0, 0.0
    before, correlation, after = float(a[1:] @ b[:-1]) / size, float(a @ b) / size, float(a[:-1] @ b[1:]) / size
    deviation = float(np.sqrt(DEPENDENT / known.sum()))
    slack = UNLIKE * abs(correlation) + 3.0 * deviation
    at_once = abs(correlation) > max(abs(before), abs(after))
    if not at_once or any(abs(c - BESIDE * correlation) > slack for c in (before, after)):
        return 0.0, 0.0
    return correlation, correlation / deviation


def _clipped(x: np.ndarray, known: np.ndarray) -> np.ndarray:
    """A series (N,) less its mean, outliers clipped, zero where it is not known."""
    limit = 4.0 * 1.4826 * float(np.median(np.abs(x[known])))
    clipped = np.clip(x, -limit, limit)
    return np.where(known, clipped - float(np.mean(clipped[known])), 0.0)


def rate_is_derived(values: np.ndarray, rate: np.ndarray, time: np.ndarray) -> str | None:
    """Whether a rate (N,) was made by differencing (and smoothing) values (N,): the reason; None where it was not.

    It is where it equals a difference quotient better than the values' noise allows, or where its integral wanders
    from the values far less than the rate's own noise would make it.
    """
    known = np.isfinite(values) & np.isfinite(rate)
    if known.sum() < 60:
        return None
    values, rate = bridged(values, time), bridged(rate, time)
    dt = float(np.median(np.diff(time)))
    noise, own = white_noise(values), white_noise(rate)
    quotients = {
        "central": (np.gradient(values, time)[1:-1], rate[1:-1]),
        "backward": (np.diff(values) / np.diff(time), rate[1:]),
        "forward": (np.diff(values) / np.diff(time), rate[:-1]),
    }
    for name, (quotient, own_rate) in quotients.items():
        half, most = np.quantile(np.abs(quotient - own_rate), [0.5, MOST]).tolist()
        off = 1.4826 * half
        if noise > 0.0 and off < 0.1 * noise / dt and most < noise / dt:
            return (
                f"it equals the {name} difference quotient to {off:.2g}, though noise would make that {noise / dt:.2g}"
            )
    if not own > 0.0:
        return None
    left = values - integral(rate, time)
    lag = max(values.size // 8, 10)
    wander = float(np.sqrt(np.mean((left[lag:] - left[:-lag]) ** 2)))
    expected = own * dt * np.sqrt(lag)
    floor = 2.0 * noise
    if wander < WANDER * expected and floor < expected:
        return f"its integral strays by {wander:.2g}, where independent noise of its size would give {expected:.2g}"
    return None


def equal_columns(record: Record) -> list[tuple[str, str]]:
    """Pairs of changing columns that are equal, or each other's negative, in every known sample."""
    names = [n for n in record.channels if np.isfinite(record.column(n)).sum() > 20]
    names = [n for n in names if not never_changes(record.column(n))]
    pairs = []
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            x, y = record.column(a), record.column(b)
            known = np.isfinite(x) & np.isfinite(y)
            if known.sum() > 20 and (np.array_equal(x[known], y[known]) or np.array_equal(x[known], -y[known])):
                pairs.append((a, b))
    return pairs


MISSING = 0.02
"""Share of missing rows from which nothing is said of the rest."""


class DerivedChannel(FileCheck):
    """A channel that was computed from another one in the record: the two cannot check each other."""

    id, rank = "derived_channel", 70
    separate_by = "the raw output of each sensor"

    def find(self, record: Record) -> list[Fault]:
        faults = [Fault(f"{a} and {b} hold the same numbers", (a, b), material=False) for a, b in equal_columns(record)]
        if record.n < 3 or stamps(record.time_s).missing > MISSING * record.n:
            return faults  # noise over steps that differ is not comparable
        if record.has(*TURN):
            why = rate_is_derived(record.heading_unwrapped(), record.column(TURN[1]), record.time_s)
            if why:
                faults.append(Fault(f"yaw_rate_rad_s is made from heading_rad: {why}", TURN))
        if record.has(*TRACK):
            velocity = velocity_over_ground(record)
            whys = [
                rate_is_derived(record.column(name), rate, record.time_s)
                for name, rate in zip(TRACK[3:], (velocity.real, velocity.imag), strict=True)
            ]
            if all(whys):
                faults.append(Fault(f"surge_m_s and sway_m_s are made from the positions: {whys[0]}", TRACK[1:]))
        return faults


class RudderFromSensor(FileCheck):
    """The rudder column carries another sensor's noise at the same instant: it was computed from that sensor (an
    autopilot's order), so that no rudder cause can be named."""

    id, rank = "rudder_from_sensor", 80
    separate_by = "a rudder angle feedback, or a rudder order that does not depend on the sensors"

    def find(self, record: Record) -> list[Fault]:
        faults = []
        for rudder in (name for name in RUDDERS if record.has(name)):
            for name in ("yaw_rate_rad_s", "heading_rad"):
                if not record.has(name):
                    continue
                other = record.continuous(name)
                correlation, z = shared_noise(record.column(rudder), other)
                if abs(correlation) > SHARED and abs(z) > CLEAR:
                    said = (
                        f"the noise of {rudder} goes with that of {name} at lag zero (correlation {correlation:.2f}, "
                        f"z = {z:.0f})"
                    )
                    faults.append(Fault(said, (rudder, name), (exact("correlation", correlation, "1"),)))
        return faults
