"""The extended model: the base model with the accepted causes built in, as a model like any other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.vector import OUTER
from ...models import kernels as kernel_store
from ...models.families.extensions import extension_of
from ...models.instruments import INSTRUMENTS, WAVES, combined
from ...models.model import Model

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..causes.base import Cause


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
