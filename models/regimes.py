"""Regimes: parts of a run in which a number of a model has another value, by a threshold on one variable."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

VARIABLES = {"rudder": "rad", "yaw_rate": "rad/s", "drift": "rad", "speed": "m/s", "side": "rad/s", "time": "s"}
"""Variable -> unit: rudder angle, yaw rate and drift angle by their size, speed, yaw rate with its sign, time."""
CLOCK = "record_time"
"""State of models with forces or numbers in time: the time from the start of a record, s."""
SIDES = ("above", "below", "port", "starboard")
EXTENSION = re.compile(rf"regime_(?P<number>\w+)_(?P<variable>{'|'.join(VARIABLES)})_(?P<side>{'|'.join(SIDES)})")
"""Identifier of the extension by which a number differs in a regime: regime_f_alpha_rudder_above."""
DEG = 180.0 / np.pi
WORDS = {
    "rudder": ("{} {} of rudder", "deg", DEG, "beyond", "below"),
    "drift": ("{} {} of drift", "deg", DEG, "beyond", "below"),
    "yaw_rate": ("{} {} of yaw rate", "deg/s", DEG, "beyond", "below"),
    "speed": ("{} {}", "m/s", 1.0, "above", "below"),
    "time": ("{} {}", "s", 1.0, "after", "before"),
}
"""How a regime is told: text, unit and factor of its threshold, words for above and below."""
WIDTH = {"rudder": 0.02, "yaw_rate": 0.03, "drift": 0.05, "speed": 0.004, "side": 0.02, "time": 0.01}
"""Width of the transition, as a share of the threshold, or of the largest yaw rate between the sides."""


@dataclass(frozen=True)
class Regime:
    """Where a number has another value.

    variable : one of VARIABLES.  side : above or below the threshold, or the side to which the ship turns.
    threshold, width : in the unit of the variable.
    """

    variable: str
    side: str
    threshold: float
    width: float

    @property
    def sign(self) -> float:
        """-1 where the regime lies below the threshold."""
        return -1.0 if self.side in ("below", "port") else 1.0

    def told(self, low: float, high: float) -> str:
        """Where it is, in words, with an interval of the threshold: `beyond 15.3 deg of rudder (14.9 to 15.8)`."""
        if self.variable == "side":
            return f"in turns to {self.side}"
        text, unit, factor, above, below = WORDS[self.variable]
        at, *ends = (f"{factor * x:.3g}" for x in (self.threshold, low, high))
        return f"{text.format(above if self.side == 'above' else below, f'{at} {unit}')} ({' to '.join(ends)})"

    def inside(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Smooth indicator (N,) of values: half of 1 + z / sqrt(1 + z^2), z in widths from the threshold.

        Eq. 11 of docs/mathematics/pieces.md.
        """
        z = self.sign * (value - self.threshold) / self.width
        return 0.5 * (1.0 + z / np.sqrt(1.0 + z * z))


def values_of(
    states: Mapping[str, NDArray[np.float64]], rudder: NDArray[np.float64], time: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Variable -> its values (N,), of those that the states u, v, r tell."""
    found = {"rudder": np.abs(rudder), "yaw_rate": np.abs(states["r"]), "side": states["r"], "time": time}
    if "u" in states and "v" in states:
        u, v = states["u"], states["v"]
        found |= {"drift": np.abs(np.arctan2(v, u)), "speed": np.hypot(u, v)}
    return found


def regime(variable: str, side: str, threshold: float, scale: float | None = None) -> Regime:
    """A regime with the width of its variable; scale : of the variable, the threshold unless given."""
    return Regime(variable, side, threshold, WIDTH[variable] * (threshold if scale is None else scale))
