"""Another code as nature: shipmmg's KVLCC2 with one constant changed, against our model with the others."""

import numpy as np
import pytest

from helmbench import calibrate

from ..models.test_reference_kvlcc2 import ship_of_shipmmg
from ..simulators.peer import TRAIN, records


@pytest.mark.nightly
def test_the_rudder_area_of_another_code_is_found():
    """The area stands in the rudder's force as the slope does; the other wake law moves the size by a few percent,
    and is named where the records show it."""
    found = calibrate(ship_of_shipmmg(), records({"A_R": 1.213}, TRAIN[:4], np.random.default_rng(1)))
    print(found.moved, found.steps)
    assert found.verdict == "named"
    assert {step.group for step in found.steps} <= {"rudder_force", "wake_in_turns"}
    (moved,) = (m for m in found.moved if m.group == "rudder_force")
    assert moved.name in ("f_alpha", "A_R") and moved.after / moved.before == pytest.approx(1.213, abs=0.08)
