"""What means nothing, or cannot be negative, where there is no effect must not be found more often than its level."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.tails import log_tail
from helmbench.datasets.generator import Case as Generated
from helmbench.datasets.generator import generate
from helmbench.diagnosis.causes.noise import _waves_at
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import testable as bank_of
from helmbench.diagnosis.innovations.criterion import noise_fitted, refined, screen
from helmbench.diagnosis.innovations.score_tests import independent_values, independent_variances
from helmbench.diagnosis.innovations.state import first_state
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import resolve

NULLS, LEVEL, MOST = 20, 0.1, 7
"""Of 20 records without an effect a right level of .1 passes 8 or more in .04 % of draws."""


AVERAGED = 9
"""One count has a standard deviation of 10 %: it comes from a quantile that 100 of 5000 draws pass."""


def started(records, vessel, fitted=True):
    est = estimator(resolve(vessel), records)
    state = first_state(est, bank_of(est)[0], 0.01, (), None)
    return noise_fitted(state) if fitted else state


def log_levels(state, rng):
    """Log p-values of refits of causes at the end of their range, with an unknown time, or of unknown frequency."""
    before = state.now.log_likelihood
    items = {i.cause: i for i in screen(state, state.setting, state.now, rng).items}
    found = {}
    for name in ("rudder_delay", "rudder_backlash", "rudder_fault"):
        cause = cause_of(name)
        refit = cause.search.refit(cause, state, items[cause], before, rng)
        found[name] = refined(state, [refit], before)[0].log_p
    waves = cause_of("wave_motion")
    there = waves.search.attempt(waves, state, -np.inf, rng)  # also where the scan finds none
    if there is not None:
        gain = 2.0 * (there.now.log_likelihood - before)
        found["wave_motion"] = np.log(there.tests) + log_tail(gain, there.k)
    return found


@pytest.mark.nightly
def test_levels_hold_where_nothing_is_hidden(rng):
    passed = {}
    for _ in range(NULLS):
        record, *_ = inject(FaultCase("response-1", (), "large", duration_s=60.0, dt_s=0.2), rng).train
        for cause, log_p in log_levels(started([record], "response-1"), rng).items():
            passed[cause] = passed.get(cause, 0) + (log_p < np.log(LEVEL))
    print(passed)
    assert set(passed) >= {"rudder_delay", "rudder_backlash", "rudder_fault"}
    assert all(count <= MOST for count in passed.values())


@pytest.fixture(scope="module")
def still():
    """A state in a record of the model itself."""
    record = generate(Generated("mariner", "zigzag:20/20", "low", seed=1))
    return started([record], "mariner", fitted=False)


def test_values_that_do_the_same_are_half_a_test_and_others_more(still, rng):
    """A cause that cannot be negative: one direction counts half, twelve that have nothing in common count six."""
    now = still.now
    change = rng.standard_normal((12, *now.e.shape))
    runs = [now._replace(e=now.e + 1e-3 * x) for x in change]
    same = [now._replace(e=now.e + amount * change[0]) for amount in (1e-3, 2e-3, 5e-3)]
    same_each = [independent_values(rng, still.point, same) for _ in range(AVERAGED)]
    assert np.mean(same_each) == pytest.approx(0.5, abs=0.1)
    assert independent_values(rng, still.point, runs) == pytest.approx(6.0, rel=0.4)
    assert independent_values(rng, still.point, [now]) == 0.5  # what changes nothing is no choice


def test_noise_like_the_sensors_is_no_further_kind(still, rng):
    """Three kinds of waves are three; noise as the sensors have it is projected out and counts nothing."""
    setting = still.setting
    waves = [_waves_at(still.est, setting, np.array([omega, 0.05, 1e-5]), None) for omega in (0.2, 0.6, 1.8)]
    sd = setting.noise.sensor_sd * np.array([1.02, 1.0, 1.0, 1.0, 1.0, 1.0])
    louder = replace(setting, noise=replace(setting.noise, sensor_sd=sd))
    found = [independent_variances(rng, still.point, waves) for _ in range(AVERAGED)]
    alone, each = np.mean([whole for whole, _ in found]), np.mean([parts for _, parts in found], axis=0)
    beside = np.mean([independent_variances(rng, still.point, [*waves, louder])[0] for _ in range(AVERAGED)])
    assert alone == pytest.approx(1.5, rel=0.3) and each == [pytest.approx(alone, rel=0.2)]
    assert beside == pytest.approx(alone, rel=0.2)
