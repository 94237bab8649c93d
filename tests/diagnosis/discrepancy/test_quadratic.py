"""The algebra of a discrepancy with priors: modes, scales by marginal likelihood, robust spreads."""

import itertools

import numpy as np
import pytest

from helmbench.diagnosis.discrepancy.quadratic import (
    START,
    by_record,
    inflation,
    mode,
    quadratic,
    robust_covariance,
    scales,
)


def regression(rng, size, sd=1.0, terms=12, blocks=30):
    """A linear model of 6-channel innovations: terms of group 0 with a standard deviation, and one free parameter."""
    rows, samples = terms + 1, 20 * blocks
    columns = 2.0 * rng.standard_normal((rows, 6 * samples)) / np.sqrt(samples)
    truth = np.concatenate([sd * rng.standard_normal(terms), [size]])
    e = (rng.standard_normal(6 * samples) - truth @ columns).reshape(-1, 6)
    edges = np.linspace(0, samples, blocks + 1).astype(int)
    cuts = [(i % 3, int(a), int(b)) for i, (a, b) in enumerate(itertools.pairwise(edges))]
    group = np.array([0] * terms + [-1])
    e = np.clip(e, -4.5, 4.5)
    q = quadratic(columns, e, np.zeros(rows), cuts, group, -0.5 * float(np.sum(e**2)), 0.0)
    return q, columns, e, truth


def test_mode_is_the_ridge_estimate(rng):
    q, columns, e, _ = regression(rng, 1.0)
    variances = START.copy()
    found = mode(q, variances, [12])
    prior = np.diag([1.0 / variances[0]] * 12 + [0.0])
    expected = np.linalg.solve(columns @ columns.T + prior, -columns @ e.ravel())
    assert found.x == pytest.approx(expected, rel=1e-5, abs=1e-8)
    assert found.covariance == pytest.approx(np.linalg.inv(columns @ columns.T + prior), rel=1e-4, abs=1e-8)


def test_evidence_is_the_marginal_likelihood(rng):
    """That of a Gaussian with the terms integrated out, at two variances."""
    q, columns, e, _ = regression(rng, 0.0, terms=3, blocks=4)
    held = columns[:3]

    def marginal(variance):
        spread = np.eye(e.size) + variance * held.T @ held
        return -0.5 * e.ravel() @ np.linalg.solve(spread, e.ravel()) - 0.5 * np.linalg.slogdet(spread)[1]

    def ours(variance):
        return mode(q, np.concatenate([[variance], START[1:]]), []).evidence

    assert ours(1.0) - ours(0.01) == pytest.approx(marginal(1.0) - marginal(0.01), rel=1e-6)


def test_the_scale_is_found_and_zero_where_there_is_nothing(rng):
    sd = float(rng.uniform(0.5, 2.0))
    q, _, _, truth = regression(rng, 3.0, sd, terms=60)
    variances, _ = scales(q, [60], (START,))
    print(sd, np.sqrt(variances[0]))
    assert np.sqrt(variances[0]) == pytest.approx(np.sqrt(np.mean(truth[:60] ** 2)), rel=0.3)
    empty, _ = scales(regression(rng, 3.0, 0.0, terms=60)[0], [60], (START,))
    assert empty[0] < 0.1


def test_spreads_of_blocks_agree_with_the_likelihood_where_rows_are_independent(rng):
    q, _, _, truth = regression(rng, 2.0, blocks=60)
    found = mode(q, START, [12])
    places = np.array([len(found.active) - 1])
    ratio = robust_covariance(q, found, places)[0, 0] / found.covariance[places[0], places[0]]
    assert 0.4 < ratio < 2.5
    assert 1.0 <= inflation(q, found, places) < 2.5
    values, spread = by_record(q, START, np.array([12]))
    assert values.shape == spread.shape == (3, 1)
    assert np.all(np.abs(values[:, 0] - truth[12]) < 6.0 * spread[:, 0])


def test_a_parameter_that_changes_nothing_stays_at_zero(rng):
    """A cause without any effect in the records: no size, no spread, and the others as without it."""
    q, columns, e, _ = regression(rng, 1.0)
    edges = np.linspace(0, len(e), 31).astype(int)
    cuts = [(i % 3, int(a), int(b)) for i, (a, b) in enumerate(itertools.pairwise(edges))]
    wide = np.vstack([columns, np.zeros((1, columns.shape[1]))])
    more = quadratic(wide, e, np.zeros(14), cuts, np.append(q.group, -1), q.const, 0.0)
    one, both = mode(q, START, [12]), mode(more, START, [12, 13])
    assert both.x[13] == 0.0 and both.x[:13] == pytest.approx(one.x, rel=1e-6, abs=1e-12)
    assert both.evidence == pytest.approx(one.evidence) and inflation(more, both, np.array([13])) == 1.0
    assert all(not part.any() for part in by_record(more, START, np.array([13])))
