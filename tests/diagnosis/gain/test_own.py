"""Runs with a record's own neutral rudder angle and start."""

import numpy as np
import pytest

from helmbench.diagnosis.gain.runs import own_run
from helmbench.estimation.run.run import run_along
from helmbench.estimation.run.stretch import Stretch
from helmbench.models.model import resolve

from ...made_up.records import errors_of, long_zigzag


@pytest.fixture(scope="module")
def ship():
    return resolve("mariner")


@pytest.fixture(scope="module")
def record():
    return long_zigzag()


def test_a_neutral_angle_of_the_record_is_its_own(ship, record):
    """Half a degree of trim turns a model's heading away; with an angle of the record's own nothing is left of it."""
    trimmed = record.with_channels(rudder_rad=record.column("rudder_rad") + np.deg2rad(0.5))
    exact, blind, own = (
        errors_of(run_along(ship, one, by=by))
        for one, by in ((record, own_run), (trimmed, Stretch.free_run), (trimmed, own_run))
    )
    assert blind["heading_rad"] > 20.0 * exact["heading_rad"]
    assert own["heading_rad"] < 2.0 * exact["heading_rad"]


def test_a_wrong_model_is_not_excused_by_the_records_own_start(ship, record):
    wrong = ship.with_coefficients(ship.coefficients * np.where(np.array(ship.coordinates) == "Nd", 0.8, 1.0))
    blind, own = (errors_of(run_along(wrong, record, by=by))["yaw_rate_rad_s"] for by in (Stretch.free_run, own_run))
    assert own > 0.7 * blind > 5.0 * errors_of(run_along(ship, record))["yaw_rate_rad_s"]
