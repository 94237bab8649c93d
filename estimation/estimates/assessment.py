"""What an estimate is worth: free runs, residuals, what the records tell, published values; and the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...checks.result import Size
from ...datasets.record import Record
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.extras import extras_told
from ...models.files import content_writer, write_together
from ...models.model import Model
from ...models.published import published_values
from ...models.result import FilePath, RunsResult, above
from ..information.identifiability import Identifiability
from ..likelihood.output_error import ADEQUATE
from ..records.naming import named, numbered
from ..validation.horizons import better_at
from ..validation.result import FREE, Validation
from ..validation.validate import validate
from .comparison import Comparison
from .correlation import ChannelResiduals, Correlation, channel_residuals
from .estimate import Estimate

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Biases:
    """Biases that would clearly lower the errors of a model that was identified without them.

    sizes : of each bias, SI, with 90 % intervals; `parameter` is `rudder_offset` (the acting rudder angle is the
    recorded one plus this, in the model's sign, rad) or `yaw_rate_bias` (the sensor shows so much too much, rad/s).
    parameters : published parameters of the model when they are estimated along with the biases.
    before, after : channel -> root mean square error of free runs of whole records, SI, of the identified model, and
    of the model with these parameters behind the biases.
    """

    sizes: tuple[Size, ...]
    parameters: Mapping[str, float]
    before: Mapping[str, float]
    after: Mapping[str, float]

    def to_json(self) -> dict[str, Any]:
        """Plain values for identification.json."""
        return {
            "sizes": [vars(size) for size in self.sizes],
            "parameters": dict(self.parameters),
            "rmse_before": dict(self.before),
            "rmse_after": dict(self.after),
        }


SCHEMA = 1
EXPLAINS, APPROXIMATES, FAILS = "explains", "approximates", "fails"
POOR = 0.5
"""Mean R^2 of free runs of whole records below which errors ahead decide whether a model is of use."""
NEAR = 3
"""Times ahead, up to three ship lengths, at which predictions must be better than without a model where R^2 is poor."""
NORMAL_95 = 1.959963984540054
SMALL = 0.5
"""Residuals below this share of the sensor's noise are not tested for correlation: the records have no noise."""


@dataclass(frozen=True)
class ParameterTold:
    """A published parameter: estimate, standard error, interval, what the records tell at best, published values.

    low, high : ends of the profile interval if there is one, else of the 95 % interval by the standard error; nan where
    none is known;  bound : smallest relative standard deviation that the records allow, nan where none was computed;
    published : vessel id -> value.
    """

    name: str
    unit: str
    value: float
    stderr: float
    low: float
    high: float
    bound: float
    published: Mapping[str, float]


@dataclass(frozen=True, repr=False)
class Assessment(RunsResult):
    """What an estimate is worth on its training records and on records that were held out: `Estimate.assess` makes it.

    train, held_out : free runs, held_out None where nothing was;  train_residuals, held_out_residuals : those of the
    free runs by channel;  identifiability : what the records tell, None with the reason in `not_told`;  doubts :
    warnings about records;  comparison : other models or methods on the same records, compared : the free runs of the
    best of them along the held-out records, or the training records where none was held out;  biases : of rudder and
    yaw rate that would clearly lower the errors, None where there are none or none were tried.
    """

    estimate: Estimate
    train: Validation
    held_out: Validation | None
    train_residuals: tuple[ChannelResiduals, ...]
    held_out_residuals: tuple[ChannelResiduals, ...]
    parameters: tuple[ParameterTold, ...]
    identifiability: Identifiability | None
    not_told: str
    doubts: tuple[str, ...]
    comparison: Comparison | None
    compared: Validation | None
    biases: Biases | None = None
    room: ClassVar[str] = "identification.page"
    files: ClassVar[tuple[str, ...]] = ("identification.json", "identification.html", "model.json")
    pictured: ClassVar[str] = "measured channels and free run"

    @property
    def name(self) -> str:
        """What the page calls the estimate."""
        return next(iter(self.train.models))

    @property
    def judged(self) -> Validation:
        """The validation that counts: on held-out records, or else on the training records."""
        return self.train if self.held_out is None else self.held_out

    @property
    def trusted_s(self) -> float:
        """Time ahead, s, up to which predictions are better than without a model; 0: nowhere; nan: not tried."""
        return self.judged.trusted_s[self.name]

    @property
    def r2(self) -> float:
        """R^2 of free runs of whole records, from the start that each record itself has; nan where there is none."""
        together = self.judged.score(None)
        return np.nan if together is None else together.r2

    @property
    def diverged(self) -> tuple[str, ...]:
        """Records along which a free run diverges."""
        parts = [self.train] if self.held_out is None else [self.train, self.held_out]
        return tuple(run.record for part in parts for run in part.runs if run.diverged)

    @property
    def exceeding(self) -> tuple[ChannelResiduals, ...]:
        """Residuals that exceed the sensor's noise by more than a model does that explains the records."""
        return tuple(one for one in (*self.train_residuals, *self.held_out_residuals) if one.ratio > ADEQUATE)

    @property
    def verdict(self) -> str:
        """'explains': residuals are those of the sensors; 'fails': a run diverges, predictions are at no time ahead
        better than without a model, or R^2 is below 0.5 in the mean and they are not better as far as `NEAR` times
        ahead, or it is below 0 on held-out records or beside residuals that exceed the noise; 'approximates': between
        the two."""
        better = better_at(self.judged.scores, self.judged.simple, self.name)
        far = len(better) >= NEAR and self.trusted_s >= [*better][NEAR - 1]
        unlike = not self.r2 >= 0.0 and (self.held_out is not None or bool(self.exceeding))
        if self.diverged or unlike or (better and not any(better.values())) or not (self.r2 >= POOR or far):
            return FAILS
        return APPROXIMATES if self.exceeding or not self.train_residuals else EXPLAINS

    @property
    def correlated(self) -> tuple[str, ...]:
        """Channels whose training residuals are correlated in time."""
        return tuple(one.channel for one in self._tested() if one.in_time.significant)

    @property
    def rudder_left(self) -> tuple[str, ...]:
        """Channels whose training residuals depend on the rudder."""
        return tuple(one.channel for one in self._tested() if one.with_rudder.significant)

    def _tested(self) -> list[ChannelResiduals]:
        return [one for one in self.train_residuals if one.ratio > SMALL]

    def to_json(self) -> dict[str, Any]:
        """Plain values for identification.json: the figures of the page."""
        estimate, told = self.estimate, self.identifiability
        sides = {"train": self.train_residuals, "held_out": self.held_out_residuals}
        return {
            "schema": SCHEMA,
            "method": estimate.method,
            "variant": estimate.variant,
            "model": estimate.model.family,
            "positive_rudder": estimate.model.positive_rudder,
            "train": [one.name for one in self.train.records],
            "parameters": [_parameter(one) for one in self.parameters],
            "converged": estimate.converged,
            "message": estimate.message,
            "wall_s": estimate.wall_s,
            "cpu_s": estimate.cpu_s,
            "verdict": self.verdict,
            "tested": self.held_out is not None,
            "diverged": list(self.diverged),
            "correlated": list(self.correlated),
            "rudder_left": list(self.rudder_left),
            "horizons": [vars(s) for s in self.judged.scores if s.record is None and s.horizon_s is not None],
            "simple": [vars(s) for s in self.judged.simple],
            "trusted_s": self.trusted_s,
            "training": scores(self.train),
            "validation": None if self.held_out is None else scores(self.held_out),
            "residuals": {side: [_residuals(one) for one in found] for side, found in sides.items()},
            "profile": estimate.extra.get("profile"),
            "identifiability": None if told is None else told.as_dict(),
            "not_told": self.not_told,
            "biases": None if self.biases is None else self.biases.to_json(),
            "warnings": list(self.doubts),
            "comparison": None if self.comparison is None else self.comparison.to_json(),
            "statement": self.statement(),
        }

    def statement(self) -> list[str]:
        """Whether to believe the estimate, and why, in sentences."""
        said = above("reporting.identification.page")
        return [said.headline(self), *said.statement(self)]

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """The parameters: a row each, with unit, value, stderr, low, high and bound."""
        import pandas as pd

        rows = [(one.unit, one.value, one.stderr, one.low, one.high, one.bound) for one in self.parameters]
        index = pd.Index([one.name for one in self.parameters], name="parameter", dtype=object)
        return pd.DataFrame(rows, index=index, columns=pd.Index(["unit", "value", "stderr", "low", "high", "bound"]))

    def _models(self) -> dict[str, Model]:
        """The model; a black box has none."""
        return {} if self.estimate.predictor is not None else {self.files[2]: self.estimate.model}

    def write_page(self, path: FilePath) -> Path:
        """Write the page to a file; BadInput where it cannot be written."""
        place = Path(path)
        return write_together(place.parent, {place.name: content_writer(self.to_html())})[0]

    def __repr__(self) -> str:
        return f"<Assessment of {self.name}: {self.verdict}{'' if self.held_out else ', not tested'}>"


def scores(found: Validation) -> dict[str, Any]:
    """Errors over all records as plain values: `rmse_free_CHANNEL`, `r2_free_CHANNEL`, and the same one step ahead."""
    out: dict[str, Any] = {
        "records": [one.name for one in found.records],
        "diverged": any(run.diverged for run in found.runs),
    }
    for score in (one for one in found.scores if one.record is None and one.channel is not None):
        horizon = "free" if score.horizon == FREE else "one" if score.horizon_s is None else None
        if horizon is not None:
            out |= {f"rmse_{horizon}_{score.channel}": score.rmse, f"r2_{horizon}_{score.channel}": score.r2}
    together = found.score(None)
    return out | {"r2_free_together": np.nan if together is None else together.r2}


def _parameter(one: ParameterTold) -> dict[str, Any]:
    plain = {"parameter": one.name, "unit": one.unit, "estimate": one.value, "stderr": one.stderr}
    return plain | {"low": one.low, "high": one.high, "bound": one.bound, "published": dict(one.published)}


def _residuals(one: ChannelResiduals) -> dict[str, Any]:
    correlations = {"in_time": _correlation(one.in_time), "with_rudder": _correlation(one.with_rudder)}
    return {**vars(one), "ratio": one.ratio, **correlations}


def _correlation(found: Correlation) -> dict[str, Any]:
    lists = {"lag_s": found.lag_s.tolist(), "values": found.values.tolist()}
    return {**found._asdict(), **lists, "outside": found.outside, "significant": found.significant}


DRAWN = 6
"""Compared candidates whose free runs are drawn."""


def assess(
    estimate: Estimate,
    train: Sequence[Record],
    held_out: Sequence[Record] = (),
    comparison: Comparison | None = None,
    doubts: Sequence[str] = (),
    biases: Biases | None = None,
) -> Assessment:
    """Free runs, residuals, identifiability and published values of an estimate.

    Parameters
    ----------
    train, held_out : records as they were read.
    biases : of the training records, where some were found.

    Raises
    ------
    BadInput : no record suits the model.
    """
    told, not_told = _identifiability(estimate, train)
    return Assessment(
        estimate=estimate,
        train=_validation(estimate, train, ahead=not held_out),
        held_out=_validation(estimate, held_out, ahead=True) if held_out else None,
        train_residuals=channel_residuals(estimate, train),
        held_out_residuals=_held_out_residuals(estimate, held_out),
        parameters=_parameters(estimate, told),
        identifiability=told,
        not_told=not_told,
        doubts=tuple(doubts),
        comparison=comparison,
        compared=None if comparison is None else _compared(comparison, held_out or train),
        biases=biases,
    )


def _validation(estimate: Estimate, records: Sequence[Record], ahead: bool) -> Validation:
    name = f"{estimate.model.family} by {estimate.method}"
    predictors = {} if estimate.predictor is None else {name: estimate.predictor}
    return validate({name: estimate.model}, named(records), predictors, ahead)


def _compared(comparison: Comparison, records: Sequence[Record]) -> Validation:
    """Free runs of the candidates that have an error, the chosen one first, then by error."""
    tested = [one for one in comparison.candidates if np.isfinite(one.error)]
    best = sorted(tested, key=lambda one: (one is not comparison.chosen, one.error))[:DRAWN]
    models = len({one.model.id for one in best}) > 1
    names = numbered([f"{one.model.id} by {one.method}" if models else one.method for one in best])
    fitted = {name: one.estimate for name, one in zip(names, best, strict=True) if one.estimate is not None}
    predictors = {name: one.predictor for name, one in fitted.items() if one.predictor is not None}
    return validate({name: one.model for name, one in fitted.items()}, named(records), predictors, ahead=False)


def _held_out_residuals(estimate: Estimate, records: Sequence[Record]) -> tuple[ChannelResiduals, ...]:
    """Residuals of the held-out records that suit the model; the validation tells of the others."""
    suited: list[Record] = []
    for record in records:
        try:
            channel_residuals(estimate, [record])
        except CannotFit:
            continue
        suited.append(record)
    return channel_residuals(estimate, suited) if suited else ()


def _identifiability(estimate: Estimate, records: Sequence[Record]) -> tuple[Identifiability | None, str]:
    """What the records tell of the parameters, or why that is not known."""
    if not estimate.parameters:
        return None, "a black box has no parameters"
    try:
        return estimate.identifiability(records), ""
    except BadInput as error:
        return None, error.message
    except (CannotFit, FitFailed) as error:
        return None, error.reason


def _parameters(estimate: Estimate, told: Identifiability | None) -> tuple[ParameterTold, ...]:
    model, profiles = estimate.model, estimate.extra.get("profile", {})
    units = dict(zip(model.parameter_names, model.parameter_units, strict=True))
    bounds = {} if told is None else {one.name: one.relative for one in told.parameters}
    published = published_values(model)
    out = []
    for name, value in estimate.parameters.items():
        error = estimate.stderr.get(name, np.nan)
        profile = profiles.get(name)
        half = NORMAL_95 * error
        low, high = (value - half, value + half) if profile is None else (profile["low"], profile["high"])
        bound = bounds.get(name, np.nan)
        out.append(ParameterTold(name, units[name], value, error, low, high, bound, published.get(name, {})))
    return tuple(out)
