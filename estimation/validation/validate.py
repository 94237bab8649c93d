"""Validation of models on records: the chain from records to scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.indices import Performed, performed
from ...datasets.instruments import hull_record
from ...models.errors import BadInput, CannotFit
from ...models.model import CHANNELS as COLUMNS
from ..records.gaps import SHORTEST, stretches
from ..results.prediction import CHANNELS, SYMBOLS, Squares, as_shown, squares
from .horizons import STRAIGHT, TURNS_ON, Horizons, Simple, horizons_of, length_of, trusted_s
from .manoeuvres import Found, measured_indices, rows, simulated_indices
from .result import FREE, ONE_STEP, Index, LeftOut, Measured, Run, Score, Validation
from .runs import Stretch

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..results.predictor import Predictor

TOGETHER = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s")
"""Channels whose mean R^2 is that of all together; positions, which sum up all errors, are not among them."""
Key = tuple[str, str, str, str]
"""Model, record, channel and horizon."""


@dataclass(frozen=True)
class _Part:
    """What one model gives on one record: sums of squares by channel and horizon, its free run, indices, gaps."""

    sums: Mapping[tuple[str, str], Squares]
    run: Run | None
    indices: tuple[Index, ...]
    left_out: tuple[LeftOut, ...]


def validate(
    models: Mapping[str, Model],
    records: Mapping[str, Record],
    predictors: Mapping[str, Predictor] = MappingProxyType({}),
    ahead: bool = True,
) -> Validation:
    """Free runs, errors ahead and manoeuvring indices of models on records.

    Parameters
    ----------
    models : name -> model with coefficients, the validated one first.
    records : name -> record as it was read; one that does not say its rudder sign has the first model's.
    predictors : name -> black box that predicts in the model's place, whose states are those of the model.
    ahead : whether to predict more than one sample ahead.

    Raises
    ------
    BadInput : there is no record, a model has no coefficients, or no record suits the first model.
    """
    if not records:
        raise BadInput("there is no record to validate on")
    for name, model in models.items():
        if not model.known and name not in predictors:
            hint = "give a vessel id or a model.json; `helmbench identify` writes one"
            raise BadInput(f"model {name} has no coefficients", hint=hint)
    first = next(iter(models.values()))
    given = {name: record.turned(first.positive_rudder) for name, record in records.items()}
    horizons = horizons_of(models.values(), list(given.values()))
    horizons = horizons if ahead else horizons._replace(times_s=())
    parts = {
        (model_name, name): _part(model_name, model, name, record, horizons, predictors.get(model_name))
        for model_name, model in models.items()
        for name, record in given.items()
    }
    if all(parts[next(iter(models)), name].run is None for name in given):
        reasons = dict.fromkeys(one.reason for name in given for one in parts[next(iter(models)), name].left_out)
        raise BadInput(f"no record suits model {next(iter(models))}: {'; '.join(reasons)}")
    sums = {(m, r, *key): value for (m, r), part in parts.items() for key, value in part.sums.items()}
    labels = [FREE, ONE_STEP, *map(label, horizons.times_s)]
    times = dict(zip(labels[2:], horizons.times_s, strict=True))
    scores = tuple(_scores(sums, list(models), list(given), times))
    simple, noise = _without_model(first, given, horizons) if ahead else ((), {})
    return Validation(
        models=dict(models),
        records=tuple(_measured(name, record) for name, record in given.items()),
        horizons_s=horizons.times_s,
        horizon_basis=horizons.basis,
        scores=scores,
        indices=tuple(index for part in parts.values() for index in part.indices),
        runs=tuple(part.run for part in parts.values() if part.run is not None),
        left_out=tuple(one for part in parts.values() for one in part.left_out),
        simple=simple,
        noise=noise,
        trusted_s={name: trusted_s(scores, simple, name) for name in models},
    )


def _without_model(
    model: Model, given: Mapping[str, Record], horizons: Horizons
) -> tuple[tuple[Score, ...], dict[str, float]]:
    """Errors ahead of both simple predictions over all records, and the sensors' noise by channel."""
    names = {TURNS_ON: Simple(model.states, turns=True), STRAIGHT: Simple(model.states, turns=False)}
    sums: dict[Key, Squares] = {}
    variances: dict[str, list[float]] = {}
    for name, record in given.items():
        turned = record.turned(model.positive_rudder)
        try:
            own = [(which, _stretches(model, turned, horizons.clock, one)) for which, one in names.items()]
        except CannotFit:
            continue
        for which, found in own:
            sums |= {(which, name, *key): value for key, value in _sums_ahead(found, horizons).items()}
        for _, stretch in own[0][1]:
            for column, sd in zip(stretch.series.columns.tolist(), stretch.series.noise.tolist(), strict=True):
                variances.setdefault(COLUMNS[model.states[column]], []).append(sd**2)
    times = {label(time): time for time in horizons.times_s}
    found = _scores(sums, list(names), list(given), times)
    noise = {channel: float(np.sqrt(np.mean(values))) for channel, values in variances.items()}
    return tuple(s for s in found if s.record is None and s.channel is not None and s.horizon_s is not None), noise


def label(horizon_s: float) -> str:
    """A time ahead as text: `10.4 s`."""
    return f"{horizon_s:.3g} s"


def _measured(name: str, record: Record) -> Measured:
    channels = {c: record.column(c) for c in CHANNELS if record.has(c) and np.isfinite(record.column(c)).any()}
    if "heading_rad" in channels:
        channels["heading_rad"] = record.heading_unwrapped()
    return Measured(name, record.time_s, record.rudder(), channels)


def _part(
    model_name: str, model: Model, name: str, record: Record, horizons: Horizons, predictor: Predictor | None
) -> _Part:
    """One model on one record."""

    def without(what: str, reason: str) -> LeftOut:
        return LeftOut(model_name, name, what, reason)

    turned = record.turned(model.positive_rudder)
    try:
        found = _stretches(model, turned, horizons.clock, predictor)
    except CannotFit as reason:
        return _Part({}, None, (), (without("record", str(reason)),))
    if not found:
        reason = f"no {SHORTEST} samples in turn with a rudder angle"
        return _Part({}, None, (), (without("record", reason),))
    left_out = [without(channel, reason) for channel, reason in _missing(model, turned).items()]
    run = _run(model_name, name, turned, found)
    sums = _sums(turned, run, found, horizons)
    longest, stretch = max(found, key=lambda pair: pair[0].n)
    manoeuvre = performed(longest)
    if not manoeuvre.kind:
        return _Part(sums, run, (), (*left_out, without("manoeuvring indices", manoeuvre.reason)))
    return _Part(sums, run, tuple(_index_rows(model_name, name, longest, stretch, manoeuvre)), tuple(left_out))


def _stretches(model: Model, record: Record, clock: float, predictor: Predictor | None) -> list[tuple[Record, Stretch]]:
    """The stretches of a record in the model's rudder sign, as recorded and as runs of the hull.

    Raises CannotFit where the record lacks an input or measures no state of the model.
    """
    hull = hull_record(record, model)
    pieces = [(record.slice(a, b), hull.slice(a, b)) for a, b in stretches(hull, clock)]
    return [(piece, Stretch.of(model, own, predictor)) for piece, own in pieces if piece.n > 1]


def free_run_squares(
    model: Model, record: Record, predictor: Predictor | None = None
) -> tuple[dict[str, Squares], bool]:
    """Sums of squares of the free run along a record by channel, as `validate` computes them, and whether it diverges.

    predictor : a black box that predicts in the model's place.

    Raises
    ------
    CannotFit : the record lacks an input, measures no state of the model, or has no stretch without gaps.
    """
    turned = record.turned(model.positive_rudder)
    horizons = horizons_of([model], [turned])
    found = _stretches(model, turned, horizons.clock, predictor)
    if not found:
        raise CannotFit(f"record {record.name} has no {SHORTEST} samples in turn with a rudder angle")
    run = _run(model.id, record.name, turned, found)
    return _free_sums(turned, run, found), bool(run.diverged)


def _missing(model: Model, record: Record) -> dict[str, str]:
    """Channel -> why it has no score, of those that the record or the model has."""
    found = {}
    for symbol in SYMBOLS:
        channel = COLUMNS[symbol]
        measured = record.has(channel) and bool(np.isfinite(record.column(channel)).any())
        if measured and symbol not in model.states:
            found[channel] = "the model has no such state"
        elif symbol in model.states and not measured:
            found[channel] = "the record has no such samples"
    return found


def _run(model: str, name: str, record: Record, found: Sequence[tuple[Record, Stretch]]) -> Run:
    """The free run in the record's channels, as the model's instruments show it."""
    measured = _measured(name, record)
    predicted: dict[str, np.ndarray] = {}
    diverged = []
    for piece, stretch in found:
        free = stretch.free_run()
        diverged += [] if free.diverged_s is None else [(float(piece.time_s[0]), free.diverged_s)]
        shown = as_shown(stretch.model, piece, stretch.channels(stretch.series.observe(free.states)))
        first = int(np.searchsorted(record.time_s, piece.time_s[0]))
        place = slice(first, first + piece.n)
        for channel in (c for c in measured.channels if shown.has(c)):
            values, observed = shown.column(channel), measured.channels[channel][place]
            values = values + (_whole_turns(observed - values) if channel == "heading_rad" else 0.0)
            predicted.setdefault(channel, np.full(record.n, np.nan))[place] = values
    starts = tuple(float(piece.time_s[0]) for piece, _ in found)
    return Run(model, name, predicted, starts, tuple(diverged))


def _whole_turns(gap: np.ndarray) -> float:
    """The whole turns, rad, that are nearest to the first known gap (N,) between two headings."""
    known = gap[np.isfinite(gap)]
    return float(2.0 * np.pi * np.round(known[0] / (2.0 * np.pi))) if known.size else 0.0


def _sums(
    record: Record, run: Run, found: Sequence[tuple[Record, Stretch]], horizons: Horizons
) -> dict[tuple[str, str], Squares]:
    """Sums of squares by channel and horizon: free runs as recorded, predictions ahead behind the instruments."""
    sums = {(channel, FREE): value for channel, value in _free_sums(record, run, found).items()}
    return sums | _sums_ahead(found, horizons)


def _sums_ahead(found: Sequence[tuple[Record, Stretch]], horizons: Horizons) -> dict[tuple[str, str], Squares]:
    """Sums of squares of predictions ahead by channel and horizon."""
    sums: dict[tuple[str, str], Squares] = {}
    labels = [ONE_STEP, *map(label, horizons.times_s)]
    for _, stretch in found:
        for horizon, states in zip(labels, stretch.ahead(horizons.times_s), strict=True):
            for state, more in states.items():
                key = COLUMNS[stretch.model.states[state]], horizon
                sums[key] = sums.get(key, Squares()).plus(more)
    return sums


def _free_sums(record: Record, run: Run, found: Sequence[tuple[Record, Stretch]]) -> dict[str, Squares]:
    """Sums of squares of the free run by channel, as recorded."""
    sums: dict[str, Squares] = {}
    measured = _measured("", record).channels
    for piece, _ in found:
        first = int(np.searchsorted(record.time_s, piece.time_s[0]))
        place = slice(first, first + piece.n)
        for channel, values in run.predicted.items():
            known = np.isfinite(values[place])
            more = squares(measured[channel][place][known], values[place][known])
            sums[channel] = sums.get(channel, Squares()).plus(more)
    return sums


def _index_rows(model: str, name: str, piece: Record, stretch: Stretch, manoeuvre: Performed) -> list[Index]:
    """The indices of the record's longest stretch."""
    measured = measured_indices(piece, manoeuvre)
    if "psi" in stretch.model.states and stretch.model.states.index("psi") not in stretch.known:
        simulated = Found({}, {})
    else:
        simulated = simulated_indices(stretch, piece, manoeuvre)
    return rows(model, name, length_of(stretch.model), manoeuvre, measured, simulated)


def _scores(
    sums: Mapping[Key, Squares], models: Sequence[str], records: Sequence[str], times: Mapping[str, float]
) -> list[Score]:
    """Scores by model, record (None: all) and horizon, channels in the order of the header, then all of them."""
    out = []
    for model in models:
        for record in (None, *records):
            for horizon in (FREE, ONE_STEP, *times):
                own = [_score(sums, records, (model, record, c, horizon), times.get(horizon)) for c in CHANNELS]
                known = [score for score in own if score.n]
                motions = [score for score in known if score.channel in TOGETHER and np.isfinite(score.r2)]
                mean = float(np.mean([score.r2 for score in motions])) if motions else np.nan
                count = sum(score.n for score in motions)
                together = Score(model, record, None, horizon, times.get(horizon), count, np.nan, mean)
                out += [*known, together] if known else []
    return out


def _score(
    sums: Mapping[Key, Squares], records: Sequence[str], key: tuple[str, str | None, str, str], horizon_s: float | None
) -> Score:
    model, record, channel, horizon = key
    total = Squares()
    for name in records if record is None else (record,):
        total = total.plus(sums.get((model, name, channel, horizon), Squares()))
    return Score(model, record, channel, horizon, horizon_s, total.n, *total.scores())
