"""nmi-rls: the sine of the innovations, corrected and as printed (paper 004)."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.errors import FitFailed
from helmbench.models.model import resolve


def test_sine_of_small_innovations_is_linear():
    """At omega 1 nmi-rls and mi-rls agree (published as a difference): noise-free 3-DOF records."""
    model, record = resolve("kvlcc2-l7"), generate(Case("kvlcc2-l7", "zigzag:20/20"))
    linear = make("mi-rls", p0=1e6).fit([record], model).coefficients
    for omega, tolerance in ((1.0, 2e-2), (1e-3, 1e-6)):
        sine = make("nmi-rls", omega=omega).fit([record], model).coefficients
        assert np.median(np.abs(sine / linear - 1.0)) < tolerance


def test_nmi_with_large_omega_fails_in_noise():
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20", "low", seed=2))
    error = {}
    for omega in (0.1, 30.0):
        found = make("nmi-rls", omega=omega).fit([record], model).parameters
        error[omega] = abs(found["T"] / model.parameters["T"] - 1.0)
    assert error[0.1] < 0.1 and error[30.0] > 3.0 * error[0.1]


@pytest.mark.parametrize("name", ["response-1", "kvlcc2-l7"])
def test_nmi_as_printed_diverges(name):
    with pytest.raises(FitFailed):
        make("nmi-rls", variant="as_printed").fit([generate(Case(name, "zigzag:20/20"))], resolve(name))


@pytest.mark.parametrize("name", ["rls", "mi-rls", "nmi-rls"])
def test_a_whole_number_as_prior_variance_is_a_number(name):
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20", "low", seed=3))
    whole, real = (make(name, p0=p0).fit([record], model).coefficients for p0 in (13572, 13572.0))
    assert np.array_equal(whole, real)
