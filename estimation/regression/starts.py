"""Starting values for iterative methods: least squares in several forms, never the true coefficients."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit, FitFailed
from ...models.model import Model
from ..records.series import averaged
from .filtered import corner_frequencies, fit_filtered
from .least_squares import LeastSquares, fit_by_scheme

AVERAGES = (200, 60)
"""Samples to which records are averaged before they are differenced."""
CORNERS = 4
"""Corner frequencies of the state-variable filter, of which the fastest is left out."""


class Start(NamedTuple):
    """Coefficients (p,) to start from, and the least-squares solution that they come from."""

    coefficients: np.ndarray
    source: LeastSquares


def starts_of(records: Sequence[Record], model: Model) -> list[Start]:
    """Starts by central differences (of the records and of their averages), by forward differences and by a filter.

    Central differences give two starts each: the full solution, and the solution along its significant directions
    only.  The full one can be far off in directions about which noisy records have little information.  The
    state-variable filter is for records whose differences are nothing but noise: a response model needs the third
    derivative of a noisy heading where only the heading is measured.

    Raises
    ------
    CannotFit : no form gives finite coefficients.
    """
    found: list[Start] = []
    reason = ""
    for fit, with_significant in _forms(records, model):
        try:
            solution = fit()
        except (CannotFit, FitFailed) as error:
            reason = reason or error.reason
            continue
        found.append(Start(solution.coefficients, solution))
        if with_significant:
            found.append(Start(solution.significant(), solution))
    found = [start for start in found if np.isfinite(start.coefficients).all()]
    if not found:
        raise CannotFit(reason or "least squares gives no finite start")
    return found


def _forms(records: Sequence[Record], model: Model) -> Iterator[tuple[Callable[[], LeastSquares], bool]]:
    """Least squares in each form, and whether its significant directions alone make another start."""
    yield partial(fit_by_scheme, records, model, "midpoint"), True
    for samples in AVERAGES:
        means = [averaged(record, samples) for record in records]
        if any(a is not b for a, b in zip(means, records, strict=True)):
            yield partial(fit_by_scheme, means, model, "midpoint"), True
    yield partial(fit_by_scheme, records, model, "forward"), False
    for omega in corner_frequencies(records, CORNERS)[:-1].tolist():
        yield lambda omega=omega: fit_filtered(records, model, omega).solution, False
