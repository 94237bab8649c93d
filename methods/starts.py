"""Starting values for methods that iterate: least squares in several forms, never the truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .base import CannotFit, FitFailed
from .ls import LeastSquares, fit_ls
from .series import averaged

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

AVERAGES = (None, 200, 60)
"""Samples to which records are averaged before they are differenced; None: as they are."""


class Start(NamedTuple):
    """Coefficients (p,) to start from, and the least-squares solution they come from."""

    coefficients: np.ndarray
    source: LeastSquares


def starts_of(records: Sequence[Record], model: Model) -> list[Start]:
    """Starts by central differences, of the records and of their averages, and by forward differences.

    Those by central differences come twice: whole, and along the directions only that stand out of the noise, without
    which a start from noisy records can be wild where they say little.

    Raises
    ------
    CannotFit : if no scheme gives finite coefficients.
    """
    found: list[Start] = []
    reason = ""
    for samples, scheme in [*((n, "midpoint") for n in AVERAGES), (None, "forward")]:
        data = list(records) if samples is None else [averaged(record, samples) for record in records]
        if found and samples is not None and all(a is b for a, b in zip(data, records, strict=True)):
            continue
        try:
            solution = fit_ls(data, model, scheme)
        except (CannotFit, FitFailed) as error:
            reason = reason or error.reason
            continue
        found.append(Start(solution.coefficients, solution))
        if scheme == "midpoint":
            found.append(Start(solution.significant(), solution))
    found = [start for start in found if np.isfinite(start.coefficients).all()]
    if not found:
        raise CannotFit(reason or "least squares gives no finite start")
    return found
