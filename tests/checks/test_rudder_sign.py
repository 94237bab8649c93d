"""The side to which a positive rudder turns the ship, of records together."""

import pytest

from helmbench.checks.check import check
from helmbench.datasets.columns import RUDDERS
from helmbench.datasets.generator import Case, generate


def turned(record):
    return record.with_channels(**{n: -record.column(n) for n in RUDDERS if record.has(n)})


@pytest.fixture
def records(seed):
    """Two zigzags, and one in which nothing tells the side: of rudder and speed alone."""
    cases = ("zigzag:20/20", "zigzag:10/10:port", "zigzag:15/15")
    first, second, last = (generate(Case("mariner", text, "low", seed=seed, duration_s=600.0)) for text in cases)
    bare = ("heading_rad", "yaw_rate_rad_s", "north_m", "east_m")
    return [first, second, last.with_channels(**dict.fromkeys(bare))]


def named(records):
    return [f.records for f in check(records).findings if f.cause == "rudder_sign" and f.material]


def test_records_that_cannot_tell_the_side_follow_those_that_contradict_it(records):
    assert named(records) == []
    assert named([turned(r) for r in records]) == [tuple(r.name for r in records)]


def test_where_a_record_confirms_its_side_only_those_that_contradict_it_are_wrong(records):
    first, second, silent = records
    assert named([turned(first), second, silent]) == [(first.name,)]
