"""Two columns under each other's names, with gaps in one of them."""

import numpy as np

from helmbench.checks.check import check, examine
from helmbench.datasets.generator import Case, generate


def test_an_exchange_leaves_no_samples_out(seed):
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = np.where(np.arange(record.n) % 9 == 0, np.nan, record.column("yaw_rate_rad_s"))
    swapped = record.with_channels(heading_rad=rate, yaw_rate_rad_s=record.heading_unwrapped())
    (found,) = (f for f in check([swapped]).findings if f.cause == "channel_swap")
    assert found.channels == ("heading_rad", "yaw_rate_rad_s") and found.corrected and found.blanked == 0


def test_a_yaw_rate_that_is_another_quantity_is_left_out(seed):
    """A roll rate under the name: a roll that follows the turn, and its slope."""
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = record.column("yaw_rate_rad_s")
    roll = np.gradient(np.convolve(rate, np.ones(5) / 5.0, mode="same"), record.time_s)
    (found,) = (f for f in check([record.with_channels(yaw_rate_rad_s=roll)]).findings if f.cause == "channel_swap")
    assert found.channels == ("yaw_rate_rad_s",) and "another quantity" in found.evidence
    assert not examine([record.with_channels(yaw_rate_rad_s=roll)]).records[0].has("yaw_rate_rad_s")


def test_a_late_or_biased_yaw_rate_is_one(seed):
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = record.column("yaw_rate_rad_s")
    step = round(8.0 / record.dt)
    for other in (rate + 0.02, 0.2 * rate, -rate, np.roll(rate, step)):
        found = check([record.with_channels(yaw_rate_rad_s=other)]).findings
        assert not any("another quantity" in f.evidence for f in found)
