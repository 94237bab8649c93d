"""Tables of an identification: parameters, residuals, what the records tell, what to sail next, comparisons."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ...datasets.display import shown_name, shown_unit
from ..numbers import interval, interval_digits, is_missing, number
from ..tables import Column, Table, make_table

if TYPE_CHECKING:
    from ...estimation.estimates.assessment import Assessment, ParameterTold
    from ...estimation.estimates.correlation import ChannelResiduals, Correlation

DIGITS = 5
SHOWN = 4
"""Published values that are listed one by one; of more the range is shown."""


def standard_error(value: float) -> str:
    """`+- 0.012`; a parameter is fixed where it is 0, not identified where it is infinite, and nan means unknown."""
    if math.isinf(value):
        return "not identified"
    return "" if math.isnan(value) else f"+- {number(value, 2)}" if value else "fixed"


def profile_interval(profile: Mapping[str, Any]) -> str:
    """A profile-likelihood interval; a round bracket marks an open-ended interval."""
    left, right = ("(" if profile["low_open"] else "["), (")" if profile["high_open"] else "]")
    return f"{left}{number(profile['low'], DIGITS)}, {number(profile['high'], DIGITS)}{right}"


def assessed_table(assessment: Assessment) -> Table:
    """Every parameter with its interval, what the records allow at best, and published values."""
    profiles = assessment.estimate.extra.get("profile", {})
    columns = [
        Column("parameter", lambda one: one.name),
        Column(
            "estimate, 95 % interval", lambda one: _with_interval(one, profiles.get(one.name)), lambda one: one.value
        ),
        Column("unit", lambda one: one.unit),
        Column("standard error", lambda one: standard_error(one.stderr)),
        Column("smallest possible", lambda one: share(one.bound), lambda one: one.bound),
        Column("published for ships of the kind", _published),
    ]
    return make_table(columns, assessment.parameters)


def _with_interval(one: ParameterTold, profile: Mapping[str, Any] | None) -> str:
    if profile is not None:
        return f"{number(one.value, DIGITS)} {profile_interval(profile)}"
    if is_missing(one.low) or math.isinf(one.low) or one.low == one.high:
        return number(one.value, DIGITS)
    digits = interval_digits(one.value, one.low, one.high)
    return interval(one.value, one.low, one.high, lambda value: number(value, digits))


def share(bound: float) -> str:
    """A relative standard deviation in percent."""
    if is_missing(bound):
        return number(math.nan)
    return "not determined" if bound > 1e2 else f"{number(100.0 * bound, 2)} %"


def _published(one: ParameterTold) -> str:
    values = one.published
    if len(values) <= SHOWN:
        return ", ".join(f"{vessel} {number(value, 4)}" for vessel, value in values.items())
    low, high = (number(pick(values.values()), 4) for pick in (min, max))
    return f"{low} to {high} ({len(values)} vessels)"


def residual_table(assessment: Assessment) -> Table:
    """Residuals of free runs: a row a channel of each side."""
    rows = [("training", one) for one in assessment.train_residuals]
    rows += [("held out", one) for one in assessment.held_out_residuals]
    columns = [
        Column("records", lambda row: row[0]),
        Column("channel", lambda row: shown_name(row[1].channel)),
        Column("unit", lambda row: shown_unit(row[1].channel)[0]),
        Column("residual, RMS", lambda row: number(_shown(row[1], row[1].rms)), lambda row: _shown(row[1], row[1].rms)),
        Column("sensor noise", lambda row: number(_shown(row[1], row[1].noise_sd))),
        Column("ratio", lambda row: number(row[1].ratio, 2), lambda row: row[1].ratio),
        Column("lags outside 99 %, in time", lambda row: _outside(row[1].in_time)),
        Column("lags outside 99 %, with the rudder", lambda row: _outside(row[1].with_rudder)),
    ]
    return make_table(columns, rows)


def _shown(one: ChannelResiduals, value: float) -> float:
    return shown_unit(one.channel)[1] * value


def _outside(one: Correlation) -> str:
    return f"{one.outside} of {one.values.size}"


def told_table(assessment: Assessment) -> Table:
    """How well the records determine each parameter."""
    told = () if assessment.identifiability is None else assessment.identifiability.parameters
    columns = [
        Column("parameter", lambda one: one.name),
        Column("value", lambda one: number(one.value, DIGITS), lambda one: one.value),
        Column("unit", lambda one: one.unit),
        Column("smallest relative standard deviation", lambda one: share(one.relative), lambda one: one.relative),
    ]
    return make_table(columns, told)


def next_table(assessment: Assessment) -> Table:
    """Further manoeuvres by what they would tell."""
    told = () if assessment.identifiability is None else assessment.identifiability.candidates
    columns = [
        Column("manoeuvre", lambda one: one.manoeuvre),
        Column("information, nats", lambda one: number(one.information, 2), lambda one: one.information),
        Column("median bound after it", lambda one: share(one.median), lambda one: one.median),
        Column("worst bound after it", lambda one: share(one.worst), lambda one: one.worst),
    ]
    return make_table(columns, told)
