"""A rudder in another unit is none of the hull's numbers, also where the base model is wrong itself."""

import numpy as np

from helmbench.diagnosis.calibration.calibrate import Records, calibrate_on
from helmbench.estimation.rudder_scale import with_rudder
from helmbench.models.model import resolve

from ...injections import injected


def wrong_base(rng):
    """The KVLCC2 with another resistance, and records of the right one."""
    base, case = resolve("kvlcc2-l7"), injected("kvlcc2-l7", (), rng)
    parameters = {**base.parameters, "R_0": 1.3 * base.parameters["R_0"]}
    return base.with_coefficients(base.from_parameters(parameters)), case.train


def test_twice_the_rudder_is_told_and_no_number_moves(rng):
    base, records = wrong_base(rng)
    found = calibrate_on(base, Records([with_rudder(r, 2.0) for r in records], []))
    print(found.verdict, found.reason, found.moved)
    assert found.verdict == "unexplained" and not found.moved and not found.steps
    assert found.standing is not None and found.standing.sizes[0].value == 0.5
    assert "0.5 times the rudder angle" in found.reason and found.doubts == (found.standing.evidence,)
    assert "standing" not in found.to_json()


def test_a_right_rudder_is_left_alone(rng):
    base, records = wrong_base(rng)
    found = calibrate_on(base, Records(records, []))
    print(found.verdict, [m.name for m in found.moved])
    assert found.standing is None and found.doubts == () and found.moved
    assert np.isfinite([m.after for m in found.moved]).all()
