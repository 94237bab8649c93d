"""The choice: few candidates alone, or faults of input and sensors beside the model's own numbers under their priors.

A base model is exact or not.  Where it is not known to be, all its own numbers are also tried as random effects: free
under their priors in every fit.  They stay where left-out pieces are predicted clearly better with them than by the
few numbers that explain the records alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import INTERVAL
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.number import distinct
from ...estimation.selection.selection import (
    Entered,
    Rules,
    Selection,
    at_bound,
    clearly_worse,
    enters,
    fall_between,
    has_entered,
    is_enough,
    least_gain,
    mean_squares,
    predictions,
    quantile,
    select,
    with_only,
)
from ..causes.base import Cause
from ..causes.base_coefficients import BaseCoefficients
from ..causes.registry import causes
from ..free_runs.units import NEUTRAL_ANGLE_SD, REFERENCE_S
from .catalogue import DELAY, FAULT, FLOWS, FORCE, HULL, INPUT, OFFSET
from .regimes import PROMISING, in_regime

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Candidate
    from ..free_runs.bank import Bank, Place
    from ..free_runs.problem import FreeRuns
    from ..options import Options
    from .regimes import InRegime

EXACT = Rules(least=0.004, level=0.999, last_rank=FORCE)
"""Of a base model that is known to be exact: what is sure counts, however little it matters."""
MATTERS, BESIDE = (0.05, 0.99), (0.005, 0.999)
"""Least fall of the score for each channel, and level: of few numbers alone, and beside the model's own numbers."""
CLEAR = 0.95
"""Level from which a number in a regime is clearly better than numbers that are wrong everywhere, and from which
left-out pieces are clearly worse with a fault beside all numbers that was named without these."""
SMALL = 0.05
"""Error of left-out pieces beyond the noise, as a share of the motion, from which something is left to explain."""
FAINT = 0.03
"""The same up to which neither all of the model's own numbers nor one in a regime are looked for where no cause alone
explains anything: exact models that erred by .007 to .028 had such, models whose numbers were off by 5 % err by .15."""
USUAL = 2.0
"""Standard deviations of neutral rudder angles up to which one is usual."""
LIKE_GEAR = 0.1
"""Share of the rate of a vessel's own steering gear within which another rate is no other one."""
LOCAL = 0.1
"""Share of the squared error that a choice with a number in a regime takes off, at least: of an exact model in gusts a
number above some speed took 2 % off."""
LATE = 0.1
"""Delay of the rudder, as a share of a piece, from which it matters what acted before a record's begin."""
MOST, NEARLY_ALL, SINGLES, FAR = 0.7, 0.95, 4, 2.0
"""Shares of what all of the model's own numbers take off the squared error, from which one of them is told that takes
it off alone: where some are far off, and where none is; single numbers that are tried beside those of the choice; prior
standard deviations that are far."""
LARGE, HALF = 0.3, 0.5
"""Error, as a share of the motion, from which a model without a finding is not adequate; and share of what all of the
model's own numbers take off the excess from which neutral angles and zeros of sensors are told without them: a hull
that is alike to both sides takes their place only in part."""
WIDER = 3.0
"""Factor on 90 % intervals beside numbers that are all uncertain, and alike to both sides: of a delay beside ten
Mariners whose numbers were off by 10 % the error was 2.9 standard errors (rms)."""
COMMON = 0.5
"""Share of the errors of left-out pieces that a rudder fault at one time of several records has to take off: planted
ones took 61 to 76 %, those that measured records only seemed to have 17 to 42 %."""
GALE = 14.0
"""Speed of a wind, m/s, from which nobody sails trials: on a usual ship's areas, where a model states none, something
else looks like it."""
FEW = 3
"""Causes and numbers up to which a choice says more than that all of the model's own numbers are uncertain."""
ENOUGH = 0.01
"""Error of left-out pieces, as a share of the motion, that is no matter where the base model may be inexact: no number
of it is named."""


@dataclass(frozen=True)
class Choice:
    """What was selected, whether it is beside the model's own numbers, and a number that is wrong in a regime only.

    few : where it is beside these numbers, what was selected without them.  wide : where few candidates stand in the
    place of these numbers, the choice with all of them.
    """

    runs: FreeRuns
    selection: Selection
    beside: bool = False
    local: InRegime | None = None
    few: Selection | None = None
    wide: Choice | None = None

    @property
    def bank(self) -> Bank:
        """All candidates."""
        return self.runs.bank


def with_own_numbers(choice: Choice) -> Choice | None:
    """The choice with all of the model's own numbers free under their priors beside what was selected, where that
    predicts left-out pieces better: naming is sparse, predicting is not."""
    runs, selection = choice.runs, choice.selection
    if choice.beside or not choice.bank.own or not _left_to_explain(runs, selection):
        return None
    numbers = distinct((*choice.bank.own, *(n for c in selection.candidates for n in c.numbers)))
    point = selection.final.point
    wide = minimise(runs, numbers, point.values, point.own)
    better = clearly_worse(runs, selection.final, wide, MATTERS[0])
    return replace(choice, selection=replace(selection, final=wide)) if better else None


def main_number(choice: Choice) -> tuple[Selection, float] | None:
    """Where all of the model's own numbers are uncertain: the one, or else the group, that beside faults of input and
    sensors alone takes most of what all take off the squared error of left-out pieces, and its share; None where there
    is none.

    Some number has to be off by more than its prior says (FAR) beside all others, or the one has to take NEARLY_ALL:
    where all are a little off, any of many takes most.
    """
    few, runs = choice.few, choice.runs
    if few is None:
        return None
    of_model = {n.name for n in choice.bank.own}
    everywhere = [e.candidate for e in few.entered if {*e.candidate.names} <= runs.places.keys()]
    of_hull = [c for c in everywhere if choice.bank.cause_of(c) == BaseCoefficients.id]
    first = {c.of for c in of_hull[:1]}  # explains most, as a slip does
    own = [c for c in of_hull if c.of in first or {*c.names} <= of_model]
    faults = choice.selection.candidates
    faults += tuple(c for c in few.candidates if _is_sided(runs, c) and not has_entered(c, faults))
    before = _fitted_beside(choice, faults) if faults else few.base
    singles = [c for c in choice.bank.candidates if len(c.names) == 1 and c.rank == HULL and not c.extends]
    predicted = predictions(runs, singles, before)
    predicted.sort(key=lambda p: float(np.sum(runs.beyond(mean_squares(runs, p.left_out)))))
    own += [p.candidate for p in predicted[:SINGLES] if p.candidate not in own]
    final, most = choice.selection.final, list[tuple[Selection, float]]()
    whole, gross = _taken(runs, before, final), _is_gross(choice)
    for candidate in own:
        fitted = _fitted_beside(choice, (*faults, candidate))
        is_slip = candidate.of in first and not {*candidate.names} & of_model
        needed = MOST if gross or is_slip else NEARLY_ALL
        if (share := _taken(runs, before, fitted) / whole) > needed:
            one = Entered(candidate, fall_between(runs, before, fitted))
            most.append((Selection(before, (one,), fitted), share))
    return _first_of(most) if most else None


def _first_of(most: Sequence[tuple[Selection, float]]) -> tuple[Selection, float]:
    """The one of fewest numbers, or the group that leaves less than HALF of what this leaves; with others of no more
    numbers, of other groups, that leave less than twice as much, as its rivals."""
    first = min(most, key=_order)
    groups = [one for one in most if _order(one) > _order(first) and 1.0 - one[1] < HALF * (1.0 - first[1])]
    selection, share = max(groups, key=lambda one: one[1], default=first)
    (own,) = selection.entered
    near = [s.entered[0].candidate for s, x in most if HALF * (1.0 - x) < 1.0 - share]
    rivals = {c.of: c for c in near if c.of != own.candidate.of and len(c.numbers) <= len(own.candidate.numbers)}
    return replace(selection, entered=(replace(own, tied_with=tuple(rivals.values())),)), share


def _is_gross(choice: Choice) -> bool:
    """Whether some of the model's own numbers moves far for its prior in the joint fit."""
    return any(abs(choice.selection.final.value(n.name)) > FAR * n.sd for n in choice.bank.own)


def _order(main: tuple[Selection, float]) -> tuple[int, bool, float]:
    """What is preferred among selections of one candidate with its share."""
    selection, share = main
    (one,) = selection.candidates
    return len(one.numbers), at_bound(selection.final, one), -share


def _fitted_beside(choice: Choice, candidates: Sequence[Candidate]) -> Fitted:
    """The fit of candidates without the model's own numbers, from where the few left them."""
    numbers = distinct(n for c in candidates for n in c.numbers)
    final = choice.selection.final if choice.few is None else choice.few.final
    return minimise(choice.runs, numbers, {n.name: final.value(n.name) for n in numbers}, final.point.own)


def _taken(runs: FreeRuns, before: Fitted, after: Fitted) -> float:
    """What a fit takes off the excess of left-out pieces, in squares of the motion, sum over channels."""
    return max(float(np.sum(runs.excess(before) - runs.excess(after))), 1e-12)


def alone(choice: Choice) -> Choice | None:
    """Faults of input and sensors that were selected without the model's own numbers; None where the choice is this, or
    where something else was, or nothing."""
    few = choice.few
    if few is None or not few.entered or any(c.rank != INPUT for c in few.candidates):
        return None
    return Choice(choice.runs, few)


def withdrawn(choice: Choice) -> Choice | None:
    """The choice without what entered last, else without the model's own numbers; None where there is nothing left."""
    runs, selection = choice.runs, choice.selection
    if not selection.entered:
        as_it_is = minimise(runs, (), {}, runs.no_own)
        return Choice(runs, Selection(as_it_is, (), as_it_is)) if choice.beside else None
    return _without(choice, selection.entered[-1])


def neutral_angle_alone(choice: Choice) -> Choice | None:
    """The neutral rudder angle of all records in the place of several numbers without one; None where the choice is
    none of these."""
    runs, base, angle = choice.runs, choice.selection.base, neutral_angle(choice.bank)
    several = choice.beside or _count(choice.selection) > 1
    if angle is None or not several or has_entered(angle, choice.selection.candidates):
        return None
    fitted = minimise(runs, angle.numbers, {}, runs.no_own)
    return Choice(runs, Selection(base, (Entered(angle, fall_between(runs, base, fitted)),), fitted))


def neutral_angle(bank: Bank) -> Candidate | None:
    """The candidate of one neutral rudder angle of all records; None where there is none."""
    return next((c for c in bank.candidates if c.of == OFFSET and len(c.numbers) == 1), None)


def without_neutral_angle(choice: Choice) -> Choice | None:
    """The choice without the neutral rudder angle of all records; None where that did not enter, or nothing else."""
    entered = choice.selection.entered
    one = next((e for e in entered if e.candidate.of == OFFSET and len(e.candidate.numbers) == 1), None)
    return None if one is None or not (choice.beside or len(entered) > 1) else _without(choice, one)


def _without(choice: Choice, one: Entered) -> Choice:
    """The choice without a candidate, all others fitted again."""
    kept = [e for e in choice.selection.entered if e is not one]
    own = choice.bank.own if choice.beside else ()
    return replace(choice, selection=with_only(choice.runs, choice.selection, kept, own))


def chosen(runs: FreeRuns, options: Options) -> Choice:
    """The choice for records, without faults of input and sensors whose sizes are below what matters, or of which none
    differs from zero.

    Where the rudder acts late, another choice is made without the begin of each record: what acts there is not known.
    """
    choice = _chosen(runs, options)
    if unlikely := {one.candidate.of for one in choice.selection.entered if _is_unlikely(choice, one, options)}:
        runs = runs.without(unlikely)
        choice = _chosen(runs, options)
    late_s = choice.selection.final.value(DELAY)
    if late_s > LATE * float(np.ptp(runs.units[0].grid_s)):
        choice = _chosen(runs.without_begin(late_s), options)
    while small := [e for e in choice.selection.entered if not _matters(choice, e) or _may_be_none(choice, e)]:
        choice = _without(choice, small[-1])
    return _sparse(_of_fewer_numbers(_of_all_records(choice)))


def _is_unlikely(choice: Choice, one: Entered, options: Options) -> bool:
    """Whether a candidate stands for something else: a flow whose speeds may all be zero, a wind of a gale where the
    model states no windage, or a rudder fault at the same second of several records that takes off less than COMMON of
    the errors of a base that may be inexact (a fault is of one record, and speed that is lost in turns looks like one).
    """
    runs = choice.runs
    if speeds := flow_speeds(choice, one).values():
        assumed = any(choice.bank.places[n].kind == "windage" for n in one.candidate.names)
        gale = assumed and max(speed - half for speed, half in speeds) > GALE
        return gale or all(speed <= half for speed, half in speeds)
    if one.candidate.of != FAULT or len(runs.record_names) == 1 or options.coefficient_sd == 0.0:
        return False
    channels = np.count_nonzero(runs.counts.sum(axis=0))
    return bool(one.fall.gain < -np.log(1.0 - COMMON) * channels)


def _of_fewer_numbers(choice: Choice) -> Choice:
    """The choice without numbers of groups of the hull that left-out pieces are not predicted clearly worse without: of
    a group that two numbers are wrong of, the others take up noise and bias these."""
    runs, whole = choice.runs, choice.selection
    for place in range(0 if choice.beside else len(whole.entered)):
        while (fewer := _with_one_less(runs, choice.selection, place)) is not None:
            if clearly_worse(runs, fewer.final, whole.final, MATTERS[0]):
                break
            choice = replace(choice, selection=fewer)
    return choice


def _with_one_less(runs: FreeRuns, selection: Selection, place: int) -> Selection | None:
    """The selection without the number of a group of the hull that left-out pieces miss least; None where the group has
    no more than two."""
    one = selection.entered[place]
    if one.candidate.rank != HULL or len(one.candidate.numbers) <= 2:
        return None
    trials = list[Selection]()
    for number in one.candidate.numbers:
        rest = tuple(n for n in one.candidate.numbers if n is not number)
        fewer = replace(one, candidate=replace(one.candidate, numbers=rest))
        entered = [fewer if other is one else other for other in selection.entered]
        trials.append(with_only(runs, selection, entered))
    return min(trials, key=lambda t: fall_between(runs, t.final, selection.final).gain)


def _of_all_records(choice: Choice) -> Choice:
    """The choice with one number of the rudder for all records in the place of one of each, where left-out pieces are
    not surely worse with it, by what matters: only that one tells what a further record has."""
    runs, selection = choice.runs, choice.selection
    for place, one in enumerate(selection.entered):
        owners = {choice.bank.places[n].record for n in one.candidate.names}
        own = (c for c in choice.bank.candidates if c.of == one.candidate.of and len(c.numbers) == 1)
        common = next((c for c in own if choice.bank.places[c.names[0]].record is None), None)
        if None in owners or common is None or choice.bank.places[common.names[0]].kind != "steering":
            continue
        entered = [*selection.entered[:place], replace(one, candidate=common), *selection.entered[place + 1 :]]
        other = with_only(runs, selection, entered, choice.bank.own if choice.beside else ())
        between = fall_between(runs, other.final, selection.final)
        if between.gain <= max(quantile(runs, CLEAR) * between.error, least_gain(runs, Rules(*MATTERS))):
            return replace(choice, selection=other)
    return choice


def _sparse(choice: Choice) -> Choice:
    """The few candidates in the place of all of the model's own numbers, where these take off little more than one of
    them does, with no fault of input or sensor beside them, or not much more than neutral angles and zeros of sensors;
    none, where errors are small and all numbers do not take most of them off."""
    few, runs, final = choice.few, choice.runs, choice.selection.final
    if few is None or not {n for c in few.candidates for n in c.names} <= runs.places.keys():
        return choice
    if not few.entered:
        little = runs.worst(few.base) <= LARGE and runs.share_taken(few.base, final) < MOST
        return Choice(runs, few) if little else choice
    named = [one for one in few.entered if one.candidate.rank != FORCE]
    sided = bool(named) and all(_is_sided(runs, one.candidate) for one in named)
    if sided and len(named) < len(few.entered):
        few = with_only(runs, few, named)
    alone = MOST if _is_gross(choice) else NEARLY_ALL
    lost = [c for c in choice.selection.candidates if not has_entered(c, few.candidates)]
    needed = HALF if sided else alone if len(few.entered) == 1 and not lost else np.inf
    enough = _taken(runs, few.base, few.final) > needed * _taken(runs, few.base, final)
    return Choice(runs, few, wide=choice) if enough else choice


def half_intervals(runs: FreeRuns, fitted: Fitted, beside: bool = False) -> dict[str, float]:
    """Number -> half of its 90 % interval; beside : numbers that are all uncertain, which widen their own intervals and
    those of faults that are alike to both sides, as they are themselves."""
    factor, pairs = interval_factor(runs), zip(fitted.numbers, fitted.sd.tolist(), strict=True)
    own = {n.name for n in runs.bank.own}

    def widening(name: str) -> float:
        place = runs.places[name]
        return WIDER if name in own or not (place.kind == "model" or _has_side(place)) else 1.0

    return {n.name: (widening(n.name) if beside else 1.0) * factor * x for n, x in pairs}


def _has_side(place: Place) -> bool:
    """Whether a number tells port from starboard: a neutral angle, or the zero of a sensor."""
    return place.entries == (OFFSET,) or (place.kind == "sensor" and all(n.endswith("_bias") for n in place.entries))


def _is_sided(runs: FreeRuns, candidate: Candidate) -> bool:
    """Whether all numbers of a candidate tell port from starboard."""
    return all(n in runs.places and _has_side(runs.places[n]) for n in candidate.names)


def interval_factor(runs: FreeRuns) -> float:
    """Standard deviations that half of a 90 % interval has."""
    return quantile(runs, INTERVAL)


def _may_be_none(choice: Choice, one: Entered) -> bool:
    """Whether the intervals of all numbers of a candidate beside the model's own, or of a fault that has another size
    in each record, hold zero."""
    of_records = len({choice.bank.places[n].record for n in one.candidate.names}) > 1
    if not choice.beside and (not of_records or choice.bank.cause_of(one.candidate) in FLOWS):
        return False
    few = choice.few
    if few is not None and _is_sided(choice.runs, one.candidate) and has_entered(one.candidate, few.candidates):
        return False
    final = choice.selection.final
    halves = half_intervals(choice.runs, final, choice.beside)
    return all(abs(final.value(n)) <= halves[n] for n in one.candidate.names)


def flow_speeds(choice: Choice, one: Entered) -> dict[int | None, tuple[float, float]]:
    """Record of a flow's own, None: all -> its speed and half of the 90 % interval, m/s; none of another candidate."""
    final, halves = choice.selection.final, half_intervals(choice.runs, choice.selection.final, choice.beside)
    pairs: dict[int | None, list[str]] = {}
    for name in one.candidate.names if choice.bank.cause_of(one.candidate) in FLOWS else ():  # not of steady forces
        if (place := choice.bank.places[name]).kind == "flow":
            pairs.setdefault(place.record, []).append(name)
    ends = {record: ([final.value(n) for n in own], [halves[n] for n in own]) for record, own in pairs.items()}
    return {r: (math.hypot(*values), math.hypot(*spread) / math.sqrt(2.0)) for r, (values, spread) in ends.items()}


def _matters(choice: Choice, one: Entered) -> bool:
    """Whether the size of a candidate is above the least of its cause that matters."""
    cause, runs = causes().get(choice.bank.cause_of(one.candidate)), choice.runs
    if any(runs.places[n].inverse for n in one.candidate.names if n in runs.places):
        return not _is_own_gear(choice, one)
    smallest = cause.smallest if isinstance(cause, Cause) and one.candidate.rank == INPUT else None
    if cause is None or smallest is None:
        return True
    unit, names = cause.unit.partition(",")[0], [n for n in one.candidate.names if runs.places[n].kind != "windage"]
    values = np.array([choice.selection.final.value(n) for n in names])
    if not names:  # in a measured wind
        return True
    if unit in ("s", "m/s"):
        smallest *= runs.length_s / REFERENCE_S
    if unit == "s":
        smallest = max(smallest, 0.5 * runs.units[0].stretch.series.dt, runs.units[0].record.dt)
    sizes = np.hypot(*values.reshape(-1, 2).T) if cause.id in FLOWS else np.abs(values)
    return bool(np.max(sizes) > smallest)


def _is_own_gear(choice: Choice, one: Entered) -> bool:
    """Whether a rate limit is the one that the vessel's own gear has, within LIKE_GEAR or its interval."""
    final, own = choice.selection.final, choice.runs.model.rudder.rate_rad_s
    halves = half_intervals(choice.runs, final, choice.beside)
    near = ((final.value(n) * own - 1.0, max(LIKE_GEAR, halves[n] * own)) for n in one.candidate.names)
    return bool(np.isfinite(own)) and all(abs(off) < most for off, most in near)


def _chosen(runs: FreeRuns, options: Options) -> Choice:
    """Few candidates, but not several where the model's own numbers, each a little off, predict left-out pieces as
    well; where errors that matter are left, a number in a regime, or these numbers with faults beside them."""
    candidates = runs.bank.candidates
    if options.base_parameters == "identify":
        return _of_identified(runs, candidates)
    base = minimise(runs, (), {}, runs.no_own)
    if options.coefficient_sd == 0.0:
        return Choice(runs, select(runs, candidates, EXACT, base))
    rules = Rules(*MATTERS, _enough(runs), last_rank=FORCE)
    selection = select(runs, candidates, rules, base)
    if runs.worst(base) <= ENOUGH and any(c.rank != INPUT for c in selection.candidates):
        selection = select(runs, [c for c in candidates if c.rank == INPUT], rules, base)
    choice = _beside_neutral_angle(Choice(runs, selection), rules)

    @cache
    def whole() -> Fitted:
        return minimise(runs, runs.bank.own, {}, base.point.own)

    several = len(choice.selection.entered) > 1
    as_well = several and bool(runs.bank.own) and _predicts_as_well(choice, whole())
    if several and not as_well and _left_to_explain(runs, choice.selection):
        choice = _without_first(choice, rules)
    faint = not choice.selection.entered and runs.worst(base) <= FAINT
    if not runs.bank.own or faint or not (as_well or _left_to_explain(runs, choice.selection)):
        return choice
    local = _with_regime(choice, rules, 0.0 if as_well else PROMISING)
    if as_well if local.local is None else _predicts_as_well(local, whole()):
        alone = _of_own_numbers(choice, whole())
        more = _beside(choice, base, whole(), MATTERS[0]) if _left_to_explain(runs, alone.selection) else None
        return alone if more is None else _without_usual_angle(replace(alone, selection=more))
    if not _left_to_explain(local.runs, local.selection):
        return local
    with_numbers = _beside(local, base, whole())
    return local if with_numbers is None else Choice(runs, with_numbers, beside=True, few=local.selection)


def _beside_neutral_angle(choice: Choice, rules: Rules) -> Choice:
    """The choice, or another one beside a neutral rudder angle, where that enters by itself, or beside the fault that
    entered first, and the other one predicts left-out pieces as well by the count of its numbers: nearly every rudder
    has one, and it makes many numbers together of the one that is wrong."""
    runs, selection, angle = choice.runs, choice.selection, neutral_angle(choice.bank)
    if angle is None or _count(selection) < 2 or angle in selection.candidates[:2]:
        return choice
    first = [one for one in selection.entered[:1] if one.candidate.rank == INPUT]
    for held in ([], first) if first else ([],):
        before = with_only(runs, selection, held).final if held else selection.base
        entered = [*held, Entered(angle, fall_between(runs, before, before))]
        fitted = with_only(runs, replace(selection, final=before), entered).final
        fall = fall_between(runs, before, fitted)
        if not enters(runs, rules, fitted, fall):
            continue
        always = tuple(n for one in entered for n in one.candidate.numbers)
        barred = {OFFSET, *(one.candidate.of for one in held)}
        rest = select(runs, [c for c in choice.bank.candidates if c.of not in barred], rules, fitted, always)
        other = Selection(selection.base, (*held, Entered(angle, fall), *rest.entered), rest.final)
        between, more = fall_between(runs, selection.final, other.final), _count(other) - _count(selection)
        needed = more * least_gain(runs, rules)
        if between.gain > (needed if more > 0 else min(needed, -between.error)):
            return Choice(runs, other)
    return choice


def _without_usual_angle(choice: Choice) -> Choice:
    """The choice without neutral rudder angles as records usually have them: beside numbers of the model that are all
    free those take up what differs between the sides of the hull."""
    final = choice.selection.final
    for one in choice.selection.entered:
        angles = [abs(final.value(n)) for n in one.candidate.names]
        if one.candidate.of == OFFSET and max(angles) < USUAL * NEUTRAL_ANGLE_SD:
            return _without(choice, one)
    return choice


def _count(selection: Selection) -> int:
    """Numbers of what entered."""
    return sum(len(c.numbers) for c in selection.candidates)


def _without_first(choice: Choice, rules: Rules) -> Choice:
    """A choice without the candidate that entered first, where left-out pieces are predicted better with it, clearly
    and by what each further number has to gain if it has more: what is best alone need not be among the best
    together."""
    runs, selection = choice.runs, choice.selection
    first = selection.candidates[0].of
    other = select(runs, [c for c in choice.bank.candidates if c.of != first], rules, selection.base)
    between, more = fall_between(runs, selection.final, other.final), _count(other) - _count(selection)
    needed = more * least_gain(runs, rules)
    least = max(rules.least, quantile(runs, CLEAR) * between.error, needed) if more > 0 else 0.0
    return Choice(runs, other) if between.gain > least else choice


def _predicts_as_well(choice: Choice, whole: Fitted) -> bool:
    """Whether all of the model's own numbers, each a little off, predict left-out pieces as well as a choice."""
    return fall_between(choice.runs, choice.selection.final, whole).gain > 0.0


def _of_own_numbers(choice: Choice, whole: Fitted) -> Choice:
    """All of the model's own numbers in the place of a choice; whole : the fit of these."""
    alone = Selection(choice.selection.base, (), whole)
    return Choice(choice.runs, alone, beside=True, few=choice.selection)


def _with_regime(choice: Choice, rules: Rules, promising: float) -> Choice:
    """The choice with a number that is wrong in a regime only in the place of numbers that are wrong everywhere, where
    that predicts left-out pieces clearly better; promising : as of `regimes.in_regime`."""
    local = in_regime(choice.runs, choice.selection, choice.bank.candidates, rules, CLEAR, promising)
    if local is None or len(local[1].entered) > FEW:
        return choice
    runs, selection, where = local
    little = runs.share_taken(selection.base, selection.final) < LOCAL
    return choice if little else Choice(runs, selection, local=where)


def _beside(choice: Choice, base: Fitted, whole: Fitted, least: float = BESIDE[0]) -> Selection | None:
    """Faults of input and sensors beside all of the model's own numbers, where these predict left-out pieces clearly
    better than the choice, surely than a single cause, or at all where that holds more than few causes.

    Faults of the choice go before others, and stay where left-out pieces are not predicted clearly worse with them: all
    numbers together can take most of their place.
    """
    runs, bank, faults = choice.runs, choice.bank, list[Entered]()
    now = Selection(whole, (), whole)
    for fault in (one for one in choice.selection.entered if one.candidate.rank == INPUT):
        wider = with_only(runs, now, [*faults, fault], bank.own)
        worse = fall_between(runs, wider.final, now.final)
        if worse.gain <= quantile(runs, CLEAR) * worse.error:
            now, faults = wider, [*faults, fault]
    inputs = [c for c in bank.candidates if c.rank == INPUT and not has_entered(c, now.candidates)]
    always = (*bank.own, *(n for one in faults for n in one.candidate.numbers))
    more = select(runs, inputs, Rules(least, BESIDE[1], most=3), now.final, always)
    selection = Selection(whole, (*faults, *more.entered), more.final)
    count = len(choice.selection.entered)
    errors = quantile(runs, CLEAR) if count == 1 else 1.0
    for fitted in (selection.final, whole):
        between = fall_between(runs, choice.selection.final, fitted)
        if between.gain > (0.0 if count > FEW else max(errors * between.error, MATTERS[0])):
            return replace(selection, base=base)
    return None


def _of_identified(runs: FreeRuns, candidates: Sequence[Candidate]) -> Choice:
    """The choice beside a model's own numbers that come from these records, and are hardly restricted."""
    names = {n.name for n in runs.bank.own}
    others = [c for c in candidates if not names & {*c.names}]
    whole = minimise(runs, runs.bank.own, {}, runs.no_own)
    return Choice(runs, select(runs, others, Rules(*BESIDE, last_rank=FORCE), whole, runs.bank.own), beside=True)


def _left_to_explain(runs: FreeRuns, selection: Selection) -> bool:
    """Whether errors of left-out pieces are left that matter where the base model may be inexact."""
    return not is_enough(runs, selection.final, _enough(runs))


def _enough(runs: FreeRuns) -> np.ndarray:
    """Error (C,) of left-out pieces, with the sensors' noise, that is no matter where the base model may be inexact."""
    return np.sqrt(np.maximum(ENOUGH * runs.motion, runs.floor) ** 2 + runs.irregular())
