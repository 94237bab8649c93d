"""What means nothing, or cannot be negative, where there is no effect must not be found more often than its level."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.planting import Case, plant
from helmbench.datasets.generator import Case as Generated
from helmbench.datasets.generator import generate
from helmbench.diagnosis import attempts, causes
from helmbench.diagnosis.bootstrap import independent_noise, independent_values
from helmbench.diagnosis.evidence import log_tail
from helmbench.diagnosis.refitting import refined, refit_cause
from helmbench.diagnosis.screening import screen
from helmbench.diagnosis.search import Search
from helmbench.diagnosis.selection import settle
from helmbench.methods.innovations.estimator import Estimator
from helmbench.models.model import resolve

NULLS, LEVEL, MOST = 40, 0.1, 12
"""Of 40 records with nothing planted a right level of .1 passes 13 or more in .05 % of draws."""


def started(records, vessel, rng, settled=True):
    est = Estimator(resolve(vessel), records)
    start = est.start()
    search = Search(est, start, start, est.evaluate(start), causes.testable(est)[0], rng, 0.01)
    if settled:
        settle(search)
    return search


def log_levels(search):
    """Log p-values of refits of causes at the end of their range, with an unknown time, or of unknown frequency."""
    before = search.now.log_likelihood
    items = {i.cause: i for i in screen(search, search.setting, search.now)}
    names = ("rudder_delay", "rudder_backlash", "rudder_fault")
    found = {c: refined(search, [refit_cause(search, items[c], before)], before)[0].log_p for c in names}
    waves = attempts.try_waves(search, -np.inf)  # also where the scan asks for none
    if waves is not None:
        gain = 2.0 * (waves.now.log_likelihood - before)
        found["wave_motion"] = np.log(waves.tests) + log_tail(gain, waves.k)
    return found


def test_levels_hold_where_nothing_is_hidden(rng):
    passed = {}
    for _ in range(NULLS):
        record, *_ = plant(Case("response-1", (), "large", duration_s=60.0, dt_s=0.2), rng).train
        for cause, log_p in log_levels(started([record], "response-1", rng)).items():
            passed[cause] = passed.get(cause, 0) + (log_p < np.log(LEVEL))
    print(passed)
    assert set(passed) >= {"rudder_delay", "rudder_backlash", "rudder_fault"}
    assert all(count <= MOST for count in passed.values())


@pytest.fixture(scope="module")
def still():
    """A search in a record of the model itself."""
    record = generate(Generated("mariner", "zigzag:20/20", "low", seed=1))
    return started([record], "mariner", np.random.default_rng(0), settled=False)


def test_values_that_do_the_same_are_half_a_test_and_others_more(still, rng):
    """A cause that cannot be negative: one direction counts half, twelve that have nothing in common count six."""
    search = replace(still, rng=rng, known={})
    change = rng.standard_normal((12, *search.now.e.shape))
    runs = [search.now._replace(e=search.now.e + 1e-3 * x) for x in change]
    same = [search.now._replace(e=search.now.e + amount * change[0]) for amount in (1e-3, 2e-3, 5e-3)]
    assert independent_values(search, same) == pytest.approx(0.5, abs=0.1)
    assert independent_values(search, runs) == pytest.approx(6.0, rel=0.4)
    assert independent_values(search, [search.now]) == 0.5  # what changes nothing is no choice


def test_noise_like_the_sensors_is_no_further_kind(still, rng):
    """Three kinds of waves are three; noise as the sensors have it is projected out and counts nothing."""
    search = replace(still, rng=rng, known={})
    slots = [search.est.index[f"wave_{name}"] for name in ("frequency", "damping", "rms")]
    waves = [attempts._waves_at(search.setting, slots, (omega, 0.05, 1e-5), None) for omega in (0.2, 0.6, 1.8)]
    louder = search.setting.noise.copy()
    louder[0] *= 1.02
    alone, each = independent_noise(search, waves)
    beside, _ = independent_noise(search, [*waves, replace(search.setting, noise=louder)])
    assert alone == pytest.approx(1.5, rel=0.3) and each == [pytest.approx(alone, rel=0.2)]
    assert beside == pytest.approx(alone, rel=0.2)
