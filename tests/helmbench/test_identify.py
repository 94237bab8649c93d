"""Identification from a user's own files."""

import json

import pytest

from helmbench import identification as room
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import write_record
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve


@pytest.fixture
def files(tmp_path):
    for name, manoeuvre in (("train", "zigzag:20/20"), ("other", "zigzag:10/10:port")):
        write_record(generate(Case("response-1", manoeuvre, "low")), tmp_path / f"{name}.csv")
    return tmp_path


def test_a_model_is_identified_and_validated(files):
    found = room.identify([files / "train.csv"], "response-1", "output-error", [files / "other.csv"])
    assert found.estimate.parameters == pytest.approx(resolve("response-1").parameters, rel=0.02)
    assert found.scores["r2_free_heading_rad"] > 0.999 and not found.scores["diverged"]
    assert (found.train, found.validation, found.warnings) == (("train",), ("other",), ())
    told = found.as_dict()
    assert json.loads(json.dumps(told))["parameters"][0] == {
        "parameter": "T", "unit": "s", "estimate": found.estimate.parameters["T"], "stderr": found.estimate.stderr["T"],
    }  # fmt: skip
    assert told["validation"]["records"] == ["other"]


def test_what_the_records_tell_is_said_on_request(files):
    quiet = room.identify([files / "train.csv"], "response-1", "output-error")
    assert quiet.identifiability is None and quiet.as_dict()["identifiability"] is None
    found = room.identify([files / "train.csv"], "response-1", "output-error,fixed=K,profile=T", report=True)
    told = json.loads(json.dumps(found.as_dict()))
    assert told["identifiability"]["counts"] == {"within_10_percent": 3, "within_50_percent": 0, "not_determined": 0}
    interval = told["profile"]["T"]
    assert told["identifiability"]["candidates"]
    assert interval["low"] < found.estimate.parameters["T"] < interval["high"]
    assert found.estimate.parameters["K"] == pytest.approx(resolve("response-1").parameters["K"], rel=1e-12)


def test_records_are_turned_to_the_models_rudder(files):
    record = generate(Case("mariner", "zigzag:20/20"))
    write_record(record, files / "mariner.csv")
    found = room.identify([files / "mariner.csv"], "nomoto-1", "ls")
    assert record.meta.positive_rudder == "port" and found.estimate.parameters["K"] > 0


@pytest.mark.parametrize("vessel", ["response-1", "mariner", "s175", "patrol", "kvlcc2-l7"])
def test_a_wrong_rudder_sign_is_told_and_a_right_one_is_not(vessel):
    record = generate(Case(vessel, "zigzag:20/20", "medium"))
    assert room.sign_doubt(record) is None
    rudder = -record.column("rudder_rad")
    doubt = room.sign_doubt(record.with_channels(rudder_rad=rudder))
    assert doubt is not None and doubt.startswith("rudder_sign: ") and record.meta.positive_rudder in doubt


def test_the_sign_is_read_from_the_heading_where_there_is_no_yaw_rate():
    record = generate(Case("response-1", "zigzag:20/20")).with_channels(yaw_rate_rad_s=None)
    assert room.sign_doubt(record) is None
    assert room.sign_doubt(record.with_channels(rudder_rad=-record.column("rudder_rad"))) is not None


def test_nothing_is_said_where_nothing_can_be_told():
    record = generate(Case("response-1", "zigzag:20/20"))
    assert room.sign_doubt(record.with_channels(yaw_rate_rad_s=None, heading_rad=None)) is None
    assert room.sign_doubt(record.slice(0, 10)) is None


def test_a_record_that_lacks_a_channel_is_bad_input(files):
    record = generate(Case("mariner", "zigzag:20/20")).with_channels(surge_m_s=None, sway_m_s=None)
    write_record(record, files / "no_sway.csv")
    with pytest.raises(BadInput, match=r"method ls cannot fit mariner: .*no_sway.*surge_m_s"):
        room.identify([files / "no_sway.csv"], "mariner", "ls")
