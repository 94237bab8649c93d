"""Free runs of the Esso Osaka vessel from rest against measured zigzags that took no part in its identification."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.instruments import corrected
from helmbench.datasets.measured import data_dir, load
from helmbench.models.model import resolve

from ...support.free_runs import blind_errors, whole_runs

pytestmark = pytest.mark.skipif(
    not (data_dir() / "esso_osaka").exists(), reason="measured data are not here: helmbench fetch esso-osaka"
)
HELD_OUT = ("zigzag_31-Jul-2020_13_57_45", "zigzag_31-Jul-2020_14_10_05")
LATE = dict.fromkeys(("surge_delay", "sway_delay", "yaw_rate_delay", "heading_delay"), 0.93)


def held_out_r2(model):
    """R^2 of u, v, r, psi over both records, free runs from the first samples."""
    runs = whole_runs(model, [corrected(load("esso-osaka", stem), LATE) for stem in HELD_OUT])
    motion = [m - np.nanmean(m, axis=0) for m in runs.measured]
    return 1.0 - blind_errors(runs) ** 2 / np.nanmean(np.concatenate(motion) ** 2, axis=0)


def test_held_out_zigzags_from_rest_are_predicted():
    u, v, r, _ = held_out_r2(resolve("esso-osaka-l3"))
    assert u > 0.9 and r > 0.9 and v > 0.75


def test_the_measured_wind_is_needed():
    vessel = resolve("esso-osaka-l3")
    calm, windy = held_out_r2(replace(vessel, windage=None)), held_out_r2(vessel)
    assert np.all(windy[1:] > calm[1:])
