"""Forgetting and weighting, corrected and as printed."""

import numpy as np
import pytest

from helmbench.methods.rls import FwRls, Rls
from helmbench.models.model import resolve

from ..made_up.records import driven, relative_errors
from ..simulators import paper_000

PROTOCOL = {"p0": 1e10, "theta0": 1e-10, "prior": "physical", "scheme": "heading-difference"}


FW = {"mu": 0.999, "weight": 20.0}


def fit(method):
    return method.fit([paper_000.difference_record()], resolve("kt"))


@pytest.mark.parametrize(
    ("method", "expected", "tolerance"),
    [
        (FwRls(**FW, **PROTOCOL), paper_000.FW_RLS, 1e-12),
        (FwRls(**FW, **PROTOCOL, variant="as_printed"), paper_000.AS_PRINTED, 1e-8),
    ],
    ids=["corrected", "eq 22 as printed"],
)
def test_protocol_of_paper_000(method, expected, tolerance):
    assert paper_000.in_paper_order(fit(method).parameters) == pytest.approx(expected, rel=tolerance)


def test_eq_22_as_printed_is_off_by_a_tenth():
    found = paper_000.in_paper_order(fit(FwRls(**FW, **PROTOCOL, variant="as_printed")).parameters)
    errors = found / [paper_000.T2, paper_000.T1, paper_000.K, paper_000.T3] - 1.0
    assert np.all((errors > 0.09) & (errors < 0.115)), errors


def test_settling_time_of_paper_000():
    """Slowest time into the 5 % band: 0.9 s with forgetting and weighting."""
    truth = np.array([paper_000.T1, paper_000.T2, paper_000.K, paper_000.T3])
    estimate = fit(FwRls(**FW, **PROTOCOL))
    assert estimate.trajectory is not None and estimate.trajectory_time_s is not None
    outside = (np.abs(estimate.trajectory / truth - 1.0) > 0.05).any(axis=1)
    settled = estimate.trajectory_time_s[np.flatnonzero(outside)[-1] + 1] + paper_000.STEP_S
    assert settled == pytest.approx(0.9, abs=1e-6)


def test_a_constant_weight_is_a_weaker_prior():
    """The published weight L acts only as p0 -> L p0."""
    weighted = fit(FwRls(mu=1.0, weight=20.0, **PROTOCOL))
    wider = fit(Rls(**(PROTOCOL | {"p0": 20.0 * PROTOCOL["p0"]})))
    assert weighted.trajectory == pytest.approx(wider.trajectory, rel=1e-9, abs=1e-12)
    assert weighted.covariance == pytest.approx(wider.covariance, rel=1e-6)


def test_forgetting_follows_a_change():
    """A vessel whose gain changes half way: with forgetting the estimate ends at the gain of the second half."""
    before = resolve("response-1")
    after = before.with_coefficients(before.coefficients * [1.0, 1.5, 1.0])
    rudder = 0.3 * np.sin(0.1 * np.arange(3000))
    records = [driven(m, rudder, 0.1, integrator="euler") for m in (before, after)]
    methods = Rls(scheme="forward"), FwRls(mu=0.99, scheme="forward")
    remembering, forgetting = (method.fit(records, before) for method in methods)
    assert relative_errors(forgetting, after)["K"] < 1e-4
    assert relative_errors(remembering, after)["K"] > 0.05
