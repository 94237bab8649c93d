"""Ensembles of free runs: what an estimate says of its own uncertainty, and how well it tells the errors.

The coefficients of a model are drawn from the normal density of their covariance; learnt functions from what their
regressors say of their uncertainty (`black_box.compiled`).  The spread of the free runs is compared with the records by
the continuous ranked probability score and the share of samples inside the ensemble's 95 % interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...datasets.record import Record
from ...models.model import Model
from ..estimates.estimate import Estimate
from ..methods_only.black_box.hybrid import HybridPredictor
from ..results.predictor import ModelPredictor, Predictor
from ..run.run import run_of
from ..run.stretch import Stretch, stretches_of
from ..validation.validate import TOGETHER

COUNT = 20
"""Members of an ensemble."""


def members(estimate: Estimate, count: int, rng: np.random.Generator) -> list[Predictor]:
    """At most `count` predictors drawn from the estimate's uncertainty; none where that is not stated, or infinite."""
    predictor = estimate.predictor
    models = _models(estimate, count, rng)
    if predictor is None:
        return [ModelPredictor(model) for model in models]
    if isinstance(predictor, HybridPredictor):
        parts = predictor.members(count, rng) or [predictor] * len(models)
        return [replace(part, model=model) for part, model in zip(parts, models, strict=False)]
    draw = getattr(predictor, "members", None)  # of predictors that state an uncertainty
    return list(draw(count, rng)) if draw else []


def _models(estimate: Estimate, count: int, rng: np.random.Generator) -> list[Model]:
    """The estimate's model with coefficients drawn from their covariance; none without a finite one."""
    covariance = estimate.covariance
    if covariance is None or not len(covariance) or not np.isfinite(covariance).all():
        return []
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unit = np.where(sd > 0.0, sd, 1.0)
    size, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    factor = unit[:, None] * vectors * np.sqrt(np.maximum(size, 0.0))
    draws = estimate.coefficients + rng.normal(size=(count, len(sd))) @ factor.T
    return [estimate.model.with_coefficients(row) for row in draws]


def ensemble_scores(estimate: Estimate, records: Sequence[Record], seed: int) -> dict[str, Any]:
    """Score and coverage of `COUNT` free runs along records, a mean over records and channels.

    `crps` is in units of the channel's standard deviation in the record: that of an ensemble without spread is its mean
    absolute error.  `coverage` is the share of samples within 1.96 standard deviations of the ensemble's mean.  Sensor
    noise of the records counts as error.  Empty where the estimate states no uncertainty; where a member's run
    diverges, `crps` is infinite and there is no coverage.
    """
    drawn = members(estimate, COUNT, np.random.default_rng(seed))
    if len(drawn) < 2:
        return {}
    found = [one for record in records for one in _of_record(estimate.model, record, drawn)]
    if not found:
        return {}
    crps, coverage = np.mean(found, axis=0)
    return {"crps": float(crps), "coverage": float(coverage)} if np.isfinite(crps) else {"crps": np.inf}


def _of_record(model: Model, record: Record, drawn: Sequence[Predictor]) -> list[tuple[float, float]]:
    """CRPS and coverage of each channel of a record that varies."""
    found, turned = [], record.turned(model.positive_rudder)
    own = stretches_of(model, turned, None if isinstance(drawn[0], ModelPredictor) else drawn[0])
    runs = [run_of([_by(one, member) for one in own], turned, model.id, record.name) for member in drawn]
    for channel, observed in runs[0].measured.channels.items():
        if not all(channel in run.predicted for run in runs):
            continue
        free = np.array([run.predicted[channel] if not run.diverged else np.full(record.n, np.inf) for run in runs])
        known = np.isfinite(observed) & ~np.isnan(free).any(axis=0)
        spread = np.std(observed[known]) if known.any() else 0.0
        if channel in TOGETHER and spread > 0.0:
            found.append(spread_scores(free[:, known] / spread, observed[known] / spread))
    return found


def _by(stretch: Stretch, member: Predictor) -> Stretch:
    """The stretch with a member in the model's place."""
    if isinstance(member, ModelPredictor):
        return replace(stretch, model=member.model)
    return replace(stretch, predictor=member)


def spread_scores(free: np.ndarray, observed: np.ndarray) -> tuple[float, float]:
    """Mean CRPS of members (m, N) for samples (N,), and the share of samples inside the ensemble's 95 % interval.

    The fair score of an ensemble: the mean of |x - y| minus half the mean of |x - x'| over different members (Ferro
    2014, Q. J. R. Meteorol. Soc. 140, 1917, eq 2).  Infinite, and nan, where a member is not finite.
    """
    from ..estimates.assessment import NORMAL_95

    if not np.isfinite(free).all():
        return np.inf, np.nan
    count = len(free)
    weight = 2.0 * np.arange(count) - count + 1.0
    apart = 2.0 * (weight[:, None] * np.sort(free, axis=0)).sum(axis=0) / (count * (count - 1))
    crps = np.abs(free - observed).mean(axis=0) - 0.5 * apart
    inside = np.abs(observed - free.mean(axis=0)) <= NORMAL_95 * free.std(axis=0, ddof=1)
    return float(crps.mean()), float(inside.mean())
