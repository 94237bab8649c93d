"""From records of a craft to a model: the ladder, its guards, the model in the fewest terms, and what can be said."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import RUDDERS
from ...estimation.fit import arithmetic_guard, blas_limited
from ...estimation.naming import named
from ...estimation.validation.horizons import STRAIGHT, mean_ratio
from ...estimation.validation.validate import label, validate
from ...estimation.windows.fit import covariance_of
from ...estimation.windows.problem import mean_of_known, pieces_of, scales_of
from ...models.errors import BadInput
from ...models.instruments import INSTRUMENTS
from ...models.time_scale import OWN_TIME
from ..causes.base import NORMAL_90
from ..gain.guard import WORSE
from .band import ratios, scale, spread
from .ladder import OWN_ANGLE, Attempt, Climb, Ladder, Step, climb, steering
from .own_speed import numbers_of, with_own_speed
from .records import COPIED, EXCITED, copied_input, craft_of, outside, weak_motion, without_spikes
from .result import (
    ADEQUATE,
    BUILT,
    FIRST,
    FOLLOWS,
    INCONCLUSIVE,
    NO_EFFECT,
    OUTSIDE,
    OWN_SPEED,
    PARTLY,
    SHIP,
    UNEXPLAINED,
    Band,
    CraftDiagnosis,
    LawTold,
    NumberTold,
    Rise,
)
from .rungs import NEUTRAL, TURNS
from .ship import corrected

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.validation.result import Validation
    from ...models.model import Model

SLACK = 0.05
"""Rise of the errors of left-out records that a step may bring and still stand."""
GOOD, FAIR = 0.7, 0.6
"""R2 of an adequate model over left-out windows, and along records three lengths ahead."""
NEAR = 3
"""Times ahead, .5, 1.5 and 3 lengths, at which structures are compared along held-out records: further ahead the
neutral angle of the record decides, which none of them knows."""
LOST = 0.1
"""R2 of the yaw rate that a surge of its own may lose: where nothing was recorded of the thrust, it is far more."""
CLEAR, LIKELY, SURE, SHOWN = 0.3, 3.0, 6.0, 2.0
"""The steering acts where left-out errors fall by more than CLEAR and LIKELY standard errors, or by SURE of them, below
those of a craft that it does not turn; below SHOWN it is not what turns the craft.  A column that has nothing to do
with the motion, but about its period, was seen to bring .2 and 3.1 standard errors."""


def build(train: Sequence[Record], held_out: Sequence[Record] = (), ship: Model | None = None) -> CraftDiagnosis:
    """Build a model of a craft from its records alone, or beside a simulation of its particulars.

    Parameters
    ----------
    train, held_out : records with rudder or command, and heading or yaw rate; held-out records take no part in the
        choice but for one guard: the model that is returned is not worse along them than the chosen law alone.
    ship : a simulation of surge, sway and yaw (`models/particulars.py`); it is corrected by the training records and
        judged beside the model that is built.

    Raises
    ------
    BadInput : no training record, or a ship that has no surge and sway or no numbers.
    CannotFit : the records hold no yaw motion, the rudder or command never moves, or all stretches are too short.
    """
    if not train:
        raise BadInput("no training record", hint="give at least one")
    if ship is not None and not (ship.is_3dof and ship.known):
        raise BadInput(
            f"model {ship.id} is no simulation of surge, sway and yaw", hint="give a YAML file of particulars"
        )
    with arithmetic_guard(), blas_limited():
        cleaned = [without_spikes(r.turned("starboard")) for r in (*train, *held_out)]
        spikes = [f"{r.name}: {n} samples that stand out of their neighbours are left out." for r, n in cleaned if n]
        records = [r for r, _ in cleaned]
        return _built(records[: len(train)], records[len(train) :], ship, spikes)


def _built(
    train: Sequence[Record], held_out: Sequence[Record], ship: Model | None, spikes: Sequence[str]
) -> CraftDiagnosis:
    started = time.perf_counter()
    scales = scales_of(train)
    pieces = pieces_of(train, scales)
    craft, given = craft_of([*train, *held_out], scales)
    ladder = Ladder(pieces, craft, given, commands=not all(r.has(RUDDERS[0]) for r in train))
    found = climb(ladder)
    kept = _guarded(ladder, found, [*train, *held_out])
    simulation, told = (None, []) if ship is None else corrected(ship, train)
    speed = numbers_of(train, scales.time_s, TURNS in given)
    kept, model, ahead, notes = _judged(ladder, kept, train, held_out, simulation, speed)
    notes = [*spikes, *_notes(train, held_out, len(kept) < len(found.steps)), *told, *notes]
    final = kept[-1].attempt
    covariance = _covariance(ladder, final, model)
    copied = copied_input(pieces)
    verdict, reason = _verdict(final, steering(ladder, final), ahead, copied, weak_motion(pieces))
    if verdict in (UNEXPLAINED, PARTLY) and max(r2(final)) >= GOOD and any(outside(train, r) for r in held_out):
        verdict = OUTSIDE
        reason = f"held-out records leave the range of the training records, where {reason}"
    band, inside = _heading(ladder, final, model, train, held_out, ahead.horizons_s)
    roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
    return CraftDiagnosis(
        model=model, first=model_of(ladder, kept[0].attempt), ship=simulation,
        own_speed=ahead.models.get(OWN_SPEED), records=tuple(roles),
        verdict=verdict, reason=reason, window_s=_window(final),
        laws=_laws(found, kept[0].attempt), steps=tuple(map(_rise, kept)), numbers=_numbers(model, covariance),
        refused=found.refused, band=band, inside=inside,
        own_angles=tuple((r.name, float(s)) for r, s in zip(train, final.fitted.shifts, strict=True)),
        ahead=ahead, trusted_s=ahead.trusted_s[BUILT], next_runs=_next(found, kept, given), notes=tuple(notes),
        wall_s=time.perf_counter() - started, covariance=covariance,
    )  # fmt: skip


def _judged(
    ladder: Ladder, kept: list[Step], train: Sequence[Record], held_out: Sequence[Record], ship: Model | None,
    speed: dict[str, float],
) -> tuple[list[Step], Model, Validation, list[str]]:  # fmt: skip
    """The steps that stand along held-out records, their model, the errors ahead of it and of what stands beside it."""
    judged, notes = named(list(held_out) or list(train)), list[str]()

    def ahead_of(model: Model) -> Validation:
        given = {BUILT: model, FIRST: first} | ({} if ship is None else {SHIP: ship})
        own = with_own_speed(model, speed) if speed else None
        if own is not None and _bounded(own, [*train, *held_out]):
            both = validate(given | {OWN_SPEED: own}, judged)
            if _told_by_speed(both):
                return both
        return validate(given, judged)

    first, model = (model_of(ladder, step.attempt) for step in (kept[0], kept[-1]))
    ahead = ahead_of(model)
    near = max(ahead.horizons_s[:NEAR])
    if len(kept) > 1 and held_out and mean_ratio(ahead.scores, BUILT, FIRST, near) > WORSE:
        notes.append("Held-out records are predicted worse with all that entered: the steering law alone is the model.")
        kept, model = kept[:1], first
        ahead = ahead_of(model)
    if mean_ratio([*ahead.scores, *ahead.simple], BUILT, STRAIGHT) > 1.0:
        notes.append("No better than a craft that goes straight: the steering of the model is set to zero.")
        model = _unsteered(model)
        ahead = ahead_of(model)
    ratio = mean_ratio(ahead.scores, SHIP, BUILT)
    if ship is not None and np.isfinite(ratio):
        more = f"{abs(ratio - 1.0):.0%} {'larger' if ratio > 1.0 else 'smaller'}"
        notes.append(f"The simulation of the particulars has errors of heading and yaw rate ahead that are {more}.")
    return kept, model, ahead, notes


def model_of(ladder: Ladder, attempt: Attempt) -> Model:
    """The fitted model with the extensions of its rungs only."""
    extensions = [r.extension for r in (NEUTRAL, *attempt.rungs) if r.extension is not None]
    blank = ladder.blank("+".join([attempt.law.family, *extensions]))
    whole = dict(zip(attempt.fitted.windows.model.coordinates, attempt.fitted.coefficients.tolist(), strict=True))
    return replace(
        blank, id="craft", title=attempt.law.title, coefficients=np.array([whole[n] for n in blank.coordinates]),
        instruments=dict(attempt.linkage), source="built from records",
        particulars={OWN_TIME: ladder.craft.scales.time_s},
    )  # fmt: skip


def r2(attempt: Attempt) -> tuple[float, float]:
    """Shares of the motion (yaw rate, heading from the window's start) of left-out windows, by fits without them and
    without the record's own neutral angle."""
    w = attempt.fitted.windows
    share = 1.0 - mean_of_known(attempt.errors[len(w.inputs) :] ** 2, (0, 1)) / w.motion**2
    return float(share[0]), float(share[1])


def _guarded(ladder: Ladder, found: Climb, records: Sequence[Record]) -> list[Step]:
    """The steps up to the last that predicts left-out records no worse than any before, and whose free runs of all
    records stay within bounds."""
    scores = [_left_out_records(ladder, step.attempt) for step in found.steps]
    for last in reversed(range(len(found.steps))):
        steady = all(_rise_of(scores[last], before) <= SLACK for before in scores[:last])
        if last == 0 or (steady and _bounded(model_of(ladder, found.steps[last].attempt), records)):
            return list(found.steps[: last + 1])
    return list(found.steps[:1])


def _rise_of(new: np.ndarray, old: np.ndarray) -> float:
    """Mean rise of the logarithms (R, 2) of errors; no record counts with more than a factor of two."""
    return float(np.nan_to_num(mean_of_known(np.clip(new - old, -np.log(2.0), np.log(2.0)), (0, 1))))


def _left_out_records(ladder: Ladder, a: Attempt) -> np.ndarray:
    """Log root mean square errors (R, 2) of whole records, each predicted by a fit to the others; of one none."""
    w, total = a.fitted.windows, []
    for record in range(w.n_records):
        mine = w.record == record
        if not mine.any() or mine.all():
            continue
        others = ladder.fitted_to(a, ~mine)
        error = w.of(mine).errors(others.coefficients[None], np.zeros((1, int(mine.sum()))))
        total.append(0.5 * np.log(mean_of_known(error**2, (0, 1)) + (1e-3 * w.motion) ** 2))
    return np.array(total).reshape(-1, 2)


def _bounded(model: Model, records: Sequence[Record]) -> bool:
    """Whether no free run along any record diverges."""
    try:
        found = validate({BUILT: model}, named(records), ahead=False)
    except BadInput:
        return False
    return not any(run.diverged for run in found.runs)


def _unsteered(model: Model) -> Model:
    """The model with its linear damping alone."""
    kept = [value if name in ("a", "a1", "lead_T2") else 0.0 for name, value in _values(model).items()]
    return replace(model, coefficients=np.array(kept), instruments={})


def _values(model: Model) -> dict[str, float]:
    return dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))


def _laws(found: Climb, first: Attempt) -> tuple[LawTold, ...]:
    return tuple(
        LawTold(
            a.law.id, a.law.title, gain, error, *r2(a), a.law is first.law, a.law is not first.law and -gain <= error
        )
        for a, gain, error in found.laws
    )


def _rise(step: Step) -> Rise:
    return Rise(step.id, step.title, step.gain, step.error, *r2(step.attempt), step.attempt.count)


def _numbers(model: Model, covariance: np.ndarray) -> tuple[NumberTold, ...]:
    """The published parameters with intervals, and the numbers between order and hull, which are known within a
    tenth."""
    slopes = model.parameters_jacobian(model.coefficients)
    spread = NORMAL_90 * np.sqrt(np.abs(np.einsum("ij,jk,ik->i", slopes, covariance, slopes)))
    values = zip(model.parameters.items(), model.parameter_units, spread.tolist(), strict=True)
    own = [
        NumberTold(name, "N" if _by_thrust(model, name) else unit, value, value - half, value + half)
        for (name, value), unit, half in values
    ]
    units = {name: INSTRUMENTS[name] for name in model.instruments}
    return (*own, *(NumberTold(n, units[n], v, v / 1.1, v * 1.1) for n, v in model.instruments.items()))


def _by_thrust(model: Model, name: str) -> bool:
    """Whether a number is an order that is told in N."""
    return name == "rudder_offset" and model.family.startswith("twin-thrusters")


def _covariance(ladder: Ladder, final: Attempt, model: Model) -> np.ndarray:
    """(p, p) of the model's coefficients, zero for those that were not free."""
    every = covariance_of(final.fitted, OWN_ANGLE * ladder.craft.scales.rudder)
    places = [model.coordinates.index(n.name) for n in final.fitted.numbers]
    out = np.zeros((len(model.coordinates),) * 2)
    out[np.ix_(places, places)] = every
    return out


def _verdict(
    final: Attempt, acts: tuple[float, float], ahead: Validation, copied: float, motion: float
) -> tuple[str, str]:
    """The verdict, and the sentence that supports it.  acts : fall of the errors by the steering, standard error."""
    rate, heading = r2(final)
    rate, heading = (heading if np.isnan(rate) else rate), (rate if np.isnan(heading) else heading)
    said = f"over {_window(final):.3g} s of left-out windows it explains {_percent(rate)} of the yaw rate"
    said += f" and {_percent(heading)} of the change of heading"
    if copied > COPIED:
        share = _percent(copied)
        return FOLLOWS, f"heading and yaw rate of the same moment give {share} of the steering: it follows the motion"
    gain, error = acts
    if not gain > min(max(CLEAR, LIKELY * error), SURE * error):
        return _without_steering(gain, error, motion, said)
    trusted = ahead.trusted_s[BUILT]
    if not trusted > 0.0:
        return UNEXPLAINED, f"{said}; it predicts no better than a craft that goes on turning, or straight"
    along = _along(ahead)
    if min(rate, heading) >= GOOD and not along < FAIR:
        return ADEQUATE, f"{said}; trust it for {trusted:.3g} s"
    if along < FAIR:
        said += f", but along the records that it is judged by {_percent(along)} of the yaw rate three lengths ahead"
    return PARTLY, f"{said}; up to {trusted:.3g} s ahead it is better than going on turning, or straight"


def _without_steering(gain: float, error: float, motion: float, said: str) -> tuple[str, str]:
    """The verdict where it is not clear that the steering turns the craft."""
    if motion < EXCITED:
        return (
            INCONCLUSIVE,
            f"the smooth yaw motion is {motion:.2g} times what noise and waves make: no manoeuvre shows",
        )
    told = (
        f"with it errors are {_percent(gain)} ± {_percent(error)} smaller than of a craft that it does not turn; {said}"
    )
    if gain > SHOWN * error:
        return UNEXPLAINED, f"that the recorded rudder or command turns the craft is not beyond doubt: {told}"
    return NO_EFFECT, f"the recorded rudder or command is not what turns the craft: {told}"


def _told_by_speed(ahead: Validation) -> bool:
    """Whether surge is predicted better than by its mean, and the yaw rate nearly as well as with the measured speed,
    three lengths ahead."""
    horizon = label(ahead.horizons_s[:NEAR][-1])
    surge, own = (ahead.score(c, OWN_SPEED, horizon=horizon) for c in ("surge_m_s", "yaw_rate_rad_s"))
    built = ahead.score("yaw_rate_rad_s", BUILT, horizon=horizon)
    return bool(surge and own and built and surge.r2 > 0.0 and own.r2 > built.r2 - LOST)


def _along(ahead: Validation) -> float:
    """R2 of the yaw rate three lengths ahead, or as far as was tried; nan where it was not measured."""
    times = ahead.horizons_s[:NEAR]
    score = ahead.score("yaw_rate_rad_s", BUILT, horizon=label(times[-1])) if times else None
    return np.nan if score is None else score.r2


def _percent(share: float) -> str:
    return f"{100.0 * max(share, 0.0):.0f} %"


def _window(a: Attempt) -> float:
    return a.fitted.windows.dt * (a.fitted.windows.inputs.shape[1] - 1)


def _heading(
    ladder: Ladder, final: Attempt, model: Model, train: Sequence[Record], held_out: Sequence[Record],
    times_s: Sequence[float],
) -> tuple[tuple[Band, ...], float]:  # fmt: skip
    """The heading band after the times ahead and after one and two minutes, and the share of held-out errors inside."""
    w = final.fitted.windows
    every, squares = np.unique(w.record), []
    for number in every.tolist() if every.size > 1 else []:
        others = replace(final, fitted=ladder.fitted_to(final, w.record != number))
        found = ratios(ladder, others, model_of(ladder, others), train[number], np.setdiff1d(every, number))
        squares += [float(np.mean(found**2))] if found.size else []
    wider, after = scale(squares), np.array([*times_s, 60.0, 120.0])
    sd = wider * spread(ladder, final, after, every)
    outer = np.concatenate([np.zeros(0), *(ratios(ladder, final, model, r, every) for r in held_out)])
    inside = float(np.mean(outer <= wider)) if outer.size else float("nan")
    return tuple(Band(*both) for both in zip(after.tolist(), sd.tolist(), strict=True)), inside


def _notes(train: Sequence[Record], held_out: Sequence[Record], shortened: bool) -> list[str]:
    notes = []
    if shortened:
        notes.append("Steps that predict left-out records worse, or whose free runs leave all bounds, were taken back.")
    for record in held_out:
        where = outside(train, record)
        notes += [f"{record.name} is outside what the training records show: {', '.join(where)}."] if where else []
    return notes


def _next(found: Climb, kept: Sequence[Step], given: frozenset[str]) -> str:
    """What to record next."""
    tied = [a.law.id for a, gain, error in found.laws if gain < 0.0 and -gain <= error]
    wanted = (
        ["runs at two speeds that differ by half, which tell what steers the craft"]
        if tied and "speed" in given
        else []
    )
    wanted += [] if "speed" in given else ["the speed, or positions"]
    wanted += ["a straight leg of a minute before each manoeuvre, which tells the neutral angle"]
    return "; ".join(wanted)
