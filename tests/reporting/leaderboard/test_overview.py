"""What a terminal shows of a leaderboard: one ranking whose figures and counts are those of the runs."""

import re

from helmbench.reporting.leaderboard.page import write_report

SHIPS = ("cargo", "patrol", "remus-kt", "response-1", "response-2")


def rows_of(text):
    """The table of a text: rows of cells, without the rule."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in (lines[0], *lines[2:])]


def overview_of(folder_of, run_of, errors, **facts):
    runs = [
        run_of(error=error, r2=1.0 - error, method=method, vessel=ship, **facts)
        for method, error in errors.items()
        for ship in SHIPS
    ]
    return write_report(folder_of("out", runs)).overview


def test_one_table_holds_every_method_best_first_with_its_errors(folder_of, run_of):
    told = overview_of(folder_of, run_of, {"worse": 0.25, "good": 0.01})
    assert len(re.findall(r"^\|[ -]*-", told, re.MULTILINE)) == 1 and len(told.splitlines()) < 20
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
    told = write_report(folder_of("out", runs)).overview
    assert [row[0] for row in rows_of(told)[1:]] == ["a", "b", "few"]
    assert "Compared on fewer of the 5 problems (less than 90 %: below the others): few 2." in told


def test_problems_without_a_finite_prediction_are_counted(folder_of, run_of):
    runs = [run_of(error=0.1, r2=0.9, method="a", vessel=ship) for ship in SHIPS]
    runs += [run_of(error=0.2, r2=0.8, method="b", vessel=ship, diverged=ship == "cargo") for ship in SHIPS[:-1]]
    runs += [run_of(method="b", vessel=SHIPS[-1], status="failed", reason="singular")]
    told = write_report(folder_of("out", runs)).overview
    assert "Problems in which it failed or diverged and ranks last: b 2." in told and "1 failed" in told


def test_records_of_ships_without_truth_have_no_parameter_errors(folder_of, run_of):
    runs = [run_of(r2=r2, method=m, vessel=ship) for m, r2 in (("a", 0.9), ("b", 0.8)) for ship in SHIPS]
    assert "parameters" not in rows_of(write_report(folder_of("out", runs)).overview)[0]
