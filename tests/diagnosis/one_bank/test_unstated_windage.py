"""A wind on a ship whose model states no areas above water: those of a usual ship, and coefficients about theirs."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve


@pytest.mark.parametrize("towards_rad", [0.6, 3.4])
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


def test_no_wind_is_named_where_there_is_none(rng):
    case = inject(FaultCase("mariner", ()), rng)
    found = diagnose(replace(resolve("mariner"), windage=None), case.train, case.held_out)
    assert found.verdict == "adequate" and not found.causes and found.extended.windage is None
