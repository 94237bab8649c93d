"""Residuals: their correlation in time and with the rudder, inside 99 % bands, and their statistics.

Of a model with the right equations they are the sensors' noise: white, and independent of the rudder.  Every run starts
from the initial state that fits it best, so that the noise of the first sample does not stay in it.
Source: Ljung 1999, System Identification, sec 16.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...datasets.columns import CANONICAL
from ...datasets.instruments import hull_record
from ...datasets.record import Record
from ...models.errors import BadInput
from ...models.model import CHANNELS, Model
from ..records.gaps import unbroken
from ..records.series import Series, series_of
from ..results.predictor import Predictor
from ..simulation.free_run import residuals
from ..simulation.selection import fitted_start
from .estimate import Estimate

if TYPE_CHECKING:
    import pandas as pd


LAGS = 25
"""Number of lags above 0; a quarter of the samples in short records."""
REACH = 4
"""Lags to the rudder are spread over the shortest record by so many."""
LEVEL = 0.99


class Correlation(NamedTuple):
    """Correlation coefficients (K,) at lags (K,) in s, and half the width of the band that holds 99 % of each where
    there is no correlation."""

    lag_s: np.ndarray
    values: np.ndarray
    band: float

    @property
    def outside(self) -> int:
        """How many lie outside the band."""
        return int(np.sum(np.abs(self.values) > self.band))

    @property
    def significant(self) -> bool:
        """Whether the largest lies outside a band that holds all of them together with 99 % (Bonferroni)."""
        from scipy.stats import norm

        alone, together = (norm.isf((1.0 - LEVEL) / 2.0 / k) for k in (1, max(self.values.size, 1)))
        return bool(np.any(np.abs(self.values) > self.band * together / alone))


@dataclass(frozen=True)
class ChannelResiduals:
    """Residuals of one channel over all records.

    n : samples;  rms : in the channel's SI unit;  noise_sd : of the sensor, estimated from the records;  in_time :
    autocorrelation at lags above 0;  with_rudder : cross-correlation at lags from 0 on, residual after rudder.
    """

    channel: str
    n: int
    rms: float
    noise_sd: float
    in_time: Correlation
    with_rudder: Correlation

    @property
    def ratio(self) -> float:
        """Residual relative to the sensor's noise."""
        return self.rms / self.noise_sd if self.noise_sd > 0.0 else np.inf

    @property
    def unit(self) -> str:
        """SI unit of the channel."""
        return CANONICAL[self.channel]


def channel_residuals(estimate: Estimate, records: Sequence[Record]) -> tuple[ChannelResiduals, ...]:
    """Residuals of the free runs along records as they were read, channel by channel; none where a run diverges.

    Raises
    ------
    CannotFit : a record lacks an input, or measures no state of the model.
    """
    from ..information.identifiability import noise_of

    model = estimate.model
    given = unbroken([hull_record(record, model) for record in records], model)
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for record in given:
        series = series_of(record, model)
        errors = _errors(estimate, series)
        rudder = series.observe(series.inputs)[:, 0]
        for place, state in enumerate(series.columns.tolist()):
            found.setdefault(CHANNELS[model.states[state]], []).append((errors[:, place], rudder))
    noise = noise_of(given)
    step = float(np.median([record.dt for record in given]))
    kept = {c: pairs for c, pairs in found.items() if c in noise and _finite(pairs)}
    return tuple(_channel(channel, pairs, noise[channel], step) for channel, pairs in kept.items())


def _errors(estimate: Estimate, series: Series) -> np.ndarray:
    """Measured minus simulated outputs (N, c); a black box starts where the record starts."""
    with np.errstate(all="ignore"):
        if estimate.predictor is None:
            return residuals(estimate.model, fitted := fitted_start(estimate.model, series), fitted.start)
        run = estimate.predictor.simulate(series.inputs, series.dt, series.start)
        return series.outputs - series.observe(run)[:, series.columns]


def _finite(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> bool:
    """Whether there are residuals, and none is infinite."""
    return any(np.isfinite(e).sum() > 4 for e, _ in pairs) and not any(np.isinf(e).any() for e, _ in pairs)


def _channel(
    channel: str, pairs: Sequence[tuple[np.ndarray, np.ndarray]], noise_sd: float, step_s: float
) -> ChannelResiduals:
    errors = [_centred(e) for e, _ in pairs]
    rudders = [_centred(np.where(np.isfinite(e), u, np.nan)) for e, u in pairs]
    pooled = np.concatenate([e[np.isfinite(e)] for e, _ in pairs])
    longest = max(1, min(e.size for e in errors) // REACH)
    near, far = np.arange(1, min(LAGS, longest) + 1), np.arange(0, longest + 1, max(1, longest // LAGS))[: LAGS + 1]
    own, cross = correlation(errors, errors, longest), correlation(errors, rudders, longest)
    taper = 1.0 - np.arange(1, longest + 1) / (longest + 1)
    shared = 1.0 + 2.0 * float(np.sum(taper * own[1:] * correlation(rudders, rudders, longest)[1:]))
    in_time = Correlation(step_s * near, own[near], _band(1.0, pooled.size))
    with_rudder = Correlation(step_s * far, cross[far], _band(shared, pooled.size))
    return ChannelResiduals(channel, pooled.size, float(np.sqrt(np.mean(pooled**2))), noise_sd, in_time, with_rudder)


def _centred(values: np.ndarray) -> np.ndarray:
    """Values (N,) about their mean; gaps are 0, so that they add nothing."""
    known = np.isfinite(values)
    return np.where(known, values - (values[known].mean() if known.any() else 0.0), 0.0)


def correlation(first: Sequence[np.ndarray], second: Sequence[np.ndarray], lags: int) -> np.ndarray:
    """Correlation coefficients (lags + 1,) of the first series with the second so many samples before, over records."""
    from scipy.signal import correlate

    power = np.sqrt(sum(float(a @ a) for a in first) * sum(float(b @ b) for b in second))
    if not power > 0.0:
        return np.zeros(lags + 1)
    products = (correlate(a, b, "full")[b.size - 1 : b.size + lags] for a, b in zip(first, second, strict=True))
    return np.sum(list(products), axis=0) / power


def _band(variance: float, n: int) -> float:
    """Half the width of the 99 % band of a coefficient of n samples; `variance` times n is that of white series.

    Of a cross-correlation it is the sum of the products of both autocorrelations, at least 1.
    """
    from scipy.stats import norm

    return float(norm.isf((1.0 - LEVEL) / 2.0) * np.sqrt(max(variance, 1.0) / n))


HORIZONS = ("free", "one")
LARGEST_LAG = 20
"""Lags of the Ljung-Box statistic; a tenth of the samples in short records."""


def residual_report(
    model: Model, records: Sequence[Record], horizon: str, predictor: Predictor | None = None
) -> pd.DataFrame:
    """A row a channel; `Estimate.residual_report` says what each column means.

    `predictor` predicts in the model's place where it is given (a black box).
    """
    import pandas as pd

    from ..run.prediction import one_step
    from ..run.run import CHANNELS, run_along

    if horizon not in HORIZONS:
        raise BadInput(f"unknown horizon {horizon!r}", hint=f"known: {', '.join(HORIZONS)}")
    if horizon == "free":
        runs = [run_along(model, record, predictor) for record in records]
        pairs = {name: [pair for run in runs if name in run.predicted for pair in run.pairs(name)] for name in CHANNELS}
    else:
        steps = [step for record in records for step in one_step(model, record, predictor)]
        pairs = {name: [step.pair for step in steps if step.channel == name] for name in CHANNELS}
    rows = {name: _row(name, own) for name, own in pairs.items() if own}
    frame = pd.DataFrame.from_dict(rows, orient="index")
    frame.index.name = "channel"
    return frame


def _row(channel: str, pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> dict[str, Any]:
    from scipy.stats import chi2

    from ...datasets.columns import CANONICAL
    from ..run.squares import pooled as summed
    from ..run.squares import squares

    series = [residuals[np.isfinite(residuals)] for residuals in (seen - run for seen, run in pairs)]
    pooled = np.concatenate(series)
    rmse, r2 = summed(squares(*pair) for pair in pairs).scores()
    tests = [ljung_box(values) for values in series if values.size > 2]
    centred = [values - values.mean() for values in series if values.size > 1]
    statistic, degrees = sum(q for q, _ in tests), sum(lags for _, lags in tests)
    return {
        "unit": CANONICAL[channel],
        "n": pooled.size,
        "mean": float(pooled.mean()) if pooled.size else np.nan,
        "sd": float(pooled.std(ddof=1)) if pooled.size > 1 else np.nan,
        "rmse": rmse,
        "r2": r2,
        "lag_1": correlation(centred, centred, 1)[1] if np.any([values.any() for values in centred]) else np.nan,
        "ljung_box": statistic if tests else np.nan,
        "degrees": degrees,
        "p_white": float(chi2.sf(statistic, degrees)) if tests else np.nan,
    }


def ljung_box(residuals: np.ndarray) -> tuple[float, int]:
    """Statistic Q = n (n + 2) sum_k rho_k^2 / (n - k) of residuals (N,), and its number of lags.

    Under white noise it has a chi-square distribution with as many degrees of freedom (Ljung and Box 1978, Biometrika
    65, 297-303).  Gaps have been left out before; constant residuals give 0.
    """
    n = residuals.size
    lags = min(LARGEST_LAG, max(1, n // 10))
    centred = [residuals - residuals.mean()]
    rho = correlation(centred, centred, lags)[1:]
    return float(n * (n + 2) * np.sum(rho**2 / (n - np.arange(1, lags + 1)))), lags
