"""Kinematic smoothing."""

import numpy as np
import pytest

from helmbench.estimation.observers.smoothing import SmoothedTrack, Walk, cost, fitted_walk, random_walk, smoothed


def test_the_random_walks_covariance_is_the_integral(rng):
    """Q = int_0^1 e^(A t) b b' e^(A' t) dt for A the chain of integrators."""
    f, q = random_walk(3, 2.0)
    t = (np.arange(4000) + 0.5) / 4000
    column = np.column_stack([t**2 / 2.0, t, np.ones_like(t)])
    assert q == pytest.approx(2.0 * column.T @ column / 4000, rel=1e-6)
    assert f @ [1.0, 2.0, 4.0] == pytest.approx([5.0, 6.0, 4.0])


def dense_posterior(track, walk, start):
    """Smoothed states by one large least-squares problem: transitions, outputs and the initial state as rows."""
    x0, p0 = start
    n, count = walk.order, len(track.outputs)
    f, q = random_walk(n, walk.level * walk.noise.max())
    root = np.linalg.inv(np.linalg.cholesky(q))
    rows, right = [], []
    first = np.zeros((n, n * count))
    first[:, :n] = np.diag(1.0 / np.sqrt(np.diag(p0)))
    rows.append(first)
    right.append(first[:, :n] @ x0)
    for k in range(1, count):
        block = np.zeros((n, n * count))
        block[:, n * (k - 1) : n * k], block[:, n * k : n * (k + 1)] = -root @ f, root
        rows.append(block)
        right.append(np.zeros(n))
    for k, output in enumerate(track.outputs):
        for value, rank, variance in zip(output, track.ranks, walk.noise, strict=True):
            if np.isfinite(value):
                row = np.zeros((1, n * count))
                row[0, n * k + rank] = 1.0 / np.sqrt(variance)
                rows.append(row)
                right.append([value / np.sqrt(variance)])
    return np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0].reshape(count, n)


@pytest.mark.parametrize("ranks", [(0,), (1,), (0, 1)])
def test_the_smoother_is_the_posterior_mean(ranks, rng):
    """Filter and backward pass against the whole problem solved at once, with gaps and two sensors."""
    from helmbench.estimation.observers import smoothing

    walk = Walk(3, 10.0 ** rng.uniform(-3, 0), rng.uniform(0.5, 2.0, len(ranks)), np.inf)
    outputs = np.cumsum(rng.normal(size=(40, len(ranks))), axis=0)
    outputs[rng.random(outputs.shape) < 0.2] = np.nan
    track = SmoothedTrack(outputs, ranks)
    scale = np.sqrt(walk.noise.max())
    x0, p0 = smoothing._start(SmoothedTrack(outputs / scale, ranks), 3, walk.noise / scale**2)
    expected = dense_posterior(track, walk, (x0 * scale, p0 * scale**2))
    assert smoothed(track, walk) == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_the_likelihood_finds_the_process_noise(rng):
    """A simulated integrated random walk: the level is estimated within a factor of 4, at any unit of the channel."""
    level, n = 1e-3, 4000
    f, q = random_walk(2, level)
    drive = rng.normal(size=(n, 2)) @ np.linalg.cholesky(q).T
    x = np.zeros((n, 2))
    for k in range(1, n):
        x[k] = f @ x[k - 1] + drive[k]
    unit = 10.0 ** rng.uniform(-4, 4)
    track = SmoothedTrack(unit * (x[:, :1] + rng.normal(size=(n, 1))), (0,))
    found = fitted_walk([track], np.array([1.7]) * unit**2, [2, 3])  # the sensor's variance itself does not matter
    print(found)
    assert found.order == 2 and level / 4.0 < found.level < 4.0 * level
    nine_fold = cost([track], found._replace(noise=found.noise * 9.0))  # only the start's prior differs
    assert found.cost == pytest.approx(nine_fold, abs=0.2)


def test_smoothed_as_another_is_linear(rng):
    """`like` fixes the linear map: smoothing commutes with sums and factors."""
    walk = Walk(4, 1e-2, np.array([1.0, 0.3]), np.inf)
    a, b = rng.normal(size=(2, 60, 2))
    first = SmoothedTrack(a, (0, 1))
    both = smoothed(SmoothedTrack(2.0 * a - 3.0 * b, (0, 1)), walk, like=first)
    parts = 2.0 * smoothed(first, walk, like=first) - 3.0 * smoothed(SmoothedTrack(b, (0, 1)), walk, like=first)
    assert both == pytest.approx(parts, rel=1e-9, abs=1e-9)
