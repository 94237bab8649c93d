"""fci-ls, mi-rls and nmi-rls: what they are worth, and what their printed forms do (papers 002 and 004)."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.base import FitFailed
from helmbench.methods.registry import make
from helmbench.methods.rls import Progress, Scales
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

from .conftest import zigzag_5_10

ONLINE = ("mi-rls", "nmi-rls", "fci-ls")


def norm_of_largest_row(record, degrees=False):
    unit = np.rad2deg(1.0) if degrees else 1.0
    r, delta = unit * record.column("yaw_rate_rad_s"), unit * record.rudder()
    return float((r**2 + r**6 + delta**2).max())


# ---- paper 002


def test_printed_prior_kills_the_cubic_term():
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
    """Held to the bound: right where the equations are, bounded where they are not; as printed neither."""
    record, model = generate(Case("response-1", "zigzag:20/20@euler")), resolve("response-1")
    assert make("fci-ls", beta=1e9, p0=1e12).fit([record], model).parameters == pytest.approx(
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
        assert printed.parameters == pytest.approx(make("ls").fit([record], model).parameters, rel=1e-3)


# ---- paper 004


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


def test_windows_reach_over_blocks_and_records():
    """Two records in one go are the same as their samples fed in pieces of any size."""
    model, method = resolve("response-1"), make("mi-rls", length=5, prior="physical")
    rng = np.random.default_rng(0)
    y, phi = rng.normal(size=(60, 1)), rng.normal(size=(60, 1, 3))
    scales = Scales(np.ones(1), np.ones(3), 60)
    whole = Progress(method.setting(3), scales).add(y, phi)
    pieces = Progress(method.setting(3), scales)
    cuts = [slice(0, 1), slice(1, 3), slice(3, 20), slice(20, 60)]
    assert np.array_equal(np.concatenate([pieces.add(y[c], phi[c]) for c in cuts]), whole)
    assert model.coordinates == ("a", "b", "c")


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


# ---- all


@pytest.mark.parametrize("text", ONLINE)
def test_exact_on_difference_data(text):
    """Records made by explicit Euler: only the prior is left."""
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20@euler"))
    assert make(text, p0=1e12).fit([record], model).parameters == pytest.approx(model.parameters, rel=1e-3)


OPTIONS = [
    "mi-rls,length=0",
    "mi-rls,length=2.5",
    "nmi-rls,omega=0",
    "fci-ls,beta=-1",
    "fci-ls,most=0",
    "fci-ls,tolerance=-1",
]


@pytest.mark.parametrize("text", OPTIONS)
def test_impossible_options_are_refused(text):
    with pytest.raises(BadInput):
        make(text)


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "cargo", "patrol", "remus-kt"])
def test_corrected_fci_goes_over_into_least_squares(vessel, suite):
    """What the first rows gain does not stay in the estimate: the parameter error is that of ls to a tenth."""
    model, records = suite(vessel, "low")
    errors = {}
    for name in ("ls", "fci-ls"):
        found = make(name).fit(records, model).parameters
        errors[name] = np.median([abs(found[k] / v - 1.0) for k, v in model.parameters.items()])
    assert errors["fci-ls"] < 1.1 * errors["ls"]
