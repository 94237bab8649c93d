"""Runs that are restarted at the measurements."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.iv import restarted_run
from helmbench.models.model import resolve


def test_simulated_record_is_the_run_and_keeps_gaps():
    model = resolve("kvlcc2-l7")
    record = generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=60, dt_s=0.2))
    sway = record.column("sway_m_s").copy()
    sway[50:60] = np.nan
    run = restarted_run(record.with_channels(sway_m_s=sway), model)
    assert np.isnan(run.column("sway_m_s")[50:60]).all()
    for name in ("surge_m_s", "yaw_rate_rad_s", "heading_rad"):
        assert run.column(name) == pytest.approx(record.column(name), abs=1e-9)


def test_a_run_far_from_the_record_is_restarted():
    """With an unstable estimate the instruments stay finite and near the record."""
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20"))
    run = restarted_run(record, model.with_coefficients([5.0, 5.0, 100.0]))
    assert np.isfinite(run.column("yaw_rate_rad_s")).all()
    assert np.abs(run.column("yaw_rate_rad_s")).max() < 20.0 * np.abs(record.column("yaw_rate_rad_s")).max()
