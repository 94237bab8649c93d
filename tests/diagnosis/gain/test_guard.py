"""When an extended model predicts held-out records worse: positions are one distance, beyond what counts as none."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.checks.result import Size
from helmbench.diagnosis.gain.guard import worsens
from helmbench.diagnosis.result import Finding, Gain, Trace

WAY_M = 2000.0


def of_errors(diagnosis_of, **errors):
    """A diagnosis of one held-out run on a course to the north-east; errors : channel -> before and after, SI."""
    time = np.linspace(0.0, 300.0, 301)
    track = {name: WAY_M / np.sqrt(2.0) * time / time[-1] for name in ("north_m", "east_m")}
    trace = Trace("run", "held_out", time, np.zeros_like(time), track, track, track)
    gains = {c: Gain(old, new, 1.0, 1.0, 0.0, 0.0, 0.0, old, new) for c, (old, new) in errors.items()}
    return replace(diagnosis_of(), gain=gains, traces=(trace,))


def test_one_axis_of_the_position_may_grow_where_the_distance_falls(diagnosis_of):
    said = of_errors(diagnosis_of, heading_rad=(0.1, 0.05), north_m=(20.0, 25.0), east_m=(60.0, 40.0))
    assert not worsens(said)
    assert worsens(
        replace(said, gain=said.gain | {"north_m": replace(said.gain["north_m"], rmse_after=80.0, own_after=80.0)})
    )


@pytest.mark.parametrize(("after_m", "worse"), [(4.5, False), (6.0, True)])
def test_a_position_within_what_a_perfect_speed_leaves_is_no_worse(diagnosis_of, after_m, worse):
    """A speed to .25 % is a position to 5 m after 2 km."""
    said = of_errors(diagnosis_of, heading_rad=(0.1, 0.05), north_m=(1.0, after_m), east_m=(0.1, 0.1))
    assert worsens(said) == worse


def test_other_channels_are_judged_each_by_itself(diagnosis_of):
    assert worsens(of_errors(diagnosis_of, heading_rad=(0.1, 0.095), surge_m_s=(0.1, 0.11)))


@pytest.mark.parametrize(("after_m_s", "worse"), [(0.13, False), (0.16, True)])
def test_a_channel_that_is_a_little_worse_is_outweighed_by_motion_that_is_clearly_better(
    diagnosis_of, after_m_s, worse
):
    said = of_errors(diagnosis_of, heading_rad=(0.1, 0.02), yaw_rate_rad_s=(0.01, 0.006), surge_m_s=(0.1, after_m_s))
    assert worsens(said) and worsens(said, outweighed=True) == worse


@pytest.mark.parametrize(("blind", "worse"), [(0.12, False), (0.2, True)])
def test_neutral_angles_of_single_records_may_leave_others_as_they_are_but_not_far_worse(diagnosis_of, blind, worse):
    """Where numbers of the hull hold the opposite of the angles, a record without one goes astray."""
    sizes = tuple(Size("delta0", x, x - 0.005, x + 0.005, "rad", name) for name, x in (("a", 0.03), ("b", 0.04)))
    said = of_errors(diagnosis_of, heading_rad=(0.1, blind))
    own = {"heading_rad": replace(said.gain["heading_rad"], own_after=0.05)}
    angles = Finding("rudder_offset", (), "free runs", 3.0, 0.01, sizes)
    assert worsens(replace(said, gain=own, causes=(angles,))) == worse
