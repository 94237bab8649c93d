"""Recursive least squares: paper 000's protocol, the role of P0, weight and forgetting, and the trajectory."""

import numpy as np
import pytest

from helmbench.methods.base import CannotFit
from helmbench.methods.fw_rls import FwRls
from helmbench.methods.ls import Ls
from helmbench.methods.rls import Rls
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

from . import paper000
from .conftest import driven, relative_errors

PROTOCOL = {"p0": 1e10, "theta0": 1e-10, "prior": "physical", "scheme": "heading-difference"}
FW = {"mu": 0.999, "weight": 20.0}


def fit(method):
    return method.fit([paper000.difference_record()], resolve("kt"))


@pytest.mark.parametrize(
    ("method", "expected", "tolerance"),
    [
        (Rls(**PROTOCOL), paper000.RLS, 1e-12),
        (FwRls(**FW, **PROTOCOL), paper000.FW_RLS, 1e-12),
        (FwRls(**FW, **PROTOCOL, variant="as_printed"), paper000.AS_PRINTED, 1e-8),
    ],
    ids=["rls", "fw-rls", "eq 22 as printed"],
)
def test_protocol_of_paper_000(method, expected, tolerance):
    assert paper000.in_paper_order(fit(method).parameters) == pytest.approx(expected, rel=tolerance)


def test_eq_22_as_printed_is_off_by_a_tenth():
    found = paper000.in_paper_order(fit(FwRls(**FW, **PROTOCOL, variant="as_printed")).parameters)
    errors = found / [paper000.T2, paper000.T1, paper000.K, paper000.T3] - 1.0
    assert np.all((errors > 0.09) & (errors < 0.115)), errors


def test_settling_times_of_paper_000():
    """Slowest time into the 5 % band: 1.8 s without, 0.9 s with forgetting and weighting."""
    truth = np.array([paper000.T1, paper000.T2, paper000.K, paper000.T3])
    for method, expected in ((Rls(**PROTOCOL), 1.8), (FwRls(**FW, **PROTOCOL), 0.9)):
        estimate = fit(method)
        assert estimate.trajectory is not None and estimate.trajectory_time_s is not None
        outside = (np.abs(estimate.trajectory / truth - 1.0) > 0.05).any(axis=1)
        settled = estimate.trajectory_time_s[np.flatnonzero(outside)[-1] + 1] + paper000.STEP_S
        assert settled == pytest.approx(expected, abs=1e-6)


def test_a_constant_weight_is_a_weaker_prior():
    """The published weight L is p0 -> L p0 and nothing else."""
    weighted = fit(FwRls(mu=1.0, weight=20.0, **PROTOCOL))
    wider = fit(Rls(**(PROTOCOL | {"p0": 20.0 * PROTOCOL["p0"]})))
    assert weighted.trajectory == pytest.approx(wider.trajectory, rel=1e-9, abs=1e-12)
    assert weighted.covariance == pytest.approx(wider.covariance, rel=1e-6)


@pytest.mark.parametrize("vessel", ["response-2", "kvlcc2-l7"])
def test_with_a_wide_prior_it_is_least_squares(suite, vessel):
    model, records = suite(vessel, noise="low")
    recursive, batch = Rls(p0=1e12).fit(records, model), Ls().fit(records, model)
    gap = np.abs(recursive.coefficients - batch.coefficients) / np.sqrt(np.diag(batch.covariance))
    assert gap.max() < (1e-3 if vessel == "response-2" else 1.0)  # 3-DOF: batch weighs its equations once more
    ratio = np.sqrt(np.diag(recursive.covariance) / np.diag(batch.covariance))
    assert np.all((ratio > 0.5) & (ratio < 2.0))


@pytest.mark.parametrize("variant", ["corrected", "as_printed"])
def test_the_compiled_recursion_is_the_written_one(rng, variant):
    """g = P h/(mu/L + h'P h) and eq 22, literally, in NumPy."""
    from helmbench.methods import _rls_kernels

    n, d, mu, weight = 60, 4, 0.97, 3.0
    h, truth = rng.normal(size=(n, d)), rng.normal(size=d)
    y = h @ truth + 0.01 * rng.normal(size=n)
    theta, p, path = np.zeros(d), 100.0 * np.eye(d), []
    for row, left in zip(h, y, strict=True):
        if variant == "corrected":
            gain = p @ row / (mu / weight + row @ p @ row)
            theta = theta + gain * (left - row @ theta)
            p = (p - np.outer(gain, row @ p)) / mu
        else:
            p = p / mu - np.outer(p @ row, row @ p) / (mu**2 / weight + mu * row @ p @ row)
            theta = theta / mu + weight * (left - row @ theta / mu) * (p @ row)
        path.append(theta)
    start, found = np.zeros(d), np.empty((n, d))
    forget = np.full(n, mu)
    if variant == "corrected":
        lower, spread = np.eye(d), np.full(d, 100.0)
        _rls_kernels.recursive_ls(y, h, forget, weight, start, lower, spread, found)
        # the kernel forgets before a row and the equations after it: the same but for the first and the last
        again, p_first = _forgetting_first(y, h, mu, weight, d)
        assert found == pytest.approx(again, rel=1e-8, abs=1e-10)
        assert (lower.T * spread) @ lower == pytest.approx(p_first, rel=1e-8)
    else:
        _rls_kernels.recursive_ls_as_printed(y, h, forget, weight, start, 100.0 * np.eye(d), found)
        assert found == pytest.approx(np.array(path), rel=1e-8, abs=1e-10)


def _forgetting_first(y, h, mu, weight, d):
    theta, p, path = np.zeros(d), 100.0 * np.eye(d), []
    for row, left in zip(h, y, strict=True):
        p = p / mu
        gain = p @ row / (1.0 / weight + row @ p @ row)
        theta = theta + gain * (left - row @ theta)
        p = p - np.outer(gain, row @ p)
        path.append(theta)
    return np.array(path), p


def test_p_stays_positive_where_the_plain_recursion_loses_it(suite):
    """Mariner's sixty collinear coefficients from P0 = 1e10."""
    model, records = suite("mariner-model")
    covariance = Rls().fit(records, model).covariance
    assert covariance is not None
    scale = np.sqrt(np.diag(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > -1e-9


def test_records_follow_each_other(suite):
    """P and the coefficients are carried over: the second record moves the first one's estimate."""
    model, records = suite("response-1", noise="medium")
    first, both = Rls().fit(records[:1], model), Rls().fit(records, model)
    n = len(first.trajectory)
    assert both.trajectory[n // 2 : n] == pytest.approx(first.trajectory[n // 2 :], rel=1e-3)
    assert both.trajectory[n] == pytest.approx(first.trajectory[-1], rel=0.05)
    assert np.all(np.diff(both.trajectory_time_s) >= 0.0)
    assert both.trajectory_time_s[-1] == pytest.approx(sum(r.time_s[-1] for r in records), abs=1.0)


def test_forgetting_follows_a_change():
    """A vessel whose gain changes half way: with forgetting the estimate ends at the second half's."""
    before = resolve("response-1")
    after = before.with_coefficients(before.coefficients * [1.0, 1.5, 1.0])
    rudder = 0.3 * np.sin(0.1 * np.arange(3000))
    records = [driven(m, rudder, 0.1, integrator="euler") for m in (before, after)]
    remembering, forgetting = Rls().fit(records, before), FwRls(mu=0.99).fit(records, before)
    assert relative_errors(forgetting, after)["K"] < 1e-4
    assert relative_errors(remembering, after)["K"] > 0.05


def test_long_trajectories_are_thinned(monkeypatch, suite):
    from helmbench.methods import rls

    model, records = suite("response-1", noise="low")
    whole = Rls().fit(records, model)
    monkeypatch.setattr(rls, "LONGEST_PATH", 3 * 500)
    thin = Rls().fit(records, model)
    assert thin.trajectory.shape == (len(thin.trajectory_time_s), 3)
    assert len(thin.trajectory) <= 501
    assert np.array_equal(thin.trajectory[-1], whole.trajectory[-1])
    assert np.array_equal(thin.coefficients, whole.coefficients)


@pytest.mark.parametrize("options", [{"mu": 0.0}, {"mu": 1.1}, {"weight": 0.0}, {"p0": -1.0}, {"prior": "mine"}])
def test_impossible_options(options):
    with pytest.raises(BadInput):
        fit(FwRls(**options))


def test_wrong_number_of_starting_values():
    with pytest.raises(CannotFit, match="theta0 has 2 numbers for 4 coefficients"):
        fit(Rls(theta0=[0.0, 1.0], scheme="heading-difference"))
