"""Instrumental variables: lagged regressors, then regressors simulated with the estimate itself, iterated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import CannotFit, Fit, FitFailed, Method
from .freerun import start_state
from .ls import check_scheme
from .regression import LONGEST_STEP, SCHEMES, accelerations
from .series import series_of
from .starts import starts_of
from .tuning.space import Choice, Integer

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .series import Series

INSTRUMENTS = ("simulated", "lagged")
LAGS = 6
"""Samples over which the residuals may be correlated."""
FAR = 3.0
"""Error of a run, in spreads of the measured channel, from which it is started anew from the measurements."""
SHORTEST_PIECE = 64
"""Samples that are simulated at first after a run has been started anew."""


class Paired(NamedTuple):
    """Rows of one record: y (N, k), phi (N, k, p) and the instruments z (N, k, p)."""

    y: np.ndarray
    phi: np.ndarray
    z: np.ndarray


class Solved(NamedTuple):
    """An instrumental-variable solution and how far to trust it."""

    coefficients: np.ndarray
    covariance: np.ndarray
    residual_sd: np.ndarray
    rank: int


class Iv(Method):
    """Instrumental-variable estimate, iterated as in refined IV (SRIVC).

    Noise on the channels is in the regressors too and biases least squares.  Instruments are regressors without that
    noise: those of a run simulated with the last estimate from the record's inputs ('simulated'), or those of the
    record some samples earlier ('lagged'), which also start the iteration.

    Parameters
    ----------
    instruments : 'simulated' or 'lagged'.
    lag : samples by which lagged instruments are late.
    iterations : most simulations; it ends when no coefficient moves by a hundredth of its standard error.
    horizon_s : the run is started anew from the record after so many seconds, and whenever it has gone astray; None
        runs on over the whole record.
    scheme : difference scheme, see `regression`; the default integrates, so that the equation's noise stays white.

    Equations are weighted by their residuals.  Standard errors allow for noise that is correlated over a few samples
    (Newey & West 1987).  Young & Jakeman 1979; Garnier & Young 2008 for SRIVC.
    """

    name = "iv"
    title = "instrumental variables, lagged and simulated, iterated"
    search_space: ClassVar = {"instruments": Choice("simulated", "lagged"), "lag": Integer(1, 40, log=True)}

    def __init__(
        self,
        instruments: str = "simulated",
        lag: int = 4,
        iterations: int = 12,
        horizon_s: float | None = None,
        scheme: str = "triple-integral",
    ) -> None:
        self.instruments, self.lag, self.iterations = instruments, lag, iterations
        self.horizon_s, self.scheme = horizon_s, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if self.instruments not in INSTRUMENTS:
            raise BadInput(f"instruments is {self.instruments!r}", hint=f"known: {', '.join(INSTRUMENTS)}")
        if not (self.lag >= 1 and self.iterations >= 1):
            raise BadInput("lag and iterations are numbers from 1 on")
        if self.horizon_s is not None and not self.horizon_s > 0.0:
            raise BadInput(f"horizon_s is {self.horizon_s!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        pairs = [_lagged(record, model, self.scheme, self.lag) for record in records]
        if sum(pair.y.size for pair in pairs) <= len(model.coordinates):
            raise CannotFit(f"{sum(pair.y.size for pair in pairs)} regression rows for too many coefficients")
        found, count, converged = _solve(pairs), 0, True
        if self.instruments == "simulated":
            found, count, converged = self._refined(records, model, found)
        return Fit(
            found.coefficients,
            found.covariance,
            converged,
            "" if converged else f"not converged after {count} simulations",
            count + 1,
            extra={"residual_sd": found.residual_sd.tolist(), "rank": found.rank},
        )

    def _refined(self, records: Sequence[Record], model: Model, first: Solved) -> tuple[Solved, int, bool]:
        """From whichever of the lagged estimate and the least-squares starts simulates the records best."""
        candidates = [first.coefficients, *(start.coefficients for start in starts_of(records, model))]
        ranked = sorted(candidates, key=lambda c: self._misfit(records, model.with_coefficients(c)))
        c, best, found = ranked[0], np.inf, first
        for count in range(1, self.iterations + 1):
            runs = [simulated(record, model.with_coefficients(c), self.horizon_s) for record in records]
            pairs = [_paired(r, run, model, self.scheme) for r, run in zip(records, runs, strict=True)]
            new = _solve(pairs)
            misfit = self._misfit(records, model.with_coefficients(new.coefficients))
            sd = np.sqrt(np.diag(new.covariance))
            moved = np.abs(new.coefficients - c) / np.where(sd > 0.0, sd, 1.0)
            still = np.all(moved[np.isfinite(sd)] < 0.01) or np.allclose(new.coefficients, c, rtol=1e-9, atol=0.0)
            if misfit <= best or count == 1:
                best, found = misfit, new
            if still:
                return new, count, True
            c = new.coefficients
        return found, self.iterations, False

    def _misfit(self, records: Sequence[Record], model: Model) -> float:
        return sum(_distance(record, simulated(record, model, self.horizon_s), model) for record in records)


def simulated(record: Record, model: Model, horizon_s: float | None = None) -> Record:
    """The record with its state channels simulated from its inputs, gaps where the record has them.

    The run starts from the record's first samples, and anew from its measurements every `horizon_s` seconds and
    wherever it has gone astray.
    """
    from ..models.model import CHANNELS

    series = series_of(record, model)
    m = len(series.inputs)
    length = m if horizon_s is None else max(8, round(horizon_s / series.dt))
    measured = np.full((m, len(model.states)), np.nan)
    measured[series.index[:, None], series.columns] = series.outputs
    spread = np.nanstd(series.outputs, axis=0)
    states, first, state = np.empty((m, len(model.states))), 0, start_state(model, series, series.start)
    while first < m:
        run = _followed(model, series, state, measured[first : first + length], spread, first)
        states[first : first + len(run)] = run
        state = run[-1].copy()
        first += len(run)
        if first < m:
            known = np.isfinite(measured[first])
            state[~np.isfinite(state)] = 0.0
            state[known] = measured[first][known]
    observed = series.observe(states)
    channels = {}
    for column in series.columns:
        name = CHANNELS[model.states[column]]
        channels[name] = np.where(np.isfinite(record.column(name)), observed[:, column], np.nan)
    return record.with_channels(**channels)


def _followed(
    model: Model, series: Series, state: np.ndarray, measured: np.ndarray, spread: np.ndarray, first: int
) -> np.ndarray:
    """The run from `state` at grid point `first` (at least one row), to the end of `measured` or where it goes astray.

    It is simulated in pieces, each twice as long as the one before: cost stays linear in the samples, however often a
    run has to start anew.
    """
    from ..models.simulate import simulate

    n, piece = len(measured), SHORTEST_PIECE
    run, done = state[None], 0
    while done < n:
        stop = min(done + piece, n)
        inputs = np.ascontiguousarray(series.inputs[first + max(done - 1, 0) : first + stop])
        ahead = simulate(model, inputs, series.dt, run[-1])[min(done, 1) :]
        near = _near(ahead[:, series.columns], measured[done:stop][:, series.columns], spread)
        run = np.concatenate([run[:done], ahead[:near]])
        if near < len(ahead):
            return run if len(run) else state[None]
        done, piece = stop, 2 * piece
    return run


def _near(run: np.ndarray, measured: np.ndarray, spread: np.ndarray) -> int:
    """Leading rows of a run that are finite and near the measurements."""
    error = np.abs(np.where(np.isfinite(measured), run - measured, 0.0))
    bad = (~np.isfinite(run)).any(axis=1) | (error > FAR * np.maximum(spread, 1e-12)).any(axis=1)
    return int(np.argmax(bad)) if bad.any() else len(run)


def _distance(record: Record, run: Record, model: Model) -> float:
    """Sum over channels of the mean squared relative error of a run; inf where it is not finite."""
    series, own = series_of(record, model), series_of(run, model)
    error = (series.outputs - own.outputs) / np.maximum(np.nanstd(series.outputs, axis=0), 1e-12)
    known = np.isfinite(series.outputs)
    value = float((np.where(known, error, 0.0) ** 2).sum() / max(known.sum(), 1))
    return value if np.isfinite(value) else np.inf


def _evaluated(record: Record, model: Model, scheme: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """y (N, k), phi (N, k, p) with nan rows where the record has gaps, and their times (N,)."""
    parts = SCHEMES[scheme](record, model)
    k, p = accelerations(model), len(model.coordinates)
    blocks = list(parts.blocks(model))
    if not blocks:
        return np.zeros((0, k)), np.zeros((0, k, p)), np.zeros(0)
    y, phi = (np.concatenate([block[i] for block in blocks]) for i in range(2))
    return y, phi, parts.time_s


def _kept(y: np.ndarray, phi: np.ndarray, z: np.ndarray) -> Paired:
    good = np.isfinite(y).all(axis=1) & np.isfinite(phi).all(axis=(1, 2)) & np.isfinite(z).all(axis=(1, 2))
    return Paired(y[good], phi[good], z[good])


def _paired(record: Record, run: Record, model: Model, scheme: str) -> Paired:
    y, phi, _ = _evaluated(record, model, scheme)
    return _kept(y, phi, _evaluated(run, model, scheme)[1])


def _lagged(record: Record, model: Model, scheme: str, lag: int) -> Paired:
    """Instruments: the state columns `lag` samples earlier; inputs, which are exact, are not delayed."""
    y, phi, time = _evaluated(record, model, scheme)
    if len(y) <= lag:
        return Paired(y[:0], phi[:0], phi[:0])
    z = np.full_like(phi, np.nan)
    z[lag:] = phi[:-lag]
    late = np.full(len(time), np.inf)
    late[lag:] = time[lag:] - time[:-lag]
    z[late > LONGEST_STEP * lag * record.dt] = np.nan
    return _kept(y, phi, z)


def _factor(pairs: Sequence[Paired], weight: np.ndarray) -> np.ndarray:
    """Triangular factor of [z | phi | y] over all rows, equation e multiplied by weight[e]."""
    p = pairs[0].phi.shape[2]
    found = np.zeros((0, 2 * p + 1))
    for pair in pairs:
        for e in np.flatnonzero(weight):
            found = factors.fold(found, weight[e] * np.column_stack([pair.z[:, e], pair.phi[:, e], pair.y[:, e]]))
    return found


def _solve(pairs: Sequence[Paired]) -> Solved:
    """Coefficients with z'(y - phi c) = 0, by orthogonal factors of the instruments; twice, to weight the equations."""
    y = np.concatenate([pair.y for pair in pairs])
    used = np.array([any(np.any(pair.phi[:, e]) for pair in pairs) for e in range(y.shape[1])])
    if not len(y) or not used.any():
        raise FitFailed("the regression has no finite, non-zero columns")
    spread = np.sqrt((y**2).mean(axis=0))
    spread = np.where(spread > 0.0, spread, 1.0)
    found = _weighted(pairs, np.where(used, 1.0 / spread, 0.0))
    if used.sum() > 1:
        sd = np.maximum(found.residual_sd, 1e-14 * spread)
        found = _weighted(pairs, np.where(used, 1.0 / sd, 0.0))
    return found


def _weighted(pairs: Sequence[Paired], weight: np.ndarray) -> Solved:
    """Solution with equations multiplied by weight (k,); z = Q R, and Q'phi c = Q'y is solved by singular values."""
    p = pairs[0].phi.shape[2]
    factor = _factor(pairs, weight)
    if len(factor) < p or not np.isfinite(factor).all():
        raise FitFailed("the instruments are not finite or too few")
    solution = factors.solve(factor[:p, p:])
    product = factor[:p, p : 2 * p]
    scale = np.linalg.norm(product, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    inverse = np.linalg.pinv(product / scale, rcond=1e-14) / scale[:, None]
    residuals = [(pair.y - pair.phi @ solution.x) for pair in pairs]
    moments = inverse @ _moments(pairs, weight, residuals, factor[:p, :p]) @ inverse.T
    covariance = (moments + moments.T) / 2.0
    unknown = ~np.isfinite(np.diag(solution.covariance))
    covariance[unknown, unknown] = np.inf
    sd = np.sqrt((np.concatenate(residuals) ** 2).mean(axis=0))
    return Solved(solution.x, covariance, sd, solution.rank)


def _moments(pairs, weight: np.ndarray, residuals, triangle: np.ndarray) -> np.ndarray:
    """Covariance (p, p) of Q'e, the residuals e correlated over `LAGS` samples (Bartlett weights keep it positive)."""
    scale = np.linalg.norm(triangle, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    inverse = np.linalg.pinv(triangle / scale, rcond=1e-14) / scale[:, None]
    total = np.zeros_like(triangle)
    for pair, error in zip(pairs, residuals, strict=True):
        score = np.zeros((len(error), len(triangle)))
        for e in np.flatnonzero(weight):
            score += pair.z[:, e] @ inverse * (weight[e] ** 2 * error[:, e, None])
        total += score.T @ score
        for lag in range(1, min(LAGS, len(score) - 1) + 1):
            cross = score[lag:].T @ score[:-lag]
            total += (1.0 - lag / (LAGS + 1.0)) * (cross + cross.T)
    return total
