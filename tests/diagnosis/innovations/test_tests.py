"""A named cause has one size: what it only resembles shows another elsewhere."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

import helmbench
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.innovations.features import LINES, MOST_LINES, lines
from helmbench.diagnosis.innovations.score_tests import Projector
from helmbench.diagnosis.innovations.state import first_state
from helmbench.diagnosis.innovations.tests import noise_with_memory, size_tests
from helmbench.diagnosis.innovations.unmodelled import _periodic
from helmbench.estimation.filters.innovations.estimator import Innovations, estimator
from helmbench.models.model import resolve


def _tests(share, seed):
    """Log p-values where a cause's column stands `share` larger in the second half of each record."""
    rng = np.random.default_rng(seed)
    est = estimator(resolve("response-1"), [generate(Case("response-1", "zigzag:20/20", "low", seed=1))])
    now = est.evaluate(est.start())
    n = len(now.e)
    late = est.segments[0].time > 0.5 * est.segments[0].time[-1]
    column = rng.standard_normal((n, 6))
    e = rng.standard_normal((n, 6)) - share * column * np.where(late, 1.0, -1.0)[:, None]
    now = now._replace(e=e)
    columns = column.reshape(1, -1)
    return dict(size_tests(est, now, Projector(now, columns), {cause_of("rudder_offset"): columns}))


def test_another_size_in_the_second_half_is_seen(seed):
    found = _tests(0.2, seed)
    assert min(found, key=lambda label: found[label]) == "another size of rudder_offset in the second half of a record"
    assert found["another size of rudder_offset in the second half of a record"] < -10.0


def test_one_size_throughout_is_believed(seed):
    """Of four tests none below e^-9.5 (chance 3 in 10,000)."""
    assert min(_tests(0.0, seed).values()) > -9.5


def _innovations(rng, keep):
    """Of one record: innovations (N, 6) of unit variance, each channel a first-order process that keeps a share."""
    est = estimator(resolve("response-1"), [generate(Case("response-1", "zigzag:20/20", "low", seed=1))])
    now = est.evaluate(est.start())
    white = rng.standard_normal((len(now.e), 6))
    return est, now._replace(e=lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], white, axis=0))


def test_noise_with_a_memory_is_told_with_the_share_of_its_samples_that_count(rng):
    """Of a process with correlations 0.8^k (1 - 0.8) / (1 + 0.8) of the samples, as the error of its mean says."""
    est, now = _innovations(rng, 0.8)
    found = noise_with_memory(est, now)
    assert [one.channel for one in found] == ["heading_rad", "yaw_rate_rad_s"]
    assert [one.near for one in found] == pytest.approx([0.8] * 2, abs=0.1)
    assert np.mean([one.independent for one in found]) == pytest.approx(0.2 / 1.8, rel=0.5)


def test_white_noise_and_an_effect_that_lasts_are_no_noise_with_a_memory(rng):
    est, now = _innovations(rng, 0.0)
    assert noise_with_memory(est, now) == []
    slow = 2.0 * np.sin(2.0 * np.pi * est.segments[0].time / est.segments[0].time[-1])
    assert noise_with_memory(est, now._replace(e=now.e + slow[:, None])) == []


def test_a_periodic_moment_is_seen_through_its_phase(rng):
    """Cosine and sine of the frequency nearest to the injected one gain what the moment is worth."""
    est = estimator(resolve("response-1"), [generate(Case("response-1", "zigzag:20/20", "low", seed=1))])
    n = est.segments[0].time.size
    waves, of = lines(est, Innovations(np.zeros((n, 6)), np.zeros((n, 6)), np.zeros((n, 1))))
    assert of == len(waves)
    columns = rng.standard_normal((2 * len(waves), 6 * n))
    k = int(rng.integers(len(waves)))
    residual = rng.standard_normal(6 * n) + 0.2 * columns[2 * k] - 0.3 * columns[2 * k + 1]
    now = Innovations(residual.reshape(-1, 6), np.zeros((n, 6)), np.zeros((n, 1)))
    row = {id(f.series): column for f, column in zip((f for pair in waves for f in pair), columns, strict=True)}
    here = SimpleNamespace(
        columns=lambda axes, series: np.stack([row[id(one)] for one in series]),
        projector=Projector(now, np.zeros((0, 6 * n))),
    )
    (found,) = _periodic(first_state(est, {}, 0.01, (), None), (waves, of), here)
    assert found.features == waves[k]
    size = np.array([0.2, -0.3])
    wanted = float(size @ (columns[2 * k : 2 * k + 2] @ columns[2 * k : 2 * k + 2].T) @ size)
    assert abs(found.gain - wanted) < 5.0 * 2.0 * np.sqrt(wanted)


def test_of_many_frequencies_those_are_tried_where_the_innovations_have_power(rng):
    """Records of many hours, one of them twice as long: the injected frequency is among the few that are tried."""
    record = helmbench.simulate("mariner", "zigzag:20/20", duration_s=6000.0, dt_s=1.0)
    longer = helmbench.simulate("mariner", "zigzag:20/20", duration_s=12000.0, dt_s=1.0)
    est = estimator(resolve("mariner"), [record, longer])
    e, time = rng.standard_normal((est.edges[-1], 6)), np.concatenate([d.time for d in est.segments])
    omega = rng.uniform(*LINES) / est.clock
    e[:, 4] += 0.2 * np.cos(omega * time + rng.uniform(0.0, 6.0))
    tried, of = lines(est, Innovations(e, np.zeros(e.shape), e))
    print(omega, of)
    assert len(tried) == MOST_LINES < of
    gains = [sum(abs(np.concatenate(f.series) @ e[:, 4]) ** 2 for f in pair) for pair in tried]
    best = tried[int(np.argmax(gains))][0].name.removeprefix("cos(").split()[0]
    assert float(best) == pytest.approx(omega, rel=0.01)
