"""The measured motion of a record, smoothed, that forces follow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...datasets.signals import bridged, integral
from ...estimation.records.weather import WIND, flow_of
from ...models.model import ship_length_m

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model


@dataclass(frozen=True)
class Motion:
    """Motion on even times of a record, arrays (N,) in SI units.

    v and r are in the prime system, v' = v/U and r' = r L/U at the instantaneous speed U; pressure is rho/2 A U^2, N,
    A = L d where the family knows the draught d, else L^2.  Of a response model r is in rad/s, and pressure and length
    are one: moments are yaw accelerations.  sway, rate : in m/s and rad/s.  north, east : nan where no positions are
    measured.  wind_ahead, wind_across : velocity of the air against the ship, m/s, in her axes (forward, to starboard);
    nan where no wind is measured.  time_s : of the record; past_s : from its start.
    """

    time_s: np.ndarray
    speed: np.ndarray
    v: np.ndarray
    r: np.ndarray
    heading: np.ndarray
    rudder: np.ndarray
    north: np.ndarray
    east: np.ndarray
    pressure: np.ndarray
    sway: np.ndarray
    rate: np.ndarray
    length_m: float
    wind_ahead: np.ndarray
    wind_across: np.ndarray

    @property
    def step_s(self) -> float:
        """Time between two values."""
        return float(self.time_s[1] - self.time_s[0])

    @property
    def past_s(self) -> np.ndarray:
        """Time (N,) from the start of the record."""
        return self.time_s - self.time_s[0]

    def unit(self, axis: str) -> np.ndarray:
        """Force X, Y, N, or moment N, N m, (N,) of one in the prime system; yaw acceleration R of one."""
        return self.pressure * self.length_m if axis == "N" else self.pressure

    def own(self, name: str) -> np.ndarray:
        """Sway v, m/s, yaw rate r, rad/s, or rudder angle d, rad, (N,)."""
        return {"v": self.sway, "r": self.rate, "d": self.rudder}[name]

    def product(self, factors: Sequence[str]) -> np.ndarray:
        """Product (N,) of v', r', the rudder angle d, and their sizes (absv, absr, absd)."""
        values = {"v": self.v, "r": self.r, "d": self.rudder}
        return np.prod([abs(values[f[3:]]) if f.startswith("abs") else values[f] for f in factors], axis=0)


Series = Callable[[Motion], np.ndarray]
"""Force, N, or moment, N m, (N,) along a motion, for a number of one."""


def motion_of(model: Model, record: Record, smooth_s: float) -> Motion:
    """The motion of a record in the model's sign of the rudder, averaged over smooth_s; a state that is not measured
    is that of the approach."""
    own = np.asarray(record.time_s, float)
    time_s = np.arange(own[0], own[-1] + 1e-9, float(np.median(np.diff(own))))
    width = max(1, int(smooth_s / (time_s[1] - time_s[0])) | 1)

    def on_grid(values: np.ndarray) -> np.ndarray:
        return np.interp(time_s, own, bridged(values, own))

    def smoothed(channel: str, otherwise: float) -> np.ndarray:
        if not record.has(channel):
            return np.full(time_s.size, otherwise)
        return uniform_filter1d(on_grid(record.continuous(channel)), width, mode="nearest")

    u, v = smoothed("surge_m_s", model.speed_m_s), smoothed("sway_m_s", 0.0)
    heading = smoothed("heading_rad", 0.0)
    r = smoothed("yaw_rate_rad_s", 0.0) if record.has("yaw_rate_rad_s") else np.gradient(heading, time_s)
    if not record.has("heading_rad"):
        heading = integral(r, time_s)
    north, east = smoothed("north_m", np.nan), smoothed("east_m", np.nan)
    rudder, one = on_grid(record.rudder()), np.ones(time_s.size)
    wind = _apparent_wind(record, time_s, heading, np.nan_to_num(u), v, width)
    if not model.is_3dof:
        return Motion(time_s, u, 0.0 * one, r, heading, rudder, north, east, one, 0.0 * one, r, 1.0, *wind)
    numbers, length = model.environment_numbers(), ship_length_m(model)
    speed = np.sqrt(u**2 + v**2 + 1e-12)
    pressure = 0.5 * numbers["rho"] * length * numbers.get("d", length) * speed**2
    prime = v / speed, r * length / speed
    return Motion(time_s, speed, *prime, heading, rudder, north, east, pressure, v, r, length, *wind)


def _apparent_wind(
    record: Record, time_s: np.ndarray, heading: np.ndarray, u: np.ndarray, v: np.ndarray, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Velocity (N,) of the air against the ship, forward and to starboard, m/s, averaged over so many samples; nan
    where no wind is measured."""
    flow = flow_of(record, WIND)
    if flow is None:
        return np.full(time_s.size, np.nan), np.full(time_s.size, np.nan)
    north, east = (uniform_filter1d(np.interp(time_s, flow[0], way), width, mode="nearest") for way in flow[1].T)
    cosine, sine = np.cos(heading), np.sin(heading)
    return north * cosine + east * sine - u, east * cosine - north * sine - v
