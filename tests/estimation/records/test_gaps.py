"""Where records are cut into runs: long gaps of rows or rudder, splices of positions and heading."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.spikes import without_spikes_in_time
from helmbench.estimation.records.gaps import splices, stretches, unbroken
from helmbench.models.model import resolve


@pytest.fixture
def record():
    return generate(Case("mariner", "zigzag:20/20", "medium", duration_s=300.0, dt_s=1.0))


def rows(record, kept):
    return replace(record, time_s=record.time_s[kept], channels={k: v[kept] for k, v in record.channels.items()})


def moved(record, first, step, *names):
    after = np.arange(record.n) >= first
    return record.with_channels(**{name: record.column(name) + step * after for name in names})


def test_an_unbroken_record_stays_as_it_is(record):
    assert stretches(record, 1.0) == [(0, record.n)] and splices(record) == []
    (same,) = unbroken([record], resolve("mariner"))
    assert same.equals(record)


@pytest.mark.parametrize(("missing", "parts"), [(3, 1), (10, 2), (100, 2)])
def test_rows_missing_for_long_cut_a_record(record, missing, parts):
    kept = np.r_[0:100, 100 + missing : record.n]
    assert len(unbroken([rows(record, kept)], resolve("mariner"))) == parts


@pytest.mark.parametrize(("names", "step"), [(("north_m",), 500.0), (("east_m",), -300.0), (("heading_rad",), 1.0)])
def test_a_jump_that_stays_is_a_splice(record, names, step):
    assert splices(moved(record, 120, step, *names)) == [120]
    assert stretches(moved(record, 120, step, *names), 1.0) == [(0, 120), (120, record.n)]


def test_a_single_gross_error_and_a_turn_of_the_compass_are_no_splices(record):
    spike = np.where(np.arange(record.n) == 120, 1e9, 0.0)
    assert splices(record.with_channels(north_m=record.column("north_m") + spike)) == []
    assert splices(record.with_channels(heading_rad=np.mod(record.column("heading_rad"), 2.0 * np.pi))) == []


def test_rows_that_a_logger_left_out_are_no_gross_errors(record):
    kept = np.delete(np.arange(record.n), [50, 51, 130, 200, 201, 202])
    values, found, _ = without_spikes_in_time(record.column("heading_rad")[kept], record.time_s[kept])
    assert found == 0 and np.array_equal(values, record.column("heading_rad")[kept])
    spoilt = record.column("heading_rad")[kept] + np.where(np.arange(kept.size) == 90, 1.0, 0.0)
    assert np.flatnonzero(np.isnan(without_spikes_in_time(spoilt, record.time_s[kept])[0])).tolist() == [90]
