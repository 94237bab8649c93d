"""Ranges of options for tuning, as plain data that a method file can declare without importing a tuner.

class MyMethod(Method):
    search_space = {"C": Real(1e-2, 1e10, log=True), "order": Integer(1, 4), "kernel": Choice("linear", "rbf")}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.errors import BadInput

if TYPE_CHECKING:
    from optuna.trial import Trial


@dataclass(frozen=True)
class Real:
    """A real number from low to high; `log` searches on a logarithmic scale and needs low > 0."""

    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high and (self.low > 0 or not self.log)):
            scale = " on a logarithmic scale" if self.log else ""
            raise BadInput(f"no range to search from {self.low!r} to {self.high!r}{scale}")

    def suggest(self, trial: Trial, name: str) -> float:
        """A trial's value."""
        return trial.suggest_float(name, self.low, self.high, log=self.log)

    def grid(self, count: int) -> Sequence[float]:
        """`count` values, ends included, evenly spaced on its scale."""
        spaced = np.geomspace if self.log else np.linspace
        return [float(value) for value in np.clip(spaced(self.low, self.high, count), self.low, self.high)]


@dataclass(frozen=True)
class Integer(Real):
    """A whole number from low to high, both included; `log` needs low > 0."""

    low: int
    high: int

    def suggest(self, trial: Trial, name: str) -> int:
        return trial.suggest_int(name, self.low, self.high, log=self.log)

    def grid(self, count: int) -> Sequence[int]:
        """At most `count` different values, ends included."""
        return sorted({round(value) for value in super().grid(count)})


@dataclass(frozen=True, init=False)
class Choice:
    """One of some words, numbers, true, false or None."""

    values: tuple[Any, ...]

    def __init__(self, *values: Any) -> None:
        if not values:
            raise BadInput("a choice needs at least one value")
        object.__setattr__(self, "values", values)

    def suggest(self, trial: Trial, name: str) -> Any:
        """A trial's value."""
        return trial.suggest_categorical(name, self.values)

    def grid(self, count: int) -> list[Any]:
        """All values, for any `count`."""
        return list(self.values)


Domain = Real | Integer | Choice


def grid_of(space: Mapping[str, Domain], n_trials: int) -> dict[str, Sequence[Any]]:
    """Values of every option of a full grid, of at most `n_trials` points where that is possible.

    Choices take all their values; the ranges have equally many values each, at least two.
    """
    chosen = {name: domain.grid(0) for name, domain in space.items() if isinstance(domain, Choice)}
    ranges = {name: domain for name, domain in space.items() if not isinstance(domain, Choice)}
    left = n_trials / max(1, np.prod([len(values) for values in chosen.values()]))
    side = max(2, int(np.floor(left ** (1.0 / max(1, len(ranges))) + 1e-9)))
    found = chosen | {name: domain.grid(side) for name, domain in ranges.items()}
    return {name: found[name] for name in space}
