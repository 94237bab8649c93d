"""A resolution matters where it is a sizeable part of the motion."""

import numpy as np
import pytest

from helmbench.checks.check import check
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record

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


def test_a_heading_in_whole_degrees_does_not_make_the_rate(rng):
    """A bridge log: whole degrees, and a rate in half degrees a second, which are often equal by chance."""
    time = np.arange(0.0, 400.0)
    rate = np.deg2rad(1.5) * np.sin(0.07 * time) + 5e-4 * rng.standard_normal(time.size)
    heading = np.cumsum(rate) + 1e-3 * rng.standard_normal(time.size)
    coarse = {"heading_rad": np.deg2rad(np.round(np.rad2deg(heading))),
              "yaw_rate_rad_s": np.deg2rad(0.5 * np.round(2.0 * np.rad2deg(rate)))}  # fmt: skip
    causes = {f.cause for f in check([Record(time, coarse, "log")]).findings if f.material}
    assert "coarse_channel" in causes and "derived_channel" not in causes
