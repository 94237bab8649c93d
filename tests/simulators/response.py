"""Ships of first and second order by exact steps between samples, with rudder angles that move evenly between samples
(first order) or are held (second): nothing of helmbench.models or helmbench.estimation takes part.

    T r' + r = K (delta + neutral),    T1 T2 r'' + (T1 + T2) r' + r = K (delta + T3 delta')
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from helmbench.datasets.record import Record

STEP_S, T_S, GAIN = 0.5, 8.0, 0.12
RATE_SD, HEADING_SD = 5e-4, 1e-3
"""Noise of the sensors, rad/s and rad."""


def turned(rudder, neutral=0.0, seed=0, name="run", zero=0.0):
    """A ship of first order with a neutral rudder angle, rad; the gyro shows `zero`, rad/s, too much."""
    (rate, heading), held = np.zeros((2, rudder.size)), np.exp(-STEP_S / T_S)
    for k, change in enumerate(GAIN * np.diff(rudder)):
        late = change * T_S / STEP_S  # how far the rate that the ship would settle at runs ahead of it
        steady = GAIN * (rudder[k] + neutral) - late
        rate[k + 1] = steady + change + (rate[k] - steady) * held
        heading[k + 1] = heading[k] + (steady + change / 2.0) * STEP_S + (rate[k] - steady) * T_S * (1.0 - held)
    return _measured(rudder, rate, heading, seed, name, zero)


def second_order(rudder, times_s, gain, seed=0, name="run", noise=1.0):
    """A ship of second order; times_s : T1, T2, T3; noise : a factor."""
    t1, t2, t3 = times_s
    # states q, q', heading and the held angle: T1 T2 q'' + (T1 + T2) q' + q = delta, r = K (q + T3 q')
    system = np.array([[0.0, 1.0, 0.0, 0.0], [-1.0 / (t1 * t2), -(t1 + t2) / (t1 * t2), 0.0, 1.0 / (t1 * t2)],
                       [gain, gain * t3, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])  # fmt: skip
    step, state = expm(STEP_S * system), np.zeros(4)
    states = np.zeros((rudder.size, 4))
    for k, angle in enumerate(rudder):
        states[k] = state
        state = step @ np.array([*state[:3], angle])
    return _measured(rudder, gain * (states[:, 0] + t3 * states[:, 1]), states[:, 2], seed, name, noise=noise)


def _measured(rudder, rate, heading, seed, name, zero=0.0, noise=1.0):
    errors = noise * np.random.default_rng(seed).standard_normal((2, rudder.size))
    shown = {"yaw_rate_rad_s": rate + zero + RATE_SD * errors[0], "heading_rad": heading + HEADING_SD * errors[1]}
    return Record(STEP_S * np.arange(rudder.size), {"rudder_rad": rudder, **shown}, name)


def heading_only(record):
    """The record without its yaw rate."""
    return record.with_channels(yaw_rate_rad_s=None)


def steps(seed, samples=480):
    """Rudder angles that change every 20 to 35 s."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(20.0, 35.0, 20))
    return np.deg2rad(rng.choice([-20.0, -10.0, 10.0, 20.0], 21))[np.searchsorted(times, STEP_S * np.arange(samples))]
