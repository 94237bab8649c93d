"""`helmbench import`: confirming the mapping, cutting into manoeuvres, JSON, the Python side."""

import io
import json

import click
import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import read_record


@pytest.fixture
def log(tmp_path):
    """A raw log of two zigzags with a straight run between and a column of remarks; its path."""
    run = generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=100.0, dt_s=0.5))
    rudder, psi = np.degrees(run.rudder()), np.degrees(run.heading_unwrapped())
    rate, none = np.degrees(run.column("yaw_rate_rad_s")), np.zeros(80)
    columns = (
        np.concatenate(x) for x in ((psi, none + psi[-1], psi + psi[-1]), (rate, none, rate), (rudder, none, rudder))
    )
    rows = zip(*columns, strict=True)
    lines = [f"{i / 2:.1f},{a % 360:.3f},{b:.4f},{c:.3f},remark" for i, (a, b, c) in enumerate(rows)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["Time [s],Heading [deg],ROT [deg/s],Rudder [deg],Note", *lines]), "utf-8")
    return path


class Terminal(io.StringIO):
    """Standard input of a terminal."""

    def isatty(self):
        return True


@pytest.mark.parametrize(("answer", "status"), [(True, 0), (False, 2)])
def test_on_a_terminal_the_mapping_is_asked_for(answer, status, log, monkeypatch, capsys):
    monkeypatch.setattr("sys.stdin", Terminal())
    monkeypatch.setattr(click, "confirm", lambda text, **_: answer)
    out = log.with_name("out.csv")
    assert status_of(["import", str(log), "-o", str(out)]) == status
    shown = capsys.readouterr().out
    assert "yaw_rate" in shown and "agrees with column Heading" in shown and "other channel" in shown
    assert out.exists() == answer


def test_without_a_known_rudder_yes_takes_none_and_says_which_column_could_be_it(log, capsys):
    log.write_text(log.read_text("utf-8").replace("Rudder [deg]", "Pump"), "utf-8")
    out = log.with_name("out.csv")
    assert status_of(["import", str(log), "-o", str(out)]) == 2
    assert "is it one of these, or is there none? Columns: Pump" in capsys.readouterr().err
    assert status_of(["import", str(log), "--yes", "-o", str(out)]) == 0
    shown = capsys.readouterr()
    assert "Columns: Pump. Imported without it, by --yes" in shown.err and "there is no rudder in this log" in shown.out
    mapping = out.with_name("out.map.yaml")
    assert "rudder: none" in mapping.read_text("utf-8")
    assert status_of(["check", str(out)]) == 1
    again = log.with_name("again.csv")
    assert status_of(["import", str(log), "--map", str(mapping), "-o", str(again)]) == 0
    assert again.read_bytes() == out.read_bytes()
    capsys.readouterr()
    for command in (
        ["identify", str(out), "--model", "nomoto-1", "--method", "pem", "-o", str(log.with_name("m.json"))],
        ["identify", str(out), "--model", "auto", "-o", str(log.with_name("m.json"))],
        ["diagnose", "--model", "nomoto-1", "--train", str(out), "--held-out", str(out), "-o", str(log.with_name("d"))],
    ):
        assert status_of(command) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert "no rudder in this record" in line and "'helmbench check' needs none" in line


def test_yes_and_json_print_the_questions(log, capsys):
    log.write_text(log.read_text("utf-8").replace("Rudder [deg]", "Rudder [%]"), "utf-8")
    out = log.with_name("out.csv")
    assert status_of(["import", str(log), "--yes", "--json", "-o", str(out)]) == 2
    told = json.loads(capsys.readouterr().out)
    (question,) = told["questions"]
    assert question["about"] == "unit" and question["answers"][0]["key"] == "35" and not out.exists()


@pytest.mark.parametrize("given", ["2", "=28.5", ""])
def test_on_a_terminal_questions_are_asked(given, log, monkeypatch, capsys):
    log.write_text(log.read_text("utf-8").replace("Rudder [deg]", "Rudder [%]"), "utf-8")
    monkeypatch.setattr("sys.stdin", Terminal())
    monkeypatch.setattr(click, "prompt", lambda text, **_: given)
    monkeypatch.setattr(click, "confirm", lambda text, **_: True)
    out = log.with_name("out.csv")
    assert status_of(["import", str(log), "-o", str(out)]) == (0 if given else 2)
    assert out.exists() == bool(given)
    assert "how many degrees are 100 %?" in capsys.readouterr().out
    if given:
        largest = np.degrees(np.abs(read_record(out).rudder()).max())
        assert largest == pytest.approx({"2": 0.45, "=28.5": 0.285}[given] * 20.0, rel=1e-3)


def test_a_new_mapping_file_is_written_to_be_looked_at(log, capsys):
    out, mapping = log.with_name("out.csv"), log.with_name("map.yaml")
    command = ["import", str(log), "--map", str(mapping), "-o", str(out)]
    assert status_of(command) == 0 and mapping.exists() and not out.exists()
    assert status_of(command) == 0 and out.exists(), capsys.readouterr().err


def test_the_mapping_beside_the_record_is_used_and_kept(log, capsys):
    out, mapping = log.with_name("out.csv"), log.with_name("out.map.yaml")
    command = ["import", str(log), "--map", str(mapping), "-o", str(out)]
    assert status_of(command) == 0
    text = mapping.read_text("utf-8") + "# mine\n"
    mapping.write_text(text, "utf-8")
    assert status_of(command) == 0, capsys.readouterr().err
    assert out.exists() and mapping.read_text("utf-8") == text


def test_a_sign_in_the_mapping_turns_the_rudder(log):
    found = helmbench.import_log(log)
    table = found.mapping.tables[0]
    columns = tuple(c.model_copy(update={"sign": -1}) if c.to == "rudder" else c for c in table.columns)
    changed = found.mapping.model_copy(
        update={"tables": (table.model_copy(update={"columns": columns}),), "positive_rudder": None}
    )
    turned = helmbench.import_log(log, mapping=changed).record
    assert np.array_equal(turned.rudder(), -found.record.rudder())
    assert {turned.meta.positive_rudder, found.record.meta.positive_rudder} == {"port", "starboard"}


def test_manoeuvres_become_records_of_their_own(log, capsys):
    out = log.with_name("out.csv")
    assert status_of(["import", str(log), "--yes", "--segment", "--json", "-o", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    kinds = [record["name"].split("-")[1] for record in told["records"]]
    assert kinds.count("zigzag") == 2 and "straight" in kinds
    first = next(path for path in told["files"] if "zigzag-1" in path)
    record = read_record(first)
    assert record.meta.manoeuvre is not None and record.meta.manoeuvre.startswith("zigzag:20/")
    assert (log.with_name("out.aside.csv")).read_text("utf-8").startswith("time_s,Time,Note\n0.0,0.0,remark\n")


def test_several_records_are_not_taken_for_one(log):
    found = helmbench.import_log(log, segment=True)
    assert len(found.records) > 2
    with pytest.raises(helmbench.BadInput, match="take one of `records`"):
        _ = found.record


def test_files_of_one_logger_are_runs_or_go_on(log, tmp_path):
    lines = log.read_text("utf-8").splitlines()
    stamped = [lines[0].replace("Time [s]", "epoch")]
    for line in lines[1:]:
        seconds, rest = line.split(",", 1)
        stamped.append(f"{1.7e9 + float(seconds):.1f},{rest}")
    paths = []
    for number, part in enumerate((stamped[1:200], stamped[200:])):
        paths.append(tmp_path / f"part{number}.csv")
        paths[-1].write_text("\n".join([stamped[0], *part]), "utf-8")
    joined = helmbench.import_log(paths)
    assert joined.record.n == len(lines) - 1 and any("joined" in step for step in joined.report.steps)
    late = [line.replace("17000", "17001", 1) for line in stamped[200:]]
    paths[1].write_text("\n".join([stamped[0], *late]), "utf-8")
    assert [record.name for record in helmbench.import_log(paths).records] == ["part0", "part1"]


def test_a_log_that_is_not_understood_leaves_a_mapping_to_change(log, capsys):
    rows = [
        "t [s],psi,delta",
        *(f"{0.5 * i},{0.1 * np.sin(0.1 * i):.5f},{0.3 * np.sign(np.sin(0.1 * i)):.3f}" for i in range(90)),
    ]
    log.write_text("\n".join(rows), "utf-8")
    out, mapping = log.with_name("out.csv"), log.with_name("map.yaml")
    command = ["import", str(log), "--map", str(mapping), "--positive-rudder", "port", "-o", str(out)]
    assert status_of(command) == 2 and not out.exists()
    assert "psi is heading [rad], delta is rudder [rad]. Is this right?" in capsys.readouterr().err
    text = mapping.read_text("utf-8")
    assert "to: rudder, unit: rad" in text and "# ASKED: The file does not state these units" in text
    assert "# ASKED: Which way does 'psi' count?" in text and 'sign: "?"' in text
    assert status_of(command) == 2 and not out.exists()
    mapping.write_text(text.replace('"?"', "1"), "utf-8")
    assert status_of(command) == 0, capsys.readouterr().err
    assert read_record(out).rudder().max() == pytest.approx(0.3)


def test_a_rudder_that_never_moves_is_told_and_kept_in_the_notes(log, capsys):
    lines = log.read_text("utf-8").splitlines()
    still = [lines[0], *(",".join([*line.split(",")[:3], "0.0", "remark"]) for line in lines[1:])]
    log.write_text("\n".join(still), "utf-8")
    out = log.with_name("out.csv")
    assert status_of(["import", str(log), "--yes", "-o", str(out)]) == 0
    assert "was the rudder held, or is its sensor dead?" in capsys.readouterr().out
    assert "was the rudder held" in out.with_suffix(".yaml").read_text("utf-8")
