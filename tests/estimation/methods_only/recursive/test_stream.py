"""partial_fit: chunks of any length give the trajectory of the whole record."""

from itertools import pairwise

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve

METHODS = ("rls", "fw-rls", "mi-rls", "nmi-rls", "fci-ls")


def chunks(record, rng):
    """The record in pieces of 1 to 60 samples."""
    cuts = [0]
    while cuts[-1] < record.n:
        cuts.append(min(cuts[-1] + int(rng.integers(1, 60)), record.n))
    return [record.slice(a, b) for a, b in pairwise(cuts)]


def stream(method, records, model, rng, **options):
    estimate = None
    for record in records:
        for chunk in chunks(record, rng):
            estimate = method.partial_fit(chunk, model, **options) or estimate
    return estimate


def assert_same(online, batch):
    assert online.trajectory_time_s == pytest.approx(batch.trajectory_time_s, abs=1e-9)
    size = np.abs(batch.trajectory).max(axis=0)
    assert np.abs((online.trajectory - batch.trajectory)[20:] / size).max() < 1e-6
    assert online.coefficients == pytest.approx(batch.coefficients, rel=1e-7)
    assert online.covariance == pytest.approx(batch.covariance, rel=1e-4)
    assert online.n_iterations == batch.n_iterations


@pytest.mark.parametrize("scheme", ["forward", "midpoint"])
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("ship", ["response-1", "remus-kt", "kvlcc2-l7"])
def test_chunks_give_the_batch_trajectory(ship, name, scheme, rng):
    model = resolve(ship)
    records = [generate(Case(ship, text, "low", seed=3)) for text in ("zigzag:20/20", "zigzag:10/10")]
    records = [record.slice(0, 400) for record in records]
    batch = make(name, scheme=scheme, p0=1e4).fit(records, model)
    assert_same(stream(make(name, scheme=scheme, p0=1e4), records, model, rng, scale_with=records), batch)


@pytest.mark.parametrize("name", ["rls", "fw-rls", "mi-rls"])
def test_the_physical_prior_needs_no_scales(name, rng):
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20", "low", seed=3)).slice(0, 500)
    batch = make(name, prior="physical", p0=1e6, scheme="midpoint").fit([record], model)
    assert_same(stream(make(name, prior="physical", p0=1e6, scheme="midpoint"), [record], model, rng), batch)


def test_heading_alone_with_gaps(rng):
    """A yaw rate that is differenced from the heading, and gaps at the borders of chunks."""
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20", "low", seed=3)).slice(0, 500)
    heading = record.column("heading_rad").copy()
    heading[rng.choice(500, 25, replace=False)] = np.nan
    record = record.with_channels(heading_rad=heading, yaw_rate_rad_s=None)
    batch = make("rls", scheme="midpoint", prior="physical", p0=1e8).fit([record], model)
    online = make("rls", scheme="midpoint", prior="physical", p0=1e8)
    assert_same(stream(online, [record], model, rng), batch)


def test_heading_difference_scheme(rng):
    model = resolve("remus-kt")
    record = generate(Case("remus-kt", "zigzag:20/20"))
    options = {"scheme": "heading-difference", "prior": "physical", "p0": 1e6}
    assert_same(stream(make("rls", **options), [record], model, rng), make("rls", **options).fit([record], model))


def test_reset_and_other_models_start_again():
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20"))
    method = make("rls", scheme="midpoint")
    first = method.partial_fit(record, model)
    method.reset()
    again = method.partial_fit(record, model)
    assert first is not None and again is not None and np.array_equal(first.coefficients, again.coefficients)
    other = method.partial_fit(record, resolve("nomoto-1"))
    assert other is not None and len(other.coefficients) == 2
    assert method.fit([record], model).coefficients == pytest.approx(first.coefficients, rel=1e-9)


def test_too_few_samples_give_nothing_and_bad_ones_are_refused():
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20"))
    assert make("rls").partial_fit(record.slice(0, 5), model) is None
    with pytest.raises(CannotFit):
        make("rls").partial_fit(record.with_channels(yaw_rate_rad_s=None, heading_rad=None), model)
    with pytest.raises(BadInput, match="whole record"):
        make("rls", scheme="triple-integral").partial_fit(record, model)
    with pytest.raises(BadInput, match="online"):
        make("fci-ls", variant="as_printed").partial_fit(record, model)
