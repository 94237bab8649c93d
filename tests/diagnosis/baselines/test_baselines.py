"""The diagnosers to compare with do what they say where it is easy."""

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.baselines.naive import LAGS, BestFit, Nothing, ResidualBic, ljung_box
from helmbench.diagnosis.baselines.output_error import FilterRuns, rms
from helmbench.diagnosis.baselines.sparse_regression import SparseRegression, survivors
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import testable as bank_of
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

OFFSET = Effect("rudder_offset", {"delta0": np.deg2rad(3.0)})
BIAS = Effect("yaw_rate_bias", {"b": np.deg2rad(1.0)})


def test_ljung_box_is_chi_squared_on_white_noise_and_large_on_coloured(rng):
    white = rng.standard_normal((400, 500))
    found = np.array([ljung_box(series) for series in white])
    assert abs(found.mean() - LAGS) < 4.5 * np.sqrt(2.0 * LAGS / len(found)) + 0.5
    assert ljung_box(np.convolve(white[0], np.ones(5))) > 200.0
    assert ljung_box(np.array([np.inf, 1.0] * 60)) == np.inf


@pytest.fixture
def offset(rng):
    return inject(FaultCase("response-1", effects=(OFFSET,)), rng)


def test_output_error_finds_the_size_of_a_gross_offset(offset):
    runs = FilterRuns(resolve("response-1"), offset.train)
    base, (bank, _) = runs.base(), bank_of(runs.est)
    (variant,) = bank[cause_of("rudder_offset")]
    fit = runs.fit(base, variant)
    value = runs.est.value(fit.setting, variant[0])
    assert value == pytest.approx(OFFSET.parameters["delta0"], rel=0.05)
    assert fit.criterion() < base.criterion() - 100.0
    assert (rms(fit.residuals)[:2] < 0.5 * rms(base.residuals)[:2]).any()


def test_bic_names_a_gross_offset_and_measures_its_gain(offset):
    found = ResidualBic().diagnose(resolve("response-1"), offset.train, offset.held_out, Options())
    assert found.verdict == "named" and found.causes[0].cause in ("rudder_offset", "constant_force")
    gain = found.gain["heading_rad"]
    assert gain.rmse_after < 0.5 * gain.rmse_before
    assert all(size.low <= size.value <= size.high for cause in found.causes for size in cause.sizes)


def test_bic_keeps_to_the_causes_it_is_told(offset):
    told = Options(only=("rudder_offset",))
    found = ResidualBic().diagnose(resolve("response-1"), offset.train, offset.held_out, told)
    assert [cause.cause for cause in found.causes] == ["rudder_offset"]


def test_pursuit_finds_the_terms_of_a_made_up_equation(rng):
    x = {name: rng.standard_normal(2000) for name in "abcd"}
    y = 2.0 * x["b"] + 0.7 * x["d"] + 0.3 * rng.standard_normal(2000)
    found = survivors(y, x, {"a": None, "b": "first", "c": None, "d": "second"})
    assert [cause for _, _, cause in found] == ["first", "second"]
    assert sum(share for share, _, _ in found) == pytest.approx(1.0, abs=0.05)
    assert survivors(rng.standard_normal(2000), x, dict.fromkeys("abcd")) == []


def test_pursuit_names_a_gross_bias(rng):
    injected = inject(FaultCase("response-1", effects=(BIAS,)), rng)
    found = SparseRegression().diagnose(resolve("response-1"), injected.train, injected.held_out, Options())
    assert [cause.cause for cause in found.causes] == ["yaw_rate_bias"]


def test_a_ship_with_sway_has_track_equations(rng):
    injected = inject(FaultCase("s175", effects=(Effect("sway_offset", {"b": 0.5}),), duration_s=200.0), rng)
    found = SparseRegression().diagnose(resolve("s175"), injected.train, injected.held_out, Options())
    assert found.verdict in ("named", "unexplained")
    assert set(found.gain) == {"heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m"}


def test_naive_diagnosers_name_one_cause_always_or_none_ever(offset, rng):
    clean = inject(FaultCase("response-1", duration_s=60.0), rng)
    model = resolve("response-1")
    told = {
        cls.name: cls().diagnose(model, clean.train[:1], clean.held_out[:1], Options()) for cls in (BestFit, Nothing)
    }
    assert len(told["best-fit"].causes) == 1 and told["best-fit"].verdict == "named"
    assert told["nothing"].causes == () and told["nothing"].verdict == "adequate"
    (found,) = BestFit().diagnose(model, offset.train, (), Options()).causes
    base = FilterRuns(model, offset.train).base()
    assert found.statistic > 100.0 and np.isfinite(base.criterion())
    assert Nothing().diagnose(model, offset.train, (), Options()).causes == ()
