"""Choices about a whole log: its map is accepted again, and nothing of what was not chosen gets into the record."""

import json

import numpy as np
import pytest

import helmbench

from ...seeds import seed_of
from .bank.choice_cases import CHOICE_CASES, ROOT
from .bank.texts import D, fixed, series, table
from .bank.truth import sail


@pytest.fixture(scope="module")
def run():
    return sail(np.random.default_rng(seed_of("choices")), seconds=120.0)


def written(run, folder, **columns):
    s = series(run)
    return table(folder / "log.csv", {"time [s]": s["t"], "heading [deg]": s["heading"], **columns})


@pytest.mark.parametrize("name", ["AIS, three vessels in turn", "two scales by their names", "no rudder"])
def test_the_map_of_an_answered_log_is_accepted_and_gives_the_same_record(name, run, tmp_path):
    case = CHOICE_CASES[name]
    files = case.write(run, tmp_path)
    first = helmbench.import_log(files, answers=case.whole)
    first.write_mapping(tmp_path / "map.yaml")
    again = helmbench.import_log(files, mapping=tmp_path / "map.yaml")
    assert again.record.equals(first.record)


@pytest.mark.parametrize(("name", "line"), [("AIS, three vessels in turn", "rows_of: 219000002"),
                                            ("two scales by their names", "scale: model")])  # fmt: skip
def test_the_draft_of_a_map_asks_for_the_choice_above_its_tables(name, line, run, tmp_path):
    case = CHOICE_CASES[name]
    files = case.write(run, tmp_path)
    draft = helmbench.draft_import(files)
    assert [question.id for question in draft.questions] == list(case.whole)
    draft.write_mapping(tmp_path / "map.yaml")
    text = (tmp_path / "map.yaml").read_text("utf-8")
    assert text.index("# ASKED: The") < text.index("\ntables:")
    (tmp_path / "map.yaml").write_text(f"{line}\n{text}", "utf-8")
    chosen = helmbench.import_log(files, mapping=tmp_path / "map.yaml").record
    assert chosen.equals(helmbench.import_log(files, answers=case.whole).record)


def test_rows_of_other_vessels_and_values_that_are_not_available_stay_out(run, tmp_path):
    case = CHOICE_CASES["AIS, three vessels in turn"]
    files = case.write(run, tmp_path)
    found = helmbench.import_log(files, answers={"vessel": "219000002"})
    assert found.record.n == len(range(0, run.t.size, 4))
    assert "61 of 183 rows are of MMSI 219000002; those of others are left out" in " ".join(found.report.steps)
    other = helmbench.import_log(files, answers={"vessel": "219000001"})
    assert not {"heading_rad", "yaw_rate_rad_s", "surge_m_s"} & set(other.record.channels)
    assert "61 cells say 'not available'" in " ".join(other.report.steps)
    with pytest.raises(helmbench.BadInput, match="'219000009' is no vessel of the log; give one of: 2190"):
        helmbench.import_log(files, answers={"vessel": "219000009"})


def test_files_of_one_vessel_each_are_not_joined(run, tmp_path):
    (path,) = CHOICE_CASES["AIS, three vessels in turn"].write(run, tmp_path)
    header, *rows = path.read_text("utf-8").splitlines()
    files = []
    for mmsi, part in (("219000001", rows[:90]), ("219000002", rows[90:])):
        files.append(tmp_path / f"{mmsi}.csv")
        files[-1].write_text("\n".join([header, *(row for row in part if row.startswith(mmsi))]), "utf-8")
    (question,) = helmbench.draft_import(files).questions
    assert question.id == "vessel" and {answer.key for answer in question.answers} == {"219000001", "219000002"}
    chosen = helmbench.import_log(files, answers={"vessel": "219000002"}).record
    assert chosen.n == 31 and chosen.has("heading_rad")


def test_a_column_of_kinds_of_rows_is_none_of_vessels(run, tmp_path):
    s = series(run)
    rows = [f"{t},1,{h}," for t, h in zip(s["t"], s["heading"], strict=True)]
    other = [f"{t},2,,{d}" for t, d in zip(s["t"], s["rudder"], strict=True)]
    lines = [line for pair in zip(rows, other, strict=True) for line in pair]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],id,heading [deg],rudder [deg]", *lines]), "utf-8")
    assert "vessel" not in {question.id for question in helmbench.draft_import(tmp_path / "log.csv").questions}


@pytest.mark.parametrize("name", ["two scales by their names", "two scales by factors alone"])
def test_the_ship_has_its_own_time_speed_and_yaw_rate(name, run, tmp_path):
    files = CHOICE_CASES[name].write(run, tmp_path)
    record = helmbench.import_log(files, answers={"scale": "ship"}).record
    assert record.time_s[-1] == pytest.approx(ROOT * run.t[-1], rel=1e-4)
    np.testing.assert_allclose(record.column("surge_m_s"), ROOT * run.u, rtol=1e-3)
    np.testing.assert_allclose(record.column("yaw_rate_rad_s"), run.r / ROOT, atol=2e-5)


def test_the_time_of_the_model_is_stretched_for_the_ship(run, tmp_path):
    files = CHOICE_CASES["two scales, the time of the model without a mark"].write(run, tmp_path)
    found = helmbench.import_log(files, answers={"scale": "ship"})
    assert found.record.time_s[-1] == pytest.approx(ROOT * run.t[-1], rel=1e-3)
    assert "Time is a time of the model: times 6" in " ".join(found.report.steps)


def test_two_units_of_one_speed_are_no_two_scales(run, tmp_path):
    s = series(run)
    files = written(run, tmp_path, **{"SOG": s["sog"], "SOG 2": fixed(run.sog, 4), "rudder [deg]": s["rudder"]})
    assert "scale" not in {question.id for question in helmbench.draft_import(files).questions}


def test_two_propellers_that_turn_the_craft_the_other_way_are_asked(run, tmp_path):
    thrusts = {
        "port thrust [N]": fixed(40.0 - 50.0 * run.delta, 4),
        "stbd thrust [N]": fixed(40.0 + 50.0 * run.delta, 4),
    }
    files = written(run, tmp_path, **{"yaw rate [deg/s]": fixed(run.r * D, 4), **thrusts})
    (question,) = helmbench.draft_import(files).questions
    assert "The yaw rate answers them the other way round" in question.text
    assert question.answers[0].key == "stbd thrust, port thrust"
    record = helmbench.import_log(files, answers={question.id: question.answers[0].key}).record
    np.testing.assert_allclose(record.column("rudder_command_rad"), 100.0 * run.delta, atol=1e-3)
    doubtful = helmbench.import_log(files, answers={question.id: question.answers[1].key})
    assert any("the ship turns against its two propellers" in fault.message for fault in doubtful.report.faults)


def test_two_rudders_that_move_as_one_have_no_order(run, tmp_path, rng):
    noisy = run.delta * D + 0.1 * rng.standard_normal(run.t.size)
    files = written(run, tmp_path, **{"Rudder A [deg]": fixed(run.delta * D, 2), "Rudder B [deg]": fixed(noisy, 2)})
    record = helmbench.draft_import(files)
    assert {c.quantity for c in record.columns if c.column.startswith("Rudder")} <= {"rudder", "not used"}


def test_a_rudder_in_volts_is_no_log_without_a_rudder(run, tmp_path):
    files = written(run, tmp_path, **{"Rudder [V]": fixed(2.5 + 2.0 * run.delta, 3)})
    (question,) = helmbench.draft_import(files).questions
    assert question.id == "rudder" and [answer.key for answer in question.answers][-1] == "none"
    assert "rudder_rad" not in helmbench.import_log(files, answers={"rudder": "none"}).record.channels


def test_the_page_says_how_surely_each_channel_is_known(run, tmp_path):
    s = series(run)
    found = helmbench.import_log(written(run, tmp_path, **{"ROT": s["rot_min"], "rudder [deg]": s["rudder"]}))
    sure = {row["channel"]: (row["columns"], row["sure"]) for row in found.to_dict()["channels"]}
    assert sure["heading_rad"] == (("heading",), "stated") and sure["rudder_rad"] == (("rudder",), "stated")
    assert sure["yaw_rate_rad_s"] == (("ROT",), "told by another channel")
    assert "told by another channel" in found.summary()
    twin = {"left motor": fixed(run.delta, 4), "right motor": fixed(-run.delta, 4), "yaw rate [deg/s]": s["rot_s"]}
    assumed = helmbench.import_log(written(run, tmp_path, **twin)).to_dict()["channels"]
    assert {row["channel"] for row in assumed if row["sure"] == "assumed"} == {
        "thrust_port_N", "thrust_starboard_N", "rudder_command_rad",
    }  # fmt: skip


def deltas(run, path, contexts):
    """Signal K's deltas of vessels: context -> how much its heading is turned, rad."""
    rows = []
    for t, psi, delta in zip(run.t, run.psi, run.delta, strict=True):
        for context, turned in contexts.items():
            values = [{"path": "navigation.headingTrue", "value": (psi + turned) % (2.0 * np.pi)}]
            values += [{"path": "steering.rudderAngle", "value": delta}] if turned == 0.0 else []
            stamp = f"2026-05-04T10:{int(t // 60):02d}:{t % 60:06.3f}Z"
            rows.append({"context": context, "updates": [{"timestamp": stamp, "values": values}]})
    path.write_text("\n".join(map(json.dumps, rows)), "utf-8")
    return path


def test_deltas_of_other_vessels_stay_out(run, tmp_path):
    other, own = "vessels.urn:mrn:imo:mmsi:211000001", "vessels.urn:mrn:imo:mmsi:211000002"
    path = deltas(run, tmp_path / "self.jsonl", {other: 1.0, "vessels.self": 0.0})
    record = helmbench.import_log(path).record
    np.testing.assert_allclose(np.unwrap(record.column("heading_rad")), np.unwrap(run.psi), atol=1e-3)
    path = deltas(run, tmp_path / "two.jsonl", {other: 1.0, own: 0.0})
    (question,) = helmbench.draft_import(path).questions
    assert question.id == "vessel" and {answer.key for answer in question.answers} == {other, own}
    record = helmbench.import_log(path, answers={"vessel": own}).record
    np.testing.assert_allclose(np.unwrap(record.column("heading_rad")), np.unwrap(run.psi), atol=1e-3)


def answered_in_its_map(files, place, choice):
    """The import of a log whose draft has the lines of an answer in the place of those of the same columns."""
    draft = helmbench.draft_import(files)
    (question,) = draft.questions
    draft.write_mapping(place, force=True)
    text = place.read_text("utf-8")
    for line in question.answers[choice].line.splitlines():
        name = line.partition(",")[0]
        text = "\n".join(f"      {line}" if own.strip().startswith(name) else own for own in text.splitlines())
    place.write_text(text, "utf-8")
    return helmbench.import_log(files, mapping=place).record


def test_a_column_that_waits_for_an_answer_is_used_after_it(run, tmp_path):
    columns = {"yaw rate [deg/s]": fixed(run.r * D, 4), "x [m]": fixed(run.north, 2), "y [m]": fixed(run.east, 2),
               "rudder [deg]": fixed(run.delta * D, 2)}  # fmt: skip
    files = table(tmp_path / "log.csv", {"time [s]": series(run)["t"], **columns})
    record = answered_in_its_map(files, tmp_path / "map.yaml", 0)
    np.testing.assert_allclose(record.column("east_m"), run.east, atol=0.02)


def test_the_other_one_of_two_rudders_is_chosen_in_the_map(run, tmp_path):
    fixed_one = {"rudder port [deg]": fixed(8.0 * np.sin(run.t), 2), "rudder stbd [deg]": fixed(run.delta * D, 2)}
    record = answered_in_its_map(written(run, tmp_path, **fixed_one), tmp_path / "map.yaml", 1)
    np.testing.assert_allclose(record.column("rudder_rad"), run.delta, atol=1e-3)


@pytest.mark.parametrize(("line", "revolutions"), [("RPM stbd, to: propeller, unit: rpm", 2.5),
                                                   ("RPM stbd, to: not used", 2.0),
                                                   ("RPM port, to: propeller, unit: rpm", 2.0)])  # fmt: skip
def test_one_line_of_the_map_says_which_of_two_columns_is_used(line, revolutions, run, tmp_path):
    s, slow = series(run), 120.0 + np.sin(run.t)
    columns = {"rudder [deg]": s["rudder"], "RPM port": fixed(slow), "RPM stbd": fixed(slow + 30.0)}
    files = written(run, tmp_path, **columns)
    draft = helmbench.draft_import(files)
    assert len(draft.questions) == 1 and "which one is used" in draft.questions[0].text
    draft.write_mapping(tmp_path / "map.yaml")
    open_line = f'- {{column: {line.partition(",")[0]}, to: "?"}}'
    text = (tmp_path / "map.yaml").read_text("utf-8")
    assert text.count(open_line) == 1
    (tmp_path / "map.yaml").write_text(text.replace(open_line, f"- {{column: {line}}}"), "utf-8")
    record = helmbench.import_log(files, mapping=tmp_path / "map.yaml").record
    np.testing.assert_allclose(np.median(record.column("propeller_rps")), revolutions, rtol=0.01)


def test_speeds_of_bow_and_stern_are_no_sway(run, tmp_path, rng):
    sway = np.convolve(-12.0 * run.r, np.ones(24) / 24.0)[: run.t.size]  # later than the yaw rate

    def shown(ahead):
        return fixed((sway + ahead * run.r + 0.02 * rng.standard_normal(run.t.size)) / (1852.0 / 3600.0))

    speeds = {"Bow transverse speed [kn]": shown(60.0), "Stern transverse speed [kn]": shown(-50.0)}
    s = series(run)
    columns = {"rudder [deg]": s["rudder"], "ROT [deg/min]": s["rot_min"], **speeds}
    found = helmbench.import_log(written(run, tmp_path, **columns))
    assert not found.record.has("sway_m_s")
    assert "110 m times the yaw rate" in next(c.why for c in found.report.columns if c.column.startswith("Bow"))
    twins = {"Sway speed [m/s]": fixed(sway), "Transverse speed [kn]": fixed(sway)}  # one with a wrong unit
    assert helmbench.draft_import(written(run, tmp_path, **columns | dict.fromkeys(speeds, s["t"]) | twins)).questions


def test_the_track_tells_which_of_two_headings_is_that_of_the_ship(run, tmp_path):
    s = series(run)
    athwart = {"GPS heading [deg]": fixed((run.psi * D + 90.0) % 360.0, 2)}
    columns = athwart | {"rudder [deg]": s["rudder"], "lat [deg]": s["lat"], "lon [deg]": s["lon"]}
    record = helmbench.import_log(written(run, tmp_path, **columns)).record
    np.testing.assert_allclose(np.sin(record.column("heading_rad")), np.sin(run.psi), atol=1e-3)


@pytest.mark.parametrize(("every", "status"), [(15, "left out"), (5, "mend or remove them")])
def test_rows_that_end_early_are_left_out_where_they_are_few(every, status, run, tmp_path):
    s = series(run)
    (path,) = written(run, tmp_path, **{"rudder [deg]": s["rudder"], "ROT [deg/min]": s["rot_min"]})
    header, *rows = path.read_text("utf-8").splitlines()
    rows = [row.rpartition(",")[0] if 0 < k < len(rows) - 1 and k % every == 0 else row for k, row in enumerate(rows)]
    path.write_text("\n".join([header, *rows]), "utf-8")
    if status != "left out":
        with pytest.raises(helmbench.BadInput, match=status):
            helmbench.import_log(path)
        return
    found = helmbench.import_log(path)
    assert status in " ".join(fault.hint for fault in found.report.faults)
    rows = np.round(found.record.time_s / 0.5).astype(int)
    np.testing.assert_allclose(found.record.column("yaw_rate_rad_s"), run.r[rows], atol=1e-4)


def test_a_rudder_that_is_called_an_angle_is_in_degrees(run, tmp_path):
    s = series(run)
    found = helmbench.draft_import(written(run, tmp_path, **{"rudder_ang": s["rudder"], "ROT [deg/min]": s["rot_min"]}))
    assert not found.questions and next(c.unit for c in found.columns if c.column == "rudder_ang") == "deg"
