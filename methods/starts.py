"""Starting values for methods that iterate: least squares in several forms, never the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .base import CannotFit, FitFailed
from .ls import LeastSquares, fit_ls
from .series import averaged
from .svf_ls import corner_frequencies, fit_filtered

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

AVERAGES = (200, 60)
"""Samples to which records are averaged before they are differenced."""
CORNERS = 4
"""Corner frequencies that the state-variable filter's are spread over; the fastest is left out."""


class Start(NamedTuple):
    """Coefficients (p,) to start from, and the least-squares solution they come from."""

    coefficients: np.ndarray
    source: LeastSquares


def starts_of(records: Sequence[Record], model: Model) -> list[Start]:
    """Starts by central differences, of the records and of their averages, by forward differences and by a filter.

    Those by central differences come twice: whole, and along the directions only that stand out of the noise, without
    which a start from noisy records can be wild where they say little.  The state-variable filter's stand where
    differences lose everything: a noisy heading alone, of which a response model needs the third derivative.

    Raises
    ------
    CannotFit : if no scheme gives finite coefficients.
    """
    found: list[Start] = []
    reason = ""
    for attempt in _attempts(records, model):
        try:
            solution, twice = attempt()
        except (CannotFit, FitFailed) as error:
            reason = reason or error.reason
            continue
        found.append(Start(solution.coefficients, solution))
        if twice:
            found.append(Start(solution.significant(), solution))
    found = [start for start in found if np.isfinite(start.coefficients).all()]
    if not found:
        raise CannotFit(reason or "least squares gives no finite start")
    return found


def _attempts(records: Sequence[Record], model: Model) -> Iterator[Callable[[], tuple[LeastSquares, bool]]]:
    """Least squares in each form, and whether its significant directions alone are a start too."""
    yield lambda: (fit_ls(records, model, "midpoint"), True)
    for samples in AVERAGES:
        data = [averaged(record, samples) for record in records]
        if any(a is not b for a, b in zip(data, records, strict=True)):
            yield partial(_averaged, data, model)
    yield lambda: (fit_ls(records, model, "forward"), False)
    for omega in corner_frequencies(records, CORNERS)[:-1]:
        yield partial(_filtered, records, model, float(omega))


def _averaged(data: Sequence[Record], model: Model) -> tuple[LeastSquares, bool]:
    return fit_ls(data, model, "midpoint"), True


def _filtered(records: Sequence[Record], model: Model, omega: float) -> tuple[LeastSquares, bool]:
    return fit_filtered(records, model, omega)[1], False
