"""Gross errors that stand beside each other, at the ends of a record, and across a turn of the compass."""

import numpy as np
import pytest

from helmbench.datasets.geometry import unwrapped
from helmbench.datasets.spikes import without_spikes

NOISE = 1e-3


def swinging(rng, n=240):
    """A heading (N,), rad, that swings by half a radian, with noise."""
    return 0.5 * np.sin(2.0 * np.pi * np.arange(n) / 120.0 + rng.uniform(0.0, 6.0)) + NOISE * rng.standard_normal(n)


@pytest.mark.parametrize(
    "places",
    [[112, 114], [111, 114], [112, 113], [2], [1], [0], [237], [239], [3, 100, 102, 236], [60, 62, 64]],
    ids=str,
)
def test_gross_errors_are_found_and_hardly_others(places, rng):
    """One other sample in .3 % of 20,000 draws, never two."""
    values = swinging(rng)
    values[places] += rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 9.0, len(places))
    kept, count, _ = without_spikes(values)
    found = set(np.flatnonzero(np.isnan(kept)).tolist())
    assert found >= set(places) and len(found) == count <= len(places) + 2


def test_sound_swings_have_none(rng):
    kept, count, _ = without_spikes(swinging(rng))
    assert count <= 2 and np.isnan(kept).sum() == count


@pytest.mark.parametrize("errors", [(2.1, -2.1), (-2.0, 2.2), (3.1,), (-3.13,)], ids=str)
def test_a_gross_error_of_a_heading_leaves_no_full_turn_behind(errors, rng):
    true = swinging(rng)
    given = true.copy()
    given[100 : 100 + len(errors)] += errors
    turned = (unwrapped(np.mod(given, 2.0 * np.pi)) - true)[[*range(100), *range(100 + len(errors), true.size)]]
    assert np.allclose(turned, turned[0])


def test_a_fast_turn_stays_one():
    """Half a circle from sample to sample and back is no gross error."""
    true = np.cumsum(np.concatenate([np.full(20, 1.2), np.full(20, 2.0), np.full(20, -1.5)]))
    found = unwrapped(np.mod(true, 2.0 * np.pi))
    assert np.allclose(found - found[0], true - true[0])


@pytest.mark.parametrize("count", range(5))
def test_headings_of_few_samples_are_unwrapped(count):
    assert unwrapped(np.array([3.0, -3.0, 3.0, -3.0, 3.0])[:count]) == pytest.approx(
        np.array([3.0, 2.0 * np.pi - 3.0, 3.0, 2.0 * np.pi - 3.0, 3.0])[:count]
    )
