"""How far heading can be trusted: the standard deviation of heading after a time, and its scale from left-out records.

    sigma^2(t) = s^2 [ walk^2(min(t, t_w)) max(1, t / t_w) + (drift t)^2 ]

walk : heading errors of left-out windows of length t_w, which grow like a random walk beyond;  drift : yaw rate by
which records differ, the spread of their own neutral angles through the model.  Both are known of few records, and free
runs bring what neither knows.  Therefore every training record is predicted by a fit to the others, and compared with
the band of that fit.  With z_i^2, the mean square of record i's errors over its band,

    s^2 = (PRIOR + sum_i z_i^2) / (PRIOR + R) :

the band without calibration counts as PRIOR records.  The band holds NORMAL_68 of the errors of a further record as
Student's distribution of PRIOR + R degrees of freedom has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import t as student

from ...estimation.diagnosis_only.windows.problem import mean_of_known
from ...estimation.records.naming import named
from ...estimation.validation.validate import validate
from ...models.errors import BadInput
from .ladder import OWN_ANGLE, Attempt, Ladder, model_of
from .result import Band

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

NORMAL_68, PRIOR = 0.683, 4.0
PLACES = 8
"""Times of a record at which its heading error is compared with the band."""


def heading_band(
    ladder: Ladder, final: Attempt, model: Model, train: Sequence[Record], held_out: Sequence[Record],
    times_s: Sequence[float],
) -> tuple[tuple[Band, ...], float]:  # fmt: skip
    """The heading band after the times ahead and after one and two minutes, and the share of held-out errors inside."""
    w = final.fitted.windows
    every, squares = np.unique(w.record), []
    for number in every.tolist() if every.size > 1 else []:
        others = replace(final, fitted=ladder.fitted_to(final, w.record != number))
        found = _ratios(ladder, others, model_of(ladder, others), train[number], np.setdiff1d(every, number))
        squares += [float(np.mean(found**2))] if found.size else []
    wider, after = _scale(squares), np.array([*times_s, 60.0, 120.0])
    sd = wider * _spread(ladder, final, after, every)
    outer = np.concatenate([np.zeros(0), *(_ratios(ladder, final, model, r, every) for r in held_out)])
    inside = float(np.mean(outer <= wider)) if outer.size else float("nan")
    return tuple(Band(*both) for both in zip(after.tolist(), sd.tolist(), strict=True)), inside


def _spread(ladder: Ladder, of: Attempt, after_s: np.ndarray, records: np.ndarray) -> np.ndarray:
    """The band without calibration, rad, after times (K,), of the records whose numbers are given."""
    w = of.fitted.windows
    walk = np.sqrt(mean_of_known(of.errors[: len(of.errors) // 2, :, 1] ** 2, 0))
    at = np.asarray(after_s) / w.dt
    known = np.flatnonzero(np.isfinite(walk))
    inside = np.interp(at, known, walk[known]) if known.size else np.zeros(at.shape)
    inside = inside * np.sqrt(np.maximum(at / (w.inputs.shape[1] - 1), 1.0))
    return np.hypot(inside, _drift(ladder, of, records) * np.asarray(after_s))


def _drift(ladder: Ladder, of: Attempt, records: np.ndarray) -> float:
    """Yaw rate, rad/s, by which a further record drifts."""
    shifts, n = of.fitted.shifts[records], records.size
    sd = OWN_ANGLE * ladder.craft.scales.rudder
    if n > 1:
        sd = float(np.sqrt(np.sum(shifts**2) / (n - 1.0) * (1.0 + 1.0 / n)))
    w = of.fitted.windows
    moved = np.stack([np.full(len(w.inputs), side * sd) for side in (0.0, 1.0)])
    both = w.errors(np.stack([of.fitted.coefficients] * 2), moved).reshape(2, len(w.inputs), -1, 2)
    return float(mean_of_known(np.abs(both[1, :, -1, 0] - both[0, :, -1, 0]), 0))


def _ratios(ladder: Ladder, of: Attempt, model: Model, record: Record, records: np.ndarray) -> np.ndarray:
    """Heading errors of a free run over the band without calibration, at PLACES times of a record without a gap."""
    try:
        told = validate({"": model}, named([record]), ahead=False)
    except BadInput:
        return np.zeros(0)
    measured, run = told.records[0], told.runs[0]
    if "heading_rad" not in run.predicted or "heading_rad" not in measured.channels or len(run.starts_s) > 1:
        return np.zeros(0)
    since = measured.time_s - float(np.ravel(run.starts_s)[0])
    places = np.linspace(0, since.size - 1, PLACES + 1).astype(int)[1:]
    error = (run.predicted["heading_rad"] - measured.channels["heading_rad"])[places]
    found = np.abs(error) / _spread(ladder, of, since[places], records)
    return found[np.isfinite(found)]


def _scale(squares: Sequence[float]) -> float:
    """What the band is multiplied by.  squares : z_i^2 of the training records."""
    known = PRIOR + len(squares)
    wider = float(student.ppf(0.5 + 0.5 * NORMAL_68, known))
    return wider * float(np.sqrt((PRIOR + np.sum(squares)) / known))
