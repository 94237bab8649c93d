"""scikit-learn regressors as methods: simulated as the model they learn from, scored, refused in one line."""

import pickle

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression

from helmbench.bench.problems import Task
from helmbench.bench.runner import RunSpec, execute
from helmbench.bench.scores import prediction_scores
from helmbench.datasets.generator import Case, generate
from helmbench.methods import contract
from helmbench.methods._compiled import compiled, stacked
from helmbench.methods.base import CannotFit, FitFailed
from helmbench.methods.black_box import ROWS, BlackBoxPredictor, _fitted, features_of, regressor, spread
from helmbench.methods.predictor import ModelPredictor
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.models.simulate import accelerations, initial_state


def perfect(model):
    """A predictor whose regressor knows the model's own accelerations."""
    states, inputs = features_of(model)
    k = 3 if model.is_3dof else 1

    def exact(features):
        given = dict(zip((*states, *inputs), features.T, strict=True))
        x = np.zeros((len(features), len(model.states)))
        gain = model.kernels.RATE_GAIN
        shift = 0.0 if gain is None else model.coefficients[gain]
        for place, name in enumerate(model.states):
            if name == "w":
                x[:, place] = given["q"] - shift * given["delta"]
            elif name in given:
                x[:, place] = given[name]
        u = np.column_stack([given[name] for name in model.inputs])
        rates = accelerations(model, x, u)[:, :k]
        return rates if gain is None else rates + shift * given["delta_rate"][:, None]

    d = len(states) + len(inputs)
    scaling = (np.zeros(d), np.ones(d), np.zeros(k), np.ones(k))
    return BlackBoxPredictor(model.states, model.inputs, (*states, *inputs), model.is_3dof, *scaling, (), exact)


@pytest.mark.parametrize("ship", ["mariner", "response-1", "response-2", "kvlcc2-l7"])
def test_free_run_and_step_are_the_model_s_own(ship, rng):
    model = resolve(ship)
    dt = model.max_step_s  # the black box takes one step a sample
    delta = np.cumsum(rng.normal(0.0, 0.02, 120))
    inputs = np.column_stack([delta, *(np.full(120, model.n0_rps) for name in model.inputs if name == "n")])
    start = initial_state(model)
    start[model.states.index("r")] += 0.001
    mine, other = perfect(model), ModelPredictor(model)
    free = mine.simulate(inputs, dt, start)
    expected = other.simulate(inputs, dt, start)
    columns = [place for place, name in enumerate(model.states) if name != "w"]
    np.testing.assert_allclose(free[:, columns], expected[:, columns], rtol=1e-9, atol=1e-12)
    states = free[:-1] + rng.normal(0.0, 1e-3, free[:-1].shape)
    ahead, ahead_expected = mine.step(states, inputs, dt), other.step(states, inputs, dt)
    np.testing.assert_allclose(ahead[:, columns], ahead_expected[:, columns], rtol=1e-9, atol=1e-12)


def test_linear_regression_learns_a_linear_ship():
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
    "HistGradientBoostingRegressor": 0.0,  # trees take differenced noise for the ship, and drift
}
"""Regressor -> R^2 that its free run has at least."""


@pytest.mark.parametrize(("name", "least"), NAMES.items())
def test_regressors_learn_a_noisy_ship(name, least):
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


FORMS = {
    "Ridge": "Affine",
    "LinearSVR": "Affine",
    "SVR": "Kernel",
    "NuSVR": "Kernel",
    "DecisionTreeRegressor": "Trees",
    "RandomForestRegressor,n_estimators=10": "Trees",
    "ExtraTreesRegressor,n_estimators=10": "Trees",
    "HistGradientBoostingRegressor,max_iter=20": "Trees",
    "SVR,kernel=poly": None,
    "KNeighborsRegressor": None,
    "GradientBoostingRegressor,n_estimators=10": None,
}


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("outputs", [1, 3])
def test_fast_forms_predict_as_scikit_learn(name, outputs, rng):
    x = rng.normal(size=(300, 4))
    y = np.column_stack([np.sin(x[:, 0] + place) + x[:, 1] * x[:, 2] for place in range(outputs)])
    regressors = _fitted(x, y, make(f"sklearn:{name}")._fresh)
    fast = compiled(regressors, x[:20])
    assert (None if fast is None else type(fast).__name__) == FORMS[name]
    if fast is not None:
        elsewhere = 2.0 * rng.normal(size=(600, 4))
        np.testing.assert_allclose(fast(elsewhere), stacked(regressors, elsewhere), rtol=1e-8, atol=1e-8)


def test_a_form_that_does_not_agree_is_not_used(rng):
    class Rounding(LinearRegression):
        def predict(self, X):
            return np.round(super().predict(X), 3)

    x = rng.normal(size=(50, 2))
    assert compiled((Rounding().fit(x, x[:, 0]),), x) is None


def test_far_outside_nothing_is_predicted():
    predictor = perfect(resolve("response-1"))
    run = predictor.simulate(np.full((50, 1), 1e4), 0.1, np.zeros(2))
    assert np.isnan(run[-1]).all() and np.isfinite(run[0]).all()


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
        ("sklearn:numpy.random.Generator", "cannot be made"),
    ],
)
def test_bad_texts_are_one_line(text, words):
    with pytest.raises(BadInput) as caught:
        make(text)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_a_class_from_elsewhere():
    method = make("sklearn:sklearn.linear_model.Ridge,alpha=2")
    assert method.get_params()["alpha"] == 2 and type(method).name == "sklearn:sklearn.linear_model.Ridge"


def test_own_options_hide_none_of_scikit_learn():
    from sklearn.utils import all_estimators

    for name, cls in all_estimators(type_filter="regressor"):
        known = set(cls._get_param_names())
        assert not known & {"rows", "scheme", "seed", "tuner", "trials", "share"}, name


def test_slow_regressors_are_given_a_subset():
    model, records = contract.sample("response-1")
    records = [record.slice(0, 300) for record in records]
    assert (
        make("sklearn:GaussianProcessRegressor").fit(records, model).extra["rows"] == ROWS["GaussianProcessRegressor"]
    )
    assert make("sklearn:SVR,rows=50").fit(records, model).extra["rows"] == 50
    assert make("sklearn:Ridge").fit(records, model).extra["rows"] > 400
    assert spread(10, 4).tolist() == [0, 3, 6, 9]


@pytest.mark.parametrize("check", contract.CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", ["HuberRegressor", "HistGradientBoostingRegressor"])
def test_contract(name, check):
    check(regressor(name))


def test_predictions_are_repeatable_and_blind_to_order_sign_and_truth():
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
