"""The scheme of least squares by left-out windows."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.regression import left_out
from helmbench.methods.registry import make
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve


def zigzag(noise, seed=3):
    return generate(Case("response-1", "zigzag:20/20", noise, seed=seed))


def test_with_noise_least_squares_does_not_take_forward_differences():
    """T is 13.5 s: forward differences give 69 s."""
    model, record = resolve("response-1"), zigzag("medium")
    found = make("ls").fit([record], model)
    assert found.extra["scheme"] in ("midpoint", "svf")
    assert found.parameters["T"] == pytest.approx(13.5, rel=0.05)
    assert make("ls-forward").fit([record], model).parameters["T"] > 60.0
    assert make("ls,scheme=midpoint").fit([record], model).parameters["T"] == pytest.approx(13.5, rel=0.05)


@pytest.mark.parametrize(("noise", "vessel"), [("none", "response-1"), ("high", "response-1"), ("low", "remus-kt")])
def test_the_chosen_fit_is_that_of_the_scheme_by_itself(noise, vessel):
    model, record = resolve(vessel).blanked(), generate(Case(vessel, "zigzag:20/20", noise, seed=1))
    scheme, found = left_out.best_scheme([record], model), make("ls").fit([record], model)
    text = f"svf-ls,omega={scheme.omega!r}" if scheme.name == left_out.SVF else f"ls,scheme={scheme.name}"
    same = make(text).fit([record], model)
    assert np.array_equal(found.coefficients, same.coefficients) and np.array_equal(found.covariance, same.covariance)


def test_the_error_is_that_of_windows_that_the_fit_has_not_seen(monkeypatch):
    """A window with another ship's motion raises the error of all windows but its own."""
    model, windows = resolve("response-1").blanked(), left_out.windows_of([zigzag("low")], resolve("response-1"))
    assert len(windows) == left_out.WINDOWS
    fitted = []
    monkeypatch.setattr(left_out, "left_out_cost", lambda models, series: fitted.extend(models) or 0.0)
    left_out.left_out_error(left_out.Scheme("midpoint"), windows, model)
    for left, own in enumerate(fitted):
        others = [record for place, (record, _) in enumerate(windows) if place != left]
        direct = make("ls,scheme=midpoint").fit(others, model)
        assert own.coefficients == pytest.approx(direct.coefficients, rel=1e-8)


def test_a_scheme_that_cannot_be_fitted_is_not_chosen():
    model, record = resolve("response-1").blanked(), zigzag("low")
    windows = left_out.windows_of([record], model)
    assert left_out.left_out_error(left_out.Scheme("heading-difference"), windows, model) == np.inf
    with pytest.raises(CannotFit):
        left_out.windows_of([record.with_channels(yaw_rate_rad_s=None, heading_rad=None)], model)
