"""Tuning: spaces, validation, every tuner, shared storages, tuned methods in suites."""

import json
import pickle
import subprocess
import sys
from typing import ClassVar

import numpy as np
import optuna
import pytest

from helmbench.bench.problems import Task
from helmbench.bench.runner import RunSpec, _named, execute
from helmbench.datasets.generator import Case, generate
from helmbench.methods import contract
from helmbench.methods.base import CannotFit, Fit, FitFailed, Method
from helmbench.methods.ls import Ls
from helmbench.methods.registry import make
from helmbench.methods.tuning import tuned as tuned_module
from helmbench.methods.tuning.space import Choice, Integer, Real, grid_of
from helmbench.methods.tuning.tune import TUNERS, sampler_of, storage_of, tune, validation_of
from helmbench.methods.tuning.tuned import STORAGE, with_tuner
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

SHIP = "response-1"


class Scaled(Ls):
    """Least squares times a factor, which a tuner should find to be 1."""

    name = "scaled"
    title = "a method with an option whose best value is known"
    search_space: ClassVar = {"factor": Real(0.01, 100.0, log=True)}

    def __init__(self, factor: float = 5.0, fail_above: float = 1e9, scheme: str = "forward") -> None:
        super().__init__(scheme)
        self.factor, self.fail_above = factor, fail_above

    def estimate(self, records, model) -> Fit:
        if self.factor > self.fail_above:
            raise FitFailed("too large")
        found = super().estimate(records, model)
        return found._replace(coefficients=found.coefficients * np.array([1.0, self.factor, 1.0]))


@pytest.fixture(scope="module")
def records():
    return [generate(Case(SHIP, text, duration_s=40)) for text in ("zigzag:20/20", "zigzag:10/10")]


@pytest.fixture(scope="module")
def model():
    return resolve(SHIP).blanked()


def run(records, model, method=None, **options):
    method = method or Scaled()
    return tune(method, type(method).search_space, records, model, **options)


@pytest.mark.parametrize("tuner", [name for name in TUNERS if name != "gp"])
@pytest.mark.parametrize("validation", ["split", "held-out"])
def test_every_tuner_finds_the_factor(tuner, validation, records, model):
    found = run(records, model, tuner=tuner, n_trials=25, validation=validation)
    assert found.trials == 25 and found.failed == 0 and found.seconds > 0.0
    assert abs(np.log(found.options["factor"])) < 0.7, "25 points in four decades"
    assert 0.0 < found.error < 2.0
    json.dumps(found.as_dict())


def test_any_optuna_sampler(records, model):
    found = run(records, model, tuner=optuna.samplers.NSGAIISampler(seed=1), n_trials=16)
    assert found.tuner == "NSGAIISampler" and found.trials == 16


def test_the_gaussian_process_says_what_it_needs(monkeypatch):
    monkeypatch.setattr("helmbench.methods.tuning.tune.find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"needs torch; pip install 'helmbench\[gp\]'"):
        sampler_of("gp", Scaled.search_space, 10, 0)
    monkeypatch.setattr("helmbench.methods.tuning.tune.find_spec", lambda name: name)
    assert isinstance(sampler_of("gp", Scaled.search_space, 10, 0), optuna.samplers.GPSampler)


@pytest.mark.parametrize("tuner", ["abc", "tpe", "grid", "random"])
def test_the_same_seed_finds_the_same(tuner, records, model):
    first, again = (run(records, model, tuner=tuner, n_trials=12, seed=3) for _ in range(2))
    assert first.options == again.options and first.error == again.error


def test_failed_fits_are_failed_trials(records, model):
    found = run(records, model, Scaled(fail_above=1.0), n_trials=30)
    assert 0 < found.failed < 30 and found.options["factor"] <= 1.0
    with pytest.raises(FitFailed, match="too large"):
        run(records, model, Scaled(fail_above=0.0), n_trials=5)


def test_diverging_runs_lose(records, model):
    class Wild(Scaled):
        def estimate(self, records, model):
            found = super().estimate(records, model)
            return found._replace(coefficients=found.coefficients * (-1e9 if self.factor < 1.0 else 1.0))

    assert run(records, model, Wild(), n_trials=30).options["factor"] >= 1.0


def test_the_method_is_not_changed(records, model):
    method = Scaled(factor=7.0)
    run(records, model, method, n_trials=5)
    assert method.factor == 7.0


def test_split_judges_what_was_not_fitted(records):
    held = validation_of(records, "split")
    assert [r.n for r in held.train] == [int(0.6 * r.n) for r in records] == list(held.since)
    assert held.judged == tuple(records)
    held = validation_of(records, "held-out")
    assert held.train == (records[0],) and held.judged == (records[1],)
    with pytest.raises(CannotFit, match="two records"):
        validation_of(records[:1], "held-out")
    with pytest.raises(CannotFit, match="too short"):
        validation_of([records[0].slice(0, 15)], "split")
    with pytest.raises(BadInput, match="unknown validation"):
        validation_of(records, "cross")


def test_the_error_is_that_of_a_free_run(records, model):
    exact = Ls().fit([generate(Case(SHIP, "zigzag:20/20@euler"))], model)

    class Fixed(Method):
        name, title, factor = "fixed", "knows the ship", 1.0

        def estimate(self, records, model):
            return Fit(exact.coefficients * np.array([1.0, self.factor, 1.0]))

    held = validation_of(records, "split")
    assert held.error(Fixed(), model) < 1e-6
    dead = Fixed()
    dead.factor = 0.0
    rate = np.concatenate([r.column("yaw_rate_rad_s")[k:] for r, k in zip(records, held.since, strict=True)])
    assert 0.5 < held.error(dead, model) < 5.0 and np.std(rate) > 0.0


def test_spaces():
    space = {"a": Real(1e-2, 1e2, log=True), "n": Integer(1, 3), "k": Choice("x", "y")}
    grid = grid_of(space, 50)
    assert grid["k"] == ["x", "y"] and grid["n"] == [1, 2, 3]
    np.testing.assert_allclose(grid["a"], np.geomspace(1e-2, 1e2, 5))
    assert len(grid_of({"a": space["a"]}, 25)["a"]) == 25
    for wrong in (lambda: Real(1.0, 1.0), lambda: Real(0.0, 1.0, log=True), lambda: Integer(3, 2), Choice):
        with pytest.raises(BadInput):
            wrong()
    with pytest.raises(BadInput, match="cmaes"):
        sampler_of("cmaes", space, 10, 0)
    with pytest.raises(BadInput, match="unknown tuner"):
        sampler_of("bees", space, 10, 0)


@pytest.mark.parametrize("text", ["{}/s.journal", "sqlite:///{}/s.db"])
def test_a_stored_study_is_continued(text, tmp_path, records, model):
    storage = text.format(tmp_path)
    whole = run(records, model, n_trials=20, seed=5)
    assert run(records, model, n_trials=8, seed=5, storage=storage, study_name="one").trials == 8
    found = run(records, model, n_trials=20, seed=5, storage=storage, study_name="one")
    assert found.trials == 20 and found.error == pytest.approx(whole.error, rel=1e-6)
    assert run(records, model, n_trials=20, seed=5, storage=storage, study_name="one") == found, "nothing left to do"


def test_studies_of_different_things_do_not_meet(tmp_path, records, model):
    storage = str(tmp_path / "s.journal")
    cases = [
        run(records, model, n_trials=3, storage=storage),
        run(records[:1], model, n_trials=3, storage=storage),
        run(records, model, Scaled(fail_above=1e3), n_trials=3, storage=storage),
        run(records, model, n_trials=3, storage=storage, seed=1),
        run(records, model, n_trials=3, storage=storage, tuner="tpe"),
    ]
    assert len({found.study for found in cases}) == 5 and all(found.trials == 3 for found in cases)


@pytest.mark.parametrize(
    "text", ["study.txt", "/no/such/folder/s.journal", "nodb://x", "sqlite:////no/such/folder/s.db"]
)
def test_impossible_storages_are_one_line(text):
    with pytest.raises(BadInput) as caught:
        storage_of(text)
    assert "\n" not in str(caught.value) and text.rpartition("/")[0] in str(caught.value)


WORKER = """
import json, sys
from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve
records = [generate(Case("response-1", "zigzag:20/20", "low", duration_s=40))]
estimate = make("tuned:sklearn:Ridge,trials=24").fit(records, resolve("response-1").blanked())
print(json.dumps(estimate.extra["tuning"]))
"""


def test_two_processes_tune_together(tmp_path, monkeypatch):
    path = tmp_path / "together.journal"
    monkeypatch.setenv(STORAGE, str(path))
    command = [sys.executable, "-c", WORKER]
    workers = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    outputs = [worker.communicate(timeout=300)[0] for worker in workers]
    found = [json.loads(output) for output in outputs]
    assert found[0]["study"] == found[1]["study"]
    (study,) = optuna.get_all_study_summaries(storage_of(str(path)))
    assert 24 <= study.n_trials <= 25, "one budget for both; the last two may be under way together"
    trials = optuna.load_study(study_name=study.study_name, storage=storage_of(str(path))).trials
    assert len({trial.params["alpha"] for trial in trials}) == study.n_trials, "no point is tried twice"
    assert min(found, key=lambda one: -one["trials"])["error"] == min(trial.value for trial in trials)


def test_tuned_methods_from_text(records, model):
    method = make("tuned:fw-rls,tuner=random,trials=6,mu=0.99")
    assert list(method.space) == ["weight"]
    assert method.get_params()["mu"] == 0.99 and method.clone().get_params() == method.get_params()
    again = pickle.loads(pickle.dumps(method))
    assert again.get_params() == method.get_params() and type(again).name == "tuned:fw-rls"
    estimate = method.fit(records, model)
    assert estimate.method == "tuned:fw-rls" and set(estimate.parameters) == set(model.parameter_names)
    assert estimate.trajectory is not None
    tuning = estimate.extra["tuning"]
    assert tuning["trials"] == 6 and set(tuning["options"]) == {"weight"}
    assert estimate.wall_s >= tuning["seconds"] > 0.0, "the tuning counts in the method's time"


def test_tuning_pays(rng):
    """On a noisy record a badly chosen option is put right."""
    case = Case(SHIP, "zigzag:20/20", "low", seed=int(rng.integers(1000)), duration_s=60)
    held_out = generate(Case(SHIP, "zigzag:10/10", duration_s=60))
    model, train = resolve(SHIP).blanked(), [generate(case)]
    from helmbench.methods.predictor import free_run_error, predictor_of

    plain = make("sklearn:Ridge,alpha=10000").fit(train, model)
    tuned = make("tuned:sklearn:Ridge,trials=12").fit(train, model)
    errors = [free_run_error(predictor_of(one), [held_out], model) for one in (plain, tuned)]
    assert errors[1] < 0.3 * errors[0]


def test_a_variant_stays_as_it_is(records, model):
    method = make("tuned:fw-rls,trials=3,variant=as_printed")
    assert _named("tuned:fw-rls,trials=3,variant=as_printed") == ("tuned:fw-rls,trials=3", "as_printed")
    assert method.variant == "as_printed"


def test_a_tuned_method_is_a_row_of_a_suite():
    task = Task(SHIP, SHIP, "nomoto-1-cubic", ("zigzag:20/20",), ("zigzag:10/10",), "low", duration_s=40)
    maker = "tuned:sklearn:Ridge,tuner=grid,trials=5"
    run = execute(RunSpec("quick", *_named(maker), maker, task))
    assert run["row"]["status"] == "ok", run["row"]["error"]
    assert run["row"]["method"] == maker and run["row"]["r2_free_yaw_rate_rad_s"] > 0.8


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("tuned:no-such", "unknown method 'no-such'"),
        ("tuned:tuned:fw-rls", "tuned already"),
        ("tuned:output-error", "declares no options to tune"),
        ("tuned:sklearn:Rigde", "did you mean Ridge"),
        ("tuned:fw-rls,tuner=bees", "unknown tuner 'bees'"),
        ("tuned:fw-rls,trials=0", "trials is 0"),
        ("tuned:fw-rls,trials=many", "trials is 'many'"),
        ("tuned:fw-rls,validation=cross", "unknown validation"),
        ("tuned:fw-rls,mu=2", "mu is 2"),
        ("tuned:fw-rls,mu=1,weight=1", "every option"),
        ("tuned:fw-rls,gamma=1", "no option 'gamma'"),
    ],
)
def test_bad_texts_are_one_line(text, words):
    with pytest.raises(BadInput) as caught:
        make(text)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_command_line_options(tmp_path, monkeypatch):
    monkeypatch.setenv(STORAGE, "")
    storage = str(tmp_path / "s.journal")
    assert with_tuner(("ls",)) == ("ls",) and with_tuner((), None, storage) == ()
    assert with_tuner(("fw-rls,scheme=midpoint", "tuned:fw-rls"), "tpe", storage) == (
        "tuned:fw-rls,scheme=midpoint,tuner=tpe",
        "tuned:fw-rls,tuner=tpe",
    )
    assert tuned_module.os.environ[STORAGE] == storage
    for wrong in (((), "abc", None), (("ls",), None, storage), (("tuned:fw-rls",), None, "nowhere")):
        with pytest.raises(BadInput):
            with_tuner(*wrong)


@pytest.mark.parametrize(
    "check", [contract.check_options, contract.check_estimate, contract.check_pickles, contract.check_too_short]
)
def test_contract(check, monkeypatch):
    cls = tuned_module.tuned("fw-rls")
    monkeypatch.setattr(cls.__init__, "__defaults__", ("random", 2, "split", 0, None))
    contract.applicable.cache_clear()
    check(cls)


def test_every_search_space_is_of_the_methods_own_options():
    from helmbench.methods.black_box import SPACES, regressor
    from helmbench.methods.registry import methods

    for cls in [*methods().values(), *(regressor(name) for name in SPACES)]:
        assert set(cls.search_space) <= set(cls.option_names()), cls.name
        for name, domain in cls.search_space.items():
            for value in domain.grid(2):
                make(cls.name).set_params(**{name: value}).check_options()
