"""Tables of a diagnosis: conditions with large errors, causes, the extended model, the gain."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...datasets.display import IN_DEGREES
from ..errors import correlation, mean, residual, rms
from ..numbers import DEG, MISSING, SHORT, fixed, interval, number, p_value, percent, with_unit
from ..runs import CHANNELS
from ..tables import Column, Table, field, make_table, numeric
from . import words

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Entry, Gain

LONGEST_BAR = 16.0
"""-log10 p at which the evidence bar is full."""
CORRELATED = (1.0, 10.0)
"""Lags in s at which the correlation of the errors with themselves is given."""

WHERE = (
    "The bar is the condition's share of the squared free-run error of the base model, the dashed line its share of "
    "the time. A bar that passes its line marks a condition under which the errors are larger than on average."
)
EVIDENCE = (
    "The bar shows the evidence, −log₁₀ of the adjusted p-value (full at 16); the dashed line is the family-wise "
    "level. Power: probability of finding an effect of relevant size in these records."
)
GAIN = "Free run against the raw recorded channels; interval of the ratio by block bootstrap."
STATISTICS = (
    "Errors: measured minus simulated, free run. Correlation: autocorrelation of the error at that lag (0 for sensor "
    "noise)."
)


# ---- where the errors arise


def where_table(diagnosis: Diagnosis) -> Table:
    """Conditions (large rudder, slow speed, ...) with their shares of the squared error and of the time."""
    columns = [
        Column("condition", lambda row: f"{words.channel(str(row.get('channel', '')))[0]}: {row.get('condition', '')}"),
        Column("share of the squared error", _share_text, lambda row: _share(row), _share_bar, _share_text),
        numeric("share of the time", lambda row: _share(row, "time"), percent),
    ]
    return make_table(columns, diagnosis.where, note=WHERE)


def _share(row: Mapping[str, Any], of: str = "error") -> float:
    return float(row.get(f"share_of_{of}") or 0.0)


def _share_text(row: Mapping[str, Any]) -> str:
    return percent(_share(row))


def _share_bar(row: Mapping[str, Any]) -> str:
    return bar(100.0 * _share(row), 100.0 * _share(row, "time"), _share_text(row))


def bar(width: float, mark: float, text: str) -> str:
    """A bar of so many per cent of the longest with a mark, and a text behind it, as HTML."""
    full = min(max(width, 0.0), 100.0)
    return f'<span class="bar"><i style="width:{full:.1f}%"></i><u style="left:{mark:.1f}%"></u></span> {text}'


# ---- causes


def bank_table(diagnosis: Diagnosis) -> Table:
    """Every cause that could be tested with its status, evidence and power."""
    mark = bar_width(diagnosis.alpha)

    def evidence(entry: Entry) -> str:
        return bar(bar_width(entry.p_adjusted), mark, p_value(entry.p_adjusted).replace("<", "&lt;"))

    columns = [
        Column("cause", lambda entry: words.cause(entry.cause)),
        Column("status", lambda entry: _status(entry, diagnosis.alpha)),
        Column("adjusted p", lambda entry: p_value(entry.p_adjusted), lambda entry: entry.p_adjusted, evidence),
        numeric("statistic", "statistic"),
        numeric("power", "power", percent),
        Column("tied with", lambda entry: ", ".join(map(words.cause, _rivals(entry, diagnosis)))),
        Column("why", lambda entry: words.said(entry.why)),
    ]
    entries = [entry for entry in words.ordered_bank(diagnosis) if entry.status != "not_testable"]
    return make_table(
        columns, entries, note=f"{EVIDENCE} The level is {number(diagnosis.alpha)}.", kind=lambda entry: entry.status
    )


def _status(entry: Entry, alpha: float) -> str:
    """The status as words; a cause whose p-value alone is significant is `not named`, and the table says why."""
    significant = entry.p_adjusted is not None and entry.p_adjusted < alpha
    return "not named" if significant and entry.status == "not_significant" else entry.status.replace("_", " ")


def not_testable_table(diagnosis: Diagnosis) -> Table:
    """Causes that cannot be tested with this model and these records, and why."""
    columns = [
        Column("cause", lambda entry: words.cause(entry.cause)),
        Column("why", lambda entry: words.said(entry.why)),
    ]
    return make_table(columns, [entry for entry in diagnosis.bank if entry.status == "not_testable"])


def bar_width(p: float | None) -> float:
    """Evidence -log10 p in per cent of the longest bar."""
    if p is None or math.isnan(p):
        return 0.0
    return 100.0 * min(-math.log10(max(p, 1e-300)), LONGEST_BAR) / LONGEST_BAR


def _rivals(entry: Entry, diagnosis: Diagnosis) -> list[str]:
    finding = next((f for f in diagnosis.causes if entry.cause in (f.cause, *f.tied_with)), None)
    return [] if finding is None else [c for c in (finding.cause, *finding.tied_with) if c != entry.cause]


# ---- the extended model


def instrument_rows(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Values of the extension for rudder linkage and sensors: name, value with unit."""
    from ...models.instruments import INSTRUMENTS, SWAPS

    own = {k: v for k, v in diagnosis.extended.instruments.items() if diagnosis.model.instruments.get(k) != v}
    rows = []
    for name, value in own.items():
        unit = IN_DEGREES.get(INSTRUMENTS[name], INSTRUMENTS[name])
        factor = DEG if INSTRUMENTS[name] in IN_DEGREES else 1.0
        switch = name in (*SWAPS, "earth_frame_velocity", "rudder_reversed")
        rows.append((words.cause(name), "yes" if switch else with_unit(factor * value, unit)))
    return rows


def numbers_table(numbers: Mapping[str, Sequence[float]]) -> Table:
    """The model's own numbers before and after a joint fit."""
    columns = [
        Column("number", lambda row: row[0]),
        numeric("before", lambda row: row[1]),
        numeric("joint fit", lambda row: row[2]),
        Column("change", lambda row: percent(row[2] / row[1] - 1.0, 1) if row[1] else MISSING),
    ]
    return make_table(columns, [(name, *pair) for name, pair in numbers.items()])


# ---- errors and gain


def gain_table(diagnosis: Diagnosis) -> Table:
    """Channel, RMSE before and after, their ratio with interval, R^2 before and after, share of the gap closed, and
    RMSE with each record's own neutral rudder angle and start."""
    columns = [
        Column("channel", lambda row: words.channel(row[0])[0]),
        Column("RMSE before", lambda row: _rmse(row, "rmse_before")),
        Column("RMSE after", lambda row: _rmse(row, "rmse_after")),
        Column("after/before [90 %]", lambda row: ratio(row[1])),
        Column("R² before", lambda row: fixed(row[1].r2_before, 3), lambda row: row[1].r2_before),
        Column("R² after", lambda row: fixed(row[1].r2_after, 3), lambda row: row[1].r2_after),
        numeric("gap to noise floor closed", lambda row: row[1].closed, percent),
        Column("own neutral angle and start: RMSE before", lambda row: _rmse(row, "own_before")),
        Column("after", lambda row: _rmse(row, "own_after")),
    ]
    return make_table(columns, list(diagnosis.gain.items()), "Free-run errors on held-out records", GAIN)


def _rmse(row: tuple[str, Gain], name: str) -> str:
    _, unit, factor = words.channel(row[0])
    value = getattr(row[1], name)
    return MISSING if math.isnan(value) else with_unit(factor * value, unit)


def ratio(gain: Gain) -> str:
    """Error after over before, with its interval."""
    middle = gain.rmse_after / gain.rmse_before if gain.rmse_before > 0.0 else math.nan
    return interval(middle, gain.ratio_low, gain.ratio_high)


def error_table(diagnosis: Diagnosis) -> Table:
    """RMS, mean and correlation of the errors of every record and channel, before and after."""
    columns = [
        field("record"),
        field("role"),
        field("channel"),
        field("run"),
        field("RMS"),
        numeric("mean", "mean"),
        *(numeric(f"correlation {lag:g} s", lambda row, lag=lag: row[lag], SHORT) for lag in CORRELATED),
    ]
    rows = [
        _error_row(trace, name, run)
        for trace in diagnosis.traces
        for name in CHANNELS
        if name in trace.measured
        for run in ("before", "after")[: 1 + bool(diagnosis.causes)]
    ]
    return make_table(columns, rows, note=STATISTICS)


def _error_row(trace: Any, name: str, run: str) -> dict[Any, Any]:
    word, unit, factor = words.channel(name)
    error = residual(trace, name, run)
    facts = {"record": trace.record, "role": trace.role.replace("_", " "), "channel": word, "run": run}
    facts |= {"RMS": with_unit(factor * rms(error), unit) if rms(error) >= 0.0 else MISSING}
    return facts | {"mean": factor * mean(error)} | {lag: correlation(trace.time, error, lag) for lag in CORRELATED}
