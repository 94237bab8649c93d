"""Files of indices: what cannot be is refused in one line."""

import copy

import pytest

from helmbench.estimation.indices.given import read_indices
from helmbench.models.errors import BadInput

SHIP = {
    "name": "tanker",
    "length_m": 320.0,
    "speed_m_s": 7.9,
    "indices": [
        {"manoeuvre": "turn:35", "advance_m": 1000.0, "transfer_m": 420.0, "tactical_diameter_m": 1020.0},
        {"manoeuvre": "zigzag:10/10", "first_overshoot_deg": 8.1, "second_overshoot_deg": 17.0},
    ],
}


def changed(top=None, turn=None, zigzag=None, drop=()):
    content = copy.deepcopy(SHIP)
    content["indices"][0] |= turn or {}
    content["indices"][1] |= zigzag or {}
    content |= top or {}
    return {key: value for key, value in content.items() if key not in drop}


WRONG = {
    "unknown key": (changed({"lenght_m": 3.0}), "unknown key 'lenght_m'; did you mean length_m?"),
    "unknown index": (changed(turn={"advanse_m": 3.0}), "unknown key 'indices 0 advanse_m'; did you mean advance_m"),
    "negative length": (changed({"length_m": -320.0}), "length_m: needs a length from 0.1 to 1000 m, not -320"),
    "no speed": (changed(drop=("speed_m_s",)), "no approach speed; give speed_m_s or speed_kn"),
    "two speeds": (changed({"speed_kn": 15.0}), "speed stands twice: speed_m_s and speed_kn"),
    "no length": (changed(drop=("length_m",)), "missing: length_m"),
    "no indices": (changed({"indices": []}), "indices: "),
    "a text": (changed(turn={"advance_m": "1 km"}), "indices 0 advance_m: needs a positive number, not 1 km"),
    "overshoot of zero": (changed(zigzag={"first_overshoot_deg": 0}), "first_overshoot_deg: needs an angle above 0"),
    "speed ratio": (changed(turn={"speed_ratio": 1.2}), "speed_ratio: needs a share above 0, at most 1, not 1.2"),
    "transfer": (changed(turn={"transfer_m": 1500.0}), "turn:35: the transfer is not below the tactical diameter"),
    "unit": (changed(turn={"advance_m": 3.1}), "turn:35: advance_m is 0.00969 ship lengths; check length_m"),
    "twice": (changed(turn={"advance_cables": 5.4}), "advance stands twice: advance_m and advance_cables"),
    "two steady speeds": (
        changed(turn={"speed_ratio": 0.4, "steady_speed_kn": 6.0}),
        "turn:35: the steady speed stands twice",
    ),
    "faster": (changed(turn={"steady_speed_kn": 20.0}), "the steady speed is above the approach speed"),
    "contradiction": (
        changed(turn={"speed_ratio": 0.4, "final_diameter_m": 900.0, "yaw_rate_deg_s": 1.0}),
        "turn:35: yaw rate, steady speed and final diameter contradict each other",
    ),
    "index of a turn": (changed(zigzag={"advance_m": 900.0}), "zigzag:10/10 has no advance_m; it has first_overshoot"),
    "initial turning": (
        changed(turn={"initial_turning_m": 500.0}),
        "turn:35 has no initial_turning_m; it is defined by",
    ),
    "manoeuvre": (changed(turn={"manoeuvre": "spiral:20"}), "manoeuvre 'spiral:20' has no indices"),
    "form": (changed(turn={"manoeuvre": "turn"}), "manoeuvre 'turn'"),
    "rudder": (changed({"rudder_max_deg": 30.0}), "turn:35: the rudder goes over to 30 deg only; see rudder_max_deg"),
    "accuracy": (changed(turn={"accuracy": {"speed_ratio": 0.1}}), "an accuracy without the index"),
    "unit of accuracy": (changed(turn={"accuracy": {"advance_cables": 0.1}}), "or in another unit: advance_cables"),
    "accuracy of zero": (
        changed(turn={"accuracy": {"advance_m": 0}}),
        "indices 0 accuracy advance_m: needs a positive",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_is_refused_in_one_line(name):
    content, said = WRONG[name]
    with pytest.raises(BadInput) as told:
        read_indices(content)
    line = str(told.value)
    assert said in line and line.startswith("indices: ") and "\n" not in line


def test_too_few_and_repeated_indices_are_refused():
    few = changed({"indices": [{"manoeuvre": "turn:35", "advance_m": 900.0}]})
    with pytest.raises(BadInput, match="1 indices are too few for a model; at least 3"):
        read_indices(few)
    turn = SHIP["indices"][0]
    with pytest.raises(BadInput, match="advance of turn:35 stands twice"):
        read_indices(changed({"indices": [turn, turn]}))
    with pytest.raises(BadInput, match="turn:35:port: no index is given"):
        read_indices(changed({"indices": [*SHIP["indices"], {"manoeuvre": "turn:35:port"}]}))


def test_both_sides_of_a_manoeuvre_may_be_given():
    port = SHIP["indices"][0] | {"manoeuvre": "turn:35:port", "advance_m": 1040.0}
    found = read_indices(changed({"indices": [*SHIP["indices"], port]}))
    assert [row.value for row in found.indices if row.name == "advance"] == [1000.0, 1040.0]


def test_a_file_is_named_in_the_line(tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text("length_m: 100\nspeed_kn: 15\nindices: [{manoeuvre: turn:35, advance_m: 1}]\n", encoding="utf-8")
    with pytest.raises(BadInput, match=r"ship\.yaml: turn:35: advance_m is 0.01 ship lengths"):
        read_indices(path)
    path.write_text("- a list\n", encoding="utf-8")
    with pytest.raises(BadInput, match=r"ship\.yaml: is not a file of indices"):
        read_indices(path)
    with pytest.raises(BadInput, match=r"nowhere\.yaml"):
        read_indices(tmp_path / "nowhere.yaml")


def test_accuracies_are_stated_or_assumed():
    given = read_indices(changed(turn={"accuracy": {"advance_m": 12.0}})).indices
    told = {row.key: row.accuracy for row in given}
    assumed = {"transfer_m": 32.0, "tactical_diameter_m": 32.0, "first_overshoot_deg": 1.0, "second_overshoot_deg": 2.0}
    assert told == pytest.approx({"advance_m": 12.0, **assumed})
