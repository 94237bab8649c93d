"""What changed between two result folders: paired runs, with intervals."""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np

from ..numbers import interval, p_value
from ..tables import Column, Table, console, field, html, make_table, numeric
from .board import build
from .equivalence import holm, log_ratios, signed_rank
from .standings import CELL, FLOOR, Frame, bootstrap_interval

FIGURES = {"nrmse": "prediction error", "rel_error": "parameter error", "cpu_s": "CPU time"}
"""Column of the cells -> what is compared."""
SAME = 1e-4
"""Relative difference below which a figure counts as unchanged."""
ENDED = ("failed", "diverged", "not_applicable")
"""How runs end otherwise than well."""
RATIO = itemgetter("ratio")


@dataclass(frozen=True)
class Changes:
    """Differences between two folders of results.

    Attributes
    ----------
    rows : one a method and figure: `method`, `figure`, `problems`, `unchanged`, `ratio` (second / first, median over
        shared problems) with `low` and `high` at 95 %, and `p` (signed ranks, Holm-corrected over the rows).
    statuses : one a method: numbers of failed, diverged and not applicable runs in both, where they differ.
    only_first, only_second : numbers of problems and methods that only one of them has.
    """

    rows: tuple[dict[str, Any], ...]
    statuses: tuple[dict[str, Any], ...]
    only_first: int
    only_second: int

    def summary(self) -> str:
        """The tables as plain text."""
        told = f"{self.only_first} problems and methods only in the first, {self.only_second} only in the second."
        both = [one for one in (self.table(), self.status_table()) if one.rows]
        return "\n\n".join([told, *(f"{one.title}:\n{console(one, fit=True)}" for one in both)])

    def table(self) -> Table:
        """Ratios second / first by method and figure."""
        columns = [
            field("method"),
            field("figure"),
            Column("second / first [95 %]", lambda row: interval(row["ratio"], row["low"], row["high"]), RATIO),
            numeric("p", "p", p_value),
            numeric("problems", "problems", str),
            numeric("unchanged", "unchanged", str),
        ]
        return make_table(columns, self.rows, "Ratios of medians over shared problems")

    def status_table(self) -> Table:
        """Numbers of runs that ended otherwise."""
        columns = [field("method")] + [
            Column(name.replace("_", " "), lambda row, name=name: f"{row[name][0]} to {row[name][1]}") for name in ENDED
        ]
        return make_table(columns, self.statuses, "Runs that ended otherwise")

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        counts = {"only_first": self.only_first, "only_second": self.only_second}
        return {"figures": list(self.rows), "statuses": list(self.statuses)} | counts

    def _repr_html_(self) -> str:
        return html(self.table())

    def __repr__(self) -> str:
        changed = sum(row["p"] < 0.05 for row in self.rows)
        return f"<Changes of {len(self.rows)} figures, {changed} of them significant>"


def changes(first: tuple[Frame, Frame], second: tuple[Frame, Frame]) -> Changes:
    """Compare the tables (`store.read_tables`) of two folders, cell by cell and method by method."""
    keys = [*CELL, "label"]
    before, after = (build(*tables).cells for tables in (first, second))
    both = before.merge(after, on=keys, suffixes=("_a", "_b"))
    rows = []
    for method, own in both.groupby("label", sort=True, observed=True):
        for column, title in FIGURES.items():
            row = _row(own[f"{column}_a"].to_numpy(dtype=float), own[f"{column}_b"].to_numpy(dtype=float))
            rows += [{"method": str(method), "figure": title} | row] if row else []
    for row, p in zip(rows, holm([row["p"] for row in rows]), strict=True):
        row["p"] = float(p)
    sums = both.groupby("label", observed=True)[[f"{name}_{side}" for name in ENDED for side in "ab"]].sum()
    statuses = [
        {"method": str(method)} | {name: (int(row[f"{name}_a"]), int(row[f"{name}_b"])) for name in ENDED}
        for method, row in sums.iterrows()
    ]
    changed = [row for row in statuses if any(row[name][0] != row[name][1] for name in ENDED)]
    return Changes(tuple(rows), tuple(changed), len(before) - len(both), len(after) - len(both))


def _row(first: np.ndarray, second: np.ndarray) -> dict[str, Any] | None:
    """Ratio, interval and p of one figure; None where it has no pairs."""
    known = ~np.isnan(first) & ~np.isnan(second) & (first > 0.0) & (second > 0.0)
    first, second = np.maximum(first[known], FLOOR), np.maximum(second[known], FLOOR)
    if not first.size:
        return None
    logs = log_ratios(second, first)
    low, high = bootstrap_interval(logs, draws=1000)
    ratio, low, high = (float(np.exp(value)) for value in (np.median(logs), low, high))
    unchanged = int((np.abs(logs) < SAME).sum())
    p = signed_rank(logs)
    return {"problems": first.size, "unchanged": unchanged, "ratio": ratio, "low": low, "high": high, "p": p}
