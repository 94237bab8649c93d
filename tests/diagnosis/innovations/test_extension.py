"""The extended model holds what was fitted: coefficients of extensions, instruments, nothing else."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.innovations.as_model import extended_model
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import model_to_json, resolve


@pytest.fixture(scope="module")
def est():
    records = [generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=100.0)) for seed in range(2)]
    return estimator(resolve("mariner"), records)


def test_without_causes_it_is_the_base_model(est):
    model = extended_model(est, est.start(), [])
    assert (model.id, model.family, dict(model.instruments)) == ("mariner", "abkowitz", {})
    assert np.array_equal(model.coefficients, est.model.coefficients)


def test_a_force_is_a_coefficient_and_a_sensor_an_instrument(est, tmp_path):
    s = est.with_entries(est.start(), {"rudder_effectiveness": -0.2, "yaw_rate_scale": 0.03, "rudder_delay": 0.4})
    causes = [cause_of(name) for name in ("rudder_effectiveness", "yaw_rate_scale", "rudder_delay")]
    model = extended_model(est, s, causes)
    assert model.id == "mariner+rudder_effectiveness+yaw_rate_scale+rudder_delay"
    assert model.family == "abkowitz+rudder_effectiveness"
    assert model.coefficients[-1] == pytest.approx(-0.2)
    assert dict(model.instruments) == pytest.approx({"yaw_rate_scale": 0.03, "rudder_delay": 0.4})
    model_to_json(model, tmp_path / "model.json")
    again = resolve(tmp_path / "model.json")
    assert np.array_equal(again.coefficients, model.coefficients) and again.instruments == model.instruments


def test_a_quantity_of_each_record_enters_as_its_mean(est):
    (north, *_) = cause_of("current").variants(est)[-1]
    s = est.start()
    for record, value in ((0, 0.2), (1, 0.6)):
        p = next(p for p in cause_of("current").variants(est)[-1] if p.record == record and p.slots == north.slots)
        s = est.at(s, p, value)
    model = extended_model(est, s, [cause_of("current")])
    assert model.parameters["current_towards_north"] == pytest.approx(0.4)


def test_corrections_made_before_the_filter_are_kept(est):
    model = extended_model(est, est.start(), [], {"heading_bias": 0.02})
    assert dict(model.instruments) == {"heading_bias": 0.02}
