"""What a large cause leaves behind counts only where it shows; several causes must be worth more than one unknown."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.planting import Case as Planted
from helmbench.bench.planting import plant
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis import causes, diagnose, selection
from helmbench.diagnosis.diagnose import RIVALLED_LEVEL, RIVALLED_NATS
from helmbench.diagnosis.gusts import worth
from helmbench.diagnosis.hypotheses import FURTHER_NATS, lead
from helmbench.diagnosis.refitting import as_effectiveness
from helmbench.diagnosis.search import Candidate, Search, mimicry, shown, stands_out
from helmbench.methods.innovations.estimator import Estimator
from helmbench.models.model import resolve

R, X, Y = 1, 4, 5


@pytest.fixture
def under_current(rng):
    """A search that has accepted a current of .3 m/s, thousands of times its standard error."""
    est = Estimator(resolve("mariner"), [generate(Case("mariner", "zigzag:20/20", "low", seed=1))])
    bank, _ = causes.testable(est)
    (variant,) = bank["current"]
    s = est.start()
    for p, value in zip(variant, (0.2, -0.25), strict=False):
        s = est.at(s, p, value)
    now = est.evaluate(s)
    current = Candidate("current", variant, -500.0, 1000.0, s, now)
    return Search(est, est.start(), s, now, bank, rng, 0.01, accepted=[current])


def _candidate(search, cause, sds):
    """A cause of one parameter, so many of its standard errors large."""
    variant = search.bank[cause][0][:1]
    spread = 1.0 / np.linalg.norm(search.est.column(search.setting, search.now, variant))
    s = search.est.at(search.setting, variant[0], sds * spread)
    return Candidate(cause, variant, -0.5 * sds**2, sds**2, s, search.est.evaluate(s))


def test_a_current_shows_in_the_track(under_current):
    share = shown(under_current, under_current.accepted[0])
    assert share.sum() == pytest.approx(1.0)
    assert share[[X, Y]].sum() > 0.7 and share[R] < 0.05


def test_leftovers_of_a_current_leave_the_yaw_rate_alone(under_current):
    """Twelve standard errors are much for a gyro's bias and nothing beside 2 % of a large current's way."""
    left = mimicry(under_current)
    assert left[X] > 500.0 and left[R] < 50.0
    assert stands_out(under_current, _candidate(under_current, "yaw_rate_bias", 12.0))
    assert not stands_out(under_current, _candidate(under_current, "constant_force", 12.0))
    assert stands_out(replace(under_current, accepted=[]), _candidate(under_current, "constant_force", 12.0))


def test_one_unknown_effect_outdoes_two_causes_that_fit_little_better(under_current):
    """One cause stands against an unknown effect that fits as well; two must fit better than it by twelve nats."""
    second = _candidate(under_current, "yaw_rate_bias", 12.0)
    one, two = under_current, replace(under_current, accepted=[*under_current.accepted, second])
    for nats, alone, both in ((3.0, False, True), (FURTHER_NATS, False, True), (2.0 * FURTHER_NATS, False, False)):
        log_s = one.now.log_s.copy()
        log_s[0, 0] += np.log(one.n_effective) + nats
        now = one.now._replace(log_s=log_s)
        alone_worth = worth(one.est, one.setting, now)
        rival = Candidate("unknown:r", second.variant, -40.0, 90.0, one.setting, now, worth=alone_worth)
        assert (lead(replace(one, rival=rival)) < 0.0) == alone
        assert (lead(replace(two, rival=rival)) < 0.0) == both
    assert lead(two) == np.inf


def test_what_an_unknown_effect_rivals_must_be_the_same_throughout(under_current, monkeypatch):
    """A size that changes a little counts where an unknown effect fits nearly as well, and nowhere else."""
    said = "current of another size late"
    monkeypatch.setattr(diagnose.selection, "size_tests", lambda search: [(said, np.log(0.5 * RIVALLED_LEVEL))])
    est = under_current.est
    s, now = est.settle(est.start(), est.start())
    here = worth(est, s, now) - np.log(under_current.n_effective)
    for behind, told in ((0.5 * RIVALLED_NATS, True), (1.5 * RIVALLED_NATS, False)):
        rival = Candidate("unknown:r", (), -40.0, 90.0, s, now, worth=here - behind)
        search = replace(under_current, setting=s, now=now, rival=rival)
        found = diagnose._unexplained(search, diagnose.Options())
        assert (found is not None and said in found.cause) == told


def test_a_fault_before_the_rudder_moves_is_a_loss_of_effectiveness(rng):
    """From the size that the fault's fit has come to; not where the fault comes later."""
    model = resolve("response-1")
    est = Estimator(model, [generate(Case("response-1", "zigzag:20/20", "low", seed=1))])
    bank, _ = causes.testable(est)
    search = Search(est, est.start(), est.start(), est.evaluate(est.start()), bank, rng, 0.01)
    (fault,) = bank["rudder_fault"]
    for t0, steady in ((0.0, True), (0.5 * est.data[0].time[-1], False)):
        s = est.at(est.at(search.setting, fault[1], t0), fault[0], 0.02)
        there = Candidate("rudder_fault", fault, -40.0, 90.0, s, est.evaluate(s))
        found = as_effectiveness(search, there, search.now.log_likelihood)
        assert (found is not None) == steady
        if found is not None:
            assert found.cause == "rudder_effectiveness" and found.statistic > -0.1
            assert abs(est.value(found.setting, found.variant[0])) < 0.01


def test_an_accepted_fault_that_moved_before_the_rudder_gives_way(rng):
    """What else is named may move a fault's time; one that is there from the start is a loss of effectiveness."""
    case = plant(Planted("response-1", ("rudder_effectiveness",), "large", duration_s=60.0, dt_s=0.2), rng)
    est = Estimator(resolve("response-1"), case.train)
    bank, _ = causes.testable(est)
    (fault,) = bank["rudder_fault"]
    for share, name in ((0.0, "rudder_effectiveness"), (0.5, "rudder_fault")):
        s = est.at(est.at(est.start(), fault[1], share * est.data[0].time[-1]), fault[0], 0.05)
        s, now = est.refit(s, fault[:1], 8)
        accepted = Candidate("rudder_fault", fault, -40.0, 90.0, s, now)
        ties = {"rudder_fault": ("rudder_backlash",)}
        search = Search(est, est.start(), s, now, bank, rng, 0.01, accepted=[accepted], ties=ties)
        selection._steady(search)
        assert [a.cause for a in search.accepted] == [*search.ties] == [name]
        assert search.now.log_likelihood == est.evaluate(search.setting).log_likelihood
        if share == 0.0:
            (e,) = search.accepted[0].variant
            print(case.truth, est.value(search.setting, e))
            assert est.value(search.setting, e) == pytest.approx(case.truth[0]["parameters"]["e"], rel=0.2)
