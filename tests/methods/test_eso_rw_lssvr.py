"""Paper 003's pipeline of observer and support vector regression."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.eso_rw_lssvr import EsoRwLssvr
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

from ..made_up.records import OF_PAPER_003, percent


def record_of(name, dt=0.1):
    ship, text, duration = OF_PAPER_003[name]
    return generate(Case(ship, text, duration_s=duration, dt_s=dt))


def test_without_noise_only_the_lag_is_left():
    record, model = record_of("cargo-S3"), resolve("cargo")
    lagging = percent(model, EsoRwLssvr(omega0=20.0, aligned=False).fit([record], model).coefficients)
    aligned = percent(model, EsoRwLssvr(omega0=0.5, C=1e10).fit([record], model).coefficients)
    assert abs(lagging[0]) < 1.0 and abs(lagging[3]) < 0.2 and 1.0 < np.abs(lagging).max() < 15.0
    assert np.abs(aligned).max() < 0.1


def test_noise_needs_one_lag_and_slow_poles(rng):
    """Noise of 1e-4 rad: aligned and with the poles chosen by the records all four parameters are identified."""
    record, model = record_of("cargo-S3"), resolve("cargo")
    noisy = record.with_channels(heading_rad=record.column("heading_rad") + 1e-4 * rng.normal(size=record.n))
    chosen = EsoRwLssvr().fit([noisy], model)
    others = [EsoRwLssvr(aligned=False), EsoRwLssvr(omega0=9.0)]
    good, lagging, fast = (percent(model, e.coefficients) for e in (chosen, *(m.fit([noisy], model) for m in others)))
    print(good, lagging, fast, chosen.extra)
    assert chosen.extra["omega0_rad_s"] < 1.0
    assert np.abs(good).max() < 3.0
    assert not np.abs(lagging).max() < 20.0 and not np.abs(fast).max() < 20.0


@pytest.mark.nightly
def test_what_the_paper_proposes_lags_and_is_tuned_by_its_colony():
    """Without noise: the states' lag is that of `aligned=False`, and C is as good as by the grid or better."""
    record, model = record_of("cargo-S3", dt=0.5), resolve("cargo")
    options = {"omega0": 5.0}
    proposed = EsoRwLssvr(variant="proposed", **options).fit([record], model)
    plain = EsoRwLssvr(aligned=False, **options).fit([record], model)
    assert (proposed.extra["evaluations"], plain.extra["evaluations"]) == (1830, 25)
    assert percent(model, proposed.coefficients) == pytest.approx(percent(model, plain.coefficients), abs=2.0)
    unweighted = EsoRwLssvr(variant="proposed", weighted=False, **options).fit([record], model)
    assert "outliers" in proposed.extra and "outliers" not in unweighted.extra


def test_the_printed_variant_runs_with_large_errors():
    record = record_of("cargo-S3", dt=0.02)
    found = EsoRwLssvr(variant="as_printed", C=1e10).fit([record], resolve("cargo"))
    error = percent(resolve("cargo"), found.coefficients)
    assert not np.abs(error).max() < 30.0


def test_the_printed_variant_needs_a_heading_reference():
    record = record_of("cargo-S3").with_channels(rudder_command_rad=None)
    with pytest.raises(CannotFit, match="rudder command"):
        EsoRwLssvr(variant="as_printed").fit([record], resolve("cargo"))


def test_3dof_models_are_refused():
    with pytest.raises(CannotFit, match="response model"):
        EsoRwLssvr().fit([generate(Case("mariner", "zigzag:20/20", duration_s=100.0))], resolve("mariner"))
