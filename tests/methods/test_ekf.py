"""Joint extended Kalman filter: exact without noise, near the bound with it."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.information.bounds import cramer_rao
from helmbench.estimation.regression.starts import starts_of
from helmbench.methods.kalman import Ekf
from helmbench.models.errors import CannotFit

from ..made_up.records import relative_errors
from ..nightly_marks import nightly_but

LOW = {"yaw_rate_rad_s": np.deg2rad(0.01), "heading_rad": np.deg2rad(0.02)}


@pytest.mark.parametrize(
    "vessel", nightly_but(["remus-kt", "response-2", "cargo", "kvlcc2-l7", "s175"], "remus-kt", "response-2", "cargo")
)
def test_exact_without_noise(suite, vessel):
    model, records = suite(vessel)
    estimate = Ekf().fit(records, model.blanked())
    errors = relative_errors(estimate, model)
    # S175's surge coefficients cancel each other to 1 part in 1e9
    assert np.median(list(errors.values())) < 1e-7
    assert max(errors.values()) < (1e-5 if vessel == "s175" else 1e-6)


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "remus-kt", "patrol"])
def test_near_the_bound_with_noise(suite, vessel):
    """Sensor noise on rudder, yaw rate and heading; the rudder's acts as process noise, which the filter allows for."""
    model, records = suite(vessel, noise="low", seed=11)
    estimate = Ekf().fit(records, model.blanked())
    bound, _ = cramer_rao(model, records, LOW)
    truth = np.array([*model.parameters.values()])
    z = (np.array([*estimate.parameters.values()]) - truth) / bound
    assert np.sqrt(np.mean(z**2)) < 6.0
    start = np.abs(starts_of(records, model)[0].coefficients / model.coefficients - 1.0).max()
    assert max(relative_errors(estimate, model).values()) < start


def test_trajectory_and_innovations(suite):
    model, records = suite("response-1", noise="low")
    estimate = Ekf(passes=2).fit(records, model)
    n = sum(r.n for r in records)
    assert estimate.trajectory.shape == (2 * n, 3)
    assert estimate.trajectory[-1] == pytest.approx(estimate.coefficients, rel=1e-12)
    assert [i.shape for i in estimate.extra["innovations"]] == [(r.n, 2) for r in records]
    rate = np.concatenate(estimate.extra["innovations"])[100:, 0]
    assert np.std(rate) < 2.0 * LOW["yaw_rate_rad_s"]


def test_refusals(suite):
    model, _ = suite("response-1")
    blind = generate(Case("response-1", "straight", duration_s=20.0)).with_channels(
        yaw_rate_rad_s=None, heading_rad=None
    )
    with pytest.raises(CannotFit):
        Ekf().fit([blind], model)
