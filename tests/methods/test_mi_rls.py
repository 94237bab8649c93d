"""mi-rls: a weaker prior (paper 004)."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
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
