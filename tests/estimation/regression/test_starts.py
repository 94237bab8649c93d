"""Starting values: several forms of least squares, none of them the truth."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.regression.starts import starts_of
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve


def test_starts_do_not_depend_on_the_true_coefficients():
    model = resolve("cargo")
    records = [generate(Case("cargo", "zigzag:20/20", "low", seed=3, duration_s=600.0))]
    blank, known = starts_of(records, model.blanked()), starts_of(records, model)
    assert len(blank) > 4
    assert all(np.array_equal(a.coefficients, b.coefficients) for a, b in zip(blank, known, strict=True))


def test_a_filtered_start_is_near_where_differences_are_not(rng):
    """A noisy heading alone: the third difference is noise, the state-variable filter is not."""
    model = resolve("cargo")
    record = generate(Case("cargo", "zigzag:20/20", duration_s=1200.0)).with_channels(yaw_rate_rad_s=None)
    noisy = record.with_channels(heading_rad=record.column("heading_rad") + 1e-3 * rng.normal(size=record.n))
    starts = [start.coefficients for start in starts_of([noisy], model.blanked())]
    error = [np.abs(c / model.coefficients - 1.0).max() for c in starts]
    print(error)
    assert error[0] > 0.5 and min(error[-3:]) < 0.5 * error[0]


def test_records_without_motion_give_no_start():
    model = resolve("cargo")
    record = generate(Case("cargo", "zigzag:20/20", duration_s=100.0))
    with pytest.raises(CannotFit):
        starts_of([record.with_channels(yaw_rate_rad_s=None, heading_rad=None)], model)
