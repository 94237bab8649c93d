"""The smallest set of candidates that predicts units which took no part in the fit: screen, refit, enter, delete.

One linearisation of all numbers says what a fit with each candidate would leave of left-out units; the leaders are
refitted.  A candidate enters where the score falls by more than matters (`least` for each channel) and by more than is
chance (`level` of Student's t over units, a lower one for a likelihood ratio of `EVIDENT`).  Of those that enter, the
first by rank and by the count of its numbers that is not clearly worse than the best.  At the end a candidate of few
numbers takes the place of one of many where it predicts as well, and candidates leave again, as long as that costs
less.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...checks.tails import student_quantile
from .minimiser import Fitted, UnitErrors, minimise, prior_of
from .number import Candidate, Number, distinct
from .quadratic import Normal, Quadratic, own_information
from .score import Fall, fall

CLEAR, LAST = 1.0, 3.0
"""Standard errors from which one of two fits is clearly worse (the rule of one standard error, Breiman et al. 1984),
and from which it is worse than one with a candidate of the last rank."""
TAKEN = 0.01
"""Share of the information on a candidate that is left beside the numbers in every fit, below which it is not tried."""
EVIDENT, LARGE = 10.0, 0.99
"""Fall of the score times the independent values from which a lower level suffices: few units may hold all that is
known of a number, so that the standard error is large by the size of the fall itself."""
AT_BOUND = 1e-3
"""Prior standard deviations from a bound within which a number is at it."""
MANY = 3
"""Numbers of a candidate from which others are tried in its place at the end."""
COARSE = 0.12
"""Fall of the cost for each independent value that ends the fit of a candidate, as a share of the fall of the score
that matters."""
HOPELESS = 0.15
"""Share of the largest predicted fall of the score below which a candidate is not refitted: in 16 cases of four suites
none of a smaller share entered or tied."""
COLUMNS = 48
"""Numbers of candidates that are linearised together, about: the work goes with the square of it."""
IN_BOUNDS = 1.5
"""A predicted fit goes so far at most beyond the trial value that it was linearised at, as a factor on that."""


@dataclass(frozen=True)
class Rules:
    """What matters, what is sure, and how many are tried.

    least : fall of the score for each channel that matters.  level : probability of Student's t for what enters.
    enough : root mean square errors (C,) of left-out units below which nothing more is looked for.
    most : candidates that may enter.  leaders, of_each : candidates that are refitted in a step, of all and of each
    rank.  last_rank : that of candidates which are preferred only where all others are far worse; None: of none.
    evident : lower level, which suffices for a likelihood ratio of `EVIDENT`.
    hopeless : share of the largest predicted fall below which a candidate is not refitted; None: predictions order
    candidates and exclude none, where errors bend far with the numbers.
    nearer : factor on the largest error, in those of `enough`, below which each candidate behind the first has to bring
    it.
    """

    least: float = 0.05
    level: float = 0.95
    enough: np.ndarray | None = None
    most: int = 5
    leaders: int = 6
    of_each: int = 3
    last_rank: int | None = None
    evident: float = LARGE
    hopeless: float | None = HOPELESS
    nearer: float = np.inf


@dataclass(frozen=True)
class Entered:
    """A candidate that entered: by how much the score fell, candidates of another id that would have done as well, and
    those of its own id with other numbers."""

    candidate: Candidate
    fall: Fall
    tied_with: tuple[Candidate, ...] = ()
    alike: tuple[Candidate, ...] = ()


@dataclass(frozen=True)
class Selection:
    """The fit without any candidate, the candidates in the order in which they entered, and the fit with them."""

    base: Fitted
    entered: tuple[Entered, ...]
    final: Fitted

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """Candidates that are in."""
        return tuple(one.candidate for one in self.entered)


Column = tuple[str, float | None]
"""A number, and the value that it is linearised at."""


class Prediction(NamedTuple):
    """A candidate, the squares (K, C) of left-out units that a linearisation predicts with it, and the fall of the
    score."""

    candidate: Candidate
    left_out: np.ndarray
    gain: float


class Trial(NamedTuple):
    """A refitted candidate and the fall of the score with it."""

    candidate: Candidate
    fitted: Fitted
    fall: Fall


def select(
    problem: UnitErrors, bank: Sequence[Candidate], rules: Rules, start: Fitted, always: Sequence[Number] = ()
) -> Selection:
    """Candidates in the order in which they enter beside numbers that are always free.

    start : the fit of the numbers `always`.
    """
    search = _Search(problem, rules, tuple(always))
    now = Selection(start, (), start)
    for _ in range(rules.most):
        if rules.enough is not None and is_enough(problem, now.final, rules.enough):
            break
        following = search.entered(now, bank)
        if following is None or (now.entered and not _comes_nearer(problem, rules, now, following)):
            break
        now = following
    return search.without_needless(search.with_smaller(now, bank))


def _comes_nearer(problem: UnitErrors, rules: Rules, now: Selection, following: Selection) -> bool:
    """Whether a selection with one candidate more comes nearer to what is enough."""
    if rules.enough is None:
        return True
    before, after = (
        float(np.max(np.sqrt(mean_squares(problem, one.final.left_out)) / rules.enough)) for one in (now, following)
    )
    return after < rules.nearer * before


def predictions(problem: UnitErrors, bank: Sequence[Candidate], base: Fitted) -> list[Prediction]:
    """Candidates by what the linearisation about a fit without any predicts, those of the largest fall of the score
    first."""
    return _Search(problem, Rules(), ()).predictions(Selection(base, (), base), bank)


def with_only(
    problem: UnitErrors, selection: Selection, kept: Sequence[Entered], always: Sequence[Number] = ()
) -> Selection:
    """The selection of some of what entered, all fitted again; always : numbers that are free in every fit."""
    numbers, point = distinct((*always, *(n for one in kept for n in one.candidate.numbers))), selection.final.point
    values = {n.name: point.values.get(n.name, 0.0) for n in numbers}
    return Selection(selection.base, tuple(kept), minimise(problem, numbers, values, point.own))


def clearly_worse(problem: UnitErrors, one: Fitted, other: Fitted, least: float) -> bool:
    """Whether the first fit predicts left-out units clearly worse than the other one."""
    between = fall_between(problem, one, other)
    return between.gain > max(CLEAR * between.error, least)


def fall_between(problem: UnitErrors, before: Fitted, after: Fitted) -> Fall:
    """By how much the score of left-out units falls from one fit to another one."""
    return fall(before.left_out, after.left_out, floor_squares(problem))


def enters(problem: UnitErrors, rules: Rules, fitted: Fitted, by: Fall) -> bool:
    """Whether the fall of the score with a fit matters and is no chance, eq. 10 of docs/mathematics/pieces.md."""
    evident = by.gain * independent(problem, fitted) > EVIDENT
    level = min(rules.level, rules.evident) if evident else rules.level
    return by.gain > max(least_gain(problem, rules), quantile(problem, level) * by.error)


def least_gain(problem: UnitErrors, rules: Rules) -> float:
    """Fall of the score that matters, of all channels together."""
    return rules.least * int((problem.counts.sum(axis=0) > 0).sum())


def is_enough(problem: UnitErrors, fitted: Fitted, enough: np.ndarray) -> bool:
    """Whether left-out units are predicted with root mean square errors below `enough` (C,)."""
    return bool(np.all(np.sqrt(mean_squares(problem, fitted.left_out)) < enough))


def floor_squares(problem: UnitErrors) -> np.ndarray:
    """Sums of squares (K, C) of errors that count as none."""
    return problem.counts * problem.floor**2


def mean_squares(problem: UnitErrors, squares: np.ndarray) -> np.ndarray:
    """Mean squared errors (C,) over all samples from sums of squares (K, C) of units."""
    return squares.sum(axis=0) / np.maximum(problem.counts.sum(axis=0), 1.0)


def independent(problem: UnitErrors, fitted: Fitted) -> float:
    """Independent values at a fit of the channel that has most of them, one at least."""
    return max(float(np.max(np.sum(fitted.point.weight * problem.counts, axis=0))), 1.0)


def quantile(problem: UnitErrors, level: float) -> float:
    """Quantile of Student's t over units."""
    return student_quantile(level, max(len(problem.counts) - 1, 1))


@dataclass(frozen=True)
class _Search:
    problem: UnitErrors
    rules: Rules
    always: tuple[Number, ...]

    def numbers_of(self, candidates: Sequence[Candidate]) -> tuple[Number, ...]:
        """Numbers of candidates behind those that are always free, each once, without their trial values."""
        return distinct((*self.always, *(n for c in candidates for n in c.numbers)))

    # ---- one step
    def entered(self, now: Selection, bank: Sequence[Candidate]) -> Selection | None:
        """With the candidate that enters; None where none does."""
        leaders = self.leaders(now, [c for c in bank if not has_entered(c, now.candidates)])
        good = [t for c in leaders if (t := self.refitted(now, c)) is not None and self.enters(t)]
        if not good:
            return None
        best = max(good, key=lambda t: t.fall.gain)
        order = sorted(good, key=_order)
        first = next(t for t in order if t is best or not self._worse(t, best))
        rivals = [t.candidate for t in good if t is not first and self._rivals(t, first)]
        tied = {c.of: c for c in rivals if c.of != first.candidate.of}
        alike = tuple(c for c in rivals if c.of == first.candidate.of and not {*c.names} & {*first.candidate.names})
        one = Entered(first.candidate, first.fall, tuple(tied.values()), alike)
        numbers, end = self.numbers_of([*now.candidates, one.candidate]), first.fitted.point
        final = minimise(self.problem, numbers, end.values, end.own, weight=end.weight)
        return Selection(now.base, (*now.entered, one), final)

    def enters(self, trial: Trial) -> bool:
        """Whether a trial is good enough to enter."""
        return enters(self.problem, self.rules, trial.fitted, trial.fall)

    def refitted(self, now: Selection, candidate: Candidate) -> Trial | None:
        """The fit with a candidate beside what has entered; None where its equations cannot be solved."""
        start = {n.name: n.trial for n in candidate.numbers if n.trial is not None}
        numbers, point = self.numbers_of([*now.candidates, candidate]), now.final.point
        try:
            fitted = minimise(
                self.problem,
                numbers,
                point.values | start,
                point.own,
                weight=point.weight,
                coarse=COARSE * self.rules.least,
            )
        except np.linalg.LinAlgError:
            return None
        return Trial(candidate, fitted, fall_between(self.problem, now.final, fitted))

    def _worse(self, one: Trial, other: Trial) -> bool:
        """Whether a trial is clearly worse than another one; than one of the last rank by more, and than one of more
        numbers by what each of these has to gain."""
        between = fall_between(self.problem, one.fitted, other.fitted)
        last = self.rules.last_rank
        far = LAST if last is not None and other.candidate.rank == last > one.candidate.rank else CLEAR
        more = len(other.candidate.numbers) - len(one.candidate.numbers)
        return between.gain > max(far * between.error, self.rules.least, more * least_gain(self.problem, self.rules))

    def _rivals(self, other: Trial, chosen: Trial) -> bool:
        """Whether another candidate would have done as well with no more numbers."""
        if len(other.candidate.numbers) > len(chosen.candidate.numbers):
            return False
        between = fall_between(self.problem, other.fitted, chosen.fitted)
        return between.gain < max(between.error, self.rules.least)

    # ---- screen
    def leaders(self, now: Selection, bank: Sequence[Candidate]) -> list[Candidate]:
        """The candidates of the largest predicted falls of the score: of all, of each rank, and of single numbers."""
        every = self.predictions(now, bank)
        share, largest = self.rules.hopeless, max((one.gain for one in every), default=0.0)
        ordered = [one.candidate for one in every if share is None or one.gain >= share * largest]
        kinds: list[Callable[[Candidate], bool]] = [lambda c, r=r: c.rank == r for r in {c.rank for c in bank}]
        kinds.append(lambda c: len(c.numbers) == 1)
        chosen = ordered[: self.rules.leaders]
        for kind in kinds:
            chosen += [c for c in ordered if kind(c)][: self.rules.of_each]
        return list(dict.fromkeys(chosen))

    def predictions(self, now: Selection, bank: Sequence[Candidate]) -> list[Prediction]:
        """Candidates by their predicted falls of the score, the largest first; none whose equations cannot be solved,
        or that the numbers which are in take the place of."""
        floor = floor_squares(self.problem)
        every = [
            Prediction(candidate, left, fall(now.final.left_out, left, floor).gain)
            for part in _parts(bank)
            for candidate, left in self._screened(now, part)
        ]
        every.sort(key=lambda one: -one.gain)
        ways = {_way(one.candidate): one for one in reversed(every)}  # of several trial values the best
        return [one for one in every if ways[_way(one.candidate)] is one]

    def _screened(self, now: Selection, bank: Sequence[Candidate]) -> Iterator[tuple[Candidate, np.ndarray]]:
        """Candidates that one linearisation holds, with squares (K, C) of left-out units, in their order."""
        point, held = now.final.point, self.numbers_of(now.candidates)
        columns = {_column(n): n for n in (*held, *(n for c in reversed(bank) for n in c.numbers))}
        screen = _Screen(self.problem.quadratic(point.values, point.own, list(columns.values())), held, list(columns))
        normal = screen.quadratic.normal(point.size, point.weight)
        for candidate in bank:
            left = self._predicted(now.final, candidate, screen, normal)
            if left is not None:
                yield candidate, left

    def _predicted(self, fitted: Fitted, candidate: Candidate, screen: _Screen, normal: Normal) -> np.ndarray | None:
        """Squares (K, C) of left-out units that the linearisation predicts with a candidate; None without any."""
        numbers = [*screen.held, *map(_reached, candidate.numbers)]
        places, prior = screen.places(numbers), prior_of(numbers, fitted.point.values)
        try:
            if own_information(normal.of(places), prior, len(screen.held)) < TAKEN:
                return None
            return screen.quadratic.left_out(normal, places, prior)
        except np.linalg.LinAlgError:
            return None

    # ---- the end
    def with_smaller(self, now: Selection, bank: Sequence[Candidate]) -> Selection:
        """The selection with a candidate of few numbers in the place of one of many, where left-out units are not
        predicted clearly worse: what entered first was chosen before the others were known."""
        for one in now.entered if len(now.entered) > 1 else ():
            smaller = [c for c in bank if len(c.numbers) < len(one.candidate.numbers)]
            if len(one.candidate.numbers) < MANY or not smaller:
                continue
            few = self.entered(self.without(now, one), smaller)
            if few is not None and not clearly_worse(self.problem, few.final, now.final, self.rules.least):
                now = few
        return now

    def without_needless(self, now: Selection) -> Selection:
        """The selection without candidates that the others make needless."""
        while len(now.entered) > 1:
            rests = [self.without(now, one) for one in now.entered]
            falls = [fall_between(self.problem, rest.final, now.final) for rest in rests]
            least = min(range(len(rests)), key=lambda i: falls[i].gain)
            if enters(self.problem, self.rules, rests[least].final, falls[least]):
                return now
            now = rests[least]
        return now

    def without(self, now: Selection, one: Entered) -> Selection:
        """The selection without a candidate, all others fitted again."""
        return with_only(self.problem, now, [e for e in now.entered if e is not one], self.always)


class _Screen(NamedTuple):
    """A linearisation of all numbers, those that are in every fit, and the column (`_column`) of each number."""

    quadratic: Quadratic
    held: tuple[Number, ...]
    columns: list[Column]

    def places(self, numbers: Sequence[Number]) -> list[int]:
        """Places of numbers among the columns."""
        return [self.columns.index(_column(n)) for n in numbers]


def _parts(bank: Sequence[Candidate]) -> Iterator[Sequence[Candidate]]:
    """The bank in parts of about COLUMNS numbers: products of all columns with all others are not needed."""
    ends = np.cumsum([len(c.numbers) for c in bank]) // COLUMNS
    for part in np.unique(ends):
        yield [c for c, end in zip(bank, ends, strict=True) if end == part]


def _order(trial: Trial) -> tuple[int, int, bool, float]:
    """What is preferred among trials that predict as well."""
    one = trial.candidate
    return _place(one), len(one.numbers), one.extends or at_bound(trial.fitted, one), -trial.fall.gain


def _place(candidate: Candidate) -> int:
    """The place of a candidate's rank: one of the first rank with many numbers, as a flow of its own in each record,
    stands beside those of the next."""
    return candidate.rank or int(len(candidate.numbers) > MANY)


def at_bound(fitted: Fitted, candidate: Candidate) -> bool:
    """Whether some number of a candidate ended at a bound: it would go on to what cannot be."""
    values = ((fitted.value(n.name), n) for n in candidate.numbers)
    return any(x - n.low < AT_BOUND * n.sd or n.high - x < AT_BOUND * n.sd for x, n in values)


def _column(number: Number) -> Column:
    return number.name, number.trial


def _way(candidate: Candidate) -> tuple[str, str | tuple[str, ...]]:
    return candidate.id, candidate.kind or candidate.names


def has_entered(candidate: Candidate, entered: Sequence[Candidate]) -> bool:
    """Whether a candidate has entered already, by itself or as a part of another one."""
    return any(c.id in (candidate.id, candidate.of) for c in entered)


def _reached(number: Number) -> Number:
    """A number that is linearised by a secant, no further than this reaches."""
    if number.trial is None:
        return number
    ends = sorted((0.0, IN_BOUNDS * number.trial))
    return replace(number, low=max(number.low, ends[0]), high=min(number.high, ends[1]))
