"""The time of one ship length, by which free runs are scaled."""

from dataclasses import replace

import pytest

from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve
from helmbench.models.time_scale import time_scale_s


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "cargo"])
def test_a_response_model_scales_by_its_own_turning(vessel):
    """K' and T' of ships are near one."""
    assert 0.3 < time_scale_s(resolve(vessel)) / {"response-1": 5.8, "response-2": 5.8, "cargo": 21.0}[vessel] < 3.0


def test_a_model_without_length_or_speed_is_refused():
    for model in (replace(resolve("kvlcc2-l7"), speed_m_s=float("nan")), resolve("nomoto-1")):
        with pytest.raises(CannotFit, match="no length and speed"):
            time_scale_s(model)
