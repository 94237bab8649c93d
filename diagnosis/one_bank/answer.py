"""What the choice says: findings with sizes, the lines of the bank, the extended model, the verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ...checks.base import SensorError
from ...checks.result import Size
from ...checks.tails import chi2_tail, half_of_mean, student_tail
from ...estimation.selection.score import share_of_errors
from ...estimation.selection.selection import independent
from ...models.coefficient_groups import grown, stated_groups, with_values
from ...models.extend import extended
from ...models.families.extensions import OFFSET, extension_of
from ...models.instruments import combined
from ..causes.base import Cause
from ..causes.base_coefficients import BaseCoefficients
from ..causes.missing_terms import MissingTerm
from ..causes.noise import WaveMotion
from ..causes.registry import causes
from ..causes.surroundings import PairCause, WaveDrift, Wind
from ..report.bank import BY_CHANNELS, BY_FREE_RUNS, lines, of_channels
from ..report.verdict import NAMED, PARTLY, of_motion
from ..result import BESIDE, CHANGE, Entry, Finding
from .catalogue import FAULT, FLOWS, SIDES, every_term, flow_name
from .search import LARGE, SMALL, flow_speeds, half_intervals, main_number

if TYPE_CHECKING:
    from ...checks.base import Check
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Candidate
    from ...estimation.selection.selection import Entered
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns
    from .search import Choice

ASSUMED = "the base model states no areas above water: the speed of the wind is that on a usual ship of her length"
NOTHING = 0.001
"""Error of left-out pieces beyond the sensors' noise, as a share of the motion, below which none is told."""
OTHER_SHIP, MANY = 2.0, 9
"""Prior standard deviations (rms) by which all numbers of a model of more than MANY move, from which it may be of
another ship: those of a tanker moved by 2.4 to follow another tanker, by .7 to follow her own records."""
APART, SEVERAL = 3.0, 3
"""Factor between the errors of records of which some are told apart, and records from which that is looked at."""


def findings(choice: Choice, identified: bool) -> list[Finding]:
    """A finding for every cause, in the order in which candidates entered; all groups of numbers in one.

    identified : the records have decided on the model's own numbers, which are no finding then.
    """
    by_cause: dict[str, list[Entered]] = {}
    for one in choice.selection.entered:
        by_cause.setdefault(choice.bank.cause_of(one.candidate), []).append(one)
    out = [_finding(choice, cause, own) for cause, own in by_cause.items()]
    if choice.beside and not identified:
        out.append(_all_numbers(choice))
    return out


def _all_numbers(choice: Choice) -> Finding:
    """That all of the model's own numbers are uncertain, and the few that alone explain most."""
    taken = choice.runs.share_taken(choice.selection.base, choice.selection.final)
    said = "all of the model's own numbers, uncertain under their priors, are needed to predict left-out pieces"
    said += f": with them and all that is named {100.0 * taken:.0f} % of the squared error is taken off"
    main, details = main_number(choice), {"numbers": _moves(choice)}
    if main is None:
        return Finding(BaseCoefficients.id, (), BY_FREE_RUNS, None, None, (), details=details, evidence=said)
    alone, share = main
    one = _finding(replace(choice, selection=alone, few=None), BaseCoefficients.id, alone.entered)
    titles = ", ".join(one.details["groups"])
    part = f"takes {100.0 * share:.0f} % of what" if share < 1.0 else "takes no less than"
    said += f"; {titles} alone {part} they take off the squared error"
    return replace(one, details={**one.details, BESIDE: "all of the model's own numbers"}, evidence=said)


def doubts_of(choice: Choice) -> Iterator[str]:
    """That the model may be of another ship, where all its numbers are needed and move far beyond their priors; that
    the measured wind may be told the other way round, where it acts against its direction."""
    final, bank = choice.selection.final, choice.bank
    moves = [final.value(n.name) / n.sd for n in bank.own] if choice.beside else []
    far = float(np.sqrt(np.mean(np.square(moves)))) if moves else 0.0
    if len(moves) > MANY and far > OTHER_SHIP:
        said = f"the numbers of the model move by {far:.1f} of their prior standard deviations (root mean square)"
        yield f"{said}: it may be of another ship, or of this one in another loading, scale or system of units"
    chosen = {n for c in choice.selection.candidates for n in c.names if bank.places[n].kind == "windage"}
    shares = {bank.places[n].entries[0]: bank.wind_share + final.value(n) for n in chosen}
    if all(shares.get(name, 1.0) < 0.0 for name in ("wind_cx", "wind_cy")):
        yield "the wind acts against its measured direction: that may be where it blows to, not where it comes from"


def _moves(choice: Choice) -> dict[str, list[float]]:
    """Number of the model -> its value before and after the joint fit; first what moves furthest for its prior."""
    values, final = choice.bank.values, choice.selection.final
    own = sorted(choice.bank.own, key=lambda n: -abs(final.value(n.name)) / n.sd)
    return {n.name: [values.get(n.name, 0.0), values.get(n.name, 0.0) + final.value(n.name)] for n in own}


def _finding(choice: Choice, cause: str, own: Sequence[Entered]) -> Finding:
    fall = max((one.fall for one in own), key=lambda f: f.gain / max(f.error, 1e-12))
    strength, units = fall.gain / max(fall.error, 1e-12), len(choice.runs.units)
    ratio = chi2_tail(
        2.0 * max(fall.gain, 0.0) * independent(choice.runs, choice.selection.final),
        max(len(one.candidate.names) for one in own),
    )
    p = min(1.0, len(choice.bank.candidates) * min(student_tail(strength, max(units - 1, 1)), float(ratio)))
    rivals = [c for one in own for c in one.tied_with]
    rival_causes = {choice.bank.cause_of(c) for c in rivals} - set(
        map(choice.bank.cause_of, choice.selection.candidates)
    )
    if cause == Wind.id and choice.runs.waves:  # drift by waves is no candidate, and pushes alike
        rival_causes.add(WaveDrift.id)
    details: dict[str, Any] = {}
    if cause == BaseCoefficients.id:
        details["groups"] = list(dict.fromkeys(_title(choice, one.candidate.of) for one in own))
        if alike := [name for one in own for c in one.alike for name in c.names]:
            details["numbers that would do as well"] = alike
    hull = {_title(choice, c.of) for c in rivals if choice.bank.cause_of(c) == BaseCoefficients.id}
    if hull := hull.difference(details.get("groups", ())):
        details["would do as well"] = sorted(hull)
    if isinstance(causes().get(cause), MissingTerm):
        details["components"] = [every_term()[name].name for one in own for name in one.candidate.names]
    kinds = {choice.bank.places[n].kind for one in own for n in one.candidate.names}
    if "windage" in kinds and cause == Wind.id:
        details["assumed"] = ASSUMED if "flow" in kinds else _areas(choice)
    if choice.local is not None and choice.local.size in {n for one in own for n in one.candidate.names}:
        details["regime"] = choice.local.facts
    said = "; ".join(_fall_of_errors(choice, one) for one in own)
    sizes = tuple(size for one in own for size in _sizes(choice, cause, one))
    separate = getattr(causes().get(cause), "separate_by", None) if rival_causes or hull else None
    return Finding(cause, tuple(sorted(rival_causes)), BY_FREE_RUNS, strength, p, sizes, details=details, evidence=said,
                   separate_by=separate)  # fmt: skip


def _fall_of_errors(choice: Choice, one: Entered) -> str:
    """By how much errors fall, as its score is the sum of their logarithms over channels."""
    channels = choice.runs.counts.shape[1]
    fall, error = (100.0 * x for x in share_of_errors(one.fall.gain / channels, one.fall.error / channels))
    return (
        f"with it the errors of left-out pieces fall by {fall:.0f} % (standard error {error:.1f} %, mean over "
        f"{channels} channels of {len(choice.runs.units)} pieces)"
    )


def waves_of(runs: FreeRuns) -> list[Finding]:
    """The motion in waves that free runs show; its sizes by record where there are several."""
    if not runs.waves:
        return []
    sizes, alone = list[Size](), len(runs.record_names) == 1
    for own in runs.waves[:1] if alone else runs.waves:
        mean, half = own.heading_rad
        sizes.append(Size("period", own.period_s, *own.period_interval_s, "s", own.record))
        sizes.append(Size("heading_rms", mean, max(mean - half, 0.0), mean + half, "rad", own.record))
    said = (
        f"errors of free runs have a sharp peak at a period of {runs.waves[0].period_s:.3g} s, which the motion of the "
        "rudder has not"
    )
    return [Finding(WaveMotion.id, (), BY_FREE_RUNS, None, None, tuple(sizes), evidence=said)]


def _title(choice: Choice, of: str) -> str:
    return choice.bank.titles.get(of, of)


# ---- sizes
def _sizes(choice: Choice, cause: str, one: Entered) -> Iterator[Size]:
    """Sizes of the numbers of a candidate with 90 % intervals."""
    fitted = choice.selection.final
    halves = half_intervals(choice.runs, fitted, choice.beside)
    entry = causes().get(cause)
    if isinstance(entry, PairCause):
        yield from _flow_sizes(choice, entry, one)
        if any(choice.bank.places[name].kind == "flow" for name in one.candidate.names):
            return
    values = model_values(choice)
    for name in one.candidate.names:
        place, value, half = choice.bank.places[name], fitted.value(name), halves.get(name, 0.0)
        if choice.local is not None and name == choice.local.size:
            number = choice.local.number.name
            yield Size(f"{CHANGE}{number} {choice.local.words}", value, value - half, value + half,
                       "rad" if number == OFFSET else "1")  # fmt: skip
            continue
        if place.kind == "model":
            yield Size(name, values[name], values[name] - half, values[name] + half, "1")
            continue
        if place.kind == "windage":
            (entry_name,), windage = place.entries, choice.bank.windage or {}
            share, unit = choice.bank.wind_share + value, windage[entry_name]
            yield Size(entry_name, unit * share, unit * (share - half), unit * (share + half), "1")
            continue
        ends = (value - half, value + half)
        if place.inverse:
            value, *ends = (1.0 / x if x > 0.0 else np.inf for x in (value, ends[1], ends[0]))
        said, unit = _of_number(cause, entry, name)
        record = None if place.record is None else choice.runs.record_names[place.record]
        yield Size(said, float(value), float(ends[0]), float(ends[1]), unit, record)
        for _, time_s in place.fixed:
            yield Size("t0", time_s, *fault_interval(choice, time_s), "s")


def _of_number(cause: str, entry: Check | None, name: str) -> tuple[str, str]:
    """What a number of a cause is called, and its unit."""
    if (term := every_term().get(name)) is not None:
        return term.name, term.unit
    for effect in entry.together if isinstance(entry, SensorError) else ():
        if name.endswith(f" {effect.parameter}"):
            return effect.parameter, effect.unit
    number = entry.number if isinstance(entry, Cause) else None
    unit = entry.unit.partition(",")[0] if entry else "1"
    unknown = "x" if unit == "m" else "tau"
    return "e" if cause == FAULT else unknown if number is None else number.name, unit


def fault_interval(choice: Choice, time_s: float) -> tuple[float, float]:
    """The times next to that of a fault among those that are tried."""
    every = sorted(t for place in choice.bank.places.values() for _, t in place.fixed)
    at = every.index(time_s)
    return every[max(at - 1, 0)], every[min(at + 1, len(every) - 1)]


def model_values(choice: Choice) -> dict[str, float]:
    """Number of the model -> its value after the fit."""
    return {n: x + choice.selection.final.value(n) for n, x in choice.bank.values.items()}


def _flow_sizes(choice: Choice, flow: PairCause, one: Entered) -> Iterator[Size]:
    """Speed and direction of a steady flow, of all records or of each."""
    fitted, names = choice.selection.final, choice.runs.record_names
    for record, (speed, spread) in flow_speeds(choice, one).items():
        pair = np.array([fitted.value(flow_name(flow.id, side, record)) for side in SIDES])
        y, x = -pair[::-1] if flow.coming_from else pair[::-1]
        direction = float(np.arctan2(y, x))
        turn = min(spread / max(speed, 1e-12), np.pi)
        where = None if record is None else names[record]
        yield Size(flow.size_name, speed, max(speed - spread, 0.0), speed + spread, "m/s", where)
        yield Size(flow.direction_name, direction, direction - turn, direction + turn, "rad", where)


def _areas(choice: Choice) -> str:
    """What the coefficients of the wind force stand on, in words."""
    windage = choice.bank.windage or {}
    areas = f"ahead {windage['A_F']:.3g} m2, of the side {windage['A_L']:.3g} m2"
    return f"wind is measured, and the base model states no areas above water: those of a usual ship, {areas}"


# ---- bank and verdict
def bank_lines(choice: Choice, findings: Sequence[Finding], sensors: Mapping[str, float]) -> tuple[Entry, ...]:
    """One line for every cause of the taxonomy; sensors : statistics of those that the channels have decided on."""
    inside, outside = ({choice.bank.cause_of(c) for c in own} for own in (choice.bank.candidates, choice.bank.outside))

    def otherwise(check: Check) -> Entry:
        if check.id in sensors:
            return of_channels(check.id, sensors, None)
        if check.id in inside:
            why = "free runs of left-out pieces are predicted no better with it"
            return Entry(check.id, "not_significant", None, None, None, why)
        if check.id in outside:
            return Entry(check.id, "not_significant", None, None, None, "whole records are predicted worse with it")
        why = check.stage if not isinstance(check, Cause) else "no candidate for this model and these channels"
        return Entry(check.id, "not_testable", None, None, None, why)

    return lines(findings, map(otherwise, causes().values()))


def verdict(choice: Choice, findings: Sequence[Finding], exact: bool) -> tuple[str, str]:
    """The verdict by what is named and by the errors of left-out pieces, and the sentence that supports it.

    Eq. 13 of docs/mathematics/pieces.md.
    """
    runs, before, after = choice.runs, choice.selection.base, choice.selection.final
    worst = runs.worst(after)
    said = f"free runs of left-out pieces err by {of_motion(worst)}, beyond the sensors' noise"
    if worst < NOTHING:
        said = "free runs of left-out pieces err by no more than the sensors' noise"
    if not findings:
        if worst > LARGE:
            return "unexplained", f"{said}, and no known cause explains it"
        return "adequate", f"{said}: too little for a cause to be told from others" if worst > SMALL else said
    if not choice.selection.entered and not choice.beside:
        aside = ["apart from the motion in waves"] if runs.waves else []
        aside += ["with what is corrected"] if any(f.stage == BY_CHANNELS for f in findings) else []
        return "unexplained" if worst > LARGE else "named", f"{' and '.join(aside)}, {said}"
    share = runs.share_taken(before, after)
    said = f"what is named takes {100.0 * share:.0f} % off the squared error of free runs"
    if not exact and worst > LARGE and share < NAMED:
        return ("partly_named" if share > PARTLY else "unexplained"), said
    ties = [f for f in findings if f.tied_with or "would do as well" in f.details]
    return ("tied" if ties else "named"), said


def apart(choice: Choice) -> tuple[dict[str, float], float]:
    """Records of which errors are left that the others have not, with the choice, or else with the base where the
    choice does not explain the records: name -> error of left-out pieces beyond the noise, as a share of the motion;
    and the largest one of the others."""
    final, base = choice.selection.final, choice.selection.base
    few = _apart(choice.runs, final)
    return few if few[0] or choice.runs.worst(final) <= SMALL else _apart(choice.runs, base)


def _apart(runs: FreeRuns, fitted: Fitted) -> tuple[dict[str, float], float]:
    """The same with one fit.

    Records are sorted by their errors.  Those above a step of a factor APART are apart, where they are at most half of
    all, and their errors matter.
    """
    errors = errors_by_record(runs, fitted)
    names = sorted(errors, key=lambda name: errors[name])
    steps = zip(range(1, len(names)), pairwise(names), strict=True)
    ends = [i for i, (one, other) in steps if is_apart(errors[other], errors[one]) and 2 * i >= len(names)]
    if len(names) < SEVERAL or not ends:
        return {}, 0.0
    return {name: errors[name] for name in names[ends[0] :]}, errors[names[ends[0] - 1]]


def is_apart(error: float, others: float) -> bool:
    """Whether the error of a record matters, and is far larger than those of others."""
    return error > max(SMALL, APART * others)


def errors_by_record(runs: FreeRuns, fitted: Fitted) -> dict[str, float]:
    """Name of a record -> largest error of its left-out pieces beyond the noise, as a share of the motion."""
    numbers, errors = np.array([u.number for u in runs.units]), dict[str, float]()
    for number, name in runs.record_names.items():
        own = np.flatnonzero(numbers == number).tolist()
        squares = fitted.left_out[own].sum(axis=0) / np.maximum(runs.counts[own].sum(axis=0), 1.0)
        errors[name] = float(np.sqrt(np.max(runs.beyond(squares, own))))
    return errors


# ---- the extended model
def extended_model(model: Model, choice: Choice, corrected: Mapping[str, float]) -> Model:
    """The model with all that was chosen, as extensions of its family and as instruments.

    corrected : instruments that were corrected in the records before.
    """
    values = {name: x for name, x in choice.selection.final.point.values.items() if x != 0.0}
    places = choice.bank.places
    moved = {name for name in values if places[name].kind == "model"}
    model = in_wind(model, choice)
    groups = [g for g in stated_groups(model) if g.extension is not None and moved & {*g.sd}]
    out = with_values(grown(model, groups) if groups else model, model_values(choice))
    for cause, own in _outside(choice, values).items():
        known = {n: own.get(n, 0.0) for n in extension_of(cause).units}
        out = extended(out, cause, known)
    numbers: dict[str, float] = {}
    of_records: dict[str, list[float]] = {}
    for name, x in values.items():
        place = places[name]
        for entry in place.entries if place.kind in ("steering", "sensor") else ():
            if place.record is not None:
                of_records.setdefault(entry, []).append(x)
                continue
            numbers[entry] = numbers.get(entry, 0.0) + (1.0 / x if place.inverse else x)
        numbers |= dict(place.fixed)
    for entry, own in of_records.items():
        numbers[entry] = numbers.get(entry, 0.0) + common_part(own, len(choice.runs.record_names))
    if choice.local is not None:
        out = choice.local.extended(out, values.get(choice.local.size, 0.0))
    instruments = combined(combined(model.instruments, numbers), corrected)
    ids = [choice.bank.cause_of(c) for c in choice.selection.candidates]
    name = "+".join([model.id.partition("+")[0], *dict.fromkeys(ids)])
    return replace(out, id=name, instruments=instruments)


def common_part(own: Sequence[float], records: int) -> float:
    """What a further record is expected to have of a number that each has of its own (some of them zero): the mean
    where it differs from zero by more than its 90 % interval, else none; the number of a single record as it is."""
    if records == 1:
        return float(own[0])
    each = np.pad(own, (0, records - len(own)))
    return float(np.mean(each)) if abs(np.mean(each)) > half_of_mean(each) else 0.0


def of_some(choice: Choice, candidate: Candidate) -> bool:
    """Whether a candidate is of some of the records alone."""
    owners = {choice.bank.places[n].record for n in candidate.names}
    return None not in owners and len(owners) < len(choice.runs.record_names)


def in_wind(model: Model, choice: Choice) -> Model:
    """The model with the coefficients of the wind force that a choice holds, or that its wind needs."""
    final, places = choice.selection.final.point.values, choice.bank.places
    shares = {n: x for n, x in final.items() if x != 0.0 and places[n].kind == "windage"}
    windy = shares or Wind.id in {choice.bank.cause_of(c) for c in choice.selection.candidates}
    return replace(model, windage=choice.bank.windage_with(shares)) if windy else model


def _outside(choice: Choice, values: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Cause of a flow, force or term -> parameters of its extension; of flows of all records the mean, of one that some
    records have alone none."""
    out: dict[str, dict[str, float]] = {}
    for candidate in choice.selection.candidates:
        own = [n for n in candidate.names if choice.bank.places[n].kind in ("flow", "term")]
        if candidate.of in FLOWS and own:
            for side in SIDES:
                each = [values.get(n, 0.0) for n in own if f"towards_{side}" in n]
                mean = 0.0 if of_some(choice, candidate) else float(np.mean(each))
                out.setdefault(candidate.of, {})[flow_name(candidate.of, side, None)] = mean
        elif own:
            out.setdefault(candidate.of, {}).update({n: values.get(n, 0.0) for n in own})
    return out
