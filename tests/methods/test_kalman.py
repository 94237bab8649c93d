"""Joint extended Kalman filter: exact without noise, near the bound with it."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.information.bounds import cramer_rao
from helmbench.estimation.regression.starts import starts_of
from helmbench.methods.kalman import Ekf, Ukf
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve
from helmbench.models.simulate import simulate

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


# ---- Unscented Kalman filter on held-out records and a noisy heading.


def test_mariner_rich_set_predicts_held_out_zigzag():
    """Noise .01 m/s and .05 deg/s: at least as good as smoothing and least squares (.03)."""
    model = resolve("mariner-model")
    noise = "surge=0.01m_s,sway=0.01m_s,yaw_rate=0.05deg_s"
    records = [generate(Case("mariner-model", text, noise, seed=2)) for text in model.suite["train"]]
    found = Ukf(passes=2).fit(records, model).model
    held = generate(Case("mariner-model", "zigzag:30/30"))
    start = np.array([held.column("surge_m_s")[0], 0.0, 0.0, 0.0, 0.0, 0.0])
    run = simulate(found, held.rudder()[:, None], held.dt, start)
    channels = [held.column(name) for name in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s")]
    error = [np.sqrt(np.mean((run[:, i] - y) ** 2)) / y.std() for i, y in enumerate(channels)]
    print(error)
    assert max(error) < 0.05


def test_response_model_from_a_noisy_heading(rng):
    """T2 and T3 nearly cancel: over 110 draws T2 is off by -3 +- 4 %, T1 by -0.1 +- 0.1 %, K by +- 0.006 %."""
    model = resolve("cargo")
    record = generate(Case("cargo", model.suite["train"][0], "none", duration_s=3600.0)).with_channels(
        yaw_rate_rad_s=None
    )
    noisy = record.with_channels(heading_rad=record.column("heading_rad") + 2e-4 * rng.normal(size=record.n))
    found = Ukf(passes=10).fit([noisy], model).parameters
    print(found)
    limits = {"T1": 0.01, "T2": 0.25, "T3": 0.18, "K": 0.001}
    assert all(found[name] == pytest.approx(value, rel=limits[name]) for name, value in model.parameters.items())
