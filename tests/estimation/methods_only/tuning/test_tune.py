"""Tuning: validation, every tuner, stored studies."""

import json
from typing import ClassVar

import numpy as np
import optuna
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.tuning.space import Real
from helmbench.estimation.methods_only.tuning.tune import TUNERS, sampler_of, storage_of, tune, validation_of
from helmbench.estimation.results.fit import Fit
from helmbench.methods.base import Method
from helmbench.methods.ls import Ls, LsForward
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve

SHIP = "response-1"


class ScaledLs(Ls):
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
    method = method or ScaledLs()
    return tune(method, type(method).search_space, records, model, **options)


@pytest.mark.parametrize("tuner", [name for name in TUNERS if name != "gp"])
@pytest.mark.parametrize("validation", ["split", "held-out"])
def test_every_tuner_finds_the_factor(tuner, validation, records, model):
    found = run(records, model, tuner=tuner, n_trials=25, validation=validation)
    assert found.trials == 25 and found.failed == 0 and found.seconds > 0.0
    assert abs(np.log(found.options["factor"])) < 0.7, "25 points in four decades"
    assert 0.0 < found.error < 2.0
    json.dumps(found._asdict())


def test_the_gaussian_process_says_what_it_needs(monkeypatch):
    monkeypatch.setattr("helmbench.estimation.methods_only.tuning.tune.find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"needs torch; pip install 'helmbench\[gp\]'"):
        sampler_of("gp", ScaledLs.search_space, 10, 0)
    monkeypatch.setattr("helmbench.estimation.methods_only.tuning.tune.find_spec", lambda name: name)
    assert isinstance(sampler_of("gp", ScaledLs.search_space, 10, 0), optuna.samplers.GPSampler)


@pytest.mark.parametrize("tuner", ["abc", "tpe", "grid", "random"])
def test_the_same_seed_finds_the_same(tuner, records, model):
    first, again = (run(records, model, tuner=tuner, n_trials=12, seed=3) for _ in range(2))
    assert first.options == again.options and first.error == again.error


def test_failed_fits_are_failed_trials(records, model):
    found = run(records, model, ScaledLs(fail_above=1.0), n_trials=30)
    assert 0 < found.failed < 30 and found.options["factor"] <= 1.0
    with pytest.raises(FitFailed, match="too large"):
        run(records, model, ScaledLs(fail_above=0.0), n_trials=5)


def test_diverging_runs_are_not_chosen(records, model):
    class Diverging(ScaledLs):
        def estimate(self, records, model):
            found = super().estimate(records, model)
            return found._replace(coefficients=found.coefficients * (-1e9 if self.factor < 1.0 else 1.0))

    assert run(records, model, Diverging(), n_trials=30).options["factor"] >= 1.0


def test_the_method_is_not_changed(records, model):
    method = ScaledLs(factor=7.0)
    run(records, model, method, n_trials=5)
    assert method.factor == 7.0


def test_split_validates_on_samples_that_were_not_fitted(records):
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
    exact = LsForward().fit([generate(Case(SHIP, "zigzag:20/20@euler"))], model)

    class FixedEstimate(Method):
        name, title, factor = "fixed", "returns given coefficients", 1.0

        def estimate(self, records, model):
            return Fit(exact.coefficients * np.array([1.0, self.factor, 1.0]))

    held = validation_of(records, "split")
    assert held.error(FixedEstimate(), model) < 1e-6
    dead = FixedEstimate()
    dead.factor = 0.0
    rate = np.concatenate([r.column("yaw_rate_rad_s")[k:] for r, k in zip(records, held.since, strict=True)])
    assert 0.5 < held.error(dead, model) < 5.0 and np.std(rate) > 0.0


@pytest.mark.parametrize("text", ["{}/s.journal", "sqlite:///{}/s.db"])
def test_a_stored_study_is_continued(text, tmp_path, records, model):
    storage = text.format(tmp_path)
    whole = run(records, model, n_trials=20, seed=5)
    assert run(records, model, n_trials=8, seed=5, storage=storage).trials == 8
    found = run(records, model, n_trials=20, seed=5, storage=storage)
    assert found.trials == 20 and found.error == pytest.approx(whole.error, rel=1e-6)
    assert run(records, model, n_trials=20, seed=5, storage=storage) == found, "nothing left to do"


def test_studies_of_different_arguments_are_separate(tmp_path, records, model):
    storage = str(tmp_path / "s.journal")
    cases = [
        run(records, model, n_trials=3, storage=storage),
        run(records[:1], model, n_trials=3, storage=storage),
        run(records, model, ScaledLs(fail_above=1e3), n_trials=3, storage=storage),
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
