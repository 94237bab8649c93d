"""Output error: exact without noise, efficient with it, and the published rows on measured records."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.estimation.information.bounds import cramer_rao
from helmbench.estimation.records.series import series_of
from helmbench.estimation.simulation import free_run
from helmbench.methods.output_error import OutputError
from helmbench.methods.rls import Rls
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve

from ..made_up.records import driven, relative_errors
from ..nightly_marks import nightly_but

NOISE_SD = {"yaw_rate_rad_s": np.deg2rad(0.01), "heading_rad": np.deg2rad(0.02)}


@pytest.mark.parametrize(
    "vessel", ["remus-kt", "remus", "cargo", "patrol", "response-1", "response-2", "kvlcc2-l7", "s175-polynomial"]
)
def test_exact_without_noise(suite, vessel):
    model, records = suite(vessel)
    estimate = OutputError().fit(records, model.blanked())
    worst = max(relative_errors(estimate, model).items(), key=lambda item: item[1])
    assert worst[1] < 1e-6, worst
    assert estimate.converged and estimate.extra["explains_records"]


def test_sixty_coefficients_without_noise(suite):
    model, records = suite("mariner-model")
    estimate = OutputError().fit(records, model.blanked())
    assert max(relative_errors(estimate, model).values()) < 1e-6
    assert max(abs(estimate.parameters[k]) for k, value in model.parameters.items() if not value) < 1e-7


# Train on 15/5, free run on the measured rudder of the others: R2 and RMSE of r [deg/s], RMSE of psi [deg].
HELD_OUT = ("Z_25_05", "Z_10_10_P", "Z_10_10_S")


ROWS = {
    "nomoto-1-cubic": [(0.953, 0.43, 2.9), (0.891, 0.40, 5.0), (0.837, 0.49, 8.0)],
    "nomoto-2": [(0.977, 0.30, 12.0), (0.964, 0.23, 5.0), (0.937, 0.31, 10.7)],
    "integrator": [(0.680, 1.12, 20.5), (0.890, 0.40, 3.6), (0.864, 0.45, 9.2)],
}


@pytest.mark.parametrize("family", ROWS)
def test_published_rows_on_hsva(hsva, family):
    estimate = OutputError().fit([hsva("Z_15_05")], resolve(family))
    assert estimate.extra["channels"] == ["r"] and not estimate.extra["explains_records"]
    for stem, (r2, rmse, rmse_heading) in zip(HELD_OUT, ROWS[family], strict=True):
        series = series_of(hsva(stem), estimate.model, ("r", "psi"))
        error = free_run.residuals(estimate.model, series, series.start)
        rate = series.outputs[:, 0]
        assert 1.0 - np.mean(error[:, 0] ** 2) / np.var(rate) == pytest.approx(r2, abs=0.01)
        rms = np.rad2deg(np.sqrt(np.mean(error**2, axis=0)))
        assert rms[0] == pytest.approx(rmse, abs=0.01)
        assert rms[1] == pytest.approx(rmse_heading, abs=0.15)


def test_first_order_parameters_on_hsva(hsva):
    found = OutputError().fit([hsva("Z_15_05")], resolve("nomoto-1-cubic")).parameters
    assert [found[k] for k in ("K", "T", "alpha")] == pytest.approx([0.519, 36.7, 765.0], rel=3e-3)


def noisy(record, rng, sd):
    return record.with_channels(**{k: record.column(k) + v * rng.normal(size=record.n) for k, v in sd.items()})


@pytest.mark.nightly
@pytest.mark.parametrize("channels", [["heading_rad"], ["yaw_rate_rad_s", "heading_rad"]], ids=["heading", "both"])
def test_efficiency(rng, channels):
    """40 records of paper 000's vessel: estimates scatter by the Cramer-Rao bound, and the stated errors are right."""
    model = resolve("remus-kt")
    clean = generate(Case("remus-kt", "zigzag:20/20"))
    clean = Record(clean.time_s, {k: clean.column(k) for k in ("rudder_rad", *channels)}, "remus")
    sd = {k: NOISE_SD[k] for k in channels}
    bound, _ = cramer_rao(model, [clean], sd)
    z, stated = [], []
    for _ in range(40):
        estimate = OutputError().fit([noisy(clean, rng, sd)], model.blanked())
        z.append((np.array([*estimate.parameters.values()]) - [*model.parameters.values()]) / bound)
        stated.append(np.array([*estimate.stderr.values()]) / bound)
    rms = np.sqrt(np.mean(np.square(z), axis=0))
    assert np.all((rms > 0.6) & (rms < 1.45)), rms
    assert np.all((np.mean(stated, axis=0) > 0.8) & (np.mean(stated, axis=0) < 1.25))


def test_cargo_by_three_sines_is_within_twice_the_bound(rng):
    """Paper 003's S3, heading alone, 10 records: rms errors of all four parameters against the Cramer-Rao bound.

    1e-3 rad of noise at 0.02 s, thinned to 1 s with the noise that carries the same information.
    """
    model = resolve("cargo")
    text = "heading:10deg/0.0105rad_s+6deg/0.031rad_s+4deg/0.083rad_s"
    clean = generate(Case("cargo", text, duration_s=3600.0, dt_s=1.0))
    clean = Record(clean.time_s, {k: clean.column(k) for k in ("rudder_rad", "heading_rad")}, "S3")
    sd = {"heading_rad": 1e-3 * np.sqrt(0.02)}
    bound, _ = cramer_rao(model, [clean], sd)
    z = []
    for _ in range(10):
        estimate = OutputError().fit([noisy(clean, rng, sd)], model)
        z.append((np.array([*estimate.parameters.values()]) - [*model.parameters.values()]) / bound)
    rms = np.sqrt(np.mean(np.square(z), axis=0))
    print(100.0 * bound / np.abs([*model.parameters.values()]), rms)
    assert np.all((rms > 0.35) & (rms < 2.0))


def test_mariner_rich_set_reaches_the_reference():
    """Noise .01 m/s and .05 deg/s on u, v, r: held-out NRMSE on the 30 deg zigzag below .02 in each of 3 seeds."""
    model, noise = resolve("mariner-model"), "surge=0.01m_s,sway=0.01m_s,yaw_rate=0.05deg_s"
    held = generate(Case("mariner-model", "zigzag:30/30"))
    series = series_of(held, model, ("u", "v", "r"))
    errors = []
    for seed in range(3):
        records = [generate(Case("mariner-model", text, noise, seed=seed)) for text in model.suite["train"]]
        found = OutputError().fit([record.with_channels(heading_rad=None) for record in records], model)
        error = free_run.residuals(found.model, series, series.start)
        errors.append(np.sqrt(np.mean(np.mean(error**2, axis=0) / np.var(series.outputs, axis=0))))
    print(errors)
    assert max(errors) < 0.02


def test_a_clean_channel_does_not_outweigh_the_noisy_ones():
    """Heading without noise and noisy velocities: the fit still explains the records."""
    model, noise = resolve("response-2"), "yaw_rate=0.05deg_s"
    record = generate(Case("response-2", "zigzag:20/20", noise, seed=1))
    assert OutputError().fit([record], model).extra["explains_records"]


def test_beats_least_squares_by_far(rng):
    """0.1 deg of heading noise: its third difference is useless, output error is within a few per cent."""
    model = resolve("remus-kt")
    clean = generate(Case("remus-kt", "zigzag:20/20")).with_channels(yaw_rate_rad_s=None)
    record = noisy(clean, rng, {"heading_rad": np.deg2rad(0.1)})
    recursive, direct = (m.fit([record], model) for m in (Rls(scheme="heading-difference"), OutputError()))
    assert max(relative_errors(recursive, model).values()) > 0.5
    assert max(relative_errors(direct, model).values()) < 0.07


@pytest.mark.parametrize("vessel", nightly_but(["kvlcc2-l7", "mariner-model", "remus"], "kvlcc2-l7"))
def test_three_degrees_of_freedom_with_noise(suite, vessel):
    model, records = suite(vessel, noise="medium", seed=4)
    estimate = OutputError().fit(records, model.blanked())
    assert estimate.extra["explains_records"] and estimate.extra["initial_states"] == "estimated"
    sensors = {"surge_m_s": 0.02, "sway_m_s": 0.02, "yaw_rate_rad_s": np.deg2rad(0.05), "heading_rad": np.deg2rad(0.1)}
    bound, _ = cramer_rao(model, records, sensors)
    truth = np.array([*model.parameters.values()])
    determined = bound < 0.3 * np.abs(truth)
    z = (np.array([*estimate.parameters.values()]) - truth) / bound
    assert np.sqrt(np.mean(z[determined] ** 2)) < 3.0


def test_a_wrong_model_does_not_explain_the_records(suite):
    """A first-order model on a second-order vessel: initial states are the record's, heading does not dominate."""
    _, records = suite("response-2", noise="low")
    estimate = OutputError().fit(records, resolve("nomoto-1"))
    assert not estimate.extra["explains_records"]
    assert estimate.extra["channels"] == ["r"] and estimate.extra["initial_states"] == "record"
    assert "does not explain" in estimate.message


def test_gaps_and_uneven_samples(rng):
    model = resolve("response-1")
    record = driven(model, 0.5 * np.sin(0.01 * np.arange(3000)), 0.05)
    holes = record.column("yaw_rate_rad_s").copy()
    holes[rng.random(3000) < 0.3] = np.nan
    estimate = OutputError().fit([record.with_channels(yaw_rate_rad_s=holes)], model)
    assert max(relative_errors(estimate, model).values()) < 1e-8
    dropped = np.flatnonzero(rng.random(3000) < 0.85)
    shorter = Record(record.time_s[dropped], {k: v[dropped] for k, v in record.channels.items()}, "rows left out")
    estimate = OutputError().fit([shorter], model)
    assert max(relative_errors(estimate, model).values()) < 1e-3  # the rudder between rows is interpolated
    fine = driven(model, 0.5 * np.sin(0.002 * np.arange(15000)), 0.01)
    kept = np.cumsum(rng.integers(3, 12, 3000))
    kept = np.append(0, kept[kept < 15000])
    uneven = Record(fine.time_s[kept], {k: v[kept] for k, v in fine.channels.items()})
    estimate = OutputError().fit([uneven], model)
    assert max(relative_errors(estimate, model).values()) < 1e-3  # the channels are interpolated to an even grid


def test_a_lost_first_sample(rng):
    model = resolve("kvlcc2-l7")
    record = driven(model, 0.4 * np.sign(np.sin(0.02 * np.arange(900))), 0.2)
    channels = {k: record.column(k).copy() for k in ("surge_m_s", "yaw_rate_rad_s", "heading_rad")}
    for values in channels.values():
        values[:4] = np.nan
    estimate = OutputError().fit([record.with_channels(**channels)], model)
    assert max(relative_errors(estimate, model).values()) < 1e-4


def test_refusals(suite):
    model, records = suite("response-1")
    with pytest.raises(BadInput, match="max_iterations"):
        OutputError(0).fit(records, model)
    with pytest.raises(CannotFit, match="none of the columns"):
        record = records[0]
        OutputError().fit([Record(record.time_s, {"rudder_rad": record.rudder()}, "blind")], model)
