"""Timings of the benchmark tests, shown beside a leaderboard."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...models.data_file import load
from ...models.errors import BadInput
from ...models.folders import check_regular
from ..numbers import duration
from ..tables import Column, Table, field, make_table

COLUMNS = (
    field("name", "what"),
    Column("median", lambda row: duration(row["median"]), lambda row: row["median"]),
    Column("quartiles", lambda row: f"{duration(row['q1'])} .. {duration(row['q3'])}", lambda row: row["q3"]),
    Column("rounds", lambda row: str(row["rounds"]), lambda row: row["rounds"]),
)


def timing_table(timings: Sequence[dict]) -> Table:
    """Median and quartiles of every timing."""
    return make_table(COLUMNS, timings, "Timings", "Wall time, measured apart from this run.")


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
