"""Tuned methods: from text, in suites, from several processes."""

import json
import pickle
import subprocess
import sys

import optuna
import pytest

from helmbench.bench.kinds.identification.execute import execute
from helmbench.bench.kinds.identification.plan import RunSpec, _named
from helmbench.bench.kinds.identification.problems import Task
from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.tuning.tune import storage_of
from helmbench.methods import contract
from helmbench.methods import tuned as tuned_module
from helmbench.methods.registry import make
from helmbench.methods.tuned import STORAGE, with_tuner
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

SHIP = "response-1"


@pytest.fixture(scope="module")
def records():
    return [generate(Case(SHIP, text, duration_s=40)) for text in ("zigzag:20/20", "zigzag:10/10")]


@pytest.fixture(scope="module")
def model():
    return resolve(SHIP).blanked()


WORKER = """
import json, sys
from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve
records = [generate(Case("response-1", "zigzag:20/20", "low", duration_s=40))]
estimate = make("tuned:sklearn:Ridge,trials=24").fit(records, resolve("response-1").blanked())
print(json.dumps(estimate.extra["tuning"]))
"""


@pytest.mark.nightly
def test_two_processes_tune_together(tmp_path, monkeypatch):
    path = tmp_path / "together.journal"
    monkeypatch.setenv(STORAGE, str(path))
    command = [sys.executable, "-c", WORKER]
    workers = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    outputs = [worker.communicate(timeout=300)[0] for worker in workers]
    found = [json.loads(output) for output in outputs]
    assert found[0]["study"] == found[1]["study"]
    (study,) = optuna.get_all_study_summaries(storage_of(str(path)))
    assert 24 <= study.n_trials <= 25, "one budget for both; the last two may run at the same time"
    trials = optuna.load_study(study_name=study.study_name, storage=storage_of(str(path))).trials
    assert len({trial.params["alpha"] for trial in trials}) == study.n_trials, "no point is tried twice"
    assert min(found, key=lambda one: -one["trials"])["error"] == min(trial.value for trial in trials)


def test_tuned_methods_from_text(records, model):
    from sklearn.base import clone

    method = make("tuned:fw-rls,tuner=random,trials=6,mu=0.99")
    assert list(method.space) == ["weight"]
    assert method.get_params()["mu"] == 0.99 and clone(method).get_params() == method.get_params()
    again = pickle.loads(pickle.dumps(method))
    assert again.get_params() == method.get_params() and type(again).name == "tuned:fw-rls"
    estimate = method.fit(records, model)
    assert estimate.method == "tuned:fw-rls" and set(estimate.parameters) == set(model.parameter_names)
    assert estimate.trajectory is not None
    tuning = estimate.extra["tuning"]
    assert tuning["trials"] == 6 and set(tuning["options"]) == {"weight"}
    assert estimate.wall_s >= tuning["seconds"] > 0.0, "the method's time includes the tuning"


def test_tuning_corrects_a_bad_option(rng):
    """A badly chosen option on a noisy record."""
    case = Case(SHIP, "zigzag:20/20", "low", seed=int(rng.integers(1000)), duration_s=60)
    held_out = generate(Case(SHIP, "zigzag:10/10", duration_s=60))
    model, train = resolve(SHIP).blanked(), [generate(case)]
    from helmbench.estimation.estimates.estimate import predictor_of
    from helmbench.estimation.results.predictor import free_run_error

    plain = make("sklearn:Ridge,alpha=10000").fit(train, model)
    tuned = make("tuned:sklearn:Ridge,trials=12").fit(train, model)
    errors = [free_run_error(predictor_of(one), [held_out], model) for one in (plain, tuned)]
    assert errors[1] < 0.3 * errors[0]


def test_a_given_variant_is_kept(records, model):
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


def test_contract(monkeypatch):
    """One fit for all checks."""
    cls = tuned_module.tuned("fw-rls")
    monkeypatch.setattr(cls.__init__, "__defaults__", ("random", 2, "split", 0, None))
    contract._fitted.cache_clear()
    for check in (contract.check_options, contract.check_estimate, contract.check_pickles, contract.check_too_short):
        check(cls)
