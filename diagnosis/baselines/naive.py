"""Diagnosers that are compared with: nothing is wrong, the cause that fits best, and the cause of lowest BIC (output
error, a test of whiteness, and BIC over the bank of causes).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import chi2_tail
from ..innovations.searches import ByChangePoint, longest
from .output_error import Chosen, FilterRuns, OfFreeRuns, RunFit, cost, fittable, rms

if TYPE_CHECKING:
    from ...checks.base import Check
    from ...datasets.record import Record
    from ...models.model import Model
    from ..causes.base import Cause
    from ..innovations.state import Variant
    from ..options import Options

MOST = 2
"""Causes that are added one after the other."""
CHANGE_TIMES = 8
LAGS = 20


class Nothing(OfFreeRuns):
    """Always says that nothing is wrong: what the others are compared with where most records are clean."""

    name = "nothing"
    title = "naive: nothing is wrong, whatever the records say"

    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """Name nothing."""
        return [], "adequate", "nothing was looked for"


class BestFit(OfFreeRuns):
    """Every cause of the bank is fitted by least squares to the free runs, and the one that fits best is named.

    It always names one: no test says whether anything is wrong, and nothing is charged for further parameters.
    """

    name = "best-fit"
    title = "naive: free-run output error, the cause that fits best, without a test"

    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """Fit every cause to the free runs and name the one of the least error."""
        base = runs.base()
        weight = 1.0 / rms(base.residuals)
        fits = [Chosen(c, *fit_cause(runs, base, c, v)) for c, v in fittable(runs, options.causes()).items()]
        chosen = sorted(fits, key=lambda one: cost(one.fit.residuals, weight))[:1]
        return chosen, "named" if chosen else "adequate", "the least error of free runs of the training records"


class ResidualBic(OfFreeRuns):
    """Free-run output error from the filtered first seconds, independent normal residuals.

    White residuals (Ljung and Box 1978, each channel at a share of alpha): adequate.  Else every cause of the bank is
    fitted and the lowest BIC (Schwarz 1978) names it; a second is added if it lowers BIC further.  Nothing below the
    base model: unexplained.  Causes that only add variance (waves, outliers, jitter) are outside an output-error fit.
    """

    name = "residual-bic"
    title = "naive: free-run output error, whiteness test, BIC over the bank"

    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """Fit every cause to the free runs and name the one of lowest BIC."""
        base = runs.base()
        p = whiteness(base, runs)
        chosen = [] if p > options.alpha else select(runs, base, options.causes())
        verdict = "named" if chosen else "adequate" if p > options.alpha else "unexplained"
        reason = f"free-run residuals are {'' if p > options.alpha else 'not '}white (p = {p:.2g})"
        return chosen, verdict, reason


def whiteness(fit: RunFit, runs: FilterRuns) -> float:
    """Smallest p-value of the Ljung-Box tests of all channels and records, times their number."""
    p_values = []
    for a, b in zip(runs.est.edges[:-1], runs.est.edges[1:], strict=True):
        for series in fit.residuals[a:b].T:
            known = series[~np.isnan(series)]
            if known.size > 5 * LAGS:
                p_values.append(float(chi2_tail(ljung_box(known), LAGS)))
    return min(1.0, min(p_values, default=1.0) * max(len(p_values), 1))


def ljung_box(series: np.ndarray) -> float:
    """Ljung-Box statistic of a series (n,), LAGS lags, about zero: free runs that are off are not white either."""
    n, power = series.size, float(series @ series)
    if not 0.0 < power < np.inf:
        return np.inf
    r = np.array([series[k:] @ series[:-k] for k in range(1, LAGS + 1)]) / power
    return float(n * (n + 2.0) * np.sum(r**2 / (n - np.arange(1, LAGS + 1))))


def select(runs: FilterRuns, base: RunFit, only: Collection[Check] | None) -> list[Chosen]:
    """Causes added while BIC falls: the best of all that can be fitted, at most MOST."""
    tried = fittable(runs, only)
    chosen: list[Chosen] = []
    now, charged = base, 0.0
    for _ in range(MOST):
        rest = [c for c in tried if c not in [x.cause for x in chosen]]
        fits = [Chosen(c, *fit_cause(runs, now, c, tried[c])) for c in rest]
        best = min(fits, key=lambda item: item.fit.criterion(), default=None)
        if best is None or not best.fit.criterion() < now.criterion() - charged:
            break
        charged = len(best.fit.columns) * float(np.log(np.isfinite(best.fit.residuals).sum()))
        now = best.fit
        chosen.append(best)
    return chosen


def fit_cause(runs: FilterRuns, before: RunFit, cause: Cause, variants: Sequence[Variant]) -> tuple[Variant, RunFit]:
    """The variant with the largest linear gain, fitted from the best of the cause's starts."""
    if isinstance(cause.search, ByChangePoint):
        return _fit_change(runs, before, variants[0])
    weight = 1.0 / rms(before.residuals)
    gains = [_linear_gain(runs.columns(before.setting, v, before.residuals), before, weight) - len(v) for v in variants]
    variant = variants[int(np.argmax(gains))]
    trials = cause.search.starts(runs.est, before.setting, variant)
    start = min(trials, key=lambda s: cost(runs.residuals(s), weight)) if len(trials) > 1 else None
    return variant, runs.fit(before, variant, start)


def _fit_change(runs: FilterRuns, before: RunFit, variant: Variant) -> tuple[Variant, RunFit]:
    """A change from the best of a few times on."""
    size, time_s = variant
    times = np.linspace(0.0, longest(runs.est), CHANGE_TIMES + 2)[1:-1]
    fits = [runs.fit(before, (size,), runs.est.at(before.setting, time_s, float(t)), 1) for t in times]
    best = min(fits, key=lambda fit: fit.criterion())
    return variant, runs.fit(before, variant, best.setting)


def _linear_gain(columns: np.ndarray, before: RunFit, weight: np.ndarray) -> float:
    """Fall of half the weighted sum of squares that a linear fit of the columns would bring."""
    weights = np.tile(weight, len(before.residuals))
    target = np.where(np.isfinite(before.residuals), before.residuals, 0.0).ravel() * weights
    basis = np.linalg.qr((columns * weights).T + 1e-300)[0]
    return 0.5 * float(np.sum((basis.T @ target) ** 2))
