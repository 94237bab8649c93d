"""What the naive diagnosers share: free runs of the base model with any effect of the bank, fitted by output error, and
the diagnosis in the form of the project's own.
"""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.filters.innovations.estimator import estimator
from ...models.linear_algebra import lstsq, pinv
from ..causes.base import Cause
from ..causes.registry import causes, testable
from ..gain.runs import with_runs
from ..innovations.as_model import adapted, extended_model, of_held_out, transferred
from ..prepared import prepared
from ..registry import Diagnoser
from ..report.verdict import diagnosis_of
from ..result import Entry, Finding

if TYPE_CHECKING:
    from ...checks.base import Check
    from ...datasets.record import Record
    from ...estimation.filters.innovations.settings import Parameter, Setting
    from ...models.model import Model
    from ..innovations.state import Variant
    from ..options import Options
    from ..result import Diagnosis


START_S = 10.0
"""Time (s, of a 160 m ship) that a free run starts after."""
LIMIT = 1e6
"""Residual, in sensor standard deviations, above which a run counts as diverged."""


@dataclass(frozen=True)
class RunFit:
    """Parameters fitted by output error: setting, residuals (N, 6), one row of `columns` (k, N*6) a parameter."""

    setting: Setting
    residuals: np.ndarray
    columns: np.ndarray

    def criterion(self) -> float:
        """Sum over channels of n log(mean square) + k log n, of independent normal residuals (BIC)."""
        known = np.isfinite(self.residuals)
        count = known.sum(axis=0)
        square = np.where(known, self.residuals, 0.0) ** 2
        used = count > 0
        likelihood = np.sum(count[used] * np.log(square.sum(axis=0)[used] / count[used] + 1e-300))
        return float(likelihood + len(self.columns) * np.log(count.sum()))


class FilterRuns:
    """Free runs of all records from their filtered states after START_S, residuals in sensor standard deviations."""

    def __init__(self, model: Model, records: Sequence[Record]) -> None:
        self.est = estimator(model, records)
        self.start = self.est.start()
        starts = [min(START_S * self.est.clock, 0.2 * d.time[-1]) for d in self.est.segments]
        self.free = [max(int(np.searchsorted(d.time, t)), 2) for d, t in zip(self.est.segments, starts, strict=True)]

    def residuals(self, s: Setting) -> np.ndarray:
        """Measured less free run (N, 6); nan at gaps and before it is free, inf where it diverged."""
        return np.vstack([self._residuals(s, i) for i in range(len(self.free))])

    def _residuals(self, s: Setting, i: int) -> np.ndarray:
        measured = self.est.segments[i].measured
        error = measured - self.est.free_run(s, i, self.free[i])
        error[:, 0] = (error[:, 0] + np.pi) % (2.0 * np.pi) - np.pi
        error /= s.noise.sensor_sd
        error[np.isfinite(measured) & ~(np.abs(error) < LIMIT)] = np.inf
        error[: self.free[i]] = np.nan
        error[:, ~self.est.channels] = np.nan
        return error

    def base(self) -> RunFit:
        """The base model without effects."""
        return RunFit(self.start, self.residuals(self.start), np.zeros((0, 0)))

    def columns(self, s: Setting, parameters: Sequence[Parameter], now: np.ndarray) -> np.ndarray:
        """Derivatives (k, N*6) of the residuals by finite differences, nothing at gaps."""
        out = []
        for p in parameters:
            step = p.scale if self.est.value(s, p) + p.scale <= p.high else -p.scale
            moved = self.residuals(self.est.moved(s, p, step))
            out.append(np.nan_to_num((moved - now) / step, nan=0.0, posinf=0.0, neginf=0.0).ravel())
        return np.array(out).reshape(len(out), now.size)

    def fit(self, before: RunFit, variant: Variant, start: Setting | None = None, most: int = 4) -> RunFit:
        """Gauss-Newton steps on the parameters of a variant, weighted by the channels' errors before them."""
        weight = 1.0 / rms(before.residuals)
        s = start or before.setting
        now = self.residuals(s)
        columns = self.columns(s, variant, now)
        for _ in range(most):
            change = _step(columns, now, weight)
            s, there = self._best_along(s, variant, change, now, weight)
            gained, now = cost(now, weight) - cost(there, weight), there
            columns = self.columns(s, variant, now)
            if not gained > 0.1:
                break
        return RunFit(s, now, columns)

    def _best_along(self, s: Setting, variant: Variant, change: np.ndarray, now: np.ndarray, weight: np.ndarray):
        for power in range(5):
            trial = s
            for p, step in zip(variant, change * 0.5**power, strict=True):
                trial = self.est.at(trial, p, self.est.value(trial, p) + float(step))
            there = self.residuals(trial)
            if cost(there, weight) < cost(now, weight):
                return trial, there
        return s, now


def rms(residuals: np.ndarray) -> np.ndarray:
    """(6,) root mean square per channel, 1 where nothing is measured or a run diverged."""
    known = np.isfinite(residuals)
    square = np.where(known, residuals, 0.0) ** 2
    mean = square.sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return np.where(mean > 0.0, np.sqrt(mean), 1.0)


def cost(residuals: np.ndarray, weight: np.ndarray) -> float:
    """Half the weighted sum of squares; infinite where a run diverged."""
    return 0.5 * float(np.nansum((residuals * weight) ** 2))


def _step(columns: np.ndarray, residuals: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Least-squares change (k,) of the parameters."""
    weights = np.tile(weight, len(residuals))
    target = -np.where(np.isfinite(residuals), residuals, 0.0).ravel() * weights
    matrix = (columns * weights).T
    size = np.linalg.norm(matrix, axis=0) + 1e-300
    return lstsq(matrix / size, target, rcond=1e-8) / size


class Chosen(NamedTuple):
    """A cause with the variant that was fitted."""

    cause: Cause
    variant: Variant
    fit: RunFit


class OfFreeRuns(Diagnoser):
    """Base class of diagnosers that choose causes by the free runs of the training records."""

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """Choose causes by the free runs of the training records, and measure the gain on the held-out ones."""
        clock = time.perf_counter(), time.process_time()
        options = options.checked(model)
        own, others = prepared(train, model, options), prepared(held_out, model, options)
        runs = FilterRuns(model, own)
        chosen, verdict, reason = self.choose(runs, model, own, options)
        diagnosis = conclude(runs, others, chosen, verdict, reason, options)
        diagnosis = replace(with_runs(diagnosis, (), (), held_out, options.channels), traces=())
        return replace(diagnosis, wall_s=time.perf_counter() - clock[0], cpu_s=time.process_time() - clock[1])

    @abstractmethod
    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """Causes with their fits, verdict and reason; train : the records of the runs, as they were prepared."""


def fittable(runs: FilterRuns, only: Collection[Check] | None) -> dict[Cause, Sequence[Variant]]:
    """Causes that an output-error fit can size, with their variants; only : of these (None: all)."""
    bank, _ = testable(runs.est)
    return {c: v for c, v in bank.items() if (not only or c in only) and v[0]}


def conclude(
    runs: FilterRuns,
    held_out: Sequence[Record],
    chosen: Sequence[Chosen],
    verdict: str,
    reason: str,
    options: Options,
) -> Diagnosis:
    """The diagnosis that names the chosen causes, without its gain."""
    rng, est, names = np.random.default_rng(options.seed), runs.est, [c.cause for c in chosen]
    setting = chosen[-1].fit.setting if chosen else runs.start
    bank = [Entry(c.id, "named" if c in names else "not_significant", None, None, None, "") for c in causes().values()]
    roles = [*((name, "train") for name in est.record_names), *((record.name, "held_out") for record in held_out)]
    diagnosis = diagnosis_of(
        (est.model, extended_model(est, setting, names)),
        replace(options, base_parameters="file"),
        (verdict, reason),
        findings(runs, chosen, rng),
        bank,
        noise={},
    )
    own = [p for c in chosen for p in c.variant if p.record is not None]
    return replace(diagnosis, records=tuple(roles), of_held_out=_of_held_out(runs, held_out, setting, own))


def findings(runs: FilterRuns, chosen: Sequence[Chosen], rng: np.random.Generator) -> list[Finding]:
    """Chosen causes with their sizes; intervals as if the residuals were independent."""
    out, before = [], runs.base()
    for cause, variant, fit in chosen:
        gained = before.criterion() - fit.criterion()
        scaled = fit.columns * np.tile(1.0 / rms(fit.residuals), len(fit.residuals))
        sizes = cause.sizes(runs.est, fit.setting, variant, pinv(scaled @ scaled.T), rng)
        said = f"BIC falls by {gained:.4g}"
        out.append(Finding(cause.id, (), "dynamics", gained, float("nan"), sizes, evidence=said))
        before = fit
    return out


def _of_held_out(
    runs: FilterRuns, records: Sequence[Record], s: Setting, own: Sequence[Parameter]
) -> dict[str, dict[str, float]]:
    """As the diagnosis proper has it: what belongs to a record is estimated on its first part."""
    if not (records and own):
        return {}
    held = replace(estimator(runs.est.model, records, runs.est.unit), base=runs.est.base)
    return of_held_out(held, adapted(held, transferred(held, s, own), own), own)
