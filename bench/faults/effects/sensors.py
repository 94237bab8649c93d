"""Effects of the sensors: what they do to the columns of a record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..regimes import TrueRegime
from ..ships import DEGREE
from .base import ANTICIPATED, REGIME, EffectKind, Rows, Stage, any_ship, random_sign, scalar

VELOCITY = ("surge_m_s", "sway_m_s")
ATTITUDE = ("heading_rad", "yaw_rate_rad_s")


def offset(channel: str, **row: Any) -> EffectKind:
    """A constant added to a channel: parameter `b`."""

    def apply(rows, time, p, noise_sd, rng) -> None:
        rows[channel] = rows[channel] + p["b"]

    return scalar("b", stage=Stage.OFFSET, apply=apply, **row)


def scale(channels: tuple[str, ...], **row: Any) -> EffectKind:
    """Channels multiplied by 1 + s."""

    def apply(rows, time, p, noise_sd, rng) -> None:
        for channel in channels:
            rows[channel] = (1.0 + p["s"]) * rows[channel]

    return scalar("s", "1", stage=Stage.SCALE, cap=0.6, apply=apply, **row)


def turn_velocity(rows: Rows, angle: float | np.ndarray) -> None:
    """Surge and sway in axes that are turned by `angle` rad to starboard."""
    surge, sway = (rows[name] for name in VELOCITY)
    rows[VELOCITY[0]] = np.cos(angle) * surge + np.sin(angle) * sway
    rows[VELOCITY[1]] = -np.sin(angle) * surge + np.cos(angle) * sway


def turned(rows: Rows, time, p, noise_sd, rng) -> None:
    turn_velocity(rows, p["angle"])


def in_earth_axes(rows: Rows, time, p, noise_sd, rng) -> None:
    turn_velocity(rows, -rows["heading_rad"])


def exchanged(rows: Rows, time, p, noise_sd, rng) -> None:
    first, second = p["channels"]
    rows[first], rows[second] = rows[second], rows[first]


def negative_rudder(rows: Rows, time, p, noise_sd, rng) -> None:
    rows["rudder_rad"] = -rows["rudder_rad"]


def late_velocities(p: Mapping[str, Any]) -> tuple[str, ...]:
    return (*VELOCITY, *ATTITUDE) if p.get("attitude") else VELOCITY


def gross_errors(rows: Rows, time, p, noise_sd: Mapping[str, float], rng: np.random.Generator) -> None:
    for name in [name for name in rows if name != "rudder_rad"]:
        n = rows[name].size
        error = rng.choice([-1.0, 1.0], n) * rng.uniform(12.0, 30.0, n) * noise_sd.get(name, 0.0)
        rows[name] = rows[name] + np.where(rng.random(n) < p["share"], error, 0.0)


def cut_off(rows: Rows, time, p, noise_sd, rng) -> None:
    rows["yaw_rate_rad_s"] = np.clip(rows["yaw_rate_rad_s"], -p["limit"], p["limit"])


def ramp(rows: Rows, time: np.ndarray, p, noise_sd, rng) -> None:
    rows[p["channel"]] = rows[p["channel"]] + p["size"] * time / time[-1]


ROWS = (
    offset(
        id="yaw_rate_bias", rank=8, unit="rad/s", channel="yaw_rate_rad_s", carried_by=any_ship,
        size=lambda ship: 0.003 * DEGREE / ship.clock,
    ),
    offset(id="heading_offset", rank=10, unit="rad", channel="heading_rad", size=lambda ship: 0.1 * DEGREE),
    offset(id="sway_offset", rank=12, unit="m/s", channel="sway_m_s", size=lambda ship: 0.005 * ship.clock),
    scale(id="yaw_rate_scale", rank=9, channels=("yaw_rate_rad_s",), carried_by=any_ship, size=lambda ship: 0.01),
    scale(id="speed_scale", rank=11, channels=VELOCITY, size=lambda ship: 0.002),
    scalar(  # the axes of the speed log are turned by an angle to starboard
        id="axis_misalignment", rank=17, parameter="angle", unit="rad", cap=0.6, stage=Stage.ALIGNMENT,
        size=lambda ship: 0.1 * DEGREE, apply=turned,
    ),
    EffectKind(  # the columns of surge and sway hold the velocities along north and east
        id="earth_frame_velocity", rank=15, stage=Stage.FRAME, apply=in_earth_axes,
    ),
    EffectKind(  # two columns are exchanged
        id="channel_swap", rank=16, units={"channels": "pair"}, whole=("channels",), stage=Stage.COLUMN,
        draw=lambda s, rng: {"channels": (VELOCITY, ("north_m", "east_m"))[rng.integers(2)]}, apply=exchanged,
    ),
    EffectKind(id="rudder_sign", stage=Stage.OFFSET, rank=7, carried_by=any_ship, apply=negative_rudder),
    scalar(  # the heading is recorded tau seconds late
        id="heading_delay", stage=Stage.OFFSET, rank=13, parameter="tau", unit="s", negative=0.0, carried_by=any_ship,
        size=lambda ship: 0.2 * ship.clock, delay_s=lambda channel, p: p["tau"] if channel == "heading_rad" else 0.0,
    ),
    EffectKind(  # the velocities are recorded tau seconds late, and heading and yaw rate too where `attitude` is 1
        id="velocity_delay", stage=Stage.OFFSET, rank=14, units={"tau": "s", "attitude": "0 or 1"}, sized=("tau",),
        draw=lambda s, rng: {
            "tau": 0.2 * s.ship.clock * rng.uniform(0.7, 1.4), "attitude": float(rng.random() < 0.5),
        },
        delay_s=lambda channel, p: p["tau"] if channel in late_velocities(p) else 0.0,
    ),
    scalar(  # samples are taken at times with a random error; ten times as large, they keep their order
        id="clock_jitter", stage=Stage.OFFSET, rank=19, parameter="sd", unit="s", negative=0.0, variance_only=True,
        carried_by=any_ship, size=lambda ship: 0.015 * ship.clock, jitter_s=lambda p: p["sd"],
    ),
    scalar(  # a share of every channel's samples has gross errors of 12 to 30 standard deviations
        id="outliers", rank=18, parameter="share", unit="1", negative=0.0, cap=0.1, variance_only=True,
        carried_by=any_ship, stage=Stage.GROSS_ERROR, size=lambda ship: 0.005,
        noncentrality=lambda p: p["share"] * 12e4, apply=gross_errors,
    ),
    EffectKind(  # a sensor of heading or yaw rate drifts linearly through the record
        id="sensor_ramp", stage=Stage.OFFSET, group=ANTICIPATED, rank=39, units={"size": "rad or rad/s"},
        sized=("size",), carried_by=any_ship,
        draw=lambda s, rng: {
            "channel": str(rng.choice(("yaw_rate_rad_s", "heading_rad"))), "size": random_sign(rng) * 0.05 * DEGREE,
        },
        apply=ramp, variables=lambda p: frozenset({"time"}),
    ),
    EffectKind(  # the yaw-rate sensor cuts off what exceeds its range
        id="yaw_rate_saturation", group=REGIME, rank=63, units={"limit": "rad/s"}, stage=Stage.COLUMN,
        carried_by=any_ship, right=("yaw_rate_scale", "yaw_rate_saturation"), apply=cut_off,
        draw=lambda s, rng: {"limit": float(rng.uniform(0.15, 0.24)) * s.ship.speed_m_s / s.ship.length_m},
        regime=lambda p, ship: TrueRegime("yaw_rate", "above", p["limit"]),
    ),
)  # fmt: skip
