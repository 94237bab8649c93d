"""What learnt predictors share: options that are left open are chosen by free runs, within the fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, cast

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.narx import NarxPredictor
from ..estimation.methods_only.black_box.rows import Lags, narx_rows, outputs_of, signals_of
from ..estimation.methods_only.black_box.scaled import evenly_spaced, fit_scaled
from ..estimation.methods_only.tuning.space import Choice, Domain, Integer
from ..estimation.methods_only.tuning.tune import tune
from ..estimation.results.fit import Fit
from ..estimation.results.predictor import Predictor
from ..models.errors import CannotFit, FitFailed
from ..models.model import Model
from .base import Method
from .options import POSITIVE, option, whole

LAGS = Integer(1, 3)


def open_option(meaning: str, domain: Domain, usual: Any) -> Any:
    """The declaration of an option that free runs choose where it is None, or that is `usual` where none is finite."""
    allowed = None if isinstance(domain, Choice) else POSITIVE
    return option(None, f"{meaning}; None: chosen by free runs", allowed, domain, usual)


STRIDE: Any = open_option("step h in samples", Integer(1, 16, log=True), 4)


class Learner(Method):
    """Base of learnt predictors.

    The function learns from records and model with all options given; it may raise CannotFit and FitFailed.  An option
    that is declared by `open_option` and is None is chosen: Optuna (TPE) tries values, fits the first 60 % of every
    record, and takes those whose free runs from the records' first samples come closest to the rest (`tuning.tune`).
    Where no trial gives a finite free run, usual values are taken and the estimate says so.
    """

    kind = "black box"
    usual_trials: ClassVar[int] = 12
    """Option values tried in a fit, unless the option `trials` says otherwise."""
    trials: int | None = option(None, "option values tried; None: 4 to 12, the fewer the longer a fit takes", whole(0))
    seed: int = option(0, "of the search and of what the method draws itself", whole(0))

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        """The fit with all options given."""
        return self.computed(records, model)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        records = in_order(records)
        space = {name: domain for name, domain in self.search_space.items() if getattr(self, name) is None}
        if not space:
            return self.learn(records, model)
        chosen, extra, message = self._chosen(space, records, model)
        fit = self._with(chosen).learn(records, model)
        told = "; ".join(filter(None, (message, fit.message)))
        return fit._replace(extra={**fit.extra, **extra}, message=told, converged=fit.converged and not message)

    def _chosen(
        self, space: Mapping[str, Domain], records: Sequence[Record], model: Model
    ) -> tuple[Mapping[str, Any], Mapping[str, Any], str]:
        """Values of the options that are left open, what the estimate tells of the search, and why it failed."""
        usual = {name: self.options[name].usual for name in space}
        trials = self.usual_trials if self.trials is None else self.trials
        if not trials:
            return usual, {"options": usual}, ""
        try:
            found = tune(
                self.for_search(records, model), space, records, model, tuner="tpe", n_trials=trials, seed=self.seed
            )
        except (CannotFit, FitFailed) as error:
            return usual, {"options": usual}, f"options not chosen: {error}"
        return found.options, {"options": found.options, "validation_error": found.error}, ""

    def for_search(self, records: Sequence[Record], model: Model) -> Learner:
        """The method whose options are searched on these records."""
        return self

    def _with(self, options: Mapping[str, Any]) -> Learner:
        from sklearn.base import clone

        return cast("Learner", clone(self)).set_params(**options)


class NarxLearner(Learner):
    """Base of regressors on rows of a difference equation with lags (`estimation.methods_only.black_box.rows`).

    The function gives a new regressor of features with some symbols (d,); options may be `stride`, `output_lags` and
    `input_lags`.
    """

    rows: ClassVar[int | None] = None
    """Most training rows, evenly spaced; for regressors whose time grows faster than the number of rows."""
    stride: int | None = None
    output_lags: int | None = None
    input_lags: int | None = None

    def lags(self) -> Lags:
        """Step and number of lagged values, by the options."""
        return Lags(int(self.stride or 1), int(self.output_lags or 1), int(self.input_lags or 1))

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        lags, parts = self.lags(), signals_of(records, model)
        x, y = narx_rows(parts, lags)
        chosen, symbols = evenly_spaced(len(x), self.rows), lags.features(model)
        learnt = fit_scaled(x[chosen], y[chosen], lambda _: self.computed(symbols), symbols)
        names = tuple(model.states), outputs_of(model)
        return black_box_fit(NarxPredictor(*names, lags.stride * parts[0].dt, lags, learnt), rows=len(chosen))


def black_box_fit(predictor: Predictor, **extra: Any) -> Fit:
    """A fit without coefficients."""
    return Fit(np.empty(0), predictor=predictor, extra=extra)


def in_order(records: Sequence[Record]) -> list[Record]:
    """Records in an order that does not depend on the one given, nor on rounding errors of their units."""

    def key(record: Record) -> tuple[Any, ...]:
        known = {name: np.abs(values[np.isfinite(values)]) for name, values in sorted(record.channels.items())}
        return record.n, *(f"{name} {values.sum():.6g}" for name, values in known.items())

    return sorted(records, key=key) if len(records) > 1 else list(records)
