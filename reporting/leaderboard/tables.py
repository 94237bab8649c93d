"""Tables of the leaderboard and their columns: standings, methods by conditions, failures, errors by record, how far
ahead to trust methods, and what stated uncertainties are worth."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from ...bench.scores.errors_ahead import LENGTHS, PREFIXES
from ..numbers import DEG, MISSING, duration, interval, is_missing, number, percent, r_squared
from ..tables import Column, Table, field, make_table, numeric, with_least_marked
from .standings import Frame, labels, median

# ---- Columns.

Row = Mapping[str, Any]


def with_interval(title: str, name: str) -> Column:
    """A column of medians with their intervals."""
    ends = (name, f"{name}_low", f"{name}_high")
    return Column(title, lambda row: interval(*(row[end] for end in ends)), lambda row: row[name])


def _unless_one(value: float) -> str:
    return MISSING if value == 1 else number(value)


TIME = numeric("time", "cpu_s", duration)
STANDING = (
    field("method"),
    numeric("mean rank", "mean_rank"),
    numeric("by parameters", "rank_parameters"),
    numeric("by prediction", "rank_prediction"),
    with_interval("parameter error [95 %]", "rel_error"),
    with_interval("NRMSE [95 %]", "nrmse"),
    numeric("yaw rate RMSE (deg/s)", "rmse_yaw_rate_rad_s", scale=DEG),
    numeric("yaw rate R2", "r2_yaw_rate", r_squared),
    numeric("heading R2", "r2_heading", r_squared),
    numeric("efficiency", "efficiency"),
    Column("failed / n.a. / runs", "{failed} / {not_applicable} / {runs}".format_map, lambda row: row["failed"]),
    numeric("diverged", "diverged", str),
    numeric("cells", "cells", str),
    TIME,
)
FAILURE = (
    Column("status", lambda row: row["status"].replace("_", " ")),
    field("label", "method"),
    field("vessel"),
    field("error", "reason"),
    field("model"),
    field("train"),
    field("noise"),
    field("disturbance"),
    numeric("thinning", "thinning", _unless_one),
    numeric("length", "length", _unless_one),
    numeric("runs", "runs", str),
    field("seeds"),
)
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
    return with_least_marked(make_table(columns, rows, title), lambda cell: " of " not in cell.text)


def _compared(level: str) -> Column:
    """A column of (value, cells, most cells), with `3 of 5` cells behind the value where it has less than the most."""

    def text(row: Row) -> str:
        value, cells, most = row.get(level, (None, 0, 0))
        return number(value) if cells == most or is_missing(value) else f"{number(value)} ({cells} of {most})"

    return Column(level, text, lambda row: row.get(level, (None,))[0])


def failure_table(failures: Frame) -> Table:
    """What failed, did not apply or did not converge, and why."""
    return make_table(FAILURE, _rows(failures), "Failed, not applicable, not converged")


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
    errors = Column("error by record", _record_errors, _mean_error)
    columns = [*map(field, ("vessel", "model", "method", "train", "noise")), errors]
    known = results[results["nrmse_by_record"].notna()] if "nrmse_by_record" in results else results[:0]
    rows = known.sort_values(["vessel", "model", "noise", "method"]).to_dict("records")
    return make_table(columns, rows, RECORDS_TITLE, RECORDS_NOTE)


def _record_errors(row: Row) -> str:
    return ", ".join(f"{name} {number(error)}" for name, error in json.loads(row["nrmse_by_record"]).items())


def _mean_error(row: Row) -> float | None:
    errors = list(json.loads(row["nrmse_by_record"]).values())
    return None if None in errors else sum(errors) / len(errors)


# ---- How far ahead methods can be trusted on measured records, beside two predictions without a model.

AHEAD_KEYS = ["vessel", "method", "model"]
AHEAD_NOTE = (
    "Medians over runs on measured records. Trust: time ahead up to which heading and yaw rate are predicted better "
    "than by a ship that goes on turning as now and by one that goes straight. Errors of yaw rate ahead, deg/s, as "
    "model / goes on turning / goes straight; times are ship lengths, or times sqrt(T / K) where no length is known."
)
AHEAD_COLUMNS = ("trusted_s", "noise_", *(f"rmse_{prefix}_" for prefix in PREFIXES.values()))


def ahead_table(results: Frame) -> Table:
    """Methods on measured records by how far ahead to trust them; no row where no run was scored ahead."""
    rows: list[dict[str, Any]] = []
    if "trusted_s" in results:
        known = results[results["trusted_s"].notna()]
        values = known[[name for name in known if name.startswith(AHEAD_COLUMNS)]].astype(float).replace(np.inf, np.nan)
        medians = values.groupby([known[key] for key in AHEAD_KEYS], observed=True).median().reset_index()
        rows = medians.sort_values(["vessel", "trusted_s"], ascending=[True, False], kind="stable").to_dict("records")
    columns = [
        *map(field, AHEAD_KEYS),
        numeric("trust it for, s", "trusted_s"),
        *(Column(f"{length:g} lengths", partial(_errors_ahead, length)) for length in LENGTHS),
        Column("sensor noise", lambda row: number(_in_degrees(row, "noise_yaw_rate_rad_s"))),
    ]
    return make_table(columns, rows, "How far ahead, measured records", AHEAD_NOTE)


def _errors_ahead(length: float, row: Row) -> str:
    values = [_in_degrees(row, f"rmse_{prefix}_{length:g}_yaw_rate_rad_s") for prefix in PREFIXES.values()]
    return " / ".join(map(number, values)) if np.isfinite(values).any() else ""


def _in_degrees(row: Row, name: str) -> float:
    return DEG * row.get(name, float("nan"))


# ---- What the uncertainty that methods state is worth: how often their intervals hold, and the probabilistic scores.

UNCERTAINTY_SCORES = ("coverage_95", "crps_median", "coverage_free", "crps_free")
UNCERTAINTY_NOTE = (
    "Inside: mean share of the stated 95 % intervals that hold the true parameter, or the sample of a held-out record. "
    "CRPS: median continuous ranked probability score, over the true value or the spread of the record. Free runs are "
    "drawn 20 times from what the method states: covariance of coefficients, Gaussian process, or trees. Noise "
    "of the held-out sensors counts as error. Intervals that are too small hold less than 95 %."
)
UNCERTAINTY_COLUMNS = (
    field("method"),
    numeric("runs", "runs", str),
    numeric("parameters inside", "coverage_95", percent),
    numeric("CRPS of parameters", "crps_median"),
    numeric("free run inside", "coverage_free", percent),
    numeric("CRPS of free runs", "crps_free"),
)


def uncertainty_table(results: Frame) -> Table:
    """Methods that state an uncertainty, the best free runs first; no row where none was scored."""
    scored = [name for name in UNCERTAINTY_SCORES if name in results]
    known = results[results[scored].notna().any(axis=1)]
    rows = [_uncertainty(str(label), own[scored]) for label, own in known.groupby(labels(known), observed=True)]
    rows.sort(key=lambda row: (np.isnan(row["crps_free"]), row["crps_free"], row["method"]))
    return make_table(UNCERTAINTY_COLUMNS, rows, "What stated uncertainties are worth", UNCERTAINTY_NOTE)


def _uncertainty(label: str, own: Frame) -> dict[str, Any]:
    means = {name: float(own[name].mean()) if name.startswith("coverage") else median(own[name]) for name in own}
    return {"method": label, "runs": len(own)} | dict.fromkeys(UNCERTAINTY_SCORES, np.nan) | means


def uncertainty_finding(runs: Frame) -> str | None:
    """How often the stated intervals of free runs hold, with the ship's own equations and on measured ships.

    runs : as `standings.judged` gives them.
    """
    if "coverage_free" not in runs:
        return None
    shares = runs.groupby("case", observed=True)["coverage_free"].agg(["mean", "count"])
    told = [f"{case} {percent(float(mean))} ({int(n)} runs)" for case, mean, n in shares.itertuples(name=None) if n]
    text = f"The 95 % intervals of free runs that methods state hold the record in: {', '.join(told)}."
    return text if told else None
