"""Columns of the leaderboard's tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..numbers import DEG, MISSING, duration, interval, is_missing, number, r_squared
from ..tables import Column, field

Row = Mapping[str, Any]


def numeric(title: str, name: str, form: Callable[[Any], str] = number, scale: float = 1.0) -> Column:
    """A column of numbers, one field of the rows times `scale`."""

    def value(row: Row) -> float | None:
        return None if is_missing(row[name]) else float(row[name]) * scale

    return Column(title, lambda row: form(value(row)), value)


def count(name: str, title: str = "") -> Column:
    """A column of whole numbers."""
    return Column(title or name, lambda row: str(row[name]), lambda row: row[name])


def with_interval(title: str, name: str) -> Column:
    """A column of medians with their intervals."""
    return Column(
        title, lambda row: interval(row[name], row[f"{name}_low"], row[f"{name}_high"]), lambda row: row[name]
    )


def unless_one(name: str) -> Column:
    """A column of numbers, empty where they are 1."""
    return Column(name, lambda row: MISSING if row[name] == 1 else number(row[name]), lambda row: row[name])


def _outcomes(row: Row) -> str:
    return f"{row['failed']} / {row['not_applicable']} / {row['runs']}"


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
    Column("failed / n.a. / runs", _outcomes, lambda row: row["failed"]),
    count("diverged"),
    count("cells"),
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
    unless_one("thinning"),
    unless_one("length"),
    count("runs"),
    field("seeds"),
)
