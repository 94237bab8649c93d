"""Truncated singular values against numpy's, and against least squares where nothing is truncated."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.numerics import factors
from helmbench.methods.registry import make
from helmbench.methods.regularised import truncated
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve


def factor_of(a, b):
    return factors.fold(factors.empty(a.shape[1]), np.column_stack([a, b]))


@pytest.mark.parametrize("rank", [1, 3, 5])
def test_it_is_the_pseudo_inverse_of_the_leading_part(rank, rng):
    a, b = rng.normal(size=(300, 5)) * np.logspace(-2, 2, 5), rng.normal(size=300)
    length = np.linalg.norm(a, axis=0)
    u, s, vt = np.linalg.svd(a / length, full_matrices=False)
    expected = np.linalg.pinv(u[:, :rank] * s[:rank] @ vt[:rank]) @ b / length
    found = truncated(factor_of(a, b), 300, rank)
    assert found.coefficients == pytest.approx(expected, rel=1e-8) and found.extra["rank"] == rank


def test_the_rank_is_that_of_the_least_cross_validation(rng):
    """Two columns that are equal but for 1e-4; GCV = n RSS / (n - rank)^2 of the residuals of every rank."""
    common, n = rng.normal(size=400), 400
    a = np.column_stack([common, common + 1e-4 * rng.normal(size=n), rng.normal(size=n)])
    for noise in (1e-9, 1e-4, 0.1):
        b = a @ [1.0, -1.0, 2.0] + noise * rng.normal(size=n)
        residuals = [b - a @ truncated(factor_of(a, b), n, rank).coefficients for rank in (1, 2, 3)]
        gcv = [n * (e @ e) / (n - rank) ** 2 for rank, e in enumerate(residuals, start=1)]
        assert truncated(factor_of(a, b), n).extra["rank"] == 1 + int(np.argmin(gcv))
    assert truncated(factor_of(a, a @ [1.0, -1.0, 2.0]), n).coefficients == pytest.approx([1.0, -1.0, 2.0], rel=1e-6)


def test_nothing_truncated_is_least_squares():
    model = resolve("nomoto-1-cubic")
    record = generate(Case("response-1", "zigzag:20/20", "low", seed=1))
    own, ls = (make(name).fit([record], model) for name in ("tsvd-ls,rank=3", "ls,scheme=midpoint"))
    assert own.coefficients == pytest.approx(ls.coefficients, rel=1e-6)
    with pytest.raises(BadInput, match="rank is 0"):
        make("tsvd-ls,rank=0").fit([record], model)
