"""Raw logs of different make, imported by one command and answers to what it asks, against the run in them."""

import datetime

import numpy as np
import pytest
import yaml

from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import read_record

from ...nightly_marks import nightly_but
from .raw_logs import LOGS, START

pytestmark = pytest.mark.usefixtures("logs_read_here")
EXACT = 2e-3
"""Largest difference over the channel's range: rounding of the log to two digits of a degree or knot."""
RESAMPLED = {"autopilot": 0.06, "auv_topics": 0.03, "sheets": 0.03}
"""Logs of several rates: the rudder's corners and the speeds made of coarse courses are rounded by averaging."""


@pytest.fixture(scope="module")
def sources():
    return {
        "mariner": generate(Case("mariner", "zigzag:20/20", duration_s=240.0, dt_s=0.5)),
        "kvlcc2-l7": generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=90.0, dt_s=0.2)),
    }


CLOCKWISE = {"sign": 1}
ANSWERS = {
    "auv_topics": {"yaw_rad": CLOCKWISE, "yaw_rate_rad_s": CLOCKWISE},
    "matlab": {"psi": CLOCKWISE, "r": CLOCKWISE, "v": CLOCKWISE},
    "midnight": {
        "Yaw": CLOCKWISE,
        "Yaw rate": CLOCKWISE,
        "Helm angle": {"to": "rudder", "unit": "deg"},
        "Sway": CLOCKWISE,
    },
}
"""Log -> column -> what is put into the draft where it asks."""


def imported(make, files, out):
    """Import as a user does: --yes, and where that stops, the draft with its answers."""
    if make not in ANSWERS:
        return status_of(["import", *map(str, files), "--yes", "-o", str(out)])
    draft = out.with_name("draft.yaml")
    assert status_of(["import", *map(str, files), "--yes", "-o", str(out)]) == 2
    assert not out.exists()
    assert status_of(["import", *map(str, files), "--map", str(draft), "-o", str(out)]) == 2
    content = yaml.safe_load(draft.read_text("utf-8"))
    for column in (column for table in content["tables"] for column in table["columns"]):
        column |= ANSWERS[make].get(column["column"], {})
    draft.write_text(yaml.safe_dump(content), "utf-8")
    return status_of(["import", *map(str, files), "--map", str(draft), "-o", str(out)])


def difference(name, record, source, time):
    """Largest difference of a channel over its range."""
    if name == "heading_rad":
        got, true = record.heading_unwrapped(), source.heading_unwrapped()
    else:
        got, true = record.column(name), source.column(name)
    true = np.interp(time, source.time_s, true)
    shift = got[0] - true[0] if name in ("north_m", "east_m") else 0.0
    return np.abs(got - shift - true).max() / np.ptp(true)


@pytest.mark.parametrize("ship", nightly_but(["mariner", "kvlcc2-l7"], "mariner"))
@pytest.mark.parametrize("make", LOGS)
def test_a_log_becomes_the_record_it_was_made_of(make, ship, sources, tmp_path, capsys):
    source = sources[ship]
    files = LOGS[make](source, tmp_path)
    out = tmp_path / "out.csv"
    assert imported(make, files, out) == 0, capsys.readouterr().err
    record = read_record(out)
    assert record.meta.positive_rudder == ("starboard" if make == "autopilot" else source.meta.positive_rudder)
    source = source.turned(record.meta.positive_rudder)
    stamp = record.meta.extra.get("start_utc") or record.meta.extra.get("start_of_unknown_zone", "")
    start = (datetime.datetime.fromisoformat(f"{stamp[:23]}+00:00") - START).total_seconds() if stamp else 0.0
    wanted = {"rudder_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s"}
    assert wanted <= record.channels.keys()
    assert (make in ("matlab", "midnight")) or record.has("north_m", "east_m")
    assert record.time_s[-1] > 0.95 * (source.time_s[-1] - 2.0)
    compared = [name for name in record.channels if name in source.channels and np.ptp(source.column(name)) > 0.0]
    found = {name: difference(name, record, source, record.time_s + start) for name in compared}
    assert {k: v for k, v in found.items() if not v < RESAMPLED.get(make, EXACT)} == {}


@pytest.mark.parametrize("make", ["bridge", "german", "auv_topics"])
def test_the_mapping_that_was_written_imports_the_next_log(make, sources, tmp_path, capsys):
    first, second = (tmp_path / name for name in ("first", "second"))
    first.mkdir()
    second.mkdir()
    files = LOGS[make](sources["mariner"], first)
    assert imported(make, files, first / "out.csv") == 0
    again = LOGS[make](sources["mariner"].between(0.0, 200.0), second)
    command = ["import", *map(str, again), "--map", str(first / "out.map.yaml"), "-o", str(second / "out.csv")]
    assert status_of(command) == 0, capsys.readouterr().err
    one, other = read_record(first / "out.csv"), read_record(second / "out.csv")
    shared = min(one.n, other.n) - 5
    for name in one.channels:
        assert other.column(name)[5:shared] == pytest.approx(one.column(name)[5:shared], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(("share", "status"), [(0.12, 0), (1.0, 2)])
def test_sentences_with_a_wrong_checksum_are_kept_aside(share, status, sources, rng, tmp_path, capsys):
    """One sentence of eight is a noisy line, but at the ends, which a lost sentence would move; where all are wrong,
    there is no log."""
    (path,) = LOGS["autopilot"](sources["mariner"], tmp_path)
    lines = path.read_text("utf-8").splitlines()
    noisy = range(len(lines)) if share == 1.0 else range(50, len(lines) - 50)
    wrong = [
        line[:-2] + "ZZ" if "*" in line and k in noisy and rng.random() < share else line
        for k, line in enumerate(lines)
    ]
    path.write_text("\n".join(wrong), "utf-8")
    assert status_of(["import", str(path), "--yes", "-o", str(tmp_path / "out.csv")]) == status
    told = capsys.readouterr()
    if status == 0:
        assert "rows are wrong, this is the first" in told.out + told.err
        record = read_record(tmp_path / "out.csv")
        assert np.ptp(record.time_s) == pytest.approx(np.ptp(sources["mariner"].time_s), abs=2.0)
