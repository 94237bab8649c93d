"""The published timings: rows, verdicts, drawings; and the study worked out from a row."""

import json
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from helmbench.models.errors import BadInput
from helmbench.reporting.timing.page import publish, verdict
from helmbench.reporting.timing.rows import read_rows
from helmbench.reporting.timing.study_page import demands, page, study

PUBLISHED = Path(__file__).parents[3] / "reports" / "timing" / "rows.jsonl"
MACHINE = {"cpu": "a processor", "cpus": 2, "python": "3.11"}
PAIR = {"what": "ours, theirs", "unit": "rows/s", "ours": 400.0, "other": 100.0, "ratio": 4.0, "low": 3.5, "high": 4.5}
GROWING = {"what": "cost against samples: ls", "unit": "slope", "ours": 1.0, "axis": "samples"}
RUN = {
    **{"cpu_s": 0.01, "parent_cpu_s": 0.002, "start_cpu_s": 2.0},
    **{"stored_bytes": 1000.0, "parent_bytes": 4000.0, "fixed_bytes": 0.0},
}


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
    command = [sys.executable, "-m", "helmbench.reporting.timing.page", tmp_path / "none.jsonl", tmp_path / "out"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_study_is_the_product_of_its_parts():
    found = study(RUN, 1e6, 100)
    assert found["hours"] == pytest.approx(1e6 * 0.008 / 100 / 3600.0)
    assert found["cores_fed"] == pytest.approx(4.0)
    assert found["parent_hours"] == pytest.approx(2000.0 / 3600.0)
    assert found["calls_per_s"] * found["runs_together"] * 0.008 == pytest.approx(100.0)
    assert found["part_hours"] > found["hours"]
    assert found["runs_a_part"] * 0.01 * 0.01 == pytest.approx(2.0)


def test_what_breaks_first_is_what_is_scarcest():
    found = study(RUN, 1e6, 100)
    assert demands(found, 100, 1e12, 1e12)[0][0] == "the process that hands out and stores"
    assert demands(found, 100, 1e6, 1e12)[0] == ("its memory", pytest.approx(4000.0))


def test_the_page_of_a_study_has_its_figures(tmp_path):
    tiny = {"what": "a tiny run of a suite", "unit": "CPU s", "ours": 0.01, "run": RUN, "remark": "made up"}
    growing = {**GROWING, "points": [[1e3, 0.002], [1e4, 0.02]]}
    paths = publish(written(tmp_path, tiny, growing), tmp_path / "out", MACHINE)
    text = {path.name: path for path in paths}["study.md"].read_text()
    assert "| CPU time in a worker | 8 ms |" in text
    assert "| results on disk | 100 GB |" in text
    assert "| the process that hands out and stores | 250 |" in text
    assert f"| `ls` | 2 ms | {1e8 * 0.002 / 1000 / 3600:.3g} h | 1 |" in text


def test_the_published_study_is_that_of_the_published_rows():
    rows = read_rows(PUBLISHED)
    (tiny,) = (row for row in rows if row.run)
    assert page(tiny, rows) == (PUBLISHED.parent / "study.md").read_text()


def test_every_published_target_that_is_missed_says_why():
    rows = read_rows(PUBLISHED)
    assert any(row.run for row in rows) and any(row.axis == "samples" for row in rows)
    assert [row.what for row in rows if "not yet explained" in verdict(row)] == []
