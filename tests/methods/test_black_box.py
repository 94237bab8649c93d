"""scikit-learn regressors as methods: learnt, scored, refused in one line."""

import pickle

import pytest

from helmbench.bench.kinds.identification.execute import execute
from helmbench.bench.kinds.identification.plan import RunSpec
from helmbench.bench.kinds.identification.problems import Task
from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.black_box.scaled import evenly_spaced
from helmbench.estimation.run.prediction import prediction_scores
from helmbench.methods import contract
from helmbench.methods.black_box import ROWS, regressor
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve

from ..nightly_marks import nightly_but


def test_linear_regression_identifies_a_linear_vessel():
    model = resolve("cargo")
    train = generate(Case("cargo", "zigzag:20/20", duration_s=600))
    held_out = generate(Case("cargo", "sine:15deg/200s+5deg/60s", duration_s=600))
    estimate = make("sklearn:LinearRegression").fit([train], model.blanked())
    assert estimate.parameters == {} and estimate.coefficients.shape == (0,) and not estimate.model.known
    scores = prediction_scores(estimate.model, [held_out], estimate.predictor)
    assert scores["r2_free_yaw_rate_rad_s"] > 0.9999 and scores["r2_one_yaw_rate_rad_s"] > 0.9999
    assert not scores["diverged"]


NAMES = {
    "HuberRegressor": 0.9,
    "SVR,C=100": 0.7,
    "GaussianProcessRegressor": 0.9,
    "HistGradientBoostingRegressor": 0.0,  # trees fit the differenced noise, and their runs drift
}
"""Regressor -> R^2 that its free run has at least."""


@pytest.mark.parametrize(("name", "least"), NAMES.items())
def test_regressors_learn_from_noisy_records(name, least):
    model = resolve("response-1")
    train = ("zigzag:20/20", "prbs:20deg/5s")
    records = [generate(Case("response-1", text, "low", seed=2, duration_s=60)) for text in train]
    held_out = generate(Case("response-1", "zigzag:10/10", duration_s=40))
    estimate = make(f"sklearn:{name}").fit(records, model.blanked())
    scores = prediction_scores(estimate.model, [held_out], estimate.predictor)
    assert scores["r2_free_yaw_rate_rad_s"] > least and scores["r2_one_yaw_rate_rad_s"] > 0.98
    assert {key for key in scores if key.startswith("rmse_free")} == {
        "rmse_free_heading_rad",
        "rmse_free_yaw_rate_rad_s",
    }


def test_a_run_of_a_suite_is_scored_on_predictions_only():
    task = Task(
        "response-1", "response-1", "nomoto-1-cubic", ("zigzag:20/20",), ("zigzag:10/10",), "low", duration_s=40
    )
    run = execute(RunSpec("quick", "sklearn:HuberRegressor", "corrected", "sklearn:HuberRegressor", task))
    assert run["row"]["status"] == "ok", run["row"]["error"]
    assert run["parameters"] == [] and "rel_error_median" not in run["row"]
    assert run["row"]["r2_free_yaw_rate_rad_s"] > 0.9


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sklearn:HuberRegresor", "did you mean HuberRegressor"),
        ("sklearn:Zzzzz", "no regressor 'Zzzzz'"),
        ("sklearn:", "no regressor"),
        ("sklearn:LogisticRegression", "not a regressor"),
        ("sklearn:StackingRegressor", "cannot be made"),
        ("sklearn:SVR,C=-1", "'C' parameter of SVR must be"),
        ("sklearn:SVR,penalty=1", "no option 'penalty'; known: rows, scheme, seed, C"),
        ("sklearn:SVR,scheme=best", "unknown difference scheme"),
        ("sklearn:SVR,rows=0", "rows is 0"),
        ("sklearn:no_such_package.Regressor", "no regressor"),
        ("sklearn:numpy.random.Generator", "is not a regressor"),
        ("sklearn:sklearn.multioutput.MultiOutputRegressor", "cannot be made"),
        ("sklearn:subprocess.Popen,args=true", "is not a regressor"),
    ],
)
def test_bad_texts_are_one_line(text, words):
    with pytest.raises(BadInput) as caught:
        make(text)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_a_class_from_elsewhere():
    method = make("sklearn:sklearn.linear_model.Ridge,alpha=2")
    assert method.get_params()["alpha"] == 2 and type(method).name == "sklearn:sklearn.linear_model.Ridge"


def test_own_options_have_other_names_than_those_of_scikit_learn():
    from sklearn.utils import all_estimators

    for name, cls in all_estimators(type_filter="regressor"):
        known = set(cls._get_param_names())
        assert not known & {"rows", "scheme", "seed", "tuner", "trials", "share"}, name


def test_slow_regressors_are_given_a_subset(suite):
    model, records = suite("response-1", noise="low")
    records = [record.slice(0, 300) for record in records]
    assert (
        make("sklearn:GaussianProcessRegressor").fit(records, model).extra["rows"] == ROWS["GaussianProcessRegressor"]
    )
    assert make("sklearn:SVR,rows=50").fit(records, model).extra["rows"] == 50
    assert make("sklearn:Ridge").fit(records, model).extra["rows"] > 400
    assert evenly_spaced(10, 4).tolist() == [0, 3, 6, 9]


@pytest.mark.parametrize("check", contract.CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", nightly_but(["HuberRegressor", "HistGradientBoostingRegressor"], "HuberRegressor"))
def test_contract(name, check):
    check(regressor(name))


def test_predictions_do_not_depend_on_repetition_sign_or_true_coefficients():
    model, records = contract.sample("kvlcc2-l7")
    other = "port" if model.positive_rudder == "starboard" else "starboard"
    turned = [record.turned(model.positive_rudder).turned(other) for record in records]
    cases = [(records, model), (records, resolve(model.id)), (turned, model)]
    fits = [make("sklearn:RandomForestRegressor,n_estimators=5").fit(given, known) for given, known in cases]
    fits.append(pickle.loads(pickle.dumps(fits[0])))
    runs = [prediction_scores(fit.model, records[:1], fit.predictor) for fit in fits]
    assert all(run == runs[0] for run in runs)


def test_refusals():
    model, records = contract.sample("kvlcc2-l7")
    blind = [record.with_channels(sway_m_s=None) for record in records]
    with pytest.raises(CannotFit, match="sway_m_s"):
        make("sklearn:Ridge").fit(blind, model)
    with pytest.raises(FitFailed, match="IsotonicRegression"):
        make("sklearn:IsotonicRegression").fit(records, model)
    estimate = make("sklearn:Ridge").fit(records, model)
    with pytest.raises(BadInput, match="no coefficients to write"):
        estimate.save("model.json")
