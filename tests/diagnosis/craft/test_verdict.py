"""What is said of a model that was built is said of channels that are measured and vary."""

from types import SimpleNamespace

import numpy as np
import pytest

from helmbench.diagnosis.craft.ladder import Steering
from helmbench.diagnosis.craft.result import ADEQUATE, BUILT, PARTLY, UNEXPLAINED
from helmbench.diagnosis.craft.verdict import r2, verdict_of
from helmbench.estimation.validation.horizons import STRAIGHT, TRUSTED, TURNS_ON, trusted_s
from helmbench.estimation.validation.result import ErrorScore


def left_out(motion, errors):
    """What is asked of an attempt: the motion in windows of 10 s, and their errors by fits without them."""
    windows = SimpleNamespace(motion=np.array(motion), length_s=10.0)
    return SimpleNamespace(problem=SimpleNamespace(windows=windows), left_out=errors)


@pytest.mark.parametrize("dead", [0.0, np.nan])
def test_nothing_is_said_of_a_channel_that_is_dead(dead):
    attempt = left_out([dead, 0.2], np.stack([np.full((8, 10), dead), np.full((8, 10), 0.02)], axis=-1))
    ahead = SimpleNamespace(trusted_s={BUILT: 30.0}, horizons_s=(), score=lambda *_, **__: None)
    assert np.isnan(r2(attempt)[0]) and r2(attempt)[1] == pytest.approx(0.99)
    said = (ADEQUATE, "in left-out windows of 10 s the model explains 99 % of the change of heading")
    assert verdict_of(attempt, Steering(0.9, 0.01, 0.9, 0.01, 0.95), ahead, 0.0, 5.0) == said


def scored(model, rmse, time):
    return [ErrorScore(model, None, channel, f"{time:g} s", time, 100, rmse, 0.5) for channel in TRUSTED]


@pytest.mark.parametrize(
    ("first", "trusted", "verdict"), [(1.01, 20.0, ADEQUATE), (1.3, 0.0, PARTLY)], ids=["tie", "clearly worse"]
)
def test_a_tie_at_the_first_time_ahead_is_no_failure(first, trusted, verdict):
    """Beside predictions without a model that have an error of one at every time ahead."""
    times = (5.0, 10.0, 20.0)
    simple = [s for name in (TURNS_ON, STRAIGHT) for time in times for s in scored(name, 1.0, time)]
    own = [s for time, rmse in zip(times, (first, 0.7, 0.5), strict=True) for s in scored(BUILT, rmse, time)]
    assert trusted_s(own, simple, BUILT) == trusted
    attempt = left_out([0.2, 0.2], np.full((8, 10, 2), 0.02))
    ahead = SimpleNamespace(
        trusted_s={BUILT: trusted}, horizons_s=(), score=lambda *_, **__: None, scores=own, simple=simple
    )
    told = verdict_of(attempt, Steering(0.9, 0.01, 0.9, 0.01, 0.95), ahead, 0.0, 5.0)
    assert told[0] == verdict and (trusted > 0.0 or "from 10 s ahead on" in told[1])


@pytest.mark.parametrize(("skill", "verdict"), [(0.6, ADEQUATE), (0.1, UNEXPLAINED)])
def test_a_fall_of_two_and_a_half_errors_is_enough_where_the_yaw_rate_shows_the_command(skill, verdict):
    attempt = left_out([0.2, 0.2], np.full((8, 10, 2), 0.02))
    ahead = SimpleNamespace(trusted_s={BUILT: 30.0}, horizons_s=(), score=lambda *_, **__: None)
    assert verdict_of(attempt, Steering(0.6, 0.24, skill, 0.1, 0.5), ahead, 0.0, 5.0)[0] == verdict
