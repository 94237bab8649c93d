"""What a large cause leaves behind counts only where it shows; several causes must be worth more than one unknown."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import testable as bank_of
from helmbench.diagnosis.innovations import criterion, tests
from helmbench.diagnosis.innovations.gusts import penalised_likelihood
from helmbench.diagnosis.innovations.state import (
    Candidate,
    Unmodelled,
    channel_shares,
    exceeds_misfit,
    first_state,
    misfit_allowance,
)
from helmbench.diagnosis.innovations.unmodelled import (
    FURTHER_NATS,
    RIVALLED_LEVEL,
    RIVALLED_NATS,
    margin_over_unmodelled,
    unexplained,
)
from helmbench.estimation.diagnosis_only.refit import refit
from helmbench.estimation.filters.innovations.derivatives import columns
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.noise_fit import fit_noise_from_starts
from helmbench.models.model import resolve

R, X, Y = 1, 4, 5


def _started(vessel, records):
    est = estimator(resolve(vessel), records)
    return first_state(est, bank_of(est)[0], 0.01, (), None)


@pytest.fixture
def under_current():
    """A state that has accepted a current of .3 m/s, thousands of times its standard error."""
    state = _started("mariner", [generate(Case("mariner", "zigzag:20/20", "low", seed=1))])
    cause = cause_of("current")
    (variant,) = state.bank[cause]
    s = state.setting
    for p, value in zip(variant, (0.2, -0.25), strict=False):
        s = state.est.at(s, p, value)
    now = state.est.evaluate(s)
    return state.at(s, now, [Candidate(cause, variant, -500.0, 1000.0, s, now)])


def _candidate(state, name, sds):
    """A cause of one parameter, so many of its standard errors large."""
    cause = cause_of(name)
    variant = state.bank[cause][0][:1]
    spread = 1.0 / np.linalg.norm(columns(state.est, state.setting, variant))
    s = state.est.at(state.setting, variant[0], sds * spread)
    return Candidate(cause, variant, -0.5 * sds**2, sds**2, s, state.est.evaluate(s))


def test_a_current_shows_in_the_track(under_current):
    share = channel_shares(under_current, under_current.accepted[0])
    assert share.sum() == pytest.approx(1.0)
    assert share[[X, Y]].sum() > 0.7 and share[R] < 0.05


def test_misfit_of_a_current_leaves_the_yaw_rate_alone(under_current):
    """Twelve standard errors are much for a gyro's bias and nothing beside 2 % of a large current's way."""
    left = misfit_allowance(under_current)
    assert left[X] > 500.0 and left[R] < 50.0
    assert exceeds_misfit(under_current, _candidate(under_current, "yaw_rate_bias", 12.0))
    force = _candidate(under_current, "constant_force", 12.0)
    assert not exceeds_misfit(under_current, force)
    assert exceeds_misfit(replace(under_current, accepted=()), force)


def test_one_unmodelled_effect_outdoes_two_causes_that_fit_little_better(under_current):
    """One cause stands against an unmodelled effect that fits as well; two must fit better than it by twelve nats."""
    one, second = under_current, _candidate(under_current, "yaw_rate_bias", 12.0)
    two = one.at(one.setting, one.now, [*one.accepted, second])
    for nats, alone, both in ((3.0, False, True), (FURTHER_NATS, False, True), (2.0 * FURTHER_NATS, False, False)):
        log_s = one.now.log_s.copy()
        log_s[0, 0] += np.log(one.n_effective) + nats
        now = one.now._replace(log_s=log_s)
        penalised = penalised_likelihood(one.est, one.setting, now)
        rival = Candidate(Unmodelled("r"), second.variant, -40.0, 90.0, one.setting, now, penalised=penalised)
        assert (margin_over_unmodelled(replace(one, rival=rival)) < 0.0) == alone
        assert (margin_over_unmodelled(replace(two, rival=rival)) < 0.0) == both
    assert margin_over_unmodelled(two) == np.inf


def test_what_an_unmodelled_effect_rivals_must_be_the_same_throughout(under_current, monkeypatch, rng):
    """A size that changes a little counts where an unmodelled effect fits nearly as well, and nowhere else."""
    label = "current of another size late"
    monkeypatch.setattr(tests, "size_tests", lambda *of: [(label, np.log(0.5 * RIVALLED_LEVEL))])
    est = under_current.est
    s, now = fit_noise_from_starts(est, est.start(), est.start())
    here = penalised_likelihood(est, s, now) - np.log(under_current.n_effective)
    for behind, named in ((0.5 * RIVALLED_NATS, True), (1.5 * RIVALLED_NATS, False)):
        rival = Candidate(Unmodelled("r"), (), -40.0, 90.0, s, now, penalised=here - behind)
        found = unexplained(replace(under_current.at(s, now), rival=rival), rng)
        assert (found is not None and label in found.cause.label) == named


def test_a_fault_before_the_rudder_moves_is_a_loss_of_effectiveness(rng):
    """From the size that the fault's fit has come to; not where the fault comes later."""
    state = _started("response-1", [generate(Case("response-1", "zigzag:20/20", "low", seed=1))])
    est, cause = state.est, cause_of("rudder_fault")
    (fault,) = state.bank[cause]
    for t0, steady in ((0.0, True), (0.5 * est.segments[0].time[-1], False)):
        s = est.at(est.at(state.setting, fault[1], t0), fault[0], 0.02)
        there = Candidate(cause, fault, -40.0, 90.0, s, est.evaluate(s))
        found = cause.simpler(state, there, state.now.log_likelihood, rng)
        assert (found is not None) == steady
        if found is not None:
            assert found.cause == cause_of("rudder_effectiveness") and found.statistic > -0.1
            assert abs(est.value(found.setting, found.variant[0])) < 0.01


def test_an_accepted_fault_that_moved_before_the_rudder_gives_way(rng):
    """What else is named may move a fault's time; one that is there from the start is a loss of effectiveness."""
    case = inject(FaultCase("response-1", ("rudder_effectiveness",), "large", duration_s=60.0, dt_s=0.2), rng)
    first = _started("response-1", case.train)
    est, cause = first.est, cause_of("rudder_fault")
    (fault,) = first.bank[cause]
    for share, name in ((0.0, "rudder_effectiveness"), (0.5, "rudder_fault")):
        s = est.at(est.at(est.start(), fault[1], share * est.segments[0].time[-1]), fault[0], 0.05)
        s, now = refit(est, s, fault[:1], 8)
        tied = (cause_of("rudder_backlash"),)
        state = first.at(s, now, [Candidate(cause, fault, -40.0, 90.0, s, now, tied=tied)])
        state = criterion._simplified(state, rng)
        assert [(a.cause, a.tied) for a in state.accepted] == [(cause_of(name), tied)]
        assert state.now.log_likelihood == est.evaluate(state.setting).log_likelihood
        if share == 0.0:
            (e,) = state.accepted[0].variant
            print(case.truth, est.value(state.setting, e))
            assert est.value(state.setting, e) == pytest.approx(case.truth[0]["parameters"]["e"], rel=0.2)
