"""Support vector regression of a noisy heading, and its tuners."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.ls_svr import LsSvr, RwLsSvr, TunedConstant
from helmbench.models.model import resolve

SINES = "heading:10deg/0.0105rad_s+6deg/0.031rad_s+4deg/0.083rad_s"


def percent(model, coefficients):
    return 100.0 * (model.to_parameters(coefficients) / model.to_parameters(model.coefficients) - 1.0)


def heading_record(noise: float, rng) -> object:
    record = generate(Case("cargo", SINES, duration_s=6000.0, dt_s=0.2)).with_channels(yaw_rate_rad_s=None)
    return record.with_channels(heading_rad=record.column("heading_rad") + noise * rng.normal(size=record.n))


@pytest.mark.parametrize("method", [LsSvr, RwLsSvr])
def test_methods_identify_cargo_from_a_noisy_heading(method, rng):
    estimate = method().fit([heading_record(3e-4, rng)], resolve("cargo"))
    error = percent(resolve("cargo"), estimate.coefficients)
    print(error, estimate.extra)
    assert np.abs(error).max() < 8.0 and abs(error[0]) < 0.5 and abs(error[3]) < 0.05
    assert estimate.extra["evaluations"] == 25


def test_any_tuner_can_be_passed(rng):
    calls = []

    def tuner(objective, low, high):
        calls.append((low, high, objective(1.0), objective(1e6)))
        return TunedConstant(1e6, calls[0][3], 2)

    estimate = LsSvr(tuner=tuner).fit([heading_record(1e-4, rng)], resolve("cargo"))
    assert calls[0][:2] == (1e-2, 1e10) and calls[0][3] <= calls[0][2]
    assert (estimate.extra["C"], estimate.extra["evaluations"]) == (1e6, 2)


def test_printed_variant_regularises_in_si_units(rng):
    """With C = 1e8 in SI units the ridge term alone biases T2 by percents; standardised it does not."""
    record = heading_record(0.0, rng)
    printed = LsSvr(C=1e8, scheme="midpoint", variant="as_printed").fit([record], resolve("cargo"))
    corrected = LsSvr(C=1e8, scheme="midpoint").fit([record], resolve("cargo"))
    assert abs(percent(resolve("cargo"), printed.coefficients)[1]) > 3.0
    assert np.abs(percent(resolve("cargo"), corrected.coefficients)).max() < 1.0
