"""What every identification method shares: parameters, the checks before a fit, and the estimate after it."""

from __future__ import annotations

import inspect
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np

from ..models.errors import BadInput

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .predictor import Predictor
    from .tuning.space import Domain

SHORTEST = 8
"""Samples below which no record is accepted."""


class CannotFit(Exception):
    """The method does not apply to these records or this model: the row becomes `not_applicable`."""

    def __init__(self, reason: str) -> None:
        self.reason = " ".join(reason.split())
        super().__init__(self.reason)


class FitFailed(Exception):
    """The method applies but gave no usable estimate: the row becomes `failed`."""

    def __init__(self, reason: str) -> None:
        self.reason = " ".join(reason.split())
        super().__init__(self.reason)


class Fit(NamedTuple):
    """What a method's own computation returns; everything but the coefficients may be left out."""

    coefficients: np.ndarray
    """(p,) in the model's coordinates; (0,) of a black box."""
    covariance: np.ndarray | None = None
    """(p, p); infinite on the diagonal where the records do not identify a coefficient."""
    converged: bool = True
    message: str = ""
    n_iterations: int = 1
    trajectory: np.ndarray | None = None
    """(N, p): the coefficients after each sample, for recursive methods."""
    trajectory_time_s: np.ndarray | None = None
    """(N,): seconds of record seen, counted on over all records."""
    extra: Mapping[str, Any] = {}
    predictor: Predictor | None = None
    """What predicts instead of the model: a black box, which has no coefficients."""
    fixed: tuple[str, ...] = ()
    """Published parameters that were kept, not estimated: they have no error."""


@dataclass(frozen=True)
class Estimate:
    """The result of one fit; SI units and radians throughout.

    `coefficients` (p,) and `covariance` (p, p) are in the model's coordinates, `parameters` and `stderr` are the
    published parameters and their standard errors (delta method; inf where the records do not tell, nan where no
    error is known).  `trajectory` (N, p) holds the recursion of a recursive method.
    """

    method: str
    variant: str
    model: Model
    coefficients: np.ndarray
    covariance: np.ndarray | None
    parameters: dict[str, float]
    stderr: dict[str, float]
    trajectory: np.ndarray | None = None
    trajectory_time_s: np.ndarray | None = None
    converged: bool = True
    message: str = ""
    n_iterations: int = 1
    wall_s: float = 0.0
    cpu_s: float = 0.0
    extra: dict[str, Any] = field(default_factory=dict)
    predictor: Predictor | None = None

    def save(self, path: str | Path) -> None:
        """Write the model with the estimated coefficients, as `--model` reads it back.

        Raises
        ------
        BadInput : if the file cannot be written, or the estimate is a black box.
        """
        if self.predictor is not None:
            raise BadInput(f"{self.method} has no coefficients to write as a model file", file=path)
        from ..models.model import model_to_json

        model_to_json(self.model, path)


@lru_cache(maxsize=1)
def _blas():
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def blas_limited():
    """Context with one linear-algebra thread: at the sizes met here a second one only costs time."""
    return _blas().limit(limits=1)


def propagate(jacobian: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Standard deviations (q,) of functions with `jacobian` (q, p) of coefficients with `covariance` (p, p).

    A coefficient with infinite variance makes every function infinite that depends on it.
    """
    unknown = ~np.isfinite(np.diag(covariance))
    finite = np.where(unknown[:, None] | unknown[None, :], 0.0, covariance)
    variance = np.einsum("qi,ij,qj->q", jacobian, finite, jacobian)
    variance = np.where((np.abs(jacobian) * unknown).sum(axis=1) > 0.0, np.inf, variance)
    return np.sqrt(np.maximum(variance, 0.0))


class Method:
    """Base class of all methods, in the manner of scikit-learn.

    A subclass sets `name`, takes its options as keyword arguments of `__init__`, stores each under its own name
    and implements `estimate`.  `fit` does the rest.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    """One line for `helmbench list methods`."""
    search_space: ClassVar[Mapping[str, Domain]] = {}
    """Option name -> what `tuned:` may choose it from."""
    variants: ClassVar[tuple[str, ...]] = ("corrected",)
    order_matters: ClassVar[bool] = False
    """True for recursive methods: the estimate may depend on the order of the records."""
    variant: str = "corrected"

    @classmethod
    def option_names(cls) -> list[str]:
        """Names of the options, in the order of `__init__`."""
        return [name for name in inspect.signature(cls.__init__).parameters if name not in ("self", "args", "kwargs")]

    def get_params(self) -> dict[str, Any]:
        """Option name -> value."""
        return {name: getattr(self, name) for name in self.option_names()}

    def set_params(self, **options: Any) -> Self:
        """Change options in place.

        Raises
        ------
        BadInput : for an option the method does not have.
        """
        known = self.option_names()
        for name, value in options.items():
            if name not in known:
                hint = f"known: {', '.join(known) or 'none'}"
                raise BadInput(f"method {self.name} has no option {name!r}", hint=hint)
            setattr(self, name, value)
        return self

    def clone(self) -> Self:
        """A new method with the same options."""
        return type(self)(**self.get_params())

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.get_params().items())})"

    def check_options(self) -> None:
        """Refuse impossible options; subclasses add their own.

        Raises
        ------
        BadInput : naming the option.
        """
        if self.variant not in self.variants:
            raise BadInput(
                f"method {self.name} has no variant {self.variant!r}", hint=f"known: {', '.join(self.variants)}"
            )

    def seen(self, model: Model) -> Model:
        """What `estimate` sees of a model: its structure; methods with prior knowledge also see its coefficients."""
        return model.blanked()

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        """The method itself, on checked records; may raise CannotFit and FitFailed."""
        raise NotImplementedError(f"{type(self).__name__} does not implement estimate()")

    def fit(self, records: Sequence[Record], model: Model) -> Estimate:
        """Identify the model's coefficients from records.

        Parameters
        ----------
        records : one or more records in SI units; their rudder sign is turned to the model's. Not modified.
        model : the structure to identify; its own coefficients, if it has any, are looked at only by methods that
            are told to take them as prior knowledge.

        Raises
        ------
        CannotFit : a channel is missing, or the records are too short.
        FitFailed : no finite estimate came out.
        BadInput : an option of the method is impossible.
        """
        self.check_options()
        records = prepared(records, model)
        wall, cpu = time.perf_counter(), time.process_time()
        fit = self._guarded(records, self.seen(model))
        return self._wrap(fit, model, time.perf_counter() - wall, time.process_time() - cpu)

    def _guarded(self, records: Sequence[Record], model: Model) -> Fit:
        try:
            with np.errstate(all="ignore"), blas_limited():
                fit = self.estimate(records, model)
        except (CannotFit, FitFailed):
            raise
        except BadInput as error:
            raise CannotFit(str(error)) from error
        except (ArithmeticError, np.linalg.LinAlgError, ValueError) as error:
            raise FitFailed(f"{type(error).__name__}: {error}") from error
        wanted = 0 if fit.predictor is not None else len(model.coordinates)
        if fit.coefficients.shape != (wanted,) or not np.isfinite(fit.coefficients).all():
            raise FitFailed(fit.message or "the estimate is not finite")
        return fit

    def _wrap(self, fit: Fit, model: Model, wall_s: float, cpu_s: float) -> Estimate:
        parameters, errors = _published(fit, model)
        return Estimate(
            method=self.name,
            variant=self.variant,
            model=model.blanked() if fit.predictor is not None else model.with_coefficients(fit.coefficients),
            coefficients=fit.coefficients,
            covariance=fit.covariance,
            parameters=parameters,
            stderr=errors,
            trajectory=fit.trajectory,
            trajectory_time_s=fit.trajectory_time_s,
            converged=bool(fit.converged),
            message=fit.message,
            n_iterations=int(fit.n_iterations),
            wall_s=wall_s,
            cpu_s=cpu_s,
            extra=dict(fit.extra),
            predictor=fit.predictor,
        )


def _published(fit: Fit, model: Model) -> tuple[dict[str, float], dict[str, float]]:
    """Published parameters and their standard errors; none of a black box."""
    if fit.predictor is not None:
        return {}, {}
    names = model.parameter_names
    with np.errstate(all="ignore"):
        values = model.to_parameters(fit.coefficients)
        errors = np.full(len(names), np.nan)
        if fit.covariance is not None:
            errors = propagate(model.parameters_jacobian(fit.coefficients), fit.covariance)
        errors[[names.index(name) for name in fit.fixed]] = 0.0
    return dict(zip(names, map(float, values), strict=True)), dict(zip(names, map(float, errors), strict=True))


def prepared(records: Sequence[Record], model: Model) -> list[Record]:
    """Records with the model's rudder sign.

    Raises
    ------
    CannotFit : without records, or for one that has no increasing time or too few samples.
    """
    if not records:
        raise CannotFit("no records")
    for record in records:
        if record.n < SHORTEST:
            raise CannotFit(f"record {record.name} has {record.n} samples, at least {SHORTEST} are needed")
        if not (np.isfinite(record.time_s).all() and (np.diff(record.time_s) > 0.0).all()):
            raise CannotFit(f"record {record.name}: time does not increase from sample to sample")
    return [record.turned(model.positive_rudder) for record in records]
