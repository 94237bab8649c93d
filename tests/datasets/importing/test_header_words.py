"""What the words of a header state: parts of a unit, where a heading counts from, Italian and Portuguese names."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import helmbench

N = 200
TIME = 0.5 * np.arange(N)
HEADING, YAW_RATE = 90.0 + 40.0 * np.sin(TIME / 8.0), 5.0 * np.cos(TIME / 8.0)
RUDDER = -20.0 * np.cos(TIME / 8.0 + 0.6)
"""deg; positive to port."""


def log(tmp_path, header, *columns):
    rows = zip(TIME, *columns, strict=True)
    path = tmp_path / "log.csv"
    path.write_text("\n".join([header, *(",".join(f"{v:.9g}" for v in row) for row in rows)]), "utf-8")
    return path


def record(path):
    (found,) = helmbench.import_log([path]).records
    return found


@pytest.mark.parametrize(
    "header, heading",
    [
        ("Yaw ccw from east [deg]", (90.0 - HEADING) % 360.0),
        ("heading (ccw from east) [deg]", (90.0 - HEADING) % 360.0),
        ("heading ENU [deg]", (90.0 - HEADING) % 360.0),
        ("heading ccw from north [deg]", -HEADING % 360.0),
        ("heading NED [deg]", HEADING),
        ("heading cw from north [deg]", HEADING),
        ("heading [1/10 deg]", 10.0 * HEADING),
        ("heading [deg/10]", 10.0 * HEADING),
        ("heading [decidegrees]", 10.0 * HEADING),
        ("heading [1/100 deg]", 100.0 * HEADING),
        ("prora [gradi]", HEADING),
        ("rumo verdadeiro [graus]", HEADING),
    ],
)
def test_a_heading_as_its_header_states_it(tmp_path, header, heading):
    found = record(log(tmp_path, f"time [s],{header},rudder (+ port) [deg]", heading, RUDDER))
    assert_allclose(np.degrees(found.heading_unwrapped()) % 360.0, HEADING % 360.0, atol=1e-5)


@pytest.mark.parametrize(
    "header",
    ["timone (+ = sinistra) [gradi]", "leme (+ = bombordo) [graus]", "angolo del timone [gradi; positivo a sinistra]"],
)
def test_rudders_and_sides_in_italian_and_portuguese(tmp_path, header):
    draft = helmbench.draft_import([log(tmp_path, f"tempo [s],heading [deg],{header}", HEADING, RUDDER)])
    rudder = draft.columns[-1]
    assert (rudder.quantity, rudder.unit, rudder.sign) == ("rudder", "deg", "positive to port")
    assert not draft.questions


def test_a_turn_rate_in_radians_a_minute(tmp_path):
    header = "time [s],heading [deg],yaw rate [rad/min],rudder [deg]"
    found = record(log(tmp_path, header, HEADING, np.radians(60.0 * YAW_RATE), RUDDER))
    assert_allclose(np.degrees(found.column("yaw_rate_rad_s")), YAW_RATE, atol=1e-6)


@pytest.mark.parametrize("unit", ["zorb", "deg^1/3", "2 turns"])
def test_a_unit_that_is_not_known_is_asked_and_not_guessed_from_the_size(tmp_path, unit):
    draft = helmbench.draft_import([log(tmp_path, f"time [s],heading [{unit}],rudder [deg]", HEADING, RUDDER)])
    (question,) = [q for q in draft.questions if q.column.startswith("heading")]
    assert question.about == "unit"
    assert unit in question.text


@pytest.mark.parametrize("name", ["sway velocity [m/s, + starboard]", "latitude [deg]", "northing [m]"])
def test_a_channel_that_misses_its_other_part_is_told(tmp_path, name):
    path = log(tmp_path, f"time [s],heading [deg],rudder [deg],{name}", HEADING, RUDDER, 10.0 + 0.1 * YAW_RATE)
    found = helmbench.import_log([path])
    told = [fault.message for fault in found.report.faults]
    assert any("without" in message for message in told), told


def test_volts_about_zero_say_what_is_taken_as_amidships(tmp_path):
    (question,) = helmbench.draft_import([log(tmp_path, "t [s],heading [deg],rudder [V]", HEADING, RUDDER)]).questions
    assert "amidships" in question.text


@pytest.mark.parametrize(
    "header",
    [
        "시간 [s],선수방위(도),선회율(도/초),타각(도)",
        "Время [s],Курс [град],Скорость поворота [град/с],Угол руля [град]",
        "Tijd [s],Ware koers [deg],Draaisnelheid [deg/s],Roerhoek [deg]",
        "Aika [s],Keulasuunta [deg],Kääntymisnopeus [deg/s],Peräsinkulma [deg]",
        "Czas [s],Kurs rzeczywisty [deg],Prędkość kątowa [deg/s],Wychylenie steru [deg]",
        "Zaman [s],Pruva açısı [deg],Dönüş hızı [deg/s],Dümen açısı [deg]",
    ],
    ids=["Korean", "Russian", "Dutch", "Finnish", "Polish", "Turkish"],
)
def test_headers_of_further_languages(tmp_path, header):
    draft = helmbench.draft_import([log(tmp_path, header, HEADING, YAW_RATE, RUDDER)])
    told = [(row.quantity, row.unit) for row in draft.columns]
    assert told == [("time", "seconds"), ("heading", "deg"), ("yaw_rate", "deg/s"), ("rudder", "deg")]


def test_copies_in_another_unit_and_of_the_opposite_sign_are_told(tmp_path):
    """The rudder in degrees, in radians to the other side, and an order in a unit of its own: nothing is asked."""
    header = "t [s],heading [deg],rot [deg/s],rudder,delta,-rudder,rudder_command"
    radians = -np.radians(RUDDER)
    path = log(tmp_path, header, HEADING, YAW_RATE, RUDDER, radians, -RUDDER, 40.0 + RUDDER)
    draft = helmbench.draft_import([path])
    rows = {row.column: row for row in draft.columns}
    assert [rows[name].quantity for name in ("rudder", "delta", "-rudder")] == ["rudder", "not used", "not used"]
    assert rows["rudder"].unit == "deg" and "column delta is the same in rad" in rows["rudder"].why
    assert [question for question in draft.questions if question.about in ("unit", "quantity")] == []


def test_angles_that_count_from_zero_to_two_pi_are_radians(tmp_path):
    """A course that goes along the positions in radians only, and a roll with negative angles near the full turn."""
    roll, course = 0.05 * np.sin(TIME), np.radians(HEADING - 90.0)
    north = np.cumsum(4.0 * np.cos(course)) * 0.5
    east = np.cumsum(4.0 * np.sin(course)) * 0.5
    header = "t [s],COG,Roll,north [m],east [m],rudder [deg]"
    path = log(tmp_path, header, course % (2.0 * np.pi), roll % (2.0 * np.pi), north, east, RUDDER)
    draft = helmbench.draft_import([path], positive_rudder="port")
    rows = {row.column: row for row in draft.columns}
    assert (rows["COG"].unit, rows["Roll"].unit) == ("rad", "rad")
    (question,) = draft.questions
    made = draft.answer({question.id: question.answers[0].key}).import_log().records[0]
    assert question.about == "sign" and made.column("roll_rad") == pytest.approx(roll, abs=1e-6)
