"""Channels that stand still to the end of a record, and rows that are missing in many short gaps."""

import numpy as np
import pytest

from helmbench.checks.check import check
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record


@pytest.fixture
def record(seed):
    return generate(Case("mariner", "zigzag:20/20", "medium", seed=seed, duration_s=600.0, dt_s=1.0))


@pytest.mark.parametrize("begin", [250, 400])
def test_a_noisy_channel_that_repeats_one_value_to_the_end_matters_however_it_came_to_rest(record, begin):
    values = record.column("yaw_rate_rad_s").copy()
    values[begin:] = values[begin]
    findings = check([record.with_channels(yaw_rate_rad_s=values)]).findings
    (frozen,) = [f for f in findings if f.cause == "frozen_samples"]
    assert frozen.material and frozen.channels == ("yaw_rate_rad_s",) and frozen.blanked >= record.n - begin - 1


def test_two_samples_that_are_equal_by_chance_do_not_matter(record):
    values = record.column("yaw_rate_rad_s").copy()
    values[300:302] = values[300]
    findings = check([record.with_channels(yaw_rate_rad_s=values)]).findings
    assert not [f for f in findings if f.cause == "frozen_samples" and f.material]


def in_bursts(n, rng):
    """Six of each fifteen rows."""
    return np.arange(n) % 15 < 6


def at_random(n, rng):
    """Six of ten rows."""
    return rng.random(n) < 0.6


@pytest.mark.parametrize(("rows", "stands"), [(at_random, False), (in_bursts, True)])
def test_rows_that_are_missing_in_short_gaps_stand_only_where_they_are_most(record, rows, stands, rng):
    rows = np.flatnonzero(rows(record.n, rng))
    thin = Record(record.time_s[rows], {n: v[rows] for n, v in record.channels.items()}, "thin", record.meta)
    findings = [f for f in check([thin]).findings if f.cause == "time_stamps"]
    assert any(f.standing for f in findings) == stands
    assert stands or any("rows are missing" in f.evidence and f.material for f in findings)
