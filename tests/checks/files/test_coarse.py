"""A resolution matters where it is a sizeable part of the motion."""

import numpy as np
import pytest

from helmbench.checks.check import check
from helmbench.datasets.generator import Case, generate

KNOT = 1852.0 / 3600.0


@pytest.mark.parametrize(
    ("name", "step", "matters"),
    [
        ("surge_m_s", 0.1 * KNOT, False),
        ("yaw_rate_rad_s", np.deg2rad(0.02), False),
        ("heading_rad", np.deg2rad(1.0), False),
        ("sway_m_s", 0.5 * KNOT, True),
        ("yaw_rate_rad_s", np.deg2rad(0.3), True),
        ("heading_rad", np.deg2rad(10.0), True),
    ],
)
def test_steps_matter_where_they_are_a_sizeable_part_of_the_motion(name, step, matters, seed):
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=600.0, dt_s=1.0))
    stored = step * np.round(record.continuous(name) / step)
    (found,) = (f for f in check([record.with_channels(**{name: stored})]).findings if f.cause == "coarse_channel")
    assert found.material is matters and found.sizes[0].value == pytest.approx(step)
