"""fci-ls: corrected and as printed (paper 002)."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.errors import FitFailed
from helmbench.models.model import resolve

from ..made_up.records import zigzag_5_10


def norm_of_largest_row(record, degrees=False):
    unit = np.rad2deg(1.0) if degrees else 1.0
    r, delta = unit * record.column("yaw_rate_rad_s"), unit * record.rudder()
    return float((r**2 + r**6 + delta**2).max())


def test_printed_prior_suppresses_the_cubic_term():
    """Reference p002_first_RLS_rad_gamma1e6: one pass, no P-type step, radians; alpha .27 instead of 258."""
    record = zigzag_5_10("response-1")
    found = make("fci-ls", variant="as_printed", beta=0.0, most=1).fit([record], resolve("response-1")).parameters
    expected = {"K": 0.20534099891002763, "T": 12.89526989545874, "alpha": 0.2704830888216314}
    assert found == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("degrees", "bound"), [(False, 253.0), (True, 0.075)])
def test_printed_form_diverges_beyond_the_usable_bound(degrees, bound):
    """beta 300 in radians and .08 in degrees diverge; below 2/|phi|^2 the estimate is poor but stays bounded."""
    record, model = zigzag_5_10("response-1"), resolve("response-1")
    assert 2.0 / norm_of_largest_row(record, degrees) == pytest.approx(bound, rel=0.02)
    options = {"variant": "as_printed", "degrees": degrees, "tolerance": 0.0, "most": 50}
    printed = make("fci-ls", beta=0.8 * bound, **options).fit([record], model)
    assert np.abs(printed.trajectory[:, 0] * 0.1).max() < 2.0
    with pytest.raises(FitFailed):
        make("fci-ls", beta=300.0 if not degrees else 0.08, **(options | {"most": 200})).fit([record], model)


def test_corrected_form_is_safe_at_any_beta():
    """beta is limited: exact where the equations are exact, bounded where they are not; as printed neither."""
    record, model = generate(Case("response-1", "zigzag:20/20@euler")), resolve("response-1")
    assert make("fci-ls", scheme="forward", beta=1e9, p0=1e12).fit([record], model).parameters == pytest.approx(
        model.parameters, rel=1e-3
    )
    with pytest.raises(FitFailed):
        make("fci-ls", beta=1e9, variant="as_printed").fit([record], model)
    coarse = make("fci-ls", beta=1e9).fit([zigzag_5_10("response-1")], model)
    assert np.isfinite(coarse.trajectory).all()


def test_repeats_are_weights():
    """With beta 0 and N repeats: as rls with the weight N, to 1e-10."""
    record, model = generate(Case("response-1", "zigzag:20/20", "low", seed=1)), resolve("response-1")
    repeated = make("fci-ls", beta=0.0, most=7, tolerance=0.0, p0=1e4).fit([record], model)
    weighted = make("fw-rls", mu=1.0, weight=7.0, p0=1e4).fit([record], model)
    assert repeated.coefficients == pytest.approx(weighted.coefficients, rel=1e-10)
    assert repeated.trajectory == pytest.approx(weighted.trajectory, rel=1e-8, abs=1e-8)
    assert repeated.covariance == pytest.approx(weighted.covariance, rel=1e-6)


@pytest.mark.parametrize("name", ["response-1", "response-2"])
def test_printed_coordinates(name):
    """One pass with a weak prior in the paper's coordinates is least squares on its difference equation."""
    record, model = zigzag_5_10(name), resolve(name)
    for degrees in (False, True):
        printed = make("fci-ls", variant="as_printed", beta=0.0, most=1, p0=1e16, degrees=degrees).fit([record], model)
        assert printed.parameters == pytest.approx(make("ls-forward").fit([record], model).parameters, rel=1e-3)


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "cargo", "patrol", "remus-kt"])
def test_corrected_fci_becomes_least_squares(vessel, suite):
    """The effect of the first rows fades: the parameter error is that of ls to a tenth."""
    model, records = suite(vessel, "low")
    errors = {}
    for name in ("ls", "fci-ls"):
        found = make(name, scheme="forward").fit(records, model).parameters
        errors[name] = np.median([abs(found[k] / v - 1.0) for k, v in model.parameters.items()])
    assert errors["fci-ls"] < 1.1 * errors["ls"]
