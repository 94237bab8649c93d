"""Where the base model leaves effects unexplained: its own numbers, by free runs of records that were left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..estimation.results.fit import arithmetic_guard
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.extend import extended
from ..models.families.extensions import extension_of
from ..models.instruments import combined
from .calibration.advice import CANDIDATES
from .calibration.calibrate import calibrate_on, causes_of
from .causes.base_coefficients import BaseCoefficients
from .causes.registry import bank
from .gain.guard import WORSE
from .report.bank import demoted, updated
from .report.findings import BY_RESIDUALS, of_groups

if TYPE_CHECKING:
    from ..models.model import Model
    from .calibration.result import Calibration
    from .discrepancy.regimes import Local
    from .discrepancy.subsets import Subset
    from .prepared import Prepared
    from .result import Diagnosis, Finding

SHOWN_ALREADY = "fits the residuals of the base model as it is, whose own numbers explain its free runs"


def by_free_runs(
    found: Diagnosis,
    given: Prepared,
    felt: Prepared,
    subsets: Sequence[Subset] = (),
    regimes: Sequence[Local] = (),
    identified: bool = False,
) -> Diagnosis:
    """The diagnosis with the smallest set of the base model's numbers, or of terms that it lacks, that predicts records
    which were left out; as it was where no set does, or where the family states no groups.

    given : records behind the sensors.  felt : also without what the named causes explain.
    subsets, regimes : the best small sets of numbers, and numbers in a regime, by the likelihood.
    identified : the model's numbers come from these records.
    """
    told = {f.cause for f in found.causes}
    short = found.verdict == "unexplained"  # else the likelihood has decided, and sees more than short pieces show
    try:
        with arithmetic_guard():
            base = calibrate_on(found.model, given, felt, identified, found.threads, told, subsets, regimes, short)
    except CannotFit as error:
        return replace(found, reason=f"{found.reason}; {error}") if short else found
    except (BadInput, FitFailed):
        return found
    if not base.moved or base.verdict == "unexplained" or _worse(base):
        return replace(found, calibration=base, calibrated=_for_predictions(base, base.model, ()))
    # What describes the hull beside the numbers gives way to the numbers that free runs name.
    described = (f for f in found.causes if BaseCoefficients.id not in (f.cause, *f.tied_with))
    before = [f for f in described if f.stage != BY_RESIDUALS]
    regime = base.regime
    if regime is not None:  # it was a part of what is wrong in the regime only
        before = [f for f in before if f.cause != causes_of(found.model).get(regime.group)]
    before += [f for f in given.shown.findings if f.cause not in {b.cause for b in before}]
    named = {f.cause for f in before}
    if found.base_parameters == "identify":  # the records have decided on the model's own numbers already
        named |= {BaseCoefficients.id}
    causes = (*before, *(f for f in _findings(base) if f.cause not in named))
    known = combined(base.extended.instruments, given.instruments)
    explained = found.extended if felt is not given else replace(found.model, instruments=known)
    return replace(
        found,
        extended=_with_causes(base.extended, explained, before),
        calibrated=_for_predictions(base, explained, before),
        verdict=base.verdict,
        reason=base.reason,
        causes=causes,
        bank=updated(demoted(found.bank, ("named", "tied"), "explained_by", SHOWN_ALREADY), causes),
        traces=base.traces,
        of_held_out=found.of_held_out if felt is not given else {},
        next_manoeuvre=", ".join(CANDIDATES[run.manoeuvre] for run in base.next_runs),
        calibration=base,
    )


def _for_predictions(base: Calibration, explained: Model, causes: Sequence[Finding]) -> Model | None:
    """The model for predictions; None where no number has moved."""
    if np.array_equal(base.calibrated.theta, base.model.theta):
        return None
    return _with_causes(base.calibrated, explained, causes)


def _with_causes(moved: Model, explained: Model, causes: Sequence[Finding]) -> Model:
    """The model with the numbers that moved, and with what an extended model holds of causes beside them."""
    ids = {f.cause for f in causes}
    wanted = {c.extension for c in bank() if c.id in ids and c.extension is not None}
    out, values = replace(moved, instruments=explained.instruments), explained.parameters
    for name in explained.family.split("+"):
        if name in wanted and name not in out.family.split("+"):
            out = extended(out, name, {n: values[n] for n in extension_of(name).units})
    return out


def _worse(base: Calibration) -> bool:
    """Whether training records that were left out are predicted worse in some channel."""
    pairs = ((base.before[c][0], new) for c, (new, _) in base.after.items())
    return any(new > WORSE * old for old, new in pairs)


def _findings(base: Calibration) -> list[Finding]:
    """One finding for each group that is a cause of the bank, one for all others; none of groups whose numbers may all
    stay where they were."""
    changed = {m.group for m in base.moved if not m.may_have_stayed}
    everywhere = changed - ({base.regime.group} if base.regime is not None else set())
    causes = {group: cause for group, cause in causes_of(base.model).items() if group in everywhere}
    still = {m.group for m in base.moved} - changed
    groups = list(dict.fromkeys(step.group for step in base.steps))
    groups = [group for group in groups if group not in still] or groups
    own = [of_groups(base, causes[group], {group}) for group in groups if group in causes]
    rest = set(groups) - set(causes)
    return [*([of_groups(base, BaseCoefficients.id, rest)] if rest else []), *own]


def refused_by_free_runs(found: Diagnosis) -> frozenset[str]:
    """Causes that free runs of left-out records could have named, and did not, or had too few records for."""
    named = {f.cause for f in _findings(found.calibration)} if found.calibration is not None else set()
    return frozenset(causes_of(found.model).values()) - named
