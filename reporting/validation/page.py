"""What a validation says: how far ahead to trust a model, errors of free runs and ahead, manoeuvring indices."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from ...datasets.columns import CANONICAL
from ...datasets.display import shown_name, shown_unit
from ...estimation.validation.horizons import STRAIGHT, better_at
from ...estimation.validation.result import FREE
from ...estimation.validation.validate import label
from ..numbers import DEG, number, percent, r_squared
from ..page import FAIR, GOOD, Note, Section, Verdict, items, overlays, result_page
from ..runs import of_validation
from ..tables import Column, Table, field, make_table, numeric

if TYPE_CHECKING:
    from ...estimation.run.run import Run
    from ...estimation.validation.result import ErrorScore, Index, Validation
    from ..page import Page


# ---- The tables of a validation, for the page and the terminal alike.

TOGETHER = "together"
"""The row of all channels: mean R^2 of heading, yaw rate, surge and sway."""
NOISE = "sensor noise"


def free_table(validation: Validation) -> Table:
    """Errors of free runs over all records: a row a channel, columns for each model."""
    columns = [Column("channel", _channel_name), Column("unit", _unit)]
    for name in validation.models:
        score = partial(validation.score, model=name)
        columns += [_scored(f"{title}{_of(validation, name)}", score, value) for title, value in FREE_SCORES.items()]
    return make_table(columns, [*_channels(validation), None])


def horizon_table(validation: Validation) -> Table:
    """Root mean square errors some time ahead, over all records: a row a channel and model, a column a horizon.

    Behind the models stand the two predictions without one, and the sensor's noise.
    """
    horizons = list(dict.fromkeys(score.horizon for score in validation.scores))
    horizons = [*(h for h in horizons if h != FREE), FREE]
    rows: list[tuple[str, str]] = []
    for channel in _channels(validation):
        rows += [(channel, name) for name in validation.models if validation.score(channel, name)]
        rows += _simple(validation, channel)
    columns = [
        Column("channel", lambda row: _channel_name(row[0])),
        Column("unit", lambda row: _unit(row[0])),
        Column("model", lambda row: row[1]),
    ]
    columns += [
        _scored(f"{'' if h in (FREE, horizons[0]) else 'after '}{h}", _at_horizon(validation, h), _rmse)
        for h in horizons
    ]
    return make_table(columns, rows)


def record_table(validation: Validation) -> Table:
    """Errors of the free run of every record: a row a record and model."""

    def score(row: Run, channel: str | None = None) -> ErrorScore | None:
        return validation.score(channel, row.model, row.record)

    order = [one.name for one in validation.records]
    columns = [
        field("record"),
        field("model"),
        *(_scored(_with_unit(channel), partial(score, channel=channel), _rmse) for channel in _channels(validation)),
        _scored("R² together", score, _r2),
        Column("remark", _remark),
    ]
    return make_table(columns, sorted(validation.runs, key=lambda run: order.index(run.record)))


def index_table(validation: Validation) -> Table:
    """Manoeuvring indices: a row an index of a record, columns for each model."""
    by_row: dict[tuple[str, str, str], dict[str, Index]] = {}
    for index in validation.indices:
        by_row.setdefault((index.record, index.manoeuvre, index.name), {})[index.model] = index
    order = [one.name for one in validation.records]
    rows = sorted(by_row.values(), key=lambda row: order.index(_any(row).record))
    columns = [
        Column("record", lambda row: _any(row).record),
        Column("manoeuvre", lambda row: _any(row).manoeuvre),
        Column("index", lambda row: _any(row).name.replace("_", " ")),
        Column("unit", lambda row: "deg" if _any(row).unit == "rad" else _any(row).unit),
        numeric("measured", lambda row: _shown(_any(row), _any(row).measured)),
    ]
    columns += [_index_column(f"simulated{_of(validation, n)}", n, "simulated") for n in validation.models]
    if len(validation.models) == 1:
        columns.append(_index_column("difference", next(iter(validation.models)), "difference"))
    return make_table([*columns, numeric("measured, in ship lengths", _lengths), Column("remark", _reasons)], rows)


def left_out_table(validation: Validation) -> Table:
    """What was left out, and why; records with the same reason share a row."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for one in validation.left_out:
        groups.setdefault((one.model, one.what, one.reason), []).append(one.record)
    columns = [
        Column("model", lambda row: row[0][0]),
        Column("left out", lambda row: shown_name(row[0][1]) if row[0][1] in CANONICAL else row[0][1]),
        Column("why", lambda row: row[0][2]),
        Column("records", lambda row: _listed(row[1], len(validation.records))),
    ]
    return make_table(columns, list(groups.items()), "Left out")


def _listed(names: Sequence[str], count: int) -> str:
    return "all" if len(names) == count and count > 1 else ", ".join(names)


def _channels(validation: Validation) -> list[str]:
    """Channels that have a score, in the order of the header."""
    return list(dict.fromkeys(score.channel for score in validation.scores if score.channel is not None))


def _channel_name(channel: str | None) -> str:
    return TOGETHER if channel is None else shown_name(channel)


def _unit(channel: str | None) -> str:
    return "" if channel is None else shown_unit(channel)[0]


def _with_unit(channel: str) -> str:
    return f"{shown_name(channel)}, {shown_unit(channel)[0]}"


def _of(validation: Validation, name: str) -> str:
    return f" {name}" if len(validation.models) > 1 else ""


def _rmse(score: ErrorScore | None) -> float | None:
    """The error in the unit that is shown."""
    if score is None or score.channel is None:
        return None
    return shown_unit(score.channel)[1] * score.rmse


def _r2(score: ErrorScore | None) -> float | None:
    return None if score is None else score.r2


FREE_SCORES = {"RMSE": _rmse, "R²": _r2}


def _simple(validation: Validation, channel: str) -> list[tuple[str, str]]:
    """Rows of what a model must beat in a channel, and of the noise that it cannot."""
    names = dict.fromkeys(score.model for score in validation.simple if score.channel == channel)
    noise = [NOISE] if names and channel in validation.noise else []
    return [(channel, name) for name in (*names, *noise)]


def _at_horizon(validation: Validation, horizon: str) -> Callable[[Any], ErrorScore | None]:
    def score(row: tuple[str, str]) -> ErrorScore | None:
        channel, name = row
        if name == NOISE:
            timed = next((s for s in validation.simple if s.horizon == horizon), None)
            return None if timed is None else replace(timed, channel=channel, rmse=validation.noise[channel])
        simple = (s for s in validation.simple if (s.model, s.channel, s.horizon) == (name, channel, horizon))
        return next(simple, None) or validation.score(channel, name, horizon=horizon)

    return score


def trusted_lines(validation: Validation) -> list[str]:
    """A sentence a model: how far ahead it is better than both predictions without a model."""
    rivals = "those of a constant rate of turn, and of a constant heading"
    known = {name: time for name, time in validation.trusted_s.items() if math.isfinite(time)}
    return [f"{name}: {_trusted(validation, name, time)} better than {rivals}" for name, time in known.items()]


def explained_lines(validation: Validation) -> list[str]:
    """The same with the share of the motion that it explains there, and the floor below which no error can come."""
    known = [(name, time) for name, time in validation.trusted_s.items() if math.isfinite(time)]
    lines = trusted_lines(validation)
    return [f"{line}{_explained(validation, *one)}" for line, one in zip(lines, known, strict=True)]


def share_explained(validation: Validation, channel: str, name: str, horizon: str) -> float:
    """One minus the squared error over the variance of a channel, or over the squared change since the start of the
    heading, which hardly varies in a zigzag; nan where there is no score."""
    score = validation.score(channel, name, horizon=horizon)
    if score is None or channel != "heading_rad":
        return math.nan if score is None else score.r2
    simple = {(s.model, s.channel, s.horizon): s.rmse for s in validation.simple}
    still = simple.get((STRAIGHT, channel, horizon), 0.0)
    return 1.0 - (score.rmse / still) ** 2 if still else math.nan


def _explained(validation: Validation, name: str, time_s: float) -> str:
    """Share explained and floor where the model is trusted to, or at the shortest time ahead."""
    horizon = label(time_s if time_s > 0.0 else min(validation.horizons_s))
    parts = []
    for channel, what in (("yaw_rate_rad_s", "the yaw rate"), ("heading_rad", "the change of heading")):
        share = share_explained(validation, channel, name, horizon)
        score = validation.score(channel, name, horizon=horizon)
        if score is not None and math.isfinite(share):
            unit, factor = shown_unit(channel)
            error, floor = number(factor * score.rmse), number(factor * validation.noise.get(channel, 0.0), 2)
            explained = percent(share) if share > 0.0 else "nothing"
            parts.append(f"{explained} of {what} (error {error}, sensor noise {floor} {unit})")
    return f"; {horizon} ahead it explains {' and '.join(parts)}" if parts else ""


def _trusted(validation: Validation, name: str, time_s: float) -> str:
    if time_s > 0.0:
        longest = ", the longest time that was tried" if time_s >= max(validation.horizons_s, default=math.inf) else ""
        return f"trust it for {time_s:.3g} s{longest}: up to then its predictions are"
    better = better_at(validation.scores, validation.simple, name)
    first = next((time for time, is_better in better.items() if is_better), None)
    when = "at no time ahead" if first is None else f"only from {first:.3g} s ahead on"
    return f"{when} are its predictions"


def _scored(
    title: str, score: Callable[[Any], ErrorScore | None], value: Callable[[ErrorScore | None], float | None]
) -> Column:
    return numeric(title, lambda row: value(score(row)), r_squared if value is _r2 else number)


def _remark(run: Run) -> str:
    parts = [f"{len(run.starts_s)} runs between long gaps"] if len(run.starts_s) > 1 else []
    return "; ".join([*parts, run.told] if run.told else parts)


def _any(row: dict[str, Index]) -> Index:
    return next(iter(row.values()))


def _shown(index: Index, value: float) -> float:
    return DEG * value if index.unit == "rad" else value


def _index_column(title: str, model: str, name: str) -> Column:
    return numeric(title, lambda row: _shown(row[model], getattr(row[model], name)) if model in row else None)


def _lengths(row: dict[str, Index]) -> float | None:
    """The measured distance in lengths of the first model's ship that has one."""
    index, lengths = _any(row), [own.length_m for own in row.values() if math.isfinite(own.length_m)]
    return index.measured / lengths[0] if index.unit == "m" and lengths else None


def _reasons(row: dict[str, Index]) -> str:
    reasons = {index.model: index.reason for index in row.values() if index.reason}
    if len(set(reasons.values())) == 1 and len(reasons) == len(row):
        return next(iter(reasons.values()))
    return "; ".join(f"{model}: {reason}" if len(row) > 1 else reason for model, reason in reasons.items())


TITLES = ("Measured and simulated", "Errors of free runs", "Errors ahead", "Manoeuvring indices")
RUNS = (
    "Each model is simulated with the recorded rudder and revolutions from the state that the record itself, smoothed, "
    "has at its first sample, without random forces, and anew behind a long gap. Errors are those of the recorded "
    "channels, over all records; R² = 1 − SSE/SST, about each run's mean; together: mean over heading, yaw rate, surge "
    "and sway. Behind a divergence the last value before it stands. In the charts a run is cut off where it is far "
    "from the measured values."
)
AHEAD = (
    "Root mean square errors of predictions some time ahead, from up to 200 smoothed states of each run, behind the "
    "model's instruments."
)
INDICES = (
    "As IMO MSC.137(76) defines them. The simulated ship sails the same manoeuvre from the first execute on: it gets "
    "counter rudder when its own heading has changed by as much as the recorded one had, and the rudder moves as "
    "recorded."
)
NO_INDICES = "The records hold neither a zigzag nor a turning circle from which indices can be read."


def page(validation: Validation) -> Page:
    """The page of a validation."""
    trusted = [f"{line}." for line in trusted_lines(validation)]
    diverged = [f"{run.model} along {run.record}: {run.told}" for run in validation.runs if run.told]
    first, *others = trusted or ["No time ahead was tried: the records are too short."]
    overview, each = overlays(of_validation(validation))
    good = not diverged and any(time > 0.0 for time in validation.trusted_s.values())
    return result_page(
        f"Validation of {', '.join(validation.models)}",
        f"on {count(validation)}; nothing was fitted",
        Verdict(GOOD if good else FAIR, first, (*others, *diverged)),
        seen=[overview],
        changed=[free_table(validation), left_out_table(validation)],
        remains=[horizon_table(validation), Note(f"Times ahead: {validation.horizon_basis}.")],
        following=[index_table(validation) if validation.indices else NO_INDICES],
        details=[
            Section("Errors by record", (record_table(validation),)),
            each,
            Section("How to read it", (items([RUNS, AHEAD, INDICES]),)),
        ],
        doubts=validation.doubts,
        titles=TITLES,
    )


def count(validation: Validation) -> str:
    """`3 records`, or the name of the only one."""
    names = [record.name for record in validation.records]
    return names[0] if len(names) == 1 else f"{len(names)} records"
