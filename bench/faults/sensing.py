"""What sensors make of a dense run: samples, noise, gaps."""

from __future__ import annotations

import numpy as np

from .effects.sensors import ATTITUDE, VELOCITY
from .ships import TrueShip
from .simulator import DenseRun

GAP = 10
"""Samples of a gap."""
CHANNELS = ("rudder_rad", *ATTITUDE, *VELOCITY, "north_m", "east_m")
RESPONSE_CHANNELS = ("rudder_rad", *ATTITUDE, "surge_m_s")
STATE = {"surge_m_s": 0, "sway_m_s": 1, "yaw_rate_rad_s": 2, "north_m": 3, "east_m": 4, "heading_rad": 5}
#: Standard deviations of a full-scale ship's sensors; a model's are in proportion (Froude), but for angles.
NOISE = {
    "rudder_rad": np.deg2rad(0.05),
    "heading_rad": np.deg2rad(0.1),
    "yaw_rate_rad_s": np.deg2rad(0.02),
    "surge_m_s": 0.02,
    "sway_m_s": 0.02,
    "north_m": 0.5,
    "east_m": 0.5,
}


def noise_sd(ship: TrueShip, level: float = 1.0) -> dict[str, float]:
    """Channel -> standard deviation of its white noise; 0 for `level` 0."""
    clock = ship.clock
    power = {"yaw_rate_rad_s": -1, "surge_m_s": 1, "sway_m_s": 1, "north_m": 2, "east_m": 2}
    return {name: level * sd * clock ** power.get(name, 0) for name, sd in NOISE.items()}


def coloured(rng: np.random.Generator, size: int, dt_s: float, time_s: float) -> np.ndarray:
    """Noise (size,) of unit variance with an exponential memory of time_s; white for 0."""
    white = rng.standard_normal(size)
    if time_s <= 0.0:
        return white
    from scipy.signal import lfilter

    keep = float(np.exp(-dt_s / time_s))
    fresh = np.sqrt(1.0 - keep**2)
    return lfilter([fresh], [1.0, -keep], white, zi=[keep * white[0]])[0]


def sampled(run: DenseRun, channel: str, at: np.ndarray) -> np.ndarray:
    """True values of a channel at times `at`, linear on the integration grid; the first value before it."""
    if channel == "rudder_rad":
        return np.interp(at, 0.5 * run.step_s * np.arange(run.rudder.size), run.rudder)
    values = run.states[:, STATE[channel]]
    if channel in ATTITUDE:
        values = values + run.wave[:, ATTITUDE.index(channel)]
    return np.interp(at, run.time_s, values)


def with_gaps(values: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """values with about that share lost in runs of `GAP`; the first samples stay."""
    if share <= 0.0:
        return values
    starts = np.flatnonzero(rng.random(values.size) < share / GAP)
    lost = np.unique((starts[:, None] + np.arange(GAP)).ravel())
    values = values.copy()
    values[lost[(lost >= 2 * GAP) & (lost < values.size)]] = np.nan
    return values
