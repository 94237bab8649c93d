"""Profile-likelihood intervals: symmetric for a quadratic cost, else not; open where the ratio stays small."""

import numpy as np
import pytest

from helmbench.methods.output_error import OutputError
from helmbench.models.model import resolve


def test_of_a_quadratic_cost_they_are_wald_intervals(suite):
    model, records = suite("response-1", noise="medium")
    found = OutputError(profile="all").fit(records, model)
    for name, interval in found.extra["profile"].items():
        value, error = found.parameters[name], found.stderr[name]
        ends = [(interval["low"] - value) / error, (interval["high"] - value) / error]
        assert ends == pytest.approx([-1.96, 1.96], rel=0.05)
        assert not interval["low_open"] and not interval["high_open"]


def test_the_limits_are_where_the_likelihood_ratio_reaches_its_threshold(suite):
    """Weakly excited: a refit with the parameter fixed at either limit costs half the chi-square quantile more."""
    model, records = suite("patrol", noise="medium")
    records = [record.with_channels(yaw_rate_rad_s=None).slice(0, 600) for record in records[:1]]
    found = OutputError(profile=["T2"], level=0.9).fit(records, model)
    interval = found.extra["profile"]["T2"]
    left, right = found.parameters["T2"] - interval["low"], interval["high"] - found.parameters["T2"]
    print(found.parameters, found.stderr, interval)
    for end, is_open in (("low", "low_open"), ("high", "high_open")):
        if not interval[is_open]:
            kept = OutputError(fixed={"T2": interval[end]}).fit(records, model)
            print(end, kept.extra["cost"] - found.extra["cost"])
            assert kept.extra["cost"] - found.extra["cost"] == pytest.approx(2.706 / 2.0, abs=0.12)
    assert left > 0.0 and right > 0.0


def test_a_bound_leaves_the_interval_open(suite):
    model, records = suite("response-1", noise="medium")
    free = OutputError(fixed=["alpha"]).fit(records, model)
    bound = free.parameters["K"] + free.stderr["K"]
    found = OutputError(bounds={"K": (None, bound)}, fixed=["alpha"], profile="K+alpha").fit(records, model)
    interval = found.extra["profile"]["K"]
    assert interval["high"] == bound and interval["high_open"] and not interval["low_open"]
    kept = found.extra["profile"]["alpha"]
    assert kept["low"] == kept["high"] == model.parameters["alpha"]


def test_an_undetermined_parameter_has_an_open_interval(suite):
    """A cubic term at a hundredth of a degree of rudder: no value of alpha within reach has a large ratio."""
    from ....made_up.records import driven

    model = resolve("response-1")
    small = driven(model, 1e-4 * np.sign(np.sin(0.05 * np.arange(1500))), 0.2)
    rng = np.random.default_rng(1)
    noisy = small.with_channels(
        yaw_rate_rad_s=small.column("yaw_rate_rad_s") + 1e-6 * rng.normal(size=1500), heading_rad=None
    )
    found = OutputError(profile="alpha").fit([noisy], model)
    print(found.parameters, found.stderr, found.extra["profile"])
    interval = found.extra["profile"]["alpha"]
    assert interval["low"] < model.parameters["alpha"] < interval["high"]
    assert interval["high"] - interval["low"] > 100.0 * model.parameters["alpha"]
