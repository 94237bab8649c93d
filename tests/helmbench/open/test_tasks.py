"""What a reading tells the page: questions wherever they stand, sampling of columns, and parts that analyses take."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import helmbench
from helmbench.models.result import page_of
from helmbench.open import parts, tasks
from helmbench.reporting.open.views import view_of

from .conftest import TIME, swing


def written(folder, name, columns, header=True):
    rows = [",".join(f"{value:.6f}" for value in row) for row in zip(*columns.values(), strict=True)]
    (folder / name).write_text("\n".join(([",".join(columns)] if header else []) + rows), "utf-8")
    return name


def read(folder, names, answers=(), choices=()):
    out = folder / "out"
    out.mkdir(exist_ok=True)
    return tasks.read_logs(str(folder), names, None, str(out), dict(answers), choices, None, lambda _: None)


@pytest.fixture(scope="module")
def zigzag():
    return helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1)


def test_columns_without_names_are_one_question_with_the_draft_beside_it(tmp_path):
    heading, rate, rudder = swing()
    name = written(tmp_path, "a.dat", {"t": TIME, "h": heading, "r": rate, "d": rudder}, header=False)
    found = read(tmp_path, [name])
    (question,) = found["questions"]
    assert question["about"] == "columns" and [one["key"] for one in question["answers"]][-1] == "none"
    proposed = [one["quantity"] for one in found["columns"] if one["table"] == question["table"]]
    assert proposed == ["time", "heading", "yaw_rate", "rudder"]
    done = read(tmp_path, [name], {question["id"]: "1"})
    assert done["questions"] == [] and done["line"] == "" and len(done["records"]) == 1
    (wrong,) = read(tmp_path, [name], {question["id"]: "none"})["questions"]
    assert wrong["about"] == "columns" and wrong["answers"][-1]["key"] == "several"
    refused = read(tmp_path, [name], {question["id"]: "none", wrong["id"]: "several"})
    assert len(refused["questions"]) > 1


def test_a_question_about_the_whole_log_is_among_the_questions(tmp_path):
    """Rows of two vessels: which one."""
    heading, rate, rudder = swing()
    columns = {"Time [s]": np.repeat(TIME, 2), "MMSI": np.tile([211000001.0, 211000002.0], TIME.size)}
    columns |= {"Heading [deg]": np.repeat(heading % 360.0, 2), "ROT [deg/s]": np.repeat(rate, 2)}
    columns |= {"Rudder [deg]": np.repeat(rudder, 2)}
    name = written(tmp_path, "ais.csv", columns)
    found = read(tmp_path, [name])
    asked = {question["id"]: question for question in found["questions"]}
    assert asked["vessel"]["about"] == "file"
    key = asked["vessel"]["answers"][0]["key"]
    assert "vessel" not in {question["id"] for question in read(tmp_path, [name], {"vessel": key})["questions"]}


def test_a_log_without_a_rudder_says_what_is_missing_and_holds_nothing_out(tmp_path):
    heading, rate, _ = swing()
    name = written(tmp_path, "a.csv", {"Time [s]": TIME, "Heading [deg]": heading % 360.0, "ROT [deg/s]": rate})
    found = read(tmp_path, [name])
    assert found["questions"] == []
    (record,) = found["records"]
    assert len(record["lacks"]) == 1 and "rudder" in record["lacks"][0]
    assert [part["role"] for part in found["parts"]] == ["train"]


def test_a_column_tells_its_rows_rate_and_missing_share():
    time, values = np.arange(10.0), np.array([1.0, np.nan] * 5)
    assert tasks.sampling(time, values, True) == {"rows": 10, "missing": 0.5, "rate": 0.5}
    assert tasks.sampling(time, values, False)["rate"] is None


def test_a_time_that_starts_again_is_drawn_over_rows(tmp_path):
    heading, rate, rudder = (np.tile(values, 2) for values in swing())
    columns = {
        "Time [s]": np.tile(TIME, 2),
        "Heading [deg]": heading % 360.0,
        "ROT [deg/s]": rate,
        "Rudder [deg]": rudder,
    }
    read(tmp_path, [written(tmp_path, "a.csv", columns)])
    for drawn in json.loads((tmp_path / "out" / tasks.COLUMNS).read_text("utf-8")):
        assert np.all(np.diff(drawn["time"]) > 0.0) and drawn["time"][-1] > TIME.size


def test_a_single_manoeuvre_is_split_without_a_common_sample(zigzag):
    first, last = parts.proposed([zigzag], ())
    assert (first["role"], last["role"]) == ("train", "held_out") and first["to"] < last["from"]
    cut = [zigzag.between(part["from"], part["to"]) for part in (first, last)]
    assert cut[0].n / (cut[0].n + cut[1].n) == pytest.approx(0.6, abs=0.01)
    helmbench.check(cut)


def test_scraps_and_common_samples_are_not_proposed(zigzag):
    """Two zigzags with a short deflection of the rudder between them; each begins in the lead of the one before."""
    pause, blip = np.zeros(120), np.full(30, 0.2)
    command = np.concatenate([zigzag.rudder(), pause, blip, pause, zigzag.rudder()])
    time = np.arange(command.size) * zigzag.dt
    record = replace(zigzag, time_s=time, channels={"rudder_rad": command, "yaw_rate_rad_s": np.gradient(command)})
    found = parts.proposed([record], ())
    assert [part["role"] for part in found] == ["train", "held_out"]
    assert all(part["to"] - part["from"] > 0.5 * zigzag.time_s[-1] for part in found)
    assert found[0]["to"] < found[1]["from"]


def test_a_run_that_stands_twice_is_not_used_and_said(zigzag):
    mirrored = replace(zigzag, name="again", channels={name: -values for name, values in zigzag.channels.items()})
    again = parts.copies([zigzag, mirrored])
    assert list(again) == [1] and "again" in again[1]
    found = parts.proposed([zigzag, mirrored], again)
    assert [(part["record"], part["role"]) for part in found] == [(0, "train"), (0, "held_out"), (1, "unused")]


def test_a_check_does_not_say_that_channels_agree_which_were_not_compared(zigzag):
    part = zigzag.slice(0, 30)
    short = replace(part, channels={name: part.channels[name] for name in ("heading_rad", "surge_m_s")})
    view = view_of(page_of(helmbench.check(short)))
    assert [part["title"] for part in view["parts"] if not part["folded"]] == ["What could not be checked"]
    assert view["sentence"].startswith("No finding in what could be checked")


def test_manoeuvres_of_a_record_share_no_sample(monkeypatch, zigzag):
    """The second begins where the first ends, a straight course is none, and a short rest of one is left out."""
    least = parts.MIN_SAMPLES
    ends = [(0, 4 * least, "turn"), (3 * least, 7 * least, "zigzag"), (7 * least, 9 * least, "straight"),
            (6 * least, 7 * least + 1, "turn")]  # fmt: skip
    drawn = [SimpleNamespace(start=a, stop=b, kind=kind) for a, b, kind in ends]
    monkeypatch.setattr("helmbench.datasets.importing.segments.find_segments", lambda record: drawn)
    spans = parts._spans(2, zigzag)
    assert spans == [(2, 0, 4 * least, "turn", 1), (2, 4 * least, 7 * least, "zigzag", 2)]
