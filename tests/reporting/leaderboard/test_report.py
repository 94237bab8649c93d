"""Reports are made from stored results, complete or not, and hide nothing."""

import csv
import html
import html.parser
import math
import re

import pytest

from helmbench.bench.store import Store, read_tables
from helmbench.models.errors import BadInput
from helmbench.reporting import numbers
from helmbench.reporting.leaderboard import page as report
from helmbench.reporting.leaderboard.standings import STANDING_COLUMNS
from helmbench.reporting.report import write_report


def finished_in(folder, manifest, run_of):
    """A directory with eight runs of three methods, one failed and one not applicable."""
    runs = [
        run_of(error=e, r2=1 - e, method=m, noise=n, vessel=v)
        for m, e in (("a", 0.01), ("b", 0.1))
        for n in ("none", "low")
        for v in ("cargo", "s175")
    ]
    runs += [
        run_of(method="c", vessel="cargo", status="failed", reason="<singular> | matrix"),
        run_of(method="c", vessel="s175", status="not_applicable", reason="no sway"),
    ]
    with Store.create(folder / "out", manifest(len(runs))) as store:
        for run in runs:
            store.append(run)
        store.write_tables()
    return folder / "out"


@pytest.fixture
def finished(tmp_path, manifest, run_of):
    return finished_in(tmp_path, manifest, run_of)


@pytest.fixture(scope="module")
def reported(tmp_path_factory, manifest, run_of):
    """(directory, its report) for tests that change neither."""
    folder = finished_in(tmp_path_factory.mktemp("reported"), manifest, run_of)
    return folder, report.write_report(folder)


class PageReader(html.parser.HTMLParser):
    """Checks that tags are balanced and collects texts and addresses."""

    VOID = ("meta", "br")

    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.cells, self.tables = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in ("src", "href")]
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, f"</{tag}> closes something else"

    def handle_data(self, data):
        self.cells += [data] if self.open and self.open[-1] == "td" else []
        if {"td", "th"} & set(self.open) and data.strip():
            self.tables[-1][-1].append(data)


def test_three_files_are_written_beside_the_results(finished):
    written = report.write_report(finished)
    assert [path.name for path in written.paths] == ["leaderboard.md", "leaderboard.csv", "leaderboard.html"]
    assert written.complete and all(path.stat().st_size > 500 for path in written.paths)
    assert written.markdown == (finished / "leaderboard.md").read_text()


def test_the_stored_tables_are_written_as_csv_too(finished):
    plain = write_report(finished).paths
    written = write_report(finished, csv=True).paths
    assert [path.name for path in written] == [*(path.name for path in plain), "runs.csv", "parameters.csv"]
    for path, frame in zip(written[-2:], read_tables(finished), strict=True):
        rows = list(csv.DictReader(path.read_text().splitlines()))
        assert list(rows[0]) == list(frame.columns) and len(rows) == len(frame)
        assert [row["method"] for row in rows] == list(frame["method"])
        number = "rel_error_median" if path.name == "runs.csv" else "estimate"
        assert [float(row[number] or "nan") for row in rows] == pytest.approx(list(frame[number]), rel=0.0, nan_ok=True)


def test_markdown_shows_ranks_intervals_and_failures(reported):
    text = reported[1].markdown
    overall = text.split("## Overall")[1].split("##")[0].strip().splitlines()
    assert [line.split("|")[1].strip() for line in overall if line.startswith("| ")][2:] == ["a", "b", "c"]
    assert "0.01 [0.01, 0.01]" in overall[2] and "1 / 1 / 2" in overall[4]
    assert "&lt;singular&gt; \\| matrix" in text and "no sway" in text
    assert "10 runs: 8 ok, 1 failed, 1 not applicable" in text


def test_every_line_of_a_markdown_table_has_the_same_columns(reported):
    for block in re.findall(r"(?:^\|.*\n)+", reported[1].markdown, flags=re.M):
        counts = {len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()}
        assert len(counts) == 1, block


def test_csv_holds_the_standings_with_fixed_columns(reported):
    rows = list(csv.DictReader((reported[0] / "leaderboard.csv").read_text().splitlines()))
    assert list(rows[0]) == STANDING_COLUMNS and [row["method"] for row in rows] == ["a", "b", "c"]


def test_html_is_one_balanced_page_without_outside_links(reported):
    text = (reported[0] / "leaderboard.html").read_text()
    page = PageReader(text)
    assert page.open == [] and all(link.startswith("#") for link in page.links)
    assert "<singular>" not in text and "<singular> | matrix" in page.cells
    assert text.count("<svg") == 0 and len(text) < 200_000


def test_an_incomplete_run_is_reported_as_such(tmp_path, manifest, run_of):
    with Store.create(tmp_path / "out", manifest(5)) as store:
        store.append(run_of(error=0.1, r2=0.9))
        written = report.write_report(tmp_path / "out")
    assert not written.complete and "INCOMPLETE: 1 of 5 runs are finished" in written.markdown
    assert "INCOMPLETE" in (tmp_path / "out" / "leaderboard.html").read_text()


@pytest.mark.nightly
def test_the_same_results_give_the_same_files(finished):
    first = [path.read_bytes() for path in report.write_report(finished).paths]
    assert first == [path.read_bytes() for path in report.write_report(finished).paths]


def test_nothing_is_reported_where_nothing_is(tmp_path, manifest):
    with pytest.raises(BadInput, match="holds no benchmark run"):
        report.write_report(tmp_path)
    Store.create(tmp_path / "out", manifest(5)).close()
    with pytest.raises(BadInput, match="no run is finished yet"):
        report.write_report(tmp_path / "out")
    assert not list(tmp_path.rglob("leaderboard*"))


def test_every_value_on_the_page_is_that_of_the_stored_results(reported):
    """The standings on the page, computed again here from the stored runs by the rules of `How to read it`."""
    folder = reported[0]
    results, _ = read_tables(folder)
    page = PageReader((folder / "leaderboard.html").read_text())
    columns = [title.strip() for title in page.tables[0][0]]
    shown = {row[0]: dict(zip(columns, row, strict=True)) for row in page.tables[0][1:]}
    assert set(shown) == {"a", "b", "c"}
    for method, own in results.groupby("method"):
        row = shown[method]
        ok = own[own["status"] == "ok"]
        failed, absent = ((own["status"] == status).sum() for status in ("failed", "not_applicable"))
        assert row["failed / n.a. / runs"] == f"{failed} / {absent} / {len(own)}"
        assert row["diverged"] == str(int(ok["diverged"].eq(True).sum()))
        error = float(ok["rel_error_median"].median()) if len(ok) else math.inf
        assert row["parameter error [95 %]"].split(" [")[0] == numbers.number(error)
        if len(ok):
            assert row["time"] == numbers.duration(float(ok["cpu_s"].median()))
            assert row["yaw rate R2"] == numbers.r_squared(float(ok["r2_free_yaw_rate_rad_s"].median()))
            rmse = numbers.DEG * float(ok["rmse_free_yaw_rate_rad_s"].median())
            assert row["yaw rate RMSE (deg/s)"] == numbers.number(rmse)


def test_page_markdown_and_csv_show_the_same_standings(reported):
    folder, text = reported[0], reported[1].markdown
    page = PageReader((folder / "leaderboard.html").read_text())
    lines = text.split("## Overall")[1].split("##")[0].strip().splitlines()
    told = [[html.unescape(cell.strip()) for cell in line.strip("|").split(" | ")] for line in [lines[0], *lines[2:]]]
    assert told == page.tables[0]
    stored = [row for row in csv.DictReader((folder / "leaderboard.csv").read_text().splitlines())]
    ranks = {row["method"]: numbers.number(float(row["mean_rank"])) for row in stored}
    assert {row[0]: row[1] for row in told[1:]} == ranks


# ---- What a terminal shows of a leaderboard: one ranking whose figures and counts are those of the runs.

SHIPS = ("cargo", "patrol", "remus-kt", "response-1", "response-2")


def rows_of(text):
    """The table of a text: rows of cells."""
    (block,) = [part for part in text.split("\n\n") if part.startswith("method ")]
    return [re.split(r"  +", line.strip()) for line in block.splitlines()]


def overview_of(folder_of, run_of, errors, **facts):
    runs = [
        run_of(error=error, r2=1.0 - error, method=method, vessel=ship, **facts)
        for method, error in errors.items()
        for ship in SHIPS
    ]
    return report.write_report(folder_of("out", runs)).overview


def test_one_table_holds_every_method_best_first_with_its_errors(folder_of, run_of):
    told = overview_of(folder_of, run_of, {"worse": 0.25, "good": 0.01})
    assert len(told.splitlines()) < 20
    assert rows_of(told) == [
        ["method", "rank", "parameters", "NRMSE", "RMSE", "R2", "time"],
        ["good", "1", "0.01", "0.1", "0.57", "0.990", "400 ms"],
        ["worse", "2", "0.25", "0.5", "0.57", "0.750", "400 ms"],
    ]
    assert told.startswith("Suite out, 10 runs: 10 ok, 0 failed, 0 not applicable; 0 diverged in free run.")
    assert "good (error 0.10" in told and "Every method was compared on all 5 problems." in told


def test_a_method_that_applies_to_fewer_problems_stands_below_and_is_named(folder_of, run_of):
    runs = [run_of(error=e, r2=1.0 - e, method=m, vessel=ship) for m, e in (("a", 0.1), ("b", 0.2)) for ship in SHIPS]
    runs += [run_of(error=0.001, r2=0.999, method="few", vessel=ship) for ship in SHIPS[:2]]
    runs += [run_of(method="few", vessel=ship, status="not_applicable", reason="no sway") for ship in SHIPS[2:]]
    told = report.write_report(folder_of("out", runs)).overview
    assert [row[0] for row in rows_of(told)[1:]] == ["a", "b", "few"]
    assert "Compared on fewer of the 5 problems (less than 90 %: below the others): few 2." in told


def test_problems_without_a_finite_prediction_are_counted(folder_of, run_of):
    runs = [run_of(error=0.1, r2=0.9, method="a", vessel=ship) for ship in SHIPS]
    runs += [run_of(error=0.2, r2=0.8, method="b", vessel=ship, diverged=ship == "cargo") for ship in SHIPS[:-1]]
    runs += [run_of(method="b", vessel=SHIPS[-1], status="failed", reason="singular")]
    told = report.write_report(folder_of("out", runs)).overview
    assert "Problems in which it failed or diverged and ranks last: b 2." in told and "1 failed" in told


def test_records_of_ships_without_truth_have_no_parameter_errors(folder_of, run_of):
    runs = [run_of(r2=r2, method=m, vessel=ship) for m, r2 in (("a", 0.9), ("b", 0.8)) for ship in SHIPS]
    assert "parameters" not in rows_of(report.write_report(folder_of("out", runs)).overview)[0]
