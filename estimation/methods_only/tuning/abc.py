"""The artificial bee colony as an Optuna sampler (`bee_colony`, `moves`).

The sampler itself has no state: the role of a trial is stored with the trial, and the colony is built from
the trials in the order of their numbers.  So threads, processes and machines that share a storage work on one colony,
and a stored study is continued as if it had never been interrupted.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from optuna.distributions import BaseDistribution
from optuna.samplers import BaseSampler
from optuna.search_space import IntersectionSearchSpace
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState

from ....datasets import randomness
from .bee_colony import EMPLOYED, FITNESS, ONLOOKER, SCOUT, Colony, Role, selection_probabilities
from .moves import neighbour, random_value

if TYPE_CHECKING:
    from optuna.study import Study

ROLE = "helmbench:abc"
"""System attribute under which a trial's role is stored."""
PAPER_003: Mapping[str, Any] = {"n_sources": 30, "n_onlookers": 30, "limit": 35, "fitness": "reciprocal"}
"""Settings of paper 003, table 3, and the fitness 1/(1 + f) of the algorithm it refers to; 30 cycles: 1830 trials."""


class ABCSampler(BaseSampler):
    """Artificial bee colony for one objective, with numerical and categorical parameters, logarithmic ones included.

    Parameters that not all trials have (conditional ones, changing ranges) are sampled independently.  A pruned trial
    counts as the worst of all, a failed one as a neighbour that was no better.  Trials from elsewhere (enqueued ones,
    those of another sampler) take an empty source or replace the worst one.

    Parameters
    ----------
    n_sources : food sources, each with one employed bee; at least 2.
    n_onlookers : onlookers in a cycle; default: n_sources.
    limit : failures in a row after which a source is abandoned; default: n_sources times the number of parameters.
    fitness : 'rank' (linear in the rank), or 'reciprocal' as printed.
    seed : integer or Generator.  The random numbers of a trial follow from the seed and the trial's number, so a study
        that is continued, or shared by processes with the same seed, repeats nothing.
    independent_sampler : for parameters outside the common search space; default: uniform.

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
        independent_sampler: BaseSampler | None = None,
    ) -> None:
        if n_sources < 2 or (n_onlookers is not None and n_onlookers < 0) or (limit is not None and limit < 1):
            raise ValueError("a colony needs n_sources >= 2, n_onlookers >= 0 and limit >= 1")
        if fitness not in FITNESS:
            raise ValueError(f"unknown fitness {fitness!r}, known: {', '.join(FITNESS)}")
        self.n_sources, self.limit, self.fitness = n_sources, limit, fitness
        self.n_onlookers = n_sources if n_onlookers is None else n_onlookers
        self.entropy = _entropy(seed)
        self._independent = independent_sampler
        self._space = IntersectionSearchSpace(include_pruned=True)
        self._finished: tuple[int, Any, Colony] = (0, None, Colony(n_sources))

    def reseed_rng(self) -> None:
        """Reseed the independent sampler; the numbers of this sampler differ from trial to trial anyway."""
        if self._independent is not None:
            self._independent.reseed_rng()

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
        if self._independent is not None:
            return self._independent.sample_independent(study, trial, param_name, param_distribution)
        return random_value(param_distribution, self._generator(trial, zlib.crc32(param_name.encode())))

    def before_trial(self, study: Study, trial: FrozenTrial) -> None:
        if self._independent is not None:
            self._independent.before_trial(study, trial)

    def after_trial(self, study: Study, trial: FrozenTrial, state: TrialState, values: Sequence[float] | None) -> None:
        if self._independent is not None:
            self._independent.after_trial(study, trial, state, values)

    def _generator(self, trial: FrozenTrial, *more: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence(self.entropy, spawn_key=(trial.number, *more)))

    def _restore(self, study: Study, trials: Sequence[FrozenTrial]) -> tuple[Colony, set[Role]]:
        """The colony after all trials so far, and the scouts that are still running.

        The colony after the first finished trials is kept, so that a long study is not processed again every time.
        """
        count, last, colony = self._finished
        if count and not (count <= len(trials) and _stamp(trials[count - 1]) == last):
            count, colony = 0, Colony(self.n_sources)
        colony = colony.copy()
        sign = -1.0 if study.direction == StudyDirection.MAXIMIZE else 1.0
        while count < len(trials) and trials[count].number == count and trials[count].state.is_finished():
            _observe(colony, trials[count], sign)
            count += 1
        if count:
            self._finished = (count, _stamp(trials[count - 1]), colony.copy())
        return colony, _pending(colony, trials[count:], sign)

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
        turn = colony.moves % (self.n_sources + self.n_onlookers)
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


def _stamp(trial: FrozenTrial) -> tuple:
    return trial.number, trial.datetime_complete


def _role(trial: FrozenTrial) -> Role | None:
    stored = trial.system_attrs.get(ROLE)
    return Role(*stored) if stored else None


def _observe(colony: Colony, trial: FrozenTrial, sign: float) -> None:
    """Update the colony with a finished trial; a role in a larger colony than this counts as none."""
    role = _role(trial)
    if role is not None and role.source >= len(colony.sources):
        role = None
    cost = None
    if trial.state == TrialState.COMPLETE:
        assert trial.values is not None
        cost = sign * float(trial.values[0])
    elif trial.state == TrialState.PRUNED:
        cost = np.inf
    colony.observe(role, trial.params, cost)


def _pending(colony: Colony, trials: Iterable[FrozenTrial], sign: float) -> set[Role]:
    """Update the colony with the finished trials; of the running ones, count the neighbours and return the scouts."""
    scouting = set()
    for trial in trials:
        role = _role(trial)
        if trial.state.is_finished():
            _observe(colony, trial, sign)
        elif role is not None and role.kind == SCOUT:
            scouting.add(role)
        elif role is not None:
            colony.moves += 1
    return scouting
