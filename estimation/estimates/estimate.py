"""The result of one fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.display import continuous, time_figure
from ...datasets.record import Record
from ...models.display import html_table
from ...models.errors import BadInput, FitFailed
from ...models.extras import extras_told
from ...models.result import FilePath, above

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from ...models.model import Model
    from ..information.identifiability import Identifiability
    from ..results.predictor import Predictor
    from .assessment import Assessment
    from .comparison import Comparison


@dataclass(frozen=True, repr=False)
class Estimate:
    """The result of one fit; SI units and radians throughout.

    `coefficients` (p,) and `covariance` (p, p) are in the model's coordinates, `parameters` and `stderr` are the
    published parameters and their standard errors (delta method; inf where the records do not determine a parameter,
    nan where no error is known).  `trajectory` (N, p) holds the coefficients after each sample of a recursive method.
    A black box has no coefficients: its `predictor` predicts in the model's place.  A hybrid has both.
    `records` are the training records as they were read; a method's own `fit` gives an estimate without them, which
    has everything but `assess`, `to_html` and `write`.  `held_out` are those that `identify` was given beside them.
    `comparison` holds the other models where `identify` chose one.

    `predict`, `simulate`, `score` and `residual_report` take records as they were read: the rudder sign is changed to
    the model's, and what the model knows of its instruments is taken into account.
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
    records: tuple[Record, ...] = ()
    comparison: Comparison | None = None
    held_out: tuple[Record, ...] = ()

    def predict(self, record: Record) -> Record:
        """One-step prediction: every sample from the measured sample before it.

        Returns
        -------
        A record of the same times with the rudder, and in each channel that the record measures and the model has the
        predicted samples (N,); nan where the sample before is missing.  The heading does not wrap.

        Raises
        ------
        CannotFit : the record lacks an input, or measures no state of the model.
        """
        from ..run.prediction import stepped_record

        return stepped_record(self.model, record, self.predictor)

    def simulate(self, record: Record) -> Record:
        """Free run: the model driven by the record's inputs from the state that is smoothed from the record.

        Returns and raises as `predict`.  It starts anew behind each long gap; samples after the run has diverged stay
        as they were there.
        """
        from ..run.run import simulated_record

        return simulated_record(self.model, record, self.predictor)

    def score(self, records: Record | Sequence[Record]) -> dict[str, Any]:
        """Errors of free runs and one-step predictions, pooled over one record or several.

        Returns
        -------
        `rmse_free_CHANNEL`, `r2_free_CHANNEL`, `rmse_one_CHANNEL`, `r2_one_CHANNEL` (in the channel's unit; R^2 = 1 -
        SSE/SST) for every measured channel, and `diverged`.

        Raises
        ------
        CannotFit : a record lacks an input, or measures no state of the model.
        """
        from ..run.prediction import prediction_scores

        return prediction_scores(self.model, listed(records), self.predictor)

    @extras_told()
    def residual_report(self, records: Record | Sequence[Record], horizon: str = "free") -> pd.DataFrame:
        """Statistics of measured minus predicted samples, pooled over one record or several.

        With correct equations and white sensor noise the residuals of a free run are white, apart from what the error
        of the state from which it starts does to it: that decays in the yaw rate and stays in the heading.
        One-step residuals are not white even then, since every prediction starts from a noisy sample.

        Parameters
        ----------
        horizon : 'free' for free runs, 'one' for one-step predictions.

        Returns
        -------
        A row a channel: unit, n (samples), mean, sd, rmse, r2, lag_1 (autocorrelation at one sample), ljung_box (Q of
        Ljung and Box 1978, Biometrika 65, summed over the records), degrees (its degrees of freedom) and p_white (its
        p-value under white residuals).

        Raises
        ------
        BadInput : another horizon.
        CannotFit : a record lacks an input, or measures no state of the model.
        """
        from .correlation import residual_report

        return residual_report(self.model, listed(records), horizon, self.predictor)

    def identifiability(self, records: Record | Sequence[Record]) -> Identifiability:
        """How well the records determine each parameter (Cramer-Rao bounds at the estimate), and what would help.

        Raises
        ------
        BadInput : the estimate is a black box.
        CannotFit : the records do not suit the model.
        """
        from ...datasets.instruments import hull_record
        from ..information.identifiability import identifiability

        if not self.parameters:
            raise BadInput(f"{self.method} has no parameters", hint="a black box has no coefficients")
        return identifiability(self.model, [hull_record(record, self.model) for record in listed(records)])

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """Published parameters: a row each, with unit, estimate and stderr; no rows for a black box."""
        import pandas as pd

        units = dict(zip(self.model.parameter_names, self.model.parameter_units, strict=True))
        rows = [(units[name], value, self.stderr.get(name, np.nan)) for name, value in self.parameters.items()]
        index = pd.Index(list(self.parameters), name="parameter", dtype=object)
        return pd.DataFrame(rows, index=index, columns=pd.Index(["unit", "estimate", "stderr"]))

    def plot(self, record: Record) -> Figure:
        """Draw a record's measured channels, the free run and the one-step prediction over time; angles in degrees.

        Returns
        -------
        A matplotlib figure, not attached to pyplot: save it with `savefig`.

        Raises
        ------
        CannotFit : the record lacks an input, or measures no state of the model.
        """
        from ..run.run import CHANNELS

        measured = record.turned(self.model.positive_rudder)
        free, one = self.simulate(record), self.predict(record)
        runs, panels = (("measured", measured), ("one step", one), ("free run", free)), {}
        for channel in (name for name in CHANNELS if free.has(name)):
            panels[channel] = [(told, run.time_s, continuous(channel, run.column(channel))) for told, run in runs]
        return time_figure(panels, f"{self.model.family} by {self.method}: {record.name}")

    def assess(
        self,
        validate: Record | FilePath | Sequence[Record | FilePath] = (),
        *,
        compared: Comparison | None = None,
        positive_rudder: str | None = None,
    ) -> Assessment:
        """Whether to believe the estimate: free runs, residuals, intervals, what the records tell, what to sail next.

        Parameters
        ----------
        validate : records that took no part in the fit, or their paths; none: those that `identify` was given.
        compared : other models or methods to show beside it (`compare`); None: what `identify` compared.
        positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files of `validate`.

        Raises
        ------
        BadInput : the estimate has no records, a file cannot be used, or a record is given twice.
        """
        if not self.records:
            raise BadInput("the estimate does not hold its records", hint="make it with helmbench.identify")
        others = self.held_out if isinstance(validate, Sequence) and not validate else validate
        return above("api.identification").assess(
            self, self.records, others, compared or self.comparison, positive_rudder
        )

    def to_html(self, validate: Record | FilePath | Sequence[Record | FilePath] = ()) -> str:
        """The page of the identification: one self-contained HTML document.  Takes and raises as `assess`."""
        return self.assess(validate).to_html()

    def write(
        self, folder: FilePath, validate: Record | FilePath | Sequence[Record | FilePath] = ()
    ) -> tuple[Path, ...]:
        """Write identification.json, identification.html and model.json into a folder: all of them or none.

        Takes and raises as `assess`; BadInput also where the folder cannot be written to.
        """
        return self.assess(validate).write(folder)

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={value:.4g}" for name, value in self.parameters.items()) or "black box"
        return (
            f"<Estimate of {self.model.family} by {self.method}: {values}{'' if self.converged else '; not converged'}>"
        )

    def _repr_html_(self) -> str:
        from ...models.figure import picture

        pictures = [picture(lambda one=one: self.plot(one), f"free run along {one.name}") for one in self.records[:1]]
        return self._table() + "".join(pictures)

    def _table(self) -> str:
        """The parameters with their standard errors as HTML."""
        title = f"<p><b>{escape(self.model.family)}</b> by {escape(self.method)}"
        state = "" if self.converged else f"; not converged: {escape(self.message)}"
        if self.predictor is not None:
            return f"{title}{state}; a black box without coefficients</p>"
        units = dict(zip(self.model.parameter_names, self.model.parameter_units, strict=True))
        errors = {name: _error(self.stderr.get(name, np.nan)) for name in self.parameters}
        rows = [(name, f"{value:.5g}", errors[name], units[name]) for name, value in self.parameters.items()]
        return f"{title}{state}</p>{html_table(('parameter', 'estimate', 'standard error', 'unit'), rows)}"

    def save(self, path: FilePath) -> None:
        """Write the model with the estimated coefficients, as `--model` and `resolve` read it back.

        Raises
        ------
        BadInput : if the file cannot be written, or the estimate is a black box.
        """
        if self.predictor is not None:
            lacks = "a learnt part that a model file cannot hold" if self.parameters else "no coefficients to write"
            raise BadInput(f"{self.method} has {lacks}", file=path)
        from ...models.model import model_to_json

        model_to_json(self.model, path)


def _error(value: float) -> str:
    if np.isinf(value):
        return "not identified"
    return "" if np.isnan(value) else f"{value:.2g}" if value else "fixed"


def predictor_of(estimate: Estimate) -> Predictor:
    """The estimate's own predictor, or its model."""
    from ..results.predictor import ModelPredictor

    return estimate.predictor or ModelPredictor(estimate.model)


def listed(records: Record | Sequence[Record]) -> list[Record]:
    """One record or several as a list."""
    return [records] if isinstance(records, Record) else list(records)


def published(estimate: Estimate) -> Estimate:
    """The estimate, if all its published parameters have finite real values.

    Raises
    ------
    FitFailed : naming those that have none.
    """
    lost = [name for name, value in estimate.parameters.items() if not np.isfinite(value)]
    if lost:
        raise FitFailed(f"{', '.join(lost)}: no finite real value belongs to the fitted coefficients of the model")
    return estimate
