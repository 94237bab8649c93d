"""Standard errors by simulation: the fit is repeated with more sensor noise.

For fits whose equation errors are correlated over the whole record.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....datasets.signals import sensor_sd
from ....models.errors import CannotFit, FitFailed

if TYPE_CHECKING:
    from ....datasets.record import Record

DRAWS, SEED = 48, 48
"""Repetitions (a standard error is then uncertain by a tenth), and the seed of their noise."""


def replayed_covariance(
    records: Sequence[Record], fit: Callable[[Sequence[Record]], np.ndarray], draws: int = DRAWS, seed: int = SEED
) -> np.ndarray:
    """Covariance (p, p) of the coefficients (p,) that `fit` gives for records with added sensor noise.

    Each draw adds white noise to every channel, with the standard deviation of its sensor as estimated from third
    differences.  Integrated equations colour the noise, so the covariance of least squares for independent errors
    would be several times too small.  To first order in the noise the result is exact.

    Raises
    ------
    FitFailed : the repetitions give no finite coefficients.
    """
    rng = np.random.default_rng(seed)
    spreads = [{name: sensor_sd(values) for name, values in record.channels.items()} for record in records]
    found = []
    for _ in range(draws):
        noisier = [_noisier(record, sd, rng) for record, sd in zip(records, spreads, strict=True)]
        try:
            found.append(fit(noisier))
        except (CannotFit, FitFailed):
            continue
    found = [c for c in found if np.isfinite(c).all()]
    if len(found) < 2:
        raise FitFailed("the fit fails on records with added sensor noise: no standard errors")
    return np.atleast_2d(np.cov(np.array(found).T))


def _noisier(record: Record, sd: dict[str, float], rng: np.random.Generator) -> Record:
    noise = {name: s * rng.standard_normal(record.n) for name, s in sd.items() if np.isfinite(s)}
    return record.with_channels(**{name: record.channels[name] + values for name, values in noise.items()})
