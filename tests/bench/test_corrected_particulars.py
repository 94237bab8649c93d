"""Situations by the simulation of a ship's particulars: what is compared with what, and that records correct it."""

import math

import numpy as np
import pytest

from helmbench.bench import corrected_particulars
from helmbench.bench.kinds.identification.problems import Task, problem
from helmbench.bench.situations import SEEDS, Situation
from helmbench.estimation.run.prediction import prediction_scores
from helmbench.methods.registry import make
from helmbench.models.model import resolve

TANKER = Situation("esso-osaka-l3", "nomoto-1", ("zigzag:20/20",), ("zigzag:10/10",), "low", "none", "zigzag:15/15")


def error_of(scores):
    """Mean of sqrt(1 - R2) of heading and yaw rate."""
    return np.mean([math.sqrt(1.0 - scores[f"r2_free_{name}"]) for name in ("heading_rad", "yaw_rate_rad_s")])


def task_of(seed):
    return Task("esso-osaka-l3", "nomoto-1", "nomoto-1", TANKER.train, TANKER.held_out, "low", seed=seed)


def test_of_a_ship_with_too_few_particulars_nothing_is_told():
    one = Situation("mariner", "nomoto-1", ("zigzag:20/20",), ("turn:20",), "low", "none", "turn:30")
    assert corrected_particulars.errors_of(one) is None


def test_the_error_is_that_of_heading_and_yaw_rate_of_each_draw_of_the_noise(monkeypatch):
    """With a correction that does nothing: that of the simulation itself, and infinite where it diverges."""
    seen = []
    monkeypatch.setattr(
        corrected_particulars, "corrected_particulars", lambda ship, train: (seen.append(train) or ship, [])
    )
    found = corrected_particulars.errors_of(TANKER)
    simulation = corrected_particulars.simulation_of("esso-osaka-l3")
    known = error_of(prediction_scores(simulation, problem(task_of(0)).held_out))
    assert found == pytest.approx([known] * SEEDS, rel=1e-6)
    drawn = [train[0].column("yaw_rate_rad_s") for train in seen]
    assert len(drawn) == SEEDS and not np.array_equal(drawn[0], drawn[1])
    lost = simulation.with_coefficients(simulation.coefficients * 1e6)
    monkeypatch.setattr(corrected_particulars, "corrected_particulars", lambda ship, train: (lost, []))
    assert corrected_particulars.errors_of(TANKER) == [math.inf] * SEEDS


@pytest.mark.nightly
def test_records_correct_the_simulation_beyond_what_a_response_model_can_follow(monkeypatch):
    monkeypatch.setattr(corrected_particulars, "SEEDS", 1)
    records = problem(task_of(0))
    simple = make("output-error").fit(list(records.train), resolve("nomoto-1"))
    response = error_of(prediction_scores(simple.model, records.held_out))
    assert corrected_particulars.errors_of(TANKER)[0] < 0.5 * response
