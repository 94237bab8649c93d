"""A record against itself: the rudder's sign."""

import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.plausibility import rudder_sign_doubt


@pytest.mark.parametrize("manoeuvre", ["zigzag:20/20", "turn:25", "turn:35:port"])
@pytest.mark.parametrize("vessel", ["response-1", "mariner", "s175", "patrol", "kvlcc2-l7", "esso-osaka-l3"])
def test_a_wrong_rudder_sign_is_told_and_a_right_one_is_not(vessel, manoeuvre):
    record = generate(Case(vessel, manoeuvre, "medium"))
    assert rudder_sign_doubt(record) is None
    rudder = -record.column("rudder_rad")
    doubt = rudder_sign_doubt(record.with_channels(rudder_rad=rudder))
    assert doubt is not None and doubt.startswith("rudder_sign: ") and record.meta.positive_rudder in doubt


def test_the_sign_is_read_from_the_heading_where_there_is_no_yaw_rate():
    record = generate(Case("response-1", "zigzag:20/20")).with_channels(yaw_rate_rad_s=None)
    assert rudder_sign_doubt(record) is None
    assert rudder_sign_doubt(record.with_channels(rudder_rad=-record.column("rudder_rad"))) is not None


def test_nothing_is_said_where_nothing_can_be_told():
    record = generate(Case("response-1", "zigzag:20/20"))
    assert rudder_sign_doubt(record.with_channels(yaw_rate_rad_s=None, heading_rad=None)) is None
    assert rudder_sign_doubt(record.slice(0, 10)) is None
