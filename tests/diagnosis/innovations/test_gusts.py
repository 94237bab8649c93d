"""Gusts are assumed in their proportions and at their price: what faint causes must beat in calm."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import testable as bank_of
from helmbench.diagnosis.innovations import criterion, gusts
from helmbench.diagnosis.innovations.gusts import GustLikelihood, penalised_likelihood
from helmbench.diagnosis.innovations.state import Candidate, first_state
from helmbench.estimation.filters.innovations.derivatives import columns
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.noise_fit import fit_noise_from_starts
from helmbench.models.model import resolve


@pytest.fixture
def est():
    return estimator(resolve("mariner"), [generate(Case("mariner", "zigzag:20/20", "low", seed=1))])


def _under(est, x, y, n, tau=10.0):
    """The start with gusts of these sd in surge, sway and yaw."""
    s = est.start()
    s = replace(s, noise=replace(s.noise, force_sd=np.array([x, y, n]), correlation_time_s=tau))
    return s, est.evaluate(s)


def test_gusts_in_proportion_cost_one_nat_for_each_parameter(est):
    s, now = _under(est, 2e-6, 5e-6, 1e-6)
    calm, quiet = _under(est, 0.0, 0.0, 0.0)
    assert penalised_likelihood(est, calm, quiet) == GustLikelihood(est, calm, quiet).gusty == quiet.log_likelihood
    assert quiet.log_likelihood > now.log_likelihood  # nothing acts in this record
    assert GustLikelihood(est, s, now).gusty == now.log_likelihood
    gusty = now._replace(log_s=now.log_s - 100.0 / now.log_s.size)
    assert penalised_likelihood(est, s, gusty) == pytest.approx(max(gusty.log_likelihood - 4.0, quiet.log_likelihood))


def test_strong_gusts_just_out_of_proportion_lose_little(rng, monkeypatch):
    """The likelihood of strong gusts falls by nats within a tenth of their size: the best in proportion are found."""
    est = estimator(resolve("mariner"), inject(FaultCase("mariner", gusts="fast"), rng).train)
    s, now = fit_noise_from_starts(est, est.start(), est.start())
    ratio = s.noise.force_sd[0] / s.noise.force_sd[2]
    monkeypatch.setattr(gusts, "GUST_Y", (0.1, 100.0))
    for out in (1.01, 1.02, 1.03, 1.04):
        monkeypatch.setattr(gusts, "GUST_X", (0.1 * ratio, ratio / out))
        assert now.log_likelihood - 0.4 < GustLikelihood(est, s, now).gusty <= now.log_likelihood


@pytest.mark.parametrize("vessel", ["response-1", "response-2"])
def test_a_response_models_one_axis_has_no_proportions(vessel):
    """The moment (and its rate) of gusts is all there is; its parameters still cost."""
    est = estimator(resolve(vessel), [generate(Case(vessel, "zigzag:20/20", "low", seed=1))])
    s = est.start()
    s = replace(s, noise=replace(s.noise, force_sd=np.full(est.n_forces, 1e-5)))
    now = est.evaluate(s)
    assert GustLikelihood(est, s, now).gusty == now.log_likelihood
    gusty = now._replace(log_s=now.log_s - 1e6 / now.log_s.size)
    assert penalised_likelihood(est, s, gusty) == pytest.approx(gusty.log_likelihood - est.n_forces - 1.0)


def test_a_moment_alone_is_no_gust(est):
    """Gusts turn no ship without pushing it: the best gusts fit worse than the yaw moment that was fitted."""
    ((p,),) = bank_of(est)[0][cause_of("yaw_damping_quadratic")]
    spread = 1.0 / np.linalg.norm(columns(est, est.start(), (p,)))
    injected = est.at(est.start(), p, 30.0 * spread)
    found, now = fit_noise_from_starts(est, injected, est.start())
    assert found.noise.force_sd[2] > 0.0
    moment = found.noise.force_sd * np.array([0.0, 0.0, 1.0])
    alone = replace(found, noise=replace(found.noise, force_sd=moment))
    there = est.evaluate(alone)
    assert GustLikelihood(est, alone, there).gusty < there.log_likelihood - 0.5
    assert penalised_likelihood(est, alone, there) <= GustLikelihood(est, alone, there).gusty
    assert now.log_likelihood >= there.log_likelihood - 1.0


def test_a_rival_below_the_level_is_a_tie(est, rng):
    """Of two dampings that move the ship alike the second is a tie though it did not pass, unless it is far behind."""
    quadratic, cubic = (cause_of(f"yaw_damping_{name}") for name in ("quadratic", "cubic"))
    for behind, tied in ((2.0, (cubic,)), (9.0, ())):
        state = first_state(est, bank_of(est)[0], 0.01, (), None)
        found = []
        for cause, log_p in ((quadratic, -9.0), (cubic, -9.0 + behind)):
            (variant,) = state.bank[cause]
            spread = 1.0 / np.linalg.norm(columns(est, state.setting, variant))
            at = est.at(state.setting, variant[0], 5.0 * spread)
            found.append(Candidate(cause, variant, log_p, 20.0, at, est.evaluate(at), k=1))
        state = criterion.accepted(state, found[0], found, rng)
        assert [(a.cause, a.tied) for a in state.accepted] == [(quadratic, tied)]
