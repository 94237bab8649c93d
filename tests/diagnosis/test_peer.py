"""Another code as nature: shipmmg's KVLCC2 with one constant changed, against our model with the others."""

import numpy as np
import pytest

from helmbench import calibrate

from ..models.test_reference_kvlcc2 import ship_of_shipmmg
from ..simulators.peer import TRAIN, records


@pytest.mark.nightly
def test_the_rudder_area_of_another_code_is_a_matter_of_the_rudder():
    """With the other wake law five numbers of the rudder's inflow predict left-out pieces clearly better than the slope
    of its force does, which stands where the area stands."""
    found = calibrate(ship_of_shipmmg(), records({"A_R": 1.213}, TRAIN[:4], np.random.default_rng(1)))
    print(found.moved, found.steps)
    assert found.verdict == "named"
    assert {step.group for step in found.steps} <= {"rudder_force", "rudder_inflow", "wake_in_turns"}
    for column in ("sway_m_s", "yaw_rate_rad_s", "heading_rad"):
        assert found.after[column][0] < 0.3 * found.before[column][0]
