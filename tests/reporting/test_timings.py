"""The published timings: rows, verdicts, drawings."""

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from helmbench.models.errors import BadInput
from helmbench.reporting.timing import publish, read_rows, verdict

PUBLISHED = Path(__file__).parents[2] / "reports" / "timing" / "rows.jsonl"
MACHINE = {"cpu": "a processor", "cpus": 2, "python": "3.11"}
PAIR = {"what": "ours, theirs", "unit": "rows/s", "ours": 400.0, "other": 100.0, "ratio": 4.0, "low": 3.5, "high": 4.5}
GROWING = {"what": "cost against samples: ls", "unit": "slope", "ours": 1.0, "axis": "samples"}


def written(folder, *rows):
    path = folder / "found.jsonl"
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return path


def test_a_pair_stands_with_its_range_target_and_verdict(tmp_path):
    met = {**PAIR, "repeats": 5, "target": ">= 3", "reached": True, "load": 0.2, "code": "1"}
    missed = {**PAIR, "what": "second", "target": ">= 5", "reached": False, "limit": "it is slow", "load": 0.2}
    absent = {"what": "third", "unit": "s", "target": ">= 2", "reached": None, "remark": "x is not installed"}
    (readme, *_) = publish(written(tmp_path, met, missed, absent), tmp_path / "out", MACHINE)
    text = readme.read_text()
    assert "4 (3.5 to 4.5, 5 repeats)" in text and "at least 3" in text and "1 of 2 targets are reached" in text
    assert "not reached: it is slow" in text and "x is not installed" in text
    assert "did other work" not in text


def test_what_is_slower_than_a_peer_stands_first_the_worst_of_it_at_the_top(tmp_path):
    pairs = [{**PAIR, "what": f"by {ratio}", "ratio": ratio} for ratio in (3.0, 0.9, 0.2)]
    text = publish(written(tmp_path, *pairs), tmp_path / "out", MACHINE)[0].read_text()
    places = [text.index(part) for part in ("## Slower", "by 0.2", "by 0.9", "## Pairs", "by 3.0")]
    assert places == sorted(places) and text.count("by 0.2") == 1
    text = publish(written(tmp_path, PAIR), tmp_path / "out", MACHINE)[0].read_text()
    assert "## Slower" not in text and "Nothing is slower" in text


def test_a_busy_machine_is_told(tmp_path):
    (readme, *_) = publish(written(tmp_path, {**PAIR, "load": 6.0}), tmp_path / "out", MACHINE)
    assert "load average 6.0" in readme.read_text()


def test_a_growing_cost_is_drawn(tmp_path):
    row = {**GROWING, "points": [[1e3, 0.001], [1e4, 0.01], [1e5, 0.1]]}
    paths = publish(written(tmp_path, row), tmp_path / "out", MACHINE)
    assert [path.name for path in paths] == ["README.md", "rows.jsonl", "samples.svg"]
    texts = " ".join(ElementTree.parse(paths[-1]).getroot().itertext())
    assert "ls (1.00)" in texts
    (left,) = (line for line in paths[0].read_text().splitlines() if line.startswith("Not measured yet"))
    assert "output-error" in left and " ls," not in left
    assert read_rows(paths[1])[0].points == row["points"]


def test_the_last_row_of_a_kind_counts(tmp_path):
    rows = read_rows(written(tmp_path, PAIR, {**PAIR, "ours": 500.0}))
    assert [row.ours for row in rows] == [500.0]


@pytest.mark.parametrize("text", ["", "{}\n", "[1]\n", "nonsense\n"])
def test_a_file_that_holds_no_rows_is_refused(tmp_path, text):
    path = tmp_path / "rows.jsonl"
    path.write_text(text)
    with pytest.raises(BadInput):
        read_rows(path)


def test_the_command_refuses_such_a_file_in_one_line(tmp_path):
    command = [sys.executable, "-m", "helmbench.reporting.timing", tmp_path / "none.jsonl", tmp_path / "out"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_every_published_target_that_is_missed_says_why():
    rows = read_rows(PUBLISHED)
    assert any(row.run for row in rows) and any(row.axis == "samples" for row in rows)
    assert [row.what for row in rows if "not yet explained" in verdict(row)] == []
