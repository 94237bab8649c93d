"""The stages of a diagnosis are told as they begin."""

from types import SimpleNamespace

import numpy as np
import pytest

import helmbench
from helmbench.diagnosis import diagnose as engine
from helmbench.diagnosis import prepared
from helmbench.diagnosis.options import Options
from helmbench.models.errors import CannotFit


@pytest.fixture
def record():
    return helmbench.simulate("response-1", "zigzag:20/20", noise="low", seed=1)


@pytest.mark.parametrize(
    ("coefficient_sd", "stages"),
    [(None, [engine.CHECKS, engine.PIECES, engine.REST]), (0.0, [engine.CHECKS, engine.CAUSES, engine.REST])],
)
def test_each_stage_is_told(monkeypatch, record, diagnosis_of, coefficient_sd, stages):
    made, told = diagnosis_of(), []
    monkeypatch.setattr(engine, "by_pieces", lambda *_: SimpleNamespace(diagnosis=made, nearly=None))
    monkeypatch.setattr(engine, "by_innovations", lambda *_: made)
    options = Options(coefficient_sd=coefficient_sd)
    engine.diagnose(helmbench.resolve("response-1"), [record], options=options, watch=told.append)
    assert told == stages


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("singular"), CannotFit("no piece"), helmbench.BadInput("g")])
def test_where_pieces_cannot_be_run_the_likelihood_decides(monkeypatch, record, error):
    def fails(*_):
        raise error

    monkeypatch.setattr(engine, "by_pieces", fails)
    said = engine.diagnose(helmbench.resolve("response-1"), [record])
    assert said.verdict == "adequate"
    assert "by the innovations of a filter, without free runs of left-out pieces: " in said.reason
    assert said.reason.endswith(str(error))


@pytest.mark.parametrize("base_parameters", ["file", "identify"])
def test_records_too_long_for_one_diagnosis_are_refused_before_it_starts(monkeypatch, record, base_parameters):
    monkeypatch.setattr(prepared, "LARGEST", 10**6)
    told, options = [], Options(base_parameters=base_parameters)
    with pytest.raises(helmbench.BadInput, match="samples of 1 record are too many for one diagnosis"):
        engine.diagnose(helmbench.resolve("response-1"), [record], (), options, told.append)
    assert told == [engine.CHECKS]


def test_a_log_too_long_for_one_record_is_refused_and_the_same_samples_in_two_are_not(monkeypatch, record):
    monkeypatch.setattr(prepared, "LONGEST_OF_RESPONSE", record.n - 1)
    with pytest.raises(helmbench.BadInput, match="too many for one record of a diagnosis; cut out the manoeuvres"):
        engine.diagnose(helmbench.resolve("response-1"), [record])
    halves = [record.slice(0, record.n // 2), record.slice(record.n // 2, record.n)]
    assert engine.diagnose(helmbench.resolve("response-1"), halves).verdict in ("adequate", "inconclusive")


def test_a_function_is_told_every_stage_from_the_reading_on(record):
    told = []
    helmbench.diagnose("response-1", record, causes=["rudder_offset"], progress=told.append)
    assert told[:2] == ["reading the model and the records", "checks of sensors and files"]
    assert len(told) == len(set(told)) > 2


def test_a_model_that_is_built_tells_its_stages(record):
    told = []
    helmbench.build_model(record, progress=told.append)
    assert told[0] == "reading the model and the records" and len(told) == len(set(told)) == 4
