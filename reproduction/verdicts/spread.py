"""Prediction intervals of values over seeds: where the value of one more run would lie."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

COVERAGE = 0.95
DIGITS = 7
"""Significant digits that are stored."""


@dataclass(frozen=True)
class Spread:
    """A quantity over runs: `median`, and the interval [`low`, `high`] for a single further run; nan where unknown.

    n : runs;  finite : those that gave a number;  smallest, largest, mean (of statements the
    share of true ones) : of these.
    """

    n: int
    finite: int
    median: float
    low: float
    high: float
    smallest: float
    largest: float
    mean: float

    @property
    def known(self) -> bool:
        """Whether at least half of the runs gave a number."""
        return self.finite > 0 and 2 * self.finite >= self.n


NOTHING = Spread(0, 0, *[math.nan] * 6)


def spread(values: Sequence[float], logarithmic: bool = False) -> Spread:
    """The spread of one value a run; what is not finite counts as a run without a number."""
    whole = np.asarray(values, float)
    found = np.sort(whole[np.isfinite(whole)])
    if not found.size:
        return Spread(len(whole), 0, *[math.nan] * 6)
    low, high = prediction_interval(found, logarithmic)
    numbers = (float(np.median(found)), low, high, float(found[0]), float(found[-1]), float(np.mean(found)))
    return Spread(len(whole), len(found), *(float(f"{value:.{DIGITS}g}") for value in numbers))


def prediction_interval(ordered: np.ndarray, logarithmic: bool = False) -> tuple[float, float]:
    """Interval that holds one more value with probability .95, given sorted values (n,).

    From 39 values on by order statistics, whatever the distribution; below by Student's t, of the logarithms where
    that is asked for and all are positive; of one value that value.
    """
    n = len(ordered)
    if n == 1:
        return float(ordered[0]), float(ordered[0])
    rank = int((1.0 - COVERAGE) / 2.0 * (n + 1))
    if rank >= 1:
        return float(ordered[rank - 1]), float(ordered[n - rank])
    if logarithmic and ordered[0] > 0.0:
        low, high = _student(np.log(ordered))
        return math.exp(low), math.exp(high)
    return _student(ordered)


def _student(values: np.ndarray) -> tuple[float, float]:
    from scipy.special import stdtrit

    n = len(values)
    half = stdtrit(n - 1, 0.5 + COVERAGE / 2.0) * float(np.std(values, ddof=1)) * math.sqrt(1.0 + 1.0 / n)
    middle = float(np.mean(values))
    return middle - half, middle + half


def summarise(runs: Sequence[Mapping[str, Any]], logarithmic: Container[str] = ()) -> dict[str, Spread]:
    """Key -> spread over the runs of one study, each a mapping of key to value; absent and null are not numbers.

    `logarithmic` are the keys whose interval is taken of the logarithms.
    """
    keys = dict.fromkeys(key for values in runs for key in values)
    each = {key: [values.get(key) for values in runs] for key in keys}
    numbers = {key: [math.nan if value is None else float(value) for value in own] for key, own in each.items()}
    return {key: spread(own, key in logarithmic) for key, own in numbers.items()}
