"""Resolving, saving and reading models; the kernel cache."""

import json

import numpy as np
import pytest

from helmbench.models.errors import BadInput
from helmbench.models.model import list_families, list_vessels, model_to_json, resolve
from helmbench.models.vessel import read_vessel

PROMISED = ["nomoto-1", "nomoto-1-cubic", "nomoto-2", "nomoto-2-cubic", "nomoto-2-quadratic", "kt", "abkowitz", "mmg"]
VESSELS = [
    "remus-kt",
    "remus",
    "mariner",
    "mariner-model",
    "response-1",
    "response-2",
    "cargo",
    "patrol",
    "s175",
    "s175-polynomial",
    "esso-osaka-l3",
    "kvlcc2-l7",
]


def test_the_promised_ids_exist():
    assert set(PROMISED) <= set(list_families())
    assert set(VESSELS) <= set(list_vessels())


@pytest.mark.parametrize("name", list(list_vessels()))
def test_a_model_file_repeats_the_vessel(name, tmp_path):
    vessel = resolve(name)
    model_to_json(vessel, tmp_path / "copy.json")
    copy = resolve(tmp_path / "copy.json")
    np.testing.assert_array_equal(copy.theta, vessel.theta)
    for field in ("family", "positive_rudder", "rudder", "controller", "windage", "max_step_s", "n0_rps"):
        assert getattr(copy, field) == getattr(vessel, field)
    assert dict(copy.suite) == dict(vessel.suite) and copy.id == "copy"


def test_an_unknown_coefficient_survives_the_file(tmp_path):
    model_to_json(resolve("kt"), tmp_path / "blank.json")
    assert not resolve(tmp_path / "blank.json").known


@pytest.mark.parametrize("name", ["cargo", "response-2", "mariner"])
def test_parameters_are_those_of_the_vessel_file(name):
    from helmbench.models.vessel import vessel_files

    entries = read_vessel(vessel_files()[name])["parameters"]
    values = {key: entry["value"] for key, entry in entries.items()}
    assert resolve(name).parameters == pytest.approx(values, rel=1e-9, abs=1e-15)


def test_complex_time_constants_are_nan_not_a_real_part():
    model = resolve("nomoto-2").with_coefficients([-0.1, -1.0, 1.0, 1.0])
    assert np.isnan(model.parameters["T1"]) and np.isnan(model.parameters["T2"])
    assert model.parameters["K"] == 1.0


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("marinr", "did you mean mariner"),
        ("abkowitz", "needs a vessel's constants"),
        ("nowhere/model.json", "no such file"),
    ],
)
def test_what_cannot_be_resolved_is_said_in_one_line(name, said):
    with pytest.raises(BadInput, match=said) as caught:
        resolve(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda facts: facts.pop("family"), "family"),
        (lambda facts: facts["coefficients"].pop("Nv"), "missing: Nv"),
        (lambda facts: facts["coefficients"].update(Q=1), "unknown coefficients: Q"),
        (lambda facts: facts.update(schema=99), "schema"),
        (lambda facts: facts.update(family="unheard-of"), "unknown model family"),
        (lambda facts: facts.update(constants=[1, 2]), "constants: Input should be"),
    ],
)
def test_a_damaged_model_file_is_named(change, said, tmp_path):
    path = tmp_path / "model.json"
    model_to_json(resolve("mariner"), path)
    facts = json.loads(path.read_text())
    change(facts)
    path.write_text(json.dumps(facts))
    with pytest.raises(BadInput, match=said) as caught:
        resolve(path)
    assert str(caught.value).startswith(str(path)) or "unknown model family" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1, 2]", "not a vessel file"),
        ("id: ship", "missing: title"),
        ("{", "not YAML"),
    ],
)
def test_a_damaged_vessel_file_is_named(text, said, tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text(text)
    with pytest.raises(BadInput, match=said):
        read_vessel(path)


def test_a_number_without_unit_and_source_is_refused(tmp_path):
    path = tmp_path / "ship.yaml"
    head = "id: ship\ntitle: t\nfamily: kt\nsource: s\npositive_rudder: port\nmax_step_s: 1\n"
    path.write_text(head + "parameters: {T1: {value: 1.0}}\n")
    with pytest.raises(BadInput, match="needs value, unit and source"):
        read_vessel(path)
