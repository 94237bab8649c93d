"""Truncated singular values against numpy's, and against least squares where nothing is truncated."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.regression import factors
from helmbench.methods.registry import make
from helmbench.methods.tsvd_ls import truncated
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
    assert found.coefficients == pytest.approx(expected, rel=1e-8) and found.rank == rank


def test_a_direction_of_noise_is_left_out_and_one_that_counts_is_kept(rng):
    """Two columns that are equal but for 1e-6: their difference is noise here, and a signal there."""
    common = rng.normal(size=400)
    a = np.column_stack([common, common + 1e-6 * rng.normal(size=400), rng.normal(size=400)])
    blurred = truncated(factor_of(a, a @ [1.0, 1.0, 2.0] + 0.1 * rng.normal(size=400)), 400)
    sharp = truncated(factor_of(a, a @ [1.0, -1.0, 2.0] + 1e-9 * rng.normal(size=400)), 400)
    assert blurred.rank == 2 and blurred.coefficients == pytest.approx([1.0, 1.0, 2.0], abs=0.1)
    assert sharp.rank == 3 and sharp.coefficients == pytest.approx([1.0, -1.0, 2.0], abs=1e-2)


def test_nothing_truncated_is_least_squares():
    model = resolve("nomoto-1-cubic")
    record = generate(Case("response-1", "zigzag:20/20", "low", seed=1))
    own, ls = (make(name).fit([record], model) for name in ("tsvd-ls,rank=3", "ls,scheme=midpoint"))
    assert own.coefficients == pytest.approx(ls.coefficients, rel=1e-6)
    with pytest.raises(BadInput, match="rank is 0"):
        make("tsvd-ls,rank=0").fit([record], model)
