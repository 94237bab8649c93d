"""Sensor errors that show between channels that must agree, as rows of data; what one leaves between them is a column
of `comparison.series`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import POSITIONS
from ..datasets.instruments import later
from .base import Prior, SensorError
from .comparison.series import (
    LogEffect,
    SurgeEffect,
    TrackEffect,
    TurnEffect,
    curve_floor,
    half_a_degree,
    half_a_percent,
    late_floor,
    none,
)

if TYPE_CHECKING:
    from ..datasets.record import Record

ROUNDS = 8
ALL_LATE = ("surge_delay", "sway_delay", "yaw_rate_delay", "heading_delay")


class YawRateBiasError(SensorError):
    """Zero error of the rate gyro: recorded yaw rate = true + b, b in rad/s."""

    id, unit = "yaw_rate_bias", "rad/s"
    turn = (TurnEffect("b", "rad/s", ("yaw_rate_bias",), lambda turn: -turn.time[None], lambda turn: turn.rate_floor),)
    drifts = True
    separate_by = "a gyro zero reading at rest"


class YawRateScaleError(SensorError):
    """Scale error of the rate gyro: recorded yaw rate = (1 + s) true."""

    id, unit = "yaw_rate_scale", "1"
    turn = (TurnEffect("s", "1", ("yaw_rate_scale",), lambda turn: -turn.turned[None], half_a_percent),)
    farthest = 1.0
    separate_by = "a heading channel of another instrument over a full turn"


class LoggerClock(SensorError):
    """Clock of the logger that runs fast or slow: a true second takes 1 + e recorded ones.  Rates and speeds of
    instruments with clocks of their own then read 1 + e times what heading and positions change in recorded time."""

    id, unit, is_cause = "logger_clock", "1", True
    scaled = (TurnEffect("e", "1", ("clock_rate",), lambda turn: -turn.turned[None], half_a_percent),)
    separate_by = "the times of two events that another clock shows too, an hour apart"


class YawRateDelay(SensorError):
    """Late (or smoothed) yaw rate against the heading: recorded(t) = true(t - tau), tau in s."""

    id, unit, is_cause = "yaw_rate_delay", "s", True
    turn = (TurnEffect("tau", "s", ("yaw_rate_delay",), lambda turn: turn.late_rate, late_floor, delay=True),)
    prior = Prior(0.3, entries=("yaw_rate_delay",), needs=("r", "psi"))
    separate_by = "yaw rate and heading of instruments with known time stamps"


class HeadingDelayError(SensorError):
    """Late heading: recorded(t) = true(t - tau), tau in s."""

    id, unit = "heading_delay", "s"
    turn = (TurnEffect("tau", "s", ("heading_delay",), lambda turn: -turn.late_rate, late_floor, delay=True),)
    track_without_model = (
        TrackEffect("tau", "s", ("heading_delay",), lambda path: path.late_heading, late_floor, delay=True),
    )
    separate_by = "yaw rate and heading of instruments with known time stamps"


class HeadingOffsetError(SensorError):
    """Misread heading: recorded = true + b, b in rad; the track shows it."""

    id, unit = "heading_offset", "rad"
    track = (TrackEffect("b", "rad", ("heading_bias",), lambda path: path.turned_way, half_a_degree),)
    track_rivals = ("axis_misalignment",)
    separate_by = "positions on two opposite straight courses"


class CompassDeviation(SensorError):
    """Compass error that goes with the heading: recorded = true + c cos(true) + s sin(true), c and s in rad (iron in
    the ship, or a wrongly calibrated magnetic compass)."""

    id, unit, is_cause = "compass_deviation", "rad", True
    turn = (
        TurnEffect("c", "rad", (), lambda turn: np.cos(turn.heading)[None] - np.cos(turn.heading[0]), half_a_degree),
        TurnEffect("s", "rad", (), lambda turn: np.sin(turn.heading)[None] - np.sin(turn.heading[0]), half_a_degree),
    )
    least_turn, farthest = np.pi, 0.6
    corrects = ("heading_rad",)
    separate_by = "a full circle against a gyro compass or against courses from positions"

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with the deviation (c, s) removed from its heading, by fixed-point steps."""
        recorded = record.heading_unwrapped()
        true = recorded
        for _ in range(ROUNDS):
            true = recorded - values[0] * np.cos(true) - values[1] * np.sin(true)
        return record.with_channels(heading_rad=true)


class SpeedScaleError(SensorError):
    """Scale error of the speed log: recorded surge and sway (in a second variant surge alone) = (1 + s) true."""

    id, unit = "speed_scale", "1"
    track = (
        TrackEffect("s", "1", ("surge_scale", "sway_scale"), lambda path: -path.way, half_a_percent),
        TrackEffect("s", "1", ("surge_scale",), lambda path: -path.along(path.surge), half_a_percent),
    )
    log = (LogEffect("s", "1", ("surge_scale",), lambda log: -log.run[None], half_a_percent),)
    farthest = 1.0
    separate_by = "a measured mile in both directions"


class SpeedCurve(SensorError):
    """Speed log that is not linear: recorded surge = (1 + s + c |u|) u: its scale error is s at rest, and grows by c
    with each m/s."""

    id, unit, is_cause = "speed_curve", "s/m", True
    together = (
        SurgeEffect("s", "1", ("surge_scale",), lambda motion: -motion.along(motion.surge), none),
        SurgeEffect(
            "c", "s/m", ("surge_curve",), lambda motion: -motion.along(motion.surge * np.abs(motion.surge)), curve_floor
        ),
    )
    farthest = 1.0
    prior = Prior(0.3, needs=("u",))
    separate_by = "a measured mile at three speeds, each in both directions"


class SwayOffsetError(SensorError):
    """Zero error of the log's athwartships axis: recorded sway = true + b, b in m/s."""

    id, unit = "sway_offset", "m/s"
    track = (TrackEffect("b", "m/s", ("sway_bias",), lambda path: path.of_sway, lambda path: path.sway_floor),)
    separate_by = "a straight run with positions"


class VelocityDelayError(SensorError):
    """Late velocities: surge and sway (in a second variant yaw rate and heading too) recorded a time tau [s] late
    against the position."""

    id, unit = "velocity_delay", "s"
    track = (
        TrackEffect("tau", "s", ("surge_delay", "sway_delay"), lambda path: path.late_speeds, late_floor, delay=True),
        TrackEffect("tau", "s", ALL_LATE, lambda path: path.late_motion, late_floor, delay=True),
    )
    log = (LogEffect("tau", "s", ("surge_delay",), lambda log: log.late_speed, late_floor, delay=True),)
    separate_by = "time stamps of each instrument"


class PositionDelay(SensorError):
    """Late positions: recorded(t) = true(t - tau), tau in s, against heading and velocities (a satellite receiver that
    filters or sends late)."""

    id, unit, is_cause = "position_delay", "s", True
    track = (TrackEffect("tau", "s", (), lambda path: -path.late_motion, late_floor, delay=True),)
    log = (LogEffect("tau", "s", (), lambda log: -log.late_speed, late_floor, delay=True),)
    corrects = POSITIONS
    separate_by = "time stamps of each instrument, and a run at another speed: a point moves with the ship, not a delay"

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with positions tau earlier; the last are lost."""
        late = float(values[0])
        return record.with_channels(**{n: later(record.time_s, record.column(n), late) for n in self.corrects})


class ReferencePoint(SensorError):
    """Positions of another point than velocities: recorded position = true + x (cos psi, sin psi), x in m forward of
    the point whose velocities are recorded (an antenna that is not at the centre of gravity)."""

    id, unit, is_cause = "reference_point", "m", True
    track = (TrackEffect("x", "m", (), lambda path: path.ahead, lambda path: path.lever_floor),)
    corrects = ("north_m", "east_m", "heading_rad")
    separate_by = (
        "where antenna and log stand, and a run at another speed: a delay moves with the speed, a point does not"
    )

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with positions moved back by x."""
        psi, x = record.heading_unwrapped(), float(values[0])
        return record.with_channels(
            north_m=record.column("north_m") - x * np.cos(psi), east_m=record.column("east_m") - x * np.sin(psi)
        )


class CurrentDrift(SensorError):
    """Steady uniform current, earth-fixed and per record: the hull's forces depend on velocities through the water;
    speed m/s and the direction (rad) it flows towards."""

    id, where, unit = "current", "environment", "m/s, rad"
    farthest = 12.0  # m/s: more than the fastest tidal streams
    track_rivals = ("speed_scale", "heading_offset", "sway_offset")
    separate_by = "the same manoeuvre on two headings, or a log that measures speed through the water"
