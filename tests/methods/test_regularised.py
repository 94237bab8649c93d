"""Ridge regression against closed forms, and on Mariner's noisy records, where least squares fails."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.methods.regularised import ridge, truncated
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

from ..made_up.least_squares import factor_of, problem


@pytest.mark.parametrize("penalty", [1e-6, 1e-3, 1.0])
def test_ridge_is_the_augmented_least_squares(penalty, rng):
    """The penalty is equivalent to rows of scaled unit vectors in the problem."""
    a, x = problem(rng)
    b = a @ x + rng.normal(size=300)
    length = np.linalg.norm(a, axis=0)
    top = np.linalg.svd(a / length, compute_uv=False)[0]
    stacked = np.vstack([a / length, np.sqrt(penalty) * top * np.eye(4)])
    expected = np.linalg.lstsq(stacked, np.append(b, np.zeros(4)), rcond=None)[0] / length
    assert ridge(factor_of(a, b), 300, penalty).coefficients == pytest.approx(expected, rel=1e-9)


def test_ridge_gcv_shrinks_more_with_more_noise(rng):
    a, x = problem(rng)
    noise = rng.normal(size=300)
    quiet, loud = (ridge(factor_of(a, a @ x + sd * noise), 300, None) for sd in (1e-6, 30.0))
    error = 1e-6 * np.sqrt(np.diag(np.linalg.inv(a.T @ a)))
    assert np.all(np.abs(quiet.coefficients - x) < 6.0 * error)
    assert quiet.extra["penalty"] < loud.extra["penalty"]
    assert quiet.extra["degrees_of_freedom"] > loud.extra["degrees_of_freedom"]


def test_ridge_without_penalty_is_least_squares(rng):
    a, x = problem(rng)
    b = a @ x + rng.normal(size=300)
    found = ridge(factor_of(a, b), 300, 0.0)
    c, covariance, freedom = found.coefficients, found.covariance, found.extra["degrees_of_freedom"]
    assert c == pytest.approx(np.linalg.lstsq(a, b, rcond=None)[0], rel=1e-8)
    assert freedom == pytest.approx(4.0)
    expected = np.linalg.inv(a.T @ a) * np.sum((b - a @ c) ** 2) / 296
    assert np.diag(covariance) == pytest.approx(np.diag(expected), rel=1e-6)


def test_ridge_is_better_than_least_squares_on_mariner():
    """Median parameter error at low noise about that of the zero model, where least squares has 230 %."""
    model = resolve("mariner")
    records = [generate(Case("mariner", text, "low", seed=3)) for text in ("zigzag:20/20", "zigzag:10/10")]
    median = {}
    for text in ("ls,scheme=midpoint", "ridge"):
        found = make(text).fit(records, model)
        median[text] = np.median([abs(found.parameters[k] / v - 1.0) for k, v in model.parameters.items() if v])
    assert median["ridge"] < 0.7 * median["ls,scheme=midpoint"]


# ---- Truncated singular values against numpy's, and against least squares where nothing is truncated.


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
