"""Tables of the leaderboard: standings, methods by conditions, failures, errors by record, timings."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...models.data_file import load
from ...models.errors import BadInput
from ...models.folders import check_regular
from ..numbers import duration, is_missing, number
from ..tables import Cell, Column, Table, field, make_table, with_least_marked
from .columns import FAILURE, STANDING
from .standings import Frame

FACTORS = {
    "noise": "noise",
    "disturbance": "disturbance",
    "thinning": "every n-th sample",
    "length": "share of the records",
    "train": "training records",
    "held_out": "held-out records",
    "model": "fitted model",
    "vessel": "vessel",
}
"""Titles of the factors of `standings.FACTORS`."""
CRITERIA = {"rel_error": "Parameter error", "nrmse": "Held-out NRMSE"}
MOST_FAILURES = 1000
"""Rows of the table of failures beyond which it says no conditions."""


def overall_table(overall: Frame) -> Table:
    """The standings over all cells."""
    return make_table(STANDING, _rows(overall), "Overall")


def matrices(overall: Frame, by: Mapping[str, Frame]) -> list[Table]:
    """Methods, best first, against the levels of each factor: the parameter error and the prediction error."""
    found = [
        _matrix(overall, frame, name, f"{title} by {FACTORS[factor]}")
        for factor, frame in by.items()
        for name, title in CRITERIA.items()
    ]
    return [table for table in found if len(table.columns) > 1]


def _matrix(overall: Frame, frame: Frame, name: str, title: str) -> Table:
    levels = list(dict.fromkeys(frame["group"]))
    most = frame.groupby("group")["cells"].max()
    rows = []
    for method in [method for method in overall["method"] if method in set(frame["method"])]:
        own = {row["group"]: row for row in _rows(frame[frame["method"] == method])}
        found = {level: (row[name], int(row["cells"]), int(most[level])) for level, row in own.items()}
        if not all(is_missing(value) for value, *_ in found.values()):
            rows.append({"method": method} | found)
    columns = [field("method"), *(_compared(level) for level in levels)]
    return with_least_marked(make_table(columns, rows, title), _in_every_cell)


def _compared(level: str) -> Column:
    """A column of (value, cells, most cells), with the number of cells where it is below the most."""

    def text(row: Mapping[str, Any]) -> str:
        value, cells, most = row.get(level, (None, 0, 0))
        return number(value) if cells == most or is_missing(value) else f"{number(value)} ({cells} of {most})"

    return Column(level, text, lambda row: row.get(level, (None,))[0])


def _in_every_cell(cell: Cell) -> bool:
    """Whether a cell of `_matrix` is a median over as many cells as any other there."""
    return " of " not in cell.text


def failure_table(failures: Frame) -> Table:
    """What failed, did not apply or did not converge, and why; the most frequent reasons where there are many."""
    title = "Failed, not applicable, not converged"
    if len(failures) <= MOST_FAILURES:
        return make_table(FAILURE, _rows(failures), title)
    reasons = failures.groupby(["status", "label", "error"], observed=True, sort=True)["runs"].sum().reset_index()
    kept = reasons.sort_values("runs", ascending=False, kind="stable").head(MOST_FAILURES)
    note = f"Put together over all conditions; the {len(kept)} most frequent of {len(reasons)} reasons."
    columns = [column for column in FAILURE if column.title in ("status", "method", "reason", "runs")]
    return make_table(columns, _rows(kept), title, note)


def _rows(frame: Frame) -> list[dict[str, Any]]:
    return frame.to_dict("records")


# ---- Errors of every held-out record of measured ships by themselves.

RECORDS_TITLE = "Errors by record, measured ships"
RECORDS_NOTE = (
    "Free-run error of every held-out record, mean over channels of sqrt(1 - R2), nothing refitted; a dash where it "
    "diverged. `helmbench run --suite SUITE --vessel SHIP --method METHOD -o DIR` makes a row again."
)


def record_table(results: Frame) -> Table:
    """One row a ship, fitted model, method and selection of records; none where no measured run is scored."""
    columns = [
        *(field(name) for name in ("vessel", "model", "method", "train", "noise")),
        Column(
            "error by record",
            lambda row: _record_errors(row["nrmse_by_record"]),
            lambda row: _mean_error(row["nrmse_by_record"]),
        ),
    ]
    known = results[results["nrmse_by_record"].notna()] if "nrmse_by_record" in results else results[:0]
    rows = known.sort_values(["vessel", "model", "noise", "method"]).to_dict("records")
    return make_table(columns, rows, RECORDS_TITLE, RECORDS_NOTE)


def _record_errors(text: Any) -> str:
    return ", ".join(f"{name} {number(error)}" for name, error in json.loads(text).items())


def _mean_error(text: Any) -> float | None:
    errors = list(json.loads(text).values())
    return None if None in errors else sum(errors) / len(errors)


# ---- Timings of the benchmark tests, shown beside a leaderboard.

TIMING_COLUMNS = (
    field("name", "what"),
    Column("median", lambda row: duration(row["median"]), lambda row: row["median"]),
    Column("quartiles", lambda row: f"{duration(row['q1'])} .. {duration(row['q3'])}", lambda row: row["q3"]),
    Column("rounds", lambda row: str(row["rounds"]), lambda row: row["rounds"]),
)


def timing_table(timings: Sequence[dict]) -> Table:
    """Median and quartiles of every timing."""
    return make_table(TIMING_COLUMNS, timings, "Timings", "Wall time, measured apart from this run.")


def read_timing(path: Path, required: bool = False) -> list[dict[str, Any]]:
    """Name, median, quartiles (s) and rounds from a benchmark JSON file; empty where there is none.

    Raises
    ------
    BadInput : the file is no benchmark JSON file, or it is required and missing.
    """
    if not required and not check_regular(path):
        return []
    try:
        found = load(path)["benchmarks"]
        pick = ("median", "q1", "q3", "rounds")
        return sorted(
            ({"name": entry["name"], **{key: entry["stats"][key] for key in pick}} for entry in found),
            key=lambda entry: entry["name"],
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"is not a benchmark JSON file ({type(error).__name__}: {error})", file=path) from None
