"""Fixed parameters, bounds and priors of published parameters, and the options for them."""

import numpy as np
import pytest

from helmbench.estimation.likelihood.unknowns import Unknowns
from helmbench.estimation.methods_only import prior_knowledge as options
from helmbench.methods.output_error import OutputError
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import list_vessels, resolve


@pytest.mark.parametrize("vessel", list_vessels())
def test_the_map_to_coefficients_is_differentiated(vessel):
    model = resolve(vessel)
    unknowns = Unknowns.all_of(model)
    values = model.to_parameters(model.coefficients)
    assert unknowns.coefficients(values) == pytest.approx(model.coefficients, rel=1e-9)
    product = model.parameters_jacobian(model.coefficients) @ unknowns.jacobian(values)
    scale = np.where(values != 0.0, np.abs(values), 1.0)
    assert product * scale / scale[:, None] == pytest.approx(np.eye(values.size), abs=1e-7)


def test_a_fixed_parameter_has_no_error_and_improves_the_others(suite):
    model, records = suite("cargo", noise="medium")
    free = OutputError().fit(records, model)
    fixed = OutputError(fixed={"T3": 10.0}).fit(records, resolve("nomoto-2"))
    named = OutputError(fixed="T3").fit(records, model)
    assert fixed.parameters["T3"] == pytest.approx(10.0, rel=1e-12) and fixed.stderr["T3"] == 0.0
    assert fixed.parameters == pytest.approx(named.parameters, rel=1e-6)
    assert fixed.stderr["T2"] < 0.5 * free.stderr["T2"]
    assert abs(fixed.parameters["T2"] - 6.0) < 5.0 * fixed.stderr["T2"]


def test_true_zeros_kept_leave_forty_coefficients(suite):
    model, records = suite("mariner-model")
    zero = [name for name, value in model.parameters.items() if not value]
    estimate = OutputError(fixed=zero).fit(records, model)
    assert all(estimate.parameters[name] == 0.0 == estimate.stderr[name] for name in zero)
    nonzero = [name for name in model.parameters if name not in zero]
    assert [estimate.parameters[k] for k in nonzero] == pytest.approx([model.parameters[k] for k in nonzero], rel=1e-6)


def test_bounds_are_kept_and_named(suite):
    model, records = suite("response-1", noise="medium")
    inside = OutputError(bounds={"T": (1.0, None), "K": (0.0, 1.0)}).fit(records, model)
    assert inside.parameters == pytest.approx(OutputError().fit(records, model).parameters, rel=1e-6)
    stopped = OutputError(bounds={"T": (None, 12.0)}).fit(records, model)
    assert stopped.parameters["T"] == pytest.approx(12.0, rel=1e-12) and "at a bound: T" in stopped.message
    best = OutputError(fixed={"T": 12.0}).fit(records, model)
    assert stopped.extra["cost"] == pytest.approx(best.extra["cost"], abs=1e-2)


def test_a_prior_enters_estimate_and_covariance(suite):
    """About the unrestricted fit all is linear: the posterior is the product of two Gaussian densities."""
    model, records = suite("cargo", noise="medium")
    free = OutputError().fit(records, model)
    mean, sd = 6.3, 0.1
    found = OutputError(prior={"T2": (mean, sd)}).fit(records, model)
    jacobian = model.parameters_jacobian(free.coefficients)
    before = jacobian @ free.covariance @ jacobian.T
    unit = np.array([0.0, 1.0, 0.0, 0.0])
    gain = before @ unit / (before[1, 1] + sd**2)
    values = np.array([*free.parameters.values()])
    expected = values + gain * (mean - values[1])
    after = np.sqrt(np.diag(before - np.outer(gain, before @ unit)))
    assert np.abs(np.array([*found.parameters.values()]) - expected).max() < 0.2 * np.max(np.sqrt(np.diag(before)))
    assert [*found.stderr.values()] == pytest.approx(after, rel=0.15)
    assert found.stderr["T2"] < 0.8 * free.stderr["T2"]


def test_a_share_of_the_given_models_values(suite):
    """30 % about wrong values limits undetermined coefficients, and keeps zeros at zero."""
    model, records = suite("mariner-model", noise="medium")
    nonzero = model.coefficients != 0.0
    given = model.with_coefficients(
        model.coefficients * (1.0 + 0.3 * np.random.default_rng(5).normal(size=nonzero.size))
    )
    errors = []
    for method, start in ((OutputError(), model.blanked()), (OutputError(prior=0.3), given)):
        found = method.fit(records, start).coefficients
        errors.append(np.median(np.abs(found[nonzero] / model.coefficients[nonzero] - 1.0)))
    print(errors)
    assert errors[1] < 0.3 and errors[1] < errors[0]


def test_files_say_the_same_as_mappings(suite, tmp_path):
    model, records = suite("response-1", noise="medium")
    (tmp_path / "prior.yaml").write_text("T: [14, 1e-1]\n")
    (tmp_path / "bounds.json").write_text('{"K": [0.21, null]}\n')
    (tmp_path / "fixed.yaml").write_text("[alpha]\n")
    text = "output-error," + ",".join(f"{path.stem}={path}" for path in sorted(tmp_path.iterdir()))
    read = make(text).fit(records, model).parameters
    direct = OutputError(prior={"T": (14.0, 0.1)}, bounds={"K": (0.21, np.inf)}, fixed=["alpha"]).fit(records, model)
    assert read == direct.parameters and read["alpha"] == model.parameters["alpha"]


def test_units_of_priors_bounds_and_fixed_values_are_converted(tmp_path):
    model = resolve("response-1")
    (tmp_path / "prior.yaml").write_text("T: {mean: 0.25, sd: 0.05, unit: min}\n")
    unknowns = options.unknowns_of(
        model,
        str(tmp_path / "prior.yaml"),
        {"T": {"low": 1000, "high": None, "unit": "ms"}},
        {"K": {"value": 12.0, "unit": "rpm"}},
    )
    assert unknowns is not None
    names = list(model.parameter_names)
    t, k = names.index("T"), names.index("K")
    assert (unknowns.mean[t], unknowns.sd[t]) == (15.0, 3.0)
    assert (unknowns.low[t], unknowns.high[t]) == (1.0, np.inf)
    assert unknowns.values[k] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"prior": -0.3}, "positive share"),
        ({"prior": {"T": 3.0}}, "pair of numbers"),
        ({"prior": {"T": (3.0, 0.0)}}, "prior of T: sd: needs a positive number, not 0.0"),
        ({"prior": {"T": {"mean": 3.0, "std": 0.1}}}, "unknown key 'std'; did you mean sd"),
        ({"prior": {"T": {"mean": 3.0, "sd": float("inf")}}}, "needs a positive number"),
        ({"prior": "nothing.yaml"}, "no such file"),
        ({"prior": "T"}, "no mapping"),
        ({"bounds": {"T": (3.0, 1.0)}}, "must be below"),
        ({"bounds": {"T": ("low", 1.0)}}, "low: needs a number, not low"),
        ({"fixed": 3}, "names are needed"),
        ({"fixed": {"T": "long"}}, "value: needs a finite number, not long"),
        ({"loss": "hubert"}, "unknown loss"),
        ({"tuning": 2.0}, "robust loss"),
        ({"loss": "huber", "tuning": -1.0}, "positive number"),
        ({"shooting": 0}, "shooting"),
        ({"shooting": 2.5}, "shooting"),
        ({"level": 1.0}, "level"),
        ({"profile": 3}, "names are needed"),
    ],
)
def test_impossible_options(suite, given, message):
    model, records = suite("response-1")
    with pytest.raises(BadInput, match=message):
        OutputError(**given).fit(records, model)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"fixed": {"Q": 1.0}}, "no parameter 'Q'"),
        ({"profile": "Q"}, "no parameter 'Q'"),
        ({"prior": 0.3}, "has none"),
        ({"prior": {"T": {"mean": 14.0, "sd": 1.0, "unit": "m"}}}, "prior of T: the unit is 'm' where 's'"),
        ({"fixed": "K"}, "has none"),
        ({"fixed": {"K": 2.0}, "bounds": {"K": (0.0, 1.0)}}, "outside its bounds"),
        ({"fixed": {"T": 2.0, "K": 2.0, "alpha": 2.0}}, "nothing is left"),
    ],
)
def test_options_that_do_not_suit_the_model(suite, given, message):
    _, records = suite("response-1")
    with pytest.raises(CannotFit, match=message):
        OutputError(**given).fit(records, resolve("nomoto-1-cubic"))


def test_complex_time_constants_still_give_a_start():
    """nomoto-2 about an oscillating solution: a start with real T1 and T2."""
    model = resolve("cargo")
    coefficients = model.coefficients * [0.1, 1.0, 1.0, 1.0]
    assert np.isnan(model.to_parameters(coefficients)).any()
    unknowns = options.unknowns_of(model, None, None, {"K": 0.09})
    assert unknowns is not None
    start = unknowns.start(coefficients)
    assert start is not None and start.shape == (3,) and np.isfinite(start).all()
