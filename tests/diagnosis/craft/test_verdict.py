"""What is said of a model that was built is said of channels that are measured and vary."""

from types import SimpleNamespace

import numpy as np
import pytest

from helmbench.diagnosis.craft.ladder import Steering
from helmbench.diagnosis.craft.result import ADEQUATE, BUILT
from helmbench.diagnosis.craft.verdict import r2, verdict_of


@pytest.mark.parametrize("dead", [0.0, np.nan])
def test_nothing_is_said_of_a_channel_that_is_dead(dead):
    windows = SimpleNamespace(inputs=np.zeros((4, 11, 1)), motion=np.array([dead, 0.2]), dt=1.0)
    errors = np.stack([np.full((8, 10), dead), np.full((8, 10), 0.02)], axis=-1)
    attempt = SimpleNamespace(fitted=SimpleNamespace(windows=windows), errors=errors)
    ahead = SimpleNamespace(trusted_s={BUILT: 30.0}, horizons_s=(), score=lambda *_, **__: None)
    assert np.isnan(r2(attempt)[0]) and r2(attempt)[1] == pytest.approx(0.99)
    said = (ADEQUATE, "over 10 s of left-out windows it explains 99 % of the change of heading; trust it for 30 s")
    assert verdict_of(attempt, Steering(0.9, 0.01, 0.9, 0.01), ahead, 0.0, 5.0) == said
