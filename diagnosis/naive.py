"""What is commonly done, to compare with: output error, a test of whiteness, and BIC over the bank of causes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .registry import Diagnoser

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..methods.innovations.estimator import Setting
    from ..models.model import Model
    from .causes import Cause, Variant
    from .diagnose import Options
    from .free_run import Fit, FreeRuns
    from .result import Diagnosis, Finding, Gain

MOST = 2
"""Causes that are added one after the other."""
FAULT_TIMES = 8
LAGS = 20


class ResidualBic(Diagnoser):
    """Free-run output error from the filtered first seconds, independent normal residuals.

    White residuals (Ljung and Box 1978, each channel at a share of alpha): adequate.  Else every cause of the bank is
    fitted and the lowest BIC (Schwarz 1978) names it; a second is added if it lowers BIC further.  Nothing below the
    base model: unexplained.  Causes that only add variance (waves, outliers, jitter) are outside an output-error fit.
    """

    name = "residual-bic"
    title = "naive: free-run output error, whiteness test, BIC over the bank"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """Fit every cause to the free runs and name the one of lowest BIC."""
        from .diagnose import prepared
        from .free_run import FreeRuns

        clock = time.perf_counter(), time.process_time()
        options = options.checked(model)
        train, held_out = prepared(train, model, options), prepared(held_out, model, options)
        runs = FreeRuns(model, train)
        base = runs.base()
        p = whiteness(base, runs)
        chosen = [] if p > options.alpha else select(runs, base, options.only)
        verdict = "named" if chosen else "adequate" if p > options.alpha else "unexplained"
        reason = f"free-run residuals are {'' if p > options.alpha else 'not '}white (p = {p:.2g})"
        return conclude(runs, held_out, chosen, verdict, reason, options, clock)


def whiteness(fit: Fit, runs: FreeRuns) -> float:
    """Smallest p-value of the Ljung-Box tests of all channels and records, times their number."""
    from scipy.stats import chi2

    found = []
    for a, b in zip(runs.est.edges[:-1], runs.est.edges[1:], strict=True):
        for series in fit.residuals[a:b].T:
            known = series[~np.isnan(series)]
            if known.size > 5 * LAGS:
                found.append(float(chi2.sf(ljung_box(known), LAGS)))
    return min(1.0, min(found, default=1.0) * max(len(found), 1))


def ljung_box(series: np.ndarray) -> float:
    """Ljung-Box statistic of a series (n,), LAGS lags, about zero: free runs that are off are not white either."""
    n, power = series.size, float(series @ series)
    if not 0.0 < power < np.inf:
        return np.inf
    r = np.array([series[k:] @ series[:-k] for k in range(1, LAGS + 1)]) / power
    return float(n * (n + 2.0) * np.sum(r**2 / (n - np.arange(1, LAGS + 1))))


def select(runs: FreeRuns, base: Fit, only: Sequence[str] | None) -> list[tuple[str, Variant, Fit]]:
    """Causes added while BIC falls: the best of all that can be fitted, at most MOST."""
    from .attempts import ATTEMPTS
    from .causes import CAUSES, testable

    bank, _ = testable(runs.est)
    names = [name for name in bank if (not only or name in only) and name not in ATTEMPTS]
    chosen: list[tuple[str, Variant, Fit]] = []
    now, charged = base, 0
    for _ in range(MOST):
        rest = [name for name in names if name not in {c for c, _, _ in chosen}]
        fits = [(name, *fit_cause(runs, now, CAUSES[name], bank[name])) for name in rest]
        best = min(fits, key=lambda item: item[2].criterion(), default=None)
        if best is None or not best[2].criterion() < now.criterion() - charged:
            break
        charged = len(best[2].columns) * np.log(np.isfinite(best[2].residuals).sum())
        now = best[2]
        chosen.append(best)
    return chosen


def fit_cause(runs: FreeRuns, before: Fit, entry: Cause, variants: Sequence[Variant]) -> tuple[Variant, Fit]:
    """The variant with the largest linear gain, fitted from the best of the cause's starts."""
    from .causes import starts

    if entry.id == "rudder_fault":
        return _fit_fault(runs, before)
    weight = 1.0 / _rms(before)
    gains = [_linear_gain(runs.columns(before.setting, v, before.residuals), before, weight) - len(v) for v in variants]
    variant = variants[int(np.argmax(gains))]
    trials = starts(runs.est, before.setting, entry, variant)
    start = min(trials, key=lambda s: _cost(runs, s, weight)) if len(trials) > 1 else None
    return variant, runs.fit(before, variant, start)


def _fit_fault(runs: FreeRuns, before: Fit) -> tuple[Variant, Fit]:
    """A loss of effectiveness from the best of a few times on."""
    from .causes import fault_variant

    e, t0 = fault_variant(runs.est, None)
    times = np.linspace(0.0, float(runs.est.data[0].time[-1]), FAULT_TIMES + 2)[1:-1]
    fits = [runs.fit(before, (e,), runs.est.at(before.setting, t0, float(t)), 1) for t in times]
    best = min(fits, key=lambda fit: fit.criterion())
    return (e, t0), runs.fit(before, (e, t0), best.setting)


def _linear_gain(columns: np.ndarray, before: Fit, weight: np.ndarray) -> float:
    """Fall of half the weighted sum of squares that a linear fit of the columns would bring."""
    weights = np.tile(weight, len(before.residuals))
    target = np.where(np.isfinite(before.residuals), before.residuals, 0.0).ravel() * weights
    basis = np.linalg.qr((columns * weights).T + 1e-300)[0]
    return 0.5 * float(np.sum((basis.T @ target) ** 2))


def _rms(fit: Fit) -> np.ndarray:
    from .free_run import rms

    return rms(fit.residuals)


def _cost(runs: FreeRuns, s: Setting, weight: np.ndarray) -> float:
    from .free_run import cost

    return cost(runs.residuals(s), weight)


def findings(
    runs: FreeRuns, chosen: Sequence[tuple[str, Variant, Fit]], before: Fit, rng: np.random.Generator
) -> list[Finding]:
    """Chosen causes with their sizes; intervals as if the residuals were independent."""
    from .result import Finding
    from .sizes import sizes_of

    out = []
    for name, variant, fit in chosen:
        gained = before.criterion() - fit.criterion()
        scaled = fit.columns * np.tile(1.0 / _rms(fit), len(fit.residuals))
        sizes = sizes_of(runs.est, fit.setting, name, variant, np.linalg.pinv(scaled @ scaled.T), rng)
        out.append(Finding(name, (), "dynamics", gained, float("nan"), sizes, evidence=f"BIC falls by {gained:.4g}"))
        before = fit
    return out


def conclude(
    runs: FreeRuns,
    held_out: Sequence[Record],
    chosen: Sequence[tuple[str, Variant, Fit]],
    verdict: str,
    reason: str,
    options: Options,
    clock: tuple[float, float],
) -> Diagnosis:
    """The diagnosis that names the chosen causes, with the gain on the held-out records."""
    from .causes import CAUSES
    from .extend import extended_model
    from .result import Diagnosis, Entry

    rng, est, names = np.random.default_rng(options.seed), runs.est, [name for name, _, _ in chosen]
    setting = chosen[-1][2].setting if chosen else runs.start
    bank = [Entry(name, "named" if name in names else "not_significant", None, None, None, "") for name in CAUSES]
    roles = [*((d.name, "train") for d in est.data), *((record.name, "held_out") for record in held_out)]
    return Diagnosis(
        model=est.model, extended=extended_model(est, setting, names, []), base_parameters="file",
        records=tuple(roles), alpha=options.alpha, seed=options.seed, verdict=verdict, reason=reason,
        causes=tuple(findings(runs, chosen, runs.base(), rng)), bank=tuple(bank),
        gain=_gains(runs, held_out, setting, tuple(p for _, v, _ in chosen for p in v), rng),
        hypothesis=None, noise={}, traces=(), where=(), next_manoeuvre=None,
        wall_s=time.perf_counter() - clock[0], cpu_s=time.process_time() - clock[1],
    )  # fmt: skip


def _gains(
    runs: FreeRuns, records: Sequence[Record], s: Setting, variant: Variant, rng: np.random.Generator
) -> dict[str, Gain]:
    """As the diagnosis proper measures it: what belongs to a record is estimated on its first part."""
    from ..methods.innovations.estimator import Estimator
    from . import gain

    held = Estimator(runs.est.model, records, runs.est.unit)
    own = [p for p in variant if p.record is not None]
    after = gain.adapted(held, gain.transferred(held, s, own), tuple(own))
    old, new = gain.free_runs(held, gain.transferred(held, runs.start, ())), gain.free_runs(held, after)
    return gain.gains(held, old, new, gain.scored_from(held, bool(own)), runs.start.noise, rng)
