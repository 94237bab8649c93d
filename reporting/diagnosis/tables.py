"""Tables of a diagnosis: conditions with large errors, causes, the extended model, the gain."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.display import IN_DEGREES
from ..numbers import DEG, MISSING, SHORT, fixed, interval, number, p_value, percent, with_unit
from ..runs import CHANNELS, rms
from ..tables import Column, Table, field, make_table, numeric
from . import words

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Entry, Gain, Trace

SHOWN_AS = {unit: (shown, DEG) for unit, shown in IN_DEGREES.items()} | {"1": ("%", 100.0)}
"""Unit of an instrument -> unit in which it is shown, and how many of that it is."""
CORRELATED = (1.0, 10.0)
"""Lags in s at which the correlation of the errors with themselves is given."""

WHERE = (
    "Shares of the free-run error of the base model. Under a condition whose share of the error is above its share of "
    "the time the errors are larger than on average."
)
POWER = "Power: probability of finding an effect of relevant size in these records. The family-wise level is"
GAIN = "Free run against the raw recorded channels; interval of the ratio by block bootstrap."
OWN = (
    "Own neutral angle and start: each record has its own, fitted to it, as wind or trim of a day are not the model's."
)
STATISTICS = (
    "Errors: measured minus simulated, free run. Correlation: autocorrelation of the error at that lag (0 for sensor "
    "noise)."
)


# ---- where the errors arise


def where_table(diagnosis: Diagnosis) -> Table:
    """Conditions (large rudder, slow speed, ...) with their shares of the squared error and of the time."""
    columns = [
        Column("condition", lambda row: f"{words.channel(str(row.get('channel', '')))[0]}: {row.get('condition', '')}"),
        numeric("share of the squared error", _share, percent),
        numeric("share of the time", lambda row: _share(row, "time"), percent),
    ]
    return make_table(columns, diagnosis.where, note=WHERE)


def _share(row: Mapping[str, Any], of: str = "error") -> float:
    return float(row.get(f"share_of_{of}") or 0.0)


# ---- causes


def bank_table(diagnosis: Diagnosis) -> Table:
    """Every cause that could be tested with its status, evidence and power."""
    columns = [
        Column("cause", lambda entry: words.cause(entry.cause)),
        Column("status", lambda entry: _status(entry, diagnosis.alpha)),
        numeric("adjusted p", "p_adjusted", p_value),
        numeric("statistic", "statistic"),
        numeric("power", "power", percent),
        Column("tied with", lambda entry: ", ".join(map(words.cause, _rivals(entry, diagnosis)))),
        Column("why", lambda entry: words.said(entry.why)),
    ]
    entries = [entry for entry in words.ordered_bank(diagnosis) if entry.status != "not_testable"]
    return make_table(columns, entries, note=f"{POWER} {number(diagnosis.alpha)}.", kind=lambda entry: entry.status)


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


def _rivals(entry: Entry, diagnosis: Diagnosis) -> list[str]:
    finding = next((f for f in diagnosis.causes if entry.cause in (f.cause, *f.tied_with)), None)
    return [] if finding is None else [c for c in (finding.cause, *finding.tied_with) if c != entry.cause]


# ---- sizes and the extended model


def size_table(diagnosis: Diagnosis) -> Table:
    """Sizes of all causes with their intervals: a row a number, and a record where each has its own."""
    rows = [(finding, item) for finding in diagnosis.causes for item in finding.sizes]
    columns = [
        Column("cause", lambda row: words.cause(row[0].cause)),
        Column("number", lambda row: words.label_of(row[1])),
        Column("record", lambda row: row[1].record or "all"),
        Column("value", lambda row: words.value_and_interval(row[1])[0], lambda row: row[1].value),
        Column("90 % interval", lambda row: words.value_and_interval(row[1])[1].strip("[]").replace(", ", " to ")),
        Column("change", lambda row: words.change(diagnosis.model, *row)),
    ]
    spare = {"record"} if all(item.record is None for _, item in rows) else set()
    spare |= set() if any(words.change(diagnosis.model, *row) for row in rows) else {"change"}
    return make_table([column for column in columns if column.title not in spare], rows, "Sizes")


def instrument_rows(diagnosis: Diagnosis) -> list[str]:
    """Values of the extension for rudder linkage and sensors, as texts: `yaw rate scale: -0.75 %`."""
    from ...models.instruments import INSTRUMENTS, SWAPS

    own = {k: v for k, v in diagnosis.extended.instruments.items() if diagnosis.model.instruments.get(k) != v}
    rows = []
    for name, value in own.items():
        unit, factor = SHOWN_AS.get(INSTRUMENTS[name], (INSTRUMENTS[name], 1.0))
        switch = name in (*SWAPS, "earth_frame_velocity", "rudder_reversed")
        rows.append(f"{words.cause(name)}: {'yes' if switch else with_unit(factor * value, unit)}")
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
    RMSE with each record's own neutral rudder angle and start; of a model that stays as it is its errors alone."""
    name = Column("channel", lambda row: words.channel(row[0])[0])
    if not diagnosis.extends:
        alone = [
            name,
            Column("RMSE", lambda row: _rmse(row, "rmse_before")),
            Column("R²", lambda row: fixed(row[1].r2_before, 3), lambda row: row[1].r2_before),
            Column("RMSE with own neutral angle and start", lambda row: _rmse(row, "own_before")),
        ]
        return make_table(alone, list(diagnosis.gain.items()), "Free-run errors on held-out records", OWN)
    columns = [
        name,
        Column("RMSE before", lambda row: _rmse(row, "rmse_before")),
        Column("RMSE after", lambda row: _rmse(row, "rmse_after")),
        Column("after/before [90 %]", lambda row: ratio(row[1])),
        Column("R² before", lambda row: fixed(row[1].r2_before, 3), lambda row: row[1].r2_before),
        Column("R² after", lambda row: fixed(row[1].r2_after, 3), lambda row: row[1].r2_after),
        numeric("gap to noise floor closed", lambda row: row[1].closed, percent),
        Column("own neutral angle and start: RMSE before", lambda row: _rmse(row, "own_before")),
        Column("after", lambda row: _rmse(row, "own_after")),
    ]
    return make_table(columns, list(diagnosis.gain.items()), "Free-run errors on held-out records", f"{GAIN} {OWN}")


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
        for run in ("before", "after")[: 1 + diagnosis.extends]
    ]
    return make_table(columns, rows, note=STATISTICS)


def _error_row(trace: Any, name: str, run: str) -> dict[Any, Any]:
    word, unit, factor = words.channel(name)
    error = residual(trace, name, run)
    facts = {"record": trace.record, "role": trace.role.replace("_", " "), "channel": word, "run": run}
    facts |= {"RMS": with_unit(factor * rms(error), unit) if rms(error) >= 0.0 else MISSING}
    return facts | {"mean": factor * mean(error)} | {lag: correlation(trace.time, error, lag) for lag in CORRELATED}


@np.errstate(over="ignore", invalid="ignore")
def residual(trace: Trace, name: str, run: str) -> np.ndarray:
    """Measured minus simulated (T,), SI, of the run `before` or `after`; headings wrapped to +- pi."""
    error = trace.measured[name] - getattr(trace, run)[name]
    return error - 2.0 * np.pi * np.round(error / (2.0 * np.pi)) if name == "heading_rad" else error


@np.errstate(over="ignore")
def mean(values: np.ndarray) -> float:
    """Mean of what is finite; nan if nothing is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else math.nan


@np.errstate(over="ignore", invalid="ignore")
def correlation(time: np.ndarray, error: np.ndarray, lag_s: float) -> float:
    """Correlation of an error (T,) with itself `lag_s` seconds later; nan for records that are too short."""
    lag = max(1, round(lag_s / float(np.median(np.diff(time)))))
    if lag >= error.size // 2:
        return math.nan
    early, late = error[:-lag], error[lag:]
    known = np.isfinite(early) & np.isfinite(late)
    if known.sum() < 10 or min(np.std(early[known]), np.std(late[known])) == 0.0:
        return math.nan
    return float(np.corrcoef(early[known], late[known])[0, 1])
