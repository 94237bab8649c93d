"""The Cramer-Rao bound: the best accuracy of any unbiased estimate of a model from given records.

Source: Ljung 1999, System Identification, sec 7.4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...datasets.record import Record
from ...models.errors import BadInput, CannotFit
from ...models.model import Model
from ..likelihood.linear_problem import NULL
from ..numerics import factors
from ..records.series import Series, series_of
from ..results.fit import blas_limited, prepared, propagate
from ..simulation import free_run


def cramer_rao(
    model: Model, records: Sequence[Record], noise_sd: Mapping[str, float], initial_states: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Smallest standard deviation of the published parameters (q,), and of the coefficients the covariance (p, p).

    The Fisher information of white Gaussian sensor noise about the free run with the true coefficients, driven by each
    record's inputs (taken as exact) and sampled where the record has samples.

    Parameters
    ----------
    model : with the true coefficients.
    records : inputs, initial states, sampling and gaps are taken from them.
    noise_sd : standard deviation > 0 by channel name (`heading_rad`, ...); channels that a record lacks do not count.
    initial_states : whether the initial states are unknown too (nuisance parameters).

    Returns
    -------
    Standard deviations and diagonal elements of the covariance are inf for what the records do not identify.

    Raises
    ------
    CannotFit : the model has unknown coefficients, a run diverges, or a record has none of the channels.
    BadInput : a standard deviation is not positive, or a channel is no state of a model.
    """
    if not model.known:
        raise CannotFit(f"model {model.id} has unknown coefficients: there is no bound")
    symbols = _symbols(noise_sd)
    found = [_information(model, record, symbols, initial_states) for record in prepared(records, model)]
    p, own = len(model.coordinates), [factor.shape[1] - 1 - len(model.coordinates) for factor in found]
    places = p + np.cumsum([0, *own])
    width = int(places[-1])
    with blas_limited(), np.errstate(all="ignore"):
        rows = [free_run.embed(r, None, p, int(place), width) for r, place in zip(found, places, strict=False)]
        solution = factors.solve(factors.fold(factors.empty(width), np.vstack(rows)), NULL)
        covariance = solution.covariance[:p, :p]
        return propagate(model.parameters_jacobian(model.coefficients), covariance), covariance


def information(model: Model, record: Record, noise_sd: Mapping[str, float]) -> np.ndarray:
    """Triangular factor (<= p, p) of one record's Fisher information of the coefficients, initial states unknown.

    R'R is the information; factors of several records are stacked.  Raises as `cramer_rao`.
    """
    (prepared_record,) = prepared([record], model)
    factor = _information(model, prepared_record, _symbols(noise_sd), True)[:, :-1]
    p = len(model.coordinates)
    nuisance = factor.shape[1] - p
    turned = np.asarray(np.linalg.qr(np.hstack([factor[:, p:], factor[:, :p]]), mode="r"))
    return turned[nuisance:, nuisance:]


def _symbols(noise_sd: Mapping[str, float]) -> dict[str, float]:
    """State symbol -> standard deviation."""
    from ...models.model import CHANNELS

    names = {channel: symbol for symbol, channel in CHANNELS.items() if symbol not in ("delta", "n")}
    for channel, sd in noise_sd.items():
        if channel not in names:
            raise BadInput(f"noise of {channel!r} is not that of a state", hint=f"known: {', '.join(names)}")
        if not sd > 0.0:
            raise BadInput(f"noise of {channel!r} is {sd!r}, a positive standard deviation is needed")
    return {names[channel]: sd for channel, sd in noise_sd.items()}


def _information(model: Model, record: Record, symbols: Mapping[str, float], initial: bool) -> np.ndarray:
    """Triangular factor of one record's derivatives in units of the noise, gaps left out."""
    series = series_of(record, model, tuple(symbols))
    free = [i for i, name in enumerate(model.states) if initial and _unknown(name, i, series)]
    with blas_limited(), np.errstate(all="ignore"):
        outputs = free_run.output_factors(model, series, series.start, free)
        rows = [r / symbols[model.states[i]] for i, r in zip(series.columns, outputs, strict=True)]
        factor = factors.fold(np.zeros((0, rows[0].shape[1])), np.vstack(rows))
    if not np.isfinite(factor[:, :-1]).all():
        raise CannotFit(f"record {record.name}: the run with the true coefficients diverges")
    return factor


def _unknown(name: str, index: int, series: Series) -> bool:
    return name in ("u", "v", "w", "r") or index in series.columns
