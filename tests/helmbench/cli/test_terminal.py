"""What a file says never steers the terminal, and no CSV that is written holds a formula."""

import csv

import numpy as np
import pandas as pd
import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.models.errors import BadInput, visible
from helmbench.reporting.tables import csv as csv_text
from helmbench.reporting.tables import from_frame

HOSTILE = "\x1b]0;title\x07\x9b2J\u202e\u2066\u200b"


def steers(text):
    return any(letter in text for letter in "\x1b\x07\x9b\u202e\u2066\u200b")


def test_control_and_direction_characters_are_shown_as_escapes():
    assert visible(HOSTILE + "é\n", kept="\n") == r"\x1b]0;title\x07\x9b2J\u202e\u2066\u200b" + "é\n"
    assert not steers(str(BadInput(HOSTILE, file=HOSTILE, column=HOSTILE, hint=HOSTILE)))


@pytest.mark.parametrize("command", ["check", "import", "identify --model nomoto-1 -o out.json", "report"])
def test_names_and_headers_never_steer_the_terminal(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    time = 0.5 * np.arange(200.0)
    path = tmp_path / f"{HOSTILE.replace('/', '')}.csv"
    rudder = 20.0 * np.sign(np.sin(time / 20.0))
    table = {"time [s]": time, "rudder [deg]": rudder, "heading [deg]": np.cumsum(0.02 * rudder), HOSTILE: time}
    pd.DataFrame(table).to_csv(path, index=False)
    first, *options = command.split()
    assert status_of([first, str(path), *options]) == 2
    said = capsys.readouterr()
    assert said.err and not steers(said.out + said.err)


def test_no_csv_that_is_written_holds_a_formula(tmp_path):
    time = 0.5 * np.arange(200.0)
    rudder = 20.0 * np.sign(np.sin(time / 20.0))
    formulas = ["=cmd|' /C calc'!A0", "@SUM(1)", "+1+1", "-2+3", "\t=1", "-5.5"] * 50
    log = pd.DataFrame({"time [s]": time, "rudder [deg]": rudder, "heading [deg]": np.cumsum(0.02 * rudder)})
    log["=HYPERLINK(1)"] = formulas[:200]
    log.to_csv(tmp_path / "log.csv", index=False)
    found = helmbench.import_log(tmp_path / "log.csv", positive_rudder="starboard")
    assert found.aside
    found.write(tmp_path / "out.csv")
    (written,) = [path for path in tmp_path.glob("*aside*")]
    with written.open(newline="", encoding="utf-8") as file:
        cells = [cell for row in csv.reader(file) for cell in row]
    cells += [cell for row in csv.reader(csv_text(from_frame(log)).splitlines()) for cell in row]
    risky = [cell for cell in cells if cell.lstrip().startswith(("=", "@", "+1+", "-2+"))]
    assert not risky and "'=HYPERLINK(1)" in cells and "-5.5" in cells
