"""The published leaderboard says what its stored results say; two folders of results are compared by pairs."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from helmbench.bench.store import read_tables
from helmbench.models.errors import BadInput
from helmbench.reporting.leaderboard import comparing, publish, standings
from helmbench.reporting.leaderboard.answer import stability_sentences
from helmbench.reporting.leaderboard.board import build
from helmbench.reporting.leaderboard.findings import findings
from helmbench.reporting.tables import in_markdown

STORED = Path(__file__).parents[3] / "reports" / "leaderboard"


@pytest.fixture
def folder(folder_of, run_of, parameter_of):
    """Results of three methods, one a black box, at two noises and with wind."""
    runs = []
    for m, factor in (("pem", 1.0), ("ls", 1.5), ("arx", 4.0)):
        for v in ("cargo", "mariner", "s175"):
            for n, d in (("low", "none"), ("high", "none"), ("low", "wind:8@40deg")):
                e = 0.01 * factor * (3.0 if n == "high" else 1.0) * (2.0 if d != "none" else 1.0)
                rows = [] if m == "arx" else [parameter_of("K", 1.0, 1.0 + e, 0.005)]
                facts = {
                    "method": m,
                    "vessel": v,
                    "noise": n,
                    "disturbance": d,
                    "cpu_s": 1 / factor,
                }
                runs.append(run_of(error=None if m == "arx" else e, r2=1.0 - e**2, parameters=rows, **facts))
    return folder_of("default", runs)


def by_problem(table, method, figure):
    """Problem and method -> median of a figure."""
    found = table.groupby([*standings.CELL, method], observed=True)[figure].median()
    return {" ".join(map(str, key)): value for key, value in found.items()}


def check_published(folder):
    """README and page hold what the stored tables give."""
    results, parameters = (pd.read_parquet(folder / name) for name in (publish.RESULTS, publish.PARAMETERS))
    every, tuning = publish.boards(results, parameters)
    runs, main = every.runs, every.in_problems_of(every.runs["suite"].iloc[0])
    readme, page = (folder / publish.README).read_text(), (folder / publish.PAGE).read_text()
    lines = publish.headline_lines(main.contest, every.contest)
    assert lines and all(in_markdown(line) in readme for line in lines)
    told = [in_markdown(text) for text, _ in publish.told(main, every, tuning)]
    assert all(text in readme for text in told) and ("## Findings" in readme) == bool(told)
    said = [in_markdown(text) for text in stability_sentences(main.contest)]
    assert said and all(text in readme for text in said)
    assert (publish.SLOW_BOARD in readme) == (folder / publish.SLOW).is_dir()
    order = [place.method for place in main.contest.order()]
    table = readme.split("## Ranking")[1].split("##")[0]
    lines = [line.split("|")[1].strip() for line in table.splitlines() if line.startswith("| ")]
    assert lines[2:][: len(order)] == order
    assert f"{len(results)} runs:" in readme and f"{len(results)} runs:" in page and len(page) < 6_000_000
    assert all(f'"{method}"' in page for method in order)
    table = pd.read_csv(folder / publish.TABLE, keep_default_na=False, na_values=[""], dtype={"length": float})
    assert (folder / publish.TABLE).stat().st_size <= 2_000_000 and table["runs"].sum() == len(runs)
    wanted = by_problem(runs, "label", "prediction_error")
    assert by_problem(table, "method", "nrmse") == pytest.approx(wanted, rel=1e-3, nan_ok=True)


def check_again(folder, copy):
    """Every file that is written from the tables is what the tables give, word by word."""
    shutil.copytree(folder, copy)
    publish.publish_again(copy)
    for path in (path for path in folder.iterdir() if path.is_file()):
        assert path.read_bytes() == (copy / path.name).read_bytes(), path.name


def test_the_published_leaderboard_says_what_its_results_say(folder, tmp_path):
    publish.publish([folder], tmp_path / "published")
    check_published(tmp_path / "published")
    check_again(tmp_path / "published", tmp_path / "again")
    for number, stored in enumerate((STORED, STORED / publish.SLOW)):
        if (stored / publish.RESULTS).is_file():
            check_published(stored)
            check_again(stored, tmp_path / f"again {number}")


@pytest.mark.nightly
def test_what_the_advice_is_worth_stands_on_page_and_readme(folder, tmp_path):
    said = "In 60 fresh situations the method that is advised errs less than 1.3 times the least error in 70 %."
    paths = publish.publish([folder], tmp_path)
    assert said not in "".join(path.read_text() for path in paths if path.name in (publish.README, publish.PAGE))
    (tmp_path / publish.ADVICE).write_text(f"# The advice tested\n\n{said}\n\nMore.\n")
    publish.publish_again(tmp_path)
    assert f"\n\n{said} See [advice.md](advice.md).\n\n" in (tmp_path / publish.README).read_text()
    assert f'<p class="sub" id="worth">{said}</p>' in (tmp_path / publish.PAGE).read_text()


@pytest.mark.nightly
def test_the_board_of_fits_that_take_minutes_is_linked(folder, tmp_path):
    publish.publish([folder], tmp_path / publish.SLOW)
    publish.publish([folder], tmp_path)
    link = f"[Where a fit may take minutes]({publish.SLOW}/{publish.README})"
    assert f"\n\n{link} {publish.SLOW_BOARD}\n\n" in (tmp_path / publish.README).read_text()


def test_findings_are_computed_from_the_results(folder):
    results, parameters = read_tables(folder)
    told = [text for text, _ in findings(build(results, parameters))]
    assert any("the black box errs 4.0 times as much" in text and "the grey box beats" in text for text in told)
    assert any(
        "With high noise, pem predicts best: median error 0.03 against 0.01 with low noise" in text for text in told
    )


@pytest.mark.nightly
def test_grey_against_black_box_beyond_the_training_records_comes_from_its_suite(folder, folder_of, run_of, tmp_path):
    apart = folder_of(
        "generalise",
        [
            run_of(r2=1.0 - e**2, method=method, vessel=vessel, train=train, suite="generalise")
            for method, e in (("pem", 0.3), ("arx", 0.1))
            for vessel in ("cargo", "mariner", "s175")
            for train in ("turn:20", "turn:35")
        ],
    )
    publish.publish([folder, apart], tmp_path / "published")
    readme = (tmp_path / "published" / publish.README).read_text()
    assert "Beyond the training records, in free runs the black box beats the grey box: pem" in readme
    assert "better in 0 of 6 problems" in readme and "better in 9 of 9 problems" in readme
    publish.publish([folder], tmp_path / "alone")
    assert "Beyond the training" not in (tmp_path / "alone" / publish.README).read_text()


def test_a_run_that_two_suites_have_is_taken_once(folder, folder_of, run_of, tmp_path):
    again = folder_of(
        "noise", [run_of(error=0.3, r2=0.5, method="pem", vessel="cargo"), run_of(error=0.3, method="new")]
    )
    results, parameters = publish.together([read_tables(folder), read_tables(again)])
    assert len(results) == 27 + 1 and set(parameters["suite"]) == {"made-up"}
    with pytest.raises(BadInput, match="holds no benchmark run"):
        publish.publish([tmp_path], tmp_path / "published")


def test_two_folders_are_compared_by_pairs(folder, folder_of, run_of):
    vessels = ("cargo", "mariner", "s175")
    better = [run_of(error=0.005, r2=1.0 - (0.5 * 0.01) ** 2, method="pem", vessel=v, cpu_s=2.0) for v in vessels] + [
        run_of(method="ls", vessel="cargo", status="failed", reason="singular"),
        run_of(method="new", r2=0.5),
    ]
    found = comparing.changes(read_tables(folder), read_tables(folder_of("other", better)))
    rows = {(row["method"], row["figure"]): row for row in found.rows}
    assert rows["pem", "prediction error"]["ratio"] == pytest.approx(0.5) and rows["pem", "CPU time"][
        "ratio"
    ] == pytest.approx(2)
    assert rows["pem", "parameter error"]["problems"] == 3 and found.only_second == 1 and found.only_first == 27 - 4
    assert [row["method"] for row in found.statuses] == ["ls"] and "0 to 1" in found.summary()
    same = comparing.changes(read_tables(folder), read_tables(folder))
    assert all(row["unchanged"] == row["problems"] and row["p"] == 1.0 for row in same.rows) and not same.statuses


def test_simpler_models_are_told_apart_from_the_ships_own(folder, folder_of, run_of):
    simple = [
        run_of(r2=1.0 - e**2, error=None, method=m, vessel=v, noise=n, model="nomoto-1", parameters=[])
        for m, e in (("pem", 0.4), ("ls", 0.5), ("arx", 0.2))
        for v in ("cargo", "mariner", "s175")
        for n in ("low", "high")
    ]
    results, parameters = publish.together([read_tables(folder), read_tables(folder_of("simple", simple))])
    told = [text for text, _ in findings(build(results, parameters))]
    assert any(
        text.startswith("Where the fitted model is not the ship's own, in free runs the black box") for text in told
    )
    assert any(
        "instead of the ship's own equations pem errs 0.4 instead of 0.02 in the median" in text for text in told
    )
