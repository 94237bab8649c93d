"""A record against itself: the rudder's sign, the units of its columns, runs that are given twice."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.plausibility import check_no_copies, check_plausible
from helmbench.datasets.rudder_sign import rudder_sign_doubt
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve


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


@pytest.fixture
def turning():
    """A run of the KVLCC2 model with all channels."""
    return generate(Case("kvlcc2-l7", "zigzag:20/20", "medium", duration_s=100.0, dt_s=0.5))


def times(record, factor, *names):
    return record.with_channels(**{name: factor * record.column(name) for name in names})


DEGREES, KNOTS = 180.0 / np.pi, 3600.0 / 1852.0
WRONG_UNITS = {
    "degrees[?] then call the column rudder_deg": lambda r: times(r, DEGREES, "rudder_rad"),
    "beyond 1.6 rad; check the column": lambda r: times(r, 5000.0, "rudder_rad"),
    "degrees per second[?] then call the column yaw_rate_deg_s": lambda r: times(r, DEGREES, "yaw_rate_rad_s"),
    "degrees in heading_rad": lambda r: times(r, DEGREES, "heading_rad"),
    "knots in speed columns": lambda r: times(r, KNOTS, "surge_m_s", "sway_m_s"),
    "km/h in speed columns": lambda r: times(r, 3.6, "surge_m_s", "sway_m_s"),
    "above 10 times the 1.179 m/s of kvlcc2-l7": lambda r: times(r, 1e6, "surge_m_s"),
    "milliseconds in time_s": lambda r: replace(r, time_s=1e3 * r.time_s),
    "check the units of heading, yaw rate and time": lambda r: replace(r, time_s=1e-9 * r.time_s),
    "yaw_rate_rad_s: stays at 0 while the rudder moves": lambda r: times(r, 0.0, "yaw_rate_rad_s"),
    "a dead sensor": lambda r: times(r, 1e-30, "heading_rad"),
}


@pytest.mark.parametrize("said", WRONG_UNITS)
def test_numbers_in_another_unit_are_refused_by_the_unit_they_are_in(turning, said):
    with pytest.raises(BadInput, match=said):
        check_plausible([WRONG_UNITS[said](turning)], resolve("kvlcc2-l7"))


@pytest.mark.parametrize("vessel", ["response-1", "cargo", "mariner", "s175", "kvlcc2-l7", "remus"])
def test_good_records_are_taken(vessel):
    texts = ("zigzag:20/20", "turn:20", "straight")
    check_plausible([generate(Case(vessel, text, "high")) for text in texts], resolve(vessel))


def test_sensor_errors_that_can_be_named_are_no_wrong_unit(turning):
    check_plausible([times(turning, 1.15, "surge_m_s", "sway_m_s")], resolve("kvlcc2-l7"))
    swapped = turning.with_channels(surge_m_s=turning.column("sway_m_s"), sway_m_s=turning.column("surge_m_s"))
    check_plausible([swapped], resolve("kvlcc2-l7"))


def test_a_run_given_twice_is_refused_under_any_name(turning):
    copy = replace(turning, name="copy")
    with pytest.raises(BadInput, match="copy: holds the same samples as"):
        check_plausible([turning, copy], resolve("kvlcc2-l7"))
    with pytest.raises(BadInput, match="copy: is both a training record and held out"):
        check_no_copies([turning], [copy])
    check_no_copies([turning], [turning.slice(0, 100)])
