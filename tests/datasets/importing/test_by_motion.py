"""Columns without a name are told by how they move together: proposed as a whole, asked once."""

import re

import numpy as np
import pytest
import yaml

import helmbench
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.importing.by_motion import assignments, motion_of
from helmbench.datasets.importing.quantities import UNITS
from helmbench.datasets.io import read_record
from helmbench.datasets.measured import data_dir

from ...seeds import SHIFT

TRADE = {"heading_rad": "deg", "yaw_rate_rad_s": "deg/min", "rudder_rad": "deg", "surge_m_s": "kn", "sway_m_s": "kn"}
BASE = {
    "heading_rad": "rad",
    "yaw_rate_rad_s": "rad/s",
    "rudder_rad": "rad",
    "surge_m_s": "m/s",
    "sway_m_s": "m/s",
}
QUANTITIES = {"heading_rad": "heading", "yaw_rate_rad_s": "yaw_rate", "rudder_rad": "rudder", "surge_m_s": "surge",
              "sway_m_s": "sway", "north_m": "north", "east_m": "east"}  # fmt: skip


def columns_of(record, units):
    """Column -> values in a unit; the heading between 0 and the full turn."""
    values = {c: record.column(c) / UNITS[units.get(c, "m")].factor for c in QUANTITIES}
    turn = 2.0 * np.pi / UNITS[units["heading_rad"]].factor
    return values | {"heading_rad": values["heading_rad"] % turn}


def meant(record, columns, rng):
    """Column -> (quantity, unit, sign) that the likeliest assignment says of shuffled columns, and their number."""
    names = [str(name) for name in rng.permutation(list(columns))]
    motion = motion_of(record.time_s, {f"c{i}": columns[name] for i, name in enumerate(names)}, {})
    made = assignments(motion)
    own = made[0].meanings if made else {}
    return {names[int(c[1:])]: (m.quantity, m.unit, m.sign) for c, m in own.items()}, len(made)


@pytest.mark.parametrize("units", [TRADE, BASE], ids=["trade", "SI"])
@pytest.mark.parametrize("ship", ["mariner", "kvlcc2-l7"])
def test_shuffled_columns_are_told_with_units_and_signs(ship, units, rng):
    length = 400.0 if ship == "mariner" else 120.0
    record = generate(Case(ship, "zigzag:20/20", duration_s=length, dt_s=0.5, seed=int(rng.integers(2**31))))
    truth = {c: (QUANTITIES[c], units.get(c, "m"), 1) for c in QUANTITIES}
    assert meant(record, columns_of(record, units), rng) == (truth, 1)


def test_a_rate_that_counts_to_port_and_an_axis_to_west_are_turned(rng):
    record = generate(Case("mariner", "zigzag:20/20", duration_s=400.0, dt_s=0.5))
    columns = columns_of(record, TRADE)
    columns |= {"yaw_rate_rad_s": -columns["yaw_rate_rad_s"], "east_m": -columns["east_m"]}
    told, count = meant(record, columns, rng)
    assert count == 1 and told["yaw_rate_rad_s"] == ("yaw_rate", "deg/min", -1) and told["east_m"] == ("east", "m", -1)


def test_without_a_track_the_unit_of_the_angles_is_open(rng):
    record = generate(Case("mariner", "turn:20", duration_s=600.0, dt_s=0.5))
    columns = {c: record.continuous(c) for c in ("heading_rad", "yaw_rate_rad_s", "rudder_rad")}
    told, count = meant(record, columns, rng)
    assert count == 2 and {c: q for c, (q, _, _) in told.items()} == {c: QUANTITIES[c] for c in columns}


def test_noise_and_constants_are_nothing(rng):
    time = np.arange(400.0)
    columns = {"a": rng.normal(size=400), "b": np.full(400, 3.0), "c": np.cumsum(rng.normal(size=400)), "d": time % 7.0}
    assert assignments(motion_of(time, columns, {})) == []


# ------------------------------------------------------------------------------------------------ import


def nameless(record, folder, changes=()):
    """A file of numbers without a header, and its path."""
    columns = columns_of(record, TRADE) | dict(changes)
    rows = np.column_stack([record.time_s, *columns.values(), np.full(record.n, 1.5)])
    path = folder / "tank.dat"
    path.write_text("\n".join("  ".join(f"{x:.6f}" for x in row) for row in rows), "utf-8")
    return path


@pytest.fixture(scope="module")
def ship():
    return generate(Case("mariner", "zigzag:20/20", duration_s=400.0, dt_s=0.5))


def test_a_file_without_a_header_is_asked_once_and_its_draft_is_the_answer(ship, tmp_path, capsys):
    path, draft, out = nameless(ship, tmp_path), tmp_path / "map.yaml", tmp_path / "out.csv"
    assert status_of(["import", str(path), "--map", str(draft), "-o", str(out)]) == 2
    said = capsys.readouterr().err
    assert len(re.findall(r"Is this right\?", said)) == 2 and "column 2 is heading [deg]" in said  # summary and fault
    assert "?" not in yaml.safe_dump(yaml.safe_load(draft.read_text("utf-8")))
    assert status_of(["import", str(path), "--map", str(draft), "-o", str(out)]) == 0
    record = read_record(out).turned("starboard")
    truth = ship.turned("starboard")
    for channel in QUANTITIES:
        own, true = record.continuous(channel), truth.continuous(channel)
        assert own == pytest.approx(true, abs=2e-3 * np.ptp(true) + 1e-5), channel


def test_the_question_is_answered_with_a_number_or_with_none(ship, tmp_path):
    draft = helmbench.draft_import([nameless(ship, tmp_path)])
    (question,) = draft.questions
    assert [answer.key for answer in question.answers] == ["1", "2", "none"]
    assert "heading [deg, counterclockwise from east]" in question.answers[1].text  # no motion tells the mirror image
    assert draft.answer({question.id: "1"}).questions == ()
    with pytest.raises(helmbench.BadInput, match=r"'3' is no answer to 'tank.dat/columns'; give one of: 1, 2, none"):
        draft.answer({question.id: "3"})


def test_where_one_column_is_wrong_it_alone_is_asked_and_all_are_where_several_are(ship, tmp_path):
    draft = helmbench.draft_import([nameless(ship, tmp_path)]).answer({"tank.dat/columns": "none"})
    (question,) = draft.questions
    assert [answer.key for answer in question.answers] == [*(f"column {i}" for i in (2, 3, 7, 8, 5, 6, 4)), "several"]
    wrong = draft.answer({question.id: "column 6"})
    (other,) = wrong.questions
    assert (other.column, other.about) == ("column 6", "quantity")
    made = wrong.answer({other.id: "not used"}).import_log()
    assert not made.records[0].has("sway_m_s") and made.records[0].has("surge_m_s", "heading_rad", "rudder_rad")
    assert len(draft.answer({question.id: "several"}).questions) > 5
    with pytest.raises(helmbench.BadInput, match=r"'column 1' is no answer to 'tank.dat/wrong column'; give one of: "):
        draft.answer({question.id: "column 1"})


def test_names_that_are_not_known_are_told_beside_those_that_are(ship, tmp_path):
    columns = columns_of(ship, TRADE)
    head = "t [s],Heading [deg],xq,zw,uvw,north [m],east [m]"
    rows = np.column_stack(
        [ship.time_s, columns["heading_rad"], columns["rudder_rad"], 0.01 * ship.time_s, columns["yaw_rate_rad_s"],
         ship.column("north_m"), ship.column("east_m")]
    )  # fmt: skip
    path = tmp_path / "log.csv"
    path.write_text(head + "\n" + "\n".join(",".join(f"{x:.5f}" for x in row) for row in rows), "utf-8")
    draft = helmbench.draft_import([path])
    asked = [question for question in draft.questions if question.about == "columns"]
    assert len(asked) == 1 and "zw" not in asked[0].text
    assert "uvw is yaw rate [deg/min], xq is rudder [deg]" in asked[0].text


def lines_of(path, columns):
    rows = (",".join(f"{value:.6g}" for value in row) for row in zip(*columns.values(), strict=True))
    path.write_text("\n".join([",".join(columns), *rows]), "utf-8")
    return path


@pytest.mark.parametrize("turned", [True, False])
def test_a_wind_that_turns_back_as_the_ship_turns_counts_from_the_bow(ship, tmp_path, turned):
    heading = np.degrees(ship.column("heading_rad"))
    columns = {"time [s]": ship.time_s, "heading [deg]": heading % 360.0, "rudder [deg]": np.degrees(ship.rudder())}
    wind = {"wind direction [deg]": (40.0 - turned * heading) % 360.0, "wind speed [m/s]": 9.0 + 0.01 * heading}
    record = helmbench.import_log(lines_of(tmp_path / "log.csv", columns | wind), positive_rudder="starboard").record
    assert record.has("wind_speed_m_s", "wind_direction_rad") is not turned


@pytest.mark.parametrize("current", [0.0, 1.2])
def test_a_speed_that_is_not_always_that_of_the_track_is_asked(ship, tmp_path, current):
    speed = np.hypot(ship.column("surge_m_s"), ship.column("sway_m_s"))
    columns = {"time [s]": ship.time_s, "heading [deg]": np.degrees(ship.column("heading_rad")) % 360.0,
               "rudder [deg]": np.degrees(ship.rudder()), "north [m]": ship.column("north_m"),
               "east [m]": ship.column("east_m") + current * ship.time_s, "speed [m/s]": speed}  # fmt: skip
    draft = helmbench.draft_import(lines_of(tmp_path / "log.csv", columns), positive_rudder="starboard")
    told = next(one for one in draft.columns if one.column == "speed")
    assert (told.sure == "other channel") is (current == 0.0)


def test_of_two_pairs_of_units_the_one_that_fits_is_told(ship, tmp_path):
    columns = {"t": ship.time_s, "psi": ship.column("heading_rad"), "delta": np.degrees(ship.rudder()),
               "r": np.degrees(ship.column("yaw_rate_rad_s"))}  # fmt: skip
    units = {one.column: one.unit for one in helmbench.draft_import(lines_of(tmp_path / "log.csv", columns)).columns}
    assert units["psi"] == "rad" and units["r"] == "deg/s"


def test_stamps_that_were_rounded_are_spread_over_their_rows(ship, tmp_path):
    """Three significant digits: many rows repeat the time of the row before, ever more of them."""
    path = nameless(ship, tmp_path)
    lines = [line.split() for line in path.read_text("utf-8").splitlines()]
    path.write_text("\n".join(" ".join([f"{float(line[0]):.2E}", *line[1:]]) for line in lines), "utf-8")
    draft = helmbench.draft_import([path])
    found = draft.answer({draft.questions[0].id: "1"}).import_log()
    assert found.records[0].time_s == pytest.approx(ship.time_s, abs=0.1)


TANK = {1: "north", 2: "east", 3: "heading", 4: "velocity_north", 5: "velocity_east", 6: "yaw_rate", 8: "rudder"}
SEA = {1: "north", 2: "east", 4: "heading", 5: "velocity_north", 6: "velocity_east", 8: "yaw_rate", 9: "rudder"}
POND = {1: "north", 2: "surge", 3: "east", 4: "sway", 5: "heading", 6: "yaw_rate", 8: "rudder"}
RIVER = {1: "rudder", 2: "heading", 3: "yaw_rate", 4: "north", 5: "east"}
MEASURED = [
    *(("kvlcc2/hsva", f"*{run}.dat", 4, None, TANK) for run in ("Z_20_10_S", "Z_05_01", "Z_35_05", "Z_10_10_P")),
    *(("kvlcc2/marin", f"*{run}_m.dat", 3, None, SEA) for run in ("zz_20", "zz_-10", "tc_35")),
    *(("esso_osaka", f"zigzag*{run}.csv", 1, ",", POND) for run in ("13_42_53", "13_50_28", "14_03_39")),
    *(("otter", f"{run}.csv", 1, ",", RIVER) for run in ("heldout-0", "train-1")),
]


def test_measured_columns_in_any_order_are_told(rng):
    """Of the sets that are on this machine; `make test` takes every fourth run."""
    runs = MEASURED if SHIFT else MEASURED[::4]
    for folder, run, above, between, truth in (entry for entry in runs if (data_dir() / entry[0]).exists()):
        (path,) = (data_dir() / folder).glob(run)
        numbers = np.genfromtxt(path, skip_header=above, delimiter=between, encoding="cp1252")
        order = rng.permutation(np.arange(1, numbers.shape[1]))
        made = assignments(motion_of(numbers[:, 0], {f"c{i}": numbers[:, i] for i in order}, {}))
        assert {int(c[1:]): m.quantity for c, m in made[0].meanings.items()} == truth, path.name
