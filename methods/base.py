"""What every identification method shares: options, the checks before a fit, and the estimate after it."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, ClassVar, Self

import numpy as np

from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate
from ..estimation.methods_only.recursive.recursion import PRIORS, UpdateRule, recursion
from ..estimation.methods_only.regression.weighted import RegressionRows
from ..estimation.methods_only.tuning.space import Domain
from ..estimation.regression.samples import RegressionSamples
from ..estimation.regression.schemes import SCHEMES, regression_samples
from ..estimation.results.fit import Fit, numerical_guard, prepared, propagate
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.extras import extras_told
from ..models.model import Model, resolve
from ..models.suggestions import suggestion
from .options import (
    POSITIVE,
    SECTION,
    Option,
    declared_in,
    option,
    options_of,
    signature_of,
    whole,
    with_options,
    words,
)

KINDS: Mapping[str, str] = {
    "grey box": "coefficients of a physical model",
    "black box": "learnt from the records alone",
    "hybrid": "a physical model with a learnt part",
    "floor": "no identification: what every method must beat",
}


DIFFERENCE = words("difference scheme", SCHEMES)
SCHEME: Any = option("midpoint", "difference scheme, see `helmbench.estimation.regression.schemes`", DIFFERENCE)
SEED: Any = option(0, "of the search", whole(0))


class Method:
    """Base class of all methods, with the conventions of scikit-learn estimators.

    `method` makes a method of a function.  A subclass of its own sets `name`, declares its options (`options.option`)
    and implements `estimate`.  `fit` does the rest.  `sklearn.base.clone` copies a method.  A constructor of the
    subclass's own works as well: its arguments are the options, each stored unchanged under its own name.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    """One line for `helmbench list methods`."""
    kind: ClassVar[str] = "grey box"
    """One of `KINDS`: what the method knows of the ship."""
    minutes: ClassVar[bool] = False
    """True for methods of the class of minutes, which the groups of a suite file leave out: a suite names them."""
    brief: ClassVar[Mapping[str, Any]] = {}
    """Options with which a fit of a method of minutes takes seconds, and is less exact: its contract is checked so."""
    search_space: ClassVar[Mapping[str, Domain]] = {}
    """Option name -> the values that `tuned:` may choose from, by the options that declare some."""
    variants: ClassVar[tuple[str, ...]] = ("corrected",)
    order_matters: ClassVar[bool] = False
    """True where the estimate may depend on the order of the records: recursions, and searches by random numbers."""
    function: ClassVar[Callable[..., Any] | None] = None
    """What computes, for a method that `method` makes."""
    options: ClassVar[Mapping[str, Option]] = {}
    """Name -> option, in the order of the constructor."""
    _declared: ClassVar[Mapping[str, Option]] = {}
    """Those that the class's body and its bases' declare: a constructor of the class's own may have others."""
    __signature__: ClassVar[inspect.Signature]
    variant: str = "corrected"
    estimate_: Estimate | None = None
    """The last estimate that `fit` gave, for `score`."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        inherited: dict[str, Option] = {}
        for base in cls.__bases__:
            inherited |= getattr(base, "_declared", {})
        cls._declared = declared_in(cls, inherited)
        cls.options = options_of(cls, cls._declared)
        cls.__signature__ = signature_of(cls.options.values())
        if "search_space" not in vars(cls):
            cls.search_space = {name: one.domain for name, one in cls.options.items() if one.domain is not None}
        if cls.__doc__ and SECTION not in cls.__doc__:
            cls.__doc__ = with_options(cls.__doc__, cls.options.values())

    def __init__(self, *values: Any, **options: Any) -> None:
        given = signature_of(self._declared.values()).bind(*values, **options)
        given.apply_defaults()
        for name, value in given.arguments.items():
            setattr(self, name, value)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Option name -> value; no option has options of its own, which `deep` would ask for."""
        return {name: getattr(self, name) for name in self.options}

    def set_params(self, **options: Any) -> Self:
        """Change options in place.

        Raises
        ------
        BadInput : for an option the method does not have.
        """
        for name, value in options.items():
            if name not in self.options:
                hint = suggestion(name, list(self.options))
                raise BadInput(f"method {self.name} has no option {name!r}", hint=hint)
            self._set_option(name, value)
        return self

    def _set_option(self, name: str, value: Any) -> None:
        setattr(self, name, value)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.get_params().items())})"

    def check_options(self) -> None:
        """Refuse impossible options; subclasses add checks of options that depend on each other.

        Raises
        ------
        BadInput : naming the option.
        """
        if self.variant not in self.variants:
            raise BadInput(
                f"method {self.name} has no variant {self.variant!r}", hint=f"known: {', '.join(self.variants)}"
            )
        for name, value in self.get_params().items():
            self.options[name].check(value)

    def visible(self, model: Model) -> Model:
        """The model that `estimate` gets: without coefficients; methods that take prior knowledge override this."""
        return model.blanked()

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        """The method itself, on checked records; may raise CannotFit and FitFailed."""
        return self.computed(records, model)

    def computed(self, *data: Any) -> Any:
        """What the method's function makes of the data that its base gives, with the options that it names."""
        if self.function is None:
            raise NotImplementedError(f"{type(self).__name__} does not implement estimate()")
        named = [name for name in inspect.signature(self.function).parameters if name in self.options]
        return self.function(*data, **{name: getattr(self, name) for name in named})

    def fit(self, records: Record | Sequence[Record], model: Model | str) -> Estimate:
        """Identify the model's coefficients from records.

        Parameters
        ----------
        records : one record or several, in SI units; their rudder sign is turned to the model's.  Not modified.
        model : the structure to identify, or its id; only methods with an option for prior knowledge use its own
            coefficients, if it has any.

        Raises
        ------
        CannotFit : a channel is missing, the records are too short, or a package of an extra is not installed.
        FitFailed : no finite estimate was found.
        BadInput : an option of the method is impossible, or what is given is no record or no model.
        """
        self.check_options()
        given, model = _records_of(records), _structure_of(model)
        checked = prepared(given, model)
        wall, cpu = time.perf_counter(), time.process_time()
        fit = self._guarded(checked, self.visible(model))
        self.estimate_ = self._wrap(fit, model, time.perf_counter() - wall, time.process_time() - cpu)
        return self.estimate_

    def score(self, records: Record | Sequence[Record], y: None = None) -> float:
        """R^2 of free runs of the last estimate along records, mean over the channels; nan where one diverges.

        What scikit-learn's model selection calls: `GridSearchCV(method, grid).fit(records, model=model)`.  `y` is there
        for it alone.

        Raises
        ------
        BadInput : nothing was fitted yet, or what is given is no record.
        CannotFit : a record lacks an input, or measures no state of the model.
        """
        if self.estimate_ is None:
            raise BadInput(f"method {self.name} has not been fitted")
        found = self.estimate_.score(_records_of(records))
        shares = [value for name, value in found.items() if name.startswith("r2_free_")]
        return float("nan") if found["diverged"] or not shares else float(np.mean(shares))

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import Tags, TargetTags

        return Tags(estimator_type=None, target_tags=TargetTags(required=False))

    def _guarded(self, records: Sequence[Record], model: Model) -> Fit:
        """`estimate` with numerical errors as FitFailed, and its coefficients checked."""
        with numerical_guard(), extras_told(CannotFit):
            fit = self.estimate(records, model)
        black_box = fit.predictor is not None and not fit.coefficients.size
        expected = 0 if black_box else len(model.coordinates)
        if fit.coefficients.shape != (expected,) or not np.isfinite(fit.coefficients).all():
            raise FitFailed(fit.message or "the estimate is not finite")
        return fit

    def _wrap(self, fit: Fit, model: Model, wall_s: float, cpu_s: float) -> Estimate:
        parameters, errors = _published(fit, model)
        facts = fit._replace(
            converged=bool(fit.converged), n_iterations=int(fit.n_iterations), extra=dict(fit.extra)
        )._asdict()
        del facts["fixed"]  # is told by the standard errors
        return Estimate(
            method=self.name,
            variant=self.variant,
            model=model.with_coefficients(fit.coefficients) if fit.coefficients.size else model.blanked(),
            parameters=parameters,
            stderr=errors,
            wall_s=wall_s,
            cpu_s=cpu_s,
            **facts,
        )


def _records_of(given: Any) -> list[Record]:
    """One record or several as a list; BadInput for anything else, such as the X of scikit-learn."""
    alone = isinstance(given, Record | str | Mapping) or not isinstance(given, Iterable)
    several: list[Any] = [given] if alone else list(given)
    if wrong := [one for one in several if not isinstance(one, Record)]:
        hint = "give a Record or a list of them: helmbench.read_record reads a file"
        raise BadInput(f"a method takes records, not {type(wrong[0]).__name__}", hint=hint)
    return several


def _structure_of(model: object) -> Model:
    """The model itself or that of an identifier; BadInput for anything else, such as the y of scikit-learn."""
    if isinstance(model, Model):
        return model
    if isinstance(model, str):
        return resolve(model)
    hint = "give a Model or an identifier of one, such as 'nomoto-1'"
    raise BadInput(f"a method takes a model beside the records, not {type(model).__name__}", hint=hint)


def _published(fit: Fit, model: Model) -> tuple[dict[str, float], dict[str, float]]:
    """Published parameters and their standard errors; none for a black box."""
    if not fit.coefficients.size:
        return {}, {}
    names = model.parameter_names
    with np.errstate(all="ignore"):
        values = model.to_parameters(fit.coefficients)
        errors = np.full(len(names), np.nan)
        if fit.covariance is not None:
            errors = propagate(model.parameters_jacobian(fit.coefficients), fit.covariance)
        errors[[names.index(name) for name in fit.fixed]] = 0.0
    return dict(zip(names, map(float, values), strict=True)), dict(zip(names, map(float, errors), strict=True))


def method(name: str, title: str, base: Any = Method, **facts: Any) -> Callable[[Any], type[Method]]:
    """A decorator that makes a method of a function: its name in the module then is the method's class.

    The function takes the data that its base gives it, records and model unless that says otherwise, and options: a
    parameter with a default declares one, and one without is an option of the base.  Its docstring is the method's.

    Parameters
    ----------
    base : what methods of one kind share.
    facts : further attributes of `Method`, and options that the base takes.
    """

    def made(function: Any) -> type[Method]:
        parameters = inspect.signature(function).parameters.values()
        declared = {p.name: p.default for p in parameters if p.default is not p.empty}
        types = {p.name: p.annotation for p in parameters}
        about = {"name": name, "title": title, "__doc__": function.__doc__, "__module__": function.__module__}
        about |= {"function": staticmethod(function), "__annotations__": types}
        new = {key: value for key, value in facts.items() if key not in base.options}
        body = new | declared | facts | about  # options that the base declares come last
        return type(function.__name__, (base,), body)

    return made


class RegressionMethod(Method):
    """Base of methods whose function solves the rows of a regression (`RegressionRows`)."""

    scheme: str = SCHEME

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        return self.computed(RegressionRows(regression_samples(records, model, self.scheme), model))


class RecursiveMethod(Method):
    """Base of methods that are a recursion over the rows of a regression.

    The function gives the `UpdateRule` of a run that begins with some samples, or a subclass has an `update_rule`.
    Several records are gone through one after the other; P and the coefficients are carried over.
    """

    order_matters = True
    p0: float = option(1e10, "initial P = p0 I, in the coordinates that `prior` names", POSITIVE)
    theta0: Any = option(0.0, "initial coefficients, one number for all or (p,) numbers")
    prior: str = option(
        "scaled",
        "'scaled' (every regressor column and equation of unit root mean square) or 'physical' (the model's "
        "coordinates and unscaled rows, as in paper 000)",
        words("prior", PRIORS),
    )
    scheme: str | None = option(
        None,
        "difference scheme, see `helmbench.estimation.regression.schemes`; None: of central ('midpoint', the trapezoid "
        "for first-order equations) and forward differences those whose fits follow left-out windows of the records "
        "best; for printed variants the papers' forward ones",
        DIFFERENCE,
    )

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        """A new rule for a run that begins with the samples `parts`."""
        return self.computed(parts)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.regression.left_out import DIFFERENCES, Scheme, best_scheme

        usual = "forward" if self.variant == "as_printed" else None
        scheme = self.scheme or usual or best_scheme(records, model, [*map(Scheme, DIFFERENCES)]).name
        parts = regression_samples(records, model, scheme)
        found = recursion(parts, model, self.update_rule(parts), self.p0, self.theta0, self.prior)
        return found._replace(extra={**found.extra, "scheme": scheme})


class Wrapper(Method):
    """Base class of methods whose other options are those of what they wrap.

    Options of the wrapped thing are stored in `inner_options`, and only those that are stated.
    """

    wrapped: ClassVar[Mapping[str, Option]] = {}
    """Options of the wrapped thing."""
    own: ClassVar[tuple[str, ...]] = ()
    """Options that are not those of the wrapped thing."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.own = tuple(cls.options)
        cls.options = {**cls.options, **{name: one for name, one in cls.wrapped.items() if name not in cls.own}}

    def __init__(self, **options: Any) -> None:
        self.inner_options: dict[str, Any] = {}
        for name in self.own:
            setattr(self, name, self.options[name].value)
        self.set_params(**options)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.own} | self.inner_options

    def _set_option(self, name: str, value: Any) -> None:
        if name in self.own:
            setattr(self, name, value)
        else:
            self.inner_options[name] = value
