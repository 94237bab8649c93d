"""Moving horizon: output error where it holds the whole record, exact without noise, and an arrival cost that keeps
what the samples before it say."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.likelihood.problem import free_start_problem, sensor_sd_of
from helmbench.estimation.records.series import series_of
from helmbench.methods.moving_horizon import Arrival, Horizon, MovingHorizon, eliminated, horizon_pass
from helmbench.methods.output_error import OutputError
from helmbench.models.model import resolve

from ..made_up.records import relative_errors
from ..nightly_marks import nightly_but

WHOLE = Horizon(steps=100_000, stretches=1, forgetting=1.0)


def _weighted(records, model):
    problem = free_start_problem([series_of(record, model) for record in records], model)
    return replace(problem, sensor=sensor_sd_of(problem))


@pytest.mark.parametrize("vessel", ["response-1", "remus-kt", "kvlcc2-l7"])
def test_one_horizon_over_the_whole_record_is_output_error(suite, vessel, seed):
    """Without prior; both searches end within a few thousandths of a standard error.  All states are measured: others
    have a prior of their initial value here, and none in output error."""
    model, records = suite(vessel, noise="low", seed=seed % 2**31)
    own = MovingHorizon(horizon=100_000, step=1.0, inflation=1e6, passes=10).fit(records[-1], model.blanked())
    other = OutputError().fit(records[-1], model.blanked())
    sd = np.sqrt(np.diag(other.covariance))
    assert own.converged and other.converged
    assert np.abs((own.coefficients - other.coefficients) / sd).max() < 0.02
    assert np.sqrt(np.diag(own.covariance)) == pytest.approx(sd, rel=0.02)


@pytest.mark.parametrize("vessel", nightly_but(["response-2", "kvlcc2-l7"], "response-2"))
def test_a_small_horizon_is_exact_without_noise(suite, vessel):
    model, records = suite(vessel)
    estimate = MovingHorizon(horizon=60, passes=3).fit([records[1], records[-1]], model.blanked())
    assert estimate.converged
    assert max(relative_errors(estimate, model).values()) < 1e-6


def test_eliminated_unknowns_leave_the_least_sum_of_squares(rng):
    rows = rng.normal(size=(20, 8))
    left = eliminated(rows, 2, 5)
    assert left.shape == (5, 5)
    for _ in range(3):
        z = rng.normal(size=4)
        a, b = rows[:, 2:5], rows[:, -1] - rows[:, [0, 1, 5, 6]] @ z
        best = b - a @ np.linalg.lstsq(a, b, rcond=None)[0]
        assert np.sum((left[:, -1] - left[:, :-1] @ z) ** 2) == pytest.approx(best @ best, rel=1e-9)


def test_the_arrival_cost_keeps_what_earlier_samples_say(suite, seed):
    """Close to the truth the problem is linear: short horizons with hardly any disturbance (a hundredth of a sensor's
    noise over the record) end like one over the record.  In 40 draws the disturbances changed standard errors by at
    most 1.03 % and coefficients by at most .13 standard errors."""
    model, records = suite("kvlcc2-l7", noise="low", seed=seed % 2**31)
    problem, c = _weighted(records[:2], model), model.coefficients
    prior = Arrival.prior(c, np.diag(1e-3 * np.abs(c) + 1e-9))
    whole, short = (horizon_pass(problem, prior, h, 1e-8 * problem.sensor**2) for h in (WHOLE, Horizon(60, 3, 1.0)))
    sd = np.sqrt(np.diag(whole.covariance))
    assert len(whole.path) == 2 and len(short.path) > 40
    assert np.sqrt(np.diag(short.covariance)) == pytest.approx(sd, rel=0.1)
    assert np.abs((short.coefficients - whole.coefficients) / sd).max() < 1.0


def test_what_the_records_do_not_show_keeps_its_prior(seed):
    """On a straight course nothing is known of sway and yaw; forgetting widens their prior with every move."""
    model = resolve("kvlcc2-l7")
    record = generate(Case("kvlcc2-l7", "straight", "low", seed=seed % 2**31, duration_s=30.0, dt_s=0.2))
    record = record.with_channels(rudder_rad=np.zeros(record.n), sway_m_s=np.zeros(record.n))
    record = record.with_channels(yaw_rate_rad_s=np.zeros(record.n), heading_rad=np.zeros(record.n))
    c = model.coefficients
    sd = np.abs(c) + 1e-6
    first, forgetting = Arrival.prior(c, np.diag(sd)), 0.9
    process = np.full(len(model.states), 1e-20)
    found = {f: horizon_pass(_weighted([record], model), first, Horizon(30, 3, f), process) for f in (1.0, forgetting)}
    names = np.array(model.coordinates)
    known = np.sqrt(np.diag(found[1.0].covariance)) < 0.99 * sd
    assert [*names[known]] == ["R_0"]
    assert found[1.0].coefficients[~known] == pytest.approx(c[~known], rel=1e-6, abs=1e-12)
    spread = np.sqrt(np.diag(found[forgetting].covariance))[~known]
    moves = len(found[forgetting].path) - 1
    assert moves == 12 and spread == pytest.approx(sd[~known] * forgetting ** (-moves / 2.0), rel=0.01)


def test_the_trajectory_has_a_row_for_every_horizon(suite):
    model, records = suite("response-1", noise="low")
    estimate = MovingHorizon(passes=2).fit(records, model)
    n = estimate.extra["horizons"]
    assert estimate.trajectory.shape == (2 * n, 3) and estimate.extra["passes"] == 2
    assert estimate.trajectory_time_s[-1] == pytest.approx(2.0 * sum(r.time_s[-1] - r.time_s[0] for r in records))
    assert set(estimate.extra["residual_sd"]) == {"r", "psi"}
