"""Effects that no test of any diagnosis was written for: whoever builds a diagnosis does not read the files `b*.py`.

Their ids B1, B2, ... say nothing.  All are forces.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from .base import UNFORESEEN, Setting
from .forces import ForceKind


@dataclass(frozen=True, eq=False)
class Chances:
    """Random numbers that every unforeseen kind draws, whichever of them it uses.

    side and other_side are -1 or 1; north, east: a place that the ship passes, in lengths; uniform (14,) in 0 .. 1.
    Kinds use different ones, so that the same seed gives each kind a different case.
    """

    side: float
    other_side: tuple[float, float]
    north: float
    east: float
    uniform: np.ndarray

    @classmethod
    def draw(cls, s: Setting, rng: np.random.Generator) -> Chances:
        """Draw them all."""
        north, east = s.place()
        side = rng.choice([-1.0, 1.0])
        first = rng.random(4)
        one = rng.choice([-1.0, 1.0])
        rest = rng.random(10)
        return cls(side, (one, rng.choice([-1.0, 1.0])), north, east, np.concatenate([first, rest]))

    def between(self, i: int, low: float, high: float) -> float:
        """Number i, uniform in low .. high."""
        return low + (high - low) * float(self.uniform[i])


class UnforeseenForce(ForceKind):
    """An unknown force; `signed` where its size may also be negative."""

    group = UNFORESEEN
    signed = True

    @abstractmethod
    def constants(self, s: Setting, c: Chances) -> list[float]:
        """Up to five constants."""

    def draw_constants(self, s: Setting, rng: np.random.Generator) -> list[float]:
        chances = Chances.draw(s, rng)
        return [chances.side if self.signed else 1.0, *self.constants(s, chances)]
