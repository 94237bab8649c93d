"""Whether to believe an estimate, and several side by side: outcomes with page, table, figure and files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..estimation.judgement import assessment, comparison
from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.extras import extras_told
from .admission import admit, refuse_copies, rudder_sign_doubt, warn_of
from .arguments import AUTO, as_model, as_records
from .documents import content_writer, write_together
from .results import RunsResult, Told

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from ..datasets.record import Record
    from ..estimation.estimates.estimate import Estimate
    from ..methods.base import Method
    from ..models.model import Model
    from .arguments import Path as FilePath

FILES = ("identification.json", "identification.html", "model.json")


class Assessment(assessment.Assessment, RunsResult):
    """What an estimate is worth: `Estimate.assess` makes it.

    `verdict` is 'explains', 'approximates' or 'fails'; `train` and `held_out` are validations of the estimate,
    `train_residuals` and `held_out_residuals` the residuals of free runs with their correlations, `parameters` the
    parameters with intervals and published values, `identifiability` what the records tell, `biases` a neutral
    rudder angle or a yaw rate bias that would clearly lower the errors, with sizes (None: there is none).
    """

    room, files, pictured = "identification.page", FILES[:2], "measured channels and free run"

    def statement(self) -> list[str]:
        """Whether to believe the estimate, and why, in sentences."""
        from ..reporting.identification.page import headline, statement

        return [headline(self), *statement(self)]

    def to_json(self) -> dict[str, Any]:
        """Plain values for identification.json: the figures of the page."""
        return super().to_json() | {"statement": self.statement()}

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """The parameters: a row each, with unit, value, stderr, low, high and bound."""
        import pandas as pd

        rows = [(one.unit, one.value, one.stderr, one.low, one.high, one.bound) for one in self.parameters]
        index = pd.Index([one.name for one in self.parameters], name="parameter", dtype=object)
        return pd.DataFrame(rows, index=index, columns=pd.Index(["unit", "value", "stderr", "low", "high", "bound"]))

    def _models(self) -> dict[str, Model]:
        """The model; a black box has none."""
        return {} if self.estimate.predictor is not None else {FILES[2]: self.estimate.model}

    def write_page(self, path: FilePath) -> Path:
        """Write the page to a file; BadInput where it cannot be written."""
        place = Path(path)
        return write_together(place.parent, {place.name: content_writer(self.to_html())})[0]

    def __repr__(self) -> str:
        return f"<Assessment of {self.name}: {self.verdict}{'' if self.held_out else ', not tested'}>"


class Comparison(comparison.Comparison, Told):
    """Models or methods side by side, by free runs of records that took no part in the fit: `compare` makes it.

    `candidates` hold estimate, error and time of each, `chosen` is the best of them.
    """

    room, pictured = "identification.comparison", "errors of the candidates"

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """A row a candidate: model, method, coefficients, error, RMSE and R² of every channel, time and reason."""
        import pandas as pd

        rows = self.to_json()["candidates"]
        flat = ("model", "method", "coefficients", "error", "wall_s", "reason", "chosen")
        return pd.DataFrame(
            [
                {name: row[name] for name in flat}
                | {
                    f"{kind}_{channel}": row[kind].get(channel)
                    for kind in ("rmse_free", "r2_free")
                    for channel in self.channels
                }
                for row in rows
            ]
        )

    def plot(self) -> Figure:
        """Draw the error of every candidate on each record that tests it; a logarithmic axis.

        Returns
        -------
        A matplotlib figure, not attached to pyplot: save it with `savefig`.
        """
        from ..reporting.identification.comparison import comparison_figure

        return comparison_figure(self)

    def __repr__(self) -> str:
        chosen = self.chosen
        return f"<Comparison of {len(self.candidates)}, {self.basis}: {chosen.model.id} by {chosen.method}>"


def assess(
    estimate: Estimate,
    records: Sequence[Record],
    validate: Record | FilePath | Sequence[Record | FilePath],
    found: comparison.Comparison | None,
    positive_rudder: str | None,
) -> Assessment:
    """What an estimate from these records is worth; raises as `Estimate.assess`."""
    others = as_records(validate, positive_rudder)
    refuse_copies(records, others)
    signs = (rudder_sign_doubt(record, estimate.model) for record in (*records, *others))
    doubts = [*admit(records, estimate.model), *admit(others, estimate.model), *filter(None, signs)]
    biases = None
    if estimate.predictor is None and estimate.parameters:
        from ..diagnosis.one_bank.biases import biases_of

        biases = biases_of(estimate.model, records)
    return Assessment.of(assessment.assess(estimate, records, others, found, doubts, biases))


@typed
def compare(
    records: Record | FilePath | Sequence[Record | FilePath],
    models: Model | FilePath | Sequence[Model | FilePath],
    methods: Method | str | Sequence[Method | str],
    *,
    validate: Record | FilePath | Sequence[Record | FilePath] = (),
    positive_rudder: str | None = None,
) -> Comparison:
    """Fit models by methods, every one by every other, and compare them on records that took no part in the fit.

    With records in `validate` each is fitted once and run freely along those.  Without, each record is left out in
    turn, or blocks of time where there is only one.  A candidate that does not apply or fails stays in the table with
    its reason.

    Parameters
    ----------
    records : records, or paths of record files.
    models : one structure or several; 'auto' takes every family that needs no constants of a ship, and the vessels
        that the records name.
    methods : one method or several, or their texts (`list_methods`).
    validate : records that were held out, likewise.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Warns
    -----
    PlausibilityWarning : something about a record is doubtful.

    Raises
    ------
    BadInput : a file, model or method cannot be used, a record is given twice, its numbers are in another unit than its
        columns say, or a single record is too short to be cut.
    CannotFit : no candidate can be fitted, or the runs of all of them diverge.
    """
    from ..methods.base import Method
    from ..methods.registry import make

    given = [methods] if isinstance(methods, Method | str) else list(methods)
    fitters = [(one, make(one)) if isinstance(one, str) else (one.name, one) for one in given]
    train, others = as_records(records, positive_rudder), as_records(validate, positive_rudder)
    structures = candidate_models(models, train)
    _check(train, others, structures)
    entrants = [comparison.Entrant(model, text, fitter) for model in structures for text, fitter in fitters]
    return Comparison.of(comparison.compare(entrants, train, others))


def candidate_models(models: Model | FilePath | Sequence[Model | FilePath], records: Sequence[Record]) -> list[Model]:
    """The structures that are compared."""
    from os import PathLike

    from ..estimation.judgement.families import families_for
    from ..models.model import Model

    listed = [models] if isinstance(models, Model | str | PathLike) else list(models)
    found = [model for one in listed for model in (families_for(records) if one == AUTO else [as_model(one)])]
    if not found:
        raise BadInput("no model to compare", hint="give one or more, or 'auto'")
    return found


def _check(train: Sequence[Record], others: Sequence[Record], models: Sequence[Model]) -> None:
    """Refuse records that cannot be what they say; warn of those that are doubtful."""
    from ..datasets.plausibility import check_plausible

    if not train:
        raise BadInput("no record to fit", hint="give at least one")
    doubts = [*admit(train, models[0]), *admit(others, models[0])]
    doubts += [told for model in models[1:] for side in (train, others) for told in check_plausible(side, model)]
    refuse_copies(train, others)
    warn_of(list(dict.fromkeys(doubts)))
