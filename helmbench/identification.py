"""Identify one model from a user's own records: what `helmbench identify` calls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .datasets.instruments import corrected
from .datasets.io import read_record
from .models.errors import BadInput
from .models.model import CHANNELS, Model, resolve

if TYPE_CHECKING:
    from .datasets.record import Record
    from .estimation.estimate import Estimate
    from .estimation.identifiability import Identifiability

SIGN_SHARE = 0.3
"""The rudder's sign is questioned where it explains at least this share of what the yaw rate leaves unexplained."""


@dataclass(frozen=True)
class Identification:
    """An estimate, its scores on validation records (`prediction_scores` columns) and what the user should know."""

    estimate: Estimate
    train: tuple[str, ...]
    validation: tuple[str, ...]
    scores: Mapping[str, Any]
    warnings: tuple[str, ...]
    identifiability: Identifiability | None = None
    """What the training records tell of the estimate's parameters, if that was asked for."""

    def as_dict(self) -> dict[str, Any]:
        """Plain values for `--json`."""
        estimate, model = self.estimate, self.estimate.model
        values, errors = estimate.parameters, estimate.stderr
        parameters = [
            {"parameter": name, "unit": unit, "estimate": values[name], "stderr": errors.get(name)}
            for name, unit in zip(model.parameter_names, model.parameter_units, strict=True)
            if name in values
        ]
        return {
            "method": estimate.method,
            "variant": estimate.variant,
            "model": model.family,
            "positive_rudder": model.positive_rudder,
            "train": list(self.train),
            "parameters": parameters,
            "converged": estimate.converged,
            "message": estimate.message,
            "wall_s": estimate.wall_s,
            "cpu_s": estimate.cpu_s,
            "validation": {"records": list(self.validation), **self.scores} if self.validation else None,
            "profile": estimate.extra.get("profile"),
            "identifiability": self.identifiability.as_dict() if self.identifiability else None,
            "warnings": list(self.warnings),
        }


def identify(
    train: Sequence[str | Path],
    model: str,
    method: str,
    validate: Sequence[str | Path] = (),
    positive_rudder: str | None = None,
    report: bool = False,
) -> Identification:
    """Read records, fit `model` with `method` and score it on the validation records.

    With `report`, also say what the training records tell of the parameters at the estimate.

    Raises
    ------
    BadInput : a file, model or method cannot be used, or a record lacks what the method needs.
    FitFailed : no finite estimate came out.
    """
    from .estimation.identifiability import identifiability
    from .estimation.prediction import prediction_scores
    from .methods.registry import make
    from .models.errors import CannotFit

    structure, fitter = resolve(model), make(method)
    records = [_read(path, positive_rudder, structure) for path in train]
    others = [_read(path, positive_rudder, structure) for path in validate]
    try:
        estimate = fitter.fit(records, structure)
        scores = prediction_scores(estimate.model, others, estimate.predictor) if others else {}
        told = identifiability(estimate.model, records) if report and estimate.predictor is None else None
    except CannotFit as reason:
        raise BadInput(f"method {method} cannot fit {model}: {reason}") from None
    doubts = tuple(doubt for record in [*records, *others] if (doubt := sign_doubt(record)))
    names, other_names = (tuple(record.name for record in group) for group in (records, others))
    return Identification(estimate, names, other_names, scores, doubts, told)


def sign_doubt(record: Record) -> str | None:
    """A sentence if the yaw response contradicts the record's rudder sign, else None.

    Least squares of the integrated first-order response r - r0 = a int r + b int delta + c t, with r to starboard:
    b must have the sign of the rudder.
    """
    if record.meta.positive_rudder is None or not (record.has("yaw_rate_rad_s") or record.has("heading_rad")):
        return None
    rate, rudder = _yaw_rate(record), record.rudder()
    known = np.isfinite(rate) & np.isfinite(rudder)
    if known.sum() < 20:
        return None
    time, rate, rudder = record.time_s[known] - record.time_s[known][0], rate[known], rudder[known]
    columns = np.column_stack([_integral(rudder, time), _integral(rate, time), time, np.ones(time.size)])
    gain, error = _least_squares(columns, rate)
    _, error_without = _least_squares(columns[:, 1:], rate)
    expected = 1.0 if record.meta.positive_rudder == "starboard" else -1.0
    if gain * expected >= 0.0 or error > (1.0 - SIGN_SHARE) * error_without:
        return None
    return (
        f"rudder_sign: in {record.name} the ship turns against a rudder that is positive to "
        f"{record.meta.positive_rudder}; check positive_rudder"
    )


def _read(path: str | Path, positive_rudder: str | None, model: Model) -> Record:
    """A record whose rudder has the model's sign, freed of what the model knows of its instruments.

    One that does not say its sign is taken to have the model's.
    """
    return corrected(read_record(path, positive_rudder).turned(model.positive_rudder), model.instruments)


def _yaw_rate(record: Record) -> np.ndarray:
    if record.has(CHANNELS["r"]):
        return record.column(CHANNELS["r"])
    return np.gradient(record.heading_unwrapped(), record.time_s)


def _integral(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    steps = np.diff(time) * (values[1:] + values[:-1]) / 2.0
    return np.concatenate([[0.0], np.cumsum(steps)])


def _least_squares(columns: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """First coefficient and sum of squared residuals."""
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(solution[0]), float(np.sum((values - columns @ solution) ** 2))
