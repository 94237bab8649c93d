"""The artificial bee colony as an Optuna sampler.

Karaboga & Basturk 2007, J. Global Optimization 39, 459-471.  A colony holds food sources, each a point with its cost.
In every cycle one employed bee per source, and then as many onlookers as configured, try a neighbour of a source,

    v_j = x_j + phi (x_j - y_j),   phi uniform in (-1, 1), y another source, j one parameter,

on the parameter's own scale (continuous, integer, logarithmic, categorical) and reflected at its bounds.  The neighbour
replaces the source where it is better.  Onlookers choose sources by fitness.  A source whose neighbours fail `limit`
times in a row is abandoned, and a scout puts a random point in its place.

The role of a trial is stored with the trial, and the colony learns from every trial when it sees that it has ended.  So
threads, processes and machines that share a storage tell each other what they found, and a stored study is continued.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from optuna._transform import _SearchSpaceTransform
from optuna.distributions import BaseDistribution, CategoricalDistribution
from optuna.samplers import BaseSampler
from optuna.search_space import IntersectionSearchSpace
from optuna.study import Study, StudyDirection
from optuna.trial import FrozenTrial, TrialState
from scipy.stats import rankdata

from ....datasets import randomness

SCOUT, EMPLOYED, ONLOOKER = "scout", "employed", "onlooker"
ROLE = "helmbench:abc"
"""System attribute under which a trial's role is stored."""
PAPER_003: Mapping[str, Any] = {"n_sources": 30, "n_onlookers": 30, "limit": 35, "fitness": "reciprocal"}
"""Settings of paper 003, table 3, and the fitness 1/(1 + f) of the algorithm it refers to; 30 cycles: 1830 trials."""


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
    """All sources, and the number of neighbours tried so far and being tried."""

    def __init__(self, n_sources: int) -> None:
        self.sources = [Source() for _ in range(n_sources)]
        self.moves, self.trying = 0, 0

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
    return rankdata(-costs)


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


class ABCSampler(BaseSampler):
    """Artificial bee colony for one objective, with numerical and categorical parameters, logarithmic ones included.

    Parameters that not all trials have (conditional ones, changing ranges) are uniform on their own scale.  A pruned
    trial counts as the worst of all, a failed one as a neighbour that was no better.  Trials from elsewhere (enqueued
    ones, those of another sampler) take an empty source or replace the worst one.

    Parameters
    ----------
    n_sources : food sources, each with one employed bee; at least 2.
    n_onlookers : onlookers in a cycle; default: n_sources.
    limit : failures in a row after which a source is abandoned; default: n_sources times the number of parameters.
    fitness : 'rank' (linear in the rank), or 'reciprocal' as printed.
    seed : integer or Generator.  The random numbers of a trial follow from the seed and the trial's number, so a study
        that is continued, or shared by processes with the same seed, repeats nothing.

    Raises
    ------
    ValueError : an option is impossible, or the study has several objectives.
    """

    def __init__(
        self,
        n_sources: int = 10,
        n_onlookers: int | None = None,
        limit: int | None = None,
        fitness: str = "rank",
        seed: int | np.random.Generator | None = None,
    ) -> None:
        if n_sources < 2 or (n_onlookers is not None and n_onlookers < 0) or (limit is not None and limit < 1):
            raise ValueError("a colony needs n_sources >= 2, n_onlookers >= 0 and limit >= 1")
        if fitness not in FITNESS:
            raise ValueError(f"unknown fitness {fitness!r}, known: {', '.join(FITNESS)}")
        self.n_sources, self.limit, self.fitness = n_sources, limit, fitness
        self.n_onlookers = n_sources if n_onlookers is None else n_onlookers
        self.entropy = _entropy(seed)
        self._space = IntersectionSearchSpace(include_pruned=True)
        self._study: Any = None
        self._colony, self._ended = Colony(n_sources), set[int]()

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        return {name: found for name, found in self._space.calculate(study).items() if not found.single()}

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, Any]:
        self._raise_error_if_multi_objective(study)
        if not search_space:
            return {}
        found = study._storage.get_all_trials(study._study_id, deepcopy=False)
        trials = sorted((other for other in found if other.number != trial.number), key=lambda other: other.number)
        colony, scouting = self._restore(study, trials)
        rng = self._generator(trial)
        role, params = self._propose(colony, scouting, search_space, rng)
        if "fixed_params" not in trial.system_attrs:
            study._storage.set_trial_system_attr(trial._trial_id, ROLE, list(role))
        return params

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> Any:
        self._raise_error_if_multi_objective(study)
        return random_value(param_distribution, self._generator(trial, zlib.crc32(param_name.encode())))

    def _generator(self, trial: FrozenTrial, *more: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence(self.entropy, spawn_key=(trial.number, *more)))

    def _restore(self, study: Study, trials: Sequence[FrozenTrial]) -> tuple[Colony, set[Role]]:
        """The colony after all trials that have ended so far, and the scouts that are still running."""
        if self._study != (key := (study._storage, study._study_id)):
            self._study, self._colony, self._ended = key, Colony(self.n_sources), set()
        sign = -1.0 if study.direction == StudyDirection.MAXIMIZE else 1.0
        running: list[Role] = []
        for trial in (trial for trial in trials if trial.number not in self._ended):
            stored = trial.system_attrs.get(ROLE)
            role = Role(*stored) if stored and stored[1] < self.n_sources else None  # that of a larger colony is none
            if trial.state.is_finished():
                self._ended.add(trial.number)
                self._colony.observe(role, trial.params, _cost(trial, sign))
            elif role is not None:
                running.append(role)
        self._colony.trying = sum(role.kind != SCOUT for role in running)
        return self._colony, {role for role in running if role.kind == SCOUT}

    def _propose(
        self, colony: Colony, scouting: set[Role], space: dict[str, BaseDistribution], rng: np.random.Generator
    ) -> tuple[Role, dict[str, Any]]:
        role = self._next_role(colony, scouting, len(space), rng)
        if role.kind == SCOUT:
            return role, {name: random_value(space[name], rng) for name in space}
        others = [k for k in colony.occupied if k != role.source]
        other = colony.sources[others[rng.integers(len(others))]]
        return role, neighbour(space, colony.sources[role.source].params, other.params, rng)

    def _next_role(self, colony: Colony, scouting: set[Role], dimension: int, rng: np.random.Generator) -> Role:
        limit = self.limit or self.n_sources * dimension
        places = [
            Role(SCOUT, k, source.life + source.occupied)
            for k, source in enumerate(colony.sources)
            if not source.occupied or source.failures >= limit
        ]
        scout = next((role for role in places if role not in scouting), None)
        occupied = colony.occupied
        if scout is None and len(occupied) < 2:
            scout = places[rng.integers(len(places))]
        if scout is not None:
            return scout
        turn = (colony.moves + colony.trying) % (self.n_sources + self.n_onlookers)
        late = next((role for role in places if role.source == turn), None)
        if late is not None:
            return late  # the trial of its scout takes long, or its process has ended
        if turn < self.n_sources:
            return Role(EMPLOYED, turn, colony.sources[turn].life)
        costs = np.array([colony.sources[k].cost for k in occupied])
        source = int(rng.choice(occupied, p=selection_probabilities(FITNESS[self.fitness](costs))))
        return Role(ONLOOKER, source, colony.sources[source].life)


def _entropy(seed: int | np.random.Generator | None) -> int:
    if isinstance(seed, np.random.Generator):
        return int(seed.integers(2**63))
    if seed is None:
        return randomness.drawn_seed()
    return int(seed)


def _cost(trial: FrozenTrial, sign: float) -> float | None:
    """Cost of a trial that has ended; None: it failed."""
    if trial.state == TrialState.COMPLETE:
        assert trial.values is not None
        return sign * float(trial.values[0])
    return np.inf if trial.state == TrialState.PRUNED else None


# ---- Random values of parameters and neighbours of points.


def _scale(distribution: BaseDistribution) -> _SearchSpaceTransform:
    """The map between a numerical value and its place in [0, 1], on the distribution's own scale."""
    return _SearchSpaceTransform({"": distribution}, transform_0_1=True)


def encode(distribution: BaseDistribution, value: float) -> float:
    """Place of a numerical value in [0, 1]."""
    return float(_scale(distribution).transform({"": value})[0])


def decode(distribution: BaseDistribution, place: float) -> int | float:
    """Value at a place in [0, 1]; the inverse of `encode`."""
    return _scale(distribution).untransform(np.array([place]))[""]


def random_value(distribution: BaseDistribution, rng: np.random.Generator) -> Any:
    """A random value, uniform on the distribution's own scale."""
    if isinstance(distribution, CategoricalDistribution):
        return distribution.choices[rng.integers(len(distribution.choices))]
    return decode(distribution, rng.random())


def neighbour_value(distribution: BaseDistribution, own: Any, other: Any, rng: np.random.Generator) -> Any:
    """A neighbour of the value `own`, towards `other` or away from it; not `own` itself where another value exists."""
    if isinstance(distribution, CategoricalDistribution):
        rest = [choice for choice in distribution.choices if choice != own]
        return other if rng.random() < 0.5 and other in rest else rest[rng.integers(len(rest))]
    at = encode(distribution, own)
    step = rng.uniform(-1.0, 1.0) * (at - encode(distribution, other))
    place = abs(at + step)
    value = decode(distribution, min(place, 2.0 - place))  # reflected at the bounds
    return value if value != own else _next(distribution, own, step)


def _next(distribution: Any, own: Any, direction: float) -> Any:
    """The next value of a discrete distribution in a direction, at its end the one before; else `own`."""
    if distribution.step is None:
        return own
    step = distribution.step * (1 if direction >= 0.0 else -1)
    return own + step if distribution.low <= own + step <= distribution.high else own - step


def neighbour(
    space: Mapping[str, BaseDistribution], own: Mapping[str, Any], other: Mapping[str, Any], rng: np.random.Generator
) -> dict[str, Any]:
    """Parameters that differ from `own` in one of them, which is moved along the line to `other`.

    A category may change even where both agree: otherwise a category that all sources share could never change.
    """
    valid = {name for name in space if _holds(space[name], own, name)}
    params = {name: own[name] if name in valid else random_value(space[name], rng) for name in space}
    shared = [name for name in sorted(valid) if _holds(space[name], other, name)]
    differing = [name for name in shared if own[name] != other[name]]
    if differing:
        movable = [name for name in shared if name in differing or len(getattr(space[name], "choices", ())) > 1]
        name = movable[rng.integers(len(movable))]
        params[name] = neighbour_value(space[name], own[name], other[name], rng)
    elif valid == set(space):
        name = sorted(valid)[rng.integers(len(valid))]
        params[name] = random_value(space[name], rng)
    return params


def _holds(distribution: BaseDistribution, params: Mapping[str, Any], name: str) -> bool:
    """Whether `params` has a value that the distribution allows (an earlier session may have had another range)."""
    if name not in params:
        return False
    try:
        return distribution._contains(distribution.to_internal_repr(params[name]))
    except (ValueError, TypeError):
        return False
