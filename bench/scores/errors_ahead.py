"""Errors some time ahead on measured records, beside what a model must beat and what it cannot.

Times ahead are those of `estimation.validation.horizons`: .5 to 12 ship lengths, or times sqrt(T / K) of a response
model.  Two predictions without a model stand beside: the ship goes on turning as now, and it goes straight.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...estimation.records.naming import named
from ...estimation.validation.horizons import LENGTHS, STRAIGHT, TRUSTED, TURNS_ON
from ...estimation.validation.result import Validation
from ...estimation.validation.validate import validate
from ...models.errors import BadInput
from .base import Outcome, score

MODEL = "model"
PREFIXES = {MODEL: "ahead", TURNS_ON: "turning", STRAIGHT: "straight"}
COLUMNS = [f"rmse_{p}_{length:g}_{channel}" for p in PREFIXES.values() for length in LENGTHS for channel in TRUSTED]
NOISE = [f"noise_{channel}" for channel in TRUSTED]


@score(dict.fromkeys(["trusted_s", *NOISE, *COLUMNS], "float"), rank=3)
def errors_ahead(outcome: Outcome) -> dict[str, float]:
    """RMSE of heading and yaw rate by time ahead, and the time ahead up to which to trust the model, s."""
    estimate, own = outcome.estimate, outcome.problem
    if not own.measured:
        return {}
    predictors = {} if estimate.predictor is None else {MODEL: estimate.predictor}
    try:
        found = validate({MODEL: estimate.model}, named(own.held_out), predictors)
    except BadInput:
        return {}
    told = {f"noise_{channel}": found.noise[channel] for channel in TRUSTED if channel in found.noise}
    return {"trusted_s": found.trusted_s[MODEL], **told, **_errors(found)}


def _errors(found: Validation) -> Mapping[str, float]:
    lengths = dict(zip(found.horizons_s, LENGTHS, strict=False))
    return {
        f"rmse_{PREFIXES[s.model]}_{lengths[s.horizon_s]:g}_{s.channel}": s.rmse
        for s in (*found.scores, *found.simple)
        if s.record is None and s.channel in TRUSTED and s.horizon_s is not None and s.horizon_s in lengths
    }
