"""Tables of the leaderboard and their columns: standings, failures, errors by record, and what stated uncertainties are
worth."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..numbers import DEG, MISSING, duration, interval, number, percent, r_squared
from ..tables import Column, Table, field, make_table, numeric
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
CRITERIA = {"rel_error": "Parameter error", "nrmse": "Held-out NRMSE"}


def overall_table(overall: Frame) -> Table:
    """The standings over all cells."""
    return make_table(STANDING, _rows(overall), "Overall")


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
