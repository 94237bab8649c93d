"""Validation of models on records, and its outcome with page, table, figure and files."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import fspath
from typing import TYPE_CHECKING

from ..estimation.validation.result import Validation
from ..models.argument_types import typed
from .arguments import admit, as_model, as_records, labels, listed, rudder_sign_doubt

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .arguments import Path as FilePath


@typed
def validate(
    model: Model | FilePath,
    records: Record | FilePath | Sequence[Record | FilePath],
    compare: Model | FilePath | Sequence[Model | FilePath] = (),
    *,
    positive_rudder: str | None = None,
) -> Validation:
    """Compare simulations with records: free runs, predictions some time ahead, manoeuvring indices.

    A free run starts from the state that the record itself, smoothed, has at its first sample, uses nothing of the
    record but rudder and revolutions, and has no random forces; it starts anew behind a long gap.  Errors of free runs
    are those of the recorded channels.  Predictions ahead start from up to 200 smoothed states of a record and are
    compared with what the hull did, behind the model's instruments.  The times ahead are 0.5, 1.5, 3, 6 and 12 ship
    lengths (10 to 249 s for a ship of 160 m at 15 kn) as far as a record is that long; where no model knows its length,
    sqrt(T / K) takes the place of L/U, else they are 1/60, 1/20 and 1/10 of the records' median duration.  A ship that
    goes on turning as now and one that goes straight stand beside the models: up to `trusted_s` a model is better.  The
    indices are those of IMO MSC.137(76), as far as the records allow them: overshoots of zigzags, advance, transfer and
    tactical diameter of turning circles, initial turning at 10 degrees of rudder; the simulated ship sails the same
    manoeuvre, with its own heading giving the counter rudder.

    Parameters
    ----------
    model : a model with coefficients, or a vessel id or the path of a model.json.
    records : one record or several, or paths of record files.
    compare : further models, likewise; they are validated in the same way.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Warns
    -----
    RudderSignWarning : the yaw response of a record contradicts its rudder sign.

    Raises
    ------
    BadInput : a file or model cannot be used, a model has no coefficients, a record is given twice, no record suits the
        model, or the numbers of a record cannot be what they say.
    """
    from ..datasets.rudder_sign import RudderSignWarning
    from ..estimation.validation import validate as engine

    models = _named_models(model, compare)
    given = as_records(records, positive_rudder)
    doubts = admit(given, next(iter(models.values())))
    named = dict(zip(_names([record.name for record in given], labels(records)), given, strict=True))
    found = replace(engine.validate(models, named), doubts=doubts)
    for doubt in filter(None, (rudder_sign_doubt(record, next(iter(models.values()))) for record in given)):
        warnings.warn(doubt, RudderSignWarning, stacklevel=3)
    return found


def _named_models(
    model: Model | FilePath, compare: Model | FilePath | Sequence[Model | FilePath]
) -> Mapping[str, Model]:
    """Models by identifier, or by what they were given as where identifiers repeat."""
    from ..models.model import Model

    given = [model, *listed(compare)]
    models = [as_model(one) for one in given]
    long = [one.id if isinstance(one, Model) else fspath(one) for one in given]
    return dict(zip(_names([one.id for one in models], long), models, strict=True))


def _names(short: Sequence[str], long: Sequence[str]) -> list[str]:
    """The short names if they differ, else the long ones; those that repeat even so get a number."""
    from ..estimation.records.naming import numbered

    return numbered(short if len(set(short)) == len(short) else long)
