"""`helmbench from-indices`: output, files, exit status."""

import json

import pytest

import helmbench
from helmbench.cli import status_of

SHIP = """
name: tanker
length_m: 320
speed_kn: 15.5
indices:
  - {manoeuvre: turn:35, advance_m: 1000, tactical_diameter_m: 1020, speed_ratio: 0.4}
  - {manoeuvre: zigzag:10/10, first_overshoot_deg: 8.1}
"""


@pytest.fixture
def ship(tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text(SHIP, encoding="utf-8")
    return path


def test_it_prints_and_writes_a_model_that_other_commands_take(ship, tmp_path, capsys):
    model = tmp_path / "model.json"
    assert status_of(["from-indices", str(ship), "-o", str(model)]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Model tanker: turning-response from 4 indices") and "not determined" in out
    assert "tactical diameter" in out and f"wrote {model}" in err
    record = tmp_path / "record.csv"
    assert status_of(["simulate", str(model), "--manoeuvre", "zigzag:20/20", "--noise", "low", "-o", str(record)]) == 0
    assert status_of(["validate", str(model), str(record)]) == 0
    capsys.readouterr()
    assert status_of(["from-indices", str(ship), "-o", str(model)]) == 2
    assert "exists" in capsys.readouterr().err


def test_json_is_what_python_gives(ship, capsys):
    assert status_of(["from-indices", str(ship), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    found = helmbench.model_from_indices(ship)
    assert told == json.loads(json.dumps(found.to_json())) | {"output": None}
    assert [row["name"] for row in told["parameters"]][:2] == ["damping", "gain"]
    frame = found.to_dataframe()
    assert frame.loc["gain", "low"] < frame.loc["gain", "value"] < frame.loc["gain", "high"]
    assert frame.loc[list(found.undetermined), ["low", "high"]].isna().all(axis=None)
    assert found.indices_to_dataframe()["given"].count() == 4


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SHIP.replace("320", "-320"), "ship.yaml: length_m: needs a length from 0.1 to 1000 m, not -320"),
        (SHIP.replace("speed_ratio", "sped_ratio"), "unknown key 'indices 0 sped_ratio'; did you mean speed_ratio?"),
        ("length_m: [", "ship.yaml: row"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(ship, tmp_path, capsys, text, said):
    ship.write_text(text, encoding="utf-8")
    assert status_of(["from-indices", str(ship), "-o", str(tmp_path / "model.json")]) == 2
    out, err = capsys.readouterr()
    assert out == "" and said in err and err.count("\n") == 1
    assert not (tmp_path / "model.json").exists()


def test_manoeuvres_that_no_model_performs_are_told(ship, tmp_path, capsys):
    impossible = "{manoeuvre: zigzag:0.1/90, first_overshoot_deg: 1}"
    ship.write_text(SHIP.replace("{manoeuvre: zigzag:10/10, first_overshoot_deg: 8.1}", impossible), encoding="utf-8")
    assert status_of(["from-indices", str(ship), "-o", str(tmp_path / "model.json")]) == 1
    err = capsys.readouterr().err
    assert "no model of the family performs zigzag:0.1/90" in err and err.count("\n") == 1
    assert not (tmp_path / "model.json").exists()
