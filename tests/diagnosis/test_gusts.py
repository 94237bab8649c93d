"""Gusts are assumed in their proportions and at their price: what faint causes must beat in calm."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.planting import Case as Planted
from helmbench.bench.planting import plant
from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis import causes, gusts, selection
from helmbench.diagnosis.gusts import Judged, worth
from helmbench.diagnosis.search import Candidate, Search
from helmbench.methods.innovations.estimator import Estimator
from helmbench.models.model import resolve


@pytest.fixture
def est():
    return Estimator(resolve("mariner"), [generate(Case("mariner", "zigzag:20/20", "low", seed=1))])


def _under(est, x, y, n, tau=10.0):
    """The start with gusts of these sd in surge, sway and yaw."""
    s = est.start()
    noise = s.noise.copy()
    noise[6:10] = x, y, n, tau
    s = replace(s, noise=noise)
    return s, est.evaluate(s)


def test_gusts_in_proportion_cost_one_nat_for_each_parameter(est):
    s, now = _under(est, 2e-6, 5e-6, 1e-6)
    calm, quiet = _under(est, 0.0, 0.0, 0.0)
    assert worth(est, calm, quiet) == Judged(est, calm, quiet).gust_like == quiet.log_likelihood
    assert quiet.log_likelihood > now.log_likelihood  # nothing acts in this record
    assert Judged(est, s, now).gust_like == now.log_likelihood
    gusty = now._replace(log_s=now.log_s - 100.0 / now.log_s.size)
    assert worth(est, s, gusty) == pytest.approx(max(gusty.log_likelihood - 4.0, quiet.log_likelihood))


def test_strong_gusts_just_out_of_proportion_lose_little(rng, monkeypatch):
    """The likelihood of strong gusts falls by nats within a tenth of their size: the best in proportion are found."""
    est = Estimator(resolve("mariner"), plant(Planted("mariner", gusts="fast"), rng).train)
    s, now = est.settle(est.start(), est.start())
    ratio = s.noise[6] / s.noise[8]
    monkeypatch.setattr(gusts, "GUST_Y", (0.1, 100.0))
    for out in (1.01, 1.02, 1.03, 1.04):
        monkeypatch.setattr(gusts, "GUST_X", (0.1 * ratio, ratio / out))
        assert now.log_likelihood - 0.4 < Judged(est, s, now).gust_like <= now.log_likelihood


@pytest.mark.parametrize("vessel", ["response-1", "response-2"])
def test_a_response_models_one_axis_has_no_proportions(vessel):
    """The moment (and its rate) of gusts is all there is; its parameters still cost."""
    est = Estimator(resolve(vessel), [generate(Case(vessel, "zigzag:20/20", "low", seed=1))])
    s = est.start()
    noise = s.noise.copy()
    noise[6 : 6 + est.n_forces] = 1e-5
    s = replace(s, noise=noise)
    now = est.evaluate(s)
    assert Judged(est, s, now).gust_like == now.log_likelihood
    gusty = now._replace(log_s=now.log_s - 1e6 / now.log_s.size)
    assert worth(est, s, gusty) == pytest.approx(gusty.log_likelihood - est.n_forces - 1.0)


def test_a_moment_alone_is_no_gust(est):
    """Gusts turn no ship without pushing it: the best gusts fit worse than the yaw moment that was fitted."""
    p = next(v for v in causes.testable(est)[0]["yaw_damping_quadratic"])[0]
    spread = 1.0 / np.linalg.norm(est.column(est.start(), est.evaluate(est.start()), (p,)))
    planted = est.at(est.start(), p, 30.0 * spread)
    found, now = est.settle(planted, est.start())
    assert found.noise[8] > 0.0
    moment = found.noise.copy()
    moment[6:8] = 0.0
    alone = replace(found, noise=moment)
    there = est.evaluate(alone)
    assert Judged(est, alone, there).gust_like < there.log_likelihood - 0.5
    assert worth(est, alone, there) <= Judged(est, alone, there).gust_like
    assert now.log_likelihood >= there.log_likelihood - 1.0


def test_a_rival_below_the_level_is_told_as_a_tie(est, rng):
    """Of two dampings that move the ship alike the second is a tie though it did not pass, unless it is far behind."""
    bank, _ = causes.testable(est)
    s = est.start()
    for behind, tied in ((2.0, ("yaw_damping_cubic",)), (9.0, ())):
        search = Search(est, s, s, est.evaluate(s), bank, rng, 0.01)
        found = []
        for cause, log_p in (("yaw_damping_quadratic", -9.0), ("yaw_damping_cubic", -9.0 + behind)):
            (p,) = variant = bank[cause][0]
            spread = 1.0 / np.linalg.norm(est.column(s, search.now, variant))
            at = est.at(s, p, 5.0 * spread)
            found.append(Candidate(cause, variant, log_p, 20.0, at, est.evaluate(at), k=1))
        selection.accept(search, found[0], found)
        assert search.ties["yaw_damping_quadratic"] == tied
