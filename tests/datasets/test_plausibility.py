"""A record against itself: the rudder's sign, the units of its columns, runs that are given twice."""

import re
from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.copies import check_no_copies
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.plausibility import check_plausible, doubts
from helmbench.datasets.yaw_response import rudder_sign_doubt
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
    spoiled = np.where(np.arange(record.n) == 50, 1e300, record.column("yaw_rate_rad_s"))
    assert rudder_sign_doubt(record.with_channels(yaw_rate_rad_s=spoiled)) is None
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


def exchanged(record, first, second):
    return record.with_channels(**{first: record.column(second), second: record.column(first)})


def test_a_heading_under_the_yaw_rate_and_the_other_way_round_is_refused(rng):
    ship = str(rng.choice(["response-1", "cargo", "kvlcc2-l7"]))
    record = generate(Case(ship, "zigzag:20/20", "low", seed=int(rng.integers(1000))))
    with pytest.raises(BadInput, match="yaw_rate_rad_s: changes as the integral of heading_rad does; exchange"):
        check_plausible([exchanged(record, "heading_rad", "yaw_rate_rad_s")], resolve(ship))


@pytest.mark.parametrize("angle", ["heading_rad", "heading in degrees"])
def test_a_heading_that_crosses_north_is_compared_over_full_turns(angle, turning):
    """Wrapped at 360 degrees, as loggers have it."""
    psi = turning.heading_unwrapped() % (2.0 * np.pi)
    assert np.sum(np.abs(np.diff(psi)) > 6.0) > 3
    if angle == "heading_rad":
        assert doubts(turning.with_channels(heading_rad=psi)) == []
        backwards = turning.with_channels(heading_rad=-psi % (2.0 * np.pi))
        assert any("headings change against" in str(d) for d in doubts(backwards))
    else:
        (found, *_) = doubts(turning.with_channels(heading_rad=DEGREES * psi))
        assert "degrees in heading_rad" in str(found) and found.fatal


CUTS = {
    "a stretch, its time from 0": lambda r: replace(r.slice(60, 150), time_s=r.time_s[:90]),
    "fewer channels": lambda r: r.slice(20, 160).with_channels(sway_m_s=None, north_m=None),
    "every third sample": lambda r: r.thinned(3),
    "the later half and more": lambda r: r.slice(90, None),
}


@pytest.mark.parametrize("cut", CUTS)
def test_a_part_of_a_training_record_is_not_held_out(cut, turning):
    part = replace(CUTS[cut](turning), name="part")
    with pytest.raises(BadInput, match=f"part: shares {part.n} of its {part.n} samples with the training record"):
        check_no_copies([turning], [part])
    with pytest.raises(BadInput, match=f"shares {part.n} of its {turning.n} samples with part"):
        check_no_copies([part, turning])


def test_runs_of_their_own_are_no_copies(turning):
    again = generate(Case("kvlcc2-l7", "zigzag:20/20", "medium", seed=1, duration_s=100.0, dt_s=0.5))
    check_no_copies([turning], [again])
    check_no_copies([turning.slice(0, 100)], [turning.slice(100, None)])
    quiet = [generate(Case("mariner", text, "none")) for text in ("zigzag:20/20", "turn:20", "pullout:20", "straight")]
    check_no_copies(quiet)  # they begin alike


AXES = {
    "east_m has the other sign": lambda r: {"east_m": -r.column("east_m")},
    "north_m has the other sign": lambda r: {"north_m": -r.column("north_m")},
    "north_m and east_m are exchanged; or": lambda r: {"north_m": r.column("east_m"), "east_m": r.column("north_m")},
    "exchanged and both": lambda r: {"north_m": -r.column("east_m"), "east_m": -r.column("north_m")},
    "the track runs at": lambda r: {"north_m": -r.column("east_m"), "east_m": r.column("north_m")},
}


@pytest.mark.parametrize("manoeuvre", ["zigzag:20/20", "turn:35"])
@pytest.mark.parametrize("said", AXES)
def test_a_track_in_other_axes_than_the_heading_is_told_without_velocities(said, manoeuvre, rng):
    ship = str(rng.choice(["mariner", "s175", "kvlcc2-l7", "esso-osaka-l3"]))
    record = generate(Case(ship, manoeuvre, "low", seed=int(rng.integers(1000))))
    print(ship)
    for name in (None, "surge_m_s"):
        bare = record.with_channels(surge_m_s=None, sway_m_s=None) if name is None else record
        changed = bare.with_channels(**AXES[said](bare))
        assert [str(d) for d in doubts(bare, resolve(ship))] == []
        found = [d for d in doubts(changed, resolve(ship)) if d.column == "north_m"]
        assert len(found) == 1 and said in str(found[0]) and found[0].fatal == (name is None)


@pytest.mark.parametrize("share", [-0.6, 0.45])
@pytest.mark.parametrize("ship", ["mariner", "s175", "kvlcc2-l7", "remus"])
def test_velocities_of_a_point_far_from_midship_are_told(ship, share, rng):
    model = resolve(ship)
    length = model.particulars["L"]
    for manoeuvre in ("zigzag:20/20", "turn:35:port"):
        record = generate(Case(ship, manoeuvre, "low", seed=int(rng.integers(1000))))
        arm = share * length * record.column("yaw_rate_rad_s")
        (found,) = doubts(record.with_channels(sway_m_s=record.column("sway_m_s") + arm), model)
        told = float(re.search(r"as that of a point (\S+) m (ahead of|abaft) midship", found.message)[1])
        assert abs(told / (abs(share) * length) - 1.0) < 0.5 and not found.fatal
        assert ("ahead of midship" in found.message) == (share > 0.0)
    reversed_sway = record.with_channels(sway_m_s=-record.column("sway_m_s"))
    assert any("else check signs" in str(d) for d in doubts(reversed_sway))


def test_revolutions_of_the_engine_before_its_gear_are_told():
    model, record = resolve("kvlcc2-l7"), generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=200.0))
    turns = np.full(record.n, model.n0_rps)
    assert doubts(record.with_channels(propeller_rps=0.8 * turns), model) == []
    (doubt,) = doubts(record.with_channels(propeller_rps=2.5 * turns), model)
    assert doubt.column == "propeller_rps" and not doubt.fatal and "gear" in doubt.hint


def test_a_sway_that_no_point_of_the_ship_has_counts_to_the_other_side():
    record = generate(Case("kvlcc2-l7", "turn:25", duration_s=200.0))
    (doubt,) = doubts(record.with_channels(sway_m_s=-record.column("sway_m_s")), resolve("kvlcc2-l7"))
    assert "ahead of midship" in doubt.message and "no point of the ship" in doubt.hint
