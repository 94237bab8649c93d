"""Two columns under each other's names, with gaps in one of them."""

import numpy as np

from helmbench.checks.check import check
from helmbench.datasets.generator import Case, generate


def test_an_exchange_leaves_no_samples_out(seed):
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = np.where(np.arange(record.n) % 9 == 0, np.nan, record.column("yaw_rate_rad_s"))
    swapped = record.with_channels(heading_rad=rate, yaw_rate_rad_s=record.heading_unwrapped())
    (found,) = (f for f in check([swapped]).findings if f.cause == "channel_swap")
    assert found.channels == ("heading_rad", "yaw_rate_rad_s") and found.corrected and found.blanked == 0
