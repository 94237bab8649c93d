"""From a dense run to a Record: sampling, what the sensors get wrong, noise, gaps.

recorded = (1 + scale) true(t - delay) + bias + noise; frames and swaps act on what the instruments give.
"""

from __future__ import annotations

import numpy as np

from ...datasets.record import Record, RecordMeta
from .ships import Ship
from .simulator import Plan, Run

VELOCITY = ("surge_m_s", "sway_m_s")
ATTITUDE = ("heading_rad", "yaw_rate_rad_s")
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


def noise_sd(ship: Ship, level: float = 1.0) -> dict[str, float]:
    """Channel -> standard deviation of its white noise; 0 for `level` 0."""
    clock = ship.clock
    power = {"yaw_rate_rad_s": -1, "surge_m_s": 1, "sway_m_s": 1, "north_m": 2, "east_m": 2}
    return {name: level * sd * clock ** power.get(name, 0) for name, sd in NOISE.items()}


def observe(
    run: Run,
    plan: Plan,
    dt_s: float,
    rng: np.random.Generator,
    noise: dict[str, float],
    channels: tuple[str, ...],
    *,
    gaps: float = 0.0,
    command: bool = False,
    name: str = "record",
    manoeuvre: str | None = None,
    wrap: bool = True,
) -> Record:
    """The record of a run, sampled every dt_s seconds.

    gaps: share of the samples of each channel but the rudder that are lost, in runs of 10; command: the rudder
    column is `rudder_command_rad`, what the steering gear was told.
    """
    sensors = plan.sensors
    time = dt_s * np.arange(round((len(run.states) - 1) * run.step_s / dt_s) + 1)
    jitter = sensors.get("clock_jitter", {}).get("sd", 0.0)
    taken = np.clip(time + jitter * rng.standard_normal(time.size), 0.0, time[-1])
    rows = {c: sampled(run, c, taken - delay(sensors, c)) for c in CHANNELS}
    framed(rows, sensors)
    calibrated(rows, sensors, time)
    for channel in rows:
        rows[channel] = rows[channel] + noise.get(channel, 0.0) * rng.standard_normal(time.size)
    spoiled(rows, sensors, noise, rng)
    swapped(rows, sensors)
    if wrap:
        rows["heading_rad"] = np.mod(rows["heading_rad"], 2.0 * np.pi)
    for channel in CHANNELS[1:]:
        rows[channel] = with_gaps(rows[channel], gaps, rng)
    rudder = rows.pop("rudder_rad")
    kept = {c: rows[c] for c in CHANNELS[1:] if c in channels}
    side = "port" if plan.ship.starboard < 0 else "starboard"
    meta = RecordMeta(vessel=plan.ship.id, positive_rudder=side, manoeuvre=manoeuvre, source="truth simulator")
    return Record(time, {"rudder_command_rad" if command else "rudder_rad": rudder, **kept}, name, meta)


def sampled(run: Run, channel: str, at: np.ndarray) -> np.ndarray:
    """True values of a channel at times `at`, linear on the integration grid; the first value before it."""
    if channel == "rudder_rad":
        return np.interp(at, 0.5 * run.step_s * np.arange(run.rudder.size), run.rudder)
    values = run.states[:, STATE[channel]]
    if channel in ATTITUDE:
        values = values + run.wave[:, ATTITUDE.index(channel)]
    return np.interp(at, run.time_s, values)


def delay(sensors: dict[str, dict], channel: str) -> float:
    """Delay of a channel, s."""
    late = sensors.get("heading_delay", {}).get("tau", 0.0) if channel == "heading_rad" else 0.0
    velocity = sensors.get("velocity_delay", {})
    if channel in VELOCITY or (channel in ATTITUDE and velocity.get("attitude", 0.0)):
        late += velocity.get("tau", 0.0)
    return late


def framed(rows: dict[str, np.ndarray], sensors: dict[str, dict]) -> None:
    """Velocities turned by the misalignment of the log, or given along north and east."""
    surge, sway = (rows[c] for c in VELOCITY)
    if "axis_misalignment" in sensors:
        angle = sensors["axis_misalignment"]["angle"]
        surge, sway = np.cos(angle) * surge + np.sin(angle) * sway, -np.sin(angle) * surge + np.cos(angle) * sway
    if "earth_frame_velocity" in sensors:
        psi = rows["heading_rad"]
        surge, sway = np.cos(psi) * surge - np.sin(psi) * sway, np.sin(psi) * surge + np.cos(psi) * sway
    rows["surge_m_s"], rows["sway_m_s"] = surge, sway


def calibrated(rows: dict[str, np.ndarray], sensors: dict[str, dict], time: np.ndarray) -> None:
    """Scales, biases and ramps."""
    for cause, channels in {"yaw_rate_scale": ATTITUDE[1:], "speed_scale": VELOCITY}.items():
        for channel in channels if cause in sensors else ():
            rows[channel] = (1.0 + sensors[cause]["s"]) * rows[channel]
    for cause, channel in {
        "yaw_rate_bias": ATTITUDE[1],
        "heading_offset": ATTITUDE[0],
        "sway_offset": VELOCITY[1],
    }.items():
        if cause in sensors:
            rows[channel] = rows[channel] + sensors[cause]["b"]
    if "sensor_ramp" in sensors:
        ramp = sensors["sensor_ramp"]
        rows[ramp["channel"]] = rows[ramp["channel"]] + ramp["size"] * time / time[-1]
    if "rudder_sign" in sensors:
        rows["rudder_rad"] = -rows["rudder_rad"]


def spoiled(rows: dict[str, np.ndarray], sensors: dict[str, dict], noise: dict[str, float], rng) -> None:
    """Outliers of 12 to 30 standard deviations in a share of every channel's samples but the rudder's."""
    share = sensors.get("outliers", {}).get("share", 0.0)
    for channel in CHANNELS[1:] if share > 0.0 else ():
        n = rows[channel].size
        error = rng.choice([-1.0, 1.0], n) * rng.uniform(12.0, 30.0, n) * noise.get(channel, 0.0)
        rows[channel] = rows[channel] + np.where(rng.random(n) < share, error, 0.0)


def swapped(rows: dict[str, np.ndarray], sensors: dict[str, dict]) -> None:
    """Two columns exchanged."""
    if "channel_swap" in sensors:
        first, second = sensors["channel_swap"]["channels"]
        rows[first], rows[second] = rows[second], rows[first]


def with_gaps(values: np.ndarray, share: float, rng: np.random.Generator, length: int = 10) -> np.ndarray:
    """values with about that share lost in runs; the first samples stay."""
    if share <= 0.0:
        return values
    starts = np.flatnonzero(rng.random(values.size) < share / length)
    lost = np.unique((starts[:, None] + np.arange(length)).ravel())
    values = values.copy()
    values[lost[(lost >= 2 * length) & (lost < values.size)]] = np.nan
    return values
