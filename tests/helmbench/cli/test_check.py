"""`helmbench check`: table, JSON, files, exit statuses."""

import json

import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of


@pytest.fixture
def file(tmp_path):
    record = helmbench.simulate("mariner", "zigzag:20/20", noise="medium", seed=5, duration_s=300.0)
    spoilt = record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + np.deg2rad(0.05))
    path = tmp_path / "run.csv"
    helmbench.write_record(spoilt, path)
    return path


def test_status_1_where_a_finding_matters_and_0_where_none_does(file, tmp_path, capsys):
    assert status_of(["check", str(file)]) == 1
    assert "yaw rate bias" in capsys.readouterr().out
    sound = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=5, duration_s=300.0)
    helmbench.write_record(sound, tmp_path / "sound.csv")
    assert status_of(["check", str(tmp_path / "sound.csv"), "--quiet"]) == 0


def test_json_and_files_say_the_same(file, tmp_path, capsys):
    assert status_of(["check", str(file), "--json", "-o", str(tmp_path / "out")]) == 1
    assert json.loads(capsys.readouterr().out) == json.loads((tmp_path / "out" / "check.json").read_text("utf-8"))
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"check.json", "check.html"}


@pytest.mark.parametrize("arguments", [["check"], ["check", "nowhere.csv"], ["check", "nowhere.csv", "--json"]])
def test_bad_input_is_one_line(arguments, capsys):
    assert status_of(arguments) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_a_place_that_is_a_file_is_refused_and_nothing_written(file, capsys):
    assert status_of(["check", str(file), "-o", str(file)]) == 2
    assert "is a file" in capsys.readouterr().err
