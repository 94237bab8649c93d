"""The base class: options, errors of a fit, and the estimate made of it."""

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.estimation.results.fit import Fit
from helmbench.methods.base import Method
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve


class Given(Method):
    """Returns or raises what it is given."""

    name = "given"
    title = "for tests"

    def __init__(self, outcome=None) -> None:
        self.outcome = outcome

    def estimate(self, records, model):
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome


@pytest.fixture
def record():
    return Record(0.1 * np.arange(20), {"rudder_rad": np.zeros(20), "yaw_rate_rad_s": np.zeros(20)})


@pytest.fixture
def model():
    return resolve("response-1")


@pytest.mark.parametrize(
    ("raised", "expected"),
    [
        (CannotFit("no sway"), CannotFit),
        (FitFailed("diverged"), FitFailed),
        (BadInput("no such column", column="sway_m_s"), CannotFit),
        (np.linalg.LinAlgError("SVD did not converge"), FitFailed),
        (ZeroDivisionError("division by zero"), FitFailed),
        (ValueError("array must not\ncontain infs"), FitFailed),
    ],
)
def test_errors_of_a_fit_become_cannot_fit_or_fit_failed(record, model, raised, expected):
    with pytest.raises(expected) as caught:
        Given(raised).fit([record], model)
    assert str(caught.value) and "\n" not in str(caught.value)


def test_a_programming_error_is_not_hidden(record, model):
    with pytest.raises(AttributeError):
        Given(AttributeError("typo")).fit([record], model)


@pytest.mark.parametrize("coefficients", [np.array([1.0, np.nan, 2.0]), np.array([1.0, 2.0])])
def test_an_estimate_is_finite_and_complete(record, model, coefficients):
    with pytest.raises(FitFailed, match="not finite"):
        Given(Fit(coefficients)).fit([record], model)


def test_the_fit_becomes_an_estimate(record, model):
    covariance = np.diag([1e-4, 4e-4, 9.0])
    estimate = Given(Fit(np.array([-0.1, 0.02, -20.0]), covariance, message="fine", extra={"k": 1})).fit(
        [record], model
    )
    assert estimate.parameters == pytest.approx({"T": 10.0, "K": 0.2, "alpha": 200.0})
    assert estimate.stderr["T"] == pytest.approx(1.0)  # dT = T^2 da
    assert (estimate.method, estimate.message, estimate.extra) == ("given", "fine", {"k": 1})
    assert estimate.model.vessel == "response-1" and estimate.converged
    plain = Given(Fit(np.array([-0.1, 0.02, -20.0]))).fit([record], model)
    assert plain.covariance is None and np.isnan([*plain.stderr.values()]).all()


def test_short_records_are_named(model):
    short = Record(np.arange(3.0), {"rudder_rad": np.zeros(3)}, "scrap")
    with pytest.raises(CannotFit, match="record scrap has 3 samples, at least 8 are needed"):
        Given().fit([short], model)
    with pytest.raises(CannotFit, match="no records"):
        Given().fit([], model)


def test_fit_takes_one_record_or_several(record, model):
    class Counting(Given):
        def estimate(self, records, model):
            return Fit(np.array([-0.1, 0.02, -20.0]), n_iterations=len(records))

    assert Counting().fit(record, model).n_iterations == 1
    assert Counting().fit([record, record], model).n_iterations == 2


def test_the_base_class_has_no_method_of_its_own(record, model):
    with pytest.raises(NotImplementedError):
        Method().fit([record], model)


@pytest.mark.parametrize("value", ["maybe", "1", "none"])
def test_a_switch_is_true_or_false(value):
    with pytest.raises(BadInput, match="true or false is needed"):
        make(f"eso-rw-lssvr,aligned={value}")
    assert make("eso-rw-lssvr,aligned=false").aligned is False
