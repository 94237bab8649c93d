"""What can be said of a model that was built: the verdict with its sentence, and how far heading can be trusted, the
standard deviation of heading after a time with its scale from left-out records.

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
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import student_quantile
from ...estimation.records.naming import named
from ...estimation.selection.score import share_of_errors
from ...estimation.validation.horizons import better_at
from ...estimation.validation.validate import label, validate
from ...models.errors import BadInput
from ..causes.base import NORMAL_90
from .problem import COMMON
from .records import COPIED, EXCITED
from .result import ADEQUATE, BUILT, FOLLOWS, INCONCLUSIVE, NO_EFFECT, PARTLY, UNEXPLAINED, Band
from .windows import mean_of_known

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ...datasets.record import Record
    from ...estimation.validation.result import Validation
    from ...models.model import Model
    from .ladder import Attempt, Steering


GOOD, FAIR = 0.7, 0.6
"""R2 of an adequate model over left-out windows, and along records three lengths ahead."""
NEAR = 3
"""Times ahead, .5, 1.5 and 3 lengths, at which structures are compared along held-out records: further ahead the
neutral angle of the record decides, which none of them knows."""
CLEAR, LIKELY, SURE, SHOWN = 0.3, 3.0, 6.0, 2.0
"""The steering acts where left-out errors fall by more than CLEAR and LIKELY standard errors, or by SURE of them, below
those of a craft that it does not turn; SHOWN of them are enough where it is clear from the yaw rate alone (SKILLED);
below SHOWN it is not what turns the craft.  A column that has nothing to do with the motion, but about its period, was
seen to bring .2 and 3.1 standard errors."""


HARDLY = 0.3
"""Share of the yaw motion (rms) below which, at the end of its 90 % interval, the steering is told to act hardly."""
SKILLED = 0.2
"""R2 of the yaw rate of left-out windows above which, where its 90 % interval is above zero, the steering acts."""


def r2(attempt: Attempt) -> tuple[float, float]:
    """Shares of the motion (yaw rate, heading from the window's start) of left-out windows, by fits without
    them; nan where a channel is not measured or does not vary."""
    motion = attempt.problem.windows.motion
    motion = np.where(motion > 0.0, motion, np.nan)
    share = 1.0 - mean_of_known(attempt.left_out**2, (0, 1)) / motion**2
    return float(share[0]), float(share[1])


def verdict_of(final: Attempt, acts: Steering, ahead: Validation, copied: float, motion: float) -> tuple[str, str]:
    """The verdict, and the sentence that supports it.  acts : what the steering brings to left-out predictions."""
    shares = dict(zip(("the yaw rate", "the change of heading"), r2(final), strict=True))
    known = {name: share for name, share in shares.items() if not np.isnan(share)}
    explained = " and ".join(f"{_percent(share)} of {name}" for name, share in known.items())
    said = f"in left-out windows of {final.problem.windows.length_s:.3g} s the model explains {explained}"
    if copied > COPIED:
        share = _percent(copied)
        return FOLLOWS, f"heading and yaw rate of the same moment give {share} of the steering: it follows the motion"
    if not _acts(acts):
        return _without_steering(acts, motion, said)
    trusted = ahead.trusted_s[BUILT]
    if not trusted > 0.0:
        return _not_at_once(known, better_at(ahead.scores, ahead.simple, BUILT), said)
    along = _along(ahead)
    if min(known.values(), default=np.nan) >= GOOD and not along < FAIR:
        return ADEQUATE, said
    if along < FAIR:
        said += f", but along whole records {_percent(along)} of the yaw rate three lengths ahead"
    return PARTLY, f"{said}; up to {trusted:.3g} s ahead it is better than a constant rate of turn or heading"


def _acts(acts: Steering) -> bool:
    """Whether the steering turns the craft: by the fall of the errors, or by a smaller one and a skill of its own."""
    enough = SHOWN if acts.skill > max(SKILLED, NORMAL_90 * acts.spread) else LIKELY
    return acts.gain > min(max(CLEAR, enough * acts.error), SURE * acts.error)


def _not_at_once(known: Mapping[str, float], better: Mapping[float, bool], said: str) -> tuple[str, str]:
    """The verdict where a simple prediction is as good at the shortest time ahead."""
    first = next((time for time, is_better in better.items() if is_better), None)
    if first is None or not min(known.values(), default=np.nan) >= GOOD:
        return UNEXPLAINED, f"{said}; it predicts no better than a constant rate of turn or heading"
    return (
        PARTLY,
        f"{said}; only from {first:.3g} s ahead on it is better than a constant rate of turn or heading",
    )


def _without_steering(acts: Steering, motion: float, said: str) -> tuple[str, str]:
    """The verdict where it is not clear that the steering turns the craft."""
    if motion < EXCITED:
        return (
            INCONCLUSIVE,
            f"the smooth yaw motion is {motion:.2g} times what noise and waves make: no manoeuvre shows",
        )
    smaller = " ± ".join(map(_percent, share_of_errors(acts.gain, acts.error))) + " smaller"
    told = f"with it errors are {smaller} than of a craft that it does not turn; {said}"
    if acts.gain > SHOWN * acts.error:
        return UNEXPLAINED, f"that the recorded rudder or command turns the craft is not beyond doubt: {told}"
    if acts.skill > max(SKILLED, NORMAL_90 * acts.spread):
        return (
            UNEXPLAINED,
            f"the recorded rudder or command acts; what form its effect has these records do not tell: {told}",
        )
    if acts.most < HARDLY:
        most = f"at most {_percent(acts.most)} of the yaw motion follows the recorded rudder or command"
        return NO_EFFECT, f"{most}, something else turns the craft: {told}"
    return UNEXPLAINED, f"whether the recorded rudder or command turns the craft these records do not tell: {told}"


def _along(ahead: Validation) -> float:
    """R2 of the yaw rate three lengths ahead, or as far as was tried; nan where it was not measured."""
    times = ahead.horizons_s[:NEAR]
    score = ahead.score("yaw_rate_rad_s", BUILT, horizon=label(times[-1])) if times else None
    return np.nan if score is None else score.r2


def _percent(share: float) -> str:
    return f"{100.0 * max(share, 0.0):.0f} %"


NORMAL_68, PRIOR = 0.683, 4.0
PLACES = 8
"""Times of a record at which its heading error is compared with the band."""


def heading_band(
    final: Attempt, train: Sequence[Record], held_out: Sequence[Record], times_s: Sequence[float]
) -> tuple[tuple[Band, ...], float]:  # fmt: skip
    """The heading band after the times ahead and after one and two minutes, and the share of held-out errors inside."""
    after, records = np.array([*times_s, 60.0, 120.0]), np.unique(final.problem.windows.record)
    squares = []
    for k, number in enumerate(records.tolist() if records.size > 1 else []):
        model = final.model(final.by_record.without[k])
        found = _ratios(final, model, train[number], np.setdiff1d(records, number))
        squares += [float(np.mean(found**2))] if found.size else []
    wider = _scale(squares)
    sd, model = wider * _spread(final, after, records), final.model()
    outer = np.concatenate([np.zeros(0), *(_ratios(final, model, r, records) for r in held_out)])
    inside = float(np.mean(outer <= wider)) if outer.size else float("nan")
    return tuple(Band(*both) for both in zip(after.tolist(), sd.tolist(), strict=True)), inside


def _spread(of: Attempt, after_s: np.ndarray, records: np.ndarray) -> np.ndarray:
    """The band without calibration, rad, after times (K,), of the records whose numbers are given."""
    windows = of.problem.windows
    walk = np.sqrt(mean_of_known(of.problem.left_out(of.with_angles)[:, :, 1] ** 2, 0))
    at = np.asarray(after_s) / windows.dt
    known = np.flatnonzero(np.isfinite(walk))
    inside = np.interp(at, known, walk[known]) if known.size else np.zeros(at.shape)
    inside = inside * np.sqrt(np.maximum(after_s / windows.length_s, 1.0))
    return np.hypot(inside, _drift(of, records) * np.asarray(after_s))


def _drift(of: Attempt, records: np.ndarray) -> float:
    """Yaw rate, rad/s, by which a further record drifts."""
    own, n, sd = of.own_angles[records], records.size, of.ladder.own_angle
    if n > 1:
        sd = float(np.sqrt(np.sum(own**2) / (n - 1.0) * (1.0 + 1.0 / n)))
    values, windows = of.fitted.point.values, of.problem.windows
    moved = {**values, COMMON: values[COMMON] + sd}
    both = windows.errors([of.problem.lane(values), of.problem.lane(moved)]).reshape(2, *windows.known.shape)
    return float(np.mean(np.abs(both[1, :, -1, 0] - both[0, :, -1, 0])))


def _ratios(of: Attempt, model: Model, record: Record, records: np.ndarray) -> np.ndarray:
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
    found = np.abs(error) / _spread(of, since[places], records)
    return found[np.isfinite(found)]


def _scale(squares: Sequence[float]) -> float:
    """What the band is multiplied by.  squares : z_i^2 of the training records."""
    known = PRIOR + len(squares)
    wider = student_quantile(0.5 + 0.5 * NORMAL_68, known)
    return wider * float(np.sqrt((PRIOR + np.sum(squares)) / known))
