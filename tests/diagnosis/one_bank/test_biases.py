"""The two biases of every log are told after an identification, with sizes, and only where there are some."""

import numpy as np
import pytest

import helmbench
from helmbench.diagnosis.one_bank.biases import biases_of

from ...simulators.response import GAIN, T_S, heading_only, steps, turned

NEUTRAL, ZERO = np.deg2rad(2.0), np.deg2rad(0.3)


def told(*records, method="output-error"):
    return biases_of(helmbench.identify(records, "nomoto-1", method).model, records)


@pytest.mark.parametrize("method", ["output-error", "ls"])
def test_a_neutral_angle_is_told_from_the_heading_alone(method):
    record = heading_only(turned(steps(3), NEUTRAL))
    estimate, found = helmbench.identify(record, "nomoto-1", method), told(record, method=method)
    (size,) = found.sizes
    assert size.parameter == "rudder_offset" and size.low < NEUTRAL < size.high
    assert size.value == pytest.approx(NEUTRAL, rel=0.1)
    assert found.parameters["K"] == pytest.approx(GAIN, rel=0.03) and found.parameters["T"] == pytest.approx(
        T_S, rel=0.1
    )
    assert abs(estimate.parameters["K"] - GAIN) > abs(found.parameters["K"] - GAIN)
    assert found.after["heading_rad"] < 0.3 * found.before["heading_rad"]


def test_a_gyro_bias_is_told_from_yaw_rate_and_heading():
    (size,) = told(turned(steps(3), zero=ZERO)).sizes
    assert size.parameter == "yaw_rate_bias" and size.low < ZERO < size.high


def test_every_record_may_have_a_neutral_angle_of_its_own():
    records = [turned(steps(3), NEUTRAL, name="one"), turned(steps(4), -NEUTRAL, seed=1, name="two")]
    found = told(*records)
    assert [(s.parameter, s.record) for s in found.sizes] == [("rudder_offset", "one"), ("rudder_offset", "two")]
    assert [s.value for s in found.sizes] == pytest.approx([NEUTRAL, -NEUTRAL], rel=0.1)
    assert found.after["heading_rad"] < 0.3 * found.before["heading_rad"]


@pytest.mark.parametrize("seed", range(10))
def test_nothing_is_told_of_a_clean_record(seed):
    record = turned(steps(seed), seed=seed)
    assert told(record) is None and told(heading_only(record), method="ls") is None


def test_a_turn_to_one_side_tells_no_neutral_angle():
    record = helmbench.simulate("response-1", "turn:35", noise="low", seed=0)
    assert told(record, method="ls") is None
    one_sided = turned(np.abs(steps(3)), NEUTRAL)
    assert told(one_sided) is None


def test_an_unusual_angle_is_told_where_it_explains_the_record_and_not_in_place_of_a_lacking_term():
    (size,) = told(turned(steps(3), 3.0 * NEUTRAL)).sizes
    assert size.value == pytest.approx(3.0 * NEUTRAL, rel=0.05)
    lacking = helmbench.simulate("kvlcc2-l7", "prbs:20deg/10s", noise="low", seed=2)
    assert told(lacking, method="ls") is None
