"""Recursive least squares: paper 000's protocol, the role of P0, and the trajectory."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.ls import Ls
from helmbench.methods.registry import make
from helmbench.methods.rls import Rls
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve

from ..simulators import paper_000

PROTOCOL = {"p0": 1e10, "theta0": 1e-10, "prior": "physical", "scheme": "heading-difference"}


def fit(method):
    return method.fit([paper_000.difference_record()], resolve("kt"))


def test_protocol_of_paper_000():
    assert paper_000.in_paper_order(fit(Rls(**PROTOCOL)).parameters) == pytest.approx(paper_000.RLS, rel=1e-12)


def test_settling_time_of_paper_000():
    """Slowest time into the 5 % band: 1.8 s without forgetting and weighting."""
    truth = np.array([paper_000.T1, paper_000.T2, paper_000.K, paper_000.T3])
    estimate = fit(Rls(**PROTOCOL))
    assert estimate.trajectory is not None and estimate.trajectory_time_s is not None
    outside = (np.abs(estimate.trajectory / truth - 1.0) > 0.05).any(axis=1)
    settled = estimate.trajectory_time_s[np.flatnonzero(outside)[-1] + 1] + paper_000.STEP_S
    assert settled == pytest.approx(1.8, abs=1e-6)


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
    method = make(name)
    if "as_printed" in method.variants:
        method.set_params(variant="as_printed")
        assert method._usual_scheme([record], model) == "forward"
