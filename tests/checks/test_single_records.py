"""What one record of several has alone: told in it with its size, and corrected; by a simulator of other code."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.check import check, examine
from helmbench.checks.files.units import revolutions_units


@pytest.fixture
def records(rng):
    return inject(FaultCase("kvlcc2-l7", ()), rng).train


def with_second(records, **columns):
    """The records of which the second one has other columns."""
    return [records[0], records[1].with_channels(**columns), *records[2:]]


def test_a_sway_log_that_reads_too_much_in_one_record_is_told_there(records):
    wrong = with_second(records, sway_m_s=1.4 * records[1].column("sway_m_s"))
    (found,) = (f for f in check(wrong).findings if f.material)
    assert found.cause == "speed_scale" and "scaled: sway" in found.evidence
    sizes = {size.record: size.value for size in found.sizes}
    assert sizes[records[1].name] == pytest.approx(0.4, abs=0.02)
    assert all(abs(sizes[r.name]) < 0.05 for r in records if r is not records[1])


@pytest.mark.parametrize(("factor", "unit"), [(2.0 * np.pi, "rad/s"), (60.0, "revolutions in a minute")])
def test_revolutions_of_one_record_in_another_unit_are_told_and_corrected(records, factor, unit):
    turns = 10.0 * np.ones(records[0].n)
    right = [r.with_channels(propeller_rps=turns[: r.n]) for r in records]
    done = examine(with_second(right, propeller_rps=factor * turns))
    (found,) = (f for f in done.findings if f.cause == "wrong_unit")
    assert found.records == (records[1].name,) and unit in found.evidence and found.corrected
    assert np.allclose(done.records[1].column("propeller_rps"), turns)


def test_revolutions_that_count_astern_are_told_and_turned_and_a_stop_is_none(records):
    turns = 10.0 * np.ones(records[0].n)
    stopping = np.where(np.arange(turns.size) < 0.8 * turns.size, turns, -turns)
    astern = [r.with_channels(propeller_rps=x[: r.n]) for r, x in zip(records, (turns, -turns, stopping), strict=False)]
    done = examine(astern)
    (found,) = (f for f in done.findings if f.cause == "channel_sign")
    assert found.records == (records[1].name,) and found.channels == ("propeller_rps",)
    assert np.allclose(done.records[1].column("propeller_rps"), turns)


def test_other_revolutions_are_no_other_unit(records):
    """Nor is one record of two told from the other."""
    turns = 10.0 * np.ones(records[0].n)
    right = [r.with_channels(propeller_rps=turns[: r.n]) for r in records]
    assert not revolutions_units(with_second(right, propeller_rps=1.5 * turns))
    assert not revolutions_units(with_second(right, propeller_rps=60.0 * turns)[:2])


def test_turns_beyond_the_range_of_a_gyro_are_no_other_unit(records):
    """What is cut off is left out: the heading turns on in these gaps."""
    cut = []
    for record in records:
        rate = record.column("yaw_rate_rad_s")
        limit = 0.5 * float(np.nanquantile(np.abs(rate), 0.99))
        cut.append(record.with_channels(yaw_rate_rad_s=np.clip(rate, -limit, limit)))
    causes = {f.cause for f in check(cut).findings if f.material}
    assert causes == {"yaw_rate_saturation"}


def test_one_long_gap_leaves_two_records_that_can_be_used(records):
    record = records[0]
    kept = np.r_[0 : int(0.4 * record.n), int(0.55 * record.n) : record.n]
    torn = np.flatnonzero(np.arange(record.n) % 60 < 25)
    for rows, stands in ((kept, False), (torn, True)):
        channels = {name: values[rows] for name, values in record.channels.items()}
        found = check([replace(record, time_s=record.time_s[rows], channels=channels)]).findings
        (gaps,) = (f for f in found if f.cause == "time_stamps" and "missing" in f.evidence)
        assert gaps.standing == stands
