"""Causes of which others are better alone are named together."""

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

LIMIT, RATE = np.deg2rad(25.0), np.deg2rad(4.0)
GEAR = (Effect("rudder_saturation", {"limit": LIMIT}), Effect("rudder_rate_limit", {"rate": RATE}))
"""Alone, a rudder law that weakens towards large angles explains a gear that stops short better than its stop does."""
RIVALS = ("rudder_saturation", "rudder_rate_limit", "rudder_effectiveness", "rudder_delay", "rudder_backlash")


@pytest.mark.parametrize("only", [RIVALS, pytest.param(None, marks=pytest.mark.nightly)], ids=["gear", "all"])
def test_a_gear_that_is_slow_and_stops_short_of_its_orders(only, rng):
    train = ("zigzag:35/35", "zigzag:10/10", "turn:35")
    case = inject(FaultCase("kvlcc2-l7", effects=GEAR, command=True, train=train, held_out=("zigzag:30/30",)), rng)
    found = diagnose(resolve("kvlcc2-l7"), case.train, case.held_out, Options(only=only))
    print(found.verdict, found.reason, found.causes)
    sizes = {f.cause: f.sizes[0].value for f in found.causes}
    assert sizes.keys() == {"rudder_saturation", "rudder_rate_limit"}
    assert np.allclose([sizes[e.cause] for e in GEAR], [LIMIT, RATE], rtol=0.1)
