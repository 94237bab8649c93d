"""The artificial bee colony: food sources, and how finished trials change them.

Karaboga & Basturk 2007, J. Global Optimization 39, 459-471.  A colony holds food sources, each a point with its cost.
In every cycle one employed bee per source, and then as many onlookers as configured, try a neighbour of a source.  The
neighbour replaces the source where it is better.  Onlookers choose sources by fitness.  A source whose neighbours fail
`limit` times in a row is abandoned, and a scout puts a random point in its place.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

SCOUT, EMPLOYED, ONLOOKER = "scout", "employed", "onlooker"


class Role(NamedTuple):
    """Role of a trial in the colony: a scout for the `life`-th place of a source, or a neighbour of that place."""

    kind: str
    source: int
    life: int


@dataclass(frozen=True)
class Source:
    """A food source: parameters and cost of its place, failures since the last improvement, times it was abandoned."""

    params: Mapping[str, Any] = field(default_factory=dict)
    cost: float = np.inf
    failures: int = 0
    life: int = 0
    occupied: bool = False


class Colony:
    """All sources, and the number of neighbours tried so far."""

    def __init__(self, n_sources: int) -> None:
        self.sources = [Source() for _ in range(n_sources)]
        self.moves = 0

    def copy(self) -> Colony:
        """An independent copy."""
        other = Colony(0)
        other.sources, other.moves = list(self.sources), self.moves
        return other

    @property
    def occupied(self) -> list[int]:
        """Indices of the sources that have a place."""
        return [k for k, source in enumerate(self.sources) if source.occupied]

    def observe(self, role: Role | None, params: Mapping[str, Any], cost: float | None) -> None:
        """Update the sources with a finished trial; cost None: it failed."""
        if role is not None and role.kind != SCOUT:
            self._neighbour(role, params, cost)
        elif cost is not None:
            self._place(role, params, cost)

    def _neighbour(self, role: Role, params: Mapping[str, Any], cost: float | None) -> None:
        self.moves += 1
        source = self.sources[role.source]
        if not source.occupied or source.life != role.life:
            return  # the source was abandoned in the meantime
        if cost is not None and cost < source.cost:
            self.sources[role.source] = replace(source, params=params, cost=cost, failures=0)
        else:
            self.sources[role.source] = replace(source, failures=source.failures + 1)

    def _place(self, role: Role | None, params: Mapping[str, Any], cost: float) -> None:
        """A scout's place, or a trial from elsewhere: for its source, else for an empty one, else for the worst one."""
        if role is not None:
            source = self.sources[role.source]
            if not source.occupied or source.life < role.life:
                self.sources[role.source] = Source(params, cost, 0, role.life, True)
                return
        empty = next((k for k, source in enumerate(self.sources) if not source.occupied), None)
        if empty is not None:
            self.sources[empty] = Source(params, cost, 0, self.sources[empty].life, True)
            return
        worst = max(range(len(self.sources)), key=lambda k: self.sources[k].cost)
        if cost < self.sources[worst].cost:
            self.sources[worst] = Source(params, cost, 0, self.sources[worst].life + 1, True)


def rank_fitness(costs: np.ndarray) -> np.ndarray:
    """Fitness (S,) from 1 (worst) to S (best) by rank, equal costs (S,) sharing their mean rank."""
    worse = (costs[None, :] > costs[:, None]).sum(axis=1)
    equal = (costs[None, :] == costs[:, None]).sum(axis=1)
    return worse + (equal + 1.0) / 2.0


def reciprocal_fitness(costs: np.ndarray) -> np.ndarray:
    """Fitness (S,) as printed: 1/(1 + f), or 1 + |f| for f < 0, of costs (S,); nearly equal for costs far below 1."""
    return np.where(costs >= 0.0, 1.0 / (1.0 + np.abs(costs)), 1.0 + np.abs(costs))


FITNESS: dict[str, Callable[[np.ndarray], np.ndarray]] = {"rank": rank_fitness, "reciprocal": reciprocal_fitness}


def selection_probabilities(fitness: np.ndarray) -> np.ndarray:
    """Probabilities (S,) proportional to fitness values (S,) >= 0; equal where these have no finite positive sum."""
    total = fitness.sum()
    if not (np.isfinite(total) and total > 0.0):
        return np.full(fitness.size, 1.0 / fitness.size)
    return fitness / total
