"""Statistics of the residuals of an estimate: size, correlation in time, and a test for white noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models.errors import BadInput

if TYPE_CHECKING:
    import pandas as pd

    from ...datasets.record import Record
    from ...models.model import Model
    from ..results.predictor import Predictor

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
    statistic, degrees = sum(q for q, _ in tests), sum(lags for _, lags in tests)
    return {
        "unit": CANONICAL[channel],
        "n": pooled.size,
        "mean": float(pooled.mean()) if pooled.size else np.nan,
        "sd": float(pooled.std(ddof=1)) if pooled.size > 1 else np.nan,
        "rmse": rmse,
        "r2": r2,
        "lag_1": _lag_1(series),
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
    centred = residuals - residuals.mean()
    power = float(centred @ centred)
    if power == 0.0:
        return 0.0, lags
    rho = np.array([centred[k:] @ centred[:-k] / power for k in range(1, lags + 1)])
    return float(n * (n + 2) * np.sum(rho**2 / (n - np.arange(1, lags + 1)))), lags


def _lag_1(series: Sequence[np.ndarray]) -> float:
    """Autocorrelation at one sample, pooled over records that are centred one by one."""
    centred = [values - values.mean() for values in series if values.size > 1]
    power = sum(float(values @ values) for values in centred)
    return sum(float(values[1:] @ values[:-1]) for values in centred) / power if power else np.nan
