"""Multiple shooting: the same minimum, from worse starts and for unstable vessels."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import parse_noise
from helmbench.estimation.likelihood.output_error import fit_output_error
from helmbench.estimation.likelihood.problem import free_start_problem, sensor_sd_of
from helmbench.estimation.likelihood.shooting import shooting_problem
from helmbench.estimation.records.series import series_of
from helmbench.methods.output_error import OutputError
from helmbench.models.model import HeadingController, resolve


@pytest.mark.parametrize(("vessel", "stretches"), [("remus-kt", 16), ("cargo", 5)])
def test_the_minimum_is_that_of_single_runs(suite, vessel, stretches):
    model, records = suite(vessel, noise="medium")
    single, multiple = OutputError().fit(records, model), OutputError(shooting=stretches).fit(records, model)
    assert multiple.parameters == pytest.approx(single.parameters, rel=1e-5)
    assert multiple.extra["cost"] == pytest.approx(single.extra["cost"], abs=1e-4)
    assert "jumps" not in multiple.extra  # closed exactly by runs over whole records


def test_a_diverging_start_reaches_the_same_minimum(suite):
    """Heading alone: growing horizons cannot help, stretches with free states can."""
    model, records = suite("cargo", noise="low")
    series = [series_of(r.with_channels(yaw_rate_rad_s=None), model) for r in records]
    with np.errstate(all="ignore"):
        good = fit_output_error(series, model, [model.coefficients])
        bad = fit_output_error(series, model, [model.coefficients * [0.3, -2.0, 2.0, 0.3]], shooting=20)
    assert bad.minimum.cost == pytest.approx(good.minimum.cost, abs=1e-2)


@pytest.mark.parametrize("vessel", ["response-2", "kvlcc2-l7"])
def test_the_factor_holds_the_derivatives_of_the_jumps(suite, vessel):
    """R'r of the factor is the gradient of the cost, jumps included."""
    model, records = suite(vessel, noise="medium")
    series = [series_of(records[0].turned(model.positive_rudder).slice(0, 160), model)]
    free = free_start_problem(series, model)
    chain = shooting_problem(replace(free, sensor=sensor_sd_of(free)), 4)
    z = chain.start(1.02 * model.coefficients)
    factor = chain.factor(chain.at(z))
    gradient = -factor[:, :-1].T @ factor[:, -1]
    for i in range(z.size):
        step = np.zeros(z.size)
        step[i] = 1e-5 * max(abs(z[i]), 1e-2)
        slope = (chain.at(z + step).cost - chain.at(z - step).cost) / (2.0 * step[i])
        assert slope == pytest.approx(gradient[i], rel=2e-3, abs=2e-3 * np.abs(gradient * step).max() / step[i])


@pytest.mark.parametrize("noise", ["heading=0.02deg,yaw_rate=0.01deg_s", "low"])
def test_an_unstable_ship_on_a_long_record(noise, seed):
    """A yaw rate that grows by e^45 without helm: no free run follows it, stretches joined without a jump do.

    Noise of the rudder's sensor acts as helm and changes the heading of the joined run by several times the noise of
    the heading sensor: the model need not explain such records, but the coefficients are identified.
    """
    ship = resolve("response-1")
    family = resolve("nomoto-1")
    helmsman = HeadingController(8.0, 20.0)
    model = replace(family.with_coefficients([0.05, 0.02]), controller=helmsman, rudder=ship.rudder)
    manoeuvre = parse_manoeuvre("heading:20deg/90s+10deg/40s")
    record = record_run(model, manoeuvre, parse_noise(noise), seed=seed, duration_s=900.0, dt_s=0.5)
    found = OutputError(shooting=40).fit([record], family)
    print(found.parameters, found.message, found.extra)
    assert found.extra["explains_records"] or noise == "low"
    assert "multiple shooting" in found.message and found.extra["initial_states"] == "estimated"
    assert max(found.extra["jumps"].values()) < 1e-5
    assert found.coefficients == pytest.approx([0.05, 0.02], rel=0.02)
