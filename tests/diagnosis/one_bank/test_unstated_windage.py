"""A wind on a ship whose model states no areas above water: those of a usual ship; and one that is measured."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve


@pytest.mark.parametrize("towards_rad", [3.4, pytest.param(0.6, marks=pytest.mark.nightly)])
def test_a_wind_is_named_with_its_direction(towards_rad, rng):
    """Beside a simulator of its own, with areas and coefficients that the model does not know."""
    coming_from = np.mod(towards_rad + 2.0 * np.pi, 2.0 * np.pi) - np.pi
    case = inject(FaultCase("mariner", effects=(Effect("wind", {"speed": 12.0, "from": coming_from}),)), rng)
    base = replace(resolve("mariner"), windage=None)
    found = diagnose(base, case.train, case.held_out)
    print(found.verdict, found.causes, found.gain["heading_rad"])
    (wind,) = found.causes
    assert wind.cause == "wind" and "areas above water" in wind.details["assumed"]
    size = {s.parameter: s for s in wind.sizes}
    assert np.cos(size["from"].value - coming_from) > np.cos(np.deg2rad(15.0))
    assert found.extended.windage is not None
    gain = found.gain["heading_rad"]
    assert gain.own_after < 0.5 * gain.own_before


def measured(records, speed_m_s, coming_from):
    """The records with an anemometer's channels."""
    wind = {"wind_speed_m_s": speed_m_s, "wind_direction_rad": coming_from}
    return [r.with_channels(**{name: np.full(r.n, x) for name, x in wind.items()}) for r in records]


@pytest.mark.parametrize("stated", [None, pytest.param(2.5, marks=pytest.mark.nightly)])
def test_a_measured_wind_acts_on_what_the_model_lacks(stated, rng):
    """The coefficients are the ship's own: those that its vessel file has, of which the simulation's force is made."""
    ship = resolve("mariner")
    names = ("wind_cx", "wind_cy", "wind_cn")
    wrong = None if stated is None else {**ship.windage, **{n: stated * ship.windage[n] for n in names}}
    case = inject(FaultCase("mariner", effects=(Effect("wind", {"speed": 12.0, "from": 0.6}),)), rng)
    train, held_out = (measured(records, 12.0, 0.6) for records in (case.train, case.held_out))
    found = diagnose(replace(ship, windage=wrong), train, held_out)
    (wind,) = found.causes
    assert wind.cause == ("wind" if stated is None else "base_coefficients")
    side, own = found.extended.windage, ship.windage
    assert side["wind_cy"] * side["A_L"] == pytest.approx(own["wind_cy"] * own["A_L"], rel=0.3)
    gain = found.gain["heading_rad"]
    assert gain.own_after < 0.5 * gain.own_before


def test_no_wind_is_named_where_there_is_none(rng):
    case = inject(FaultCase("mariner", ()), rng)
    found = diagnose(replace(resolve("mariner"), windage=None), case.train, case.held_out)
    assert found.verdict == "adequate" and not found.causes and found.extended.windage is None


@pytest.mark.nightly
def test_a_measured_wind_that_is_told_the_other_way_round(rng):
    case = inject(FaultCase("mariner", effects=(Effect("wind", {"speed": 12.0, "from": 0.6}),)), rng)
    train, held_out = (measured(records, 12.0, 0.6 - np.pi) for records in (case.train, case.held_out))
    found = diagnose(resolve("mariner"), train, held_out)
    print(found.causes, found.doubts)
    assert any("where it blows to" in doubt for doubt in found.doubts)
