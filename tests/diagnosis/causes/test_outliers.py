"""Samples that cannot be are taken out before any stage compares channels."""

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.base import cleaned
from helmbench.checks.files.outliers import ImpossibleSamples
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import resolve


def spoiled(record, rng, value):
    """One sample of heading and of yaw rate that no ship has."""
    channels = {}
    for name in ("heading_rad", "yaw_rate_rad_s"):
        channels[name] = record.column(name).copy()
        channels[name][int(rng.integers(record.n))] = value
    return record.with_channels(**channels)


@pytest.mark.parametrize("value", [1e9, -1e300])
def test_single_huge_samples_become_gaps_and_are_told(value, rng):
    records = [spoiled(r, rng, value) for r in inject(FaultCase("response-1", ()), rng).train]
    for before in records:
        faults = ImpossibleSamples().find(before)
        after = cleaned(before, faults)
        assert sorted(f.channels for f in faults) == [("heading_rad",), ("yaw_rate_rad_s",)]
        for name in ("heading_rad", "yaw_rate_rad_s"):
            kept = np.isfinite(after.column(name))
            assert kept.sum() == before.n - 1
            assert np.array_equal(after.column(name)[kept], before.column(name)[kept])


def test_no_scale_is_named_for_a_single_huge_sample(rng):
    records = [spoiled(r, rng, 1e9) for r in inject(FaultCase("response-1", ()), rng).train]
    found = diagnose(resolve("response-1"), records)
    print(found.verdict, found.causes)
    assert {f.cause for f in found.causes if f.stage == "kinematics"} == {"impossible_samples"}


def test_clean_records_are_left_as_they_are(rng):
    records = list(inject(FaultCase("response-1", ()), rng).train)
    assert [f for r in records for f in ImpossibleSamples().find(r)] == []
