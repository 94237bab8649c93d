"""mi-rls: a weaker prior (paper 004)."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve


@pytest.mark.parametrize("name", ["response-1", "kvlcc2-l7"])
def test_multi_innovation_is_a_weaker_prior(name):
    """mi-rls (l 10, P0 1e6) is rls (P0 1e7) to a few per cent, and with l = 1 it is rls."""
    model = resolve(name)
    record = generate(Case(name, "zigzag:20/20", "low", seed=2))
    plain, weaker = (make("rls", p0=p0).fit([record], model) for p0 in (1e6, 1e7))
    assert make("mi-rls", length=1, p0=1e6).fit([record], model).coefficients == pytest.approx(
        plain.coefficients, rel=1e-6
    )
    multi = make("mi-rls", length=10, p0=1e6).fit([record], model)
    away = np.abs(multi.coefficients - weaker.coefficients) / np.sqrt(np.diag(weaker.covariance))
    assert np.median(away) < 0.1


def test_exact_on_difference_data():
    """Records made by explicit Euler: only the prior has an effect."""
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20@euler"))
    found = make("mi-rls", scheme="forward", p0=1e12).fit([record], model)
    assert found.parameters == pytest.approx(model.parameters, rel=1e-3)


@pytest.mark.parametrize("text", ["mi-rls,length=0", "mi-rls,length=2.5"])
def test_impossible_options_are_refused(text):
    with pytest.raises(BadInput):
        make(text)
