"""What a fit takes and returns: checked records, coefficients with their covariance, propagated errors."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from ...datasets.record import Record
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.linear_algebra import blas_limited
from ...models.model import Model
from .predictor import Predictor

SHORTEST = 8
"""Samples below which no record is accepted."""
LONGEST_PATH = 20_000_000
"""Numbers above which a kept trajectory is thinned to every second, third, ... sample."""


class Fit(NamedTuple):
    """What the computation of a method returns; everything but the coefficients may be left out."""

    coefficients: np.ndarray
    """(p,) in the model's coordinates; (0,) for a black box."""
    covariance: np.ndarray | None = None
    """(p, p); infinite on the diagonal where the records do not identify a coefficient."""
    converged: bool = True
    message: str = ""
    n_iterations: int = 1
    trajectory: np.ndarray | None = None
    """(N, p): the coefficients after each sample, for recursive methods."""
    trajectory_time_s: np.ndarray | None = None
    """(N,): seconds of record up to each row, summed over the records."""
    extra: Mapping[str, Any] = {}
    predictor: Predictor | None = None
    """A black box, which has no coefficients, or a model with a learnt part predicts with this instead of the model."""
    fixed: tuple[str, ...] = ()
    """Published parameters that were fixed, not estimated: they have no error."""


@contextmanager
def numerical_guard() -> Generator[None]:
    """Context of a fit: no floating-point warnings, one linear-algebra thread, errors as FitFailed or CannotFit.

    Raises
    ------
    CannotFit : also for BadInput: records or model do not suit the fit.
    FitFailed : also for an arithmetic or linear-algebra error.
    """
    try:
        with arithmetic_guard(), blas_limited():
            yield
    except BadInput as error:
        raise CannotFit(str(error)) from error


@contextmanager
def arithmetic_guard() -> Generator[None]:
    """Context without floating-point warnings, whose arithmetic errors are FitFailed.

    Raises
    ------
    FitFailed : for an arithmetic or linear-algebra error, or a value that an algorithm refuses.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except BadInput:
        raise
    except (ArithmeticError, np.linalg.LinAlgError, ValueError) as error:
        raise FitFailed(f"{type(error).__name__}: {error}") from error


def mapped(jacobian: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Covariance (q, q) of functions with `jacobian` (q, p) of coefficients with `covariance` (p, p).

    A coefficient with infinite variance makes that of every function infinite that depends on it.
    """
    unknown = ~np.isfinite(np.diag(covariance))
    found = jacobian @ np.where(unknown[:, None] | unknown, 0.0, covariance) @ jacobian.T
    undetermined = np.abs(jacobian) @ unknown > 0.0
    found[undetermined, undetermined] = np.inf
    return found


def propagate(jacobian: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Standard deviations (q,) of the same functions."""
    return np.sqrt(np.maximum(np.diag(mapped(jacobian, covariance)), 0.0))


def prepared(records: Sequence[Record], model: Model) -> list[Record]:
    """Records with the model's rudder sign.

    Raises
    ------
    CannotFit : without records, or for one that has too few samples.
    """
    if not records:
        raise CannotFit("no records")
    for record in records:
        if record.n < SHORTEST:
            raise CannotFit(f"record {record.name} has {record.n} samples, at least {SHORTEST} are needed")
    return [record.turned(model.positive_rudder) for record in records]
