"""A setting of the filter as a model like any other: the base model with the accepted causes built in, and what belongs
to a held-out record (its current, its wind), estimated on the record's first part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.diagnosis_only.refit import gauss_newton
from ...estimation.filters.innovations.estimator import estimator
from ...estimation.filters.innovations.settings import Parameter, Setting
from ...estimation.filters.innovations.vector import OUTER
from ...models import kernels as kernel_store
from ...models.families.extensions import extension_of
from ...models.instruments import INSTRUMENTS, WAVES, combined
from ...models.model import Model
from .state import Unmodelled

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..causes.base import Cause
    from .state import State


def extended_model(
    est: Estimator, s: Setting, causes: Sequence[Cause], instruments: Mapping[str, float] | None = None
) -> Model:
    """The model at a setting with the causes as extensions of its family, else as instruments.

    A quantity per record enters as its mean over the training records.  instruments : what was corrected in the
    records before the filter saw them.
    """
    model = est.model
    row = np.where(np.all(s.vectors == s.vectors[0], axis=0), s.vectors[0], s.vectors.mean(axis=0))
    family, values, taken = model.family, list(row[: len(model.coordinates)]), set()
    for cause in causes:
        if cause.extension is None or not kernel_store.carries(family, cause.extension):
            continue
        family = f"{family}+{cause.extension}"
        names = extension_of(cause.extension).units
        values += [row[est.index[name]] for name in names]
        taken |= set(names)
    extended = replace(model, id=_named(model, causes), family=family, coefficients=np.array(values, float))
    numbers = {**_instruments(est, row, taken), **(instruments or {})}
    return replace(extended, constants=_constants(extended, est, row), instruments=combined(model.instruments, numbers))


def _named(model: Model, causes: Sequence[Cause]) -> str:
    return "+".join([model.id.partition("+")[0], *(cause.id for cause in causes)])


def _constants(extended: Model, est: Estimator, row: np.ndarray) -> np.ndarray:
    """Constants of the extended family: the model's at the setting, and those that its terms brought along."""
    known = {name: row[i] for name, i in est.index.items() if name not in OUTER}
    names = kernel_store.load(extended.family).CONSTANTS
    return np.array([known[name] for name in names], float)


def _instruments(est: Estimator, row: np.ndarray, taken: set[str]) -> dict[str, float]:
    """Numbers of rudder, sensors and waves that differ from the ideal and are not in the equations."""
    waves = row[est.index["wave_rms"]] > 0.0
    out = {}
    for name in OUTER:
        i = est.index[name]
        if name in INSTRUMENTS and name not in taken and (row[i] != est.base[i] or (waves and name in WAVES)):
            out[name] = float(row[i])
    return out


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
