"""A number that may differ from what a model says, and a candidate: numbers that enter an explanation together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Number:
    """One number, as its difference from what the model says; 0: the model is right.

    sd : prior standard deviation, in the unit of the number.  low, high : bounds.
    trial : value at which it is linearised by a secant instead of a tangent, where the tangent at 0 is zero or stands
    for nothing (a rudder that is infinitely fast); None: a tangent.
    """

    name: str
    sd: float
    low: float = -np.inf
    high: float = np.inf
    trial: float | None = None

    def step(self, value: float, share: float) -> float:
        """Step of the difference at a value: a share of the prior standard deviation, or, of a size that is not
        negative (slowness, play), of the value where this is smaller."""
        if self.trial is not None:
            return self.trial - value
        return share * (min(self.sd, value) if self.low == 0.0 < value else self.sd)


def distinct(numbers: Iterable[Number]) -> tuple[Number, ...]:
    """Numbers, each once and without its trial value: those of a fit."""
    return tuple({n.name: replace(n, trial=None) for n in numbers}.values())


@dataclass(frozen=True)
class Candidate:
    """Numbers that enter together.

    rank : candidates of a lower rank are preferred where they are not clearly worse.  of : id of the candidate that
    this one is a part of, else its own.
    kind : candidates of the same id and kind differ in a setting that is no number of the fit, such as a time: of these
    the best is tried.
    Several candidates may have the same id: ways in which one cause may act.
    extends : it adds a term that the model lacks: of candidates that are alike otherwise it is not preferred.
    """

    id: str
    numbers: tuple[Number, ...]
    rank: int = 0
    of: str = ""
    kind: str = ""
    extends: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "of", self.of or self.id)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its numbers."""
        return tuple(number.name for number in self.numbers)
