"""The artificial bee colony as a sampler: Optuna's own checks, restarts, and niapy for comparison."""

import subprocess
import sys
from collections import Counter

import numpy as np
import optuna
import pytest
from optuna.distributions import FloatDistribution
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from optuna.testing.pytest_samplers import BasicSamplerTestCase, RelativeSamplerTestCase, SingleOnlySamplerTestCase
from optuna.trial import TrialState

from helmbench.estimation.methods_only.tuning import abc
from helmbench.estimation.methods_only.tuning.abc import ROLE, ABCSampler, Colony, Role

PLANE = {"x": FloatDistribution(-5.0, 5.0), "y": FloatDistribution(-5.0, 5.0)}


@pytest.fixture(autouse=True)
def quiet():
    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    yield
    optuna.logging.set_verbosity(before)


class TestSampler(BasicSamplerTestCase, RelativeSamplerTestCase, SingleOnlySamplerTestCase):
    """Optuna's checks for every sampler."""

    @pytest.fixture
    def sampler(self):
        return lambda: ABCSampler(n_sources=4)


def advance(study, function, count, space=PLANE):
    """Ask and tell `count` trials; a function that returns None has failed."""
    for _ in range(count):
        trial = study.ask(space)
        value = function(**trial.params)
        study.tell(trial, value, state=TrialState.FAIL if value is None else None)


def bowl(x, y):
    return (x - 1.0) ** 2 + (y + 2.0) ** 2


def roles(study):
    stored = [trial.system_attrs.get(ROLE) for trial in study.trials]
    return [role and Role(*role) for role in stored]


def test_cycles_have_employed_bees_and_onlookers():
    study = optuna.create_study(sampler=ABCSampler(n_sources=4, n_onlookers=6, limit=1000, seed=1))
    advance(study, bowl, 1 + 3 + 2 * (4 + 6))
    found = roles(study)
    assert found[0] is None  # before the first trial no parameter is known
    assert [role.kind for role in found[1:4]] == ["scout"] * 3
    assert sorted(role.source for role in found[1:4]) == [1, 2, 3]
    for cycle in (found[4:14], found[14:24]):
        assert [(role.kind, role.source) for role in cycle[:4]] == [("employed", k) for k in range(4)]
        assert [role.kind for role in cycle[4:]] == ["onlooker"] * 6


def test_onlookers_prefer_good_sources():
    colony = Colony(5)
    for k in range(5):
        colony.observe(Role("scout", k, 0), {"x": k}, float(k))
    colony.moves = 5
    sampler, rng = ABCSampler(n_sources=5), np.random.default_rng(2)
    chosen = Counter(sampler._next_role(colony, set(), 1, rng).source for _ in range(1500))
    np.testing.assert_allclose([chosen[k] / 1500 for k in range(5)], np.arange(5, 0, -1) / 15, atol=0.05)


def test_a_source_is_abandoned_after_the_limit():
    study = optuna.create_study(sampler=ABCSampler(n_sources=3, limit=2, seed=3))
    values = iter(range(100))
    advance(study, lambda x, y: float(next(values)), 30)  # nothing is ever better than what was there
    scouts = [role for role in roles(study)[1:] if role.kind == "scout" and role.life > 0]
    assert len(scouts) >= 5
    lives = Counter(role.source for role in scouts)
    assert all([role.life for role in scouts if role.source == k] == list(range(1, n + 1)) for k, n in lives.items())


def test_the_same_seed_gives_the_same_study():
    found = []
    for seed in (7, 7, 8, np.random.default_rng(7), np.random.default_rng(7)):
        study = optuna.create_study(sampler=ABCSampler(n_sources=4, seed=seed))
        advance(study, bowl, 30)
        found.append([trial.params for trial in study.trials])
    assert found[0] == found[1] != found[2]
    assert found[3] == found[4] != found[0]


def test_maximising_is_minimising_the_negative():
    found = []
    for direction, sign in (("minimize", 1.0), ("maximize", -1.0)):
        study = optuna.create_study(direction=direction, sampler=ABCSampler(n_sources=4, seed=5))
        advance(study, lambda x, y, sign=sign: sign * bowl(x, y), 60)
        found.append([trial.params for trial in study.trials])
    assert found[0] == found[1]


def test_a_restart_continues_the_colony(tmp_path, rng):
    seed = int(rng.integers(2**32))
    whole = optuna.create_study(sampler=ABCSampler(n_sources=5, limit=4, seed=seed))
    advance(whole, bowl, 70)
    for _ in range(7):
        storage = JournalStorage(JournalFileBackend(str(tmp_path / "study.journal")))
        sampler = ABCSampler(n_sources=5, limit=4, seed=seed)
        study = optuna.create_study(storage=storage, study_name="bees", sampler=sampler, load_if_exists=True)
        advance(study, bowl, 10)
    assert [trial.params for trial in study.trials] == [trial.params for trial in whole.trials]
    assert roles(study) == roles(whole)


def test_trials_lost_with_their_process_do_not_stop_the_colony():
    study = optuna.create_study(sampler=ABCSampler(n_sources=4, limit=3, seed=4))
    advance(study, bowl, 1)
    for _ in range(8):
        study.ask(PLANE)  # never finished
    advance(study, bowl, 80)
    occupied = {role.source for role, trial in zip(roles(study), study.trials, strict=True) if role and trial.values}
    assert occupied == {0, 1, 2, 3}
    assert study.best_value < 1e-2


def test_failed_and_pruned_trials():
    study = optuna.create_study(sampler=ABCSampler(n_sources=4, seed=6))

    def half(trial):
        x, y = trial.suggest_float("x", -5, 5), trial.suggest_float("y", -5, 5)
        if x < -2.0:
            raise optuna.TrialPruned
        if y > 2.0:
            raise ArithmeticError
        return bowl(x, y)

    study.optimize(half, n_trials=150, catch=(ArithmeticError,))
    states = Counter(trial.state for trial in study.trials)
    assert states[TrialState.PRUNED] and states[TrialState.FAIL]
    assert states[TrialState.COMPLETE] > 100, "sources in places that fail are left"
    assert study.best_value < 1e-3


def test_all_trials_failing_is_random_search():
    study = optuna.create_study(sampler=ABCSampler(n_sources=3, seed=6))
    advance(study, lambda x, y: None, 20)
    assert len({trial.params["x"] for trial in study.trials}) == 20


def test_an_infinite_value_counts_as_a_bad_one():
    study = optuna.create_study(sampler=ABCSampler(n_sources=8, seed=6))
    advance(study, lambda x, y: bowl(x, y) if x > 0.0 else float("inf"), 250)
    assert study.best_value < 1e-2


def test_enqueued_trials_are_used():
    study = optuna.create_study(sampler=ABCSampler(n_sources=3, limit=1000, seed=2))
    advance(study, bowl, 10)
    study.enqueue_trial({"x": 1.0, "y": -2.0})
    advance(study, bowl, 12)
    assert study.trials[10].value == 0.0 and ROLE not in study.trials[10].system_attrs
    colony, _ = study.sampler._restore(study, study.trials)
    assert {"x": 1.0, "y": -2.0} in [source.params for source in colony.sources]


def test_mixed_parameters_with_conditions(rng):
    def objective(trial):
        kernel = trial.suggest_categorical("kernel", ["linear", "rbf"])
        c = trial.suggest_float("C", 1e-2, 1e10, log=True)
        width = trial.suggest_float("width", 0.1, 10.0, log=True) if kernel == "rbf" else 5.0
        degree = trial.suggest_int("degree", 1, 9)
        return (np.log10(c) - 3.0) ** 2 + (degree - 4) ** 2 + np.log10(width) ** 2

    study = optuna.create_study(sampler=ABCSampler(n_sources=6, seed=rng))
    study.optimize(objective, n_trials=250)
    assert {trial.params["kernel"] for trial in study.trials} == {"linear", "rbf"}
    assert study.best_params["degree"] == 4
    assert study.best_value < 0.6, "0.49 is the best of the linear branch"


def test_threads_share_a_colony(rng):
    study = optuna.create_study(sampler=ABCSampler(n_sources=5, seed=rng))
    study.optimize(
        lambda trial: bowl(trial.suggest_float("x", -5, 5), trial.suggest_float("y", -5, 5)), n_trials=320, n_jobs=4
    )
    assert len(study.trials) == 320
    assert len({tuple(trial.params.values()) for trial in study.trials}) == 320, "no point is tried twice"
    assert study.best_value < 1e-2


WORKER = """
import sys
import optuna
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from helmbench.estimation.methods_only.tuning.abc import ABCSampler
study = optuna.create_study(
    storage=JournalStorage(JournalFileBackend(sys.argv[1])), study_name="bees", load_if_exists=True,
    sampler=ABCSampler(n_sources=4, seed=1),
)
study.optimize(lambda t: (t.suggest_float("x", -5, 5) - 1) ** 2 + (t.suggest_float("y", -5, 5) + 2) ** 2, n_trials=50)
"""


@pytest.mark.nightly
def test_processes_share_a_colony(tmp_path):
    path = str(tmp_path / "study.journal")
    workers = [subprocess.Popen([sys.executable, "-c", WORKER, path], stderr=subprocess.DEVNULL) for _ in range(2)]
    assert [worker.wait(timeout=300) for worker in workers] == [0, 0]
    study = optuna.load_study(storage=JournalStorage(JournalFileBackend(path)), study_name="bees")
    assert len(study.trials) == 100
    assert len({tuple(trial.params.values()) for trial in study.trials}) == 100, "the same seed in both, no repetition"
    assert {role.source for role in roles(study) if role} == {0, 1, 2, 3}


@pytest.mark.parametrize("options", [{"n_sources": 1}, {"n_onlookers": -1}, {"limit": 0}, {"fitness": "best"}], ids=str)
def test_impossible_options(options):
    with pytest.raises(ValueError):
        ABCSampler(**options)


BUDGET, REPEATS, SOURCES, DIMENSION = 600, 5, 10, 3
"""Evaluations, repetitions, food sources and dimension of the comparison with niapy."""
COMPARABLE = 1.0
"""Decades by which the mean best value may lie above niapy's, besides three standard errors."""


FUNCTIONS = {
    "sphere": (5.12, lambda x: float(np.sum(x**2))),
    "rosenbrock": (2.048, lambda x: float(np.sum(100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2))),
    "rastrigin": (5.12, lambda x: float(np.sum(x**2 - 10.0 * np.cos(2.0 * np.pi * x) + 10.0))),
}


def best_of(sampler, bound, function):
    """Logarithm of the best value that a sampler finds within the budget."""
    space = {f"x{i}": FloatDistribution(-bound, bound) for i in range(DIMENSION)}
    study = optuna.create_study(sampler=sampler)
    advance(study, lambda **params: function(np.array([*params.values()])), BUDGET, space)
    return np.log10(study.best_value + 1e-12)


def best_of_niapy(seed, bound, function):
    from niapy.algorithms.basic import ArtificialBeeColonyAlgorithm
    from niapy.problems import Problem
    from niapy.task import Task

    class Wrapped(Problem):
        def _evaluate(self, x):
            return function(x)

    task = Task(Wrapped(DIMENSION, -bound, bound), max_evals=BUDGET)
    colony = ArtificialBeeColonyAlgorithm(population_size=2 * SOURCES, limit=SOURCES * DIMENSION, seed=seed)
    return np.log10(colony.run(task)[1] + 1e-12)


@pytest.mark.nightly
@pytest.mark.parametrize("name", FUNCTIONS)
def test_as_good_as_niapy(name, rng):
    seeds = rng.integers(2**31, size=REPEATS).tolist()
    ours = np.array([best_of(ABCSampler(SOURCES, seed=seed), *FUNCTIONS[name]) for seed in seeds])
    theirs = np.array([best_of_niapy(seed, *FUNCTIONS[name]) for seed in seeds])
    error = np.sqrt((ours.var(ddof=1) + theirs.var(ddof=1)) / REPEATS)
    print(f"{name}: log10 of the best, ours {ours.mean():.2f}, niapy {theirs.mean():.2f}, standard error {error:.2f}")
    assert ours.mean() < theirs.mean() + COMPARABLE + 3.0 * error


def test_random_search_is_not_as_good_as_niapy():
    random = [best_of(optuna.samplers.RandomSampler(seed), *FUNCTIONS["sphere"]) for seed in range(2)]
    theirs = [best_of_niapy(seed, *FUNCTIONS["sphere"]) for seed in range(2)]
    assert np.mean(random) > np.mean(theirs) + 2.0 * COMPARABLE


# ---- Food sources and their fitness.


def test_rank_fitness_separates_small_costs():
    costs = np.array([3e-11, 1e-11, 2e-11, 2e-11])
    np.testing.assert_array_equal(abc.rank_fitness(costs), [1.0, 4.0, 2.5, 2.5])
    assert np.ptp(abc.reciprocal_fitness(costs)) < 1e-10
    np.testing.assert_allclose(abc.reciprocal_fitness(np.array([1.0, np.inf, -2.0])), [0.5, 0.0, 3.0])
    np.testing.assert_array_equal(abc.selection_probabilities(np.zeros(4)), 0.25)


def test_neighbours_of_an_abandoned_source_do_not_bring_it_back():
    colony = Colony(2)
    colony.observe(Role("scout", 0, 0), {"x": 0}, 1.0)
    colony.observe(Role("scout", 0, 1), {"x": 5}, 9.0)
    colony.observe(Role("employed", 0, 0), {"x": 1}, 0.5)
    assert (colony.sources[0].cost, colony.sources[0].failures) == (9.0, 0)
    colony.observe(Role("employed", 0, 1), {"x": 6}, 8.0)
    assert (colony.sources[0].cost, colony.sources[0].params) == (8.0, {"x": 6})
