"""Instrumental variables: lagged regressors, then regressors simulated with the estimate itself, iterated.

Instruments z are regressors without the noise of the regressors phi: z'(y - phi c) = 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.tuning.space import Choice, Integer
from ..estimation.numerics import factors
from ..estimation.records.series import Series, series_of
from ..estimation.regression.least_squares import SMALLEST_RESIDUAL
from ..estimation.regression.samples import LONGEST_STEP, check_enough_rows, n_accelerations
from ..estimation.regression.schemes import SCHEMES
from ..estimation.regression.starts import starts_of
from ..estimation.results.fit import Fit
from ..estimation.simulation.free_run import start_state
from ..models.errors import FitFailed
from ..models.linear_algebra import pinv
from ..models.model import Model
from .base import DIFFERENCE, method
from .options import POSITIVE, option, whole, words

INSTRUMENTS = ("simulated", "lagged")


@method("iv", "instrumental variables, lagged and simulated, iterated")
def Iv(
    records: Sequence[Record],
    model: Model,
    instruments: str = option(
        "simulated", "'simulated' or 'lagged'", words("instruments", INSTRUMENTS), Choice(*INSTRUMENTS)
    ),
    lag: int = option(4, "samples by which lagged instruments are late", whole(1), Integer(1, 40, log=True)),
    iterations: int = option(
        12,
        "most simulations; the iteration ends when no coefficient changes by a hundredth of its standard error",
        whole(1),
    ),
    horizon_s: float | None = option(
        None,
        "the simulation is restarted from the record after so many seconds, and whenever it is far from the record; "
        "None simulates the whole record as long as it stays near",
        POSITIVE,
    ),
    scheme: str = option(
        "triple-integral",
        "difference scheme, see `helmbench.estimation.regression.schemes`; the default integrates, so that the "
        "equation's noise stays white",
        DIFFERENCE,
    ),
) -> Fit:
    """Instrumental-variable estimate, iterated as in refined IV (SRIVC).

    Noise on the channels is in the regressors too and biases least squares.  Instruments are regressors without that
    noise: those of a run simulated with the last estimate from the record's inputs ('simulated'), or those of the
    record some samples earlier ('lagged'), which also start the iteration.

    Equations are weighted by their residuals.  Standard errors allow for noise that is correlated over a few samples
    (Newey & West 1987).  Young & Jakeman 1979; Garnier & Young 2008 for SRIVC.
    """
    rows = [_lagged(record, model, scheme, lag) for record in records]
    check_enough_rows(sum(y.size for y, *_ in rows), model)
    found, count, converged = _solve(rows), 0, True
    if instruments == "simulated":
        found, count, converged = _refined(records, model, found, scheme, iterations, horizon_s)
    message = "" if converged else f"not converged after {count} simulations"
    return found._replace(converged=converged, message=message, n_iterations=count + 1)


def _refined(
    records: Sequence[Record], model: Model, first: Fit, scheme: str, iterations: int, horizon_s: float | None
) -> tuple[Fit, int, bool]:
    """Iterated solution with simulated instruments, the number of simulations, and whether it has converged.

    It starts from `first` or from one of the least-squares starts, whichever simulates the records best.  Without
    convergence the solution that simulates the records best is returned.
    """
    outputs = [series_of(record, model).outputs for record in records]
    own = [_evaluated(record, model, scheme)[:2] for record in records]

    def tried(c: np.ndarray) -> tuple[np.ndarray, list[Record], float]:
        """Coefficients (p,), the records that they simulate, and how far those are from the measured ones."""
        known = model.with_coefficients(c)
        runs = [restarted_run(record, known, horizon_s) for record in records]
        return c, runs, sum(_distance(y, run, known) for y, run in zip(outputs, runs, strict=True))

    candidates = [first.coefficients, *(start.coefficients for start in starts_of(records, model))]
    here, runs, _ = min(map(tried, candidates), key=lambda one: one[2])
    best, found = np.inf, first
    for count in range(1, iterations + 1):
        rows = zip(own, runs, strict=True)
        new = _solve([_without_gaps(y, phi, _evaluated(run, model, scheme)[1]) for (y, phi), run in rows])
        before, (here, runs, cost) = here, tried(new.coefficients)
        sd = np.sqrt(np.diag(np.asarray(new.covariance)))
        change = np.abs(new.coefficients - before) / np.where(sd > 0.0, sd, 1.0)
        still = np.all(change[np.isfinite(sd)] < STILL) or np.allclose(new.coefficients, before, rtol=1e-9, atol=0.0)
        if cost <= best or count == 1:
            best, found = cost, new
        if still:
            return new, count, True
    return found, iterations, False


Rows = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Rows of one record: y (N, k), phi (N, k, p) and the instruments z (N, k, p)."""
LAGS = 6
"""Samples over which the residuals may be correlated."""
STILL = 0.01
"""Change of a coefficient, in standard errors, below which the iteration has converged."""
SMALLEST_SINGULAR = 1e-14
"""Singular values, relative to the largest, that a pseudo-inverse leaves out."""


def _distance(outputs: np.ndarray, run: Record, model: Model) -> float:
    """Mean squared error of a run from outputs (N, c), in units of their standard deviations; inf where not finite."""
    error = (outputs - series_of(run, model).outputs) / np.maximum(np.nanstd(outputs, axis=0), 1e-12)
    known = np.isfinite(outputs)
    value = float((np.where(known, error, 0.0) ** 2).sum() / max(known.sum(), 1))
    return value if np.isfinite(value) else np.inf


def _evaluated(record: Record, model: Model, scheme: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """y (N, k), phi (N, k, p) with nan rows where the record has gaps, and their times (N,)."""
    samples = SCHEMES[scheme](record, model)
    k, p = n_accelerations(model), len(model.coordinates)
    blocks = list(samples.blocks(model))
    if not blocks:
        return np.zeros((0, k)), np.zeros((0, k, p)), np.zeros(0)
    y, phi = (np.concatenate([block[i] for block in blocks]) for i in range(2))
    return y, phi, samples.time_s


def _without_gaps(y: np.ndarray, phi: np.ndarray, z: np.ndarray) -> Rows:
    good = np.isfinite(y).all(axis=1) & np.isfinite(phi).all(axis=(1, 2)) & np.isfinite(z).all(axis=(1, 2))
    return y[good], phi[good], z[good]


def _lagged(record: Record, model: Model, scheme: str, lag: int) -> Rows:
    """Rows of a record whose instruments are the regressors `lag` samples earlier."""
    y, phi, time = _evaluated(record, model, scheme)
    if len(y) <= lag:
        return y[:0], phi[:0], phi[:0]
    z = np.full_like(phi, np.nan)
    z[lag:] = phi[:-lag]
    late = np.full(len(time), np.inf)
    late[lag:] = time[lag:] - time[:-lag]
    z[late > LONGEST_STEP * lag * record.dt] = np.nan
    return _without_gaps(y, phi, z)


def _factor(parts: Sequence[Rows], weight: np.ndarray) -> np.ndarray:
    """Triangular factor of [z | phi | y] over all rows, equation e multiplied by weight[e]."""
    p = parts[0][1].shape[2]
    found = np.zeros((0, 2 * p + 1))
    for y, phi, z in parts:
        for e in np.flatnonzero(weight):
            found = factors.fold(found, weight[e] * np.column_stack([z[:, e], phi[:, e], y[:, e]]))
    return found


def _solve(parts: Sequence[Rows]) -> Fit:
    """Coefficients with z'(y - phi c) = 0; solved twice, the second time with equations weighted by their residuals."""
    y = np.concatenate([y for y, *_ in parts])
    used = np.array([any(np.any(phi[:, e]) for _, phi, _ in parts) for e in range(y.shape[1])])
    if not len(y) or not used.any():
        raise FitFailed("the regression has no finite, non-zero columns")
    rms = factors.divisors(np.sqrt((y**2).mean(axis=0)))
    found = _weighted(parts, np.where(used, 1.0 / rms, 0.0))
    if used.sum() > 1:
        sd = np.maximum(found.extra["residual_sd"], SMALLEST_RESIDUAL * rms)
        found = _weighted(parts, np.where(used, 1.0 / sd, 0.0))
    return found


def _weighted(parts: Sequence[Rows], weight: np.ndarray) -> Fit:
    """Solution with equations multiplied by weight (k,): z = Q R, and Q'phi c = Q'y by singular values."""
    p = parts[0][1].shape[2]
    factor = _factor(parts, weight)
    if len(factor) < p or not np.isfinite(factor).all():
        raise FitFailed("the instruments are not finite or too few")
    solution = factors.solve(factor[:p, p:])
    product = factor[:p, p : 2 * p]
    inverse = _pseudo_inverse(product)
    residuals = [(y - phi @ solution.x) for y, phi, _ in parts]
    moments = inverse @ _moments(parts, weight, residuals, factor[:p, :p]) @ inverse.T
    covariance = (moments + moments.T) / 2.0
    unknown = ~np.isfinite(np.diag(solution.covariance))
    covariance[unknown, unknown] = np.inf
    sd = np.sqrt((np.concatenate(residuals) ** 2).mean(axis=0))
    return Fit(solution.x, covariance, extra={"residual_sd": sd.tolist(), "rank": solution.rank})


def _moments(
    parts: Sequence[Rows], weight: np.ndarray, residuals: Sequence[np.ndarray], triangle: np.ndarray
) -> np.ndarray:
    """Covariance (p, p) of Q'e for residuals e that are correlated over `LAGS` samples (Bartlett weights)."""
    inverse = _pseudo_inverse(triangle)
    total = np.zeros_like(triangle)
    for (*_, z), error in zip(parts, residuals, strict=True):
        score = np.zeros((len(error), len(triangle)))
        for e in np.flatnonzero(weight):
            score += z[:, e] @ inverse * (weight[e] ** 2 * error[:, e, None])
        total += score.T @ score
        for lag in range(1, min(LAGS, len(score) - 1) + 1):
            cross = score[lag:].T @ score[:-lag]
            total += (1.0 - lag / (LAGS + 1.0)) * (cross + cross.T)
    return total


def _pseudo_inverse(matrix: np.ndarray) -> np.ndarray:
    """Pseudo-inverse by singular values, columns scaled to unit length."""
    scale = factors.column_lengths(matrix)
    return pinv(matrix / scale, rcond=SMALLEST_SINGULAR) / scale[:, None]


# ---- A model simulated along a record with restarts at the measurements wherever the run is far from them.

FAR = 3.0
"""Error of a run, in standard deviations of the measured channel, from which it is restarted at the measurements."""
SHORTEST_PIECE = 8
"""Samples of the first piece that is simulated after a restart."""
SHORTEST_HORIZON = 8
"""Samples between two restarts at least."""


def restarted_run(record: Record, model: Model, horizon_s: float | None = None) -> Record:
    """The record with its state channels simulated from its inputs, gaps where the record has them.

    The run starts from the record's first samples.  It is restarted at the measurements every `horizon_s` seconds
    (None: never for this reason) and wherever it is far from them or not finite.
    """
    from ..models.model import CHANNELS

    series = series_of(record, model)
    observed = series.observe(_states(model, series, horizon_s))
    channels = {}
    for column in series.columns:
        name = CHANNELS[model.states[column]]
        channels[name] = np.where(np.isfinite(record.column(name)), observed[:, column], np.nan)
    return record.with_channels(**channels)


def _states(model: Model, series: Series, horizon_s: float | None) -> np.ndarray:
    """States (M, n) of the restarted run on the grid of the series.

    A run is simulated in pieces, each twice as long as the one before: the cost stays linear in the number of samples
    however often it is restarted.
    """
    from ..models.simulate import simulate

    m, columns = len(series.inputs), series.columns
    length = m if horizon_s is None else max(SHORTEST_HORIZON, round(horizon_s / series.dt))
    measured = np.full((m, len(model.states)), np.nan)
    measured[series.index[:, None], columns] = series.outputs
    far = FAR * np.maximum(np.nanstd(series.outputs, axis=0), 1e-12)
    states, state, first = np.empty_like(measured), start_state(model, series, series.start), 0
    while first < m:
        states[first], last, end, piece = state, first, min(first + length, m) - 1, SHORTEST_PIECE
        while last < end:
            run = simulate(model, series.inputs[last : min(last + piece, end) + 1], series.dt, states[last])[1:]
            off = np.abs(run[:, columns] - measured[last + 1 : last + 1 + len(run), columns]) > far
            near = np.isfinite(run).all(axis=1) & ~off.any(axis=1)
            count = len(run) if near.all() else int(np.argmin(near))
            states[last + 1 : last + 1 + count] = run[:count]
            last, piece = last + count, 2 * piece
            if count < len(run):
                break
        first = last + 1
        if first < m:
            known, before = np.isfinite(measured[first]), states[last]
            state = np.where(known, measured[first], np.where(np.isfinite(before), before, 0.0))
    return states
