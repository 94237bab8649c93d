"""Effects of the sensors: what they do to the columns of a record, simulated or measured."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, ClassVar

import numpy as np

from .base import RecordEffect, Rows

VELOCITY = ("surge_m_s", "sway_m_s")
ATTITUDE = ("heading_rad", "yaw_rate_rad_s")


class Stage(IntEnum):
    """Order in which sensor effects act; white noise comes between `OFFSET` and `GROSS_ERROR`."""

    ALIGNMENT = 0
    FRAME = 1
    SCALE = 2
    OFFSET = 3
    GROSS_ERROR = 4
    COLUMN = 5


class SensorKind(RecordEffect):
    """A kind of effect that acts on a sensor."""

    stage: ClassVar[Stage] = Stage.OFFSET

    def jitter_s(self, p: Mapping[str, Any]) -> float:
        """Standard deviation of the sampling times, s."""
        return 0.0

    def delay_s(self, channel: str, p: Mapping[str, Any]) -> float:
        """Delay of a channel of a simulated record, s."""
        return 0.0

    def apply(
        self,
        rows: Rows,
        time: np.ndarray,
        p: Mapping[str, Any],
        noise_sd: Mapping[str, float],
        rng: np.random.Generator,
    ) -> None:
        """Change the columns in place; time (n,) s, `noise_sd` of the channels in their own units."""

    def change_record(self, rows: Rows, time: np.ndarray, p: Mapping[str, Any], rng: np.random.Generator) -> None:
        self.apply(rows, time, p, {}, rng)


class OffsetKind(SensorKind):
    """A constant added to a channel: parameter `b`."""

    channel: ClassVar[str]

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        rows[self.channel] = rows[self.channel] + p["b"]


class ScaleKind(SensorKind):
    """Channels multiplied by 1 + s."""

    stage = Stage.SCALE
    channels: ClassVar[tuple[str, ...]]

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        for channel in self.channels:
            rows[channel] = (1.0 + p["s"]) * rows[channel]


def turn_velocity(rows: Rows, angle: float | np.ndarray) -> None:
    """Surge and sway in axes that are turned by `angle` rad to starboard."""
    surge, sway = (rows[name] for name in VELOCITY)
    rows[VELOCITY[0]] = np.cos(angle) * surge + np.sin(angle) * sway
    rows[VELOCITY[1]] = -np.sin(angle) * surge + np.cos(angle) * sway


def delay_columns(rows: Rows, time: np.ndarray, names: list[str], delay_s: float) -> None:
    """recorded(t) = true(t - delay); nan where the record has no such time."""
    for name in names:
        known = np.isfinite(rows[name])
        moved = np.interp(time - delay_s, time[known], rows[name][known], left=np.nan, right=np.nan)
        share = np.interp(time - delay_s, time, known.astype(float), left=0.0, right=0.0)
        rows[name] = np.where(share > 0.999, moved, np.nan)
