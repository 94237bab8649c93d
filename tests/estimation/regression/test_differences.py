"""Difference schemes: exact where they should be, of the right order, and correct about gaps."""

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.estimation.regression.least_squares import fit_by_scheme
from helmbench.estimation.regression.schemes import regression_samples
from helmbench.models.model import resolve

from ...made_up.records import driven


def smooth_rudder(dt, duration=60.0):
    time = np.arange(0.0, duration, dt)
    return 0.2 * np.sin(0.7 * time) * (1.0 - np.exp(-time)) + 0.1 * np.sin(0.23 * time) ** 2


def worst_error(model, record, scheme):
    found = fit_by_scheme([record], model, scheme).coefficients
    return np.abs(found / model.coefficients - 1.0).max()


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "remus-kt", "cargo", "remus"])
def test_midpoint_is_of_second_order(vessel):
    model = resolve(vessel)
    errors = [worst_error(model, driven(model, smooth_rudder(dt, 6.0 if vessel == "remus" else 60.0), dt), "midpoint")
              for dt in (0.05, 0.025)]  # fmt: skip
    assert errors[1] < 0.02
    assert 3.4 < errors[0] / errors[1] < 4.6


@pytest.mark.parametrize("vessel", ["response-1", "remus-kt"])
def test_forward_is_of_first_order(vessel):
    model = resolve(vessel)
    errors = [worst_error(model, driven(model, smooth_rudder(dt), dt), "forward") for dt in (0.02, 0.01)]
    assert 1.8 < errors[0] / errors[1] < 2.2


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "kvlcc2-l7", "remus-kt"])
def test_forward_inverts_explicit_euler(vessel):
    model = resolve(vessel)
    record = driven(model, smooth_rudder(0.1, 120.0), 0.1, integrator="euler")
    (part,) = regression_samples([record], model, "forward")
    for y, phi in part.blocks(model):
        assert np.abs(y - phi @ model.coefficients).max() < 1e-11 * np.abs(y).max() + 1e-13


def test_yaw_rate_may_be_missing():
    model = resolve("response-1")
    record = driven(model, smooth_rudder(0.1), 0.1, integrator="euler")
    without = record.with_channels(yaw_rate_rad_s=None)
    assert np.allclose(fit_by_scheme([without], model, "forward").coefficients, model.coefficients, rtol=1e-8)
    record = driven(model, smooth_rudder(0.05), 0.05)
    assert worst_error(model, record.with_channels(yaw_rate_rad_s=None), "midpoint") < 1e-2


def test_wrapped_heading_is_unwrapped():
    model = resolve("remus-kt")
    record = driven(model, np.full(300, 0.3), 0.1, integrator="euler")
    wrapped = np.mod(record.column("heading_rad") + np.pi, 2.0 * np.pi) - np.pi
    assert np.abs(np.diff(wrapped)).max() > 6.0
    turned = record.with_channels(yaw_rate_rad_s=None, heading_rad=wrapped)
    (part,) = regression_samples([turned], model, "forward")
    assert np.abs(part.states[:, 1]).max() < 1.0


@pytest.mark.parametrize(("scheme", "lost"), [("forward", {"r": 2, "delta": 2}), ("midpoint", {"r": 2, "delta": 2})])
def test_a_gap_removes_the_rows_it_touches(scheme, lost):
    model = resolve("response-1")
    record = driven(model, smooth_rudder(0.1), 0.1)
    whole = len(regression_samples([record], model, scheme)[0].time_s)
    for channel, symbol in (("yaw_rate_rad_s", "r"), ("rudder_rad", "delta")):
        values = record.column(channel).copy()
        values[50] = np.nan
        rows = len(regression_samples([record.with_channels(**{channel: values})], model, scheme)[0].time_s)
        expected = 1 if (scheme, symbol) == ("forward", "delta") else lost[symbol]
        assert rows == whole - expected


def test_rows_left_out_in_time_are_a_gap():
    model = resolve("response-1")
    record = driven(model, smooth_rudder(0.1), 0.1, integrator="euler")
    kept = np.r_[0:200, 260:600]
    cut = Record(record.time_s[kept], {k: v[kept] for k, v in record.channels.items()}, "cut")
    assert np.allclose(fit_by_scheme([cut], model, "forward").coefficients, model.coefficients, rtol=1e-9)


@pytest.mark.parametrize("vessel", ["response-1", "remus-kt"])
def test_uneven_steps(vessel, rng):
    model = resolve(vessel)
    fine = driven(model, smooth_rudder(0.005), 0.005)
    kept = np.cumsum(rng.integers(4, 13, 1200))
    kept = kept[kept < fine.n]
    uneven = Record(fine.time_s[kept], {k: v[kept] for k, v in fine.channels.items()}, "uneven")
    assert worst_error(model, uneven, "midpoint") < 0.03
