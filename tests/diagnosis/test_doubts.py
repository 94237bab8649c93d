"""A doubt sets aside the record that it is about; one about the rudder gives way where free runs follow."""

from dataclasses import replace

import numpy as np
import pytest

import helmbench
from helmbench.checks.result import CheckFinding
from helmbench.diagnosis.checked import with_checks
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.result import RemainingForce
from helmbench.models.model import resolve

from ..simulators.response import GAIN, T_S, steps, turned


@pytest.fixture(scope="module")
def model():
    """The ship without its neutral angle."""
    nomoto = resolve("nomoto-1")
    return nomoto.with_coefficients(nomoto.from_parameters({"T": T_S, "K": GAIN}))


def torn(record):
    """The record without 27 of each 45 rows."""
    kept = np.arange(record.n) % 45 < 18
    return replace(record, time_s=record.time_s[kept], channels={k: v[kept] for k, v in record.channels.items()})


def test_a_held_out_record_with_missing_rows_is_set_aside(model):
    neutral = np.deg2rad(2.0)
    train, held = turned(steps(1), neutral), torn(turned(steps(2), neutral, seed=2, name="torn"))
    found = helmbench.diagnose(model, train, held)
    assert found.verdict == "named" and [f.cause for f in found.causes] == ["rudder_offset"]
    assert found.causes[0].sizes[0].value == pytest.approx(neutral, rel=0.05)
    assert any(said.startswith("torn is set aside: ") for said in found.doubts) and not found.gain


def test_a_training_record_in_doubt_is_set_aside_and_the_others_are_diagnosed(model):
    neutral = np.deg2rad(2.0)
    train = [turned(steps(k), neutral, seed=k, name=f"run-{k}") for k in (1, 3)]
    train.append(torn(turned(steps(2), neutral, seed=2, name="torn")))
    found = diagnose(model, train)
    assert found.verdict == "named" and [f.cause for f in found.causes] == ["rudder_offset"]
    assert [f.standing for f in found.checks if f.records == ("torn",)] == [False]


def test_where_every_training_record_is_in_doubt_nothing_is_said_of_the_model(model):
    found = diagnose(model, [torn(turned(steps(1), np.deg2rad(2.0)))], [turned(steps(2), name="held")])
    assert found.verdict == "inconclusive" and not found.causes


def test_a_doubt_about_the_rudder_gives_way_where_free_runs_follow(model):
    records = [turned(steps(1))]
    found = diagnose(model, records)
    lost = replace(
        found, traces=tuple(replace(t, after={c: 0.0 * y for c, y in t.after.items()}) for t in found.traces)
    )
    response = CheckFinding("rudder_response", "file", ("run",), ("rudder_rad",), (), "it explains 1 %", standing=True)
    told = with_checks(found, (response,), records)
    assert told.verdict == "adequate" and not told.checks[0].standing
    assert told.doubts == ("it explains 1 %; yet free runs with it hold 100 % of the yaw motion",)
    assert with_checks(lost, (response,), records).verdict == "inconclusive"
    torn_file = replace(response, cause="time_stamps", channels=("time_s",))
    assert with_checks(found, (torn_file,), records).verdict == "inconclusive"


def test_what_remains_is_withheld_with_the_model(model):
    """Where records stand in doubt, and where free runs with the described force do not follow the motion."""
    records = [turned(steps(1))]
    force = RemainingForce("N", ("heading",), "a yaw moment", 0.9, {}, (), True, "a current", "turn")
    found = replace(diagnose(model, records), verdict="described", remaining=(force,))
    assert with_checks(found, (), records).remaining == (force,)
    torn_file = CheckFinding("time_stamps", "file", ("run",), ("time_s",), (), "rows are missing", standing=True)
    assert with_checks(found, (torn_file,), records).remaining == ()
    lost = replace(
        found, traces=tuple(replace(t, after={c: 0.0 * y for c, y in t.after.items()}) for t in found.traces)
    )
    told = with_checks(lost, (), records)
    assert told.verdict == "unexplained" and told.remaining == ()


def test_a_neutral_angle_is_named_by_the_heading_alone_beside_numbers_of_these_records():
    neutral = np.deg2rad(2.0)
    record = turned(steps(3), neutral)
    alone = replace(record, channels={k: v for k, v in record.channels.items() if k != "yaw_rate_rad_s"})
    found = helmbench.diagnose("nomoto-1", alone, base_parameters="identify")
    assert [f.cause for f in found.causes] == ["rudder_offset"]
    (size,) = found.causes[0].sizes
    assert size.low < neutral < size.high and size.value == pytest.approx(neutral, rel=0.15)
