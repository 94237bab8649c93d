"""Tables of one identification: parameters with their standard errors, prediction errors on validation records."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .numbers import fixed, number
from .tables import Column, Table, field, make_table

if TYPE_CHECKING:
    from ..estimation.estimate import Estimate

DIGITS = 5


def parameter_table(estimate: Estimate) -> Table:
    """Value, standard error and unit of every parameter, and its profile-likelihood interval if there is one."""
    units = dict(zip(estimate.model.parameter_names, estimate.model.parameter_units, strict=True))
    profiles = estimate.extra.get("profile", {})
    rows = [
        {
            "parameter": name,
            "value": value,
            "error": estimate.stderr.get(name, math.nan),
            "unit": units[name],
            "interval": profile_interval(profiles.get(name)),
        }
        for name, value in estimate.parameters.items()
    ]
    columns = [
        field("parameter"),
        Column("value", lambda row: number(row["value"], DIGITS), lambda row: row["value"]),
        Column("standard error", lambda row: standard_error(row["error"])),
        field("unit"),
        field("interval", "profile interval"),
    ]
    return make_table(columns, rows)


def standard_error(value: float) -> str:
    """`+- 0.012`; a parameter is fixed where it is 0, not identified where it is infinite, and nan means unknown."""
    if math.isinf(value):
        return "not identified"
    return "" if math.isnan(value) else f"+- {number(value, 2)}" if value else "fixed"


def profile_interval(profile: Mapping[str, Any] | None) -> str:
    """A profile-likelihood interval; a round bracket marks an open-ended interval."""
    if profile is None:
        return ""
    left, right = ("(" if profile["low_open"] else "["), (")" if profile["high_open"] else "]")
    return f"{left}{number(profile['low'], DIGITS)}, {number(profile['high'], DIGITS)}{right}"


def score_table(scores: Mapping[str, Any]) -> Table:
    """Errors of free runs and of one-step predictions by channel."""
    prefix = "rmse_free_"
    rows = [
        {"channel": channel, **{name: scores[f"{name}_{channel}"] for name in ("rmse_free", "r2_free", "rmse_one")}}
        for channel in (name.removeprefix(prefix) for name in scores if name.startswith(prefix))
    ]
    columns = [
        field("channel"),
        Column("free-run RMSE", lambda row: number(row["rmse_free"], 4), lambda row: row["rmse_free"]),
        Column("free-run R2", lambda row: fixed(row["r2_free"], 4), lambda row: row["r2_free"]),
        Column("one-step RMSE", lambda row: number(row["rmse_one"], 4), lambda row: row["rmse_one"]),
    ]
    return make_table(columns, rows)
