"""A run whose motion is known, without any code of helmbench: the truth of the raw logs of the bank."""

from dataclasses import dataclass

import numpy as np

KN = 1852.0 / 3600.0
START = 1773480413.0
"""Epoch seconds of the first sample: 2026-03-14 09:26:53 UTC."""


@dataclass(frozen=True)
class Run:
    """A ship on zigzags; everything positive to starboard, north, east, forward; SI and radians."""

    t: np.ndarray
    psi: np.ndarray
    r: np.ndarray
    delta: np.ndarray
    order: np.ndarray
    u: np.ndarray
    v: np.ndarray
    roll: np.ndarray
    north: np.ndarray
    east: np.ndarray
    lat: np.ndarray
    lon: np.ndarray
    rps: np.ndarray

    @property
    def north_speed(self):
        return self.u * np.cos(self.psi) - self.v * np.sin(self.psi)

    @property
    def east_speed(self):
        return self.u * np.sin(self.psi) + self.v * np.cos(self.psi)

    @property
    def sog(self):
        return np.hypot(self.u, self.v)

    @property
    def cog(self):
        return np.arctan2(self.east_speed, self.north_speed) % (2.0 * np.pi)


def sail(rng, dt=0.5, seconds=240.0, latitude=54.42, longitude=10.31) -> Run:
    """Zigzags of a first-order ship with a slow rudder, its drift outward in the turn."""
    n = round(seconds / dt) + 1
    t = dt * np.arange(n)
    gain, lag, angle = rng.uniform(0.08, 0.14), rng.uniform(6.0, 12.0), np.radians(rng.uniform(15.0, 25.0))
    psi, r, delta, order = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    psi[0], helm = rng.uniform(0.5, 5.0), angle * rng.choice([-1.0, 1.0])
    for i in range(n - 1):
        off = psi[i] - psi[0]
        if i * dt > 20.0 and off * helm > 0.0 and abs(off) > angle:
            helm = -helm
        order[i] = helm if i * dt > 8.0 else 0.0
        delta[i + 1] = delta[i] + np.clip(order[i] - delta[i], -0.06 * dt, 0.06 * dt)
        r[i + 1] = r[i] + dt * (gain * delta[i] - r[i]) / lag
        psi[i + 1] = psi[i] + dt * (r[i] + r[i + 1]) / 2.0
    order[-1] = order[-2]
    speed = rng.uniform(4.0, 7.0)
    u = speed * (1.0 - 0.1 * np.clip(t / 60.0, 0.0, 1.0)) - 3.0 * np.abs(r)
    v, roll = -18.0 * r, -1.8 * r
    north_speed, east_speed = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    north, east = _integral(north_speed, dt), _integral(east_speed, dt)
    a, e2, phi = 6378137.0, 0.00669437999014, np.radians(latitude)
    w = np.sqrt(1.0 - e2 * np.sin(phi) ** 2)
    lat = latitude + np.degrees(north / (a * (1.0 - e2) / w**3))
    lon = longitude + np.degrees(east / (a / w * np.cos(np.radians((latitude + lat) / 2.0))))
    rps = 1.9 - 0.2 * np.abs(r) / np.abs(r).max() + 0.01 * np.sin(t / 9.0)
    return Run(t, psi, r, delta, order, u, v, roll, north, east, lat, lon, rps)


def _integral(rate, dt):
    return np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2.0) * dt])
