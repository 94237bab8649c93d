"""Channels that are made from each other, and a rudder that carries another sensor's noise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import bridged, integral, white_noise

if TYPE_CHECKING:
    from ...datasets.record import Record

SHARED = 0.3
"""Correlation from which noise is said to be shared."""
CLEAR = 6.0
"""The same in standard deviations."""
DEPENDENT = 2.31
"""Variance of the correlation of two white noises' third differences, times their number."""
WANDER = 0.2
"""Share of the wander that independent noise would give, below which one channel is made from the other."""


def shared_noise(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Correlation at lag zero of the noise of two series (N,), and the same in standard deviations; 0 where either
    shows no noise."""
    if not (white_noise(one) > 0.0 and white_noise(other) > 0.0):
        return 0.0, 0.0
    a, b = np.diff(one, 3), np.diff(other, 3)
    known = np.isfinite(a) & np.isfinite(b)
    a, b = _clipped(a[known]), _clipped(b[known])
    if a.size < 30 or not (a.std() > 0.0 and b.std() > 0.0):
        return 0.0, 0.0
    correlation = float(np.corrcoef(a, b)[0, 1])
    return correlation, correlation * np.sqrt(a.size / DEPENDENT)


def _clipped(x: np.ndarray) -> np.ndarray:
    limit = 4.0 * 1.4826 * float(np.median(np.abs(x)))
    return np.clip(x, -limit, limit)


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
    for name, (quotient, given) in quotients.items():
        off = 1.4826 * float(np.median(np.abs(quotient - given)))
        if noise > 0.0 and off < 0.1 * noise / dt:
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


def earth_velocities(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Velocities north and east (N,) from heading, surge and sway."""
    psi, u, v = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    return u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)


def equal_columns(record: Record) -> list[tuple[str, str]]:
    """Pairs of changing columns that are equal, or each other's negative, in every known sample."""
    names = [n for n in record.channels if np.isfinite(record.column(n)).sum() > 20]
    names = [n for n in names if np.nanmin(record.column(n)) < np.nanmax(record.column(n))]
    pairs = []
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            x, y = record.column(a), record.column(b)
            known = np.isfinite(x) & np.isfinite(y)
            if known.sum() > 20 and (np.array_equal(x[known], y[known]) or np.array_equal(x[known], -y[known])):
                pairs.append((a, b))
    return pairs
