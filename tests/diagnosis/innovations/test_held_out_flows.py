"""What belongs to a held-out record is estimated on its first part."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.innovations.as_model import adapted, transferred
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import resolve


def test_what_belongs_to_a_record_is_estimated_anew():
    """A current in the held-out records comes out of their first part."""
    model, manoeuvres = resolve("mariner"), ("zigzag:20/20", "turn:25")
    est = estimator(model, [generate(Case("mariner", text, duration_s=200.0)) for text in manoeuvres])
    current = cause_of("current").variants(est)[-1]
    drifting = est.with_entries(est.start(), {"current_towards_north": 0.5, "current_towards_east": -0.3})
    records = [generate(Case("mariner", text, "low", seed=3, duration_s=300.0)) for text in manoeuvres]
    held = estimator(model, [r.with_channels(**_moved(r, 0.5, -0.3)) for r in records])
    setting = adapted(held, transferred(held, est.start(), current), current)
    index = [held.index["current_towards_north"], held.index["current_towards_east"]]
    assert setting.vectors[:, index] == pytest.approx(drifting.vectors[:, index], abs=0.05)


def _moved(record, north, east):
    """Channels of the record in a steady current: velocities over ground and positions."""
    psi, t = record.heading_unwrapped(), record.time_s - record.time_s[0]
    return {
        "surge_m_s": record.column("surge_m_s") + north * np.cos(psi) + east * np.sin(psi),
        "sway_m_s": record.column("sway_m_s") - north * np.sin(psi) + east * np.cos(psi),
        "north_m": record.column("north_m") + north * t,
        "east_m": record.column("east_m") + east * t,
    }
