"""Standard errors of methods whose errors are correlated over the whole record: the fit is repeated with more noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .base import CannotFit, FitFailed
from .series import sensor_sd

if TYPE_CHECKING:
    from ..datasets.record import Record

DRAWS, SEED = 48, 48
"""Repetitions, which leave a standard error uncertain by a tenth, and the seed of their noise."""


def replayed_covariance(
    records: Sequence[Record], fit: Callable[[Sequence[Record]], np.ndarray], draws: int = DRAWS, seed: int = SEED
) -> np.ndarray:
    """Covariance (p, p) of the coefficients that `fit` gives when every channel is noisier by its own sensor's noise.

    White noise of each channel's standard deviation, read off its third differences, is added to the records anew in
    each draw.  Noise that the equations integrate is coloured by them: what least squares states about rows with
    independent errors would be several times too small.  To first order in the noise the result is exact.

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
        raise FitFailed("the fit cannot be repeated with more noise")
    return np.atleast_2d(np.cov(np.array(found).T))


def _noisier(record: Record, sd: dict[str, float], rng: np.random.Generator) -> Record:
    noise = {name: s * rng.standard_normal(record.n) for name, s in sd.items() if np.isfinite(s)}
    return record.with_channels(**{name: record.channels[name] + values for name, values in noise.items()})
