"""What the diagnosers of free runs share: the runs, and the diagnosis in the form of the project's own."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.filters.innovations.estimator import estimator
from ...models.linear_algebra import pinv
from ..causes.base import Cause
from ..causes.registry import causes, testable
from ..gain.runs import with_runs
from ..innovations.as_model import adapted, extended_model, of_held_out, transferred
from ..prepared import prepared
from ..registry import Diagnoser
from ..report.verdict import diagnosis_of
from ..result import Entry, Finding
from .output_error import FilterRuns, RunFit, rms

if TYPE_CHECKING:
    from ...checks.base import Check
    from ...datasets.record import Record
    from ...estimation.filters.innovations.settings import Parameter, Setting
    from ...models.model import Model
    from ..innovations.state import Variant
    from ..options import Options
    from ..result import Diagnosis


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
