"""Sensor errors that show between channels that must agree, as rows of data; what one leaves between them is a column
of `comparison.series`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import POSITIONS, VELOCITIES
from ..datasets.instruments import later
from .base import Prior, SensorError
from .comparison.motion import Effect, angle, curve_floor, late, lever_floor, scale, zero_floor

if TYPE_CHECKING:
    from ..datasets.record import Record

ROUNDS = 8
OF_SWAY = (0.05, 0.6)
"""Scale errors that sway alone may have: a smaller one is no larger than what other errors leave of the small sway, and
a larger one takes the place of delays of positions."""
ALL_LATE = ("surge_delay", "sway_delay", "yaw_rate_delay", "heading_delay")


def _squared(speed: np.ndarray) -> np.ndarray:
    """Squares of speeds (T,) with their signs."""
    return speed * np.abs(speed)


def _earlier(record: Record, columns: Sequence[str], late_s: float) -> Record:
    """The record with some columns that are late as they were so much before; the last samples are lost."""
    return record.with_channels(**{n: later(record.time_s, record.column(n), late_s) for n in columns})


class YawRateBiasError(SensorError):
    """Zero error of the rate gyro: recorded yaw rate = true + b, b in rad/s."""

    id, unit = "yaw_rate_bias", "rad/s"
    turn = (Effect("b", "rad/s", ("yaw_rate_bias",), lambda turn: -turn.time, zero_floor),)
    drifts = True
    separate_by = "a gyro zero reading at rest"


class YawRateScaleError(SensorError):
    """Scale error of the rate gyro: recorded yaw rate = (1 + s) true."""

    id, unit = "yaw_rate_scale", "1"
    turn = (scale(lambda turn: -turn.run, "yaw_rate_scale"),)
    farthest = 1.0
    separate_by = "a heading channel of another instrument over a full turn"


class LoggerClock(SensorError):
    """Clock of the logger that runs fast or slow: a true second takes 1 + e recorded ones.  Rates and speeds of
    instruments with clocks of their own then read 1 + e times what heading and positions change in recorded time."""

    id, unit, is_cause = "logger_clock", "1", True
    turn_instead = (scale(lambda turn: -turn.run, "clock_rate", parameter="e"),)
    instead_of = YawRateScaleError.id
    separate_by = "the times of two events that another clock shows too, an hour apart"


class HeadingDrift(SensorError):
    """Heading that drifts: recorded(t) = true(t) + d (t - start of the record), d in rad/s (a gyro compass that
    settles, or a heading that is integrated).  It looks like a zero error of the rate; positions tell which it is."""

    id, unit, is_cause = "heading_drift", "rad/s", True
    turn_instead = (Effect("d", "rad/s", ("heading_drift",), lambda turn: turn.time, zero_floor),)
    instead_of = YawRateBiasError.id
    drifts = True
    separate_by = "courses from positions on a straight run at the begin and at the end"


class YawRateDelay(SensorError):
    """Late (or smoothed) yaw rate against the heading: recorded(t) = true(t - tau), tau in s."""

    id, unit, is_cause = "yaw_rate_delay", "s", True
    turn = (late(lambda turn: turn.late, "yaw_rate_delay"),)
    prior = Prior(0.3, entries=("yaw_rate_delay",), needs=("r", "psi"))
    separate_by = "yaw rate and heading of instruments with known time stamps"


class HeadingDelayError(SensorError):
    """Late heading: recorded(t) = true(t - tau), tau in s."""

    id, unit = "heading_delay", "s"
    turn = (late(lambda turn: -turn.late, "heading_delay"),)
    track = (late(lambda path: path.late_heading, "heading_delay"),)
    separate_by = "yaw rate and heading of instruments with known time stamps"


class HeadingOffsetError(SensorError):
    """Misread heading: recorded = true + b, b in rad; the track shows it."""

    id, unit = "heading_offset", "rad"
    track = (angle(lambda path: -1j * path.run, "heading_bias"),)
    track_rivals = ("axis_misalignment",)
    separate_by = "positions on two opposite straight courses"


class CompassDeviation(SensorError):
    """Compass error that goes with the heading: recorded = true + c cos(true) + s sin(true), c and s in rad (iron in
    the ship, or a wrongly calibrated magnetic compass)."""

    id, unit, is_cause = "compass_deviation", "rad", True
    turn = (
        angle(lambda turn: np.cos(turn.heading) - np.cos(turn.heading[0]), parameter="c"),
        angle(lambda turn: np.sin(turn.heading) - np.sin(turn.heading[0]), parameter="s"),
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
    """Scale error of the speed log: recorded surge and sway (in further variants one of them alone) = (1 + s) true."""

    id, unit = "speed_scale", "1"
    track = (
        scale(lambda path: -path.run, "surge_scale", "sway_scale"),
        scale(lambda path: -path.along(path.speed.real), "surge_scale"),
        scale(lambda path: -path.along(1j * path.speed.imag), "sway_scale", sizes=OF_SWAY),
    )
    log = (scale(lambda log: -log.run, "surge_scale"),)
    farthest = 1.0
    separate_by = "a measured mile in both directions"


class SpeedCurve(SensorError):
    """Speed log that is not linear: recorded surge = (1 + s + c |u|) u: its scale error is s at rest, and grows by c
    with each m/s."""

    id, unit, is_cause = "speed_curve", "s/m", True
    together = (
        Effect("s", "1", ("surge_scale",), lambda motion: -motion.along(motion.speed.real), lambda motion: np.inf),
        Effect("c", "s/m", ("surge_curve",), lambda motion: -motion.along(_squared(motion.speed.real)), curve_floor),
    )
    farthest = 1.0
    prior = Prior(0.3, needs=("u",))
    separate_by = "a measured mile at three speeds, each in both directions"


class SwayOffsetError(SensorError):
    """Zero error of the log's athwartships axis: recorded sway = true + b, b in m/s."""

    id, unit = "sway_offset", "m/s"
    track = (Effect("b", "m/s", ("sway_bias",), lambda path: path.along(-1j), zero_floor),)
    separate_by = "a straight run with positions"


class VelocityDelayError(SensorError):
    """Late velocities: surge and sway (in a second variant yaw rate and heading too) recorded a time tau [s] late
    against the position."""

    id, unit = "velocity_delay", "s"
    track = (
        late(lambda path: path.late_speeds, "surge_delay", "sway_delay"),
        late(lambda path: path.late_motion, *ALL_LATE),
    )
    log = (late(lambda log: log.late, "surge_delay"),)
    separate_by = "time stamps of each instrument"


class PositionDelay(SensorError):
    """Late positions: recorded(t) = true(t - tau), tau in s, against heading and velocities (a satellite receiver that
    filters or sends late)."""

    id, unit, is_cause = "position_delay", "s", True
    track = (late(lambda path: -path.late_motion),)
    log = (late(lambda log: -log.late),)
    corrects = POSITIONS
    separate_by = "time stamps of each instrument, and a run at another speed: a point moves with the ship, not a delay"

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with positions tau earlier; the last are lost."""
        return _earlier(record, self.corrects, float(values[0]))


class TrackDelay(SensorError):
    """Late track: positions and velocities of one receiver recorded a time tau [s] late against heading and yaw rate,
    as where two loggers' clocks differ."""

    id, unit, is_cause = "track_delay", "s", True
    track = (late(lambda path: -path.late_heading, "surge_delay", "sway_delay", "north_delay", "east_delay"),)
    corrects = (*POSITIONS, *VELOCITIES)
    separate_by = "time stamps of each instrument"

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with positions and velocities tau earlier; the last are lost."""
        return _earlier(record, self.corrects, float(values[0]))


class ReferencePoint(SensorError):
    """Positions of another point than velocities: recorded position = true + x (cos psi, sin psi), x in m forward of
    the point whose velocities are recorded (an antenna that is not at the centre of gravity)."""

    id, unit, is_cause = "reference_point", "m", True
    track = (Effect("x", "m", (), lambda path: path.direction - path.direction[0], lever_floor),)
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


class VelocityPoint(SensorError):
    """Velocities and positions of another point than the hull's: recorded sway = true + x r, x in m forward of the
    point that the model's velocities are of (an antenna far from midship).  Both agree: only a model of the hull
    tells."""

    id, unit, is_cause = "velocity_point", "m", True
    prior = Prior(0.1, entries=("point_ahead",), needs=("v", "r"), last=True)
    separate_by = "where the antenna or log stands that the velocities come from, and the point that the model is of"


class CurrentDrift(SensorError):
    """Steady uniform current, earth-fixed and per record: the hull's forces depend on velocities through the water;
    speed m/s and the direction (rad) it flows towards."""

    id, where, unit = "current", "environment", "m/s, rad"
    farthest = 12.0  # m/s: more than the fastest tidal streams
    track_rivals = ("speed_scale", "heading_offset", "sway_offset")
    separate_by = "the same manoeuvre on two headings, or a log that measures speed through the water"
