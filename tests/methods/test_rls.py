"""Recursive least squares: paper 000's protocol, the role of P0, and the trajectory."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.ls import Ls
from helmbench.methods.registry import make
from helmbench.methods.rls import FwRls, Rls
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve

from ..made_up.records import driven, relative_errors
from ..simulators import paper_000

FW = {"mu": 0.999, "weight": 20.0}
PROTOCOL = {"p0": 1e10, "theta0": 1e-10, "prior": "physical", "scheme": "heading-difference"}


def fit(method):
    return method.fit([paper_000.difference_record()], resolve("kt"))


@pytest.mark.parametrize(
    ("method", "expected", "tolerance"),
    [
        (Rls(**PROTOCOL), paper_000.RLS, 1e-12),
        (FwRls(**FW, **PROTOCOL), paper_000.FW_RLS, 1e-12),
        (FwRls(**FW, **PROTOCOL, variant="as_printed"), paper_000.AS_PRINTED, 1e-8),
    ],
    ids=["rls", "fw-rls", "eq 22 as printed"],
)
def test_protocol_of_paper_000(method, expected, tolerance):
    assert paper_000.in_paper_order(fit(method).parameters) == pytest.approx(expected, rel=tolerance)


def test_eq_22_as_printed_is_off_by_a_tenth():
    found = paper_000.in_paper_order(fit(FwRls(**FW, **PROTOCOL, variant="as_printed")).parameters)
    errors = found / [paper_000.T2, paper_000.T1, paper_000.K, paper_000.T3] - 1.0
    assert np.all((errors > 0.09) & (errors < 0.115)), errors


@pytest.mark.parametrize(("method", "time_s"), [(Rls(**PROTOCOL), 1.8), (FwRls(**FW, **PROTOCOL), 0.9)])
def test_settling_time_of_paper_000(method, time_s):
    """Slowest time into the 5 % band, without and with forgetting and weighting."""
    truth = np.array([paper_000.T1, paper_000.T2, paper_000.K, paper_000.T3])
    estimate = fit(method)
    assert estimate.trajectory is not None and estimate.trajectory_time_s is not None
    outside = (np.abs(estimate.trajectory / truth - 1.0) > 0.05).any(axis=1)
    settled = estimate.trajectory_time_s[np.flatnonzero(outside)[-1] + 1] + paper_000.STEP_S
    assert settled == pytest.approx(time_s, abs=1e-6)


@pytest.mark.parametrize("vessel", ["response-2", "kvlcc2-l7"])
def test_with_a_wide_prior_it_is_least_squares(suite, vessel):
    model, records = suite(vessel, noise="low")
    recursive, batch = Rls(p0=1e12, scheme="midpoint").fit(records, model), Ls("midpoint").fit(records, model)
    gap = np.abs(recursive.coefficients - batch.coefficients) / np.sqrt(np.diag(batch.covariance))
    assert gap.max() < (1e-3 if vessel == "response-2" else 1.0)  # 3-DOF: batch weighs its equations once more
    ratio = np.sqrt(np.diag(recursive.covariance) / np.diag(batch.covariance))
    assert np.all((ratio > 0.5) & (ratio < 2.0))


def test_p_stays_positive_definite(suite):
    """Mariner's sixty collinear coefficients from P0 = 1e10."""
    model, records = suite("mariner-model")
    covariance = Rls().fit(records, model).covariance
    assert covariance is not None
    scale = np.sqrt(np.diag(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > -1e-9


def test_records_follow_each_other(suite):
    """P and the coefficients are carried over: the second record changes the estimate of the first."""
    model, records = suite("response-1", noise="medium")
    first, both = (Rls(scheme="forward").fit(part, model) for part in (records[:1], records))
    n = len(first.trajectory)
    assert both.trajectory[n // 2 : n] == pytest.approx(first.trajectory[n // 2 :], rel=1e-3)
    assert both.trajectory[n] == pytest.approx(first.trajectory[-1], rel=0.05)
    assert np.all(np.diff(both.trajectory_time_s) >= 0.0)
    assert both.trajectory_time_s[-1] == pytest.approx(sum(r.time_s[-1] for r in records), abs=1.0)


def test_wrong_number_of_starting_values():
    with pytest.raises(CannotFit, match="theta0 has 2 numbers for 4 coefficients"):
        fit(Rls(theta0=[0.0, 1.0], scheme="heading-difference"))


@pytest.mark.parametrize("options", [{"p0": -1.0}, {"prior": "mine"}])
def test_impossible_options(options):
    with pytest.raises(BadInput):
        fit(Rls(**options))


@pytest.mark.parametrize("name", ["rls", "fw-rls", "mi-rls", "nmi-rls", "fci-ls"])
@pytest.mark.parametrize(("vessel", "scheme"), [("response-1", "midpoint"), ("response-2", "forward")])
def test_recursions_choose_differences_and_printed_forms_have_the_papers(name, vessel, scheme):
    """Median error of rls in the suite quick: .069, with forward differences alone .10, with central ones .29."""
    record, model = generate(Case(vessel, "zigzag:20/20", "low", seed=1)), resolve(vessel)
    plain, stated = (make(text).fit([record], model) for text in (name, f"{name},scheme={scheme}"))
    assert plain.extra["scheme"] == scheme and np.array_equal(plain.coefficients, stated.coefficients)
    if name == "fw-rls":
        assert make("fw-rls,variant=as_printed").fit([record], model).extra["scheme"] == "forward"


# ---- fw-rls: forgetting and weighting.


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


# ---- mi-rls: a weaker prior (paper 004).


@pytest.mark.parametrize("name", ["response-1", "kvlcc2-l7"])
def test_multi_innovation_is_a_weaker_prior(name):
    """mi-rls (l 10, P0 1e6) is rls (P0 1e7) to a few per cent, and with l = 1 it is rls."""
    model = resolve(name)
    record = generate(Case(name, "zigzag:20/20", "low", seed=2))
    plain, weaker = (make("rls", p0=p0).fit([record], model) for p0 in (1e6, 1e7))
    assert make("mi-rls", length=1, p0=1e6).fit([record], model).coefficients == pytest.approx(
        plain.coefficients, rel=1e-6
    )
    multi = make("mi-rls", length=10, p0=1e6).fit([record], model)
    away = np.abs(multi.coefficients - weaker.coefficients) / np.sqrt(np.diag(weaker.covariance))
    assert np.median(away) < 0.1


# ---- nmi-rls: the sine of the innovations, corrected and as printed (paper 004).


def test_sine_of_small_innovations_is_linear():
    """At omega 1 nmi-rls and mi-rls agree (published as a difference): noise-free 3-DOF records."""
    model, record = resolve("kvlcc2-l7"), generate(Case("kvlcc2-l7", "zigzag:20/20"))
    linear = make("mi-rls", p0=1e6).fit([record], model).coefficients
    for omega, tolerance in ((1.0, 2e-2), (1e-3, 1e-6)):
        sine = make("nmi-rls", omega=omega).fit([record], model).coefficients
        assert np.median(np.abs(sine / linear - 1.0)) < tolerance


def test_nmi_with_large_omega_fails_in_noise():
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20", "low", seed=2))
    error = {}
    for omega in (0.1, 30.0):
        found = make("nmi-rls", omega=omega).fit([record], model).parameters
        error[omega] = abs(found["T"] / model.parameters["T"] - 1.0)
    assert error[0.1] < 0.1 and error[30.0] > 3.0 * error[0.1]


@pytest.mark.parametrize("name", ["response-1", "kvlcc2-l7"])
def test_nmi_as_printed_diverges(name):
    with pytest.raises(FitFailed):
        make("nmi-rls", variant="as_printed").fit([generate(Case(name, "zigzag:20/20"))], resolve(name))


@pytest.mark.parametrize("name", ["rls", "mi-rls", "nmi-rls"])
def test_a_whole_number_as_prior_variance_is_a_number(name):
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20", "low", seed=3))
    whole, real = (make(name, p0=p0).fit([record], model).coefficients for p0 in (13572, 13572.0))
    assert np.array_equal(whole, real)
