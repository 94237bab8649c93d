"""Scores of what a diagnosis says beside names: where an effect acts, and how far it moves numbers that are right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ....datasets.record import Record
from ....diagnosis.result import Diagnosis
from ....models.coefficient_groups import stated_groups, values_of
from ....models.model import Model
from .names import Said

if TYPE_CHECKING:
    from ...faults import Injected
    from ...faults.regimes import TrueRegime


def regime_scores(diagnosis: Diagnosis, case: Injected) -> dict[str, Any]:
    """Columns of the regime of a case: the true one, those stated in `details["regime"]`, and their F1.

    F1 is over the samples of all training records: truly in the regime against said to be in any of those stated, both
    by the true motion.  It is 0 without a stated regime, empty without a true one.
    """
    stated = stated_regimes(diagnosis)
    true = [e.kind.regime(e.at(0), case.case.ship) for e in case.effects if e.kind.regime]
    return {
        "regime_true": "+".join(map(str, true)),
        "regime_named": "+".join(map(str, stated)),
        "regime_f1": localisation(true, stated, case.true_motion()) if true else None,
    }


def stated_regimes(diagnosis: Said) -> list[TrueRegime]:
    """The regimes that the findings of a diagnosis state."""
    from ...faults.regimes import TrueRegime

    details = [finding.details.get("regime") for finding in diagnosis.causes]
    return list(dict.fromkeys(TrueRegime.of(one) for one in details if isinstance(one, dict)))


def localisation(true: Sequence[TrueRegime], stated: Sequence[TrueRegime], runs: Sequence[Record]) -> float | None:
    """F1 of samples of records of the true motion in any of the regimes; None where the true one never occurs."""
    from ...faults.regimes import f1

    truly, said = (
        np.concatenate(
            [np.any([one.inside(run) for one in some], axis=0) if some else np.zeros(run.n, bool) for run in runs]
        )
        for some in (true, stated)
    )
    return f1(truly, said) if truly.any() else None


def healthy_bias(diagnosis: Diagnosis, true: Model, wrong: frozenset[str]) -> float | None:
    """Root mean square error of the extended model's numbers that are right in the base model, in prior standard
    deviations.

    true : the model of the ship; wrong : numbers, and groups of numbers, that are left out.  None where the family
    states no priors.
    """
    now, then = values_of(diagnosis.extended), values_of(true)
    groups = [g for g in stated_groups(true) if g.extension is None and g.id not in wrong]
    own = {name: sd for g in groups for name, sd in g.sd.items() if name not in wrong}
    errors = [(now[name] - then[name]) / sd for name, sd in own.items() if name in now]
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None
