"""The columns of surge and sway hold the velocities along north and east."""

from __future__ import annotations

from ._sensors import SensorKind, Stage, turn_velocity


class EarthFrameVelocity(SensorKind):
    """The columns of surge and sway hold the velocities along north and east."""

    id = "earth_frame_velocity"
    rank = 15
    stage = Stage.FRAME

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        turn_velocity(rows, -rows["heading_rad"])
