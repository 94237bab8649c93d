"""What a fit takes and returns: records, errors and propagated standard deviations."""

import warnings

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.estimation.results.fit import numerical_guard, prepared, propagate
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve


def test_errors_of_unidentified_coefficients():
    covariance = np.array([[4.0, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, 9.0]])
    jacobian = np.array([[1.0, 0.0, 0.0], [1.0, 1e-9, 0.0], [0.5, 0.0, 1.0]])
    assert propagate(jacobian, covariance) == pytest.approx([2.0, np.inf, np.sqrt(10.0)])


@pytest.mark.parametrize(
    ("raised", "expected"),
    [
        (CannotFit("no sway"), CannotFit),
        (BadInput("no such column"), CannotFit),
        (FitFailed("diverged"), FitFailed),
        (np.linalg.LinAlgError("singular"), FitFailed),
        (OverflowError("too large"), FitFailed),
        (KeyError("a bug"), KeyError),
    ],
)
def test_the_guard_names_the_failure(raised, expected):
    with pytest.raises(expected), numerical_guard():
        raise raised


def test_the_guard_allows_overflow():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with numerical_guard():
            assert np.array([1e300]) * 1e300 == np.inf


def test_records_get_the_rudder_sign_of_the_model():
    model = resolve("mariner")
    record = Record(np.arange(10.0), {"rudder_rad": np.linspace(0.0, 0.1, 10)})
    turned = record.turned(model.positive_rudder).turned("starboard")
    (checked,) = prepared([turned], model)
    assert checked.meta.positive_rudder == model.positive_rudder
    assert np.array_equal(checked.rudder(), record.turned(model.positive_rudder).rudder())
    with pytest.raises(CannotFit, match="no records"):
        prepared([], model)
