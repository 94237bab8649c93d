"""Score tests: tails, projection and the number of independent tests."""

import numpy as np
import pytest
from scipy.stats import chi2

from helmbench.checks.tails import log_tail
from helmbench.diagnosis.innovations.score_tests import (
    Projector,
    canonical_correlation,
    cauchy_combination,
    effective_number,
    independent_tests,
)
from helmbench.estimation.filters.innovations.estimator import Innovations


def innovations(e):
    return Innovations(e.reshape(-1, 6), np.zeros((e.size // 6, 6)), np.zeros((e.size // 6, 1)))


@pytest.mark.parametrize("k", [1, 3, 6])
def test_log_tail_joins_its_asymptote(k):
    assert log_tail(20.0, k) == pytest.approx(chi2.logsf(20.0, k))
    assert log_tail(300.1, k) == pytest.approx(chi2.logsf(299.9, k), rel=0.01)
    assert log_tail(5000.0, k) == pytest.approx(-2500.0, rel=0.02)


def test_score_finds_an_injected_size(rng):
    column = rng.standard_normal((1, 6000))
    noise = rng.standard_normal(6000)
    score = Projector(innovations(noise - 0.3 * column[0]), np.zeros((0, 6000))).score(column)
    assert score.step[0] == pytest.approx(0.3, abs=5.0 / np.sqrt(6000.0))
    assert score.share == pytest.approx(1.0)


def test_score_is_blind_to_the_nuisance(rng):
    nuisance = rng.standard_normal((3, 3000))
    noise = rng.standard_normal(3000)
    column = rng.standard_normal((1, 3000))
    plain = Projector(innovations(noise), nuisance).score(column)
    moved = Projector(innovations(noise + 0.1 * nuisance[1]), nuisance).score(column)
    assert moved.statistic == pytest.approx(plain.statistic, rel=0.2, abs=0.3)
    spanned = Projector(innovations(noise), nuisance).score(nuisance[:1] + nuisance[1:2])
    assert spanned.share < 1e-8


@pytest.mark.parametrize("prior", [None, np.array([3.0, 0.0, 900.0])])
def test_products_are_those_of_the_projected_columns(prior, rng):
    """With a prior the projection shrinks; stacks of columns (pairs) are taken one by one."""
    projector = Projector(innovations(rng.standard_normal(600)), rng.standard_normal((3, 600)), prior)
    columns = rng.standard_normal((5, 2, 600))
    inner, slope = projector.products(columns)
    for pair, found, along in zip(columns, inner, slope, strict=True):
        left = projector.project(pair)
        assert found == pytest.approx(left @ left.T, rel=1e-9, abs=1e-9)
        assert along == pytest.approx(left @ projector.residual, rel=1e-9, abs=1e-9)


def test_score_has_its_distribution(rng):
    """Mean of chi2_2 over 400 draws: 2 +- 4 standard errors of .1."""
    columns = rng.standard_normal((2, 1200))
    draws = [
        Projector(innovations(rng.standard_normal(1200)), np.zeros((0, 1200))).score(columns).statistic
        for _ in range(400)
    ]
    assert np.mean(draws) == pytest.approx(2.0, abs=0.4)


def test_equal_causes_count_once_and_different_ones_each(rng):
    noise = rng.standard_normal(6 * 500)
    projector = Projector(innovations(noise), np.zeros((0, noise.size)))
    one = [rng.standard_normal((1, noise.size))]
    others = [[rng.standard_normal((1, noise.size))] for _ in range(10)]
    assert effective_number(projector, [one] * 10, rng) == pytest.approx(1.0, abs=0.35)
    assert effective_number(projector, others, rng) == pytest.approx(10.0, rel=0.35)


def test_scores_count_as_many_tests_as_they_are_independent_tests(rng):
    apart = rng.standard_normal((20, 2000))
    same = [independent_tests(rng, np.repeat(apart[:1], 20, axis=0)) for _ in range(9)]  # 10 % sd each
    assert np.mean(same) == pytest.approx(1.0, abs=0.2)
    assert independent_tests(rng, apart) == pytest.approx(20.0, rel=0.4)
    assert independent_tests(rng, apart, sided=True) == pytest.approx(10.0, rel=0.4)
    assert independent_tests(rng, apart[:0]) == 1.0


def test_combined_tests_keep_their_level_and_add_up(rng):
    """Normal scores of correlation .5: exact far in the tail; a level of .05 is passed in .058 +- .004."""
    shared = rng.standard_normal((4000, 1))
    z = np.sqrt(0.5) * shared + np.sqrt(0.5) * rng.standard_normal((4000, 12))
    passed = np.mean([cauchy_combination(chi2.logsf(row**2, 1)) < np.log(0.05) for row in z])
    assert 0.042 < passed < 0.076
    several, one = [np.log(0.01)] * 4 + [np.log(0.5)] * 8, [np.log(0.01)] + [np.log(0.5)] * 11
    assert cauchy_combination(several) < cauchy_combination(one) < np.log(0.5)
    assert cauchy_combination([-100.0, -0.1]) == pytest.approx(-100.0 + np.log(2.0))
    assert cauchy_combination([-29.9, -0.1]) == pytest.approx(-29.9 + np.log(2.0), abs=0.01)


def test_canonical_correlation_of_equal_and_of_orthogonal_causes(rng):
    projector = Projector(innovations(rng.standard_normal(600)), np.zeros((0, 600)))
    a = rng.standard_normal((1, 600))
    b = rng.standard_normal((1, 600))
    b -= (b @ a.T) / (a @ a.T) * a
    assert canonical_correlation(projector, a, 2.0 * a) == pytest.approx(1.0)
    assert canonical_correlation(projector, a, b) == pytest.approx(0.0, abs=1e-8)
