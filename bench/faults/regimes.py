"""Regimes: parts of a run in which an effect acts, by a threshold on one variable.

A diagnosis states a regime as plain data, `{"variable", "side", "threshold", "low", "high"}` in SI units, low and high
being the interval of the threshold.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...datasets.record import Record

VARIABLES = ("rudder", "drift", "yaw_rate", "speed", "side", "time")
SIDES = ("above", "below", "port", "starboard")


@dataclass(frozen=True)
class TrueRegime:
    """Where an effect acts.

    variable : rudder angle, drift angle and yaw rate by their size, speed over ground, the side to which the ship
        turns, or time in the record.
    side : above or below the threshold (rad, rad/s, m/s, s), or the side to which rudder, drift or turn point.
    """

    variable: str
    side: str
    threshold: float = 0.0

    @classmethod
    def of(cls, stated: Mapping[str, Any]) -> TrueRegime:
        """The regime that a finding states; ValueError for another variable or side."""
        variable, side = str(stated.get("variable")), str(stated.get("side"))
        if variable not in VARIABLES or side not in SIDES:
            raise ValueError(f"regime of {variable!r}, {side!r}: variables are {VARIABLES}, sides {SIDES}")
        threshold = stated.get("threshold")
        return cls(variable, side, 0.0 if threshold is None else float(threshold))

    def inside(self, run: Record) -> np.ndarray:
        """Which samples (N,) of a record of the true motion lie in the regime."""
        value = signed(self.variable, run)
        if self.side == "starboard":
            return value > abs(self.threshold)
        if self.side == "port":
            return value < -abs(self.threshold)
        return np.abs(value) > self.threshold if self.side == "above" else np.abs(value) < self.threshold

    def __str__(self) -> str:
        return f"{self.variable} {self.side} {self.threshold:.3g}"


def signed(variable: str, run: Record) -> np.ndarray:
    """A variable (N,) of a record of the true motion, positive to starboard where it has a side."""
    turning = run.column("yaw_rate_rad_s")
    if variable == "rudder":
        sign = -1.0 if run.meta.positive_rudder == "port" else 1.0
        return sign * run.rudder()
    if variable == "time":
        return run.time_s
    if variable in ("yaw_rate", "side"):
        return turning
    sway = run.column("sway_m_s") if run.has("sway_m_s") else np.zeros(run.n)
    surge = run.column("surge_m_s")
    return np.hypot(surge, sway) if variable == "speed" else np.arctan2(-sway, surge)


def f1(true: np.ndarray, said: np.ndarray) -> float:
    """Harmonic mean of precision and recall of samples (N,) that are said to be in a regime; nan where none is."""
    both, total = np.sum(true & said), np.sum(true) + np.sum(said)
    return float(2.0 * both / total) if total else float("nan")
