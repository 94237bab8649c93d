"""Validation of models on records: the chain from records to scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ...datasets.indices import RecordedManoeuvre, performed
from ...datasets.record import Record
from ...models.errors import BadInput, CannotFit
from ...models.model import CHANNELS as COLUMNS
from ...models.model import Model
from ..results.predictor import Predictor
from ..run.run import CHANNELS, Run, measured_of, run_of
from ..run.squares import Squares
from ..run.stretch import SYMBOLS, Stretch, stretches_of
from .horizons import STRAIGHT, TURNS_ON, Simple, horizons_of, length_of, trusted_s
from .manoeuvres import IndexValues, measured_indices, rows, simulated_indices
from .result import FREE, ONE_STEP, ErrorScore, Index, LeftOut, Validation

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
    horizons, basis = horizons_of(models.values(), list(given.values()))
    horizons = horizons if ahead else ()
    parts = {
        (model_name, name): _part(model_name, model, name, record, horizons, predictors.get(model_name))
        for model_name, model in models.items()
        for name, record in given.items()
    }
    if all(parts[next(iter(models)), name].run is None for name in given):
        reasons = dict.fromkeys(one.reason for name in given for one in parts[next(iter(models)), name].left_out)
        raise BadInput(f"no record suits model {next(iter(models))}: {'; '.join(reasons)}")
    sums = {(m, r, *key): value for (m, r), part in parts.items() for key, value in part.sums.items()}
    labels = [FREE, ONE_STEP, *map(label, horizons)]
    times = dict(zip(labels[2:], horizons, strict=True))
    scores = tuple(_scores(sums, list(models), list(given), times))
    simple, noise = _without_model(first, given, horizons) if ahead else ((), {})
    return Validation(
        models=dict(models),
        records=tuple(measured_of(name, record) for name, record in given.items()),
        horizons_s=horizons,
        horizon_basis=basis,
        scores=scores,
        indices=tuple(index for part in parts.values() for index in part.indices),
        runs=tuple(part.run for part in parts.values() if part.run is not None),
        left_out=tuple(one for part in parts.values() for one in part.left_out),
        simple=simple,
        noise=noise,
        trusted_s={name: trusted_s(scores, simple, name) for name in models},
    )


def _without_model(
    model: Model, given: Mapping[str, Record], horizons: Sequence[float]
) -> tuple[tuple[ErrorScore, ...], dict[str, float]]:
    """Errors ahead of both simple predictions over all records, and the sensors' noise by channel."""
    names = {TURNS_ON: Simple(model.states, turns=True), STRAIGHT: Simple(model.states, turns=False)}
    sums: dict[Key, Squares] = {}
    variances: dict[str, list[float]] = {}
    for name, record in given.items():
        turned = record.turned(model.positive_rudder)
        try:
            own = [(which, stretches_of(model, turned, one)) for which, one in names.items()]
        except CannotFit:
            continue
        for which, found in own:
            sums |= {(which, name, *key): value for key, value in _sums_ahead(found, horizons).items()}
        for stretch in own[0][1]:
            for column, sd in zip(stretch.series.columns.tolist(), stretch.series.noise.tolist(), strict=True):
                variances.setdefault(COLUMNS[model.states[column]], []).append(sd**2)
    times = {label(time): time for time in horizons}
    found = _scores(sums, list(names), list(given), times)
    noise = {channel: float(np.sqrt(np.mean(values))) for channel, values in variances.items()}
    return tuple(s for s in found if s.record is None and s.channel is not None and s.horizon_s is not None), noise


def label(horizon_s: float) -> str:
    """A time ahead as text: `10.4 s`."""
    return f"{horizon_s:.3g} s"


def _part(
    model_name: str, model: Model, name: str, record: Record, horizons: Sequence[float], predictor: Predictor | None
) -> _Part:
    """One model on one record."""

    def without(what: str, reason: str) -> LeftOut:
        return LeftOut(model_name, name, what, reason)

    turned = record.turned(model.positive_rudder)
    try:
        found = stretches_of(model, turned, predictor)
    except CannotFit as reason:
        return _Part({}, None, (), (without("record", str(reason)),))
    left_out = [without(channel, reason) for channel, reason in _missing(model, turned).items()]
    run = run_of(found, turned, model_name, name)
    sums = {(channel, FREE): value for channel, value in run.squares().items()} | _sums_ahead(found, horizons)
    stretch = max(found, key=lambda one: one.record.n)
    longest = turned.slice(stretch.place.start, stretch.place.stop)
    manoeuvre = performed(longest)
    if not manoeuvre.kind:
        return _Part(sums, run, (), (*left_out, without("manoeuvring indices", manoeuvre.reason)))
    return _Part(sums, run, tuple(_index_rows(model_name, name, longest, stretch, manoeuvre)), tuple(left_out))


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


def _sums_ahead(found: Sequence[Stretch], horizons: Sequence[float]) -> dict[tuple[str, str], Squares]:
    """Sums of squares of predictions ahead by channel and horizon."""
    sums: dict[tuple[str, str], Squares] = {}
    labels = [ONE_STEP, *map(label, horizons)]
    for stretch in found:
        for horizon, states in zip(labels, stretch.ahead(horizons), strict=True):
            for state, more in states.items():
                key = COLUMNS[stretch.model.states[state]], horizon
                sums[key] = sums.get(key, Squares()).plus(more)
    return sums


def _index_rows(model: str, name: str, piece: Record, stretch: Stretch, manoeuvre: RecordedManoeuvre) -> list[Index]:
    """The indices of the record's longest stretch."""
    measured = measured_indices(piece, manoeuvre)
    if "psi" in stretch.model.states and stretch.model.states.index("psi") not in stretch.known:
        simulated: IndexValues = {}, {}
    else:
        simulated = simulated_indices(stretch, piece, manoeuvre)
    return rows(model, name, length_of(stretch.model), manoeuvre, measured, simulated)


def _scores(
    sums: Mapping[Key, Squares], models: Sequence[str], records: Sequence[str], times: Mapping[str, float]
) -> list[ErrorScore]:
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
                together = ErrorScore(model, record, None, horizon, times.get(horizon), count, np.nan, mean)
                out += [*known, together] if known else []
    return out


def _score(
    sums: Mapping[Key, Squares], records: Sequence[str], key: tuple[str, str | None, str, str], horizon_s: float | None
) -> ErrorScore:
    model, record, channel, horizon = key
    total = Squares()
    for name in records if record is None else (record,):
        total = total.plus(sums.get((model, name, channel, horizon), Squares()))
    return ErrorScore(model, record, channel, horizon, horizon_s, total.n, *total.scores())
