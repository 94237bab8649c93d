"""Simulation and identification from Python."""

from dataclasses import replace

import numpy as np
import pytest

import helmbench
from helmbench.datasets.columns import in_order
from helmbench.estimation.results.fit import Fit
from helmbench.methods.base import Method


@pytest.fixture
def record():
    return helmbench.simulate("response-1", "zigzag:20/20", noise="low")


@pytest.fixture
def other():
    return helmbench.simulate("response-1", "zigzag:10/10:port", noise="low", seed=1)


def test_simulate_is_generate_for_a_vessel(record):
    case = helmbench.Case("mariner", "zigzag:20/20", "low", "current:1@90", 3, 60.0, 0.5)
    given = {"noise": "low", "disturbance": "current:1@90", "seed": 3, "duration_s": 60.0, "dt_s": 0.5}
    assert helmbench.simulate("mariner", "zigzag:20/20", **given).equals(helmbench.generate(case))
    assert helmbench.simulate(helmbench.resolve("response-1"), "zigzag:20/20", noise="low").equals(record)


def test_an_identified_model_is_simulated(record, other):
    estimate = helmbench.identify(record, "nomoto-1-cubic", "output-error")
    assert estimate.parameters == pytest.approx(helmbench.resolve("response-1").parameters, rel=0.02)
    again = helmbench.simulate(estimate.model, "zigzag:10/10", duration_s=100.0, dt_s=0.5)
    assert again.n == 201
    with pytest.raises(helmbench.BadInput, match="no coefficients"):
        helmbench.simulate("nomoto-1", "turn:20")


def test_one_record_several_or_files(record, other, tmp_path):
    for name, one in (("one", record), ("two", other)):
        helmbench.write_record(one, tmp_path / f"{name}.csv")
    alone = helmbench.identify(record, "nomoto-1-cubic", "ls")
    assert helmbench.identify([record], "nomoto-1-cubic", helmbench.make_method("ls")).parameters == alone.parameters
    assert helmbench.identify(tmp_path / "one.csv", "nomoto-1-cubic", "ls").parameters == alone.parameters
    assert helmbench.make_method("ls").fit(record, helmbench.resolve("nomoto-1-cubic")).parameters == alone.parameters
    both = helmbench.identify([record, other], "nomoto-1-cubic", "ls")
    mixed = helmbench.identify([record, str(tmp_path / "two.csv")], "nomoto-1-cubic", "ls")
    assert both.parameters == mixed.parameters != alone.parameters


def test_records_are_turned_to_the_models_rudder():
    record = helmbench.simulate("mariner", "zigzag:20/20")
    assert record.meta.positive_rudder == "port"
    assert helmbench.identify(record, "nomoto-1", "ls").parameters["K"] > 0


def test_a_contradicting_rudder_sign_is_a_warning(record):
    side = "starboard" if record.meta.positive_rudder == "port" else "port"
    wrong = replace(record, meta=replace(record.meta, positive_rudder=side))
    with pytest.warns(helmbench.RudderSignWarning, match="rudder_sign"):
        helmbench.identify(wrong, "nomoto-1", "ls")
    model = helmbench.resolve("nomoto-1")
    assert helmbench.rudder_sign_doubt(wrong, model) and helmbench.rudder_sign_doubt(record, model) is None


def test_what_cannot_be_fitted_is_said():
    record = helmbench.simulate("mariner", "zigzag:20/20").with_channels(surge_m_s=None, sway_m_s=None)
    with pytest.raises(helmbench.CannotFit, match="surge_m_s"):
        helmbench.identify(record, "mariner", "ls")
    with pytest.raises(helmbench.BadInput, match="unknown method"):
        helmbench.identify(record, "mariner", "best")
    with pytest.raises(helmbench.BadInput, match=r"none\.csv"):
        helmbench.identify("none.csv", "mariner", "ls")


def test_an_estimate_without_finite_real_parameters_is_a_failed_fit(record):
    class Oscillating(Method):
        name = "oscillating"

        def estimate(self, records, model):
            return Fit(np.array([-0.1, -0.1, 0.01, 0.01]))  # s^2 + .1 s + .1 has no real roots

    with pytest.raises(helmbench.FitFailed, match="T1, T2: no finite real value"):
        helmbench.identify(record, "nomoto-2", Oscillating())


def test_a_record_shows_itself(record):
    assert repr(record) == (
        f"<Record 'response-1 zigzag:20/20': {record.n} samples, 0 to {record.time_s[-1]:g} s every {record.dt:g} s; "
        f"{', '.join(in_order(record.channels))}>"
    )
    table = record._repr_html_()
    assert table.count("<tr>") == 1 + len(record.channels) and "yaw rate" in table and "deg/s" in table
    assert "&lt;b&gt;" in replace(record, name="<b>")._repr_html_()
