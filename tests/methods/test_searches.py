"""CMA-ES finds the minimum of output error, and the ensemble its spread."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve


@pytest.fixture(scope="module")
def record():
    return generate(Case("response-1", "zigzag:20/20", "medium", seed=1, dt_s=0.5))


@pytest.fixture(scope="module")
def reference(record):
    return make("output-error").fit([record], resolve("nomoto-1-cubic"))


def test_the_evolution_strategy_ends_where_the_derivatives_do(record, reference):
    found = make("cma-es").fit([record], resolve("nomoto-1-cubic"))
    assert found.extra["cost"] == pytest.approx(reference.extra["cost"], abs=1e-3)
    assert found.coefficients == pytest.approx(reference.coefficients, rel=1e-3)
    assert found.stderr["T"] == pytest.approx(reference.stderr["T"], rel=1e-2)


def test_a_prior_is_where_it_starts_and_a_bound_where_it_ends(record):
    """With so few runs it has hardly left the prior's mean; T of this ship is 13.5 s."""
    prior = {"T": (20.0, 0.1), "K": (0.2, 0.01), "alpha": (250.0, 10.0)}
    near = make("cma-es,evaluations=10").set_params(prior=prior).fit([record], resolve("nomoto-1-cubic"))
    assert near.parameters["T"] == pytest.approx(20.0, abs=0.5)
    bounded = make("cma-es").set_params(bounds={"T": (15.0, 30.0)}).fit([record], resolve("nomoto-1-cubic"))
    assert bounded.parameters["T"] == pytest.approx(15.0, rel=1e-3)


@pytest.mark.nightly
def test_the_ensemble_has_the_mean_and_the_spread_of_the_likelihood(record, reference):
    """300 independent draws or so: the mean within .4 standard errors, the spread within 30 %, each five times its own
    deviation and more."""
    found = make("mcmc,steps=1000").fit([record], resolve("nomoto-1-cubic"))
    for name, sd in reference.stderr.items():
        assert abs(found.parameters[name] - reference.parameters[name]) < 0.4 * sd
        assert found.stderr[name] == pytest.approx(sd, rel=0.3)
        low, middle, high = found.extra["quantiles"][name]
        assert low < middle < high and high - low == pytest.approx(3.92 * sd, rel=0.4)
    assert 0.2 < found.extra["acceptance"] < 0.8
    assert not found.converged and "fewer steps than 50 autocorrelation times" in found.message


def test_a_narrow_prior_takes_the_place_of_the_records(record):
    prior = {"T": (14.0, 1e-4)}
    found = make("mcmc,steps=200").set_params(prior=prior).fit([record], resolve("nomoto-1-cubic"))
    assert found.parameters["T"] == pytest.approx(14.0, abs=1e-3)
    assert found.stderr["T"] == pytest.approx(1e-4, rel=0.5)


def test_what_the_records_leave_open_has_no_posterior():
    straight = generate(Case("response-1", "zigzag:20/20", "none", seed=1, duration_s=60.0))
    straight = straight.with_channels(rudder_rad=np.zeros(straight.n), rudder_command_rad=None)
    with pytest.raises(CannotFit):
        make("mcmc,steps=20").fit([straight], resolve("nomoto-1-cubic"))
    for text in ("mcmc,steps=3", "mcmc,walkers=1", "cma-es,evaluations=0", "cma-es,seed=-2"):
        with pytest.raises(BadInput):
            make(text).fit([straight], resolve("nomoto-1-cubic"))
