"""What belongs to a held-out record (its current, its wind): estimated by the filter on the record's first part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.diagnosis_only.refit import gauss_newton
from ...estimation.filters.innovations.estimator import estimator
from ...estimation.filters.innovations.settings import Parameter, Setting
from ..candidate import Unmodelled

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ..state import State

FIRST_PART = 0.3
"""Share of a held-out record on which its own quantities are estimated."""
STEPS, ENOUGH = 6, 0.05
"""Most Gauss-Newton steps, and the gain in log likelihood that ends them."""


def of_state(state: State, records: Sequence[Record]) -> dict[str, dict[str, float]]:
    """As `of_held_out`, of the accepted causes; nothing without records."""
    lasting = [a for a in state.accepted if not isinstance(a.cause, Unmodelled) and a.cause.search.steady]
    steady = [p for a in lasting for p in a.variant if p.record is not None]
    if not (records and steady):
        return {}
    est, of_record = state.est, [p for a in state.accepted for p in a.variant if p.record is not None]
    held = estimator(est.model, records, est.unit, est.threads, est.terms)
    held = replace(held, rudder_sd=est.rudder_sd, base=est.base)
    return of_held_out(held, adapted(held, transferred(held, state.setting, of_record), steady), steady)


def of_held_out(held: Estimator, s: Setting, steady: Sequence[Parameter]) -> dict[str, dict[str, float]]:
    """Name of a held-out record -> what belongs to it (current, wind), as coefficients of the extended model.

    held, s : the records under the filter, and the setting there.  steady : the parameters of a record.
    """
    entries = {entry for p in steady for entry, _ in p.slots}
    names = {name: entry for name, entry in held.index.items() if entry in entries}
    return {
        record: {name: float(s.vectors[held.rows(i)[0], entry]) for name, entry in names.items()}
        for i, record in enumerate(held.record_names if names else ())
    }


def transferred(held: Estimator, s: Setting, of_record: Sequence[Parameter]) -> Setting:
    """A training setting on the held-out records: shared parameters as they are, those of a record at zero."""
    row = s.vectors[0].copy()
    for p in of_record:
        for entry, _ in p.slots:
            row[entry] = held.base[entry]
    return Setting(np.tile(row, (len(held.segments), 1)), s.noise)


def adapted(held: Estimator, s: Setting, variant: Sequence[Parameter]) -> Setting:
    """Parameters of single records estimated on the first part of each held-out record."""
    if not variant:
        return s
    early = held.first(FIRST_PART)
    kinds = {(p.name, p.slots): p for p in variant}
    own = [replace(p, record=i) for i in range(held.n_records) for p in kinds.values()]
    setting, now = s, early.evaluate(s)
    for _ in range(STEPS):
        before = now.log_likelihood
        setting, now = gauss_newton(early, setting, now, own)
        if now.log_likelihood - before < ENOUGH:
            break
    return replace(setting, noise=s.noise)
