"""Model files are data: they run no code, and every number counts as it stands, with its unit."""

import json

import numpy as np
import pytest

from helmbench.models import kernels
from helmbench.models.errors import BadInput
from helmbench.models.model import model_from_json, model_to_json, resolve


@pytest.fixture
def facts(tmp_path):
    """The content of a model file of `response-1`, and a function that writes a changed one and reads it."""
    model_to_json(resolve("response-1"), tmp_path / "model.json")
    content = json.loads((tmp_path / "model.json").read_text())

    def read(**changed):
        (tmp_path / "changed.json").write_text(json.dumps({**content, **changed}))
        return model_from_json(tmp_path / "changed.json")

    return content, read


@pytest.mark.parametrize(
    "where", ["{folder}/trap", "../../{name}/trap", "trap/../../trap", "nomoto-1/../{folder}/trap"]
)
def test_a_model_file_loads_no_code(where, facts, tmp_path, monkeypatch):
    """An index beside a Python file, as the cache of kernels has them, must not be followed."""
    canary = tmp_path / "canary"
    (tmp_path / "trap.py").write_text(f"open({str(canary)!r}, 'w').close()\n")
    parts = ("core", "simulate", "tangent", "lanes", "regress")
    (tmp_path / "trap.json").write_text(json.dumps(dict.fromkeys(parts, str(tmp_path / "trap.py"))))
    monkeypatch.setattr(kernels, "cache_folder", lambda: tmp_path / "cache" / "kernels")
    family = where.format(folder=tmp_path, name=tmp_path.name)
    with pytest.raises(BadInput, match="unknown model family"):
        facts[1](family=family)
    with pytest.raises(BadInput):
        resolve(family)
    assert not canary.exists()


@pytest.mark.parametrize(
    "family",
    ["", "nomoto-1 ", "nomoto-1\x00", "nomoto-1+", "nomoto-1\n", "a" * 300, "mmg+environment", "mmg+bank", "x+bank~y"],
)
def test_what_is_no_family_is_refused(family, facts):
    with pytest.raises(BadInput):
        facts[1](family=family)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"positive_rudder": "Starboard"}, "positive_rudder: needs port or starboard, not Starboard"),
        ({"positive_rudder": 7}, "positive_rudder: needs port or starboard, not 7"),
        ({"positive_ruder": "port"}, "unknown key 'positive_ruder'; did you mean positive_rudder"),
        ({"instruments": {"rudder_offset": {"value": 2.0, "unit": "m"}}}, "the unit is 'm' where 'rad'"),
        ({"instruments": {"rudder_offset": {"value": 2.0, "units": "deg"}}}, "unknown key .*; did you mean unit"),
        ({"instruments": {"rudder_offset": 2.0}}, "instruments rudder_offset"),
        ({"max_step_s": 0.0}, "max_step_s: needs a positive number"),
        ({"speed_m_s": 1e6}, "speed_m_s: needs a speed from 0 to 200 m/s"),
        ({"rudder": {"max_rad": 35.0}}, "rudder max_rad: needs an angle"),
        ({"rudder": {"max_deg": 35.0}}, "unknown key 'rudder max_deg'; did you mean max_rad"),
        ({"controller": {"kp": "1"}}, "controller kp: needs a finite number"),
        ({"schema": 2}, "schema: needs 1"),
        ({"coefficients": {"a": True}}, "coefficients a: needs a finite number, not true"),
    ],
)
def test_what_a_model_file_says_is_read_exactly_or_refused(changed, said, facts):
    with pytest.raises(BadInput, match=said) as caught:
        facts[1](**changed)
    assert "\n" not in str(caught.value)


def test_units_of_instruments_are_converted(facts):
    model = facts[1](instruments={"rudder_offset": {"value": 2, "unit": "deg"}})
    assert model.instruments == {"rudder_offset": pytest.approx(np.deg2rad(2.0))}


def test_an_edited_parameter_is_refused_or_honoured(facts):
    content, read = facts
    edited = {**content["parameters"], "T": {"value": 30.0, "unit": "s"}}
    with pytest.raises(BadInput, match="parameters T is 30, the coefficients give"):
        read(parameters=edited)
    assert read(parameters=edited, coefficients=None).parameters["T"] == pytest.approx(30.0)
    minutes = {**edited, "T": {"value": 0.5, "unit": "min"}}
    assert read(parameters=minutes, coefficients=None).parameters["T"] == pytest.approx(30.0)


@pytest.mark.parametrize("coefficients", [[-0.0, 0.1, 0.0], [-1.0, 0.0, 1.0], [1e-300, 1e300, 1.0], [np.nan] * 3])
def test_a_model_without_finite_parameters_is_read_back(coefficients, tmp_path):
    model = resolve("response-1").with_coefficients(coefficients)
    model_to_json(model, tmp_path / "m.json")
    np.testing.assert_array_equal(resolve(tmp_path / "m.json").coefficients, model.coefficients)


def test_a_model_file_is_written_whole_or_not_at_all(tmp_path):
    model = resolve("response-1")
    with pytest.raises(BadInput, match="cannot be written"):
        model_to_json(model, tmp_path / "nowhere" / "model.json")
    (tmp_path / "model.json").mkdir()
    with pytest.raises(BadInput, match="is a directory"):
        model_to_json(model, tmp_path / "model.json")
    assert [path.name for path in tmp_path.iterdir()] == ["model.json"]


def test_a_device_is_not_replaced_by_a_file():
    with pytest.raises(BadInput, match="it is a device or a pipe"):
        model_to_json(resolve("response-1"), "/dev/null")


def test_a_model_with_some_coefficients_of_null_is_refused(facts):
    content, read = facts
    name = next(iter(content["coefficients"]))
    for changed in ({}, {"parameters": {}}):
        with pytest.raises(BadInput, match=rf"coefficients without a number: {name}; give every coefficient a number"):
            read(coefficients={**content["coefficients"], name: None}, **changed)
    assert not read(coefficients=dict.fromkeys(content["coefficients"]), parameters={}).known


def test_a_model_with_some_parameters_of_null_and_no_coefficients_is_refused(facts):
    content, read = facts
    first, *others = content["parameters"]
    gap = {first: {**content["parameters"][first], "value": None}}
    with pytest.raises(BadInput, match=rf"parameters without a number: {first}; give every parameter a number"):
        read(coefficients=None, parameters=content["parameters"] | gap)
    every = {name: {**content["parameters"][name], "value": None} for name in (first, *others)}
    assert not read(coefficients=None, parameters=every).known
