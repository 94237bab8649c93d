"""Calibration of a model with records, and its outcome with page, figure and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..diagnosis.calibration.result import Calibration
from ..models.argument_types import typed
from .admission import require_trustworthy
from .arguments import as_model, labels
from .diagnosis import training_and_held_out

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .arguments import Path as FilePath


@typed
def calibrate(
    model: Model | FilePath,
    train: Record | FilePath | Sequence[Record | FilePath],
    held_out: Record | FilePath | Sequence[Record | FilePath] = (),
    *,
    positive_rudder: str | None = None,
) -> Calibration:
    """Find which numbers of a model are wrong and by how much, by free runs of records that were left out.

    Groups of coefficients and constants enter one after the other, within the prior standard deviations that the
    family states, as long as they predict training records better that took no part in the fit.  Every record has a
    neutral rudder angle and an initial state of its own.

    Parameters
    ----------
    model : a 3-DOF model with coefficients, a vessel id or the path of a model.json.
    train : one record or several, or paths of record files; fewer than three are cut into pieces.
    held_out : likewise; scored once at the end, they take no part in the choice.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Raises
    ------
    BadInput : a file or model cannot be used, a record is given twice or on both sides, or its numbers are in another
        unit than its columns say.
    FitFailed : the model cannot be run with the records, or the arithmetic fails.
    CannotFit : the records lack what free runs need, or are too short to leave a part out.
    """
    from ..diagnosis.calibration.calibrate import calibrate as engine

    base = as_model(model)
    records, others, doubts = training_and_held_out(base, train, held_out, positive_rudder)
    require_trustworthy([*records, *others], base)
    found = engine(base, records, others)
    roles = [role for _, role in found.records]
    names = zip([*labels(train), *labels(held_out)], roles, strict=True)
    return replace(found, records=tuple(names), doubts=(*doubts, *found.doubts))
